// The last lines of fixed_topology_*.cpp: the kernel's code, told at compile time which steps it walks. No
// #pragma once: one inclusion per file.

#include <utility>

#include "abbe/kernel/kernel_correct_single.h"
#include "bench/fixed_topology.h"

namespace abbe::kernel {
namespace {

constexpr FlatStep step_of(FlatStep::Kind kind, FlatStep::About about, int axis, bool moves_on) {
  FlatStep step;
  step.kind = kind;
  step.about = about;
  step.axis = static_cast<std::int8_t>(axis);
  step.moves_on = moves_on;
  return step;
}

using Kind = FlatStep::Kind;
using About = FlatStep::About;
// "w C A Y b X Z t", from the tool to the workpiece; axes C A Y X Z are number 0 to 4.
constexpr FlatStep kSteps[] = {
    step_of(Kind::tip, About::z, -1, false),  step_of(Kind::twist, About::z, -1, false),
    step_of(Kind::slide, About::z, 4, false), step_of(Kind::twist, About::x, -1, false),
    step_of(Kind::slide, About::x, 3, false), step_of(Kind::fixed_twist, About::other, -1, false),
    step_of(Kind::slide, About::y, 2, false), step_of(Kind::twist, About::y, -1, true),
    step_of(Kind::turn, About::x, 1, false),  step_of(Kind::twist, About::x, -1, true),
    step_of(Kind::turn, About::z, 0, false),  step_of(Kind::twist, About::z, -1, false),
};
constexpr std::uint32_t kStepCount = sizeof kSteps / sizeof kSteps[0];
constexpr FreeAxes kFreeAxes = {{2, 3, 4}, {0, 1}, 2};

/// The plan is the machine above.
bool is_known(const FlatView& plan) {
  if (plan.single_count != kStepCount || plan.axis_count != 5 || plan.rotary != 3) return false;
  for (std::uint32_t i = 0; i < kStepCount; ++i) {
    const FlatStep &a = plan.single[i], &b = kSteps[i];
    const bool same = a.kind == b.kind && (a.about == b.about || a.axis < 0) && a.axis == b.axis &&
                      a.moves_on == b.moves_on && a.inverse == b.inverse && a.part == b.part;
    if (!same || (a.kind == Kind::twist) != (a.table != nullptr)) return false;
  }
  return true;
}

/// The numbers of a step of the plan, and of all else what the compiler knows.
template <std::size_t kStep>
[[gnu::always_inline]] inline FlatOpOf<float> known(const FlatView& plan) {
  FlatOpOf<float> op = plan.single[kStep];
  static_cast<FlatStep&>(op) = kSteps[kStep];
  if constexpr (kSteps[kStep].kind == Kind::twist) {
    op.table = plan.single[kStep].table;
    if (op.table == nullptr) __builtin_unreachable();
  }
  return op;
}

template <std::size_t... kStep>
[[gnu::always_inline]] inline void take_all(const FlatView& plan, FirstOrderWalk<Single>& walk,
                                            std::index_sequence<kStep...>) {
  (walk.take(known<kStep>(plan)), ...);
}

}  // namespace
}  // namespace abbe::kernel

bool abbe::bench::ABBE_FIXED_FUNCTION(const kernel::FlatView& plan, const kernel::Setting& setting,
                                      const double* const* q, std::size_t count, double* const* corrected,
                                      double* last) {
  using namespace kernel;
  if (!is_known(plan) || setting.free != 31 || count % kSingles != 0) return false;
  FlatView view = plan;
  view.axis_count = 5;
  view.rotary = 3;
  Setting known = setting;
  known.free = 31;
  known.exact_steps = 0;
  Place places[kPlaces];
  const auto walk_known = [](const FlatView& of, const Setting& by, State<Single>& state,
                             FirstOrder<Single>& f) __attribute__((always_inline)) {
    FirstOrderWalk<Single> walk(of, by, state, f);
    take_all(of, walk, std::make_index_sequence<kStepCount>());
    walk.finish();
  };
  for (std::size_t i = 0; i < count; i += kSingles)
    if (!correct_singles(view, known, kFreeAxes, q, i, corrected, last, places, walk_known)) return false;
  return true;
}
