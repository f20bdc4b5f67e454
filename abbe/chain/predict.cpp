#include "abbe/chain/predict.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/chain/plan_impl.h"
#include "abbe/chain/query_variables.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

/// True if no number is NaN or infinite.
template <class Derived>
[[nodiscard]] bool finite(const Eigen::MatrixBase<Derived>& x) {
  return (x * 0.0).eval().cwiseEqual(0.0).all();
}

struct Poses {
  Pose nominal, actual;
  Vec3 d_w = Vec3::Zero(), e_w = Vec3::Zero();  ///< first order: twist at the tip, workpiece axes
};

[[nodiscard]] Carried<double, 3> unit_frame() {
  Carried<double, 3> c;
  c.v = {Vec3::UnitX(), Vec3::UnitY(), Vec3::UnitZ()};
  return c;
}

[[nodiscard]] Pose pose_of(const Carried<double, 3>& c) {
  Pose pose;
  pose.R << c.v[0], c.v[1], c.v[2];
  pose.p = c.p;
  return pose;
}

[[nodiscard]] Mat3 cross_matrix(const Vec3& e) {
  Mat3 m;
  m << 0, -e.z(), e.y(), e.z(), 0, -e.x(), -e.y(), e.x(), 0;
  return m;
}

[[nodiscard]] Pose walk_pose(const Plan::Impl& plan, std::span<const Op> ops, const Inputs<double>& in,
                             bool* outside) {
  Carried<double, 3> c = unit_frame();
  walk<double, 3>(plan, ops, in, c, outside);
  return pose_of(c);
}

[[nodiscard]] CarriedTwist<double, 3> first_order_pose(const Plan::Impl& plan, const Inputs<double>& in,
                                                       bool* outside) {
  CarriedTwist<double, 3> c;
  static_cast<Carried<double, 3>&>(c) = unit_frame();
  walk_first_order<double, 3>(plan, in, c, outside);
  return c;
}

/// Rotation vector of R: the axial vector scaled by angle / sin(angle), near half a turn from the
/// symmetric part.
[[nodiscard]] Vec3 rotation_log(const Mat3& r) {
  const Vec3 axial = 0.5 * Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1));
  const double sine = axial.norm(), cosine = 0.5 * (r.trace() - 1);
  if (cosine > 0) return sine < 1e-8 ? axial : Vec3(axial * (std::atan2(sine, cosine) / sine));
  const Eigen::AngleAxisd a(r);
  return a.angle() * a.axis();
}

[[nodiscard]] Twist twist_between(const Pose& nominal, const Pose& actual, ErrorModel model) {
  const Mat3 r = nominal.R.transpose() * actual.R;
  Twist twist;
  twist.d = nominal.R.transpose() * (actual.p - nominal.p);
  twist.e = model == ErrorModel::linear
                ? Vec3(0.5 * Vec3(r(2, 1) - r(1, 2), r(0, 2) - r(2, 0), r(1, 0) - r(0, 1)))
                : rotation_log(r);
  return twist;
}

[[nodiscard]] std::vector<std::string> extrapolated_errors(const Plan::Impl& plan, const Query& query) {
  const QueryVariables read = query_variables(plan, query);
  std::vector<std::string> names;
  for (const ErrorTerm& error : plan.machine->errors) {
    bool outside = false;
    // The flag is wanted, not the value.
    static_cast<void>(error.function.value<double>(read.values.data(), read.approach.data(), &outside));
    std::string name = to_string(error.name);
    if (outside && std::find(names.begin(), names.end(), name) == names.end())
      names.push_back(std::move(name));
  }
  return names;
}

}  // namespace

Prediction predict(const Plan& plan, const Query& query) {
  const Plan::Impl& impl = plan.impl();
  const QueryInputs inputs(impl, query);
  bool outside = false;
  const Pose nominal = walk_pose(impl, impl.nominal, inputs.inputs(), &outside);
  const Vec3 axis = query.tool.axis;

  Prediction result;
  result.nominal = {nominal.p, nominal.R * axis};
  if (impl.model == ErrorModel::first_order) {
    const CarriedTwist<double, 3> c = first_order_pose(impl, inputs.inputs(), &outside);
    // Delta p = d_w, Delta a = e_w x a;  D_tool = R_wt^T (d_w; e_w)
    result.deviation = {c.dp, c.e.cross(result.nominal.tool_axis)};
    result.actual = {nominal.p + c.dp, result.nominal.tool_axis + result.deviation.tool_axis};
    result.tool_twist = {nominal.R.transpose() * c.dp, nominal.R.transpose() * c.e};
  } else {
    const Pose actual = walk_pose(impl, impl.actual, inputs.inputs(), &outside);
    result.actual = {actual.p, actual.R * axis};
    result.deviation = {actual.p - nominal.p, result.actual.tool_axis - result.nominal.tool_axis};
    result.tool_twist = twist_between(nominal, actual, impl.model);
  }
  const bool all_finite = finite(result.nominal.position) && finite(result.nominal.tool_axis) &&
                          finite(result.actual.position) && finite(result.actual.tool_axis) &&
                          finite(result.deviation.position) && finite(result.deviation.tool_axis) &&
                          finite(result.tool_twist.d) && finite(result.tool_twist.e);
  if (!all_finite) {
    result = Prediction{};
    result.finite = false;
    return result;
  }
  if (outside || impl.constant_outside) result.extrapolated = extrapolated_errors(impl, query);
  return result;
}

Pose nominal_pose(const Plan& plan, const Query& query) {
  const Plan::Impl& impl = plan.impl();
  Inputs<double> in;
  in.q = query.q.data();
  in.tip = query.tool.tip;
  const Pose pose = walk_pose(impl, impl.nominal, in, nullptr);
  return finite(pose.p) && finite(pose.R) ? pose : Pose{};
}

Pose actual_pose(const Plan& plan, const Query& query, bool* outside) {
  const Plan::Impl& impl = plan.impl();
  const QueryInputs inputs(impl, query);
  bool beyond = impl.constant_outside;
  Pose pose;
  if (impl.model == ErrorModel::first_order) {
    const CarriedTwist<double, 3> c = first_order_pose(impl, inputs.inputs(), &beyond);
    pose = pose_of(c);
    pose.p += c.dp;
    pose.R += (cross_matrix(c.e) * pose.R).eval();
  } else {
    pose = walk_pose(impl, impl.actual, inputs.inputs(), &beyond);
  }
  if (outside != nullptr && beyond) *outside = true;
  return finite(pose.p) && finite(pose.R) ? pose : Pose{};
}

Vec3 nominal_tip(const Plan& plan, const Query& query) {
  const Plan::Impl& impl = plan.impl();
  Inputs<double> in;
  in.q = query.q.data();
  in.tip = query.tool.tip;
  Carried<double, 0> c;
  walk<double, 0>(impl, impl.nominal, in, c, nullptr);
  return finite(c.p) ? c.p : Vec3(Vec3::Zero());
}

Vec3 actual_tip(const Plan& plan, const Query& query, bool* outside) {
  const Plan::Impl& impl = plan.impl();
  const QueryInputs inputs(impl, query);
  bool beyond = impl.constant_outside;
  Vec3 tip;
  if (impl.model == ErrorModel::first_order) {
    CarriedTwist<double, 0> c;
    walk_first_order<double, 0>(impl, inputs.inputs(), c, &beyond);
    tip = c.p + c.dp;
  } else {
    Carried<double, 0> c;
    walk<double, 0>(impl, impl.actual, inputs.inputs(), c, &beyond);
    tip = c.p;
  }
  if (outside != nullptr && beyond) *outside = true;
  return finite(tip) ? tip : Vec3(Vec3::Zero());
}

Jacobian jacobian(const Plan& plan, const Query& query) {
  const Plan::Impl& impl = plan.impl();
  Inputs<double> in;
  in.q = query.q.data();
  in.tip = query.tool.tip;
  CarriedColumns c;
  c.v[0] = query.tool.axis;
  walk_columns(impl, in, c);
  Jacobian j;
  j.position = c.position.leftCols(impl.axis_count);
  j.tool_axis = c.tool_axis.leftCols(impl.axis_count);
  if (!finite(j.position) || !finite(j.tool_axis)) {
    j.position.setZero();
    j.tool_axis.setZero();
  }
  return j;
}

}  // namespace abbe
