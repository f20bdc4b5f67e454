#include <gtest/gtest.h>

#include <array>
#include <string>

#include "abbe/chain/correct.h"
#include "abbe/chain/method_fit.h"
#include "abbe/chain/test_seven_axis_machine.h"
#include "abbe/machine/read_machine.h"

namespace abbe {
namespace {

// 50-digit arithmetic from the equations of seed 000, solved by Newton's method with the Jacobian of the
// adjoints. It adds squareness as a translation, which is of second order apart from the rigid model.
constexpr double kSecondOrder = 5e-7;       // mm
constexpr double kSecondOrderAngle = 1e-9;  // rad
constexpr std::array<const char*, 7> kNames = {"X", "Y", "Z", "A", "B", "Z1", "B1"};
constexpr std::array<double, 7> kCommanded = {
    -420.5, 350.25, 180.75, 0.20943951023931956, -0.4363323129985824, 60.125, 0.5235987755982989};

class Redundant : public ::testing::Test {
 protected:
  Redundant() {
    machine_ = read_machine({"seven.toml", kSevenAxes}, std::nullopt, [](const std::string&) {
                 return std::optional<std::string>();
               }).value.value_or(Machine{});
    query_.tool = tool_of(machine_);
    for (std::size_t i = 0; i < kNames.size(); ++i) query_.q.at(index(i)) = kCommanded[i];
  }
  [[nodiscard]] std::size_t index(std::size_t i) const {
    return static_cast<std::size_t>(machine_.find_axis(kNames[i]));
  }
  void expect(const Correction& r, const std::array<double, 7>& q, double length, double angle) const {
    EXPECT_EQ(r.status, Status::ok);
    for (std::size_t i = 0; i < kNames.size(); ++i) {
      const bool rotary = machine_.axis(static_cast<int>(index(i))).type == AxisType::rotary;
      EXPECT_NEAR(r.corrected[index(i)], q[i], rotary ? angle : length) << kNames[i];
    }
  }

  Machine machine_;
  Query query_;
};

TEST_F(Redundant, FeedAndIndexingAxesAreLockedByTheirNames) {
  const AxisSet free = *free_axes(machine_, 0);
  const Plan plan = std::get<Plan>(make_plan(machine_, {}));
  const std::array<double, 7> exact = {-420.51613833253305, 350.28540006785653,  180.73529742293525,
                                       0.209430669871712,   -0.4362927259900254, 60.125,
                                       0.5235987755982989};
  for (const Method method : {Method::newton, Method::closed_form}) {
    CorrectOptions options;
    options.method = method;
    const Correction r = correct(plan, query_, free, options);
    expect(r, exact, kSecondOrder, kSecondOrderAngle);
    EXPECT_LE(r.residual_position, 1e-9);
    EXPECT_LE(r.residual_direction, 1e-12);
  }
  CorrectOptions one_step;
  one_step.method = Method::one_step;
  const Correction step =
      correct(std::get<Plan>(make_plan(machine_, {}, ErrorModel::first_order)), query_, free, one_step);
  expect(step,
         {-420.51613780192264, 350.2854011585186, 180.73529670560083, 0.2094306694118591,
          -0.43629272682185805, 60.125, 0.5235987755982989},
         1e-12, 1e-15);
  EXPECT_NEAR(correct(plan, query_, free, one_step).residual_position, 1.3775920300256228e-06, 2e-7);
}

TEST_F(Redundant, AllSevenTakeTheSmallestWeightedMotion) {
  const std::array<double, 7> weights = {1, 1, 1, 300, 300, 10, 3000};
  CorrectOptions options;
  for (std::size_t i = 0; i < kNames.size(); ++i) options.weights.at(index(i)) = weights[i];
  const Plan plan = std::get<Plan>(make_plan(machine_, {}));
  const Correction r = correct(plan, query_, 0x7F, options);
  expect(r,
         {-420.5121391500426, 350.2853787572135, 180.73642372638182, 0.20943043341495063, -0.4362903400723745,
          60.12486428332671, 0.5236012148098533},
         kSecondOrder, kSecondOrderAngle);
  EXPECT_LE(r.residual_position, 1e-9);
  EXPECT_LE(r.residual_direction, 1e-12);
  // The closed form has one answer or none.
  EXPECT_TRUE(method_obstacle(Method::closed_form, machine_, ErrorModel::rigid, query_.tool, 0x7F));
  options.method = Method::closed_form;
  EXPECT_EQ(correct(plan, query_, 0x7F, options).status, Status::failed);
}

}  // namespace
}  // namespace abbe
