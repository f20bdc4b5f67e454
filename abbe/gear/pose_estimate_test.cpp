#include "abbe/gear/pose_estimate.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "abbe/gear/sensitivity.h"
#include "abbe/gear/test_gear_machines.h"
#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

constexpr double kNothing = 1e-9;     // mm
constexpr double kFirstOrder = 1e-6;  // mm
constexpr double kInterpolation =
    5e-8;  // mm, of 17 places per stroke, and of combinations that are hardly seen

struct GearSetup {
  explicit GearSetup(const GearSpec& spec)
      : job(test::job_of(spec)),
        wheel(test::wheel_of(job.gear)),
        inspection(*GearInspection::make(job.gear, wheel, {})) {}
  GearJob job;
  WheelInGap wheel;
  GearInspection inspection;
};

PoseValues hidden() {
  PoseValues values{};
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> some(-1, 1);
  for (std::size_t i = 0; i < values.size(); ++i)
    values[i] = some(random) * (pose_unknown(i).direction >= 3 ? 20 * urad : 10 * um);
  return values;
}

/// Traces of some teeth as an inspection would give them.
std::vector<MeasuredFlankPoint> measured(const GearSetup& setup, const WheelDeviations& deviations,
                                         const std::vector<int>& teeth, bool with_offsets = false) {
  std::vector<MeasuredFlankPoint> points;
  int trace = 0;
  for (const int tooth : teeth)
    for (const Flank flank : {Flank::right, Flank::left}) {
      const FlankTraces traces = setup.inspection.traces(deviations, tooth - 1, flank);
      const double offset = with_offsets ? 0.02 * (trace % 5) : 0.0;
      for (std::size_t i = 0; i < traces.profile.size(); i += 20)
        points.push_back({tooth, flank, traces.roll_length[i] / setup.job.gear.base_radius, 0,
                          traces.profile[i] + offset, with_offsets ? trace : -1});
      ++trace;
      for (std::size_t i = 0; i < traces.helix.size(); i += 10)
        points.push_back({tooth, flank, setup.job.gear.reference_roll, traces.z[i], traces.helix[i] - offset,
                          with_offsets ? trace : -1});
      ++trace;
    }
  return points;
}

double largest_of(const GearSetup& setup, const WheelDeviations& a, const WheelDeviations& b) {
  const std::vector<double> z = even_heights(setup.job.gear, 5);
  const auto fa = flank_field(setup.job.gear, setup.wheel, a, z),
             fb = flank_field(setup.job.gear, setup.wheel, b, z);
  double most = 0;
  for (std::size_t i = 0; i < fa.size(); ++i) most = std::max(most, std::abs(fa[i] - fb[i]));
  return most;
}

TEST(PoseMap, AWheelMovedIsAGearMovedTheOtherWay) {
  const GearSetup setup(test::helical_spec());
  const Stroke stroke = stroke_of(setup.job, setup.wheel);
  // The gear lifted and turned about its axis; the wheel lowered and turned back about the gear's axis.
  PoseValues gear{}, wheel{};
  gear[2] = 5 * um;
  gear[5] = 30 * urad;
  wheel[12 + 2] = -5 * um;
  wheel[12 + 5] = -30 * urad;
  wheel[12 + 1] = -30 * urad * setup.wheel.centre_distance;
  EXPECT_LT(largest_of(setup, deviations_of(setup.job, setup.wheel, gear, stroke, 5),
                       deviations_of(setup.job, setup.wheel, wheel, stroke, 5)),
            kNothing);
}

TEST(EstimatePose, HiddenDeviationsAreFound) {
  for (const GearSpec& spec : {test::seed_spec(), test::helical_spec(), test::helical_spec(-1)}) {
    const GearSetup setup(spec);
    const Stroke stroke = stroke_of(setup.job, setup.wheel);
    const WheelDeviations truth = deviations_of(setup.job, setup.wheel, hidden(), stroke, 17);
    const PoseEstimate estimate =
        estimate_pose(setup.job, setup.wheel, measured(setup, truth, {1, 12, 20, 31}), 0);
    ASSERT_EQ(estimate.status, PoseEstimate::Status::ok);
    EXPECT_GT(estimate.rms_before, 3 * um);
    EXPECT_LT(estimate.rms_after, kInterpolation);
    // Not the values themselves, of which some only act together: what inspection sees, on all teeth. A tilt
    // that grows along the face is seen by neither trace.
    const GearFigures a = setup.inspection.figures(truth),
                      b = setup.inspection.figures(
                          deviations_of(setup.job, setup.wheel, estimate.value, stroke, 17));
    for (std::size_t i = 0; i < a.teeth.size(); ++i)
      for (std::size_t side = 0; side < 2; ++side) {
        EXPECT_NEAR(a.teeth[i][side].profile.slope, b.teeth[i][side].profile.slope, kFirstOrder);
        EXPECT_NEAR(a.teeth[i][side].helix.slope, b.teeth[i][side].helix.slope, kFirstOrder);
        EXPECT_NEAR(a.teeth[i][side].position, b.teeth[i][side].position, kFirstOrder);
      }
  }
}

TEST(EstimatePose, TheRankIsStated) {
  const GearSetup spur(test::seed_spec());
  const WheelDeviations nothing(-60, 60, 4, 94);
  const PoseEstimate estimate =
      estimate_pose(spur.job, spur.wheel, measured(spur, nothing, {1, 25, 48, 72}), 1 * um);
  EXPECT_LT(estimate.rank, 24);
  EXPECT_GT(estimate.rank, 8);
  // The wheel along the gap of a spur gear, and swivelled about x: no flank shows it.
  EXPECT_NEAR(estimate.determined[12 + 2], 0, 1e-9);
  EXPECT_NEAR(estimate.determined[12 + 3], 0, 1e-9);
  EXPECT_NEAR(estimate.determined[12 + 0], 1, 0.6);
  EXPECT_EQ(estimate_pose(spur.job, spur.wheel, {}, 0).status, PoseEstimate::Status::no_points);
  EXPECT_EQ(estimate_pose(spur.job, spur.wheel,
                          {{95, Flank::right, 0.3, 0, 0, -1}, {1, Flank::left, -3, 0, 0, -1}}, 0)
                .status,
            PoseEstimate::Status::no_points);
}

TEST(EstimatePose, NoiseDoesNotMoveTheWheel) {
  // One tooth does not tell where the gear stands: without a limit half a micrometre of noise on it becomes
  // millimetres on the other side of the gear.
  const GearSetup setup(test::helical_spec());
  const Stroke stroke = stroke_of(setup.job, setup.wheel);
  const WheelDeviations truth = deviations_of(setup.job, setup.wheel, hidden(), stroke, 17);
  const WheelDeviations none(stroke.low, stroke.high, 17, 41);
  std::vector<MeasuredFlankPoint> points = measured(setup, truth, {1});
  std::mt19937_64 random(7);
  std::normal_distribution<double> noise(0, 0.5 * um);
  for (MeasuredFlankPoint& point : points) point.deviation += noise(random);
  for (const double sigma : {0.0, 0.5 * um}) {
    const PoseEstimate estimate = estimate_pose(setup.job, setup.wheel, points, sigma);
    ASSERT_EQ(estimate.status, PoseEstimate::Status::ok);
    EXPECT_LT(estimate.rms_after, 0.7 * um);
    EXPECT_LT(largest_of(setup, deviations_of(setup.job, setup.wheel, estimate.value, stroke, 17), none),
              0.05);
  }
  // What lies below the form diameter or beyond the face is no flank.
  const std::size_t on_flank = points.size();
  points.push_back({1, Flank::right, 0.9 * setup.job.gear.form_roll, 0, 1, -1});
  points.push_back({1, Flank::right, setup.job.gear.reference_roll, 31, 1, -1});
  EXPECT_EQ(estimate_pose(setup.job, setup.wheel, points, 0).points, on_flank);
  points.resize(5);
  EXPECT_EQ(estimate_pose(setup.job, setup.wheel, points, 0).status, PoseEstimate::Status::few_points);
}

TEST(EstimatePose, OffsetsOfTracesDoNotMatter) {
  const GearSetup setup(test::helical_spec());
  const Stroke stroke = stroke_of(setup.job, setup.wheel);
  const WheelDeviations truth = deviations_of(setup.job, setup.wheel, hidden(), stroke, 17);
  const PoseEstimate estimate =
      estimate_pose(setup.job, setup.wheel, measured(setup, truth, {1, 12, 20, 31}, true), 0);
  EXPECT_LT(estimate.rms_after, kInterpolation);
  // Slopes and forms come back on every tooth; what is common to a trace is not known.
  const GearFigures a = setup.inspection.figures(truth),
                    b = setup.inspection.figures(
                        deviations_of(setup.job, setup.wheel, estimate.value, stroke, 17));
  for (std::size_t i = 0; i < a.teeth.size(); i += 5)
    EXPECT_NEAR(a.teeth[i][0].helix.slope, b.teeth[i][0].helix.slope, 10 * kFirstOrder);
}

TEST(EstimatePose, CorrectedPosesMakeTheGear) {
  // A grinder without errors of its own, whose wheel and gear are mounted askew: measure, correct, cut again.
  const GearSetup setup(test::helical_spec());
  const Machine askew = test::machine_of(test::gear_grinder(
      "EXt = 9\nEYt = -6\nEBt = 30\nEAt = -20\nEXw = 8\nEYw = -5\nEZw = 7\nEAw = 25\nEBw = -15\n"));
  const CuttingMotion motion = std::get<CuttingMotion>(plan_cutting(askew, setup.job, setup.wheel, 9, {}));
  CutOptions options;
  const auto first = std::get<MachineCut>(cut_on_machine(askew, setup.job, setup.wheel, motion, options));
  const PoseEstimate estimate =
      estimate_pose(setup.job, setup.wheel, measured(setup, first.deviations, {1, 12, 20, 31}), 0);
  EXPECT_LT(estimate.rms_after, 1e-5);
  const PoseChange change = [&](std::size_t gap, double height, const TipAndAxis& nominal) {
    return pose_corrected_for(setup.job, setup.wheel, estimate.value, gap, height, nominal);
  };
  const CuttingMotion corrected =
      std::get<CuttingMotion>(plan_cutting(askew, setup.job, setup.wheel, 9, {}, change));
  options.sent = &corrected.commands;
  const auto second = std::get<MachineCut>(cut_on_machine(askew, setup.job, setup.wheel, motion, options));
  const WheelDeviations none(motion.stroke.low, motion.stroke.high, 9, 41);
  EXPECT_GT(largest_of(setup, first.deviations, none), 10 * um);
  EXPECT_LT(largest_of(setup, second.deviations, none), 0.05 * um);
}

const SensitivityRow& row_of(const std::vector<SensitivityRow>& rows, const std::string& name) {
  for (const SensitivityRow& row : rows)
    if (row.name == name) return row;
  ADD_FAILURE() << name;
  return rows.front();
}

TEST(Sensitivity, RowsAreTheClosedForms) {
  const GearSetup setup(test::seed_spec());
  const auto rows = pose_sensitivity(setup.job, setup.wheel, setup.inspection, {10 * um, 10 * urad});
  ASSERT_EQ(rows.size(), 24U);
  const double phi = setup.job.gear.transverse_angle + setup.job.gear.half_gap, length = 90;
  // The wheel further out: profile slope of both flanks, depth; nothing differs from tooth to tooth.
  const GearEffects& x = row_of(rows, "wheel_static_x").effects;
  EXPECT_NEAR(x.depth, 10 * um, kNothing);
  EXPECT_NEAR(x.profile_slope[0].mean, x.profile_slope[1].mean, kNothing);
  EXPECT_NEAR(x.profile_slope[0].mean, 1.13 * um, 0.02 * um);
  EXPECT_NEAR(x.F_p, 0, kNothing);
  // Sideways: profile slopes of opposite senses. The table's numbers end to end, +0.4544 um, over 95 % of it.
  const GearEffects& y = row_of(rows, "wheel_static_y").effects;
  EXPECT_NEAR(y.profile_slope[0].mean, 0.95 * 0.4544 * um, 0.02 * um);
  EXPECT_NEAR(y.profile_slope[1].mean, -y.profile_slope[0].mean, kNothing);
  // Along the stroke: helix slopes, 10 um over half the face.
  EXPECT_NEAR(row_of(rows, "wheel_motion_x").effects.helix_slope[0].mean, 0.2 * um * length * std::sin(phi),
              kNothing);
  EXPECT_NEAR(row_of(rows, "wheel_motion_y").effects.helix_slope[0].mean, -0.2 * um * length * std::cos(phi),
              kNothing);
  EXPECT_NEAR(row_of(rows, "wheel_motion_y").effects.helix_slope[1].mean, 0.2 * um * length * std::cos(phi),
              kNothing);
  // The gear off its centre: pitch, runout. Turned about its axis: nothing but the position of all teeth.
  const GearEffects& centre = row_of(rows, "gear_static_x").effects;
  EXPECT_NEAR(centre.F_r, 20 * um, 0.02 * um);
  EXPECT_NEAR(centre.F_p, 21.2836 * um, 0.02 * um);
  EXPECT_NEAR(centre.depth, 0, kFirstOrder);
  const GearEffects& turned = row_of(rows, "gear_static_c").effects;
  EXPECT_NEAR(turned.F_p, 0, kNothing);
  EXPECT_NEAR(turned.F_r, 0, kNothing);
  EXPECT_NEAR(turned.profile_slope[0].mean, 0, kNothing);
  // The gear tilted: helix slopes that go round with the teeth.
  const GearEffects& tilted = row_of(rows, "gear_static_a").effects;
  EXPECT_NEAR(tilted.helix_slope[0].mean, 0, kFirstOrder);
  EXPECT_NEAR(tilted.helix_slope[0].range, 2 * 10 * urad * length, 0.005 * um);
}

TEST(Sensitivity, MachineErrorsMakeWhatTheirPosesMake) {
  GearSetup setup(test::seed_spec());
  EvaluationSpec few;
  few.profile_samples = few.helix_samples = 11;
  setup.inspection = *GearInspection::make(setup.job.gear, setup.wheel, few);
  const Machine machine = test::machine_of(test::gear_mill());
  const CuttingMotion motion = std::get<CuttingMotion>(plan_cutting(machine, setup.job, setup.wheel, 5, {}));
  const SensitivityUnits units{10 * um, 10 * urad};
  const auto rows = machine_sensitivity(machine, setup.job, setup.wheel, motion, setup.inspection, units);
  const auto poses = pose_sensitivity(setup.job, setup.wheel, setup.inspection, units);
  EXPECT_NEAR(row_of(rows, "EXX").effects.profile_slope[0].mean,
              row_of(poses, "wheel_static_x").effects.profile_slope[0].mean, kNothing);
  EXPECT_NEAR(row_of(rows, "EXw").effects.F_p, row_of(poses, "gear_static_x").effects.F_p, kNothing);
  // Constant errors of the table: the same in every gap, as seen from the bed.
  EXPECT_NEAR(row_of(rows, "EZX").effects.F_p, 0, kNothing);
  // A tilt of the column's guideway towards y makes the carriage lean: helix slope by the squareness alone.
  const auto budget =
      error_budget(test::machine_of(test::gear_mill("EXX = 10\nEYZ = { poly = [0, 0.02] }\n")), setup.job,
                   setup.wheel, motion, setup.inspection, {});
  ASSERT_EQ(budget.size(), 2U);
  EXPECT_NEAR(budget[0].effects.depth, 10 * um, kNothing);
  EXPECT_NEAR(budget[1].effects.depth, 0, kNothing);
  EXPECT_GT(std::abs(budget[1].effects.helix_slope[0].mean), 1 * um);
}

}  // namespace
}  // namespace abbe
