#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/method_fit.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_grinder.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

using Commands = std::array<double, kMaxAxes>;

constexpr double kPosition = 1e-9;    // mm: the stop of the contract
constexpr double kDirection = 1e-12;  // rad

Machine machine_of(const std::string& text) {
  const Parsed<Machine> parsed = read_machine(
      {"test.toml", text}, std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  for (const Diagnostic& d : parsed.diagnostics) {
    if (d.severity == Severity::error) ADD_FAILURE() << to_text(d);
  }
  return parsed.value.value_or(Machine{});
}

Plan plan_of(const Machine& machine, ErrorModel model = ErrorModel::rigid) {
  return std::get<Plan>(make_plan(machine, {{"T1", 23}}, model));
}

/// Positions in the order X Y Z A C.
Query grinder_at(const Machine& machine, const std::array<double, 5>& q) {
  Query query;
  query.tool = tool_of(machine);
  const char* names[] = {"X", "Y", "Z", "A", "C"};
  for (std::size_t i = 0; i < 5; ++i)
    query.q.at(static_cast<std::size_t>(machine.find_axis(names[i]))) = q[i];
  return query;
}

CorrectOptions with(Method method, double max_rotary = 0.5 * deg) {
  CorrectOptions options;
  options.method = method;
  options.max_rotary_correction = max_rotary;
  return options;
}

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

/// Distance and tilt between where the corrected machine is and where the command wanted it.
struct Left {
  double position = 0, direction = 0;
};
Left left_of(const Plan& plan, const Query& query, const Commands& corrected) {
  Query there = query;
  there.q = corrected;
  const Pose nominal = nominal_pose(plan, query), actual = actual_pose(plan, there);
  return {(actual.p - nominal.p).norm(),
          angle_between(actual.R * query.tool.axis, nominal.R * query.tool.axis)};
}

TEST(ClosedForm, IsTheExactInverseOfTheGrinder) {
  for (const grinder::Case& c : grinder::kCases) {
    SCOPED_TRACE(testing::Message() << "A " << c.ideal[3] << " errors " << c.errors);
    const Machine machine = machine_of(grinder::text(c.errors, c.scale));
    const Query query = grinder_at(machine, c.ideal), exact = grinder_at(machine, c.exact);
    const Correction r =
        correct(plan_of(machine), query, *free_axes(machine, 0), with(Method::closed_form, 0.3));
    EXPECT_EQ(r.status, Status::ok);
    EXPECT_LE(r.iterations, 4);
    // A tool axis in double is exact to 1e-16; C follows it by 1 / sin A, X and Y follow C by 100 mm.
    const double amplified = std::max(1.0, 2e-4 / std::abs(std::sin(c.ideal[3])));
    for (std::size_t k = 0; k < 5; ++k) {
      const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
      EXPECT_NEAR(r.corrected[k], exact.q[k], (rotary ? 1e-12 : 1e-10) * amplified) << k;
    }
    EXPECT_LE(r.residual_position, 1e-12);
    EXPECT_LE(r.residual_direction, 1e-15);
  }
}

TEST(Printed, IsThePrintedFormWithItsStatedResidual) {
  for (const grinder::Case& c : grinder::kCases) {
    SCOPED_TRACE(testing::Message() << "A " << c.ideal[3] << " errors " << c.errors);
    const Machine machine = machine_of(grinder::text(c.errors, c.scale));
    const Query query = grinder_at(machine, c.ideal), printed = grinder_at(machine, c.printed);
    const Correction r = correct(plan_of(machine), query, *free_axes(machine, 0), with(Method::printed, 0.3));
    EXPECT_EQ(r.status, Status::ok);
    // acos and 1 / rho lose digits near tilt zero.
    const double amplified = 1 / std::abs(std::sin(c.ideal[3]));
    for (std::size_t k = 0; k < 5; ++k) {
      const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
      EXPECT_NEAR(r.corrected[k], printed.q[k], (rotary ? 1e-15 : 1e-13) * 30 * amplified) << k;
    }
    EXPECT_NEAR(r.residual_position, c.printed_position, 1e-4 * c.printed_position);
    EXPECT_NEAR(r.residual_direction, c.printed_direction, 1e-3 * c.printed_direction);
  }
}

TEST(Printed, ASecondOrderRest) {
  // Errors ten times as large leave a hundred times as much.
  std::array<double, 2> left{};
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}}) {
    const Machine machine = machine_of(grinder::text(0, i == 0 ? 1 : 10));
    const Query query = grinder_at(machine, grinder::kCases[0].ideal);
    left[i] = correct(plan_of(machine), query, 31, with(Method::printed)).residual_position;
  }
  EXPECT_NEAR(left[1] / left[0], 100, 1);
}

TEST(Printed, DirectionsAndSidesOfErrorsArePartOfTheChain) {
  // The same machine described otherwise: X and C count the other way, X's errors as seen at the tool.
  std::string text = grinder::text(0);
  const auto replace = [&](const std::string& from, const std::string& to) {
    text.replace(text.find(from), from.size(), to);
  };
  replace("direction = [1, 0, 0]\nerrors_seen = \"body\"", "direction = [-1, 0, 0]\nerrors_seen = \"tool\"");
  replace("direction = [0, 0, 1]", "direction = [0, 0, -1]");
  for (const char* name : {"EXX", "EYX", "EZX", "EAX", "EBX", "ECX"}) {
    const std::size_t at = text.find(std::string(name) + " = ") + 6;
    if (text[at] == '-')
      text.erase(at, 1);
    else
      text.insert(at, "-");
  }
  const Machine here = machine_of(grinder::text(0)), there = machine_of(text);
  std::array<double, 5> q = grinder::kCases[0].ideal;
  const Correction a = correct(plan_of(here), grinder_at(here, q), 31, with(Method::printed));
  q[0] = -q[0];
  q[4] = -q[4];
  const Correction b = correct(plan_of(there), grinder_at(there, q), 31, with(Method::printed));
  EXPECT_EQ(b.status, Status::ok);
  for (const char* name : {"X", "Y", "Z", "A", "C"}) {
    const auto i = static_cast<std::size_t>(here.find_axis(name));
    const double sign = name[0] == 'X' || name[0] == 'C' ? -1 : 1;
    EXPECT_NEAR(sign * b.corrected[i], a.corrected[i], 1e-13) << name;
  }
  // The inverse of a matrix is minus its errors to first order.
  EXPECT_NEAR(b.residual_position, a.residual_position, 1e-7);
}

TEST(Methods, ASingularityHoldsTheTableAndStaysFinite) {
  const Machine machine = machine_of(grinder::text(0));
  const Plan plan = plan_of(machine);
  const auto c_axis = static_cast<std::size_t>(machine.find_axis("C"));
  for (const grinder::Singular& c : grinder::kSingular) {
    // Ideal inverse of seed 003: tip (35.5, -62.25, 48.75), L = 200.
    const double C = c.held[4], A = c.tilt, x = 35.5, y = -62.25, z = 48.75;
    const Query query = grinder_at(
        machine, {-(x * std::cos(C) - y * std::sin(C)), x * std::sin(C) + y * std::cos(C) - 200 * std::sin(A),
                  z - 200 + 200 * std::cos(A), A, C});
    const auto near = [&](const Correction& r, const std::array<double, 5>& q, double amplified) {
      const Query expected = grinder_at(machine, q);
      for (std::size_t k = 0; k < 5; ++k) {
        const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
        EXPECT_NEAR(r.corrected[k], expected.q[k], (rotary ? 1e-12 : 1e-10) * amplified) << k;
      }
      EXPECT_LE(r.residual_position, 1e-12 * amplified);
    };
    for (const double most : {0.5 * deg, 2.0}) {
      SCOPED_TRACE(testing::Message() << "tilt " << c.tilt << " most " << most);
      const Correction r = correct(plan, query, 31, with(Method::closed_form, most));
      const bool feasible = std::abs(c.ratio) <= 1;
      const bool reached = feasible && std::abs(c.exact[4] - C) <= most;
      EXPECT_EQ(r.status, reached ? Status::ok : Status::degraded);
      if (reached) {
        near(r, c.exact, 4e-4 / c.tilt + 1);
        EXPECT_LE(r.residual_direction, 1e-15);
      } else {
        EXPECT_EQ(r.held, AxisSet{1} << c_axis);
        EXPECT_EQ(r.corrected[c_axis], query.q[c_axis]);
        near(r, c.held, 1);
        EXPECT_NEAR(r.residual_direction, c.held_direction, 1e-9 * c.held_direction);
      }
    }
    // The printed form has no answer here: it keeps both rotary axes.
    const Correction p = correct(plan, query, 31, with(Method::printed));
    EXPECT_TRUE(std::isfinite(p.residual_direction));
    EXPECT_LE(p.residual_position, 2e-6);
    EXPECT_LE(p.residual_direction, 6e-5);
    if (std::abs(c.ratio) > 1) {
      EXPECT_EQ(p.status, Status::degraded);
    }
  }
}

/// Runs on machines of every structure: three linear and two rotary axes in any order, split over the
/// branches in any way, tilted by design (0.3 rad) and by location errors.
template <class Function>
void on_random_five_axis_machines(unsigned seed, int machines, double length, double angle,
                                  const Function& f) {
  RandomMachine random(seed);
  for (int i = 0; i < machines; ++i) {
    const Machine machine = random.make(3, 2, length, angle);
    const Plan plan = plan_of(machine);
    if (method_obstacle(Method::closed_form, machine, ErrorModel::rigid, tool_of(machine),
                        *free_axes(machine, 0)))
      continue;
    for (int k = 0; k < 5; ++k) {
      SCOPED_TRACE(testing::Message() << "machine " << i << " point " << k);
      f(machine, plan, random.query(machine));
    }
  }
}

/// Sine of how far the pose is from one where the two rotary axes turn the tool about one line, and the
/// volume that the linear axes span.
struct Distance {
  double direction = 1, position = 1;
};
Distance from_singular(const Machine& machine, const Plan& plan, const Query& query) {
  const Jacobian j = jacobian(plan, query);
  const Vec3 a = nominal_pose(plan, query).R * query.tool.axis;
  std::vector<Vec3> turns, slides;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if (machine.axis(i).type == AxisType::rotary)
      turns.emplace_back(j.tool_axis.col(i));
    else
      slides.emplace_back(j.position.col(i));
  }
  return {std::abs(a.dot(turns[0].cross(turns[1]))), std::abs(slides[0].dot(slides[1].cross(slides[2])))};
}

TEST(ClosedForm, ActualOfCorrectedIsNominal) {
  int ok = 0, away = 0, work = 0, tool = 0, mixed = 0;
  on_random_five_axis_machines(
      21, 300, 0.02, 5e-5, [&](const Machine& machine, const Plan& plan, const Query& query) {
        int on_work = 0;
        for (int i = 0; i < machine.axis_count(); ++i) {
          const Body& axis = machine.axis(i);
          if (axis.type == AxisType::rotary && axis.branch == Branch::workpiece) ++on_work;
        }
        ++(on_work == 2 ? work : on_work == 0 ? tool : mixed);
        const Correction c = correct(plan, query, *free_axes(machine, 0), with(Method::closed_form));
        const Distance distance = from_singular(machine, plan, query);
        // 5e-5 rad of each of some twenty errors, at 0.1: less than the half degree that is allowed.
        const bool is_away = distance.direction > 0.1 && distance.position > 0.1;
        if (is_away) {
          ++away;
          EXPECT_EQ(c.status, Status::ok);
        }
        EXPECT_TRUE(std::isfinite(c.residual_position) && std::isfinite(c.residual_direction));
        if (c.status != Status::ok) return;
        ++ok;
        const Left left = left_of(plan, query, c.corrected);
        EXPECT_LE(left.position, kPosition);
        EXPECT_LE(left.direction, kDirection);
        EXPECT_NEAR(c.residual_position, left.position, 1e-11);
        EXPECT_NEAR(c.residual_direction, left.direction, 1e-14);
      });
  EXPECT_GT(ok, 1300);
  EXPECT_GT(away, 1000);
  for (const int n : {work, tool, mixed}) EXPECT_GT(n, 200);
}

TEST(ClosedForm, ClosedFormEqualsNewton) {
  int compared = 0;
  on_random_five_axis_machines(
      22, 150, 0.02, 5e-5, [&](const Machine& machine, const Plan& plan, const Query& query) {
        const AxisSet free = *free_axes(machine, 0);
        const Correction a = correct(plan, query, free, with(Method::closed_form));
        const Correction b = correct(plan, query, free, with(Method::newton));
        EXPECT_EQ(a.held, b.held);
        EXPECT_EQ(a.status, b.status);
        if (a.status != Status::ok || b.status != Status::ok) return;
        ++compared;
        const Distance distance = from_singular(machine, plan, query);
        const double amplified = 1 / (distance.direction * distance.position);
        for (std::size_t k = 0; k < static_cast<std::size_t>(machine.axis_count()); ++k) {
          const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
          EXPECT_NEAR(a.corrected[k], b.corrected[k], (rotary ? 1e-12 : 1e-9) * amplified);
        }
      });
  EXPECT_GT(compared, 600);
}

TEST(ClosedForm, ZeroErrorsChangeNothing) {
  RandomMachine random(23);
  int points = 0;
  for (int i = 0; i < 60; ++i) {
    Machine machine = random.make(3, random.below(3), 0.02, 1e-4);
    machine.errors.clear();
    const Plan plan = plan_of(machine);
    const AxisSet free = *free_axes(machine, 0);
    if (method_obstacle(Method::closed_form, machine, ErrorModel::rigid, tool_of(machine), free)) continue;
    Query query = random.query(machine);
    for (const bool home : {false, true}) {
      SCOPED_TRACE(testing::Message() << i << home);
      ++points;
      if (home) query.q = {};
      const Correction c = correct(plan, query, free, with(Method::closed_form));
      EXPECT_EQ(c.status, Status::ok);
      for (std::size_t k = 0; k < static_cast<std::size_t>(machine.axis_count()); ++k)
        EXPECT_NEAR(c.corrected[k], query.q[k], 1e-11);
      EXPECT_LE(c.residual_position, 1e-11);
    }
  }
  EXPECT_GT(points, 100);
  // The tool on the axis of the table: nothing to do, and nothing is held.
  std::string text = grinder::kText;
  const Machine machine = machine_of(text + "EXX = 0.01\n");
  const Correction c =
      correct(plan_of(machine), grinder_at(machine, {10, 20, 30, 0, 0.4}), 31, with(Method::closed_form));
  EXPECT_EQ(c.status, Status::ok);
  EXPECT_EQ(c.corrected[static_cast<std::size_t>(machine.find_axis("C"))], 0.4);
  const Correction p =
      correct(plan_of(machine), grinder_at(machine, {10, 20, 30, 0, 0.4}), 31, with(Method::printed));
  EXPECT_EQ(p.status, Status::ok);
  EXPECT_NEAR(p.corrected[static_cast<std::size_t>(machine.find_axis("X"))], 9.99, 1e-12);
}

TEST(ClosedForm, ServesThreeAndFourAxesAndLockedOnes) {
  RandomMachine random(24);
  int compared = 0;
  for (int i = 0; i < 80; ++i) {
    SCOPED_TRACE(i);
    const Machine machine = random.make(3, 3, 0.02, 5e-5);
    AxisSet locked = 0;
    // All rotary axes locked, or one or two of three free.
    int rotary_free = random.below(3);
    for (int k = 0; k < machine.axis_count(); ++k) {
      if (machine.axis(k).type == AxisType::rotary && rotary_free-- <= 0) locked |= AxisSet{1} << k;
    }
    const Plan plan = plan_of(machine);
    const AxisSet free = *free_axes(machine, locked);
    ASSERT_FALSE(method_obstacle(Method::closed_form, machine, ErrorModel::rigid, tool_of(machine), free));
    const Query query = random.query(machine);
    const Correction a = correct(plan, query, free, with(Method::closed_form));
    const Correction b = correct(plan, query, free, {});
    EXPECT_EQ(a.status, b.status);
    if (a.status != Status::ok || b.status != Status::ok) continue;
    ++compared;
    EXPECT_LE(a.residual_position, kPosition);
    // One rotary axis: the minimum of the angle itself, Newton's is that of its projection.
    EXPECT_NEAR(a.residual_direction, b.residual_direction, 1e-4 * b.residual_direction + 1e-12);
    for (int k = 0; k < machine.axis_count(); ++k) {
      if ((free >> k & 1U) == 0) {
        EXPECT_EQ(a.corrected[static_cast<std::size_t>(k)], query.q[static_cast<std::size_t>(k)]);
      }
    }
  }
  EXPECT_GT(compared, 55);
}

TEST(Methods, RefuseChainsTheyDoNotFit) {
  const auto obstacle = [](Method method, const std::string& text, ErrorModel model = ErrorModel::rigid) {
    const Machine machine = machine_of(text);
    return method_obstacle(method, machine, model, tool_of(machine), *free_axes(machine, 0)).value_or("");
  };
  const auto chain = [](const std::string& c, const std::string& more = "") {
    return "format = 1\n[machine]\nname = \"m\"\nchain = \"" + c + "\"\n" + more;
  };
  const std::string tool = "[tool]\nlength = 100\n";
  const auto closed = [&](const std::string& text) { return obstacle(Method::closed_form, text); };
  EXPECT_EQ(closed(chain("w b X Y Z A C t", tool)), "the axis C turns the tool about itself");
  EXPECT_EQ(closed(chain("w b X Y Z C A t", tool)), "");
  EXPECT_EQ(closed(chain("w b X Y Z C t", tool)), "");
  EXPECT_EQ(closed(chain("w b X Y Z t")), "");
  EXPECT_NE(closed(chain("w b X Z C t")), "");
  EXPECT_NE(closed(chain("w b X Y Z A B t", "[axis.A]\ndirection = [0, 1, 0]\n")), "");
  EXPECT_NE(closed(chain("w b X Y Z A C t", "[axis.Z]\ndirection = [1, 1, 0]\n")), "");
  EXPECT_NE(obstacle(Method::closed_form, chain("w b X Y Z C A t", tool), ErrorModel::linear), "");
  EXPECT_EQ(obstacle(Method::newton, chain("w b X Z C t")), "");

  const std::string good = grinder::text(0);
  const auto printed = [&](const std::string& from, const std::string& to) {
    std::string text = good;
    text.replace(text.find(from), from.size(), to);
    return obstacle(Method::printed, text);
  };
  EXPECT_EQ(obstacle(Method::printed, good), "");
  EXPECT_NE(printed("w C X b Y Z A t", "w C X b Z Y A t"), "");
  EXPECT_NE(printed("EXX = ", "TXX = "), "");
  EXPECT_NE(printed("EX0C = ", "EZ0C = "), "");
  EXPECT_NE(printed("[tool]\norigin = [0, 0, 0]", "[tool]\norigin = [0, 0, 1]"), "");
  EXPECT_NE(printed("[axis.Z]\nlocation = \"frame\"", "[axis.Z]\nlocation = \"line\""), "");
  EXPECT_NE(printed("origin = [0, 0, 200]", "origin = [0, 1, 200]"), "");

  // A method that does not fit fails, with the command given back.
  const Machine machine = machine_of(chain("w b X Y Z A C t", tool + "[errors]\nEXX = 5\n"));
  const Query query = grinder_at(machine, {1, 2, 3, 0.1, 0.2});
  const Correction r = correct(plan_of(machine), query, 31, with(Method::printed));
  EXPECT_EQ(r.status, Status::failed);
  EXPECT_EQ(r.corrected, query.q);
  const Correction linear =
      correct(plan_of(machine_of(good), ErrorModel::linear),
              grinder_at(machine_of(good), {1, 2, 3, 0.1, 0.2}), 31, with(Method::closed_form));
  EXPECT_EQ(linear.status, Status::failed);
}

TEST(ClosedForm, AnAxisAtTheEndOfItsTravelStaysThere) {
  std::string text = grinder::text(0);
  text.replace(text.find("[axis.Y]"), 8, "[axis.Y]\nrange = [-112.07, 300]");
  const Machine machine = machine_of(text);
  const Query query = grinder_at(machine, grinder::kCases[0].ideal);  // Y -112.068, wanted -112.0899
  const auto y = static_cast<std::size_t>(machine.find_axis("Y"));
  const Correction r = correct(plan_of(machine), query, 31, with(Method::closed_form));
  EXPECT_EQ(r.status, Status::degraded);
  EXPECT_EQ(r.held, AxisSet{1} << y);
  EXPECT_EQ(r.corrected[y], -112.07);
  EXPECT_LE(r.residual_direction, 1e-12);
  const Correction newton = correct(plan_of(machine), query, 31, {});
  EXPECT_NEAR(r.residual_position, newton.residual_position, 1e-6);
}

/// Machines as they are built: every order of X Y Z, every split of the five axes over both branches that
/// keeps the rotary axes next to workpiece or tool, upright or with a rotary axis at 45 deg.
std::vector<std::string> built_machines() {
  const std::string errors = R"([errors]
EXX = { poly = [4, 0.02, 3e-5] }
EYX = 7
EBX = { poly = [12, 0.03] }
ECX = -21
EYY = { poly = [-6, 0.01] }
EAY = { poly = [9, -0.02] }
EZZ = -8
EBZ = { poly = [0, 0.04] }
EC0X = 35
EB0Z = -28
EA0Z = 17
)";
  struct Pair {
    const char *work, *tool;  ///< rotary axes from the outside inwards; from the carriage to the tool
    const char* letters;
  };
  const Pair pairs[] = {{"C A", "", "AC"}, {"C B", "", "BC"}, {"", "C A", "AC"}, {"", "C B", "BC"},
                        {"", "A B", "AB"}, {"C", "A", "AC"},  {"C", "B", "BC"},  {"A", "B", "AB"}};
  std::vector<std::string> all;
  std::string order = "XYZ";
  do {
    for (const Pair& pair : pairs) {
      for (std::size_t on_work = 0; on_work <= 3; ++on_work) {
        for (const bool nutating : {false, true}) {
          std::string chain = std::string("w ") + pair.work, tool = "b";
          for (std::size_t i = 0; i < on_work; ++i) chain += std::string(" ") + order[i];
          for (std::size_t i = on_work; i < 3; ++i) tool += std::string(" ") + order[i];
          std::string text = "format = 1\n[machine]\nname = \"m\"\nchain = \"" + chain + " " + tool + " " +
                             pair.tool + " t\"\n[tool]\norigin = [0, 0, 90]\nlength = 120\n";
          for (std::size_t i = 0; i < on_work; ++i)
            text += std::string("[axis.") + order[i] + "]\nerrors_seen = \"tool\"\n";
          for (const char* letter = pair.letters; *letter != 0; ++letter) {
            const bool on_table = std::string(pair.work).find(*letter) != std::string::npos;
            const bool tilted = nutating && *letter != 'C' && letter == pair.letters;
            text += std::string("[axis.") + *letter + "]\norigin = [10, -20, 40]\n";
            if (on_table) text += "errors_seen = \"body\"\n";
            if (on_table || tilted) {
              text += std::string("direction = ") + (tilted           ? "[0, 1, 1]\n"
                                                     : *letter == 'A' ? "[-1, 0, 0]\n"
                                                     : *letter == 'B' ? "[0, -1, 0]\n"
                                                                      : "[0, 0, -1]\n");
            }
          }
          text += errors;
          for (const char* letter = pair.letters; *letter != 0; ++letter) {
            text += std::string("EX") + *letter + " = { sine = [5, 0.0174533, 0.3] }\nEC" + *letter +
                    " = -14\nEA0" + *letter + " = 22\nEB0" + *letter + " = -31\nEY0" + *letter + " = 12\n";
          }
          all.push_back(text);
        }
      }
    }
  } while (std::next_permutation(order.begin(), order.end()));
  return all;
}

TEST(ClosedForm, ServesEveryMachineThatIsBuilt) {
  RandomMachine random(25);
  int ok = 0, machines = 0;
  for (const std::string& text : built_machines()) {
    SCOPED_TRACE(text.substr(0, 120));
    const Machine machine = machine_of(text);
    ASSERT_EQ(machine.axis_count(), 5);
    ASSERT_EQ(method_obstacle(Method::closed_form, machine, ErrorModel::rigid, tool_of(machine), 31),
              std::nullopt);
    ++machines;
    const Plan plan = plan_of(machine);
    for (int k = 0; k < 3; ++k) {
      const Query query = random.query(machine, 300, 1.4);
      const Distance distance = from_singular(machine, plan, query);
      if (distance.direction < 0.05 || distance.position < 0.05) continue;
      const Correction closed = correct(plan, query, 31, with(Method::closed_form));
      const Correction newton = correct(plan, query, 31, {});
      ASSERT_EQ(closed.status, Status::ok);
      ASSERT_EQ(newton.status, Status::ok);
      ++ok;
      const Left left = left_of(plan, query, closed.corrected);
      EXPECT_LE(left.position, kPosition);
      EXPECT_LE(left.direction, kDirection);
      const double amplified = 1 / (distance.direction * distance.position);
      for (std::size_t i = 0; i < 5; ++i) {
        const bool rotary = machine.axis(static_cast<int>(i)).type == AxisType::rotary;
        EXPECT_NEAR(closed.corrected[i], newton.corrected[i], (rotary ? 1e-12 : 1e-9) * amplified);
      }
    }
  }
  EXPECT_EQ(machines, 6 * 8 * 4 * 2);
  EXPECT_GT(ok, 900);
}

TEST(Methods, NeverNaN) {
  const double strange[] = {0,   -0.0, 1e-300, 1e-12, 0.5,      M_PI / 2, M_PI,
                            1e6, 1e15, 1e150,  1e300, INFINITY, NAN};
  std::mt19937 pick(26);
  const std::vector<std::string> built = built_machines();
  std::vector<Machine> machines = {machine_of(grinder::text(0)), machine_of(grinder::text(1, 1e5)),
                                   machine_of(built[0]), machine_of(built[57]), machine_of(built[200])};
  for (const Machine& machine : machines) {
    const Plan plan = plan_of(machine);
    for (int k = 0; k < 300; ++k) {
      Query query;
      query.tool = tool_of(machine);
      for (std::size_t i = 0; i < 5; ++i) query.q[i] = strange[pick() % std::size(strange)];
      for (const Method method : {Method::newton, Method::one_step, Method::closed_form, Method::printed}) {
        const Correction c = correct(plan, query, 31, with(method, 0.1));
        bool finite = std::isfinite(c.residual_position) && std::isfinite(c.residual_direction);
        for (std::size_t i = 0; i < 5; ++i) {
          finite = finite && std::isfinite(c.corrected[i]);
          const bool rotary = machine.axis(static_cast<int>(i)).type == AxisType::rotary;
          // Never a jump.
          if (rotary && std::isfinite(query.q[i])) {
            EXPECT_LE(std::abs(c.corrected[i] - query.q[i]), 0.1 + 1e-9 + 1e-15 * std::abs(query.q[i]));
          }
        }
        ASSERT_TRUE(finite) << to_string(method) << " " << k;
      }
    }
  }
}

constexpr const char* kThreeAxes = R"(format = 1
[machine]
name = "seed 001"
chain = "w X b Y Z t"
[units]
error_length = "mm"
error_angle = "rad"
[axis.X]
direction = [1, 0, 0]
location = "frame"
errors_seen = "body"
[axis.Y]
location = "frame"
[axis.Z]
location = "frame"
[tool]
origin = [0.5, -0.25, -120.0]
[workpiece]
origin = [0, 0, 0]
[errors]
EXX = { poly = [0.0, 3.1e-05, -4.2e-08, 1.5e-11] }
EYX = { poly = [0.0, -1.2e-05, 3.3e-08] }
EZX = { poly = [0.0, 9e-06, -2.7e-08] }
EAX = { poly = [0.0, 4.1e-08, -1.1e-10] }
EBX = { poly = [0.0, -6.3e-08, 1.9e-10] }
ECX = { poly = [0.0, 5.2e-08, 7e-11] }
EXY = { poly = [0.0, -8e-06, 2.9e-08] }
EYY = { poly = [0.0, 2.6e-05, -3.8e-08, 2.1e-11] }
EZY = { poly = [0.0, -1.4e-05, 1.7e-08] }
EAY = { poly = [0.0, -3.6e-08, 2.3e-10] }
EBY = { poly = [0.0, 2.8e-08, -1.3e-10] }
ECY = { poly = [0.0, -4.4e-08, 1.6e-10] }
EXZ = { poly = [0.0, 1.1e-05, -2.2e-08] }
EYZ = { poly = [0.0, -7e-06, 1.8e-08] }
EZZ = { poly = [0.0, -2.9e-05, 4.6e-08, -1.2e-11] }
EAZ = { poly = [0.0, 3.3e-08, -2.1e-10] }
EBZ = { poly = [0.0, -5.1e-08, 1.4e-10] }
ECZ = { poly = [0.0, 2.4e-08, -9e-11] }
EC0X = -5.778e-05
EA0Z = -2.928e-05
EB0Z = 4.899e-05
)";

TEST(OneStep, LeavesTheSecondOrderThatIterationRemoves) {
  // 50-digit arithmetic from the equations of seed 001 with the sign of the X column that is right.
  const Machine machine = machine_of(kThreeAxes);
  const Plan plan = plan_of(machine);
  Query query;
  query.tool = tool_of(machine);
  query.q = {120.5, -85.25, -40.75};
  const Correction one = correct(plan, query, 7, with(Method::one_step));
  const Vec3 first(one.corrected[0], one.corrected[1], one.corrected[2]);
  EXPECT_LE((first - Vec3(120.49318087727718, -85.24499560150107, -40.75273188506069)).norm(), 1e-12);
  EXPECT_NEAR(one.residual_position, 4.0532341046041393e-07, 1e-11);
  for (const Method method : {Method::newton, Method::closed_form}) {
    const Correction all = correct(plan, query, 7, with(method));
    const Vec3 last(all.corrected[0], all.corrected[1], all.corrected[2]);
    EXPECT_LE((last - Vec3(120.49318094820146, -85.24499528663497, -40.75273213023458)).norm(), 1e-10);
    EXPECT_LE(all.residual_position, kPosition);
  }
}

}  // namespace
}  // namespace abbe
