#pragma once

#include <Eigen/Core>
#include <vector>

namespace abbe {

/// Correlation of two columns of mean 0; 0 if one of them does not change.
[[nodiscard]] double correlation(const Eigen::VectorXd& a, const Eigen::VectorXd& b);

/// Sensors that say nearly the same: groups of columns such that every member's correlation with some other
/// member is above `threshold` (single linkage), in the order of their first members. Columns of mean 0; one
/// that does not change is in no group.
/// laws     GroupsAreTheConnectedOnes
/// cost     sensors^2 * rows
[[nodiscard]] std::vector<std::vector<std::size_t>> sensor_groups(const Eigen::MatrixXd& columns,
                                                                  double threshold);

}  // namespace abbe
