#include "abbe/evaluate/uncertainty.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "abbe/evaluate/monte_carlo.h"

namespace abbe {
namespace {

using Kind = Distribution::Kind;

// GUM H.1, end gauge: numbers of the guide. Results with more digits than it prints (32 nm, 16) are those of
// the GTC package's tests, whose derivatives differ in the sixth digit.
TEST(Uncertainty, GumH1) {
  const double length = 50'000'623;  // nm
  const auto d = combine({{"d0", 5.8, 1, 24}, {"d1", 3.9, 1, 5}, {"d2", 6.7, 1, 8}});
  ASSERT_TRUE(d);
  EXPECT_NEAR(d->u, 9.68194195397, 5e-9);
  EXPECT_NEAR(d->degrees_of_freedom, 25.4472507774, 5e-9);
  const auto theta = combine({{"mean", 0.2, 1}, {"cycle", 0.5 / std::sqrt(2.0), 1}});
  ASSERT_TRUE(theta);
  EXPECT_NEAR(theta->u, 0.406201920232, 5e-12);
  const double third = 1 / std::sqrt(3.0);
  // l = l_s + d - l_s (d_alpha theta + alpha_s d_theta); theta = -0.1, alpha_s = 11.5e-6, d_alpha = d_theta =
  // 0
  const auto l = combine({{"l_s", 25, 1, 18},
                          {"d", d->u, 1, d->degrees_of_freedom},
                          {"d_alpha", 1e-6 * third, -length * -0.1, 50},
                          {"d_theta", 0.05 * third, -length * 11.5e-6, 2},
                          {"alpha_s", 2e-6 * third, 0},
                          {"theta", theta->u, 0}});
  ASSERT_TRUE(l);
  EXPECT_NEAR(l->u, 31.6637674111, 5e-4);
  EXPECT_NEAR(l->degrees_of_freedom, 16.7521475092, 5e-3);
  EXPECT_NEAR(student_factor(0.99, 16), 2.92078, 5e-6);
}

// GUM H.2: resistance, reactance, impedance from correlated means of voltage, current and phase.
TEST(Uncertainty, GumH2) {
  const double V = 4.999, I = 0.019661, phi = 1.04446;
  Eigen::Matrix3d r;
  r << 1, -0.36, 0.86, -0.36, 1, -0.65, 0.86, -0.65, 1;
  const auto of = [&](double by_V, double by_I, double by_phi) {
    return combine({{"V", 0.0032, by_V}, {"I", 0.0000095, by_I}, {"phi", 0.00075, by_phi}}, r);
  };
  const double R = V / I * std::cos(phi), X = V / I * std::sin(phi), Z = V / I;
  EXPECT_NEAR(R, 127.732, 5e-4);
  EXPECT_NEAR(X, 219.847, 5e-4);
  EXPECT_NEAR(Z, 254.260, 5e-4);
  EXPECT_NEAR(of(R / V, -R / I, -X)->u, 0.071, 0.0012);
  EXPECT_NEAR(of(X / V, -X / I, R)->u, 0.295, 0.001);
  EXPECT_NEAR(of(Z / V, -Z / I, 0)->u, 0.236, 0.001);
}

TEST(Uncertainty, RefusesWhatIsNoUncertainty) {
  EXPECT_FALSE(combine({{"a", -1, 1}}));
  EXPECT_FALSE(combine({{"a", NAN, 1}}));
  EXPECT_FALSE(combine({{"a", 1, 1}}, Eigen::MatrixXd::Constant(2, 2, 1)));
  Eigen::Matrix2d beyond;
  beyond << 1, -1.5, -1.5, 1;
  EXPECT_FALSE(combine({{"a", 1, 1}, {"b", 1, 1}}, beyond));
}

TEST(Uncertainty, StudentQuantilesOfTheTable) {
  EXPECT_NEAR(student_factor(0.95, 1), 12.7062047, 5e-7);
  EXPECT_NEAR(student_factor(0.95, 4), 2.7764451, 5e-7);
  EXPECT_NEAR(student_factor(0.6827, 10), 1.0526, 2e-3);
  EXPECT_NEAR(student_factor(0.95, 1e12), 1.9599640, 5e-7);
}

// JCGM 101, 9.2: four equal contributions.
TEST(MonteCarlo, SumOfNormals) {
  const auto sum = [](const std::vector<double>& x) {
    return std::vector<double>{x[0] + x[1] + x[2] + x[3]};
  };
  const std::vector<Distribution> normals(4, {Kind::normal, 0, 1});
  const MonteCarloResult result = propagate(normals, sum, 400'000, 0.95, 3).front();
  EXPECT_NEAR(result.mean, 0, 0.02);
  EXPECT_NEAR(result.u, 2.00, 0.01);
  EXPECT_NEAR(result.symmetric[1], 3.92, 0.03);
  EXPECT_NEAR(result.symmetric[0], -3.92, 0.03);
}

TEST(MonteCarlo, SumOfRectangles) {
  const auto sum = [](const std::vector<double>& x) {
    return std::vector<double>{x[0] + x[1] + x[2] + x[3]};
  };
  const std::vector<Distribution> rectangles(4, {Kind::rectangular, 0, std::sqrt(3.0)});
  const MonteCarloResult result = propagate(rectangles, sum, 400'000, 0.95, 3).front();
  EXPECT_NEAR(result.u, 2.00, 0.01);
  EXPECT_NEAR(result.symmetric[1], 3.88, 0.03);
  EXPECT_NEAR(result.shortest[1] - result.shortest[0], 7.76, 0.05);
}

// JCGM 101, 9.5: 838 nm, 36 nm, shortest 99 % interval [745, 931] nm; the first-order law gives 32 nm.
TEST(MonteCarlo, GaugeBlock) {
  const std::vector<Distribution> inputs = {{Kind::student, 50'000'623, 25, 18},  // L_S, nm
                                            {Kind::student, 215, 6, 24},          // D
                                            {Kind::student, 0, 4, 5},             // d1
                                            {Kind::student, 0, 7, 8},             // d2
                                            {Kind::rectangular, 11.5e-6, 2e-6},   // alpha_S
                                            {Kind::normal, -0.1, 0.2},            // theta_0
                                            {Kind::arcsine, 0, 0.5},              // Delta
                                            {Kind::curvilinear_trapezoid, 0, 1e-6, 0.1e-6},
                                            {Kind::curvilinear_trapezoid, 0, 0.05, 0.025}};
  const auto model = [](const std::vector<double>& x) {
    const double theta = x[5] + x[6], theta_s = theta - x[8], alpha = x[4] + x[7];
    return std::vector<double>{(x[0] * (1 + x[4] * theta_s) + x[1] + x[2] + x[3]) / (1 + alpha * theta) -
                               5e7};
  };
  const MonteCarloResult result = propagate(inputs, model, 400'000, 0.99, 5).front();
  EXPECT_NEAR(result.mean, 838, 0.5);
  EXPECT_NEAR(result.u, 35.8, 0.3);
  EXPECT_NEAR(result.shortest[0], 745, 3);
  EXPECT_NEAR(result.shortest[1], 931, 3);
}

TEST(MonteCarlo, CurvilinearTrapezoidHasItsVariance) {
  RandomStream random(11);
  const Distribution trapezoid{Kind::curvilinear_trapezoid, 0, 1, 0.5};
  std::vector<double> values;
  for (int i = 0; i < 200'000; ++i) values.push_back(trapezoid.draw(random));
  // (2 a)^2 / 12 + d^2 / 9
  EXPECT_NEAR(std::pow(summarise(values, 0.95).u, 2), 1.0 / 3 + 0.25 / 9, 3e-3);
}

TEST(MonteCarlo, SameSeedSameNumbers) {
  RandomStream random(1);
  EXPECT_NEAR(random.uniform(), 0.13387664401253274, 1e-15);  // mt19937_64 is fixed by the standard
  const auto identity = [](const std::vector<double>& x) { return x; };
  const std::vector<Distribution> one = {{Kind::student, 0, 1, 3}};
  const auto a = propagate(one, identity, 1000, 0.95, 9).front(),
             b = propagate(one, identity, 1000, 0.95, 9).front();
  EXPECT_EQ(a.u, b.u);
  EXPECT_NE(a.u, propagate(one, identity, 1000, 0.95, 10).front().u);
}

TEST(MonteCarlo, NothingIsZeroNotNaN) {
  const MonteCarloResult none = summarise({NAN, INFINITY}, 0.95);
  EXPECT_EQ(none.u, 0);
  EXPECT_EQ(none.shortest[1], 0);
}

}  // namespace
}  // namespace abbe
