#include "abbe/chain/chain_steps.h"

#include <utility>

namespace abbe {
namespace {

/// T_wt = T_bw^-1 T_bt read from the right: tool mounting, tool branch from the tool to the bed, then
/// the inverses of the workpiece branch from the bed to the workpiece.
class ChainBuilder {
 public:
  ChainBuilder(const Machine& machine, const GroupIndex& groups) : machine_(machine), groups_(groups) {}

  [[nodiscard]] std::vector<Step> build() {
    add_error(kToolBody, ErrorClass::component, Part::all, false, Vec3::UnitZ());
    steps_.push_back({Step::Kind::tip, Vec3::Zero(), nullptr, -1, Part::all, false});
    translate(-last_origin(Branch::tool));
    const int count = static_cast<int>(machine_.bodies.size());
    for (int i = count - 1; i >= 0; --i) {
      const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
      if (body.branch != Branch::tool) continue;
      for (auto factor = body.order.rbegin(); factor != body.order.rend(); ++factor)
        add_factor(i, *factor, false);
      translate(body.origin - lower_origin(i));
    }
    for (int i = count - 1; i >= 0; --i) {
      const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
      if (body.branch != Branch::workpiece) continue;
      translate(-(body.origin - lower_origin(i)));
      for (const Factor& factor : body.order) add_factor(i, factor, true);
    }
    translate(-(machine_.workpiece_origin - last_origin(Branch::workpiece)));
    add_error(kWorkpieceBody, ErrorClass::component, Part::all, true, Vec3::UnitZ());
    return std::move(steps_);
  }

 private:
  /// Bodies are in chain order w .. b .. t: the outermost one of a branch is the first or the last.
  [[nodiscard]] Vec3 last_origin(Branch branch) const {
    if (branch == Branch::workpiece) {
      return !machine_.bodies.empty() && machine_.bodies.front().branch == branch
                 ? machine_.bodies.front().origin
                 : Vec3(Vec3::Zero());
    }
    return !machine_.bodies.empty() && machine_.bodies.back().branch == branch ? machine_.bodies.back().origin
                                                                               : Vec3(Vec3::Zero());
  }

  [[nodiscard]] Vec3 lower_origin(int i) const {
    const Branch branch = machine_.bodies[static_cast<std::size_t>(i)].branch;
    const int lower = branch == Branch::tool ? i - 1 : i + 1;
    if (lower < 0 || lower >= static_cast<int>(machine_.bodies.size())) return Vec3::Zero();
    const Body& body = machine_.bodies[static_cast<std::size_t>(lower)];
    return body.branch == branch ? body.origin : Vec3(Vec3::Zero());
  }

  void translate(const Vec3& by) {
    if (by != Vec3::Zero()) steps_.push_back({Step::Kind::translate, by, nullptr, -1, Part::all, false});
  }

  /// `undo`: the body is on the workpiece branch, its matrices act inverted.
  void add_factor(int i, const Factor& factor, bool undo) {
    const Body& body = machine_.bodies[static_cast<std::size_t>(i)];
    const bool inverse = factor.inverse != undo;
    const bool seen_inverse = inverse != body.errors_seen_at_tool;
    switch (factor.kind) {
      case FactorKind::motion:
        if (body.type != AxisType::fixed) {
          steps_.push_back({Step::Kind::motion, body.direction, &body, -1, Part::all, inverse});
        }
        break;
      case FactorKind::location:
        add_error(i, ErrorClass::location, Part::all, inverse, body.direction);
        break;
      case FactorKind::along:
        add_error(i, ErrorClass::location, Part::along, inverse, body.direction);
        break;
      case FactorKind::across:
        add_error(i, ErrorClass::location, Part::across, inverse, body.direction);
        break;
      case FactorKind::thermal:
        add_error(i, ErrorClass::thermal, Part::all, seen_inverse, body.direction);
        break;
      case FactorKind::component:
        add_error(i, ErrorClass::component, Part::all, seen_inverse, body.direction);
        break;
      case FactorKind::dynamic:
        add_error(i, ErrorClass::dynamic, Part::all, seen_inverse, body.direction);
        break;
    }
  }

  void add_error(int body, ErrorClass error_class, Part part, bool inverse, const Vec3& direction) {
    const auto group = groups_.find({body, error_class});
    if (group == groups_.end()) return;
    steps_.push_back({Step::Kind::error, direction, nullptr, group->second, part, inverse});
  }

  const Machine& machine_;
  const GroupIndex& groups_;
  std::vector<Step> steps_;
};

}  // namespace

std::vector<Step> chain_steps(const Machine& machine, const GroupIndex& groups) {
  return ChainBuilder(machine, groups).build();
}

}  // namespace abbe
