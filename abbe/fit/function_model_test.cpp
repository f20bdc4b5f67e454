#include "abbe/fit/function_model.h"

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/core/units.h"
#include "abbe/evaluate/monte_carlo.h"
#include "abbe/fit/choose_form.h"
#include "abbe/fit/independent_columns.h"
#include "abbe/fit/test_hidden_machine.h"

namespace abbe {
namespace {

using Kind = FunctionForm::Kind;

std::vector<FunctionForm> forms() {
  return {{Kind::polynomial, 1, {}, 0, 0},
          {Kind::polynomial, 5, {}, 0, 0},
          {Kind::polynomial, 3, {}, 40, 2},
          {Kind::table, 0, {-100, -20, 30, 200}, 0, 0},
          {Kind::cubic, 0, {-100, -50, 0, 110, 200}, 0, 0},
          {Kind::cubic, 0, {-100, 200}, 25, 1}};
}

TEST(FunctionModel, GaugeIsKept) {
  RandomStream random(4);
  for (const FunctionForm& form : forms()) {
    const FunctionModel model(form, {20, true}, -100, 200);
    Eigen::VectorXd z(model.parameters());
    for (double& value : z) value = random.normal();
    EXPECT_NEAR(model.row(20).dot(z), 0, 1e-12) << model.describe();
    double trend = 0;
    for (int i = 0; i < kTrendSamples; ++i) {
      const double t = -1 + 2.0 * i / (kTrendSamples - 1);
      trend += t * model.row(50 + 150 * t).dot(z);
    }
    EXPECT_NEAR(trend, 0, 1e-11) << model.describe();
  }
}

TEST(FunctionModel, TextReadsBackToTheSameFunction) {
  RandomStream random(5);
  for (const FunctionForm& form : forms()) {
    const FunctionModel model(form, {20, false}, -100, 200);
    Eigen::VectorXd z(model.parameters());
    for (double& value : z) value = random.normal();
    const Machine machine =
        test::HiddenMachine::read(test::three_axis_machine() + "[errors]\nEXX = [" + model.text(z) + "]\n");
    for (double v = -130; v < 230; v += 7.3) {
      const std::array<double, 3> variables = {v, 0, 0};
      EXPECT_NEAR(machine.errors[0].function.value(variables.data(), nullptr, nullptr), model.row(v).dot(z),
                  2e-8)
          << model.describe() << " at " << v;
    }
  }
}

TEST(ChooseForm, FindsTheOrderOfAPolynomial) {
  for (const int order : {1, 2, 3, 5}) {
    int found = 0;
    for (std::uint64_t seed = 1; seed <= 40; ++seed) {
      RandomStream random(seed);
      std::vector<CoursePoint> course;
      for (int i = 0; i <= 20; ++i) {
        const double x = -1 + 0.1 * i;
        double value = 3;
        for (int k = 1; k <= order; ++k) value += (k % 2 == 0 ? -8 : 10) * std::pow(x, k);
        course.push_back({100 * x, value + 0.05 * random.normal()});
      }
      const FunctionForm form = choose_form({0, false}, course, 8);
      EXPECT_TRUE(form.kind != Kind::polynomial || form.order >= order);
      found += form.kind == Kind::polynomial && form.order == order;
    }
    EXPECT_GE(found, 30) << order;  // chance lets a higher order win now and then
  }
}

TEST(ChooseForm, TakesASplineWhereNoPolynomialFits) {
  std::vector<CoursePoint> course;
  for (int i = 0; i <= 40; ++i) course.push_back({10.0 * i, std::abs(i - 17) < 3 ? 5.0 : std::sin(0.9 * i)});
  EXPECT_EQ(choose_form({0, false}, course, 4).kind, Kind::cubic);
}

TEST(IndependentColumns, NamesTheCombination) {
  Eigen::MatrixXd a(4, 4);
  a << 1, 0, 2, 0, 0, 1, -3, 0, 1, 1, -1, 0, 0, 2, -6, 0;  // third = 2 first - 3 second; the fourth is zero
  const IndependentColumns columns = independent_columns(a, 1e-9);
  EXPECT_EQ(columns.kept, (std::vector<Eigen::Index>{0, 1}));
  ASSERT_EQ(columns.dependent.size(), 2U);
  EXPECT_EQ(columns.dependent[0].column, 2);
  ASSERT_EQ(columns.dependent[0].like.size(), 2U);
  EXPECT_NEAR(columns.dependent[0].like[0].second, 2, 1e-12);
  EXPECT_NEAR(columns.dependent[0].like[1].second, -3, 1e-12);
  EXPECT_TRUE(columns.dependent[1].like.empty());
}

TEST(IndependentColumns, OrderDecides) {
  Eigen::MatrixXd a(2, 2);
  a << 1, 1e-6, 1, 1e-6;
  EXPECT_EQ(independent_columns(a, 1e-9).dependent[0].column, 1);
  EXPECT_EQ(independent_columns(a.rowwise().reverse(), 1e-9).dependent[0].column, 1);
}

}  // namespace
}  // namespace abbe
