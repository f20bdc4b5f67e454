#include "abbe/symbols/derive.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/chain/walk.h"
#include "abbe/machine/read_machine.h"
#include "abbe/symbols/write_expression.h"

namespace abbe {
namespace {

constexpr double kRelative = 1e-10;
constexpr double kSensor = 23.5;  // degC

/// Values of all symbols at a query: what the numeric model uses.
class SymbolValues {
 public:
  SymbolValues(const Machine& machine, const SymbolNames& names, const Query& query) : query_(query) {
    std::vector<double> variables;
    for (std::size_t i = 0; i < machine.variables.size(); ++i) {
      const Variable& variable = machine.variables[i];
      variables.push_back(variable.kind == Variable::Kind::position
                              ? file_position(query.q[i], machine.axis_unit(static_cast<int>(i)))
                          : variable.kind == Variable::Kind::sensor ? kSensor
                                                                    : 0.0);
    }
    std::vector<signed char> approach(variables.size(), 0);
    for (std::size_t i = 0; i < static_cast<std::size_t>(machine.axis_count()); ++i)
      approach[i] = query.approach[i];
    for (const ErrorName& name : names.errors) {
      double sum = 0;
      for (const ErrorTerm& error : machine.errors) {
        bool outside = false;
        if (error.name == name)
          sum += error.scale * error.function.value<double>(variables.data(), approach.data(), &outside);
      }
      errors_.push_back(sum);
    }
  }

  [[nodiscard]] Vec3 operator()(const Vec3T<Expression>& v) const {
    Vec3 out;
    for (int i = 0; i < 3; ++i) out[i] = v[i].value([this](Symbol s) { return value(s); });
    return out;
  }

 private:
  [[nodiscard]] double value(Symbol s) const {
    const auto index = static_cast<std::size_t>(s.index);
    switch (s.kind) {
      case Symbol::Kind::cosine:
        return std::cos(query_.q[index]);
      case Symbol::Kind::sine:
        return std::sin(query_.q[index]);
      case Symbol::Kind::position:
        return query_.q[index];
      case Symbol::Kind::error:
        break;
    }
    return errors_[index];
  }

  const Query& query_;
  std::vector<double> errors_;
};

/// `tabulated`: what the numeric model's tables of sines may miss.
void expect_equal(const Vec3& symbolic, const Vec3& numeric, double scale, double tabulated) {
  EXPECT_LE((symbolic - numeric).norm(), kRelative * (scale + numeric.norm()) + tabulated)
      << symbolic.transpose() << " is not " << numeric.transpose();
}

void expect_equals_numeric_model(const Machine& machine, RandomMachine& random, int queries) {
  Environment environment;
  for (const Variable& v : machine.variables) {
    if (v.kind == Variable::Kind::sensor) environment[v.name] = kSensor;
  }
  const Plan plan = std::get<Plan>(make_plan(machine, environment, ErrorModel::first_order));
  const Derivation derived = derive(machine);
  for (int i = 0; i < queries; ++i) {
    const Query query = random.query(machine);
    const Prediction numeric = predict(plan, query);
    const SymbolValues at(machine, derived.names, query);
    // Errors that nearly cancel leave less than they are: judged by one mm, one rad of random machines,
    // by a tenth of a um and a urad of others.
    expect_equal(at(derived.deviation), numeric.deviation.position, 1e-4, 1e-11);
    expect_equal(at(derived.tool_axis), numeric.deviation.tool_axis, 1e-6, 1e-14);
    expect_equal(at(derived.twist_d), numeric.tool_twist.d, 1e-4, 1e-11);
    expect_equal(at(derived.twist_e), numeric.tool_twist.e, 1e-6, 1e-14);
  }
}

TEST(Derive, EqualsTheNumericFirstOrderModel) {
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE(seed);
    RandomMachine random(seed);
    const Machine machine = random.make(random.below(5), random.below(4), 0.02, 50e-6);
    expect_equals_numeric_model(machine, random, 5);
  }
}

TEST(Derive, EqualsTheNumericFirstOrderModelOfThePublishedMachines) {
  const std::filesystem::path folder = std::string(ABBE_SOURCE_DIR) + "/../shared/golden";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no golden machines beside the source folder";
  RandomMachine random(7);
  int machines = 0;
  for (const char* part : {"machines", "contract"}) {
    for (const auto& entry : std::filesystem::directory_iterator(folder / part)) {
      if (entry.path().extension() != ".toml") continue;
      SCOPED_TRACE(entry.path().filename());
      const Parsed<Machine> parsed = read_machine_file(entry.path());
      ASSERT_TRUE(parsed.value.has_value());
      expect_equals_numeric_model(*parsed.value, random, 5);
      ++machines;
    }
  }
  EXPECT_GE(machines, 20);
}

/// Two linear, two rotary axes in coordinate directions, so that what is equal is equal to the last bit.
Machine straight_machine() {
  RandomMachine random(11);
  Machine machine = random.make(2, 2, 1, 1);
  for (Body& body : machine.bodies) {
    int largest = 0;
    body.direction.cwiseAbs().maxCoeff(&largest);
    body.direction = Vec3::Unit(largest);
    body.origin = Vec3(100, 0, -20);
  }
  machine.tool.axis = Vec3::UnitZ();
  machine.tool.origin = Vec3(0, 0, 250);
  machine.tool.length = 100;
  machine.workpiece_origin = Vec3(10, 20, 30);
  return machine;
}

TEST(Derive, TwistTurnedIntoWorkpieceAxesIsTheDeviation) {
  // R_wt d = deviation of the tip holds because sin^2 + cos^2 = 1 and not otherwise.
  const Machine machine = straight_machine();
  const Derivation derived = derive(machine);
  Mat3T<Expression> r_wt = Mat3T<Expression>::Identity();
  for (const bool workpiece : {false, true}) {
    for (std::size_t k = 0; k < machine.bodies.size(); ++k) {
      const std::size_t i = workpiece ? k : machine.bodies.size() - 1 - k;
      const Body& body = machine.bodies[workpiece ? machine.bodies.size() - 1 - k : i];
      if ((body.branch == Branch::workpiece) != workpiece || body.type != AxisType::rotary) continue;
      const Expression c(Symbol{Symbol::Kind::cosine, body.axis}), s(Symbol{Symbol::Kind::sine, body.axis});
      const Vec3 u = workpiece ? Vec3(-body.direction) : body.direction;
      Mat3 cross;
      cross << 0, -u.z(), u.y(), u.z(), 0, -u.x(), -u.y(), u.x(), 0;
      const Mat3 uu = u * u.transpose();
      Mat3T<Expression> turn;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column)
          turn(row, column) = Expression(uu(row, column)) +
                              c * Expression((row == column ? 1.0 : 0.0) - uu(row, column)) +
                              s * Expression(cross(row, column));
      }
      r_wt = (turn * r_wt).eval();
    }
  }
  const Vec3T<Expression> turned = r_wt * derived.twist_d;
  const Vec3T<Expression> tilted =
      r_wt * derived.twist_e.cross(Vec3T<Expression>(machine.tool.axis.cast<Expression>()));
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(write_expression(turned[i], derived.names),
              write_expression(derived.deviation[i], derived.names));
    EXPECT_EQ(write_expression(tilted[i], derived.names),
              write_expression(derived.tool_axis[i], derived.names));
  }
}

Machine machine_of(const std::string& text) {
  const Parsed<Machine> parsed =
      read_machine({"machine.toml", text}, std::nullopt, [](const std::string&) { return std::nullopt; });
  for (const Diagnostic& d : parsed.diagnostics) {
    if (d.severity == Severity::error) ADD_FAILURE() << to_text(d);
  }
  return parsed.value.value_or(Machine{});
}

std::vector<std::string> written(const Vec3T<Expression>& v, const SymbolNames& names,
                                 Notation notation = Notation::text) {
  std::vector<std::string> out;
  for (int i = 0; i < 3; ++i) out.push_back(write_expression(v[i], names, notation));
  return out;
}

using Strings = std::vector<std::string>;

constexpr const char* kBench = R"(format = 1
[machine]
chain = "w X b Y A t"
[axis.X]
errors_seen = "body"
[axis.A]
origin = [0, 0, 300]
location = "frame"
[tool]
origin = [0, 0, 300]
length = 300
[errors]
EXX = 1
EYY = 1
ECY = 1
EBY = 1
EB0A = 1
EAA = 1
TZA = 1
EXt = 1
ECt = 1
EYw = 1
)";

TEST(Derive, SmallMachineReadsAsWrittenByHand) {
  const Derivation d = derive(machine_of(kBench));
  // Tip 300 below the axis A, hanging at (0, Y + 300 sin A, 300 - 300 cos A).
  EXPECT_EQ(written(d.deviation, d.names),
            (Strings{"-EXX + EXt + 300*EBY - 300*cos(A)*(EBY + EB0A) - 300*sin(A)*ECY",
                     "-EYw + EYY + 300*cos(A)*EAA - sin(A)*TZA", "cos(A)*TZA + 300*sin(A)*EAA"}));
  EXPECT_EQ(written(d.tool_axis, d.names),
            (Strings{"cos(A)*(EBY + EB0A) + sin(A)*ECY", "-cos(A)*EAA", "-sin(A)*EAA"}));
  EXPECT_EQ(written(d.twist_e, d.names),
            (Strings{"EAA", "cos(A)*(EBY + EB0A) + sin(A)*ECY", "ECt + cos(A)*ECY - sin(A)*(EBY + EB0A)"}));
}

TEST(Derive, ExampleOfTheDocumentationIsPrintedSo) {
  const Derivation d = derive(machine_of(R"(format = 1
[machine]
chain = "w X b Y Z t"
[axis.X]
direction = [1, 0, 0]
errors_seen = "body"
[errors]
EXX = 1
EBX = 1
ECX = 1
EXY = 1
EBY = 1
EB0Z = 1
)"));
  EXPECT_EQ(written(d.deviation, d.names),
            (Strings{"-EXX + EXY + Y*ECX - Z*(EBX - EBY - EB0Z)", "X*ECX", "-X*EBX"}));
  EXPECT_EQ(written(d.tool_axis, d.names), (Strings{"-EBX + EBY", "0", "0"}));
}

TEST(Derive, LatexNamesHaveIndices) {
  const Derivation d = derive(machine_of(kBench));
  EXPECT_EQ(
      write_expression(d.deviation[0], d.names, Notation::latex),
      "-E_{XX} + E_{Xt} + 300\\,E_{BY} - 300\\,\\cos(A)\\,(E_{BY} + E_{B0A}) - 300\\,\\sin(A)\\,E_{CY}");
}

TEST(Derive, LongEquationsAreBrokenBeforeSigns) {
  const Derivation d = derive(machine_of(kBench));
  EXPECT_EQ(write_text_equation("dx", d.deviation[0], d.names, 60),
            "dx = -EXX + EXt + 300*EBY\n"
            "     - 300*cos(A)*(EBY + EB0A)\n"
            "     - 300*sin(A)*ECY\n");
  EXPECT_EQ(write_text_equation("dx", d.deviation[0], d.names, 100),
            "dx = " + write_expression(d.deviation[0], d.names) + "\n");
  EXPECT_EQ(write_text_equation("d", Expression(), d.names, 60), "d = 0\n");
}

TEST(Derive, LatexLinesThatGoOnHaveNoNumber) {
  const Derivation d = derive(machine_of(kBench));
  const std::string equation = write_latex_equation("x", d.deviation[0], d.names);
  EXPECT_EQ(equation,
            "x &= -E_{XX} + E_{Xt} + 300\\,E_{BY} \\notag \\\\\n"
            "  &\\quad - 300\\,\\cos(A)\\,(E_{BY} + E_{B0A}) \\notag \\\\\n"
            "  &\\quad - 300\\,\\sin(A)\\,E_{CY}");
}

TEST(Derive, InventoryAddsWhatIsNotGiven) {
  const Machine machine = machine_of(kBench);
  const Machine full = with_inventory(machine);
  std::vector<std::string> names;
  for (const ErrorName& name : derive(full).names.errors) names.push_back(to_string(name));
  for (const std::string& name : error_inventory(machine))
    EXPECT_EQ(std::count(names.begin(), names.end(), name), 1) << name;
  EXPECT_EQ(std::count(names.begin(), names.end(), "TZA"), 1);
  // What was given keeps its place along the chain.
  EXPECT_EQ(names.front(), "EYw");
  EXPECT_EQ(names.back(), "ECt");
}

TEST(Derive, ErrorThatTheOrderLeavesOutIsInNoExpression) {
  std::string text(kBench);
  text.replace(text.find("location = \"frame\""), 18, "order = [\"motion\", \"static\"]");
  const Derivation d = derive(machine_of(text));
  EXPECT_EQ(written(d.deviation, d.names)[2], "300*sin(A)*EAA");  // no TZA, no EB0A
  EXPECT_EQ(d.names.errors.size(), 10U);
}

}  // namespace
}  // namespace abbe
