// `abbe ballbar`: the members of its JSON, both outputs, wrong input.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

/// Both directions, R 100 mm, centre (3, -2) um, lost motion of X 4 um.
std::string trace() {
  std::string text =
      "# plane: XY\n# radius_mm: 100\n# feed_mm_per_min: 1200\nrun,direction,angle_deg,deviation_um\n";
  for (const int s : {+1, -1}) {
    for (int i = 0; i < 180; ++i) {
      const double degrees = s * (2 * i + 1), t = degrees * 3.14159265358979323846 / 180;
      const double sense = -s * std::sin(t) > 0 ? 1 : -1;
      const double d = 3 * std::cos(t) - 2 * std::sin(t) - 2 * sense * std::cos(t);
      text += (s > 0 ? "1,CCW," : "2,CW,") + std::to_string(degrees) + "," + std::to_string(d) + "\n";
    }
  }
  return text;
}

class Ballbar : public ::testing::Test {
 protected:
  ProgramRun ballbar(std::vector<std::string> options) {
    options.insert(options.begin(), "ballbar");
    return run_abbe(options, {}, folder_.path());
  }
  static std::string content(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
  }

  Folder folder_;
  std::string trace_ = folder_.put("trace.csv", trace());
};

TEST_F(Ballbar, JsonHasFiguresAndCauses) {
  const ProgramRun run = ballbar({trace_, "--json"});
  ASSERT_EQ(run.exit, 0) << run.err;
  const json test = json::parse(run.out)["tests"][0];
  EXPECT_EQ(test["plane"], "XY");
  EXPECT_NEAR(test["figures"]["directions"][0]["G_least_squares"]["centre_um"][1], -2, 1e-3);
  EXPECT_EQ(test["figures"]["directions"][1]["direction"], "CW");
  bool found = false;
  for (const json& cause : test["diagnosis"]["causes"]) {
    if (cause["cause"] != "backlash" || cause["axis"] != "X") continue;
    found = true;
    EXPECT_NEAR(cause["value"], 4e-3, 1e-6);
    EXPECT_TRUE(cause["separable"]);
  }
  EXPECT_TRUE(found);
}

TEST_F(Ballbar, TextPictureAndNeutralFile) {
  const std::string svg = folder_ / "out.svg", csv = folder_ / "out.csv";
  const ProgramRun run = ballbar({trace_, "--svg", svg, "--out", csv});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("backlash X                    4.00 "));
  EXPECT_THAT(content(svg), HasSubstr("</svg>"));
  EXPECT_EQ(ballbar({csv}).exit, 0);
}

TEST_F(Ballbar, WrongInputIsNamed) {
  const auto refused = [&](const std::vector<std::string>& options, const char* message) {
    const ProgramRun run = ballbar(options);
    EXPECT_EQ(run.exit, 2) << message;
    EXPECT_THAT(run.err, HasSubstr(message));
  };
  refused({folder_ / "absent.csv"}, "E-FILE");
  refused({folder_.put("a.csv", "angle_deg,deviation_um\n")}, "does not say the plane");
  refused({trace_, "--plane", "XX"}, "two different letters");
  refused({trace_, "--pitch", "X=-1"}, "--pitch");
  refused({trace_, "--radius", "nan"}, "--radius");
  refused({trace_, "--svg", trace_}, "is an input");
  refused({trace_, "--svg", "a", "--out", "a"}, "the same file as --svg");
  refused({trace_, trace_, "--out", "a"}, "one file shows one test");
  refused({folder_.put("a.b5r", "<a/>")}, "E-B5R");
  refused({folder_.put("b.csv", "angle_deg,deviation_um\n1,nan\n")}, "E-CELL");
}

}  // namespace
}  // namespace abbe::cli
