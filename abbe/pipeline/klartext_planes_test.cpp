// Drilling cycles on tilted planes (PLANE SPATIAL) on five-axis machines, through the whole way: holes square
// to the plane, each with its own surface.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "abbe/machine/read_profile.h"
#include "abbe/pipeline/test_five_axis_machine.h"
#include "abbe/pipeline/test_run_program.h"

namespace abbe {
namespace {

using namespace testing;

/// Two planes, to which the program turns the rotary axes itself; on each of them holes, lines and arcs.
class PlaneWriter {
 public:
  PlaneWriter(Random& random, const Structure& structure, const Plan& plan)
      : random_(random), structure_(structure), plan_(plan) {}

  std::string write() {
    std::string text = "BEGIN PGM PLANES MM\nTOOL CALL 1 Z S1000\n";
    for (int i = 0; i < 2; ++i) text += plane();
    return text + "M30\nEND PGM PLANES MM\n";
  }

 private:
  static double rounded(double value) { return std::round(value * 1e3) / 1e3; }
  double place() { return rounded(random_.between(-100, 100)); }

  /// Rz(c) Ry(b) Rx(a) e_z = n:  a = asin(-n'y), b = atan2(n'x, n'z) with n' = Rz(-c) n, for any c.
  std::string plane() {
    const auto [tilt, turn, n] = draw_stance(random_, structure_, plan_);
    const double c = rounded(random_.between(-180, 180)) * deg;
    const double x = std::cos(c) * n.x() + std::sin(c) * n.y(),
                 y = -std::sin(c) * n.x() + std::cos(c) * n.y();
    std::string text =
        fmt::format("PLANE SPATIAL SPA{:+.5f} SPB{:+.5f} SPC{:+.3f} STAY\nL {}{:+.3f} {}{:+.3f} R0 FMAX\n",
                    std::asin(-y) / deg, std::atan2(x, n.z()) / deg, c / deg, structure_.tilt, tilt,
                    structure_.turn, turn);
    text += "L X+0 Y+0 FMAX\nL Z+60 FMAX M3\n";
    text += holes() + cut() + holes();
    return text + "L Z+80 FMAX\nPLANE RESET STAY\n";
  }
  std::string cut() {
    const double x = place(), y = place();
    return fmt::format(
        "L X{:+.3f} Y{:+.3f} FMAX\nL Z{:+.3f} F500\nCC X{:+.3f} Y{:+.3f}\nC X{:+.3f} Y{:+.3f} DR+\nL Z+30 "
        "FMAX\n",
        x, y, rounded(random_.between(-10, 5)), x + 8, y, x + 16, y);
  }
  std::string holes() {
    constexpr int bore_mill = 208;
    if (random_.chance(0.25)) return old_holes();
    const int cycle = random_.chance(0.3) ? bore_mill : 200 + static_cast<int>(random_.below(4));
    std::string text = fmt::format("CYCL DEF {} HOLE ~\n Q200=2 ~\n Q201={:.3f} ~\n Q203={:.3f} ~\n Q204=20",
                                   cycle, -rounded(random_.between(1, 4)), rounded(random_.between(-15, 15)));
    text += cycle == bore_mill ? " ~\n Q335=5\n" : "\n";
    const bool modal = random_.chance(0.2);
    for (int i = 0; i < 3; ++i) {
      text += fmt::format("L X{:+.3f} Y{:+.3f} FMAX", place(), place());
      if (modal)
        text += i == 0 ? " M89\n" : i == 2 ? " M99\n" : "\n";
      else
        text += random_.chance(0.5) ? " M99\n" : "\nCYCL CALL\n";
    }
    return text + "L Z+60 FMAX\n";
  }

  /// The older cycles drill from where the tool stands.
  std::string old_holes() {
    const double depth = rounded(random_.between(1, 4)), surface = rounded(random_.between(-15, 15));
    std::string text = random_.chance(0.5)
                           ? fmt::format(
                                 "CYCL DEF 1.0 PECKING\nCYCL DEF 1.1 SET UP 2\nCYCL DEF 1.2 DEPTH-{:.3f}\n"
                                 "CYCL DEF 1.3 PECKG 1\nCYCL DEF 1.4 DWELL 0\nCYCL DEF 1.5 F100\n",
                                 depth)
                           : fmt::format(
                                 "CYCL DEF 17.0 TAPPING\nCYCL DEF 17.1 DIST2\nCYCL DEF 17.2 DEPTH -{:.3f}\n"
                                 "CYCL DEF 17.3 PITCH-1\n",
                                 depth);
    text += fmt::format("L X{:+.3f} Y{:+.3f} FMAX\nL Z{:+.3f} FMAX M99\n", place(), place(), surface + 2);
    const bool modal = random_.chance(0.3);
    text += fmt::format("L X{:+.3f} Y{:+.3f} FMAX {}\n", place(), place(), modal ? "M89" : "M99");
    text += fmt::format("L X{:+.3f} Y{:+.3f} FMAX{}\n", place(), place(), modal ? "" : "\nCYCL CALL");
    text += fmt::format("L Y{:+.3f} FMAX M99\n", place());
    return text + "L Z+60 FMAX\n";
  }

  Random& random_;
  Structure structure_;
  const Plan& plan_;
};

const std::string kControl = "[control]\nmode = \"axis\"\n";

ProgramJob plane_job() {
  ProgramJob job = plain_program_job(kToolLength);
  job.setup.profile = embedded_profile("heidenhain");
  return job;
}

ProgramRun run(const std::string& machine, const std::string& program, const std::string& judged_by = {}) {
  return run_program(plan_of(machine), program, plane_job(),
                     [&](const ProgramJob& job, ProgramOutcome& outcome) {
                       if (!judged_by.empty() && outcome.end == ProgramEnd::done)
                         outcome = verify_programs(plan_of(judged_by), job, job.output);
                     });
}

struct Drawn {
  std::string machine, opposite, program;
};

/// `scale`: of the errors. Half of what other five-axis programs are tested with: a hole is shifted whole.
Drawn draw(std::uint64_t seed, double scale = 0.5) {
  Random random(seed), same(seed);
  const Structure& structure = kStructures[seed % std::size(kStructures)];
  Drawn drawn;
  drawn.machine = machine_text(random, structure, kControl, scale);
  drawn.opposite = machine_text(same, structure, kControl, -scale);
  drawn.program = PlaneWriter(random, structure, plan_of(drawn.machine)).write();
  return drawn;
}

// M89 needs one height for all of its holes: most programs with it are refused, and no others.
bool refused_for_m89(const ProgramRun& run) {
  return run.outcome.end == ProgramEnd::refused &&
         findings(run.outcome).find("M89 needs another height") != std::string::npos;
}

TEST(KlartextPlanes, HolesAreVerifiedOnMachinesOfEveryStructure) {
  const Seeds seeds = random_seeds(35);
  std::uint64_t done = 0;
  for (std::uint64_t seed = seeds.first; seed != seeds.end(); ++seed) {
    const Drawn drawn = draw(seed);
    const ProgramRun result = run(drawn.machine, drawn.program);
    if (refused_for_m89(result)) continue;
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << "seed " << seed << "\n"
                                                    << findings(result.outcome) << drawn.machine << "\n----\n"
                                                    << drawn.program << "\n----\n"
                                                    << result.output;
    ++done;
    EXPECT_LE(result.outcome.verify.after.max, result.outcome.verify.allowed) << "seed " << seed;
    EXPECT_GT(result.outcome.verify.before.max, result.outcome.verify.after.max) << "seed " << seed;
  }
  EXPECT_GT(2 * done, seeds.count) << "most programs must be compensated";
}

TEST(KlartextPlanes, AMachineWithoutErrorsChangesNoByte) {
  for (std::uint64_t seed = 1; seed <= 14; ++seed) {
    const Drawn drawn = draw(seed, 0);
    const ProgramRun result = run(drawn.machine, drawn.program);
    ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome) << drawn.program;
    EXPECT_EQ(result.output, drawn.program) << "seed " << seed;
  }
}

TEST(KlartextPlanes, OppositeErrorsAreNotVerified) {
  for (std::uint64_t seed = 1; seed <= 7; ++seed) {
    const Drawn drawn = draw(seed);
    const ProgramRun result = run(drawn.machine, drawn.program, drawn.opposite);
    if (refused_for_m89(result)) continue;
    EXPECT_EQ(result.outcome.end, ProgramEnd::disagrees) << "seed " << seed;
  }
}

constexpr const char* kHead =
    "format = 1\n[machine]\nchain = \"w b X Y Z B t\"\n[axis.B]\ndirection = [0, 1, 0]\n[tool]\nlength = "
    "100\n";
constexpr const char* kErrors = "[control]\nmode = \"axis\"\n[errors]\nEXX = { poly = [0, 0.2] }\n";
constexpr const char* kBegin =
    "0 BEGIN PGM A MM\n1 TOOL CALL 1 Z S3000\n2 L X+0 Y+0 Z+50 B+0 R0 FMAX M3\n"
    "3 PLANE SPATIAL SPA+0 SPB+30 SPC+0 STAY\n4 L B+30 R0 FMAX\n";
constexpr const char* kOver = "5 L X+0 Y+0 FMAX\n6 L Z+50 FMAX\n";
constexpr const char* kDrill = "7 CYCL DEF 201 Q200=2 Q201=-10 Q206=150 Q203=+4 Q204=20\n";

ProgramJob ideal_job() {
  ProgramJob job = plane_job();
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.tools[1] = ToolEntry{1, 1, {}, 100, 10, ""};
  job.datum = DatumRule::ideal;
  return job;
}

ProgramRun run_by_hand(const std::string& program) {
  return run_program(plan_of(std::string(kHead) + kErrors), program, ideal_job());
}

// X is 0.2 um per mm too long, and 100 cos 30 at mid-depth (Q203 - 4 = 0): 17.32 um, of which cos 30 lie
// along X of the plane and sin 30 along the tool: X - 15.0 um, Q203 - 8.7 um. At X50 half of it.
TEST(KlartextPlanes, TheCorrectionIsTurnedIntoThePlane) {
  const ProgramRun result = run_by_hand(std::string(kBegin) + kOver + kDrill +
                                        "8 L X+100 Y+10 FMAX M99\n9 L X+50 FMAX M99\n10 END PGM A MM\n");
  ASSERT_EQ(result.outcome.end, ProgramEnd::done) << findings(result.outcome);
  EXPECT_NE(result.output.find("Q203=+3.9913 Q204=20\n8 L X+99.9850 Y+10 "), std::string::npos)
      << result.output;
  EXPECT_NE(result.output.find("\n Q203=+3.9957 ~\n Q204=20\n10 L X+49.9925 "), std::string::npos)
      << result.output;
}

// The verifying reader finds a hole that is off by 3 um along the plane or along the tool.
TEST(KlartextPlanes, AHoleThatIsOffIsFound) {
  const std::string program =
      std::string(kBegin) + kOver + kDrill + "8 L X+100 Y+10 FMAX M99\n9 END PGM A MM\n";
  const Plan plan = plan_of(std::string(kHead) + kErrors);
  run_program(plan, program, ideal_job(), [&](const ProgramJob& job, ProgramOutcome& outcome) {
    ASSERT_EQ(outcome.end, ProgramEnd::done) << findings(outcome);
    for (const auto& [from, to] : std::vector<std::pair<std::string, std::string>>{
             {"Q203=+3.9913", "Q203=+3.9943"}, {"X+99.9850", "X+99.9820"}, {"Y+10", "Y+10.003"}}) {
      const ProgramOutcome judged = judge_spoiled(plan, job, from, to);
      EXPECT_EQ(judged.end, ProgramEnd::disagrees) << to;
      EXPECT_NE(findings(judged).find("V-CYCLE"), std::string::npos) << findings(judged);
    }
  });
}

TEST(KlartextPlanes, ACycleWhereTheToolDoesNotStandYetIsRefused) {
  const std::vector<std::pair<std::string, std::string>> refused = {
      {std::string(kDrill) + "8 L X+1 Y+1 Z+50 FMAX M99\n", "E-CYCLE"},
      {"5 L X+1 Y+1 FMAX\n" + std::string(kDrill) + "8 CYCL CALL\n", "E-POS"},
      {std::string(kOver) + kDrill + "8 PLANE RESET STAY\n9 CYCL CALL\n", "E-POS"},
      {std::string(kOver) + kDrill + "8 L B+20 FMAX M99\n", "E-PLANE"}};
  for (const auto& [blocks, code] : refused) {
    const ProgramRun result = run_by_hand(kBegin + blocks + "90 END PGM A MM\n");
    EXPECT_EQ(result.outcome.end, ProgramEnd::refused) << blocks;
    EXPECT_NE(findings(result.outcome).find(code), std::string::npos) << blocks << findings(result.outcome);
  }
}

}  // namespace
}  // namespace abbe
