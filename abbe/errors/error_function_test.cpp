#include "abbe/errors/error_function.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>
#include <numbers>
#include <random>
#include <unsupported/Eigen/AutoDiff>
#include <vector>

namespace {
std::size_t allocations = 0;
}

// Every allocation of this program is counted. Not inlined: gcc would warn of new that ends in free.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* memory = std::malloc(size == 0 ? 1 : size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace abbe {
namespace {

using enum ErrorFunction::Interpolation;

constexpr double kRounding = 1e-12;   // of a few operations on numbers up to about 100
constexpr double kDifference = 1e-6;  // of central differences with kStep
constexpr double kStep = 1e-5;
constexpr double kInfinity = std::numeric_limits<double>::infinity();

// A forward derivative in one variable, in the form of Ceres' Jet.
struct Dual {
  double a = 0, v = 0;
  Dual() = default;
  explicit Dual(double x) : a(x) {}
  Dual(double x, double dx) : a(x), v(dx) {}
};
Dual operator+(Dual x, Dual y) { return {x.a + y.a, x.v + y.v}; }
Dual operator-(Dual x, Dual y) { return {x.a - y.a, x.v - y.v}; }
Dual operator*(Dual x, Dual y) { return {x.a * y.a, x.v * y.a + x.a * y.v}; }
Dual operator/(Dual x, Dual y) { return {x.a / y.a, (x.v * y.a - x.a * y.v) / (y.a * y.a)}; }
Dual sin(Dual x) { return {std::sin(x.a), std::cos(x.a) * x.v}; }

double at(const ErrorFunction& f, double v, bool* outside = nullptr) {
  return f.value<double>(&v, nullptr, outside);
}
double slope_at(const ErrorFunction& f, double v) {
  const Dual x(v, 1);
  return f.value<Dual>(&x, nullptr, nullptr).v;
}
bool is_outside(const ErrorFunction& f, double v) {
  bool outside = false;
  static_cast<void>(at(f, v, &outside));
  return outside;
}

// Second derivative on one side of v, exact for cubics up to rounding: side +1 or -1.
double curvature_at(const ErrorFunction& f, double v, double side, double h) {
  return (2 * at(f, v) - 5 * at(f, v + side * h) + 4 * at(f, v + 2 * side * h) - at(f, v + 3 * side * h)) /
         (h * h);
}
double slope_beside(const ErrorFunction& f, double v, double side, double h) {
  return side *
         (-11 * at(f, v) + 18 * at(f, v + side * h) - 9 * at(f, v + 2 * side * h) +
          2 * at(f, v + 3 * side * h)) /
         (6 * h);
}

struct Samples {
  std::vector<double> x, e;
};

Samples draw_samples(std::mt19937_64& rng, std::size_t n, bool uniform) {
  std::uniform_real_distribution<double> start(-100, 100), step(0.5, 20), error(-10, 10);
  Samples s;
  double x = start(rng);
  const double fixed = step(rng);
  for (std::size_t i = 0; i < n; ++i) {
    s.x.push_back(x);
    s.e.push_back(error(rng));
    x += uniform ? fixed : step(rng);
  }
  return s;
}

// What the header says, written plainly.
double plain_linear(const Samples& s, double v) {
  if (v <= s.x.front()) return s.e.front();
  for (std::size_t i = 0; i + 1 < s.x.size(); ++i) {
    if (v <= s.x[i + 1]) return s.e[i] + (s.e[i + 1] - s.e[i]) * (v - s.x[i]) / (s.x[i + 1] - s.x[i]);
  }
  return s.e.back();
}

TEST(ErrorFunction, DefaultIsZero) {
  const ErrorFunction f;
  EXPECT_EQ(at(f, 3), 0.0);
  EXPECT_TRUE(f.is_constant());
  EXPECT_FALSE(f.is_directional());
  EXPECT_TRUE(f.variables().empty());
}

TEST(ErrorFunction, ConstantPolynomialAndSineFollowTheirFormulas) {
  EXPECT_EQ(at(ErrorFunction::constant(-57.78), 5), -57.78);
  const auto poly = *ErrorFunction::polynomial(0, {1, -2, 0.5, 0.25}, 20);
  const double v = 23.5 - 20;  // the reference is subtracted
  EXPECT_NEAR(at(poly, 23.5), 1 - 2 * v + 0.5 * v * v + 0.25 * v * v * v, kRounding);
  const auto sine = *ErrorFunction::sine(0, 0.4, 0.628, 0.1, -5);
  EXPECT_NEAR(at(sine, 7), 0.4 * std::sin(0.628 * 12 + 0.1), kRounding);
}

TEST(ErrorFunction, ReadsItsOwnVariable) {
  const auto f = *ErrorFunction::polynomial(2, {0, 1});
  const double variables[] = {5, 6, 7};
  EXPECT_EQ(f.value<double>(variables, nullptr, nullptr), 7.0);
  EXPECT_EQ(f.variables(), std::vector<int>{2});
}

TEST(ErrorFunction, InterpolatesItsSamples) {
  std::mt19937_64 rng{1};
  for (int k = 0; k < 200; ++k) {
    const std::size_t n = 1 + rng() % 40;
    const Samples s = draw_samples(rng, n, k % 2 == 0);
    for (const auto kind : {linear, cubic}) {
      const auto f = ErrorFunction::table(0, s.x, s.e, kind, 0);
      ASSERT_TRUE(f.has_value());
      for (std::size_t i = 0; i < n; ++i) {
        ASSERT_EQ(at(*f, s.x[i]), s.e[i]) << "draw " << k << " sample " << i;
        ASSERT_FALSE(is_outside(*f, s.x[i]));
      }
      const auto turned = ErrorFunction::table(0, s.x, s.e, kind, 0, s.x.back() - s.x.front() + 3.7);
      ASSERT_TRUE(turned.has_value());
      for (std::size_t i = 0; i < n; ++i) ASSERT_EQ(at(*turned, s.x[i]), s.e[i]);
    }
  }
}

TEST(ErrorFunction, LinearTableAgreesWithItsPlainForm) {
  std::mt19937_64 rng{2};
  for (int k = 0; k < 100; ++k) {
    const Samples s = draw_samples(rng, 2 + rng() % 30, k % 2 == 0);
    const auto f = *ErrorFunction::table(0, s.x, s.e, linear, 12.5);
    ASSERT_EQ(f.nodes().back().uniform, k % 2 == 0 || s.x.size() == 2);
    std::uniform_real_distribution<double> where(s.x.front() - 10, s.x.back() + 10);
    for (int j = 0; j < 50; ++j) {
      const double v = where(rng);
      ASSERT_NEAR(at(f, v + 12.5), plain_linear(s, v), kRounding);
    }
  }
}

TEST(ErrorFunction, SplineHasContinuousSecondDerivative) {
  std::mt19937_64 rng{3};
  for (int k = 0; k < 100; ++k) {
    const std::size_t n = 3 + rng() % 20;
    const Samples s = draw_samples(rng, n, k % 2 == 0);
    const auto f = *ErrorFunction::table(0, s.x, s.e, cubic, 0);
    for (std::size_t i = 1; i + 1 < n; ++i) {
      const double h = std::min(s.x[i] - s.x[i - 1], s.x[i + 1] - s.x[i]) / 3.5;
      const double tolerance = 1e-10 * (1 + 10 / (h * h));
      ASSERT_NEAR(slope_beside(f, s.x[i], 1, h), slope_beside(f, s.x[i], -1, h), tolerance);
      ASSERT_NEAR(curvature_at(f, s.x[i], 1, h), curvature_at(f, s.x[i], -1, h), tolerance);
    }
  }
}

TEST(ErrorFunction, NaturalSplineHasNoCurvatureAtItsEnds) {
  std::mt19937_64 rng{4};
  for (int k = 0; k < 50; ++k) {
    const Samples s = draw_samples(rng, 3 + rng() % 10, k % 2 == 0);
    const auto f = *ErrorFunction::table(0, s.x, s.e, cubic, 0);
    const double first = (s.x[1] - s.x[0]) / 3.5, last = (s.x.back() - s.x[s.x.size() - 2]) / 3.5;
    EXPECT_NEAR(curvature_at(f, s.x.front(), 1, first), 0, 1e-10 * (1 + 10 / (first * first)));
    EXPECT_NEAR(curvature_at(f, s.x.back(), -1, last), 0, 1e-10 * (1 + 10 / (last * last)));
  }
}

TEST(ErrorFunction, NaturalSplineOfThreePointsIsTheOneInTheBooks) {
  // (0, 0) (1, 1) (2, 0): M_1 = -3, e = 1.5 t - 0.5 t^3 on the first half.
  const auto f = *ErrorFunction::table(0, {0, 1, 2}, {0, 1, 0}, cubic);
  EXPECT_NEAR(at(f, 0.5), 0.6875, kRounding);
  EXPECT_NEAR(at(f, 1.5), 0.6875, kRounding);
  EXPECT_NEAR(slope_at(f, 0.0), 1.5, kRounding);
  EXPECT_NEAR(slope_at(f, 2.0), -1.5, kRounding);
}

TEST(ErrorFunction, SplineOfTwoPointsIsTheLineAndOfOneAConstant) {
  const auto two = *ErrorFunction::table(0, {0, 4}, {1, 3}, cubic);
  for (const double v : {0.0, 1.0, 2.5, 4.0}) EXPECT_NEAR(at(two, v), 1 + v / 2, kRounding);
  const auto one = *ErrorFunction::table(0, {7}, {2.5}, cubic);
  EXPECT_EQ(at(one, -1e6), 2.5);
  EXPECT_FALSE(is_outside(one, -1e6));
  EXPECT_TRUE(one.is_constant());
}

TEST(ErrorFunction, SplineThroughAStraightLineIsThatLine) {
  const std::vector<double> x = {-3, -1, 0, 2.5, 7};
  std::vector<double> e;
  for (const double v : x) e.push_back(4 - 0.3 * v);
  const auto f = *ErrorFunction::table(0, x, e, cubic);
  for (double v = -3; v <= 7; v += 0.37) EXPECT_NEAR(at(f, v), 4 - 0.3 * v, kRounding);
}

TEST(ErrorFunction, HeldBeyondItsEnds) {
  const std::vector<double> x = {0, 10, 25}, e = {1, -2, 4};
  for (const auto kind : {linear, cubic}) {
    const auto f = *ErrorFunction::table(0, x, e, kind, 100);
    EXPECT_EQ(at(f, 99.999), 1.0);
    EXPECT_EQ(at(f, -1e9), 1.0);
    EXPECT_EQ(at(f, 125.001), 4.0);
    EXPECT_TRUE(is_outside(f, 99.999));
    EXPECT_TRUE(is_outside(f, 125.001));
    EXPECT_FALSE(is_outside(f, 100));
    EXPECT_FALSE(is_outside(f, 125));
    EXPECT_EQ(slope_at(f, 130), 0.0);
    EXPECT_NE(slope_at(f, 125), 0.0);
  }
  const auto poly = *ErrorFunction::polynomial(0, {0, 1}, 20, {-5, 15});
  EXPECT_EQ(at(poly, 10), -5.0);
  EXPECT_EQ(at(poly, 40), 15.0);
  EXPECT_TRUE(is_outside(poly, 14.9));
  EXPECT_FALSE(is_outside(poly, 15));
  const auto sine = *ErrorFunction::sine(0, 2, 1, 0, 0, {0, 1});
  EXPECT_EQ(at(sine, 5), 2 * std::sin(1.0));
  EXPECT_TRUE(is_outside(sine, 5));
  const auto narrowed = *ErrorFunction::table(0, x, e, linear, 0, 0, {5, 100});
  EXPECT_NEAR(at(narrowed, 0), -0.5, kRounding);
  EXPECT_TRUE(is_outside(narrowed, 4));
  EXPECT_TRUE(is_outside(narrowed, 26));
}

TEST(ErrorFunction, OutsideIsNeverCleared) {
  const auto f = *ErrorFunction::table(0, {0, 1}, {0, 1}, linear);
  bool outside = true;
  static_cast<void>(at(f, 0.5, &outside));
  EXPECT_TRUE(outside);
}

TEST(ErrorFunction, PeriodicRepeatsAndIsNeverOutside) {
  std::mt19937_64 rng{5};
  for (int k = 0; k < 50; ++k) {
    const Samples s = draw_samples(rng, 2 + rng() % 20, k % 2 == 0);
    const double period = s.x.back() - s.x.front() + 5;
    for (const auto kind : {linear, cubic}) {
      const auto f = *ErrorFunction::table(0, s.x, s.e, kind, 0, period);
      std::uniform_real_distribution<double> where(-300, 300);
      for (int j = 0; j < 20; ++j) {
        const double v = where(rng);
        for (const int turns : {-3, -1, 1, 7}) ASSERT_NEAR(at(f, v + turns * period), at(f, v), 1e-9);
        ASSERT_FALSE(is_outside(f, v));
      }
      ASSERT_FALSE(is_outside(f, 1e300));
      ASSERT_TRUE(std::isfinite(at(f, 1e300)));
      ASSERT_TRUE(std::isfinite(at(f, -1e300)));
    }
  }
}

TEST(ErrorFunction, PeriodicLinearTableCrossesTheGap) {
  const auto f = *ErrorFunction::table(0, {0, 90, 180, 270}, {0, 1, 0, -2}, linear, 0, 360);
  EXPECT_NEAR(at(f, 315), -1, kRounding);
  EXPECT_NEAR(at(f, -45), -1, kRounding);
  EXPECT_NEAR(at(f, 360 + 45), 0.5, kRounding);
  const auto shifted = *ErrorFunction::table(0, {-30, 170}, {3, 5}, linear, 0, 360);
  EXPECT_NEAR(at(shifted, 250), 4, kRounding);  // half way from 170 to 330
}

TEST(ErrorFunction, PeriodicSplineIsSmoothAcrossTheSeam) {
  std::mt19937_64 rng{6};
  for (int k = 0; k < 100; ++k) {
    const bool closed = k % 3 == 0;  // the last sample is the first again
    Samples s = draw_samples(rng, 3 + rng() % 12, k % 2 == 0);
    if (closed) s.e.back() = s.e.front();
    const double gap = closed ? 0 : 4;
    const double period = s.x.back() - s.x.front() + gap;
    const auto f = *ErrorFunction::table(0, s.x, s.e, cubic, 0, period);
    for (const double v : s.x) {
      // No sample is within 3 h: the steps are 0.5 at least and the gap is 4.
      const double h = 0.15;
      const double tolerance = 2e-10 * (1 + 10 / (h * h));
      ASSERT_NEAR(at(f, v - 1e-12), at(f, v + 1e-12), 1e-9);
      ASSERT_NEAR(slope_beside(f, v, 1, h), slope_beside(f, v, -1, h), tolerance) << "draw " << k;
      ASSERT_NEAR(curvature_at(f, v, 1, h), curvature_at(f, v, -1, h), tolerance) << "draw " << k;
    }
  }
}

TEST(ErrorFunction, PeriodicSplineFollowsASineToFourthOrder) {
  const auto worst = [](int n) {
    std::vector<double> x, e;
    for (int i = 0; i < n; ++i) {
      x.push_back(360.0 * i / n);
      e.push_back(std::sin(x.back() * std::numbers::pi / 180));
    }
    const auto f = *ErrorFunction::table(0, x, e, cubic, 0, 360);
    double most = 0;
    for (double v = -500; v < 500; v += 1.7)
      most = std::max(most, std::abs(at(f, v) - std::sin(v * std::numbers::pi / 180)));
    return most;
  };
  EXPECT_LT(worst(24), 2e-5);
  EXPECT_NEAR(worst(24) / worst(48), 16, 1.5);
}

TEST(ErrorFunction, DerivativeEqualsDifference) {
  std::mt19937_64 rng{7};
  std::vector<ErrorFunction> functions;
  functions.push_back(*ErrorFunction::polynomial(0, {1, 0.2, -0.03, 0.001}, 3));
  functions.push_back(*ErrorFunction::sine(0, 3, 0.2, 1, -4));
  for (int k = 0; k < 20; ++k) {
    const Samples s = draw_samples(rng, 4 + rng() % 10, k % 2 == 0);
    functions.push_back(*ErrorFunction::table(0, s.x, s.e, cubic, 1));
    functions.push_back(*ErrorFunction::table(0, s.x, s.e, cubic, 1, 400));
    functions.push_back(*ErrorFunction::table(0, s.x, s.e, linear, 1));
    functions.push_back(*ErrorFunction::grid({0}, {s.x}, s.e, 2));
  }
  functions.push_back(ErrorFunction::product({functions[0], functions[1], functions[2]}));
  functions.push_back(ErrorFunction::sum({functions[3], functions[1]}));
  functions.push_back(ErrorFunction::directional(0, functions[0], functions[1]));
  std::uniform_real_distribution<double> where(-50, 50);
  for (std::size_t i = 0; i < functions.size(); ++i) {
    const ErrorFunction& f = functions[i];
    for (int j = 0; j < 50; ++j) {
      const double v = where(rng);
      if (!f.knots(0, v - 2 * kStep, v + 2 * kStep).empty()) continue;
      const double difference = (at(f, v + kStep) - at(f, v - kStep)) / (2 * kStep);
      ASSERT_NEAR(slope_at(f, v), difference, kDifference * (1 + std::abs(difference)))
          << "function " << i << " at " << v;
      const Dual x(v, 1);
      ASSERT_EQ(f.value<Dual>(&x, nullptr, nullptr).a, at(f, v));
    }
  }
}

TEST(ErrorFunction, TakesEigensDerivativeType) {
  using Scalar = Eigen::AutoDiffScalar<Eigen::Vector2d>;
  const auto f = ErrorFunction::sum({*ErrorFunction::grid({0, 1}, {{0, 2}, {0, 4}}, {0, 1, 2, 5}),
                                     *ErrorFunction::sine(1, 2, 0.5, 0.1),
                                     *ErrorFunction::table(0, {0, 1, 3}, {0, 1, 0}, cubic, 0, 6),
                                     *ErrorFunction::table(1, {0, 1, 3}, {0, 1, 0}, linear)});
  const Scalar q[] = {Scalar(1.2, 2, 0), Scalar(2.5, 2, 1)};
  const Scalar e = f.value<Scalar>(q, nullptr, nullptr);
  const auto plain = [&](double x, double y) {
    const double v[] = {x, y};
    return f.value<double>(v, nullptr, nullptr);
  };
  EXPECT_NEAR(e.value(), plain(1.2, 2.5), kRounding);
  EXPECT_NEAR(e.derivatives()[0], (plain(1.2 + kStep, 2.5) - plain(1.2 - kStep, 2.5)) / (2 * kStep),
              kDifference);
  EXPECT_NEAR(e.derivatives()[1], (plain(1.2, 2.5 + kStep) - plain(1.2, 2.5 - kStep)) / (2 * kStep),
              kDifference);
}

TEST(ErrorFunction, GridIsMultilinearWithTheLastVariableFastest) {
  const auto f = *ErrorFunction::grid({1, 0}, {{0, 500}, {18, 20, 24}}, {0, 1, 2, 0.5, 1.5, 3});
  const auto value = [&](double y, double temperature, bool* outside = nullptr) {
    const double v[] = {temperature, y};
    return f.value<double>(v, nullptr, outside);
  };
  EXPECT_EQ(value(0, 20), 1.0);
  EXPECT_EQ(value(500, 18), 0.5);
  EXPECT_EQ(value(500, 24), 3.0);
  EXPECT_NEAR(value(250, 22), 0.25 * (1 + 2 + 1.5 + 3), kRounding);
  EXPECT_NEAR(value(100, 19), 0.8 * 0.5 + 0.2 * 1.0, kRounding);
  bool outside = false;
  EXPECT_EQ(value(600, 17, &outside), 0.5);
  EXPECT_TRUE(outside);
  EXPECT_EQ(f.variables(), (std::vector<int>{0, 1}));
}

TEST(ErrorFunction, GridOfFourVariablesReproducesAMultilinearFunction) {
  const std::vector<std::vector<double>> x = {{0, 1, 3}, {-2, 2}, {5}, {0, 10, 20, 40}};
  const auto truth = [](double a, double b, double, double d) {
    return 1 + 2 * a - b + a * b * 0.5 + 0.01 * a * b * d;
  };
  std::vector<double> e;
  for (const double a : x[0]) {
    for (const double b : x[1]) {
      for (const double d : x[3]) e.push_back(truth(a, b, 5, d));
    }
  }
  const auto f = *ErrorFunction::grid({3, 2, 1, 0}, x, e);
  std::mt19937_64 rng{8};
  for (int k = 0; k < 100; ++k) {
    const double a = std::uniform_real_distribution<double>(0, 3)(rng),
                 b = std::uniform_real_distribution<double>(-2, 2)(rng);
    const double d = std::uniform_real_distribution<double>(0, 40)(rng);
    const double v[] = {d, 99, b, a};
    bool outside = false;
    ASSERT_NEAR(f.value<double>(v, nullptr, &outside), truth(a, b, 5, d), kRounding);
    ASSERT_FALSE(outside);  // one position: known everywhere
  }
}

TEST(ErrorFunction, SumsAndProductsOfNestedTrees) {
  const auto p = *ErrorFunction::polynomial(0, {0, 1});
  const auto q = *ErrorFunction::polynomial(1, {1, 2});
  const auto inner = ErrorFunction::sum({p, ErrorFunction::constant(3)});
  const auto f = ErrorFunction::sum(
      {ErrorFunction::product({inner, q}), ErrorFunction::product({p, p, ErrorFunction()}), q});
  const double v[] = {4, 5};
  EXPECT_NEAR(f.value<double>(v, nullptr, nullptr), (4 + 3) * 11 + 0 + 11, kRounding);
  EXPECT_EQ(f.variables(), (std::vector<int>{0, 1}));
  for (std::size_t i = 0; i < f.nodes().size(); ++i) {
    const auto& node = f.nodes()[i];
    if (node.form != ErrorFunction::Form::sum && node.form != ErrorFunction::Form::product) continue;
    for (std::uint32_t c = 0; c < node.count; ++c) EXPECT_LT(f.children()[node.first_child + c], i);
  }
  EXPECT_EQ(at(ErrorFunction::sum({}), 1), 0.0);
  EXPECT_EQ(at(ErrorFunction::product({}), 1), 1.0);
}

TEST(ErrorFunction, DirectionalTakesTheSideOfApproachOrTheMean) {
  const auto f = ErrorFunction::directional(1, *ErrorFunction::polynomial(0, {0.5, 1}),
                                            *ErrorFunction::polynomial(0, {-0.3, 2}));
  const double v[] = {10, 0};
  const auto value = [&](signed char other, signed char own) {
    const signed char approach[] = {other, own};
    return f.value<double>(v, approach, nullptr);
  };
  EXPECT_NEAR(value(-1, 1), 10.5, kRounding);
  EXPECT_NEAR(value(1, -1), 19.7, kRounding);
  EXPECT_NEAR(value(1, 0), 0.5 * (10.5 + 19.7), kRounding);
  EXPECT_NEAR(f.value<double>(v, nullptr, nullptr), 0.5 * (10.5 + 19.7), kRounding);
  EXPECT_TRUE(f.is_directional());
  EXPECT_FALSE(f.is_constant());
  EXPECT_TRUE(ErrorFunction::sum({f, f}).is_directional());
}

TEST(ErrorFunction, OnlyTheChosenDirectionCanBeOutside) {
  const auto f = ErrorFunction::directional(0, *ErrorFunction::table(0, {0, 1}, {0, 1}, linear),
                                            ErrorFunction::constant(0));
  const double v = 2;
  const signed char backward = -1, forward = 1;
  bool outside = false;
  static_cast<void>(f.value<double>(&v, &backward, &outside));
  EXPECT_FALSE(outside);
  static_cast<void>(f.value<double>(&v, &forward, &outside));
  EXPECT_TRUE(outside);
}

TEST(ErrorFunction, NeverNaN) {
  std::mt19937_64 rng{9};
  std::vector<ErrorFunction> functions;
  for (int k = 0; k < 40; ++k) {
    const Samples s = draw_samples(rng, 1 + rng() % 12, k % 2 == 0);
    for (const auto kind : {linear, cubic}) {
      functions.push_back(*ErrorFunction::table(0, s.x, s.e, kind, 5));
      functions.push_back(*ErrorFunction::table(0, s.x, s.e, kind, 5, 500));
    }
    functions.push_back(*ErrorFunction::grid({0}, {s.x}, s.e));
  }
  for (const ErrorFunction& f : functions) {
    for (const double v : {0.0, -0.0, 1e-300, 5e-324, 1e15, -1e15, 1e308, -1e308, kInfinity, -kInfinity,
                           std::numeric_limits<double>::quiet_NaN()}) {
      ASSERT_TRUE(std::isfinite(at(f, v))) << v;
    }
    for (int j = 0; j < 100; ++j) {
      const double v = std::ldexp(static_cast<double>(static_cast<std::int64_t>(rng())),
                                  static_cast<int>(rng() % 120) - 60);
      ASSERT_TRUE(std::isfinite(at(f, v))) << v;
    }
  }
}

TEST(ErrorFunction, FactoriesRefuseWhatBreaksTheRules) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(ErrorFunction::polynomial(-1, {1, 2}));
  EXPECT_FALSE(ErrorFunction::polynomial(0, {}));
  EXPECT_FALSE(ErrorFunction::polynomial(0, {1, nan}));
  EXPECT_FALSE(ErrorFunction::polynomial(0, {1, 2}, nan));
  EXPECT_FALSE(ErrorFunction::polynomial(0, {1, 2}, 0, {2, 1}));
  EXPECT_FALSE(ErrorFunction::polynomial(0, {1, 2}, 0, {nan, 1}));
  EXPECT_FALSE(ErrorFunction::table(0, {}, {}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 1}, {0}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 0}, {0, 1}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {1, 0}, {0, 1}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {0, kInfinity}, {0, 1}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 1}, {0, nan}, cubic));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 1}, {0, 1}, linear, 0, -360));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 361}, {0, 0}, linear, 0, 360));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 180, 360}, {0, 1, 0.5}, linear, 0, 360));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 1}, {0, 1}, linear, 0, 0, {2, 3}));
  EXPECT_FALSE(ErrorFunction::table(0, {0, 5e-324}, {0, 1}, linear));
  EXPECT_FALSE(ErrorFunction::table(0, {-1e308, 1e308}, {0, 1}, linear));
  EXPECT_TRUE(ErrorFunction::table(0, {0, 180, 360}, {1, 2, 1}, linear, 0, 360));
  EXPECT_TRUE(ErrorFunction::table(0, {0, 3, 6.2831853}, {1, 2, 1}, cubic, 0, 2 * std::numbers::pi));
  EXPECT_FALSE(ErrorFunction::sine(0, 1, kInfinity, 0));
  EXPECT_FALSE(ErrorFunction::sine(-1, 1, 1, 0));
  EXPECT_FALSE(ErrorFunction::grid({}, {}, {}));
  EXPECT_FALSE(ErrorFunction::grid({0, 0}, {{0, 1}, {0, 1}}, {0, 1, 2, 3}));
  EXPECT_FALSE(ErrorFunction::grid({0, 1}, {{0, 1}, {0, 1}}, {0, 1, 2}));
  EXPECT_FALSE(ErrorFunction::grid({0, 1}, {{0, 1}, {0, 1}}, {0, 1, 2, 3, 4}));
  EXPECT_FALSE(ErrorFunction::grid({0, 1}, {{0, 1}, {}}, {}));
  EXPECT_FALSE(ErrorFunction::grid({0}, {{1, 0}}, {0, 1}));
  EXPECT_FALSE(ErrorFunction::grid({0, 1, 2, 3, 4}, {{0}, {0}, {0}, {0}, {0}}, {1}));
}

TEST(ErrorFunction, KnotsAreWhereTheFormChanges) {
  const auto table = *ErrorFunction::table(0, {0, 10, 25}, {1, 2, 3}, linear, 100);
  EXPECT_EQ(table.knots(0, 0, 1000), (std::vector<double>{100, 110, 125}));
  EXPECT_EQ(table.knots(0, 105, 110), (std::vector<double>{110}));
  EXPECT_TRUE(table.knots(1, 0, 1000).empty());
  const auto turning = *ErrorFunction::table(0, {0, 90}, {1, 2}, cubic, 10, 360);
  EXPECT_EQ(turning.knots(0, -360, 400), (std::vector<double>{-350, -260, 10, 100, 370}));
  const auto poly = *ErrorFunction::polynomial(0, {1, 2}, 5, {-1, 2});
  EXPECT_EQ(poly.knots(0, -100, 100), (std::vector<double>{4, 7}));
  const auto grid = *ErrorFunction::grid({2, 0}, {{0, 1}, {3, 4}}, {0, 1, 2, 3}, 10);
  EXPECT_EQ(grid.knots(0, 0, 100), (std::vector<double>{13, 14}));
  EXPECT_EQ(ErrorFunction::sum({table, grid}).knots(0, 0, 1000),
            (std::vector<double>{13, 14, 100, 110, 125}));
  const auto sine = *ErrorFunction::sine(0, 1, 2 * std::numbers::pi / 8, 0);  // period 8
  const auto comb = sine.knots(0, 0, 8);
  ASSERT_EQ(comb.size(), 17U);
  for (std::size_t i = 0; i < comb.size(); ++i) EXPECT_NEAR(comb[i], 0.5 * static_cast<double>(i), kRounding);
  const auto shifted = ErrorFunction::sine(0, 1, -0.5, 0.3, 2)->knots(0, -20, 20);
  for (const double v : shifted) {
    const double sixteenth = (-0.5 * (v - 2) + 0.3) / (std::numbers::pi / 8);
    EXPECT_NEAR(sixteenth, std::round(sixteenth), kRounding);
  }
  EXPECT_GT(shifted.size(), 45U);
  const auto fast = ErrorFunction::sine(0, 1, 1e30, 0)->knots(0, -500, 500);
  EXPECT_LE(fast.size(), static_cast<std::size_t>(ErrorFunction::kMaxKnots) + 1);
  EXPECT_TRUE(std::is_sorted(fast.begin(), fast.end()));
}

TEST(ErrorFunction, ValueDoesNotAllocate) {
  std::mt19937_64 rng{10};
  const Samples s = draw_samples(rng, 50, false);
  const auto f = ErrorFunction::directional(
      0,
      ErrorFunction::sum({*ErrorFunction::table(0, s.x, s.e, cubic),
                          *ErrorFunction::table(0, s.x, s.e, linear, 0, 2000),
                          *ErrorFunction::polynomial(0, {1, 2, 3}), *ErrorFunction::sine(0, 1, 2, 3)}),
      ErrorFunction::product(
          {*ErrorFunction::grid({0, 1}, {{0, 1}, {0, 1}}, {0, 1, 2, 3}), ErrorFunction::constant(2)}));
  const double v[] = {3, 0.5};
  const Dual d[] = {Dual(3, 1), Dual(0.5, 0)};
  const std::size_t before = allocations;
  double total = 0;
  for (const int approach : {-1, 0, 1}) {
    const signed char both[] = {static_cast<signed char>(approach), 0};
    total += f.value<double>(v, both, nullptr) + f.value<Dual>(d, both, nullptr).v;
  }
  EXPECT_EQ(allocations, before);
  EXPECT_TRUE(std::isfinite(total));
}

}  // namespace
}  // namespace abbe
