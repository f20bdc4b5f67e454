#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "abbe/chain/correct.h"
#include "abbe/chain/inverse.h"
#include "abbe/chain/predict.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

using nlohmann::json;

constexpr double kExactLength = 1e-9;  // mm: rigid and linear against independent numbers
constexpr double kExactAxis = 1e-12;   // of a unit vector
constexpr double kFirstOrder = 1e-10;  // mm

std::string golden_folder() { return std::string(ABBE_SOURCE_DIR) + "/../shared/golden/"; }

std::optional<json> golden(const std::string& name) {
  std::ifstream in(golden_folder() + name);
  if (!in) return std::nullopt;
  return json::parse(in);
}

Machine machine_at(const std::string& path) {
  Parsed<Machine> parsed = read_machine_file(golden_folder() + path);
  for (const Diagnostic& d : parsed.diagnostics) {
    if (d.severity == Severity::error) ADD_FAILURE() << to_text(d);
  }
  return parsed.value.value_or(Machine{});
}

Plan plan_of(const Machine& machine, ErrorModel model, const Environment& environment = {}) {
  auto made = make_plan(machine, environment, model);
  if (const auto* missing = std::get_if<MissingSensors>(&made)) {
    ADD_FAILURE() << "missing sensor " << missing->names.front();
    return std::get<Plan>(make_plan(Machine{}, {}, model));
  }
  return std::get<Plan>(made);
}

Vec3 vec(const json& j, std::size_t first = 0) {
  return {j.at(first).get<double>(), j.at(first + 1).get<double>(), j.at(first + 2).get<double>()};
}

#define EXPECT_VEC_NEAR(a, b, tolerance) \
  EXPECT_LE(((a) - (b)).cwiseAbs().maxCoeff(), tolerance) << (a).transpose() << " vs " << (b).transpose()

#define GOLDEN_OR_SKIP(name)                     \
  const std::optional<json> file = golden(name); \
  if (!file) GTEST_SKIP() << "no golden numbers beside the source folder"

/// Positions by axis name, in internal units.
Query at(const Machine& machine, const std::map<std::string, double>& q) {
  Query query;
  query.tool = tool_of(machine);
  for (const auto& [name, value] : q) query.q.at(static_cast<std::size_t>(machine.find_axis(name))) = value;
  return query;
}

TEST(Golden, EveryCaseOfTheContractInThreeModels) {
  GOLDEN_OR_SKIP("contract/cases.json");
  double worst_first_order = 0;
  for (const json& c : file->at("cases")) {
    SCOPED_TRACE(c.at("machine").get<std::string>() + " " + c.at("q").dump());
    const Machine machine = machine_at(c.at("machine"));
    Environment environment;
    for (const auto& [name, value] : c.at("set").items()) environment[name] = value;
    Query query;
    query.tool = tool_of(machine);
    for (const auto& [name, value] : c.at("q").items()) {
      const int i = machine.find_axis(name);
      query.q.at(static_cast<std::size_t>(i)) = value.get<double>() * machine.axis_unit(i);
    }
    for (const auto& [name, value] : c.at("approach").items()) {
      query.approach.at(static_cast<std::size_t>(machine.find_axis(name))) =
          static_cast<signed char>(value.get<int>());
    }
    for (const auto model : {ErrorModel::rigid, ErrorModel::linear}) {
      const json& expected = c.at(model == ErrorModel::rigid ? "rigid" : "linear");
      const Plan plan = plan_of(machine, model, environment);
      const Prediction p = predict(plan, query);
      EXPECT_VEC_NEAR(p.nominal.position, vec(c.at("nominal").at("position_mm")), kExactLength);
      EXPECT_VEC_NEAR(p.nominal.tool_axis, vec(c.at("nominal").at("tool_axis")), kExactAxis);
      EXPECT_VEC_NEAR(p.actual.position, vec(expected.at("position_mm")), kExactLength);
      EXPECT_VEC_NEAR(p.actual.tool_axis, vec(expected.at("tool_axis")), kExactAxis);
      EXPECT_VEC_NEAR(actual_tip(plan, query), vec(expected.at("position_mm")), kExactLength);
    }
    const Prediction p = predict(plan_of(machine, ErrorModel::first_order, environment), query);
    const Vec3 d = vec(c.at("first-order").at("deviation_position_mm")),
               a = vec(c.at("first-order").at("deviation_tool_axis"));
    EXPECT_VEC_NEAR(p.deviation.position, d, kFirstOrder);
    EXPECT_VEC_NEAR(p.deviation.tool_axis, a, kExactAxis);
    worst_first_order = std::max(worst_first_order, (p.deviation.position - d).cwiseAbs().maxCoeff());
  }
  RecordProperty("worst_first_order_mm", std::to_string(worst_first_order));
}

TEST(Golden, SevenAxisMachineOfSeed000) {
  GOLDEN_OR_SKIP("seed000_mbs.json");
  const json& g = *file;
  for (const bool after : {true, false}) {
    const Machine machine = machine_at(after ? "machines/seed000-seven-axis-after.toml"
                                             : "machines/seed000-seven-axis-frame.toml");
    const json& c = g.at("config");
    const Query query = at(machine, {{"X", c.at("x")},
                                     {"Y", c.at("y")},
                                     {"Z", c.at("z")},
                                     {"Z1", c.at("z1")},
                                     {"A", c.at("alpha_deg").get<double>() * deg},
                                     {"B", c.at("beta_deg").get<double>() * deg},
                                     {"B1", c.at("beta1_deg").get<double>() * deg}});
    const auto check = [&](ErrorModel model, const json& expected, double length, double axis) {
      const Prediction p = predict(plan_of(machine, model), query);
      EXPECT_VEC_NEAR(p.nominal.position, vec(g.at("ideal").at("P_w_i")), 1e-12 * 1000);
      EXPECT_VEC_NEAR(p.deviation.position, vec(expected.at("delta_w")), length);
      EXPECT_VEC_NEAR(p.deviation.tool_axis, vec(expected.at("dtheta_w")), axis);
    };
    check(ErrorModel::first_order,
          g.at(after ? "first_order_paper_order" : "first_order_setup_before_motion"), 1e-12, 1e-16);
    check(ErrorModel::linear, g.at(after ? "paper_linear_matrices" : "paper_linear_setup_before_motion"),
          1e-9, 1e-12);
    // The golden adds squareness as a translation: second order apart in the rigid model.
    check(ErrorModel::rigid, g.at(after ? "rigid_exp_paper_order" : "rigid_exp_setup_before_motion"), 3e-7,
          1e-12);
  }
}

TEST(Golden, ThreeAxisMachineOfSeed001) {
  GOLDEN_OR_SKIP("seed001_xfyz.json");
  const std::map<std::string, std::string> orders = {{"literal", "after"}, {"pre", "frame"}, {"dir", "line"}};
  for (const json& c : file->at("cases")) {
    const Vec3 offset = vec(c.at("tool_offset"));
    const std::string name = "machines/seed001-xfyz-" + orders.at(c.at("squareness_mode")) +
                             (offset.norm() > 0 ? "-tool-offset" : "") + ".toml";
    SCOPED_TRACE(name);
    const Machine machine = machine_at(name);
    const Query query =
        at(machine, {{"X", file->at("q")[0]}, {"Y", file->at("q")[1]}, {"Z", file->at("q")[2]}});
    const bool literal = c.at("squareness_mode") == "literal";
    const auto deviation = [&](ErrorModel model) {
      return predict(plan_of(machine, model), query).deviation.position;
    };
    EXPECT_VEC_NEAR(deviation(ErrorModel::first_order), vec(c.at("Pe_first_order")), 1e-12);
    // literal adds the squareness to the angles of one matrix, dir as a translation: second order apart.
    EXPECT_VEC_NEAR(deviation(ErrorModel::linear), vec(c.at("Pe_exact_linear_matrices")),
                    literal ? 3e-7 : 1e-12);
    EXPECT_VEC_NEAR(deviation(ErrorModel::rigid), vec(c.at("Pe_exact_rigid_exp")), 3e-7);

    const Plan plan = plan_of(machine, ErrorModel::rigid);
    CorrectOptions one_step;
    one_step.method = Method::one_step;
    const Correction step = correct(plan, query, 7, one_step);
    EXPECT_VEC_NEAR(Vec3(step.corrected[0], step.corrected[1], step.corrected[2]),
                    vec(c.at("compensation")[1].at("q")), 1e-12);
    EXPECT_NEAR(step.residual_position, c.at("compensation")[1].at("norm").get<double>(), 3e-7);
    const Correction corrected = correct(plan, query, *free_axes(machine, 0), {});
    EXPECT_EQ(corrected.status, Status::ok);
    const Vec3 expected = vec(c.at("compensation").back().at("q"));
    EXPECT_VEC_NEAR(Vec3(corrected.corrected[0], corrected.corrected[1], corrected.corrected[2]), expected,
                    3e-7);
  }
}

TEST(Golden, GearMillOfSeed002) {
  GOLDEN_OR_SKIP("seed002_gearmill.json");
  const Machine machine = machine_at("machines/seed002-gear-mill.toml");
  const json& c = file->at("config");
  const Query query =
      at(machine, {{"X", c.at("x")}, {"Z", c.at("z")}, {"C", c.at("r_deg").get<double>() * deg}});
  const auto check = [&](ErrorModel model, const json& g, double length, double angle) {
    const Twist t = predict(plan_of(machine, model), query).tool_twist;
    EXPECT_VEC_NEAR(t.d, Vec3(g.at("dx"), g.at("dy"), g.at("dz")), length);
    EXPECT_VEC_NEAR(t.e, Vec3(g.at("thx"), g.at("thy"), g.at("thz")), angle);
  };
  check(ErrorModel::first_order, file->at("first_order_correct"), 1e-12, 1e-15);
  check(ErrorModel::linear, file->at("exact_linear_matrices"), 1e-9, 1e-12);
  check(ErrorModel::rigid, file->at("exact_rigid_exp"), 1e-9, 1e-12);
}

TEST(Golden, GearGrinderOfSeed003Forward) {
  GOLDEN_OR_SKIP("seed003_xyzac.json");
  const Machine machine = machine_at("machines/seed003-xyzac.toml");
  const json& f = file->at("forward_case");
  const Query query = at(machine, {{"X", f.at("q")[0]},
                                   {"Y", f.at("q")[1]},
                                   {"Z", f.at("q")[2]},
                                   {"A", f.at("q")[3]},
                                   {"C", f.at("q")[4]}});
  const Prediction rigid = predict(plan_of(machine, ErrorModel::rigid), query);
  EXPECT_VEC_NEAR(rigid.nominal.position, vec(f.at("pose_ideal")), 1e-11);
  EXPECT_VEC_NEAR(rigid.nominal.tool_axis, vec(f.at("pose_ideal"), 3), 1e-14);
  EXPECT_VEC_NEAR(rigid.actual.position, vec(f.at("pose_rigid_exp")), 1e-11);
  EXPECT_VEC_NEAR(rigid.actual.tool_axis, vec(f.at("pose_rigid_exp"), 3), 1e-14);
  const Prediction linear = predict(plan_of(machine, ErrorModel::linear), query);
  // The golden uses the printed inverse of one matrix.
  EXPECT_VEC_NEAR(linear.actual.position, vec(f.at("pose_linear_printed")), 2.7e-8);
}

/// "dXy(X)" -> EYX, "gaAY" -> EC0A, "alT" -> EAt: the patent's names, rotations alpha beta gamma.
ErrorName patent_name(const std::string& text) {
  const std::map<std::string, int> rotation = {{"al", 3}, {"be", 4}, {"ga", 5}};
  ErrorName name;
  const bool displacement = text[0] == 'd';
  const char axis = displacement ? text[1] : text[2];
  name.direction = displacement ? text[2] - 'x' : rotation.at(text.substr(0, 2));
  const bool mount = axis == 'T' || axis == 'W';
  name.axis = mount ? std::string(1, static_cast<char>(axis - 'A' + 'a')) : std::string(1, axis);
  name.error_class =
      mount || text.find('(') != std::string::npos ? ErrorClass::component : ErrorClass::location;
  return name;
}

TEST(Golden, GearGrinderOfSeed003Inverse) {
  GOLDEN_OR_SKIP("seed003_xyzac.json");
  for (const json& c : file->at("inverse_cases")) {
    SCOPED_TRACE(c.at("tag").get<std::string>() + " " + c.at("seed").dump());
    Machine machine = machine_at("machines/seed003-xyzac.toml");
    std::size_t found = 0;
    for (ErrorTerm& error : machine.errors) {
      for (const auto& [name, value] : c.at("errors").items()) {
        if (!(patent_name(name) == error.name)) continue;
        error.function = ErrorFunction::constant(value);
        ++found;
      }
    }
    EXPECT_EQ(found, machine.errors.size());
    const auto commands = [&](const json& q) {
      return at(machine, {{"X", q[0]}, {"Y", q[1]}, {"Z", q[2]}, {"A", q[3]}, {"C", q[4]}});
    };
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const Query ideal = commands(c.at("q_ideal")), exact = commands(c.at("q_exact_rigid"));
    EXPECT_VEC_NEAR(nominal_tip(plan, ideal), vec(c.at("cl")), 1e-12);
    EXPECT_VEC_NEAR(actual_tip(plan, exact), vec(c.at("cl")), 1e-12);
    CorrectOptions options;
    options.max_rotary_correction = 0.3;
    // Rounding of 1e-16 in the tool axis is 1e-16 / sin(A) in C, and 100 times that in X and Y.
    const double amplified = 1 / std::abs(std::sin(c.at("q_ideal")[3].get<double>()));
    for (const Method method : {Method::newton, Method::closed_form}) {
      options.method = method;
      const Correction corrected = correct(plan, ideal, *free_axes(machine, 0), options);
      EXPECT_EQ(corrected.status, Status::ok);
      // The closed form does not lose as much.
      const double loss = method == Method::newton ? amplified : std::max(1.0, 2e-4 * amplified);
      for (std::size_t i = 0; i < 5; ++i) {
        const bool rotary = machine.axis(static_cast<int>(i)).type == AxisType::rotary;
        EXPECT_NEAR(corrected.corrected[i], exact.q[i], (rotary ? 1e-12 : 1e-10) * loss);
      }
    }
    options.method = Method::printed;
    const Correction printed = correct(plan, ideal, *free_axes(machine, 0), options);
    const Query expected = commands(c.at("q_printed_closed_form"));
    const json& rest = c.at("residual_printed_on_rigid_model");
    for (std::size_t i = 0; i < 5; ++i) EXPECT_NEAR(printed.corrected[i], expected.q[i], 3e-12 * amplified);
    EXPECT_NEAR(printed.residual_position, rest[0], 1e-4 * rest[0].get<double>());
    EXPECT_NEAR(printed.residual_direction, rest[1], 1e-3 * rest[1].get<double>());
  }
}

TEST(Golden, SevenAxesLockedOrWeightedIterated) {
  GOLDEN_OR_SKIP("unified_checks.json");
  const Machine machine = machine_at("machines/seed000-seven-axis-after.toml");
  const Plan plan = plan_of(machine, ErrorModel::rigid);
  for (const json& g : file->at("seed000").at("compensation")) {
    SCOPED_TRACE(g.at("solver").get<std::string>());
    const bool all = g.at("active").size() == 7;
    std::map<std::string, double> q, expected;
    CorrectOptions options;
    for (std::size_t i = 0; i < g.at("axes").size(); ++i) {
      const std::string name = g.at("axes")[i];
      q[name] = g.at("steps")[0].at("q")[i];
      expected[name] = g.at("steps").back().at("q")[i];
      if (all)
        options.weights.at(static_cast<std::size_t>(machine.find_axis(name))) = g.at("weights").at(name);
    }
    const AxisSet free = all ? AxisSet{0x7F} : *free_axes(machine, 0);
    const Correction newton = correct(plan, at(machine, q), free, options);
    EXPECT_EQ(newton.status, Status::ok);
    EXPECT_LE(newton.residual_position, 1e-9);
    EXPECT_LE(newton.residual_direction, 1e-12);
    for (const auto& [name, value] : expected) {
      const int axis = machine.find_axis(name);
      const bool rotary = machine.axis(axis).type == AxisType::rotary;
      // The golden adds squareness as a translation: second order apart.
      EXPECT_NEAR(newton.corrected[static_cast<std::size_t>(axis)], value, rotary ? 1e-9 : 5e-7) << name;
    }
    options.method = Method::closed_form;
    const Correction closed = correct(plan, at(machine, q), free, options);
    if (all) {
      EXPECT_EQ(closed.status, Status::failed);
      continue;
    }
    EXPECT_EQ(closed.status, Status::ok);
    for (std::size_t i = 0; i < 7; ++i) EXPECT_NEAR(closed.corrected[i], newton.corrected[i], 1e-9);
  }
}

TEST(Golden, TwistsAndJacobiansOfTheUnifiedChecks) {
  GOLDEN_OR_SKIP("unified_checks.json");
  {
    const json& g = file->at("seed000");
    const Machine machine = machine_at("machines/seed000-seven-axis-after.toml");
    const std::vector<std::string> names = {"X", "Y", "Z", "A", "B", "Z1", "B1"};
    std::map<std::string, double> q;
    for (std::size_t i = 0; i < names.size(); ++i) q[names[i]] = g.at("q")[i];
    const Query query = at(machine, q);
    const Plan first = plan_of(machine, ErrorModel::first_order);
    const Twist twist = predict(first, query).tool_twist;
    EXPECT_VEC_NEAR(twist.d, vec(g.at("D_tool")), 1e-12);
    EXPECT_VEC_NEAR(twist.e, vec(g.at("D_tool"), 3), 1e-16);
    const Jacobian j = jacobian(first, query);
    const Mat3 r = nominal_pose(first, query).R;
    for (std::size_t i = 0; i < names.size(); ++i) {
      const int axis = machine.find_axis(names[i]);
      const Vec3 column(g.at("J_tool")[0][i], g.at("J_tool")[1][i], g.at("J_tool")[2][i]);
      EXPECT_VEC_NEAR((r.transpose() * j.position.col(axis)).eval(), column, 1e-11) << names[i];
      const Vec3 turn(g.at("J_tool")[3][i], g.at("J_tool")[4][i], g.at("J_tool")[5][i]);
      EXPECT_VEC_NEAR((r.transpose() * j.tool_axis.col(axis)).eval(), turn.cross(Vec3::UnitZ()).eval(), 1e-14)
          << names[i];
    }
    // One differential step with Z1 and B1 locked.
    CorrectOptions options;
    options.method = Method::one_step;
    const Correction step = correct(first, query, *free_axes(machine, 0), options);
    EXPECT_EQ(step.status, Status::ok);
    for (std::size_t i = 0; i < names.size(); ++i) {
      EXPECT_NEAR(step.corrected[static_cast<std::size_t>(machine.find_axis(names[i]))],
                  g.at("one_step").at("q")[i].get<double>(), 1e-12);
    }
  }
  {
    // All seven axes free, weights in mm and rad.
    const json& g = file->at("seed000").at("compensation").at(1);
    const Machine machine = machine_at("machines/seed000-seven-axis-after.toml");
    const Plan plan = plan_of(machine, ErrorModel::first_order);
    std::map<std::string, double> q, expected;
    CorrectOptions options;
    options.method = Method::one_step;
    for (std::size_t i = 0; i < g.at("axes").size(); ++i) {
      const std::string name = g.at("axes")[i];
      q[name] = g.at("steps")[0].at("q")[i];
      expected[name] = g.at("steps").back().at("q")[i];
      options.weights.at(static_cast<std::size_t>(machine.find_axis(name))) = g.at("weights").at(name);
    }
    const Correction step = correct(plan, at(machine, q), 0x7F, options);
    EXPECT_EQ(step.status, Status::ok);
    for (const auto& [name, value] : expected) {
      const int axis = machine.find_axis(name);
      const bool rotary = machine.axis(axis).type == AxisType::rotary;
      // One first-order step against the converged rigid solution.
      EXPECT_NEAR(step.corrected[static_cast<std::size_t>(axis)], value, rotary ? 3e-9 : 2e-6) << name;
    }
  }
  {
    const json& g = file->at("seed003");
    const Machine machine = machine_at("machines/seed003-xyzac.toml");
    const Query query = at(machine, {{"X", g.at("q")[0]},
                                     {"Y", g.at("q")[1]},
                                     {"Z", g.at("q")[2]},
                                     {"A", g.at("q")[3]},
                                     {"C", g.at("q")[4]}});
    const Prediction p = predict(plan_of(machine, ErrorModel::first_order), query);
    EXPECT_VEC_NEAR(p.tool_twist.d, vec(g.at("D_tool")), 1e-12);
    EXPECT_VEC_NEAR(p.tool_twist.e, vec(g.at("D_tool"), 3), 1e-16);
    EXPECT_VEC_NEAR(p.deviation.position, vec(g.at("delta_w")), 1e-12);
    EXPECT_VEC_NEAR(p.deviation.tool_axis, vec(g.at("dtheta_w")), 1e-16);
  }
}

}  // namespace
}  // namespace abbe
