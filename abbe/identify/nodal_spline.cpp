#include "abbe/identify/nodal_spline.h"

#include <algorithm>
#include <cmath>

#include "abbe/errors/spline.h"

namespace abbe {

NodalSpline::NodalSpline(std::array<double, 2> travel, int count, int node)
    : values_(static_cast<std::size_t>(count), 0.0) {
  for (int i = 0; i < count; ++i)
    nodes_.push_back(i + 1 == count ? travel[1] : travel[0] + i * (travel[1] - travel[0]) / (count - 1));
  values_[static_cast<std::size_t>(node)] = 1;
  curvatures_ = natural_spline(nodes_, values_);
  // trend: slope = 3 mean(f x) / L with q = m + L x; three Gauss points an interval are exact for cubics
  // times x
  const double m = (travel[0] + travel[1]) / 2, L = (travel[1] - travel[0]) / 2, h = nodes_[1] - nodes_[0];
  double moment = 0;
  for (std::size_t i = 0; i + 1 < nodes_.size(); ++i) {
    const double middle = nodes_[i] + h / 2, off = std::sqrt(0.6) * h / 2;
    for (const auto& [q, weight] : {std::array{middle - off, 5.0}, {middle, 8.0}, {middle + off, 5.0}})
      moment += weight / 18 * spline(q) * (q - m) / L / (count - 1);
  }
  slope_ = 3 * moment / L;
  offset_ = spline(m) - slope_ * m;
}

/// f = a y_k + b y_(k+1) + h^2 / 6 ((a^3 - a) M_k + (b^3 - b) M_(k+1))
double NodalSpline::spline(double q) const {
  const double h = nodes_[1] - nodes_[0];
  const auto last = static_cast<double>(nodes_.size() - 2);
  const auto k = static_cast<std::size_t>(std::clamp(std::floor((q - nodes_[0]) / h), 0.0, last));
  const double b = (q - nodes_[k]) / h, a = 1 - b;
  return a * values_[k] + b * values_[k + 1] +
         h * h / 6 * ((a * a * a - a) * curvatures_[k] + (b * b * b - b) * curvatures_[k + 1]);
}

double NodalSpline::operator()(double q) const {
  const double held = std::clamp(q, nodes_.front(), nodes_.back());
  return spline(held) - (offset_ + slope_ * held);
}

}  // namespace abbe
