#include "abbe/symbols/derive.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <tuple>
#include <utility>

#include "abbe/chain/chain_steps.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

using Vector = Vec3T<Expression>;
using Matrix = Mat3T<Expression>;

constexpr double kDust = 1e-15;  // of components of unit vectors

/// A number of a rotation matrix without the last bits of rounding: 0 and 1 where they are meant.
double tidy(double x) { return std::abs(x - std::round(x)) <= kDust ? std::round(x) : x; }

Vector symbolic(const Vec3& v) { return v.cast<Expression>(); }
Vec3 tidy(const Vec3& v) {
  return v.unaryExpr([](double x) { return tidy(x); });
}

/// The values of one error factor as symbols.
struct FactorSymbols {
  Vector d = Vector::Zero(), e = Vector::Zero();
  bool is_rotary = false;
};

/// A matrix of the chain, as the walk meets it: x -> x + shift, x -> turn x, or an error factor.
struct Stage {
  enum class Kind { shift, turn, error } kind = Kind::shift;
  Vector shift = Vector::Zero();
  Matrix turn = Matrix::Identity();
  Vector d = Vector::Zero(), e = Vector::Zero();  // sign and part included
};

/// Rot(u, q) = u u^T + cos q (1 - u u^T) + sin q [u]x; the inverse turns the other way.
Matrix turn_about(const Vec3& u, int axis, bool inverse) {
  const Expression cosine(Symbol{Symbol::Kind::cosine, axis});
  const Expression sine(Symbol{Symbol::Kind::sine, axis});
  Mat3 cross;
  cross << 0, -u.z(), u.y(), u.z(), 0, -u.x(), -u.y(), u.x(), 0;
  Matrix r;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      const double along = tidy(u[i] * u[j]);
      const double across = tidy((i == j ? 1.0 : 0.0) - u[i] * u[j]);
      const double turned = tidy(inverse ? -cross(i, j) : cross(i, j));
      r(i, j) = Expression(along) + Expression(across) * cosine + Expression(turned) * sine;
    }
  }
  return r;
}

/// Where an error is named in sums: along the chain from the workpiece to the tool.
auto chain_order(const ErrorTerm& error) {
  const int place = error.body == kWorkpieceBody ? -1
                    : error.body == kToolBody    ? std::numeric_limits<int>::max()
                                                 : error.body;
  return std::tuple(place, error.name.error_class, error.name.direction);
}

class Deriver {
 public:
  explicit Deriver(const Machine& machine) : machine_(machine) {
    name_symbols();
    for (const Step& step : chain_steps(machine_, groups_)) stages_.push_back(stage(step));
  }

  [[nodiscard]] Derivation derive() {
    walk_to_the_workpiece();
    walk_to_the_tool();
    return std::move(result_);
  }

 private:
  void name_symbols() {
    for (int i = 0; i < machine_.axis_count(); ++i) result_.names.axes.push_back(machine_.axis(i).name);
    std::vector<ErrorTerm> errors;
    for (const ErrorTerm& error : machine_.errors) {
      const bool known = std::any_of(errors.begin(), errors.end(),
                                     [&](const ErrorTerm& other) { return other.name == error.name; });
      if (!known) errors.push_back(error);
    }
    std::stable_sort(errors.begin(), errors.end(),
                     [](const ErrorTerm& a, const ErrorTerm& b) { return chain_order(a) < chain_order(b); });
    for (const ErrorTerm& error : errors) {
      const GroupKey key{error.body, error.name.error_class};
      const auto [at, is_new] = groups_.try_emplace(key, static_cast<int>(factors_.size()));
      if (is_new) factors_.emplace_back();
      FactorSymbols& factor = factors_[static_cast<std::size_t>(at->second)];
      const Expression symbol(Symbol{Symbol::Kind::error, static_cast<int>(result_.names.errors.size())});
      (error.name.is_rotation() ? factor.e : factor.d)[error.name.direction % 3] = symbol;
      result_.names.errors.push_back(error.name);
    }
    for (const auto& [key, index] : groups_) {
      if (key.first < 0) continue;
      const Body& body = machine_.bodies[static_cast<std::size_t>(key.first)];
      FactorSymbols& factor = factors_[static_cast<std::size_t>(index)];
      factor.is_rotary = body.type == AxisType::rotary;
      // d = d_file - e x (measured_at - origin)
      if (key.second == ErrorClass::component && body.measured_at.has_value())
        factor.d -= factor.e.cross(symbolic(*body.measured_at - body.origin)).eval();
    }
  }

  [[nodiscard]] Stage stage(const Step& step) const {
    Stage out;
    switch (step.kind) {
      case Step::Kind::tip:
        out.shift = symbolic(tool_of(machine_).tip);
        break;
      case Step::Kind::translate:
        out.shift = symbolic(step.vector);
        break;
      case Step::Kind::motion:
        if (step.body->type == AxisType::linear) {
          const Expression q(Symbol{Symbol::Kind::position, step.body->axis});
          out.shift = symbolic(tidy(step.inverse ? Vec3(-step.vector) : step.vector)) * q;
        } else {
          out.kind = Stage::Kind::turn;
          out.turn = turn_about(step.vector, step.body->axis, step.inverse);
        }
        break;
      case Step::Kind::error: {
        const FactorSymbols& factor = factors_[static_cast<std::size_t>(step.group)];
        out.kind = Stage::Kind::error;
        out.d = factor.d;
        out.e = factor.e;
        take_part<Expression>(step.part, factor.is_rotary, tidy(step.vector), out.d, out.e);
        if (step.inverse) {
          out.d = -out.d;
          out.e = -out.e;
        }
        break;
      }
    }
    return out;
  }

  /// Point and axis of the tool go to the workpiece, their deviations with them.
  void walk_to_the_workpiece() {
    Vector p = Vector::Zero(), v = symbolic(tidy(machine_.tool.axis));
    Vector dp = Vector::Zero(), dv = Vector::Zero();
    for (const Stage& stage : stages_) {
      switch (stage.kind) {
        case Stage::Kind::shift:
          p += stage.shift;
          break;
        case Stage::Kind::turn:
          p = (stage.turn * p).eval();
          v = (stage.turn * v).eval();
          dp = (stage.turn * dp).eval();
          dv = (stage.turn * dv).eval();
          break;
        case Stage::Kind::error:
          // dp += d + e x p,  dv += e x v
          dp += stage.d + stage.e.cross(p);
          dv += stage.e.cross(v).eval();
          break;
      }
    }
    result_.deviation = dp;
    result_.tool_axis = dv;
  }

  /// The same sum as a twist, gathered from the workpiece back to the tool: every rotation enters once,
  /// so that no squares of sines appear and cancel.
  void walk_to_the_tool() {
    Vector d = Vector::Zero(), e = Vector::Zero();
    for (auto stage = stages_.rbegin(); stage != stages_.rend(); ++stage) {
      switch (stage->kind) {
        case Stage::Kind::shift:
          // d + e x (x + t) = (d + e x t) + e x x
          d += e.cross(stage->shift).eval();
          break;
        case Stage::Kind::turn:
          d = (stage->turn.transpose() * d).eval();
          e = (stage->turn.transpose() * e).eval();
          break;
        case Stage::Kind::error:
          d += stage->d;
          e += stage->e;
          break;
      }
    }
    result_.twist_d = d;
    result_.twist_e = e;
  }

  const Machine& machine_;
  Derivation result_;
  GroupIndex groups_;
  std::vector<FactorSymbols> factors_;
  std::vector<Stage> stages_;
};

}  // namespace

Derivation derive(const Machine& machine) { return Deriver(machine).derive(); }

Machine with_inventory(const Machine& machine) {
  Machine full = machine;
  for (const std::string& text : error_inventory(machine)) {
    const std::optional<ErrorName> name = read_error_name(text);
    if (!name) continue;
    const bool given = std::any_of(full.errors.begin(), full.errors.end(),
                                   [&](const ErrorTerm& error) { return error.name == *name; });
    const auto body = std::find_if(full.bodies.begin(), full.bodies.end(),
                                   [&](const Body& b) { return b.name == name->axis; });
    if (given || body == full.bodies.end()) continue;
    ErrorTerm error;
    error.name = *name;
    error.body = static_cast<int>(body - full.bodies.begin());
    error.function = ErrorFunction::constant(1.0);
    full.errors.push_back(std::move(error));
  }
  return full;
}

}  // namespace abbe
