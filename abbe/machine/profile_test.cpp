// Profiles as data: what the embedded ones say, how one extends another, and that every mistake has its
// place.

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
    EXPECT_EQ(use_of(*parsed.value, "G41.2").meaning, Meaning::unknown);
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
scale_words = "thousandths"
scale_axes = "plane"
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
  EXPECT_EQ(parsed.value->numbers.scale_words, Profile::Numbers::Scale::thousandths);
  EXPECT_EQ(parsed.value->numbers.scale_axes, Profile::Numbers::ScaleAxes::plane);
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
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nX5 = \"copy\"\n", "4:1: error[E-VALUE]",
                "no G or M code"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG5 = \"copi\"\n", "4:6: error[E-VALUE]",
                "did you mean 'copy'?"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nM5 = \"line\"\n", "4:6: error[E-VALUE]",
                "codes.M5"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG54 = \"work-offset\"\n",
                "4:7: error[E-MISSING-KEY]", "number"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[codes]\nG5 = { meaning = \"copy\", words = \"pq\" }\n",
                "4:34: error[E-VALUE]", "capital letters"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[numbers]\ndecimals = { mm = 3.5 }\n",
                "4:19: error[E-VALUE]", "decimals.mm"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[text]\nblock_bytes = 1000\n", "4:15: error[E-VALUE]",
                "block_bytes"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[arcs]\ntolerance_mm = nan\n", "4:16: error[E-NOT-FINITE]",
                "tolerance_mm"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[arcs]\ntolerance_mm = -1\n", "4:16: error[E-VALUE]",
                "not positive"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[[refused]]\ncodes = [\"G5\"]\nfix = \"x\"\n",
                "3:1: error[E-MISSING-KEY]", "no why"},
        Mistake{"format = 1\nextends = \"fanuc\"\n[text\n", "3:", "E-TOML"}));

TEST(Profiles, AnyBytesGiveAProfileOrReasons) {
  const std::string base(embedded_profiles()[0].text);
  std::mt19937 random(20261122);
  for (int round = 0; round < 1500; ++round) {
    std::string text = base.substr(0, random() % base.size());
    for (int edit = 0; edit < 4 && !text.empty(); ++edit) {
      const std::size_t at = random() % text.size();
      if (random() % 2 == 0)
        text[at] = static_cast<char>(random() % 256);
      else
        text.insert(at, std::string(base, random() % base.size(), random() % 40));
    }
    const auto parsed = read_profile("fuzz.toml", text);
    EXPECT_EQ(parsed.value.has_value(), !has_errors(parsed.diagnostics));
  }
}

TEST(Profiles, CodesMayBeWords) {
  const auto siemens = embedded_profile("siemens");
  ASSERT_NE(siemens, nullptr);
  const Profile::Keyword* supa = find_keyword(*siemens, "SUPA");
  ASSERT_NE(supa, nullptr);
  EXPECT_EQ(siemens->g[supa->index].meaning, Meaning::machine_coordinates);
  EXPECT_EQ(supa->form, Profile::Form::alone);
  EXPECT_EQ(g_name(*siemens, supa->index), "SUPA");
  EXPECT_EQ(g_name(*siemens, 591), "G59.1");
  EXPECT_EQ(find_keyword(*siemens, "MSG")->form, Profile::Form::arguments);
  EXPECT_EQ(find_keyword(*siemens, "SUP"), nullptr);
  EXPECT_EQ(find_address(*siemens, "CR"), 'R');
  EXPECT_EQ(find_address(*siemens, "C1"), '\0');
  EXPECT_EQ(find_address(*siemens, "A3"), kVectorLetters[0]);
  EXPECT_EQ(find_address(*siemens, "C3"), kVectorLetters[2]);
  EXPECT_EQ(siemens->g[5990].number, 9 + 99) << "G599";
  const auto own = read_profile("own.toml",
                                "format = 1\nextends = \"siemens\"\n[codes]\nMSG = \"copy\"\nCUSTOM = { "
                                "meaning = \"copy\", form = \"value\" }\n[addresses]\nS2 = \"S\"\n");
  ASSERT_TRUE(own.value);
  EXPECT_EQ(find_keyword(*own.value, "MSG")->form, Profile::Form::alone);
  EXPECT_EQ(find_keyword(*own.value, "CUSTOM")->form, Profile::Form::value);
  EXPECT_EQ(find_address(*own.value, "S2"), 'S');
}

TEST(Profiles, MistakesInNamesHaveTheirPlace) {
  const auto code_of = [](const std::string& text) {
    const auto parsed = read_profile("own.toml", "format = 1\nextends = \"siemens\"\n" + text);
    return parsed.diagnostics.empty() ? std::string() : parsed.diagnostics.front().code;
  };
  EXPECT_EQ(code_of("[codes]\nsupa = \"copy\"\n"), "E-VALUE");
  EXPECT_EQ(code_of("[codes]\nG0 = { meaning = \"rapid\", form = \"value\" }\n"), "E-VALUE");
  EXPECT_EQ(code_of("[codes]\nXY = { meaning = \"copy\", form = \"odd\" }\n"), "E-VALUE");
  EXPECT_EQ(code_of("[addresses]\nX1 = \"X\"\n"), "E-VALUE") << "axes are spelled by their letters";
  EXPECT_EQ(code_of("[addresses]\nq = \"R\"\n"), "E-VALUE");
  const auto plain = read_profile("own.toml", "format = 1\nextends = \"fanuc\"\n[codes]\nSUPA = \"copy\"\n");
  EXPECT_FALSE(plain.value) << "a control without names";
}

}  // namespace
}  // namespace abbe
