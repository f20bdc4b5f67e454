// Random conversational programs on random machines, through the whole way: rewritten, then found to be the
// same program by the independent reader. Without errors no byte changes; the negative map brings the numbers
// back.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// A program as CAM systems post it for the control, or as people write it.
class KlartextWriter {
 public:
  explicit KlartextWriter(Random& random)
      : random_(random),
        inch_(random.chance(0.2)),
        comma_(random.chance(0.3)),
        numbered_(random.chance(0.8)) {}

  std::string write(int blocks) {
    const char* unit = inch_ ? "INCH" : "MM";
    add(fmt::format("BEGIN PGM RANDOM {}", unit));
    add("BLK FORM 0.1 Z X-100 Y-100 Z-20");
    add(random_.chance(0.5) ? "TOOL CALL 1 Z S3000" : "TOOL CALL \"MILL 10\" Z S3000 DL+0");
    if (random_.chance(0.3)) preset();
    add(fmt::format("L {} {} R0 FMAX M3", word(0, 0), word(1, 0)));
    add(fmt::format("L {} FMAX", word(2, 20)));
    add("L F500 M8");
    at_ = Vec3(0, 0, 20);
    for (int i = 0; i < blocks; ++i) block();
    add("L Z-1 R0 FMAX M91");
    add("M30");
    add("LBL 1");
    add(fmt::format("END PGM RANDOM {}", unit));
    return text_;
  }

 private:
  void add(const std::string& words) {
    if (numbered_) text_ += fmt::format("{} ", count_++);
    text_ += words + "\n";
  }
  void preset() {
    add("CYCL DEF 247 PRESET ~");
    text_ += "  Q339=+5 ;ROW\n";
    if (!random_.chance(0.5)) return;
    add("CYCL DEF 7.0 NULLPUNKT");
    add(fmt::format("CYCL DEF 7.1 {}", word(0, 10)));
    add(fmt::format("CYCL DEF 7.2 {}", word(2, -5)));
  }
  [[nodiscard]] double unit() const { return inch_ ? abbe::inch : 1.0; }
  [[nodiscard]] double round(double mm) const { return rounded(mm / unit(), decimals()) * unit(); }
  [[nodiscard]] int decimals() const { return inch_ ? 4 : 3; }
  [[nodiscard]] std::string number(double mm) const {
    std::string text = fmt::format("{:+.{}f}", rounded(mm / unit(), decimals()), decimals());
    if (comma_) std::replace(text.begin(), text.end(), '.', ',');
    return text;
  }
  [[nodiscard]] std::string word(int axis, double mm) const { return "XYZ"[axis] + number(mm); }
  /// A place, or the way to it.
  [[nodiscard]] std::string target_word(int axis, double to) {
    return random_.chance(0.2) ? "I" + word(axis, to - at_[axis]) : word(axis, to);
  }
  void block() {
    switch (random_.below(10)) {
      case 0:
        return add(random_.chance(0.5) ? "; COMMENT" : "* - HEADING");
      case 1:
        return line(" FMAX", 200);
      case 2:
      case 3:
      case 4:
        return line(random_.chance(0.2)   ? " F AUTO M9"
                    : random_.chance(0.2) ? " R0 F800"
                                          : "",
                    random_.chance(0.4) ? 250 : 20);
      case 5:
        return add("L M8");
      case 6:
        return holes();
      default:
        return arc();
    }
  }
  void line(const char* after, double reach) {
    std::string words = "L";
    for (int k = 0; k < 3; ++k) {
      if (!random_.chance(0.7)) continue;
      const double to = round(std::clamp(at_[k] + random_.between(-reach, reach), k == 2 ? -40.0 : -250.0,
                                         k == 2 ? 100.0 : 250.0));
      words += ' ' + target_word(k, to);
      at_[k] = to;
    }
    if (words.size() > 1) add(words + after);
  }
  /// Some holes of one cycle: flat enough to be shifted as a whole.
  void holes() {
    const int cycle = 200 + static_cast<int>(random_.below(10));
    if (cycle == 204) return;
    const double surface = round(random_.between(-20, 5)), depth = round(random_.between(2, 12));
    const double set_up = round(random_.between(1, 3)), second = random_.chance(0.5) ? 0 : set_up + 20;
    const bool lines = random_.chance(0.7);
    const std::string next = lines ? (random_.chance(0.5) ? " ;TEXT ~\n " : " ~\n") : " ";
    std::string words =
        fmt::format("CYCL DEF {} NAME{}Q200={}{}Q201={}{}Q203={}{}Q204={}", cycle, lines ? " ~\n" : " ",
                    number(set_up), next, number(-depth), next, number(surface), next, number(round(second)));
    if (cycle == 208) words += next + "Q335=" + number(8);
    if (cycle == 200) words += next + "Q206=FAUTO" + next + "Q202=" + number(3);
    if (cycle == 207) words += next + "Q239=" + number(1);
    add(words);
    at_.z() = round(surface + std::max(round(second), set_up));
    const bool modal = random_.chance(0.3);
    const int count = 1 + static_cast<int>(random_.below(4));
    for (int i = 0; i < count; ++i) {
      if (random_.chance(0.2)) add("L M8");
      std::string to = "L";
      for (int k = 0; k < 2; ++k) {
        const double place = round(std::clamp(at_[k] + random_.between(-60, 60), -250.0, 250.0));
        if (k == 1 && random_.chance(0.3)) continue;
        to += ' ' + target_word(k, place);
        at_[k] = place;
      }
      to += " FMAX";
      const bool last = i + 1 == count;
      if (modal)
        add(to + (last ? " M99" : i == 0 ? " M89" : ""));
      else if (random_.chance(0.3))
        add(to), add("CYCL CALL");
      else
        add(to + " M99");
    }
    // a feed move would begin where the hole's shift has left the tool
    at_.z() = round(at_.z() + random_.between(5, 30));
    add(fmt::format("L {} FMAX", word(2, at_.z())));
  }
  void arc() {
    const double r = random_.between(3, 60), t0 = random_.between(0, 6.28);
    const double ca = round(at_.x() - r * std::cos(t0)), cb = round(at_.y() - r * std::sin(t0));
    const double radius = std::hypot(at_.x() - ca, at_.y() - cb);
    const bool clockwise = random_.chance(0.5);
    const char* sense = clockwise ? " DR-" : " DR+";
    const double start = std::atan2(at_.y() - cb, at_.x() - ca), sweep = random_.between(0.4, 5.5);
    const double end = start + (clockwise ? -sweep : sweep);
    const double x = round(ca + radius * std::cos(end)), y = round(cb + radius * std::sin(end));
    if (std::max(std::abs(x), std::abs(y)) > 300) return;
    if (random_.chance(0.3)) {  // by its radius
      add(fmt::format("CR {} {} R{}{}", target_word(0, x), target_word(1, y),
                      number(sweep > std::numbers::pi ? -radius : radius), sense));
    } else {
      add(fmt::format("CC {} {}", word(0, ca), word(1, cb)));
      if (random_.chance(0.2)) add("; ABOUT IT");
      if (random_.chance(0.3)) add(fmt::format("C{}", sense));  // a full circle, then its part
      add(fmt::format("C {} {}{}{}", target_word(0, x), target_word(1, y), sense,
                      random_.chance(0.2) ? " M9" : ""));
    }
    at_.x() = x;
    at_.y() = y;
  }

  Random& random_;
  bool inch_, comma_, numbered_;
  int count_ = 0;
  std::string text_;
  Vec3 at_ = Vec3::Zero();
};

ProgramJob heidenhain_job() {
  ProgramJob job = plain_program_job();
  job.setup.profile = embedded_profile("heidenhain");
  job.setup.further_offsets[5] = WorkOffset{{-40, 25, 5}, 0, {}};
  job.setup.tools[1].comment = "name=\"MILL 10\"";
  return job;
}

TEST(RandomKlartext, IsVerifiedOnRandomMachines) {
  const Seeds seeds = random_seeds(25);
  std::uint64_t done = 0;
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.7);
    const std::string program = KlartextWriter(random).write(25);
    const ProgramRun result = run_program(plan_of(machine), program, heidenhain_job());
    // a hole inside which the correction changes cannot be shifted as a whole
    const bool too_deep = result.outcome.end == ProgramEnd::refused &&
                          findings(result.outcome).find("um inside this cycle") != std::string::npos;
    if (too_deep) continue;
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program << "\n----\n"
                                                    << result.output;
    ++done;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
  }
  EXPECT_GT(2 * done, seeds.count) << "most programs must be compensated";
}

TEST(RandomKlartext, ZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = KlartextWriter(random).write(30);
    const ProgramRun result = run_program(plan_of(machine), program, heidenhain_job());
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program;
    ASSERT_EQ(result.output, program) << "seed " << seed;
  }
}

/// Numbers of blocks without a gap from 0 on.
void expect_counted(const std::string& text) {
  int expected = 0;
  for (std::size_t at = 0; at < text.size(); at = text.find('\n', at) + 1) {
    if (text[at] == ' ') continue;  // a block goes on
    ASSERT_EQ(std::stoi(text.substr(at)), expected++) << text.substr(at, 60);
  }
}

constexpr const char* kTilted = R"(format = 1
[machine]
chain = "w b X Y Z t"
[errors]
EXX = {{ poly = [0, {0}0.05] }}
EYX = {{ poly = [0, 0, {0}2e-4] }}
EZY = {{ poly = [0, {0}0.05] }}
)";

std::string tilted(const char* sign) { return fmt::format(fmt::runtime(kTilted), sign); }

ProgramRun run_ideal(const std::string& machine, const std::string& program) {
  ProgramJob job = heidenhain_job();
  job.datum = DatumRule::ideal;
  return run_program(plan_of(machine), program, job);
}

constexpr const char* kHead =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 R0 FMAX M3\n3 L Z+10 FMAX\n";

// The map and its negative: numbers come back within one last digit.
TEST(Klartext, TheNegativeMapBringsTheNumbersBack) {
  const std::string program = std::string(kHead) +
                              "4 L X+10.0000 Y+5.0000 Z-2.0000 F500\n5 L X+40.0000 Y+25.0000 Z-2.0000\n"
                              "6 L X+55.0000 Y-5.0000 Z-3.5000 M9\n7 END PGM A MM\n";
  const ProgramRun there = run_ideal(tilted(""), program);
  ASSERT_EQ(there.outcome.end, ProgramEnd::done) << findings(there.outcome);
  EXPECT_NE(there.output, program);
  const ProgramRun back = run_ideal(tilted("-"), there.output);
  ASSERT_EQ(back.outcome.end, ProgramEnd::done) << findings(back.outcome);
  const std::size_t from = program.find("4 L");
  ASSERT_EQ(back.output.find("4 L X+"), back.output.find("4 L"));
  std::size_t a = from, b = back.output.find("4 L");
  int numbers = 0;
  while (true) {
    a = program.find_first_of("XYZ", a);
    b = back.output.find_first_of("XYZ", b);
    if (a == std::string::npos || b == std::string::npos || ++numbers > 9) break;
    const double before = read_decimal(std::string_view(program).substr(++a)).value,
                 after = read_decimal(std::string_view(back.output).substr(++b)).value;
    EXPECT_NEAR(after, before, 1.01e-4) << back.output;
  }
  EXPECT_EQ(numbers, 9);
}

TEST(Klartext, BlocksThatAreAddedAreCounted) {
  const std::string program = std::string(kHead) +
                              "4 L X+200 Y+60 F500 M9 ; LONG\n5 CC X+220 Y+60\n6 C X+220 Y+80 DR-\n"
                              "7 ;TEXT ~\n 2019 MORE OF IT\n8 L X+0,5\n9 M30\n10 LBL 1\n11 END PGM A MM\n";
  const ProgramRun run = run_ideal(tilted(""), program);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  expect_counted(run.output);
  EXPECT_NE(run.output.find("\n 2019 MORE OF IT\n"), std::string::npos) << run.output;
  const std::size_t first = run.output.find("\n4 L X"), stop = run.output.find("M9");
  ASSERT_NE(first, std::string::npos);
  EXPECT_GT(run.output.substr(first, stop - first).find('\n', 1), 0U);
  EXPECT_GT(std::count(run.output.begin(), run.output.end(), '\n'), 13);
  EXPECT_NE(run.output.find("; LONG"), std::string::npos);
  EXPECT_LT(run.output.find("; LONG"), stop) << "M9 acts when the motion is done: on the last piece";
}

TEST(Klartext, CommasStayCommas) {
  const std::string program = std::string(kHead) + "4 L X+10,5 Y+3 F500\n5 L X+100 Y+3\n6 END PGM A MM\n";
  const ProgramRun run = run_ideal(tilted(""), program);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  const std::string body = run.output.substr(run.output.find("4 L"));
  EXPECT_EQ(body.find('.'), std::string::npos) << body;
  EXPECT_NE(body.find("Y+2,9"), std::string::npos) << body;
}

// An increment stays one, and what is added says places.
TEST(Klartext, IncrementsStayIncrements) {
  const std::string program = std::string(kHead) + "4 L IX+100 IY+50 F500\n5 L IZ-4\n6 END PGM A MM\n";
  const ProgramRun run = run_ideal(tilted(""), program);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  EXPECT_NE(run.output.find("4 L IX+"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("L IZ-"), std::string::npos) << run.output;
}

// A pole serves several arcs; the one that the first arc needed is not the second one's.
TEST(Klartext, APoleIsRightForEveryArcAboutIt) {
  const std::string program =
      std::string(kHead) +
      "4 L X+40 Y+0 F500\n5 CC X+20 Y+0\n6 C X+20 Y+20 DR+\n7 C X+0 Y+0 DR+\n8 L X+10\n"
      "9 L X+40\n10 C DR-\n11 END PGM A MM\n";
  const std::string machine =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEXX = { poly = [0, 0.3] }\n"
      "EYX = { poly = [0, 0, 3e-3] }\n";
  const ProgramRun run = run_ideal(machine, program);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  expect_counted(run.output);
  EXPECT_NE(run.output.find("CC X+"), std::string::npos);
}

TEST(Klartext, ACorrectionAcrossAnArcMakesLinesOfIt) {
  const std::string machine =
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\nEZX = { poly = [0, 0.2] }\n";
  const std::string program = std::string(kHead) +
                              "4 L X+10 Y+0 F500\n5 CC X+0 Y+0\n6 C X-10 Y+0 DR+ F200 M9\n"
                              "7 CC X+0 Y+0\n8 C DR+\n9 END PGM A MM\n";
  const ProgramRun run = run_ideal(machine, program);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  EXPECT_EQ(run.output.find("DR"), std::string::npos) << run.output;
  EXPECT_NE(run.output.find("\n6 L X+"), std::string::npos) << run.output;
  expect_counted(run.output);
}

// The header is comments behind BEGIN PGM; what it marks is refused a second time.
TEST(Klartext, TheHeaderStandsBehindTheFirstBlock) {
  const std::string program = std::string(kHead) + "4 L X+10 F500\n5 END PGM A MM\n";
  ProgramJob job = heidenhain_job();
  job.header = HeaderForm::inline_comments;
  const ProgramRun run = run_program(plan_of(tilted("")), program, job);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  EXPECT_EQ(run.output.find("0 BEGIN PGM A MM\n1 ;ABBE COMPENSATED - DO NOT EDIT - DO NOT RE-COMPENSATE\n"),
            0U)
      << run.output;
  expect_counted(run.output);
  const ProgramRun again = run_program(plan_of(tilted("")), run.output, job);
  EXPECT_EQ(again.outcome.end, ProgramEnd::refused);
  EXPECT_NE(findings(again.outcome).find("E-COMPENSATED"), std::string::npos);
}

// M129 beside a motion acts behind it: the words are still of the tip.
TEST(Klartext, TipControlEndsInABlockOfItsOwn) {
  const std::string machine =
      "format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[control]\nmode = \"axis\"\n"
      "codes = { M128 = \"tcp\", M129 = \"axis\" }\n[axis.A]\ndirection = [1, 0, 0]\n[axis.C]\n"
      "direction = [0, 0, 1]\n[errors]\nEXX = { poly = [0, 0.2] }\n";
  const std::string begin =
      "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 Z+9 A+10 C+40 R0 FMAX\n3 M128\n"
      "4 L X+5 Y+5 Z+5 FMAX\n";
  const ProgramRun alone = run_ideal(machine, begin + "5 M129\n6 L X+20 Y+7 Z+5 FMAX\n7 END PGM A MM\n");
  EXPECT_EQ(alone.outcome.end, ProgramEnd::done) << findings(alone.outcome);
  const ProgramRun beside = run_ideal(machine, begin + "5 L X+20 Y+7 Z+5 FMAX M129\n6 END PGM A MM\n");
  EXPECT_EQ(beside.outcome.end, ProgramEnd::refused) << beside.output;
  EXPECT_NE(findings(beside.outcome).find("E-TCP"), std::string::npos) << findings(beside.outcome);
}

// Both readers count F of a program in inches in tenths: 8 inches at F48000 last 100 ms.
TEST(Klartext, TenthsOfAnInchDecideHowLongBlocksLast) {
  const std::string program =
      "0 BEGIN PGM A INCH\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 Z+1 R0 FMAX\n3 L X+8 F48000\n4 END PGM A "
      "INCH\n";
  ProgramJob job = heidenhain_job();
  job.datum = DatumRule::ideal;
  job.block_time = 0.030;
  const ProgramRun run = run_program(plan_of(tilted("")), program, job);
  ASSERT_EQ(run.outcome.end, ProgramEnd::done) << findings(run.outcome);
  EXPECT_GT(run.outcome.rewrite.blocks.split, 0U) << run.output;
  EXPECT_GE(run.outcome.rewrite.shortest_split_time, 0.030 * 0.999);
}

TEST(Klartext, WhatIsNotSureIsRefused) {
  const std::vector<std::pair<std::string, std::string>> refused = {
      {"4 C X+10 Y+10 DR+ F500\n", "E-ARC"},                                    // no pole
      {"4 CC X+10 Y+0\n5 CYCL DEF 7.1 X+5\n6 C X+20 Y+0 DR+ F500\n", "E-ARC"},  // of another frame
      {"4 CYCL DEF 7.1 X+5\n5 L IX+5 F500\n", "E-POS"},                         // catches up, or not
      {"4 CYCL DEF 7.1 X+5\n5 CYCL DEF 247 P Q339=+5\n", "E-FRAME"},
      {"4 L Z-1 FMAX M91\n5 L X+5 F500\n", "E-POS"},  // where Z is
      {"4 TOOL CALL 1 Z S100\n5 L X+5 F500\n", "E-POS"},
      {"4 TOOL CALL 9 Z S100\n", "E-TOOL"},
      {"4 CC X+5 Y+0\n5 C X+10 Y+0 Z+5 DR+ F500\n", "E-WORD"},
      {"4 CYCL DEF 247 P Q339=+77\n5 L X+1 Y+1 Z+1 FMAX\n", "E-WCS"},
      {"3 L X+5 F500\n", "E-BLOCK"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun run = run_ideal(tilted(""), kHead + blocks + "90 END PGM A MM\n");
    EXPECT_EQ(run.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(run.outcome).find(code), std::string::npos) << blocks << findings(run.outcome);
  }
  // numbered or not: the words of the next line would be lost
  for (const char* goes_on : {"4 L X+10 ~\n  Y+50 F500\n", "4 CYCL DEF 7.0 SHIFT ~\n  CYCL DEF 7.1 X+5\n"}) {
    const ProgramRun run = run_ideal(tilted(""), kHead + std::string(goes_on) + "90 END PGM A MM\n");
    EXPECT_EQ(run.outcome.end, ProgramEnd::refused) << run.output;
    EXPECT_NE(findings(run.outcome).find("goes on"), std::string::npos) << findings(run.outcome);
  }
  const ProgramRun unstated = run_ideal(tilted(""), "L X+1 Y+1 Z+1 FMAX\n");
  EXPECT_NE(findings(unstated.outcome).find("E-START"), std::string::npos) << findings(unstated.outcome);
}

}  // namespace
}  // namespace abbe
