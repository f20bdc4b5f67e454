// Random programs in the dialects of controls, on random machines, through the whole way: rewritten, then
// found to be the same program by the independent reader. Without errors of the machine no byte changes.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>
#include <string>

#include "abbe/core/units.h"
#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// What a control's programs look like.
struct Style {
  const char* dialect;
  bool percent, cycles, tool_table, after_codes, rotation;
  const char* further;  ///< code of a further work offset; empty: none
  char repeats;         ///< word that counts holes in G91; 0: not used
  double inches;        ///< chance of a program in inches
  bool increments;      ///< words without points
  bool names = false;   ///< words with names, D for the tool's offset, TRANS and ROT
};

/// A program as CAM systems post it for the control: absolute starts, three or four decimals.
class DialectWriter {
 public:
  DialectWriter(Random& random, const Style& style)
      : random_(random), style_(style), inch_(random.chance(style.inches)) {}

  std::string write(int blocks) {
    if (style_.names) return write_named(blocks);
    if (style_.percent) text_ = "%\nO0007(RANDOM)\n";
    text_ += inch_ ? "G20 G90 G17 G40 G80\n" : "G21 G90 G17 G40\n";
    if (*style_.further != 0 && random_.chance(0.5))
      text_ += fmt::format("{} P2\n", style_.further);
    else
      text_ += "G54\n";
    if (style_.tool_table) text_ += "T1 M6\n";
    text_ += fmt::format("G0 {} {}\n", word('X', 0), word('Y', 0));
    text_ += fmt::format("{} {} S1000 M3\nG94 F{}\n", style_.tool_table ? "G43 H1" : "", word('Z', 20),
                         inch_ ? "20." : "500.");
    at_ = Vec3(0, 0, 20);
    for (int i = 0; i < blocks; ++i) block();
    mode(false);
    text_ += style_.tool_table ? "M5\nG0 G91 G28 Z0\nM30\n" : "M5\nG53 G0 Z0\nM30\n";
    if (style_.percent) text_ += "%\n";
    return text_;
  }

 private:
  std::string write_named(int blocks) {
    text_ = fmt::format("%_N_RANDOM_MPF\nG17 {} G90 G94 G40 ; random\nT=\"MILL 10\"\nM6\n{} D1\n",
                        inch_ ? "G700" : "G710", random_.chance(0.5) ? "G54" : "G505");
    text_ += fmt::format("G0 {} {}\nZ={} S1=1000 M1=3\nF{}\n", word('X', 0), word('Y', 0), number(20),
                         inch_ ? "20." : "500.");
    at_ = Vec3(0, 0, 20);
    for (int i = 0; i < blocks; ++i) block();
    mode(false);
    return text_ + "M5\nSUPA G0 Z0 D0\nM30\n";
  }
  [[nodiscard]] double unit() const { return inch_ ? 25.4 : 1.0; }
  [[nodiscard]] int decimals() const { return inch_ ? 4 : 3; }
  [[nodiscard]] double round(double v) const {
    const double scale = std::pow(10.0, decimals());
    return std::round(v / unit() * scale) / scale * unit();
  }
  [[nodiscard]] std::string number(double mm) const {
    if (style_.increments) return fmt::format("{:.0f}", std::round(mm / unit() * std::pow(10.0, decimals())));
    return fmt::format("{:.{}f}", mm / unit(), decimals());
  }
  [[nodiscard]] std::string word(char letter, double mm) const { return letter + number(mm); }
  [[nodiscard]] std::string axis_word(int k, double target) const {
    return word("XYZ"[k], incremental_ ? target - at_[k] : target);
  }

  void mode(bool incremental) {
    if (incremental != incremental_) text_ += incremental ? "G91\n" : "G90\n";
    incremental_ = incremental;
  }
  Vec3 target(double reach) {
    Vec3 p;
    for (int k = 0; k < 3; ++k)
      p[k] = round(std::clamp(at_[k] + random_.between(-reach, reach), k == 2 ? -40.0 : -250.0,
                              k == 2 ? 100.0 : 250.0));
    return p;
  }
  void block() {
    switch (random_.below(12)) {
      case 0:
        mode(!incremental_);
        break;
      case 1:
        text_ += random_.chance(0.5) ? "M8\n" : style_.names ? "N5 MSG(\"a;b\") ; comment\n" : "(COMMENT)\n";
        break;
      case 2:
        line("G0", 200);
        break;
      case 3:
      case 4:
      case 5:
        line("G1", random_.chance(0.4) ? 250 : 20);
        break;
      case 6:
      case 7:
      case 8:
        arc();
        break;
      case 9:
        if (style_.cycles && !inch_) cycle();
        break;
      case 10:
        if (style_.rotation) rotation();
        break;
      default:
        text_ += fmt::format("N{} G4 {}\n", random_.below(1000), style_.names ? "F0.5" : "P100");
        break;
    }
  }
  void line(const char* code, double reach) {
    const Vec3 p = target(reach);
    std::string words;
    for (int k = 0; k < 3; ++k) {
      if (!random_.chance(0.7)) continue;
      words += ' ' + axis_word(k, p[k]);
      at_[k] = p[k];
    }
    if (words.empty()) return;
    const char* after =
        style_.after_codes && random_.chance(0.2) ? (random_.chance(0.5) ? " M9" : " G9 M9") : "";
    text_ +=
        fmt::format("{}{}{}{}\n", style_.after_codes && random_.chance(0.1) ? "/3" : "", code, words, after);
  }
  void arc() {
    static constexpr int kAxes[3][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
    const int plane = style_.names ? 0 : random_.below(3), a = kAxes[plane][0], b = kAxes[plane][1],
              n = kAxes[plane][2];
    const double r = random_.between(3, plane == 0 ? 80 : 20), t0 = random_.between(0, 6.28);
    const double i = round(-r * std::cos(t0)), j = round(-r * std::sin(t0));
    const bool clockwise = random_.chance(0.5), full = random_.chance(0.3);
    const double sweep = random_.between(0.4, 5.5), radius = std::hypot(i, j);
    const double t1 = std::atan2(-j, -i) + (clockwise ? -sweep : sweep);
    Vec3 end = at_;
    if (!full) {
      end[a] = round(at_[a] + i + radius * std::cos(t1));
      end[b] = round(at_[b] + j + radius * std::sin(t1));
    }
    if (random_.chance(0.3)) end[n] = round(at_[n] + random_.between(-3, 3));
    if (end.head<2>().cwiseAbs().maxCoeff() > 300 || end.z() < -60 || end.z() > 120) return;
    text_ += fmt::format("G{} G{}", 17 + plane, clockwise ? 2 : 3);
    for (int k = 0; k < 3; ++k)
      if (end[k] != at_[k]) text_ += ' ' + axis_word(k, end[k]);
    if (style_.names && !full && random_.chance(0.3)) {
      text_ += fmt::format(" CR={}\nG17\n", number(sweep > std::numbers::pi ? -radius : radius));
    } else {
      text_ += fmt::format(" {} {}\nG17\n", word("IJK"[a], i), word("IJK"[b], j));
    }
    at_ = end;
  }
  void cycle() {
    mode(false);
    if (style_.names) return brackets();
    const double r = round(at_.z() - random_.between(0, 3)), z = round(r - 4);
    const char* const cycles[] = {"G81", "G82 P100", "G85", "G73 Q2.", "G83 Q2."};
    const char* code = cycles[random_.below(5)];
    text_ += fmt::format("G9{} {} {} {} {} {}\n", 8 + random_.below(2), code, word('X', at_.x()),
                         word('Y', at_.y()), word('R', r), word('Z', z));
    at_.x() = round(at_.x() + 3);
    text_ += fmt::format("{}\n", word('X', at_.x()));
    if (style_.repeats != 0 && random_.chance(0.3)) {
      text_ += fmt::format("G91 {} {}3\nG90\n", word('X', 0.5 * unit()), style_.repeats);
      at_.x() += 1.5 * unit();
    }
    text_ += fmt::format("G80\nG98\nG0 {}\n", word('Z', at_.z()));
  }
  /// Holes of a control with names: one where the tool stands, two or three behind a modal call.
  void brackets() {
    const double top = round(at_.z() - random_.between(0, 3)), deep = random_.between(2, 8);
    const char* const cycles[] = {"CYCLE81({},{},1,{}{})", "CYCLE82({},{},1,{},{},0.1)",
                                  "CYCLE83({},{},1,{},{},,1,0,,,1,1)", "CYCLE85({},{},1,{},{},0,200,400)"};
    const std::string clear = number(at_.z() + 1), surface = number(top), depth = number(top - deep);
    const std::string call = fmt::format(fmt::runtime(cycles[random_.below(4)]), clear, surface, depth, "");
    text_ += "G0\n";
    if (random_.chance(0.4)) text_ += call + "\n";
    text_ += fmt::format("MCALL {}\n", call);
    for (int i = 0; i < 2 + random_.below(2); ++i) {
      at_.x() = round(std::clamp(at_.x() + random_.between(-80, 80), -250.0, 250.0));
      text_ += word('X', at_.x()) + "\n";
    }
    text_ += fmt::format("MCALL\nG0 {}\n", word('Z', at_.z()));
  }
  void rotation() {
    mode(false);
    if (style_.names) {
      text_ += fmt::format("TRANS {} Y={}\nG1 {}\nAROT {}=30\n", word('X', 10), number(5), word('X', 20),
                           random_.chance(0.5) ? "RPL" : "Z");
      text_ += fmt::format("G0 {} {}\nG1 {} {}\nG2 {} {}\nROT\n", word('X', 20), word('Y', 0), word('X', 60),
                           word('Y', 30), word('X', 80), word('I', 10));
      text_ += fmt::format("G0 {} {}\n", word('X', at_.x()), word('Y', at_.y()));
      return;
    }
    // turned about (10, 5); what is cut then stands somewhere, and the program goes back to a known place
    text_ += fmt::format("G68 {} {} R{}\n", word('X', 10 * unit() / 25.4), word('Y', 5 * unit() / 25.4),
                         style_.increments ? "30000" : "30.");
    text_ += fmt::format("G0 {} {}\nG1 {} {}\nG2 {} {}\nG69\n", word('X', 20), word('Y', 0), word('X', 60),
                         word('Y', 30), word('X', 80), word('I', 10));
    text_ += fmt::format("G0 {} {}\n", word('X', at_.x()), word('Y', at_.y()));
  }

  Random& random_;
  const Style& style_;
  bool inch_;
  std::string text_;
  Vec3 at_ = Vec3::Zero();
  bool incremental_ = false;
};

ProgramRun run(const Style& style, const std::string& machine, const std::string& program) {
  ProgramJob job = plain_program_job();
  Profile profile = *embedded_profile(style.dialect);
  if (style.increments) profile.numbers.integer_words = Profile::IntegerWords::increments;
  job.setup.profile = std::make_shared<const Profile>(std::move(profile));
  job.setup.further_offsets[style.names ? 5 : 2] = WorkOffset{{-40, 25, 5}, 0};
  job.setup.tools[1] = ToolEntry{1, 1, {0, 0, 80}, 80.0, 10, "name=\"MILL 10\""};
  job.setup.block_delete = ControlSetup::BlockDelete::off;
  return run_program(plan_of(machine), program, job);
}

class RandomDialects : public ::testing::TestWithParam<Style> {};

TEST_P(RandomDialects, AreVerifiedOnRandomMachines) {
  const Style& style = GetParam();
  std::uint64_t done = 0;
  const testing::Seeds seeds = testing::random_seeds(60);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.7);
    const std::string program = DialectWriter(random, style).write(25);
    const ProgramRun result = run(style, machine, program);
    if (result.outcome.end == ProgramEnd::refused) {
      // a cycle whose correction bends inside it; what follows is judged from where it would have ended
      const bool bends = std::any_of(result.outcome.diagnostics.begin(), result.outcome.diagnostics.end(),
                                     [](const Diagnostic& d) { return d.code == "E-CYCLE"; });
      EXPECT_TRUE(bends) << "seed " << seed << "\n" << findings(result.outcome) << program;
      continue;
    }
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    ++done;
  }
  EXPECT_GT(done, seeds.count / 3);
}

TEST_P(RandomDialects, ZeroErrorsChangeNoByte) {
  const Style& style = GetParam();
  for (std::uint64_t seed = 1; seed <= 30; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = DialectWriter(random, style).write(30);
    const ProgramRun result = run(style, machine, program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program;
    ASSERT_EQ(result.output, program) << "seed " << seed;
  }
}

INSTANTIATE_TEST_SUITE_P(
    Controls, RandomDialects,
    ::testing::Values(Style{"fanuc", true, true, true, true, true, "G54.1", 'K', 0.3, false},
                      Style{"fanuc", true, true, true, true, true, "G54.1", 'K', 0.0, true},
                      Style{"haas", true, true, true, true, true, "G154", 'L', 0.3, false},
                      Style{"grbl", false, false, false, false, false, "", 0, 0.3, false},
                      Style{"siemens", false, true, true, true, true, "", 0, 0.3, false, true},
                      Style{"grblhal", false, true, false, false, false, "", 0, 0.0, false}),
    [](const auto& test) {
      return std::string(test.param.dialect) + (test.param.increments ? "_increments" : "");
    });

/// A table that turns about `tilt` and C.
std::string tilting_table(char tilt) {
  return fmt::format(R"(format = 1
[machine]
chain = "w C {0} b Y X Z t"
[axis.{0}]
direction = [{1}, {2}, 0]
origin = [0, 5, -100]
errors_seen = "body"
[axis.C]
direction = [0, 0, 1]
errors_seen = "body"
[tool]
length = 80
[control]
mode = "axis"
[errors]
EXX = {{ poly = [0, 0.5] }}
EC0{0} = 25
EZ0{0} = -90
EX0C = 140
EAC = {{ sine = [12, 0.0174533, 1.0] }}
EBC = {{ sine = [15, 0.0174533, 0.4] }}
)",
                     tilt, tilt == 'A' ? 1 : 0, tilt == 'B' ? 1 : 0);
}

std::string findings_of_pair(const ProgramJob& job, const std::string& machine, const std::string& original,
                             const std::string& output) {
  const TestFile a(original), b(output);
  ProgramJob both = job;
  both.program = a.path();
  return findings(verify_programs(plan_of(machine), both, b.path()));
}

// A30000 is 30 degrees where an increment is 0.001 degree, as X30000 is 30 mm. The rewriter must write for
// the integers what it writes for points; the verifier, given one text as the original and the other's
// result, must agree.
TEST(IntegerWords, OfRotaryAxesCountThousandthsOfADegree) {
  for (const char tilt : {'A', 'B'}) {
    const std::string machine = tilting_table(tilt);
    const auto program = [&](const char* text) { return fmt::format(fmt::runtime(text), tilt); };
    const std::string points = program(
                          "G21 G90 G94 G17 G54\nG0 X10. Y20. Z50. {0}1. C1.\nG0 X11. Y21. Z51. {0}30. C-45.\n"
                          "G93 G1 X30. Y22. Z52. {0}31. C10. F2.\nM30\n"),
                      integers = program(
                          "G21 G90 G94 G17 G54\nG0 X10000 Y20000 Z50000 {0}1000 C1000\nG0 X11000 Y21000 "
                          "Z51000 {0}30000 C-45000\n"
                          "G93 G1 X30000 Y22000 Z52000 {0}31000 C10000 F2.\nM30\n");
    ProgramJob job = plain_program_job();
    Profile profile = *embedded_profile("fanuc");
    profile.numbers.integer_words = Profile::IntegerWords::increments;
    job.setup.profile = std::make_shared<const Profile>(std::move(profile));
    const ProgramRun a = run_program(plan_of(machine), points, job),
                     b = run_program(plan_of(machine), integers, job);
    ASSERT_EQ(a.outcome.end, ProgramEnd::done) << findings(a.outcome);
    ASSERT_EQ(b.outcome.end, ProgramEnd::done) << findings(b.outcome);
    EXPECT_GT(a.outcome.verify.before.max, 0.02) << "an error that the unit of an angle changes";
    EXPECT_DOUBLE_EQ(a.outcome.verify.before.max, b.outcome.verify.before.max);
    EXPECT_EQ(a.output.substr(a.output.find("\nG93")), b.output.substr(b.output.find("\nG93"))) << b.output;
    for (const auto& [original, output] : {std::pair{points, b.output}, {integers, a.output}})
      EXPECT_EQ(findings_of_pair(job, machine, original, output), "");
    std::string wrong = a.output;
    wrong.replace(wrong.find("C-4"), 3, "C-5");
    EXPECT_NE(findings_of_pair(job, machine, integers, wrong), "");
  }
}

}  // namespace
}  // namespace abbe
