#include "abbe/gear/machine_cut.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "abbe/gear/test_gear_machines.h"
#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

using ::testing::HasSubstr;

constexpr double kNothing = 1e-9;     // mm
constexpr double kFirstOrder = 1e-6;  // mm
constexpr std::size_t kNodes = 5;

/// A gear on a machine.
struct Cut {
  GearJob job;
  WheelInGap wheel;
  CuttingMotion motion;
  MachineCut cut;
};

Cut cut_of(const std::string& machine, const GearSpec& spec, const CutOptions& options = {}) {
  Cut out{test::job_of(spec), {}, {}, {}};
  out.wheel = test::wheel_of(out.job.gear);
  const Machine read = test::machine_of(machine);
  out.motion = std::get<CuttingMotion>(plan_cutting(read, out.job, out.wheel, kNodes, {}));
  out.cut = std::get<MachineCut>(cut_on_machine(read, out.job, out.wheel, out.motion, options));
  return out;
}

GearFigures figures_of(const Cut& cut) {
  return GearInspection::make(cut.job.gear, cut.wheel, {})->figures(cut.cut.deviations);
}

double largest(const Cut& cut) {
  double most = 0;
  for (const double f :
       flank_field(cut.job.gear, cut.wheel, cut.cut.deviations, even_heights(cut.job.gear, 3)))
    most = std::max(most, std::abs(f));
  return most;
}

const std::string kGrinderErrors =
    "EXX = -7.25\nEYX = 1.65\nEZX = 7.35\nEAX = 6.43\nEBX = 5.64\nECX = -8.71\nEXC = 5.61\nEYC = 5.71\nEAC = "
    "4.25\n"
    "EBC = -0.88\nEXY = { poly = [1, 0.02] }\nEYY = -7.59\nEAY = 5.58\nECY = -0.33\nEXZ = { poly = [3, 0.05] "
    "}\n"
    "EYZ = -2.23\nEBZ = -8.08\nEXA = -9.42\nEYA = 8.29\nEAA = -2.02\nEBA = -1.14\nECA = 2.44\nEX0C = "
    "1.08\nEA0C = 9.23\n"
    "EB0C = 8.04\nEY0A = -2.2\nEC0A = -5.57\nEC0Y = -1.36\nEA0Z = 4.86\nEXt = 4.77\nEBt = 9.35\nEXw = "
    "8.46\nEAw = -9.55\n";

TEST(PlanCutting, CommandsBringTheWheelToItsPose) {
  struct Case {
    std::string machine;
    GearSpec spec;
  };
  for (const Case& c :
       {Case{test::gear_mill(), test::seed_spec()}, Case{test::gear_grinder(), test::helical_spec(1)},
        Case{test::gear_grinder(), test::helical_spec(-1)}}) {
    GearJob job = test::job_of(c.spec);
    job.cutting.middle = 30;
    job.cutting.first_gap = 0.3;
    const WheelInGap wheel = test::wheel_of(job.gear);
    const Machine machine = test::machine_of(c.machine);
    const CuttingMotion motion = std::get<CuttingMotion>(plan_cutting(machine, job, wheel, kNodes, {}));
    const Plan plan = std::get<Plan>(make_plan(machine, {}));
    Query query;
    query.tool = tool_of(machine);
    ASSERT_EQ(motion.gaps(), static_cast<std::size_t>(c.spec.teeth));
    for (std::size_t gap = 0; gap < motion.gaps(); gap += 7)
      for (std::size_t node = 0; node < kNodes; ++node) {
        query.q = motion.commands[gap * kNodes + node];
        const TipAndAxis wanted = wheel_pose(job, wheel, gap, motion.height(node), motion.axis_sign);
        const Pose pose = nominal_pose(plan, query);
        EXPECT_LT((pose.p - wanted.position).norm(), 1e-8);
        EXPECT_LT((pose.R * query.tool.axis - wanted.tool_axis).norm(), 1e-11);
        // The gap is where it is said to be: the wheel's centre above its middle.
        const Vec3 in_gap = gap_axes(job, gap, motion.height(node)).transpose() * pose.p;
        EXPECT_NEAR(in_gap.x(), wheel.centre_distance, 1e-8);
        EXPECT_NEAR(in_gap.y(), 0, 1e-8);
        EXPECT_NEAR(in_gap.z(), 30 + motion.height(node), 1e-8);
      }
  }
}

TEST(PlanCutting, TheGrinderTiltsByTheHelixAngle) {
  const Machine machine = test::machine_of(test::gear_grinder());
  const auto a = static_cast<std::size_t>(machine.find_axis("A"));
  for (const int hand : {1, -1}) {
    const GearJob job = test::job_of(test::helical_spec(hand));
    const WheelInGap wheel = test::wheel_of(job.gear);
    AxisCommands near{};
    near[a] = 90 * deg;
    const CuttingMotion motion = std::get<CuttingMotion>(plan_cutting(machine, job, wheel, kNodes, near));
    EXPECT_NEAR(motion.commands[0][a] / deg, 90 - 15 * hand, 1e-9);
    EXPECT_EQ(motion.axis_sign, -1);
    // From A = 0 the shorter way is taken, with the spindle at the other end of the wheel if need be.
    const CuttingMotion shorter = std::get<CuttingMotion>(plan_cutting(machine, job, wheel, kNodes, {}));
    EXPECT_NEAR(shorter.commands[0][a] / deg, 75 * hand, 1e-9);
  }
}

TEST(PlanCutting, AMachineWithoutTheAxesIsRefused) {
  const GearJob helical = test::job_of(test::helical_spec());
  const WheelInGap wheel = test::wheel_of(helical.gear);
  const auto trouble = [](const auto& planned) {
    EXPECT_TRUE(std::holds_alternative<CuttingProblem>(planned));
    return std::get<CuttingProblem>(planned).trouble;
  };
  EXPECT_EQ(trouble(plan_cutting(test::machine_of(test::gear_mill()), helical, wheel, kNodes, {})),
            CuttingProblem::Trouble::axes);
  const Machine three = test::machine_of("format = 1\n[machine]\nchain = \"w X b Y Z t\"\n");
  EXPECT_EQ(trouble(plan_cutting(three, helical, wheel, kNodes, {})), CuttingProblem::Trouble::axes);
  GearJob far = helical;
  far.cutting.middle = 2000;
  EXPECT_EQ(trouble(plan_cutting(test::machine_of(test::gear_grinder()), far, wheel, kNodes, {})),
            CuttingProblem::Trouble::travel);
}

TEST(PlanCutting, TravelsHoldBetweenTheGaps) {
  // The wheel goes 87.1 mm beyond its stroke of 104 mm, and 32 mm out, with the seed's gear.
  const GearJob job = test::job_of(test::seed_spec());
  const WheelInGap wheel = test::wheel_of(job.gear);
  const auto message = [&](const std::string& ranges) -> std::string {
    const Machine machine = test::machine_of("format = 1\n[machine]\nchain = \"w C b X Z S t\"\n" + ranges +
                                             "[tool]\naxis = [0, 1, 0]\n");
    const auto planned = plan_cutting(machine, job, wheel, kNodes, {});
    const auto* problem = std::get_if<CuttingProblem>(&planned);
    return problem != nullptr ? problem->message : "";
  };
  const std::string turn = "[axis.C]\ndirection = [0, 0, 1]\n";
  EXPECT_EQ(message(turn + "[axis.X]\nrange = [690, 735]\n[axis.Z]\nrange = [-140, 140]\n"), "");
  EXPECT_THAT(message(turn + "[axis.X]\n[axis.Z]\nrange = [-130, 140]\n"),
              HasSubstr("gap 1, on the way into it"));
  EXPECT_THAT(message(turn + "[axis.X]\n[axis.Z]\nrange = [-140, 130]\n"),
              HasSubstr("gap 1, on the way out of it"));
  EXPECT_THAT(message(turn + "[axis.X]\nrange = [690, 705]\n[axis.Z]\n"),
              HasSubstr("gap 1, on the way into it"));
  EXPECT_THAT(message(turn + "range = [-90, 90]\n[axis.X]\n[axis.Z]\n"), HasSubstr("gap 25"));
  // A table of one turn goes back between two gaps of a spur gear, but not within a gap of a helical one.
  EXPECT_EQ(message(turn + "range = [-180, 180]\n[axis.X]\n[axis.Z]\n"), "");
  Machine grinder = test::machine_of(test::gear_grinder());
  const auto c = static_cast<std::size_t>(grinder.find_axis("C"));
  grinder.bodies[static_cast<std::size_t>(grinder.axes[c])].range = std::array{-180 * deg, 180 * deg};
  const GearJob helical = test::job_of(test::helical_spec());
  AxisCommands near{};
  near[static_cast<std::size_t>(grinder.find_axis("A"))] = 90 * deg;
  const auto planned = plan_cutting(grinder, helical, test::wheel_of(helical.gear), kNodes, near);
  ASSERT_TRUE(std::holds_alternative<CuttingProblem>(planned));
  EXPECT_THAT(std::get<CuttingProblem>(planned).message, HasSubstr("axis C would have to turn back"));
}

TEST(MachineCut, NominalMachineHasNoDeviation) {
  EXPECT_LT(largest(cut_of(test::gear_mill(), test::seed_spec())), kNothing);
  EXPECT_LT(largest(cut_of(test::gear_grinder(), test::helical_spec())), kNothing);
}

TEST(MachineCut, AGearThatStandsOffCentreRunsOut) {
  // The mounting of the work as an error of the machine: the closed form of eccentricity through the whole
  // chain.
  const GearFigures figures = figures_of(cut_of(test::gear_mill("EXw = 10\n"), test::seed_spec()));
  const double e = 10 * um, alpha = 20 * deg;
  EXPECT_NEAR(figures.F_r, 2 * e, 1e-4 * e + kFirstOrder);
  for (const PitchFigures& pitch : figures.pitch) {
    EXPECT_NEAR(pitch.F_p, 2 * e / std::cos(alpha), 1e-3 * e);
    EXPECT_NEAR(pitch.f_p, 2 * e / std::cos(alpha) * std::sin(std::numbers::pi / 94), 1e-3 * e);
  }
  // The gear is off by +x of the work: gap 1 is cut too deep there, its ball sits further in.
  EXPECT_NEAR(figures.ball[0], -e, kFirstOrder);
}

TEST(MachineCut, SingleAxisErrorsHaveTheirSigns) {
  const double phi = (20 * deg + std::numbers::pi / 188), e = 10 * um;
  // The column is too far out: both flanks keep material.
  const GearFigures column = figures_of(cut_of(test::gear_mill("EXX = 10\n"), test::seed_spec()));
  EXPECT_NEAR(column.ball[40], e, kNothing);
  EXPECT_NEAR(column.F_r, 0, kNothing);
  // The spindle leans along y as it goes up by 20 urad: helix slopes of opposite senses.
  const GearFigures leaning =
      figures_of(cut_of(test::gear_mill("EYZ = { poly = [0, 0.02] }\n"), test::seed_spec()));
  EXPECT_NEAR(leaning.teeth[9][0].helix.slope, -20 * urad * 90 * std::cos(phi), kNothing);
  EXPECT_NEAR(leaning.teeth[9][1].helix.slope, 20 * urad * 90 * std::cos(phi), kNothing);
  // The table is ahead by 5 arcsec in one sense over half a turn: pitch only.
  const GearFigures index = figures_of(
      cut_of(test::gear_mill("ECC = { sine = [24.2406840555, 0.0174532925199, 0] }\n"), test::seed_spec()));
  EXPECT_NEAR(index.pitch[0].F_p, 2 * 564 * 24.2406840555e-6, 1e-3 * um + 2e-3 * 27.3 * um);
  EXPECT_LT(index.teeth[30][0].profile.total, 1e-6);
  EXPECT_NEAR(index.F_r, 0, kFirstOrder);
}

TEST(MachineCut, PoseCorrectionRemovesEverything) {
  CutOptions options;
  const double before = largest(cut_of(test::gear_grinder(kGrinderErrors), test::helical_spec(), options));
  EXPECT_GT(before, 5 * um);
  const Machine machine = test::machine_of(test::gear_grinder(kGrinderErrors));
  options.free = *free_axes(machine, 0);
  for (const Method method : {Method::newton, Method::closed_form}) {
    options.correction = CutCorrection::pose;
    options.solver.method = method;
    EXPECT_LT(largest(cut_of(test::gear_grinder(kGrinderErrors), test::helical_spec(), options)),
              kFirstOrder);
  }
  options.correction = CutCorrection::flank;
  EXPECT_LT(largest(cut_of(test::gear_grinder(kGrinderErrors), test::helical_spec(), options)), kFirstOrder);
}

TEST(MachineCut, FlankCorrectionIsNeverWorse) {
  // The mill has no axis along y and none that swivels: the flanks tell what C and X can do about it.
  const std::string errors =
      "EXX = 12\nEYX = 16\nEYZ = { poly = [3, 0.05] }\nEAZ = 20\nECC = 9\nEYw = 7\nEBC = 11\n";
  const Machine machine = test::machine_of(test::gear_mill(errors));
  CutOptions options;
  options.free = *free_axes(machine, 0);
  std::array<double, 3> sum{};
  for (const CutCorrection correction : {CutCorrection::none, CutCorrection::pose, CutCorrection::flank}) {
    options.correction = correction;
    const Cut cut = cut_of(test::gear_mill(errors), test::seed_spec(), options);
    for (const double f :
         flank_field(cut.job.gear, cut.wheel, cut.cut.deviations, even_heights(cut.job.gear, 3)))
      sum[static_cast<std::size_t>(correction)] += f * f;
  }
  EXPECT_LT(sum[2], sum[1]);
  EXPECT_LT(std::sqrt(sum[2] / sum[0]), 0.05);
}

TEST(MachineCut, TemperaturesChangeWhileTheTeethAreCut) {
  const std::string errors = "TXX = { poly = [0, 1], of = \"T1\", reference = 20 }\n";
  CutOptions options;
  options.course.time = {0, 100, 1e4};
  options.course.values["T1"] = {20, 20, 30};
  const Cut cut = cut_of(test::gear_mill(errors), test::seed_spec(), options);
  // Linear in time between 100 s and 10^4 s; a tooth takes stroke / feed + index time.
  const auto at = [&](std::size_t gap, std::size_t node) {
    const double t = cut.motion.time(cut.job.cutting, gap, node);
    return std::clamp((t - 100) / 9900 * 10, 0.0, 10.0) * um;
  };
  for (const std::size_t gap : {std::size_t{0}, std::size_t{40}, std::size_t{93}})
    for (std::size_t node = 0; node < kNodes; ++node)
      EXPECT_NEAR(cut.cut.deviations.of(gap, node).d.x(), at(gap, node), kNothing);
  // At 5 mm/s: 5 + 27 mm down, the disc's way beyond the face, a stroke of 104 mm, beyond the face again; 2 s
  // to the next gap.
  const double beyond = std::sqrt(150.0 * 150 - 123 * 123), first = (32 + beyond) / 5;
  EXPECT_NEAR(cut.motion.time(cut.job.cutting, 0, 0), first, 1e-9);
  EXPECT_NEAR(cut.motion.time(cut.job.cutting, 0, kNodes - 1), first + 104 / 5.0, 1e-9);
  EXPECT_NEAR(cut.motion.time(cut.job.cutting, 1, 0), 2 * first + (104 + beyond) / 5 + 2, 1e-9);
  EXPECT_GT(at(93, 0), 1 * um);
  const auto missing =
      cut_on_machine(test::machine_of(test::gear_mill(errors)), cut.job, cut.wheel, cut.motion, {});
  EXPECT_TRUE(std::holds_alternative<MissingSensors>(missing));
}

TEST(MachineCut, StopsWhenAsked) {
  const Cut cut = cut_of(test::gear_mill(), test::seed_spec());
  const auto stopped = cut_on_machine(test::machine_of(test::gear_mill()), cut.job, cut.wheel, cut.motion, {},
                                      [](std::uint64_t done, std::uint64_t) { return done < 3; });
  EXPECT_TRUE(std::get<MachineCut>(stopped).stopped);
}

}  // namespace
}  // namespace abbe
