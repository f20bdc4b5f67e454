#include "abbe/volume/diagonals.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "abbe/chain/predict.h"

namespace abbe {
namespace {

[[nodiscard]] std::optional<Diagonal> along(const Plan& plan, const Tool& tool, Diagonal d) {
  Query query;
  query.tool = tool;
  std::array<signed char, kMaxAxes> forward{}, backward{};
  for (std::size_t k = 0; k < d.axes.size(); ++k) {
    const auto axis = static_cast<std::size_t>(d.axes[k]);
    forward[axis] = static_cast<signed char>(d.signs[k]);
    backward[axis] = static_cast<signed char>(-d.signs[k]);
  }
  std::vector<Vec3> nominal, there, back;
  for (std::size_t i = 0; i < kDiagonalPoints; ++i) {
    query.q = d.from;
    const double part = static_cast<double>(i) / static_cast<double>(kDiagonalPoints - 1);
    for (const int axis : d.axes) {
      const auto a = static_cast<std::size_t>(axis);
      query.q[a] = d.from[a] * (1 - part) + d.to[a] * part;
    }
    query.approach = forward;
    const Prediction f = predict(plan, query);
    query.approach = backward;
    const Prediction b = predict(plan, query);
    if (!f.finite || !b.finite) return std::nullopt;
    nominal.push_back(f.nominal.position);
    there.push_back(f.deviation.position);
    back.push_back(b.deviation.position);
  }
  const Vec3 line = nominal.back() - nominal.front();
  d.length = line.norm();
  if (!(d.length > 0) || !std::isfinite(d.length)) return std::nullopt;
  const Vec3 u = line / d.length, start = (there[0] + back[0]) / 2;
  double least = 0, most = 0;
  for (std::size_t i = 0; i < nominal.size(); ++i) {
    // (1)
    const Diagonal::Point point{u.dot(nominal[i] - nominal[0]), u.dot(there[i] - start),
                                u.dot(back[i] - start)};
    const auto [lo, hi] = std::minmax(point.forward, point.backward);
    least = i == 0 ? lo : std::min(least, lo);
    most = i == 0 ? hi : std::max(most, hi);
    d.reversal = std::max(d.reversal, hi - lo);
    d.points.push_back(point);
  }
  d.range = most - least;
  d.change = (d.points.back().forward + d.points.back().backward) / 2;
  return d;
}

}  // namespace

std::string name_of(const Diagonal& diagonal, const Machine& machine) {
  std::string name;
  for (std::size_t k = 0; k < diagonal.axes.size(); ++k) {
    name += k > 0 ? " " : "";
    name += diagonal.signs[k] > 0 ? '+' : '-';
    name += machine.axis(diagonal.axes[k]).name;
  }
  return name;
}

std::vector<int> diagonal_axes(const Machine& machine, const VolumeGrid& grid) {
  std::vector<std::tuple<bool, bool, std::string, int>> found;
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& axis = machine.axis(i);
    if (axis.type != AxisType::linear || !grid.varies(i)) continue;
    const bool second = axis.name.find_first_of("UVW") != std::string::npos;
    found.emplace_back(axis.name.find_first_of("0123456789") != std::string::npos, second, axis.name, i);
  }
  std::sort(found.begin(), found.end());
  if (found.size() > 3) found.resize(3);
  std::sort(found.begin(), found.end(),
            [](const auto& a, const auto& b) { return std::get<2>(a) < std::get<2>(b); });
  std::vector<int> axes;
  for (const auto& entry : found) axes.push_back(std::get<3>(entry));
  return axes;
}

std::vector<Diagonal> diagonals(const Plan& plan, const VolumeGrid& grid, const Tool& tool,
                                const std::array<double, kMaxAxes>& rest) {
  const std::vector<int> axes = diagonal_axes(plan.machine(), grid);
  std::vector<Diagonal> result;
  const auto add = [&](const std::vector<int>& moving, const std::vector<int>& signs) {
    Diagonal d;
    d.axes = moving;
    d.signs = signs;
    d.from = d.to = rest;
    for (std::size_t k = 0; k < moving.size(); ++k) {
      const auto a = static_cast<std::size_t>(moving[k]);
      const auto [lo, hi] = std::minmax_element(grid.positions[a].begin(), grid.positions[a].end());
      d.from[a] = signs[k] > 0 ? *lo : *hi;
      d.to[a] = signs[k] > 0 ? *hi : *lo;
    }
    if (std::optional<Diagonal> measured = along(plan, tool, std::move(d)))
      result.push_back(std::move(*measured));
  };
  for (std::size_t a = 0; a < axes.size(); ++a) {
    for (std::size_t b = a + 1; b < axes.size(); ++b) {
      add({axes[a], axes[b]}, {1, 1});
      add({axes[a], axes[b]}, {-1, 1});
    }
  }
  if (axes.size() == 3) {
    add(axes, {1, 1, 1});
    add(axes, {-1, 1, 1});
    add(axes, {1, -1, 1});
    add(axes, {1, 1, -1});
  }
  return result;
}

}  // namespace abbe
