#pragma once

#include <Eigen/Core>

namespace abbe {

/// Points, displacements and rotation vectors: 3 numbers in the axes that the name of the variable
/// says (`p_wt`: of the tool point in workpiece axes). Lengths in mm, rotations in rad.
template <class T>
using Vec3T = Eigen::Matrix<T, 3, 1>;
template <class T>
using Mat3T = Eigen::Matrix<T, 3, 3>;

using Vec3 = Vec3T<double>;
using Mat3 = Mat3T<double>;

}  // namespace abbe
