#include "abbe/chain/correct.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "abbe/chain/effect.h"
#include "abbe/chain/inverse.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_grinder.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

Machine machine_of(const std::string& text) {
  const Parsed<Machine> parsed = read_machine(
      {"test.toml", text}, std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  for (const Diagnostic& d : parsed.diagnostics) {
    if (d.severity == Severity::error) ADD_FAILURE() << to_text(d);
  }
  return parsed.value.value_or(Machine{});
}

Plan plan_of(const Machine& machine, ErrorModel model = ErrorModel::rigid) {
  return std::get<Plan>(make_plan(machine, {}, model));
}

Query at(const Machine& machine, const std::map<std::string, double>& q) {
  Query query;
  query.tool = tool_of(machine);
  for (const auto& [name, value] : q) query.q.at(static_cast<std::size_t>(machine.find_axis(name))) = value;
  return query;
}

double of(const Machine& machine, const std::array<double, kMaxAxes>& q, const char* name) {
  return q.at(static_cast<std::size_t>(machine.find_axis(name)));
}

AxisSet set_of(const Machine& machine, const char* name) { return AxisSet{1} << machine.find_axis(name); }

/// A case of the grinder by name; its commands in mm and rad.
struct InverseCase {
  explicit InverseCase(const grinder::Case& from)
      : text(grinder::text(from.errors, from.scale)),
        position(from.pose[0], from.pose[1], from.pose[2]),
        direction(from.pose[3], from.pose[4], from.pose[5]),
        x(from.ideal[0]),
        y(from.ideal[1]),
        z(from.ideal[2]),
        a(from.ideal[3]),
        c(from.ideal[4]),
        xe(from.exact[0]),
        ye(from.exact[1]),
        ze(from.exact[2]),
        ae(from.exact[3]),
        ce(from.exact[4]) {}

  std::string text;
  Vec3 position, direction;
  double x, y, z, a, c;       ///< ideal
  double xe, ye, ze, ae, ce;  ///< that put the real tool there
};

TEST(Correct, EqualsTheExactInverseOfTheGrinder) {
  for (const grinder::Case& entry : grinder::kCases) {
    const InverseCase c(entry);
    if (std::abs(c.ce - c.c) > 0.5 * deg) continue;  // so close to the pole C is held
    SCOPED_TRACE(c.a);
    const Machine machine = machine_of(c.text);
    const Query query = at(machine, {{"X", c.x}, {"Y", c.y}, {"Z", c.z}, {"A", c.a}, {"C", c.c}});
    const Correction r = correct(plan_of(machine), query, *free_axes(machine, 0), {});
    EXPECT_EQ(r.status, Status::ok);
    EXPECT_NEAR(of(machine, r.corrected, "X"), c.xe, 2e-10);
    EXPECT_NEAR(of(machine, r.corrected, "Y"), c.ye, 2e-10);
    EXPECT_NEAR(of(machine, r.corrected, "Z"), c.ze, 2e-10);
    EXPECT_NEAR(of(machine, r.corrected, "A"), c.ae, 1e-12);
    EXPECT_NEAR(of(machine, r.corrected, "C"), c.ce, 2e-12);
  }
}

TEST(Inverse, FindsTheCommandsOfAPose) {
  for (const grinder::Case& entry : grinder::kCases) {
    const InverseCase c(entry);
    if (std::abs(c.ce - c.c) > 0.5 * deg) continue;  // so close to the pole C is held
    SCOPED_TRACE(c.a);
    const Machine machine = machine_of(c.text);
    const AxisSet free = *free_axes(machine, 0);
    const Plan plan = plan_of(machine);
    // From afar, but nearer to this branch than to the other one.
    const Query start = at(machine, {{"A", c.a > 0 ? 0.4 : -0.4}, {"C", c.c + 0.3}});
    InverseOptions ideal;
    ideal.ideal = true;
    const InverseResult nominal =
        inverse(plan, start.tool, c.position, c.direction * 3, start.q, free, ideal);
    EXPECT_EQ(nominal.status, Status::ok);
    EXPECT_EQ(nominal.branch, 0);
    EXPECT_NEAR(of(machine, nominal.q, "Y"), c.y, 1e-8);
    EXPECT_NEAR(of(machine, nominal.q, "A"), c.a, 1e-11);
    EXPECT_NEAR(of(machine, nominal.q, "C"), c.c, 1e-9);
    EXPECT_LE(nominal.residual_position, 1e-9);
    const InverseResult real = inverse(plan, start.tool, c.position, c.direction, start.q, free, {});
    EXPECT_EQ(real.status, Status::ok);
    EXPECT_NEAR(of(machine, real.q, "X"), c.xe, 1e-8);
    EXPECT_NEAR(of(machine, real.q, "Z"), c.ze, 1e-8);
    EXPECT_NEAR(of(machine, real.q, "C"), c.ce, 1e-9);
    EXPECT_LE(real.residual_position, 1e-8);
    EXPECT_LE(real.residual_direction, 1e-10);
  }
}

TEST(Inverse, TakesTheBranchAndTheTurnWithinTheTravels) {
  const InverseCase c(grinder::kCases[0]);
  Machine machine = machine_of(c.text);
  const AxisSet free = *free_axes(machine, 0);
  Query start = at(machine, {{"A", 0.4}, {"C", c.c + 4 * M_PI + 0.1}});
  const auto solve = [&] {
    return inverse(plan_of(machine), start.tool, c.position, c.direction, start.q, free, {});
  };
  // Rotary axes are unwrapped to the start.
  EXPECT_NEAR(of(machine, solve().q, "C"), c.ce + 4 * M_PI, 1e-9);
  // A may not go positive: the other branch, half a turn of C away.
  machine.bodies
      .at(static_cast<std::size_t>(machine.axes.at(static_cast<std::size_t>(machine.find_axis("A")))))
      .range = {-2, 0.1};
  const InverseResult other = solve();
  EXPECT_EQ(other.status, Status::ok);
  EXPECT_EQ(other.branch, 1);
  EXPECT_NEAR(of(machine, other.q, "A"), -c.ae, 1e-3);
  EXPECT_LE(other.residual_position, 1e-8);
  // Nothing fits: failed, with finite numbers.
  machine.bodies
      .at(static_cast<std::size_t>(machine.axes.at(static_cast<std::size_t>(machine.find_axis("A")))))
      .range = {-0.1, 0.1};
  EXPECT_EQ(solve().status, Status::failed);
}

TEST(Inverse, UnreachableDirectionFails) {
  const Machine machine =
      machine_of("format = 1\n[machine]\nname = \"three\"\nchain = \"w b X Y Z t\"\n[errors]\nEXX = 5\n");
  const Query start = at(machine, {});
  const auto solve = [&](const Vec3& direction) {
    return inverse(plan_of(machine), start.tool, Vec3(1, 2, 3), direction, start.q, 7, {});
  };
  EXPECT_EQ(solve(Vec3::UnitZ()).status, Status::ok);
  EXPECT_NEAR(solve(Vec3::UnitZ()).q[0], 1 - 0.005, 1e-9);
  const InverseResult tilted = solve(Vec3(0.1, 0, 1));
  EXPECT_EQ(tilted.status, Status::failed);
  EXPECT_NEAR(tilted.residual_direction, std::atan(0.1), 1e-9);
  EXPECT_EQ(solve(Vec3::Zero()).status, Status::failed);
}

TEST(Correct, HoldsAnAxisNearASingularity) {
  const Machine machine = machine_of(grinder::text(0));
  const Plan plan = plan_of(machine);
  const AxisSet free = *free_axes(machine, 0);
  // The tool is parallel to C: C cannot turn it, A does what it can, the position is restored.
  for (const double tilt : {0.0, 1e-9, 1e-6, 1e-5, 1e-4, 1e-3}) {
    SCOPED_TRACE(tilt);
    const Query query = at(machine, {{"X", 30}, {"Y", -12}, {"Z", 48}, {"A", tilt}, {"C", 0.4}});
    const Correction r = correct(plan, query, free, {});
    EXPECT_EQ(r.status, Status::degraded);
    EXPECT_EQ(r.held, set_of(machine, "C"));
    EXPECT_EQ(of(machine, r.corrected, "C"), 0.4);
    EXPECT_LE(r.residual_position, 1e-9);
    EXPECT_GT(r.residual_direction, 1e-6);
    EXPECT_LT(r.residual_direction, 4e-5);
    Query there = query;
    there.q = r.corrected;
    EXPECT_LE((actual_tip(plan, there) - nominal_tip(plan, query)).norm(), 1e-9);
  }
  // 0.1 deg of tilt needs 1.06 deg of C: 50-digit solution of seed 003.
  const Query steep = at(machine, {{"X", 70.63758073198403},
                                   {"Y", -12.41739978905653},
                                   {"Z", 48.74969538265754},
                                   {"A", 0.0017453292519943296},
                                   {"C", -1.9198621771937625}});
  EXPECT_EQ(correct(plan, steep, free, {}).status, Status::degraded);
  CorrectOptions wide;
  wide.max_rotary_correction = 2 * deg;
  const Correction r = correct(plan, steep, free, wide);
  EXPECT_EQ(r.status, Status::ok);
  EXPECT_NEAR(of(machine, r.corrected, "C"), -1.938441226353178, 1e-10);
  EXPECT_NEAR(of(machine, r.corrected, "Y"), -11.129324840045498, 1e-8);
}

constexpr const char* kThreeAxes = R"(format = 1
[machine]
name = "three"
chain = "w b X Y Z t"
[axis.X]
range = [-100, 100]
[tool]
length = 100
[errors]
EXX = -20
EBX = { poly = [0, 0.5] }
EYY = 8
EZZ = 5
)";

TEST(Correct, ThreeAxesAreOkThoughTheDirectionStays) {
  const Machine machine = machine_of(kThreeAxes);
  const Correction r = correct(plan_of(machine), at(machine, {{"X", 60}}), *free_axes(machine, 0), {});
  EXPECT_EQ(r.status, Status::ok);
  EXPECT_LE(r.residual_position, 1e-9);
  EXPECT_NEAR(r.residual_direction, 30.0115e-6, 1e-10);  // EBX = 0.5 urad/mm at X = 60.023
  // d = (-0.020, 0, 0) and e x (0, 0, -100) = (-0.003, 0, 0): X goes the other way.
  EXPECT_NEAR(r.corrected[0], 60 + 0.020 + 0.003, 2e-6);
  EXPECT_NEAR(r.corrected[1], -0.008, 1e-9);
}

TEST(Correct, StopsAtTheEndOfTheTravel) {
  const Machine machine = machine_of(kThreeAxes);
  const Correction r = correct(plan_of(machine), at(machine, {{"X", 99.99}}), *free_axes(machine, 0), {});
  EXPECT_EQ(r.status, Status::degraded);
  EXPECT_EQ(r.held, set_of(machine, "X"));
  EXPECT_EQ(r.corrected[0], 100);
  EXPECT_NEAR(r.corrected[1], -0.008, 1e-9);
  EXPECT_NEAR(r.residual_position, 0.020 + 0.005 - 0.010, 1e-6);
  CorrectOptions one_step;
  one_step.method = Method::one_step;
  const Correction s =
      correct(plan_of(machine), at(machine, {{"X", 99.99}}), *free_axes(machine, 0), one_step);
  EXPECT_EQ(s.status, Status::degraded);
  EXPECT_EQ(s.corrected[0], 100);
  EXPECT_NEAR(s.residual_position, r.residual_position, 1e-5);
}

TEST(Correct, MissingOrLockedAxesLeaveAPartOfThePosition) {
  const Machine machine = machine_of(kThreeAxes);
  const Query query = at(machine, {{"X", 10}});
  CorrectOptions options;
  options.locked = set_of(machine, "Z");
  const Correction r = correct(plan_of(machine), query, *free_axes(machine, 0), options);
  EXPECT_EQ(r.status, Status::partial);
  EXPECT_EQ(r.corrected[2], 0);
  EXPECT_NEAR(r.residual_position, 0.005, 1e-6);
  EXPECT_NEAR(r.corrected[1], -0.008, 1e-9);
  const Correction none = correct(plan_of(machine), query, 0, {});
  EXPECT_EQ(none.status, Status::partial);
  EXPECT_EQ(none.corrected, query.q);
}

TEST(Correct, TheTargetMayBeShifted) {
  const Machine machine = machine_of(kThreeAxes);
  const Query query = at(machine, {{"X", 10}});
  for (const Method method : {Method::newton, Method::one_step}) {
    CorrectOptions options;
    options.method = method;
    options.target_shift = Vec3(0.1, -0.2, 0.3);
    const Correction r = correct(plan_of(machine), query, 7, options);
    EXPECT_EQ(r.status, Status::ok);
    Query there = query;
    there.q = r.corrected;
    const Vec3 moved = actual_tip(plan_of(machine), there) - nominal_tip(plan_of(machine), query);
    EXPECT_LE((moved - options.target_shift).norm(), method == Method::newton ? 1e-9 : 1e-4);
  }
}

TEST(Correct, RedundantAxesTakeTheSmallestWeightedStep) {
  // Two parallel Z axes: the error of 10 um is shared 4 : 1 by weights 1 and 2.
  const Machine machine =
      machine_of("format = 1\n[machine]\nname = \"two\"\nchain = \"w b X Y Z Z1 t\"\n[errors]\nEZZ = 10\n");
  CorrectOptions options;
  options.weights.at(static_cast<std::size_t>(machine.find_axis("Z1"))) = 2;
  const Correction r = correct(plan_of(machine), at(machine, {}), 0xF, options);
  EXPECT_EQ(r.status, Status::ok);
  EXPECT_NEAR(of(machine, r.corrected, "Z"), -0.008, 1e-9);
  EXPECT_NEAR(of(machine, r.corrected, "Z1"), -0.002, 1e-9);
}

TEST(FreeAxes, LocksDigitsThenUVW) {
  const auto free = [](const std::string& chain, AxisSet locked = 0) {
    std::string text = "format = 1\n[machine]\nname = \"m\"\nchain = \"" + chain + "\"\n";
    const Machine machine = machine_of(text);
    const std::optional<AxisSet> set = free_axes(machine, locked);
    if (!set) return std::string("ambiguous");
    std::string names;
    for (int i = 0; i < machine.axis_count(); ++i) {
      if ((*set >> i & 1u) != 0) names += machine.axis(i).name + " ";
    }
    return names;
  };
  EXPECT_EQ(free("w b X Y Z t"), "X Y Z ");
  EXPECT_EQ(free("w b X Y Z A B Z1 t"), "X Y Z A B ");
  EXPECT_EQ(free("w b X Y Z W t"), "X Y Z ");
  EXPECT_EQ(free("w b X Y Z1 t"), "X Y Z1 ");
  EXPECT_EQ(free("w b X Y Z A B B1 t"), "X Y Z A B ");
  EXPECT_EQ(free("w b X Y Z A B C t"), "ambiguous");
  EXPECT_EQ(free("w b X Y Z A B C t", 1u << 5), "X Y Z A B ");
}

TEST(Effect, NamesErrorsThatDoNothing) {
  const Machine machine = machine_of(R"(format = 1
[machine]
name = "effect"
chain = "w b X Y Z C S t"
[axis.C]
origin = [0, 0, 0]
[tool]
length = 100
[errors]
EXX = 1
ECX = 1
ECY = 1
ECZ = 1
ECS = 1
ECt = 1
EZ0C = 1
EC0X = 1
EA0X = 1
EX0X = 1
EX0C = 0
)");
  // The tool is on its own axis over C: ECZ, ECS and ECt turn it about itself, ECX turns the carriers of
  // Y and Z, ECY those of Z. EX0C is zero in the file but would act,
  // and EA0X tilts what X carries.
  const std::vector<std::string> idle = errors_without_effect(machine);
  EXPECT_EQ(idle, (std::vector<std::string>{"ECY", "ECZ", "ECS", "ECt"}));
}

TEST(Plan, AsksForSensorsAndFreezesThem) {
  const Machine machine = machine_of(R"(format = 1
[machine]
name = "warm"
chain = "w b X Y Z t"
[errors]
TXX = { poly = [0, 2.5], of = "T1", reference = 20 }
EYX = { poly = [0, 1e-3], times = { poly = [0, 1], of = "T1" } }
DZX = { poly = [0, 0.5], of = "v.X" }
)");
  const auto missing = make_plan(machine, {});
  ASSERT_TRUE(std::holds_alternative<MissingSensors>(missing));
  EXPECT_EQ(std::get<MissingSensors>(missing).names, std::vector<std::string>{"T1"});
  const Plan plan = std::get<Plan>(make_plan(machine, {{"T1", 24.0}, {"v.X", 2.0}, {"unused", 1.0}}));
  Query query = at(machine, {{"X", 100}});
  // 2.5 (24 - 20), 1e-3 * 100 * 24, 0.5 * 2 um
  EXPECT_LE((predict(plan, query).deviation.position - Vec3(0.010, 0.0024, 0.001)).norm(), 1e-13);
  const double velocity[] = {6.0, 0.0, 0.0};
  query.velocity = velocity;
  EXPECT_NEAR(predict(plan, query).deviation.position.z(), 0.003, 1e-13);
  EXPECT_NEAR(actual_tip(plan, query).z(), 0.003, 1e-13);
}

TEST(Predict, NamesExtrapolatedErrors) {
  const Machine machine = machine_of(R"(format = 1
[machine]
name = "ends"
chain = "w b X C Z t"
[axis.C]
origin = [0, 0, 0]
[errors]
EXX = { table = [[0, 1], [100, 2]] }
EZC = { table = [[-30, 1], [30, 2]] }
EYX = { poly = [0, 1], domain = [0, 100] }
)");
  const Plan plan = plan_of(machine);
  const auto names = [&](double x, double c) {
    return predict(plan, at(machine, {{"X", x}, {"C", c * deg}})).extrapolated;
  };
  EXPECT_EQ(names(100, 30), std::vector<std::string>{});
  EXPECT_EQ(names(0, -30), std::vector<std::string>{});
  EXPECT_EQ(names(100.001, 0), (std::vector<std::string>{"EXX", "EYX"}));
  EXPECT_EQ(names(50, 30.001), std::vector<std::string>{"EZC"});
  bool outside = false;
  static_cast<void>(actual_tip(plan, at(machine, {{"X", 100}, {"C", 30 * deg}}), &outside));
  EXPECT_FALSE(outside);
  static_cast<void>(actual_tip(plan, at(machine, {{"X", -0.1}}), &outside));
  EXPECT_TRUE(outside);
}

/// A quill that tilts: at 90 deg Y and Z move the tip along one line, and X is far from the third direction.
TEST(Correct, NearlyDependentLinearAxesAreNotSentFar) {
  const Parsed<Machine> quill = read_machine(
      {"quill.toml",
       "format = 1\n[machine]\nname = \"quill\"\nchain = \"w X Y b A Z t\"\n[axis.X]\nrange = [-300, 300]\n"
       "errors_seen = \"tool\"\n[axis.Y]\nrange = [-300, 300]\nerrors_seen = \"tool\"\n[axis.Z]\nrange = "
       "[-200, "
       "200]\n[tool]\nlength = 100\n[errors]\nEYY = 5\nEZX = 12\nEAA = 10\n"},
      std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  ASSERT_TRUE(quill.value.has_value());
  const Plan plan = std::get<Plan>(make_plan(*quill.value, {}));
  const auto axis = [&](const char* name) { return static_cast<std::size_t>(quill.value->find_axis(name)); };
  const AxisSet free = free_axes(*quill.value, 0).value();
  for (const Method method : {Method::newton, Method::closed_form, Method::one_step}) {
    for (const double angle : {60.0, 89.0, 89.5, 89.9, 89.99, 89.999, 90.0, 90.001, 91.0}) {
      Query query;
      query.tool = tool_of(*quill.value);
      query.q[axis("X")] = 50;
      query.q[axis("Y")] = 20;
      query.q[axis("Z")] = 10;
      query.q[axis("A")] = angle * deg;
      CorrectOptions options;
      options.method = method;
      const Correction c = correct(plan, query, free, options);
      EXPECT_NE(c.status, Status::failed) << angle;
      EXPECT_EQ(c.status == Status::ok, std::abs(angle - 90) > 0.6) << angle;
      EXPECT_LE(c.residual_position, 0.014) << angle;
      for (const char* name : {"X", "Y", "Z"})
        EXPECT_LE(std::abs(c.corrected[axis(name)] - query.q[axis(name)]), 1.5) << name << " at " << angle;
    }
  }
}

}  // namespace
}  // namespace abbe
