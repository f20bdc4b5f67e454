// Motions judged together: the same verdict and figures as one by one, and no mutation of a line slips
// through.
#include <gtest/gtest.h>

#include <functional>
#include <random>
#include <string>
#include <variant>
#include <vector>

#include "abbe/compensate/plain_program_fixture.h"
#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/verify/verify.h"

namespace abbe {
namespace {

using testing::five_axes;
using testing::RandomProgram;
using testing::TestFile;

constexpr double kSameFigure = 1e-9;  // mm, rad

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size() - 1) + 1;
    lines.push_back(text.substr(begin, end - begin));
    begin = end;
  }
  return lines;
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line;
  return text;
}

/// One program, its compensated text, and the judge.
class Judged {
 public:
  explicit Judged(std::string program, bool probed = true)
      : plan_(std::get<Plan>(make_plan(five_axes(), {}))), program_(std::move(program)), original_(program_) {
    job_.setup.work_offsets[0] = WorkOffset{{3, 5, -7}, 0, {}};
    job_.datum = probed ? DatumRule::probed : DatumRule::ideal;
    job_.original_path = original_.path();
    job_.original_name = "part.ngc";
    job_.output_name = "out.ngc";
    RewriteJob rewriting;
    rewriting.setup = job_.setup;
    rewriting.probed_datum = probed;
    const testing::Rewritten rewritten = testing::rewrite(five_axes(), program_, rewriting);
    EXPECT_TRUE(rewritten.report.complete) << rewritten.findings();
    output_ = rewritten.text;
  }
  [[nodiscard]] const std::string& output() const { return output_; }
  [[nodiscard]] VerifyReport judge(const std::string& output, bool one_by_one) {
    const TestFile file(output);
    job_.output_path = file.path();
    job_.one_by_one = one_by_one;
    return verify_program(plan_, job_);
  }

 private:
  Plan plan_;
  std::string program_;
  TestFile original_;
  VerifyJob job_;
  std::string output_;
};

/// A path of plain lines and nothing else, 0.4 mm apart.
std::string plain_path(int lines) {
  std::string text = "G21 G90 G17 G54 G94\nG0 X0 Y10 Z20 A30 C0\nG1 X0.4 Y10.1 Z20 A30.1 C0.1 F2000\n";
  for (int i = 2; i < lines; ++i) {
    char line[120];
    std::snprintf(line, sizeof line, "X%.4f Y%.4f Z%.4f A%.4f C%.4f%s\n", 0.4 * i, 10 + 0.1 * i,
                  20 - 0.05 * i, 30 + 0.1 * i, 0.1 * i, i % 7 == 0 ? (i % 2 == 0 ? " F1500" : " F2000") : "");
    text += line;
  }
  return text + "M2\n";
}

std::string texts(const Diagnostics& diagnostics) {
  std::string all;
  for (const Diagnostic& d : diagnostics) all += to_text(d) + "\n";
  return all;
}

TEST(PlainLane, TheVerdictIsThatOfOneByOne) {
  for (unsigned seed = 21; seed <= 25; ++seed) {
    Judged judged(RandomProgram(seed).text(300), seed % 2 == 0);
    const VerifyReport together = judged.judge(judged.output(), false);
    const VerifyReport alone = judged.judge(judged.output(), true);
    EXPECT_TRUE(together.agrees) << texts(together.diagnostics);
    EXPECT_TRUE(alone.agrees) << texts(alone.diagnostics);
    EXPECT_GT(together.together, 60u);
    EXPECT_EQ(alone.together, 0u);
    EXPECT_EQ(together.feed_motions, alone.feed_motions);
    EXPECT_EQ(together.rapid_motions, alone.rapid_motions);
    EXPECT_EQ(together.events, alone.events);
    EXPECT_EQ(together.quantisation, alone.quantisation);
    EXPECT_NEAR(together.path_length, alone.path_length, 1e-2 * alone.path_length);
    EXPECT_EQ(together.original.sha256, alone.original.sha256);
    EXPECT_EQ(together.output.sha256, alone.output.sha256);
    EXPECT_EQ(together.output.lines, alone.output.lines);
    // ends alone are looked at, not what lies between
    EXPECT_LE(together.after.max, alone.after.max + kSameFigure);
    EXPECT_NEAR(together.before.max, alone.before.max, 1e-4);
    EXPECT_NEAR(together.direction_before, alone.direction_before, 1e-6);
  }
}

TEST(PlainLane, NothingButLinesIsJudgedTogetherFromTheFirstOnes) {
  Judged judged(plain_path(200));
  const VerifyReport report = judged.judge(judged.output(), false);
  EXPECT_TRUE(report.agrees);
  EXPECT_GT(report.together, 190u);
}

/// Changes that make another program of a line.
const std::vector<std::pair<const char*, std::function<void(std::vector<std::string>&, std::size_t)>>>
    kMutations = {
        {"a line less",
         [](auto& lines, std::size_t i) { lines.erase(lines.begin() + static_cast<long>(i)); }},
        {"two lines exchanged", [](auto& lines, std::size_t i) { std::swap(lines[i], lines[i + 1]); }},
        {"another X",
         [](auto& lines, std::size_t i) { lines[i].replace(1, 1, lines[i][1] == '7' ? "8" : "7"); }},
        {"a minus", [](auto& lines, std::size_t i) { lines[i].insert(1, "-"); }},
        {"two micrometres",
         [](auto& lines, std::size_t i) {
           const std::size_t digit = lines[i].find('.') + 3;
           lines[i][digit] =
               static_cast<char>(lines[i][digit] < '5' ? lines[i][digit] + 2 : lines[i][digit] - 2);
         }},
        {"no A",
         [](auto& lines, std::size_t i) {
           const std::size_t a = lines[i].find('A');
           lines[i].erase(a, lines[i].find(' ', a) - a + 1);
         }},
        {"a hundredth of a degree",
         [](auto& lines, std::size_t i) {
           const std::size_t digit = lines[i].find('.', lines[i].find('C')) + 2;
           lines[i][digit] =
               static_cast<char>(lines[i][digit] < '5' ? lines[i][digit] + 2 : lines[i][digit] - 2);
         }},
        {"a feed", [](auto& lines, std::size_t i) { lines[i].insert(lines[i].size() - 1, " F1700"); }},
        {"a rapid",
         [](auto& lines, std::size_t i) {
           lines[i].insert(0, "G0 ");
           lines[i + 1].insert(0, "G1 ");
         }},
        {"a block delete", [](auto& lines, std::size_t i) { lines[i].insert(0, "/"); }},
        {"a comment", [](auto& lines, std::size_t i) { lines[i].insert(lines[i].size() - 1, " (x)"); }},
        {"an event", [](auto& lines, std::size_t i) { lines[i].insert(0, "M5\n"); }},
};

TEST(PlainLane, NoMutationInsideARunIsAccepted) {
  Judged judged(plain_path(120));
  const std::vector<std::string> good = lines_of(judged.output());
  ASSERT_EQ(good.size(), 122u);  // 119 moves, the first lines and the end
  std::mt19937 random(5);
  for (const auto& [name, mutate] : kMutations) {
    for (int round = 0; round < 6; ++round) {
      std::vector<std::string> lines = good;
      std::size_t at = 20 + random() % 90;
      while (lines[at].find('F') != std::string::npos || lines[at + 1].find('F') != std::string::npos) ++at;
      mutate(lines, at);
      const std::string mutated = joined(lines);
      const VerifyReport together = judged.judge(mutated, false), alone = judged.judge(mutated, true);
      EXPECT_FALSE(together.agrees) << name << ", line " << at + 1;
      EXPECT_EQ(together.agrees, alone.agrees) << name;
      if (together.diagnostics.empty() || alone.diagnostics.empty()) continue;  // said above
      EXPECT_EQ(together.diagnostics[0].code, alone.diagnostics[0].code) << name;
      EXPECT_EQ(together.diagnostics[0].place.line, alone.diagnostics[0].place.line) << name;
      EXPECT_GT(together.together, 10u);
    }
  }
}

TEST(PlainLane, AFeedThatChangesOrIsMissingIsSeen) {
  Judged judged(plain_path(120));
  for (const char* instead : {" F1501", "", " F1500.1"}) {
    std::string mutated = judged.output();
    const std::size_t feed = mutated.find(" F1500", mutated.size() / 2);
    ASSERT_NE(feed, std::string::npos);
    mutated.replace(feed, 6, instead);
    EXPECT_FALSE(judged.judge(mutated, false).agrees) << instead;
  }
}

}  // namespace
}  // namespace abbe
