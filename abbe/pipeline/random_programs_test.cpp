// Random programs on random machines, through the whole way: what the rewriter writes, the independent
// reader must find to be the same program, on the path within tolerance.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

#include "abbe/core/units.h"
#include "abbe/pipeline/diff_programs.h"
#include "abbe/pipeline/test_random_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// Lost motion of every axis in its own direction and across it, as a constant and growing with the position.
std::string random_lost_motion(Random& random) {
  const bool table = random.chance(0.5);
  std::string text = fmt::format("format = 1\n[machine]\nname = \"play\"\nchain = \"{}\"\n",
                                 table ? "w X b Y Z t" : "w b X Y Z t");
  for (const char axis : {'X', 'Y', 'Z'}) text += fmt::format("[axis.{}]\nrange = [-600, 600]\n", axis);
  if (table) text.insert(text.find("[axis.Y]"), "errors_seen = \"body\"\n");
  text += "[errors]\n";
  const auto both = [&](const std::string& name, double lost) {
    const double mean = random.between(-10, 10), slope = random.between(-0.02, 0.02);
    text += fmt::format(
        "{} = {{ forward = {{ poly = [{:.4f}, {:.5f}] }}, backward = {{ poly = [{:.4f}, {:.5f}] }} }}\n",
        name, mean + lost / 2, slope, mean - lost / 2, slope * random.between(0.9, 1.1));
  };
  for (const char axis : {'X', 'Y', 'Z'}) {
    if (random.chance(0.8)) both(fmt::format("E{0}{0}", axis), random.between(-12, 12));
    if (random.chance(0.3)) both(fmt::format("E{}{}", axis == 'X' ? 'Y' : 'X', axis), random.between(-2, 2));
  }
  text += fmt::format("EC0Y = {:.6g}\n", random.between(-40, 40));
  return text;
}

/// A program that LinuxCNC accepts: it knows where it stands.
class ProgramWriter {
 public:
  /// A rotated work offset wants arcs in XY only, lost motion no inverse time.
  explicit ProgramWriter(Random& random, bool xy_only = false, bool inverse_time = true)
      : random_(random), xy_only_(xy_only), inverse_time_(inverse_time) {}

  std::string write(int blocks) {
    text_ = "%\nO7 (random)\nG21 G90 G17 G54 G94\nT1 M6\nG0 X0 Y0 Z20\nF500 S1000 M3\n";
    at_ = Vec3(0, 0, 20);
    for (int i = 0; i < blocks; ++i) block();
    mode(false);
    text_ += "G0 Z50\nM5\nM30\n%\n";
    return text_;
  }

 private:
  void mode(bool incremental) {
    if (incremental != incremental_) text_ += incremental ? "G91\n" : "G90\n";
    incremental_ = incremental;
  }
  double round(double v) { return std::round(v * 1000) / 1000; }
  std::string word(int k, double target) {
    const double v = incremental_ ? target - at_[k] : target;
    std::string digits = fmt::format("{:.3f}", v);
    if (random_.chance(0.3)) digits = fmt::format("{:.4f}", v);
    return std::string(1, "XYZ"[k]) + digits;
  }
  Vec3 target(double reach) {
    Vec3 p;
    for (int k = 0; k < 3; ++k)
      p[k] = round(std::clamp(at_[k] + random_.between(-reach, reach), k == 2 ? -40.0 : -350.0,
                              k == 2 ? 100.0 : 350.0));
    return p;
  }
  void block() {
    switch (random_.below(14)) {
      case 0:
        mode(!incremental_);
        break;
      case 1:
        text_ += random_.chance(0.5) ? "M8\n" : "(a comment)\n";
        break;
      case 2:
        line("G0", 200);
        break;
      case 3:
      case 4:
      case 5:
        line("G1", random_.chance(0.4) ? 300 : 20);
        break;
      case 6:
      case 7:
      case 8:
        arc();
        break;
      case 9:
        cycle();
        break;
      case 10:
        text_ += fmt::format("G92 X{:.3f}\nG92.1\n", random_.between(-5, 5));
        break;
      case 11:
        if (inverse_time_)
          text_ += fmt::format("G93 G1 {} F{:.2f}\nG94 F400\n", word_to(1, 150), random_.between(0.5, 5));
        break;
      case 12:
        text_ += fmt::format("N{} G4 P0.1\n", random_.below(1000));
        break;
      default:
        units();
        break;
    }
  }
  std::string word_to(int k, double reach) {
    const Vec3 p = target(reach);
    const std::string text = word(k, p[k]);
    at_[k] = p[k];
    return text;
  }
  void line(const char* code, double reach) {
    const Vec3 p = target(reach);
    std::string words;
    for (int k = 0; k < 3; ++k) {
      if (!random_.chance(0.7)) continue;
      words += ' ' + word(k, p[k]);
      at_[k] = p[k];
    }
    if (!words.empty()) text_ += fmt::format("{}{}\n", code, words);
  }
  void arc() {
    const int plane = xy_only_ ? 0 : random_.below(3);
    static constexpr int kAxes[3][3] = {{0, 1, 2}, {2, 0, 1}, {1, 2, 0}};
    const int a = kAxes[plane][0], b = kAxes[plane][1], n = kAxes[plane][2];
    const double r = random_.between(2, plane == 0 ? 80 : 20), t0 = random_.between(0, 6.28);
    const double i = round(-r * std::cos(t0)), j = round(-r * std::sin(t0));
    const bool clockwise = random_.chance(0.5), full = random_.chance(0.3);
    const double sweep = full ? 2 * std::numbers::pi : random_.between(0.2, 5.5);
    const double t1 = std::atan2(-j, -i) + (clockwise ? -sweep : sweep), radius = std::hypot(i, j);
    Vec3 end = at_;
    if (!full) {
      end[a] = std::round((at_[a] + i + radius * std::cos(t1)) * 1e4) / 1e4;
      end[b] = std::round((at_[b] + j + radius * std::sin(t1)) * 1e4) / 1e4;
    }
    if (random_.chance(0.3)) end[n] = round(at_[n] + random_.between(-3, 3));
    if (end.head<2>().cwiseAbs().maxCoeff() > 380 || end.z() < -60 || end.z() > 120) return;
    text_ += fmt::format("G{} G{}", 17 + plane, clockwise ? 2 : 3);
    for (int k = 0; k < 3; ++k) {
      if (end[k] == at_[k]) continue;
      const double v = incremental_ ? end[k] - at_[k] : end[k];
      text_ += fmt::format(" {}{:.4f}", "XYZ"[k], v);
    }
    text_ += fmt::format(" {}{:.3f} {}{:.3f}{}\nG17\n", "IJK"[a], i, "IJK"[b], j,
                         full && random_.chance(0.3) ? " P2" : "");
    at_ = end;
  }
  void cycle() {
    mode(false);
    const double r = round(at_.z() - random_.between(0, 3));
    text_ += fmt::format("G9{} {} X{:.3f} Y{:.3f} R{:.3f} Z{:.3f}\n", 8 + random_.below(2),
                         random_.chance(0.5) ? "G81" : "G82 P0.1", at_.x(), at_.y(), r, r - 4);
    at_.x() = round(at_.x() + 3);
    text_ += fmt::format("X{:.3f}\nG80\nG98\n", at_.x());
    // where a cycle leaves Z depends on G98 and G99: name it
    text_ += fmt::format("G0 Z{:.3f}\n", at_.z());
  }
  void units() {
    mode(false);
    at_.x() = std::round(at_.x() / 25.4 * 1e4) / 1e4 * 25.4;
    text_ += fmt::format("G20 G1 X{:.4f} F20\nG21 F500\n", at_.x() / 25.4);
  }

  Random& random_;
  bool xy_only_, inverse_time_;
  std::string text_;
  Vec3 at_ = Vec3::Zero();
  bool incremental_ = false;
};

ProgramRun run(const std::string& machine, const std::string& program, bool header, bool reversal = false,
               double rotation = 0) {
  ProgramJob job = plain_program_job();
  job.header = header ? HeaderForm::inline_comments : HeaderForm::none;
  job.version = "test";
  job.reversal = reversal;
  job.setup.work_offsets[0]->rotation = rotation;
  return run_program(
      plan_of(machine), program, job, [header](const ProgramJob& done, ProgramOutcome& outcome) {
        if (outcome.end != ProgramEnd::done || header) return;
        const DiffReport diff = diff_programs(done.program, done.output, {});
        EXPECT_TRUE(diff.same_program) << (diff.diagnostics.empty() ? "" : to_text(diff.diagnostics.front()));
      });
}

TEST(RandomPrograms, AreVerifiedOnRandomMachines) {
  std::uint64_t done = 0, refused = 0;
  const Seeds seeds = random_seeds(300);
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 1.0);
    const std::string program = ProgramWriter(random).write(25);
    const ProgramRun result = run(machine, program, seed % 2 == 0);
    if (result.outcome.end == ProgramEnd::refused) {
      // a cycle whose correction bends inside it, nothing else
      ++refused;
      for (const auto& d : result.outcome.diagnostics) {
        if (d.severity != Severity::error) continue;
        EXPECT_EQ(d.code, "E-CYCLE") << "seed " << seed << "\n" << to_text(d);
      }
      continue;
    }
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << program << "\n----\n"
                                                    << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    ++done;
  }
  EXPECT_GT(done, seeds.count / 2) << refused << " refused";
}

TEST(RandomPrograms, LostMotionIsTakenUpEverywhere) {
  int done = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    Random random(seed);
    const bool rotated = seed % 4 == 0;
    const std::string machine = random_lost_motion(random);
    const std::string program = ProgramWriter(random, rotated, false).write(25);
    const ProgramRun result = run(machine, program, false, true, rotated ? 0.3 : 0.0);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done)
        << "seed " << seed << "\n"
        << machine << findings(result.outcome) << program << "\n----\n"
        << result.output;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    ++done;
  }
  EXPECT_EQ(done, 200);
}

/// The same machine with every error the other way round.
std::string with_errors_reversed(const std::string& machine) {
  const std::size_t errors = machine.find("[errors]\n") + 9;
  std::string text = machine.substr(0, errors);
  std::istringstream lines(machine.substr(errors));
  for (std::string line; std::getline(lines, line);) {
    const std::size_t equals = line.find("= "), open = line.find("{ ");
    if (open != std::string::npos)
      line.insert(open + 2, "times = { poly = [-1] }, ");
    else
      line = fmt::format("{}= {:.9g}", line.substr(0, equals), -std::stod(line.substr(equals + 2)));
    text += line + '\n';
  }
  return text;
}

/// Lines that are not split, with all their words.
std::string short_moves(Random& random) {
  std::string text = "G21 G90 G17 G94\nG54\nT1 M6\nG43 H1\nG0 X0.000 Y0.000 Z20.000\nF500\n";
  Vec3 at(0, 0, 20);
  const auto near = [&](double v, double most) {
    return std::round(std::clamp(v + random.between(-15, 15), -most, most) * 1e3) / 1e3;
  };
  for (int i = 0; i < 40; ++i) {
    at = Vec3(near(at.x(), 250), near(at.y(), 250), near(at.z(), 60));
    text += fmt::format("G{} X{:.4f} Y{:.4f} Z{:.4f}\n", random.below(2), at.x(), at.y(), at.z());
  }
  return text + "M2\n";
}

/// The numbers of a line behind X, Y and Z.
std::vector<double> coordinates_of(const std::string& line) {
  std::vector<double> values;
  for (std::size_t at = 0; at + 1 < line.size(); ++at) {
    if (line[at] >= 'X' && line[at] <= 'Z') values.push_back(std::stod(line.substr(at + 1)));
  }
  return values;
}

TEST(RandomPrograms, AMapAndItsNegativeBringTheNumbersBack) {
  constexpr double kLastDigit = 1e-4 + 1e-9;
  int numbers = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 1.0), program = short_moves(random);
    const ProgramRun there = run(machine, program, false);
    ASSERT_EQ(there.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                   << findings(there.outcome) << program;
    ASSERT_NE(there.output, program) << "seed " << seed;
    const ProgramRun back = run(with_errors_reversed(machine), there.output, false);
    ASSERT_EQ(back.outcome.end, ProgramEnd::done) << "seed " << seed << "\n" << findings(back.outcome);
    std::istringstream first(program), last(back.output);
    for (std::string a, b; std::getline(first, a) && std::getline(last, b);) {
      const auto meant = coordinates_of(a), found = coordinates_of(b);
      ASSERT_EQ(meant.size(), found.size()) << "seed " << seed << "\n" << a << "\n" << b;
      for (std::size_t k = 0; k < meant.size(); ++k)
        EXPECT_NEAR(meant[k], found[k], kLastDigit) << "seed " << seed << "\n" << a << "\n" << b;
      numbers += static_cast<int>(meant.size());
    }
  }
  EXPECT_GT(numbers, 7000);
}

TEST(RandomPrograms, ZeroErrorsChangeNoByte) {
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Random random(seed);
    const std::string machine = random_machine(random, 0.0);
    const std::string program = ProgramWriter(random).write(40);
    const ProgramRun result = run(machine, program, false);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n" << findings(result.outcome);
    ASSERT_EQ(result.output, program) << "seed " << seed;
  }
}

}  // namespace
}  // namespace abbe
