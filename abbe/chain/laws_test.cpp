#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>
#include <limits>

#include "abbe/chain/correct.h"
#include "abbe/chain/inverse.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/chain/walk.h"

namespace abbe {
namespace {

using Mat4 = Eigen::Matrix4d;
using Commands = std::array<double, kMaxAxes>;

constexpr double kReferenceLength = 1e-9;  // mm, walk against products of 4x4 matrices with levers of 1 m
constexpr double kReferenceAxis = 1e-13;
const Environment kWarm = {{"T1", 23.5}};

Plan plan_of(const Machine& machine, ErrorModel model) {
  return std::get<Plan>(make_plan(machine, kWarm, model));
}

Mat3 cross_matrix(const Vec3& e) {
  Mat3 m;
  m << 0, -e.z(), e.y(), e.z(), 0, -e.x(), -e.y(), e.x(), 0;
  return m;
}

Mat4 matrix(const Mat3& r, const Vec3& p) {
  Mat4 m = Mat4::Identity();
  m.topLeftCorner<3, 3>() = r;
  m.topRightCorner<3, 1>() = p;
  return m;
}

/// The definition: products of 4x4 matrices, left to right, inverted by a general inverse.
class Reference {
 public:
  Reference(const Machine& machine, const Query& query, ErrorModel model, bool with_errors)
      : machine_(machine), query_(query), model_(model), with_errors_(with_errors) {
    for (const Variable& v : machine.variables)
      variables_.push_back(v.axis >= 0 ? query.q[static_cast<std::size_t>(v.axis)] / machine.axis_unit(v.axis)
                                       : kWarm.at(v.name));
    approach_.assign(query.approach.begin(), query.approach.end());
    approach_.resize(std::max(approach_.size(), variables_.size()));
  }

  Mat4 pose() const {
    Mat4 tool = Mat4::Identity(), work = Mat4::Identity();
    Vec3 tool_origin = Vec3::Zero(), work_origin = Vec3::Zero();
    for (const Body& body : machine_.bodies) {
      if (body.branch == Branch::tool) tool *= body_matrix(body, tool_origin);
    }
    for (auto body = machine_.bodies.rbegin(); body != machine_.bodies.rend(); ++body) {
      if (body->branch == Branch::workpiece) work *= body_matrix(*body, work_origin);
    }
    tool *= matrix(Mat3::Identity(), query_.tool.tip - tool_origin) * mount(kToolBody);
    work *= matrix(Mat3::Identity(), machine_.workpiece_origin - work_origin) * mount(kWorkpieceBody);
    return work.inverse() * tool;
  }

 private:
  std::pair<Vec3, Vec3> error(int body, ErrorClass c) const {
    Vec3 d = Vec3::Zero(), e = Vec3::Zero();
    for (const ErrorTerm& term : machine_.errors) {
      if (!with_errors_ || term.body != body || term.name.error_class != c) continue;
      const double value =
          term.scale * term.function.value<double>(variables_.data(), approach_.data(), nullptr);
      if (term.name.direction < 3)
        d(term.name.direction) += value;
      else
        e(term.name.direction - 3) += value;
    }
    return {d, e};
  }

  Mat4 err(const Vec3& d, const Vec3& e) const {
    if (model_ == ErrorModel::linear) return matrix(Mat3::Identity() + cross_matrix(e), d);
    if (e.norm() == 0) return matrix(Mat3::Identity(), d);
    return matrix(Eigen::AngleAxisd(e.norm(), e.normalized()).toRotationMatrix(), d);
  }

  Mat4 mount(int body) const {
    const auto [d, e] = error(body, ErrorClass::component);
    return err(d, e);
  }

  Mat4 body_matrix(const Body& body, Vec3& lower) const {
    Mat4 m = matrix(Mat3::Identity(), body.origin - lower);
    lower = body.origin;
    const int index = static_cast<int>(&body - machine_.bodies.data());
    const Vec3 u = body.direction;
    const bool rotary = body.type == AxisType::rotary;
    for (const Factor& factor : body.order) {
      Mat4 f = Mat4::Identity();
      switch (factor.kind) {
        case FactorKind::motion: {
          const double q = query_.q[static_cast<std::size_t>(body.axis)];
          f = rotary ? matrix(Eigen::AngleAxisd(q, u).toRotationMatrix(), Vec3::Zero())
                     : matrix(Mat3::Identity(), q * u);
          break;
        }
        case FactorKind::location:
        case FactorKind::along:
        case FactorKind::across: {
          auto [d, e] = error(index, ErrorClass::location);
          const Vec3 across_e = e - u * u.dot(e),
                     across_d = rotary ? Vec3(d - u * u.dot(d)) : Vec3(Vec3::Zero());
          if (factor.kind == FactorKind::across)
            f = err(across_d, across_e);
          else if (factor.kind == FactorKind::along)
            f = err(d - across_d, e - across_e);
          else
            f = err(d, e);
          break;
        }
        case FactorKind::thermal:
        case FactorKind::component:
        case FactorKind::dynamic: {
          const ErrorClass c = factor.kind == FactorKind::thermal     ? ErrorClass::thermal
                               : factor.kind == FactorKind::component ? ErrorClass::component
                                                                      : ErrorClass::dynamic;
          auto [d, e] = error(index, c);
          if (c == ErrorClass::component && body.measured_at) d -= e.cross(*body.measured_at - body.origin);
          f = err(d, e);
          if (body.errors_seen_at_tool) f = f.inverse().eval();
          break;
        }
      }
      m *= factor.inverse ? Mat4(f.inverse()) : f;
    }
    return m;
  }

  const Machine& machine_;
  const Query& query_;
  ErrorModel model_;
  bool with_errors_;
  std::vector<double> variables_;
  std::vector<signed char> approach_;
};

template <class Check>
void on_random_machines(unsigned seed, int count, double length, double angle, Check check) {
  RandomMachine random(seed);
  for (int i = 0; i < count; ++i) {
    SCOPED_TRACE(i);
    const Machine machine = random.make(1 + random.below(4), random.below(4), length, angle);
    check(random, machine);
    if (testing::Test::HasFailure()) return;
  }
}

TEST(Chain, WalkEqualsTheMatrixProduct) {
  // Large errors: every order, part and inverse is seen far above rounding.
  for (const double angle : {1e-4, 0.3}) {
    on_random_machines(1, 60, 0.5, angle, [](RandomMachine& random, const Machine& machine) {
      const Query query = random.query(machine);
      for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear}) {
        const Plan plan = plan_of(machine, model);
        const Mat4 expected = Reference(machine, query, model, true).pose(),
                   ideal = Reference(machine, query, model, false).pose();
        const Pose actual = actual_pose(plan, query), nominal = nominal_pose(plan, query);
        EXPECT_LE((actual.p - expected.topRightCorner<3, 1>()).norm(), kReferenceLength);
        EXPECT_LE((actual.R - expected.topLeftCorner<3, 3>()).norm(), kReferenceAxis * 10);
        EXPECT_LE((nominal.p - ideal.topRightCorner<3, 1>()).norm(), kReferenceLength);
        EXPECT_LE((nominal.R - ideal.topLeftCorner<3, 3>()).norm(), kReferenceAxis);
        EXPECT_LE((actual_tip(plan, query) - actual.p).norm(), 1e-10);
        EXPECT_LE((nominal_tip(plan, query) - nominal.p).norm(), 1e-10);
      }
    });
  }
}

TEST(Chain, NoErrorsActualIsNominal) {
  on_random_machines(2, 40, 0.02, 1e-4, [](RandomMachine& random, Machine machine) {
    machine.errors.clear();
    const Query query = random.query(machine);
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear, ErrorModel::first_order}) {
      const Prediction p = predict(plan_of(machine, model), query);
      EXPECT_EQ(p.deviation.position, Vec3::Zero());
      EXPECT_EQ(p.deviation.tool_axis, Vec3::Zero());
      EXPECT_EQ(p.tool_twist.d, Vec3::Zero());
      EXPECT_LE(p.tool_twist.e.norm(), 1e-15);
    }
  });
}

TEST(Chain, FirstOrderIsLinearInTheErrors) {
  on_random_machines(3, 40, 0.02, 1e-4, [](RandomMachine& random, const Machine& machine) {
    Machine first = machine, second = machine;
    for (std::size_t i = 0; i < machine.errors.size(); ++i) {
      const double share = random.uniform(-2, 2);
      first.errors[i].scale *= share;
      second.errors[i].scale *= 3 * (1 - share);
    }
    const Query query = random.query(machine);
    const auto deviation = [&](const Machine& m) {
      return predict(plan_of(m, ErrorModel::first_order), query);
    };
    const Prediction whole = deviation(machine), a = deviation(first), b = deviation(second);
    EXPECT_LE((whole.deviation.position - a.deviation.position - b.deviation.position / 3).norm(),
              1e-11);  // sines are tabulated to 1e-12 mm each
    EXPECT_LE((whole.tool_twist.e - a.tool_twist.e - b.tool_twist.e / 3).norm(), 1e-14);
  });
}

TEST(Chain, HalvingErrorsQuartersTheFirstOrderGap) {
  on_random_machines(4, 40, 0.5, 1e-3, [](RandomMachine& random, const Machine& machine) {
    Machine half = machine;
    for (ErrorTerm& error : half.errors) error.scale /= 2;
    const Query query = random.query(machine);
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear}) {
      const auto gap = [&](const Machine& m) {
        return Vec3(predict(plan_of(m, model), query).deviation.position -
                    predict(plan_of(m, ErrorModel::first_order), query).deviation.position);
      };
      const Vec3 whole = gap(machine), quarter = gap(half);
      EXPECT_LE((whole - 4 * quarter).norm(), 0.01 * whole.norm() + 1e-7);
    }
  });
}

TEST(Chain, ToolTwistIsTheRelativePose) {
  on_random_machines(5, 30, 0.02, 1e-4, [](RandomMachine& random, const Machine& machine) {
    const Query query = random.query(machine);
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const Prediction p = predict(plan, query);
    const Pose nominal = nominal_pose(plan, query), actual = actual_pose(plan, query);
    const double angle = p.tool_twist.e.norm();
    const Mat3 r = angle == 0 ? Mat3(Mat3::Identity())
                              : Eigen::AngleAxisd(angle, p.tool_twist.e / angle).toRotationMatrix();
    EXPECT_LE((nominal.R * r - actual.R).norm(), 1e-14);
    EXPECT_LE((nominal.p + nominal.R * p.tool_twist.d - actual.p).norm(), 1e-10);
  });
}

TEST(Chain, JacobianEqualsDifference) {
  on_random_machines(6, 40, 0.02, 1e-4, [](RandomMachine& random, const Machine& machine) {
    const Query query = random.query(machine);
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const Jacobian j = jacobian(plan, query);
    constexpr double kStep = 1e-4;
    for (int i = 0; i < machine.axis_count(); ++i) {
      Query up = query, down = query;
      up.q[static_cast<std::size_t>(i)] += kStep;
      down.q[static_cast<std::size_t>(i)] -= kStep;
      const Pose a = nominal_pose(plan, up), b = nominal_pose(plan, down);
      EXPECT_LE((j.position.col(i) - (a.p - b.p) / (2 * kStep)).norm(), 1e-5);
      EXPECT_LE((j.tool_axis.col(i) - (a.R - b.R) * query.tool.axis / (2 * kStep)).norm(), 1e-8);
    }
  });
}

TEST(Chain, DerivativeScalarEqualsDifference) {
  using D = Derivative<kMaxAxes>;
  on_random_machines(7, 30, 0.5, 1e-2, [](RandomMachine& random, const Machine& machine) {
    const Query query = random.query(machine, 300, 2);
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const Plan::Impl& impl = plan.impl();
    std::array<D, kMaxAxes> q;
    std::vector<D> variables(impl.variables.begin(), impl.variables.end());
    std::vector<signed char> approach(variables.size(), 0);
    for (int i = 0; i < machine.axis_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      q[k] = D::variable(query.q[k], i);
      variables[k] = q[k] / D(impl.unit[k]);
      approach[k] = query.approach[k];
    }
    Inputs<D> in;
    in.q = q.data();
    in.variables = variables.data();
    in.approach = approach.data();
    in.tip = query.tool.tip;
    Carried<D, 1> c;
    c.v[0] = query.tool.axis.cast<D>();
    bool outside = false;
    walk<D, 1>(impl, impl.actual, in, c, &outside);
    const Pose here = actual_pose(plan, query);
    constexpr double kStep = 1e-4;
    for (int i = 0; i < machine.axis_count(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      Query up = query, down = query;
      up.q[k] += kStep;
      down.q[k] -= kStep;
      const Pose a = actual_pose(plan, up), b = actual_pose(plan, down);
      for (int row = 0; row < 3; ++row) {
        EXPECT_NEAR(c.p(row).a, here.p(row), 1e-10);
        EXPECT_NEAR(c.p(row).v[k], (a.p(row) - b.p(row)) / (2 * kStep), 2e-5);
        EXPECT_NEAR(c.v[0](row).v[k], ((a.R - b.R) * query.tool.axis)(row) / (2 * kStep), 1e-7);
      }
    }
  });
}

bool restores_everything(const Machine& machine, AxisSet free) {
  int linear = 0, rotary = 0;
  for (int i = 0; i < machine.axis_count(); ++i) {
    if ((free & (AxisSet{1} << i)) != 0) (machine.axis(i).type == AxisType::rotary ? rotary : linear) += 1;
  }
  return linear == 3 && rotary == 2;
}

TEST(Correct, ActualOfCorrectedIsNominal) {
  int ok = 0, whole = 0;
  for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear, ErrorModel::first_order}) {
    RandomMachine random(8);
    for (int i = 0; i < 60; ++i) {
      const Machine machine = random.make(3, random.below(3), 0.02, 5e-5);
      const Plan plan = plan_of(machine, model);
      const AxisSet free = *free_axes(machine, 0);
      for (int k = 0; k < 5; ++k) {
        SCOPED_TRACE(testing::Message() << static_cast<int>(model) << " " << i << " " << k);
        const Query query = random.query(machine);
        const Correction c = correct(plan, query, free, {});
        EXPECT_NE(c.status, Status::failed);
        if (c.status != Status::ok) continue;
        ++ok;
        Query there = query;
        there.q = c.corrected;
        const Pose nominal = nominal_pose(plan, query), actual = actual_pose(plan, there);
        EXPECT_LE((actual.p - nominal.p).norm(), 1e-9);
        EXPECT_LE(c.residual_position, 1e-9);
        const Vec3 a = actual.R * query.tool.axis, n = nominal.R * query.tool.axis;
        const double angle = std::atan2(a.cross(n).norm(), a.dot(n));
        EXPECT_NEAR(c.residual_direction, angle, 1e-9 + 1e-4 * angle);
        if (!restores_everything(machine, free)) continue;
        ++whole;
        EXPECT_LE(angle, 1e-12);
        EXPECT_LE(c.residual_direction, 1e-12);
      }
    }
  }
  EXPECT_GT(ok, 850);
  EXPECT_GT(whole, 200);
}

TEST(Correct, ZeroErrorsChangeNothing) {
  on_random_machines(9, 40, 0.02, 1e-4, [](RandomMachine& random, Machine machine) {
    machine.errors.clear();
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const AxisSet free = free_axes(machine, 0).value_or(0);
    Query query = random.query(machine);
    for (const bool home : {false, true}) {
      if (home) query.q = {};
      const Correction c = correct(plan, query, free, {});
      EXPECT_EQ(c.status, Status::ok);
      EXPECT_EQ(c.corrected, query.q);
      EXPECT_EQ(c.residual_position, 0);
      EXPECT_EQ(c.residual_direction, 0);
    }
  });
}

TEST(Correct, WarmStartGivesTheSameAnswer) {
  RandomMachine random(10);
  for (int i = 0; i < 60; ++i) {
    SCOPED_TRACE(i);
    const Machine machine = random.make(3, random.below(3), 0.02, 5e-5);
    const Plan plan = plan_of(machine, ErrorModel::rigid);
    const Query query = random.query(machine);
    const AxisSet free = *free_axes(machine, 0);
    const Correction cold = correct(plan, query, free, {});
    for (const double away : {0.0, 1e-5, 1e-2}) {
      Commands start = cold.corrected;
      for (int k = 0; k < machine.axis_count(); ++k) {
        const bool rotary = machine.axis(k).type == AxisType::rotary;
        start[static_cast<std::size_t>(k)] += random.uniform(-1, 1) * away * (rotary ? 1e-3 : 1.0);
      }
      const Correction warm = correct(plan, query, free, {}, &start);
      EXPECT_EQ(warm.status, cold.status);
      for (std::size_t k = 0; k < static_cast<std::size_t>(machine.axis_count()); ++k) {
        const bool rotary = machine.axis(static_cast<int>(k)).type == AxisType::rotary;
        EXPECT_NEAR(warm.corrected[k], cold.corrected[k], rotary ? 1e-11 : 1e-8);
      }
    }
  }
}

TEST(Correct, CloseStartAndLooseToleranceNeedOneEvaluation) {
  RandomMachine random(11);
  const Machine machine = random.make(3, 0, 0.02, 5e-5);
  const Plan plan = plan_of(machine, ErrorModel::rigid);
  const Query query = random.query(machine);
  const Correction exact = correct(plan, query, 7, {});
  Commands start = exact.corrected;
  start[0] += 1e-5;
  CorrectOptions loose;
  loose.position_tolerance = 1e-6;
  const Correction fast = correct(plan, query, 7, loose, &start);
  EXPECT_EQ(fast.iterations, 1);
  EXPECT_EQ(fast.status, Status::ok);
  EXPECT_LE(fast.residual_position, 1e-6);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_NEAR(fast.corrected[k], exact.corrected[k], 1e-7);
}

TEST(Chain, NeverNaN) {
  constexpr double kInf = std::numeric_limits<double>::infinity(),
                   kNan = std::numeric_limits<double>::quiet_NaN();
  const double hostile[] = {kNan, kInf, -kInf, 1e308, -1e308, 1e200, 1e-320, 0.0, 1e17};
  const auto finite = [](const auto& x) { return ((x * 0.0).array() == 0).all(); };
  RandomMachine random(12);
  for (int i = 0; i < 40; ++i) {
    const Machine machine = random.make(3, random.below(4), 0.02, i % 2 == 0 ? 1e-4 : 1e150);
    const AxisSet free = free_axes(machine, 0).value_or(0x7);
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear, ErrorModel::first_order}) {
      const Plan plan = plan_of(machine, model);
      for (const double value : hostile) {
        SCOPED_TRACE(testing::Message() << i << " " << static_cast<int>(model) << " " << value);
        Query query = random.query(machine);
        const int where = random.below(machine.axis_count() + 2);
        if (where < machine.axis_count())
          query.q[static_cast<std::size_t>(where)] = value;
        else if (where == machine.axis_count())
          query.tool.tip.y() = value;
        else
          query.tool.axis.x() = value;
        const Prediction p = predict(plan, query);
        EXPECT_TRUE(finite(p.nominal.position) && finite(p.actual.position) && finite(p.deviation.position));
        EXPECT_TRUE(finite(p.nominal.tool_axis) && finite(p.actual.tool_axis) && finite(p.tool_twist.d) &&
                    finite(p.tool_twist.e));
        EXPECT_TRUE(finite(actual_tip(plan, query)) && finite(nominal_tip(plan, query)));
        EXPECT_TRUE(finite(actual_pose(plan, query).R) && finite(nominal_pose(plan, query).p));
        EXPECT_TRUE(finite(jacobian(plan, query).position) && finite(jacobian(plan, query).tool_axis));
        for (const Method method : {Method::newton, Method::one_step}) {
          CorrectOptions options;
          options.method = method;
          const Correction c = correct(plan, query, free, options);
          for (const double x : c.corrected) EXPECT_TRUE(std::isfinite(x));
          EXPECT_TRUE(std::isfinite(c.residual_position) && std::isfinite(c.residual_direction));
        }
        const InverseResult inverted =
            inverse(plan, query.tool, Vec3(value, 0, 0), Vec3(0, value, 1), query.q, free, {});
        for (const double x : inverted.q) EXPECT_TRUE(std::isfinite(x));
        EXPECT_TRUE(std::isfinite(inverted.residual_position) && std::isfinite(inverted.residual_direction));
      }
    }
  }
}

}  // namespace
}  // namespace abbe
