#include "abbe/part/machined_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

namespace abbe {
namespace {

constexpr std::uint32_t kLeaf = 4;
constexpr std::size_t kDeepest = 64;  // halves of at most 2^32 pieces

/// The ray with 1 / n, for slabs.
struct Slabs {
  Vec3 p, inverse;
  double low;
};

/// Where the line enters the box, at least `low`; infinity if it does not before `high`.
double entry_of_box(const Vec3& box_low, const Vec3& box_high, const Slabs& ray, double high) {
  double in = ray.low, out = high;
  for (Eigen::Index k = 0; k < 3; ++k) {
    double a = (box_low[k] - ray.p[k]) * ray.inverse[k], b = (box_high[k] - ray.p[k]) * ray.inverse[k];
    if (a > b) std::swap(a, b);
    in = std::max(in, a);
    out = std::min(out, b);
  }
  return in <= out ? in : std::numeric_limits<double>::infinity();
}

}  // namespace

/// The corners of both ends: discs of the cutter's radius at the tip and at the top.
MachinedSurface::Box MachinedSurface::box_of(const SweepPiece& piece) const {
  const double turned = (piece.to.axis - piece.from.axis).squaredNorm() * cutter_.length;
  Box box{piece.from.tip, piece.from.tip};
  for (const ToolPose* pose : {&piece.from, &piece.to}) {
    // A disc across a reaches radius sqrt(1 - a_k^2) along axis k.
    const Vec3 disc = cutter_.radius * (Vec3::Ones() - pose->axis.cwiseAbs2()).cwiseMax(0).cwiseSqrt();
    const Vec3 top = pose->tip + (cutter_.length + cutter_.corner) * pose->axis;
    box.low = box.low.cwiseMin(pose->tip - disc).cwiseMin(top - disc);
    box.high = box.high.cwiseMax(pose->tip + disc).cwiseMax(top + disc);
  }
  box.low.array() -= turned;
  box.high.array() += turned;
  return box;
}

MachinedSurface::MachinedSurface(const Cutter& cutter, std::vector<SweepPiece> pieces)
    : cutter_(cutter), pieces_(std::move(pieces)) {
  if (pieces_.empty()) return;
  std::vector<Box> boxes;
  boxes.reserve(pieces_.size());
  for (const SweepPiece& piece : pieces_) boxes.push_back(box_of(piece));
  std::vector<std::uint32_t> order(pieces_.size());
  std::iota(order.begin(), order.end(), 0u);
  nodes_.reserve(pieces_.size());
  nodes_.push_back({{}, 0, static_cast<std::uint32_t>(pieces_.size())});
  for (std::size_t node = 0; node < nodes_.size(); ++node) split(node, boxes, order);
  std::vector<SweepPiece> sorted;
  sorted.reserve(pieces_.size());
  for (const std::uint32_t k : order) sorted.push_back(pieces_[k]);
  pieces_ = std::move(sorted);
}

/// Takes the box of the node's pieces, and halves them at the median of the longest extent of their middles.
void MachinedSurface::split(std::size_t node, const std::vector<Box>& boxes,
                            std::vector<std::uint32_t>& order) {
  const std::uint32_t first = nodes_[node].first, count = nodes_[node].count;
  Box all = boxes[order[first]];
  Vec3 low = all.low + all.high, high = low;  // of the middles, times 2
  for (std::uint32_t k = first; k < first + count; ++k) {
    const Box& box = boxes[order[k]];
    all = {all.low.cwiseMin(box.low), all.high.cwiseMax(box.high)};
    low = low.cwiseMin(box.low + box.high);
    high = high.cwiseMax(box.low + box.high);
  }
  nodes_[node].box = all;
  if (count <= kLeaf) return;
  Eigen::Index axis = 0;
  (high - low).maxCoeff(&axis);
  const std::uint32_t half = count / 2;
  const auto begin = order.begin() + first;
  std::nth_element(begin, begin + half, begin + count, [&](std::uint32_t a, std::uint32_t b) {
    const double x = boxes[a].low[axis] + boxes[a].high[axis], y = boxes[b].low[axis] + boxes[b].high[axis];
    return x != y ? x < y : a < b;
  });
  const auto children = static_cast<std::uint32_t>(nodes_.size());
  nodes_.push_back({{}, first, half});
  nodes_.push_back({{}, first + half, count - half});
  nodes_[node].first = children;
  nodes_[node].count = 0;
}

std::optional<double> MachinedSurface::deviation(const Vec3& point, const Vec3& normal, double reach) const {
  if (nodes_.empty()) return std::nullopt;
  // A component 0 of n makes slabs of +-infinity; 1e-300 keeps them off 0 * infinity.
  const auto inverse = [](double n) { return 1 / (std::abs(n) > 1e-300 ? n : 1e-300); };
  const Slabs slabs{point, Vec3(inverse(normal.x()), inverse(normal.y()), inverse(normal.z())), -reach};
  Ray ray{point, normal, -reach, reach};
  std::optional<double> best;
  std::array<std::pair<double, std::uint32_t>, kDeepest> stack;
  std::size_t waiting = 0;
  const auto wait = [&](double entry, std::uint32_t node) {
    if (entry <= ray.high) stack[waiting++] = {entry, node};
  };
  wait(entry_of_box(nodes_[0].box.low, nodes_[0].box.high, slabs, ray.high), 0);
  while (waiting > 0) {
    const auto [entry, index] = stack[--waiting];
    if (entry > ray.high) continue;
    const Node& node = nodes_[index];
    for (std::uint32_t k = node.first; k < node.first + node.count; ++k) {
      const std::optional<double> found = entry_of(cutter_, pieces_[k], ray);
      if (found) best = ray.high = *found;
    }
    if (ray.high <= ray.low) return best;
    if (node.count > 0) continue;
    const Node &a = nodes_[node.first], &b = nodes_[node.first + 1];
    const double in_a = entry_of_box(a.box.low, a.box.high, slabs, ray.high);
    const double in_b = entry_of_box(b.box.low, b.box.high, slabs, ray.high);
    wait(std::max(in_a, in_b), in_a < in_b ? node.first + 1 : node.first);
    wait(std::min(in_a, in_b), in_a < in_b ? node.first : node.first + 1);
  }
  return best;
}

}  // namespace abbe
