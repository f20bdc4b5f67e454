// Profiles as data: what the embedded ones say, how one extends another, and that every mistake has its place.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <string>

#include "abbe/machine/read_profile.h"

namespace abbe {
namespace {

using ::testing::HasSubstr;

const CodeUse& use_of(const Profile& profile, const char* name) {
  const CodeName code = read_code_name(name);
  EXPECT_NE(code.kind, 0) << name;
  return code.kind == 'G' ? profile.g[code.index] : profile.m[code.index];
}

TEST(Profiles, EveryEmbeddedProfileIsReadWithoutAFinding) {
  ASSERT_GE(embedded_profiles().size(), 6U);
  for (const EmbeddedProfile& embedded : embedded_profiles()) {
    const auto parsed = read_profile(std::string(embedded.name) + ".toml", embedded.text);
    for (const auto& finding : parsed.diagnostics) ADD_FAILURE() << to_text(finding);
    ASSERT_TRUE(parsed.value) << embedded.name;
    EXPECT_EQ(parsed.value->name, embedded.name);
    EXPECT_FALSE(parsed.value->sources.empty());
    EXPECT_EQ(use_of(*parsed.value, "G1").meaning, Meaning::line);
    EXPECT_EQ(use_of(*parsed.value, "G41").meaning, Meaning::unknown);
    EXPECT_EQ(use_of(*parsed.value, "G17").meaning, Meaning::plane_xy);
  }
}

TEST(Profiles, TheLinuxCncProfileSaysWhatTheReadersOnceHadInCode) {
  const auto profile = embedded_profile("linuxcnc");
  ASSERT_NE(profile, nullptr);
  EXPECT_EQ(profile->title, "LinuxCNC");
  EXPECT_EQ(use_of(*profile, "G59.3").number, 9);
  EXPECT_EQ(use_of(*profile, "G64").words, letter_set("PQ"));
  EXPECT_EQ(use_of(*profile, "G81").words, letter_set("XYZRL"));
  EXPECT_TRUE(use_of(*profile, "M30").after);
  EXPECT_FALSE(use_of(*profile, "M5").after);
  EXPECT_EQ(use_of(*profile, "M98").meaning, Meaning::unknown);
  EXPECT_NE(use_of(*profile, "M98").refusal, 0);
  EXPECT_EQ(profile->numbers.decimals_mm, 4);
}

TEST(Profiles, AControlThatExtendsAnotherChangesWhatItNames) {
  const auto haas = embedded_profile("haas");
  ASSERT_NE(haas, nullptr);
  EXPECT_EQ(use_of(*haas, "G154").meaning, Meaning::numbered_work_offset);
  EXPECT_EQ(use_of(*haas, "G54.1").meaning, Meaning::unknown);
  EXPECT_EQ(use_of(*haas, "G129").number, 29);
  EXPECT_EQ(use_of(*haas, "G81").words, letter_set("XYZRL"));
  EXPECT_EQ(use_of(*embedded_profile("fanuc"), "G81").words, letter_set("XYZRK"));
  EXPECT_TRUE(use_of(*haas, "M5").after);
  EXPECT_TRUE(use_of(*haas, "M89").after);
}

TEST(Profiles, AUsersFileAddsCodesWithoutCompiling) {
  const auto parsed = read_profile("shop/vmc.toml", R"(format = 1
extends = "fanuc"
[numbers]
integer_words = "increments"
decimals = { mm = 4 }
[codes]
M251 = "auxiliary"
"G5.1" = "unknown"
[[refused]]
codes = ["M77"]
why = "it moves the pallet"
fix = "leave it out"
)");
  for (const auto& finding : parsed.diagnostics) ADD_FAILURE() << to_text(finding);
  ASSERT_TRUE(parsed.value);
  EXPECT_EQ(parsed.value->name, "vmc");
  EXPECT_EQ(parsed.value->title, "Fanuc");
  EXPECT_EQ(parsed.value->numbers.integer_words, Profile::IntegerWords::increments);
  EXPECT_EQ(parsed.value->numbers.decimals_mm, 4);
  EXPECT_EQ(parsed.value->numbers.decimals_inch, 4) << "of fanuc";
  EXPECT_EQ(use_of(*parsed.value, "M251").meaning, Meaning::auxiliary);
  EXPECT_EQ(use_of(*parsed.value, "G5.1").meaning, Meaning::unknown);
  EXPECT_EQ(parsed.value->refusals[use_of(*parsed.value, "M77").refusal - 1U].why, "it moves the pallet");
}

struct Mistake {
  const char* text;
  const char* place;  ///< "line:column: error[CODE]"
  const char* message;
};

class ProfileMistakes : public ::testing::TestWithParam<Mistake> {};

TEST_P(ProfileMistakes, AreReportedWithTheirPlace) {
  const auto parsed = read_profile("p.toml", GetParam().text);
  EXPECT_FALSE(parsed.value);
  std::string all;
  for (const auto& finding : parsed.diagnostics) {
    all += to_text(finding);
    EXPECT_FALSE(finding.fix.empty()) << to_text(finding);
  }
  EXPECT_THAT(all, HasSubstr(std::string("p.toml:") + GetParam().place));
  EXPECT_THAT(all, HasSubstr(GetParam().message));
}

INSTANTIATE_TEST_SUITE_P(
    Texts, ProfileMistakes,
    ::testing::Values(
        Mistake{"format = 1\n", "1:1: error[E-MISSING-KEY]", "no [codes]"},
        Mistake{"extends = \"fanuc\"\n", "1:1: error[E-FORMAT]", "format"},
        Mistake{"format = 1\nextends = \"fanuk\"\n", "2:11: error[E-VALUE]", "did you mean 'fanuc'?"},
        Mistake{"format = 1\nextends = \"fanuc\"\ncolour = 1\n", "3:1: error[E-UNKNOWN-KEY]", "colour"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG200.55 = \"copy\"\n", "4:1: error[E-", ""},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nX5 = \"copy\"\n", "4:1: error[E-VALUE]", "no G or M code"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG5 = \"copi\"\n", "4:6: error[E-VALUE]", "did you mean 'copy'?"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nM5 = \"line\"\n", "4:6: error[E-VALUE]", "codes.M5"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG54 = \"work-offset\"\n", "4:7: error[E-MISSING-KEY]", "number"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG5 = { meaning = \"copy\", words = \"pq\" }\n", "4:34: error[E-VALUE]", "capital letters"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[numbers]\ndecimals = { mm = 3.5 }\n", "4:19: error[E-VALUE]", "decimals.mm"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[text]\nblock_bytes = 1000\n", "4:15: error[E-VALUE]", "block_bytes"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[arcs]\ntolerance_mm = nan\n", "4:16: error[E-NOT-FINITE]", "tolerance_mm"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[arcs]\ntolerance_mm = -1\n", "4:16: error[E-VALUE]", "not positive"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[[refused]]\ncodes = [\"G5\"]\nfix = \"x\"\n", "3:1: error[E-MISSING-KEY]", "no why"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[text\n", "3:", "E-TOML"}));

TEST(Profiles, AnyBytesGiveAProfileOrReasons) {
  const std::string base(embedded_profiles()[0].text);
  std::mt19937 random(20261122);
  for (int round = 0; round < 1500; ++round) {
    std::string text = base.substr(0, random() % base.size());
    for (int edit = 0; edit < 4 && !text.empty(); ++edit) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0) text[at] = static_cast<char>(random() % 256);
      else text.insert(at, std::string(base, random() % base.size(), random() % 40));
    }
    const auto parsed = read_profile("fuzz.toml", text);
    EXPECT_EQ(parsed.value.has_value(), !has_errors(parsed.diagnostics));
  }
}

}  // namespace
}  // namespace abbe
