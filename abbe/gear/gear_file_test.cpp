#include "abbe/gear/gear_file.h"

#include <gtest/gtest.h>

#include <random>

namespace abbe {
namespace {

const std::string kGear = "module = 12\nteeth = 94\nface_width = 100\n";
const std::string kWheel = "[wheel]\ndiameter = 300\n";

std::string text_of(const std::string& gear, const std::string& more = kWheel) {
  return "format = 1\n[gear]\n" + gear + more;
}

std::string code_of(const std::string& text) {
  const Parsed<GearJob> parsed = read_gear({"gear.toml", text});
  EXPECT_NE(parsed.value.has_value(), has_errors(parsed.diagnostics));
  for (const Diagnostic& diagnostic : parsed.diagnostics)
    if (diagnostic.severity == Severity::error) return diagnostic.code;
  return "";
}

TEST(ReadGear, UnitsAndDefaults) {
  const Parsed<GearJob> parsed = read_gear(
      {"gear.toml",
       text_of(
           "name = \"pinion\"\nmodule = 4\nteeth = 41\nhelix_angle = 15\nhand = \"left\"\nface_width = 60\n",
           "[modifications]\ntip_relief = 20\ntip_relief_length = 3\n[wheel]\ndiameter = 300\nswivel = -15\n"
           "[cutting]\nfeed = 120\nmiddle = 80\nfirst_gap = 90\n[evaluation]\nclass = 5\nteeth = [1, "
           "25]\n")});
  ASSERT_TRUE(parsed.value) << to_text(parsed.diagnostics.front());
  const GearJob& job = *parsed.value;
  EXPECT_EQ(job.gear.spec.name, "pinion");
  EXPECT_EQ(job.gear.spec.hand, -1);
  EXPECT_NEAR(job.gear.spec.helix_angle, 15 * deg, 1e-15);
  EXPECT_LT(job.gear.turn_per_mm, 0);
  EXPECT_NEAR(job.gear.spec.tip_relief, 0.02, 1e-15);
  EXPECT_NEAR(*job.wheel.swivel, -15 * deg, 1e-15);
  EXPECT_NEAR(job.cutting.feed, 2, 1e-15);
  EXPECT_NEAR(job.cutting.first_gap, 90 * deg, 1e-15);
  EXPECT_EQ(job.cutting.middle, 80);
  EXPECT_EQ(job.tolerance_class, 5);
  EXPECT_EQ(job.teeth, (std::vector<int>{1, 25}));
}

TEST(ReadGear, EveryMistakeHasItsName) {
  EXPECT_EQ(code_of(text_of(kGear)), "");
  EXPECT_EQ(code_of("[gear]\n" + kGear + kWheel), "E-FORMAT");
  EXPECT_EQ(code_of(text_of(kGear, "")), "E-MISSING-KEY");
  EXPECT_EQ(code_of(text_of("module = 12\nface_width = 9\n")), "E-MISSING-KEY");
  EXPECT_EQ(code_of(text_of(kGear + "helix_angle = 10\n")), "E-MISSING-KEY");  // which hand?
  EXPECT_EQ(code_of(text_of(kGear + "modul = 3\n")), "E-UNKNOWN-KEY");
  EXPECT_EQ(code_of(text_of(kGear + "hand = \"up\"\n")), "E-VALUE");
  EXPECT_EQ(code_of(text_of("module = 12\nteeth = 9.5\nface_width = 100\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of("module = -1\nteeth = 94\nface_width = 100\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of("module = nan\nteeth = 94\nface_width = 100\n")), "E-NOT-FINITE");
  EXPECT_EQ(code_of(text_of("module = 12\nteeth = 12\nface_width = 100\n")), "E-GEAR-UNDERCUT");
  EXPECT_EQ(code_of(text_of("module = 12\nteeth = 8\nprofile_shift = 0.8\nface_width = 100\n")),
            "E-GEAR-POINTED");
  EXPECT_EQ(code_of(text_of(kGear + "tip_diameter = 1000\n")), "E-GEAR-ORDER");
  EXPECT_EQ(code_of(text_of(kGear + "profile_shift = 2.5\nform_diameter = 1062\nroot_diameter = 1060\n"
                                    "tip_diameter = 1152\n")),
            "E-GEAR-GAP");
  EXPECT_EQ(code_of(text_of(kGear, "[wheel]\ndiameter = 30\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of(kGear, "[wheel]\ndiameter = 300\ntip_width = 15\n")), "E-GEAR-WHEEL");
  EXPECT_EQ(code_of(text_of(kGear + "helix_angle = 30\nhand = \"right\"\n",
                            "[wheel]\ndiameter = 300\nswivel = 0\n")),
            "E-GEAR-MESH");
  EXPECT_EQ(code_of(text_of(kGear, kWheel + "[evaluation]\nteeth = [95]\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of(kGear, kWheel + "[evaluation]\nclass = 12\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of(kGear, kWheel + "[modifications]\ntip_relief = 10\n")), "E-GEAR-VALUE");
  EXPECT_EQ(code_of(text_of(kGear, kWheel + "[cutting]\nfeed = 0\n")), "E-GEAR-VALUE");
}

TEST(ReadGear, TheMistakeIsShownWhereItIs) {
  const Parsed<GearJob> parsed =
      read_gear({"gear.toml", text_of(kGear, "[wheel]\ndiameter = 300\ntip_width = 15\n")});
  ASSERT_EQ(parsed.diagnostics.size(), 1U);
  EXPECT_EQ(parsed.diagnostics[0].place.line, 8U);
  EXPECT_FALSE(parsed.diagnostics[0].fix.empty());
}

TEST(ReadGear, TotalOnAnyBytes) {
  std::mt19937 random(20261122);
  const std::string seed =
      text_of(kGear + "helix_angle = 12\nhand = \"left\"\nprofile_shift = 0.3\naddendum = 0.9\n",
              kWheel +
                  "[modifications]\ntip_relief = 12\ntip_relief_length = 9\n"
                  "[cutting]\nfeed = 100\n[evaluation]\nclass = 6\nteeth = [1, 48]\n");
  for (int round = 0; round < 3000; ++round) {
    std::string text = seed;
    for (int k = 0; k < 1 + round % 4; ++k) {
      const std::size_t at = random() % text.size();
      switch (random() % 3) {
        case 0:
          text[at] = static_cast<char>(random());
          break;
        case 1:
          text.erase(at, random() % 12);
          break;
        default:
          text.insert(at, text.substr(random() % text.size(), random() % 20));
          break;
      }
      if (text.empty()) break;
    }
    const Parsed<GearJob> parsed = read_gear({"gear.toml", text});
    EXPECT_NE(parsed.value.has_value(), has_errors(parsed.diagnostics)) << text;
  }
}

}  // namespace
}  // namespace abbe
