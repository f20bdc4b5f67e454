#include <gtest/gtest.h>

#include "abbe/chain/correct.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"
#include "abbe/core/test_allocations.h"

namespace abbe {
namespace {

TEST(Chain, NoAllocation) {
  if (!ABBE_COUNTS_ALLOCATIONS) GTEST_SKIP() << "not with the address sanitizer";
  RandomMachine random(13);
  for (int i = 0; i < 20; ++i) {
    const Machine machine = random.make(i % 3 == 0 ? 4 : 3, random.below(4), 0.02, 1e-4);
    const AxisSet all = (AxisSet{1} << machine.axis_count()) - 1;
    AxisSet five = 0;  // as many as the closed form takes
    for (int axis = 0, linear = 0, rotary = 0; axis < machine.axis_count(); ++axis) {
      const bool taken = machine.axis(axis).type == AxisType::rotary ? ++rotary <= 2 : ++linear <= 3;
      if (taken) five |= AxisSet{1} << axis;
    }
    for (const ErrorModel model : {ErrorModel::rigid, ErrorModel::linear, ErrorModel::first_order}) {
      const Plan plan = std::get<Plan>(make_plan(machine, {{"T1", 23.5}}, model));
      const Query query = random.query(machine);
      const CorrectOptions options;
      const std::size_t before = allocation_count();
      const Vec3 a = nominal_tip(plan, query), b = actual_tip(plan, query);
      const Pose c = actual_pose(plan, query);
      const Jacobian j = jacobian(plan, query);
      const Correction d = correct(plan, query, all, options);
      CorrectOptions closed_form;
      closed_form.method = Method::closed_form;
      const Correction e = correct(plan, query, five, closed_form);
      EXPECT_EQ(allocation_count(), before) << e.iterations << a << b << c.p << j.position << d.iterations;
    }
  }
}

}  // namespace
}  // namespace abbe
