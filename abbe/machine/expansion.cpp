#include "abbe/machine/expansion.h"

#include <algorithm>
#include <utility>

namespace abbe {
namespace {

/// Place of the one static factor of a body that acts behind its motion; nullopt if there is none such.
std::optional<Factor> static_factor(const Body& body) {
  std::optional<Factor> found;
  bool moved = body.type == AxisType::fixed;
  for (const Factor& factor : body.order) {
    if (factor.kind == FactorKind::motion) moved = true;
    if (factor.kind != FactorKind::component) continue;
    if (found || (!moved && body.type == AxisType::rotary)) return std::nullopt;
    found = factor;
  }
  return found;
}

/// Adds terms to a copy of a machine.
class Expanding {
 public:
  Expanding(const Machine& machine, double strain) : machine_(machine), strain_(strain) {}

  /// Indices of the work branch from the bed outwards.
  [[nodiscard]] std::vector<int> work_branch() const {
    std::vector<int> out;
    for (std::size_t i = machine_.bodies.size(); i-- > 0;)
      if (machine_.bodies[i].branch == Branch::workpiece) out.push_back(static_cast<int>(i));
    return out;
  }

  std::optional<std::string> expand() {
    const std::vector<int> work = work_branch();
    for (std::size_t k = 0; k < work.size(); ++k) {
      const Vec3 next = k + 1 < work.size() ? body(work[k + 1]).origin : machine_.workpiece_origin;
      if (auto why = move(work[k], next - body(work[k]).origin)) return why;
    }
    for (std::size_t i = 0; i < machine_.bodies.size(); ++i) {
      if (machine_.bodies[i].branch != Branch::tool) continue;
      if (machine_.bodies[i].type == AxisType::rotary)
        return machine_.bodies[i].name + " turns the tool, whose length would be scaled with the workpiece";
      if (auto why = move(static_cast<int>(i), Vec3::Zero())) return why;
    }
    const Vec3 centre = work.empty() ? machine_.workpiece_origin : body(work.front()).origin;
    const Vec3 tip = machine_.tool.origin - machine_.tool.length * machine_.tool.axis;
    for (int c = 0; c < 3; ++c) add(c, kToolBody, "t", -strain_ * (tip - centre)[c], 0, -1);
    return std::nullopt;
  }

  [[nodiscard]] Machine take() { return std::move(machine_); }

 private:
  [[nodiscard]] const Body& body(int i) const { return machine_.bodies[static_cast<std::size_t>(i)]; }

  /// d = -s (q u + offset) of one body, in its own frame.
  std::optional<std::string> move(int index, const Vec3& offset) {
    const Body& b = body(index);
    const Vec3 way = b.type == AxisType::linear ? b.direction : Vec3(Vec3::Zero());
    if (way.isZero(0) && offset.isZero(0)) return std::nullopt;
    const auto factor = static_factor(b);
    if (!factor) return "the order of " + b.name + " leaves no place for it";
    const double sign = factor->inverse != b.errors_seen_at_tool ? -1 : 1;
    const double unit = b.axis >= 0 ? machine_.axis_unit(b.axis) : 1;
    const std::string name = b.name;
    for (int c = 0; c < 3; ++c)
      add(c, index, name, -sign * strain_ * offset[c], -sign * strain_ * way[c] * unit, b.axis);
    return std::nullopt;
  }

  /// constant + slope * position, mm
  void add(int direction, int index, const std::string& name, double constant, double slope, int variable) {
    if (constant == 0 && slope == 0) return;
    ErrorTerm term;
    term.name = {ErrorClass::component, direction, name};
    term.body = index;
    term.function = slope == 0
                        ? ErrorFunction::constant(constant)
                        : ErrorFunction::polynomial(variable, {constant, slope}).value_or(ErrorFunction());
    machine_.errors.push_back(std::move(term));
  }

  Machine machine_;
  double strain_;
};

}  // namespace

std::variant<Machine, std::string> with_expansion(const Machine& machine,
                                                  const WorkpieceExpansion& expansion) {
  Expanding expanding(machine, expansion.strain());
  if (auto why = expanding.expand()) return std::move(*why);
  return expanding.take();
}

}  // namespace abbe
