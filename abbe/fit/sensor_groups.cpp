#include "abbe/fit/sensor_groups.h"

#include <cmath>

namespace abbe {

double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const double length = a.norm() * b.norm();
  return length > 0 ? a.dot(b) / length : 0;
}

std::vector<std::vector<std::size_t>> sensor_groups(const Eigen::MatrixXd& columns, double threshold) {
  const auto count = static_cast<std::size_t>(columns.cols());
  std::vector<bool> placed(count, false);
  std::vector<std::vector<std::size_t>> groups;
  for (std::size_t first = 0; first < count; ++first) {
    if (placed[first] || !(columns.col(static_cast<Eigen::Index>(first)).norm() > 0)) continue;
    std::vector<std::size_t> group = {first};
    placed[first] = true;
    for (std::size_t k = 0; k < group.size(); ++k)
      for (std::size_t other = first + 1; other < count; ++other) {
        if (placed[other] ||
            !(std::abs(correlation(columns.col(static_cast<Eigen::Index>(group[k])),
                                   columns.col(static_cast<Eigen::Index>(other)))) > threshold))
          continue;
        placed[other] = true;
        group.push_back(other);
      }
    groups.push_back(std::move(group));
  }
  return groups;
}

}  // namespace abbe
