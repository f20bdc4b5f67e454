#include <filesystem>
#include <map>
#include <set>

#include "abbe/cl/record.h"
#include "abbe/cl/test_random_cl.h"

// Real CL files that nobody of this project wrote. With ABBE_CL_TABLE=FILE the table of docs/cl-corpus.md is
// written.

namespace abbe::cl {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = fs::path(ABBE_SOURCE_DIR) / ".." / "shared" / "data" / "cldata";
constexpr int kMachines = 5;  // one of each kind; only the first has no rotary axes

std::map<std::string, std::string> corpus() {
  std::map<std::string, std::string> files;
  if (!fs::exists(kFolder)) return files;
  for (const auto& entry : fs::recursive_directory_iterator(kFolder)) {
    if (entry.path().extension() == ".apt") files[entry.path().filename()] = slurp(entry.path());
  }
  return files;
}

std::string machine_of(int kind, std::uint64_t seed, double scale) {
  Random random(seed);
  return random_machine_text(random, kind, scale);
}

TEST(ClCorpus, ZeroErrorsChangeNoByte) {
  const auto files = corpus();
  if (files.empty()) GTEST_SKIP() << "no CL files in " << kFolder;
  for (const auto& [name, text] : files) {
    const ClRun run = run_cl(plan_of(machine_of(1, 1, 0)), text);
    ASSERT_TRUE(run.verify.agrees) << name << "\n" << run.findings();
    EXPECT_EQ(run.output, text) << name;
  }
}

struct Row {
  std::uint64_t lines = 0, motions = 0, arcs = 0;
  int fine = 0, done = 0;  ///< at 1 um, and at 5 um too
  double before = 0, after = 0;
  std::set<std::string> reasons, last_reasons;
};

TEST(ClCorpus, IsCompensatedOrRefusedWithAReason) {
  const auto files = corpus();
  if (files.empty()) GTEST_SKIP() << "no CL files in " << kFolder;
  std::map<std::string, Row> table;
  for (const auto& [name, text] : files) {
    Row& row = table[name];
    for (int i = 0; i < kMachines; ++i) {
      const Plan plan = plan_of(machine_of(i % 5, static_cast<std::uint64_t>(100 + i), 1));
      ClRun run = run_cl(plan, text);
      if (run.rewrite.complete) {
        ++row.fine;
      } else {
        // what bends inside a hole or under CUTCOM needs a wider tolerance: the remedy of the finding
        row.reasons.insert(run.refusal());
        Options wide;
        wide.tolerance = 5 * um;
        run = run_cl(plan, text, wide);
      }
      row.lines = run.rewrite.lines_in;
      row.motions = std::max(row.motions, run.rewrite.blocks.motion);
      row.arcs = std::max(row.arcs, run.rewrite.arcs_in);
      if (!run.rewrite.complete) {
        ASSERT_FALSE(run.refusal().empty()) << name;
        row.last_reasons.insert(run.refusal());
        continue;
      }
      ASSERT_TRUE(run.verify.agrees) << name << " machine " << i << "\n" << run.findings();
      EXPECT_LE(run.verify.after.max, run.verify.allowed) << name;
      ++row.done;
      row.before = std::max(row.before, run.verify.before.max);
      row.after = std::max(row.after, run.verify.after.max);
    }
    // a three-axis machine cannot tilt: nothing else is left
    for (const std::string& reason : row.last_reasons) EXPECT_EQ(reason, "E-REACH") << name;
    EXPECT_GE(row.done, kMachines - 1) << name << ": refusing is no way out";
  }
  if (const char* path = std::getenv("ABBE_CL_TABLE")) {
    std::ofstream out(path);
    out << "| file | lines | motions | arcs | zero errors | verified at 1 um | at 5 um | worst before | "
           "worst after | refusals at 1 um |\n"
        << "|---|---|---|---|---|---|---|---|---|---|\n";
    for (const auto& [name, row] : table) {
      std::string reasons;
      for (const std::string& reason : row.reasons) reasons += (reasons.empty() ? "" : ", ") + reason;
      out << fmt::format(
          "| {} | {} | {} | {} | same bytes | {} of {} | {} of {} | {:.1f} um | {:.2f} um | {} |\n", name,
          row.lines, row.motions, row.arcs, row.fine, kMachines, row.done, kMachines, row.before / um,
          row.after / um, reasons.empty() ? "-" : reasons);
    }
  }
}

/// A circle of a Heidenhain program: CC X Y, C X Y DR.
struct Turn {
  double x = 0, y = 0, end_x = 0, end_y = 0;
  int sense = 0;
};

void read_words(std::istringstream& words, double& x, double& y, int& sense) {
  for (std::string word; words >> word;) {
    if (word.starts_with("DR"))
      sense = word[2] == '+' ? 1 : -1;
    else if (word.size() > 1 && (word[0] == 'X' || word[0] == 'Y') &&
             word.find_first_not_of("0123456789+-.", 1) == std::string::npos)
      (word[0] == 'X' ? x : y) = std::stod(word.substr(1));
  }
}

std::vector<Turn> posted_turns(const std::string& text) {
  std::vector<Turn> turns;
  Turn now;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    std::istringstream words(line);
    std::string number, code;
    words >> number >> code;
    if (code == "CC") read_words(words, now.x, now.y, now.sense);
    if (code == "L" || code == "C") read_words(words, now.end_x, now.end_y, now.sense);
    if (code == "C") turns.push_back(now);
  }
  return turns;
}

std::vector<Turn> turns_of(const std::string& text) {
  std::vector<Turn> turns;
  RecordReader reader;
  Interpreter interpreter({}, std::nullopt);
  Findings findings("part.apt");
  std::istringstream lines(text);
  std::uint64_t number = 0;
  for (std::string line; std::getline(lines, line);) {
    if (reader.add(line + "\n", ++number) != RecordReader::State::complete ||
        interpreter.take(reader.record(), findings) != Interpreter::Outcome::motion)
      continue;
    const Motion& motion = interpreter.motion();
    if (motion.kind == MotionKind::arc && std::abs(motion.end.axis.z()) > 0.9999)
      turns.push_back({motion.arc.centre.x(), motion.arc.centre.y(), motion.end.tip.x(), motion.end.tip.y(),
                       motion.arc.normal.z() > 0 ? 1 : -1});
  }
  EXPECT_FALSE(findings.refused());
  return turns;
}

// Another post-processor's output of the same files: the same circles, in the same order and sense.
TEST(ClCorpus, CirclesAreThoseOfTheReferencePost) {
  constexpr double kItsDigits = 1.1e-3;  // mm: it rounds twice
  const auto files = corpus();
  if (files.empty()) GTEST_SKIP() << "no CL files in " << kFolder;
  for (const auto& [name, post, count] :
       {std::tuple{"shimemcunha", "12.h", 28U}, std::tuple{"Top-light-cover", "11.h", 708U}}) {
    const auto posted = posted_turns(slurp(kFolder / name / "expected" / post)),
               read = turns_of(files.at(std::string(name) + ".apt"));
    ASSERT_EQ(read.size(), count) << name;
    ASSERT_EQ(posted.size(), read.size()) << name;
    for (std::size_t i = 0; i < read.size(); ++i) {
      EXPECT_NEAR(posted[i].x, read[i].x, kItsDigits) << name << " " << i;
      EXPECT_NEAR(posted[i].y, read[i].y, kItsDigits) << name << " " << i;
      EXPECT_NEAR(posted[i].end_x, read[i].end_x, kItsDigits) << name << " " << i;
      EXPECT_NEAR(posted[i].end_y, read[i].end_y, kItsDigits) << name << " " << i;
      EXPECT_EQ(posted[i].sense, read[i].sense) << name << " " << i;
    }
  }
}

}  // namespace
}  // namespace abbe::cl
