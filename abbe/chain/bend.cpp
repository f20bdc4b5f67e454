#include "abbe/chain/bend.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "abbe/chain/table_bounds.h"

namespace abbe {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kSecondOrder = 1.01;  // products of errors, which the sum above leaves out

}  // namespace

double straight_reach(const Plan& plan, const Tool& tool, double bend) {
  const Plan::Impl& impl = plan.impl();
  if (!impl.terms.empty() || !(bend > 0)) return 0;
  const double lever = chain_length(impl, tool);
  double curvature = 0, jump = 0, reach = kInfinity;
  for (const AxisTable& table : impl.tables) {
    if ((impl.rotary >> table.axis & 1) != 0) continue;
    const TableBounds b = table_bounds(impl, table, lever);
    curvature += b.d2 + b.e2 * lever + 2 * b.e1;
    jump += b.d_jump + b.e_jump * lever;
    reach = std::min(reach, b.knot_distance);
  }
  curvature *= kSecondOrder;
  jump *= kSecondOrder;
  if (!std::isfinite(curvature) || !std::isfinite(jump)) return 0;
  // L^2/8 K + L/4 J = bend
  const double a = curvature / 8, b = jump / 4;
  const double length = a > 0   ? (-b + std::sqrt(b * b + 4 * a * bend)) / (2 * a)
                        : b > 0 ? bend / b
                                : kInfinity;
  return std::min(length, reach);
}

}  // namespace abbe
