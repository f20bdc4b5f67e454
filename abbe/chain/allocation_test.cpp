#include <gtest/gtest.h>

#include <cstdlib>
#include <new>

#include "abbe/chain/correct.h"
#include "abbe/chain/predict.h"
#include "abbe/chain/test_random_machine.h"

#if defined(__SANITIZE_ADDRESS__)
#define ABBE_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ABBE_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef ABBE_COUNTS_ALLOCATIONS
#define ABBE_COUNTS_ALLOCATIONS 1
#endif

namespace {
std::size_t allocations = 0;
}  // namespace

#if ABBE_COUNTS_ALLOCATIONS  // the sanitizer has operators of its own, and does not like half of them
                             // replaced
// Out of line, or the compiler pairs malloc with delete and complains.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif

namespace abbe {
namespace {

[[gnu::noinline]] std::size_t allocation_count() { return allocations; }

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
