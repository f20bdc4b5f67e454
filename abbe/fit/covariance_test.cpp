// The covariance that a fit writes, read back as modes.

#include <gtest/gtest.h>

#include "abbe/fit/test_hidden_machine.h"
#include "abbe/machine/uncertainty_modes.h"

namespace abbe {
namespace {

using namespace test;

struct Fitted {
  HiddenMachine hidden = HiddenMachine(three_axis_machine(), kHiddenErrors);
  FitResult result;
  std::string text;
  Machine machine;
  UncertaintyModes modes;

  Fitted() {
    const Instrument instrument{0.3, 3, true, 5, 40 * urad};
    const Files files = {
        {"hidden.toml", hidden.text},
        {"x.csv", run_file(hidden, 0, 0, spaced_targets(-200, 300, 11), {}, {0, 60, 20}, instrument)},
        {"c.csv", run_file(hidden, 0, 5, spaced_targets(-200, 300, 11), {}, Vec3::Zero(), instrument)}};
    const Parsed<FitJob> job = read_job(
        "format = 1\nmachine = \"hidden.toml\"\n[functions]\nEXX = { form = \"polynomial\", order = 3 }\nECX "
        "= { form = "
        "\"polynomial\", order = 2 }\n[[run]]\nfile = \"x.csv\"\nerror = \"EXX\"\noptic = [0, 60, "
        "20]\nscale_u_ppm = "
        "2\n[[run]]\nfile = \"c.csv\"\nerror = \"ECX\"\n[[value]]\nerror = \"EC0Y\"\nvalue = 3\nu = 2\n",
        files);
    const auto observations = observations_of(*job.value);
    const auto unknowns = unknowns_of(*job.value, *observations.value);
    result = fit_jointly(*job.value, *observations.value, *unknowns.value);
    text = write_errors_file(*job.value, result) + write_uncertainty_modes(*job.value, result);
    machine = read_machine({"hidden.toml", hidden.text}, MachineText{"e.toml", text}, {}).value.value();
    modes = read_uncertainty_modes(machine, {"e.toml", text}, {}).value.value();
  }

  /// sum_m mode_m(a at x) mode_m(b at x), um and urad
  [[nodiscard]] double covariance(const std::string& a, const std::string& b, double x) const {
    const std::vector<double> variables(modes.variables.size(), x);
    const auto value = [&](const std::vector<ErrorTerm>& mode, const std::string& name) {
      for (const ErrorTerm& term : mode)
        if (to_string(term.name) == name)
          return term.function.value<double>(variables.data(), nullptr, nullptr);
      return 0.0;
    };
    double sum = 0;
    for (const auto& mode : modes.modes) sum += value(mode, a) * value(mode, b);
    return sum;
  }
};

TEST(Covariance, ModesAddUpToTheCovariance) {
  const Fitted fitted;
  const FoundFunction &exx = fitted.result.functions[0], &ecx = fitted.result.functions[1];
  ASSERT_EQ(exx.unknown.name, "EXX");
  const Eigen::Index n = exx.mean.size(), m = ecx.mean.size(), second = n + exx.reversal.size();
  const Eigen::MatrixXd& C = fitted.result.covariance;
  for (const double x : {-150.0, 40.0, 290.0}) {
    const Eigen::RowVectorXd a = exx.unknown.mean.row(x), b = ecx.unknown.mean.row(x);
    const double aa = a * C.topLeftCorner(n, n) * a.transpose(),
                 bb = b * C.block(second, second, m, m) * b.transpose(),
                 ab = a * C.block(0, second, n, m) * b.transpose();
    EXPECT_NEAR(fitted.covariance("EXX", "EXX", x), aa, 1e-3 * aa);
    EXPECT_NEAR(fitted.covariance("ECX", "ECX", x), bb, 1e-3 * bb);
    EXPECT_NEAR(fitted.covariance("EXX", "ECX", x), ab, 1e-3 * std::sqrt(aa * bb));
    EXPECT_GT(std::abs(ab), 0.01 * std::sqrt(aa * bb));  // the optic beside the axis makes them depend
  }
  EXPECT_NEAR(fitted.covariance("EC0Y", "EC0Y", 0), 4, 0.01);
}

TEST(Covariance, ThermalSlopesAreUncertainTogether) {
  const HiddenMachine hidden(three_axis_machine(), kHiddenErrors);
  FitJob job;
  job.machine = hidden.machine;
  job.thermal.reference = 21;
  ThermalFit thermal;
  thermal.models.resize(2);
  thermal.models[0].name = "EXt";
  thermal.models[0].terms = {{"head", 0, 2, 0, 15, 40}, {"bed", 1800, -1, 0, 15, 40}};
  thermal.models[0].beyond_slopes = 0.25;
  thermal.models[1].name = "EBt";
  thermal.models[1].terms = {{"bed", 1800, 3, 0, 15, 40}};
  thermal.models[1].beyond_slopes = 0.5;
  Eigen::Matrix3d L;
  L << 0.3, 0, 0, -0.1, 0.2, 0, 0.15, -0.05, 0.1;
  thermal.covariance = L * L.transpose();
  const std::string text = write_errors_file(job, {}, thermal) + write_uncertainty_modes(job, {}, thermal);
  const auto machine = read_machine({"hidden.toml", hidden.text}, MachineText{"e.toml", text}, {});
  ASSERT_TRUE(machine.value) << text;
  const auto modes = read_uncertainty_modes(*machine.value, {"e.toml", text}, {});
  ASSERT_TRUE(modes.value) << text;
  ASSERT_EQ(modes.value->modes.size(), 5U);  // three of the slopes, one of each error
  std::vector<double> variables(modes.value->variables.size(), 21);
  for (std::size_t i = 0; i < variables.size(); ++i) {
    if (modes.value->variables[i].name == "head") variables[i] = 25;
    if (modes.value->variables[i].name == "bed_lag1800") variables[i] = 31;
  }
  Eigen::Matrix2d sum = Eigen::Matrix2d::Zero();
  for (const auto& mode : modes.value->modes) {
    Eigen::Vector2d errors = Eigen::Vector2d::Zero();
    for (const ErrorTerm& term : mode)
      errors[to_string(term.name) == "EXt" ? 0 : 1] +=
          term.function.value<double>(variables.data(), nullptr, nullptr);
    sum += errors * errors.transpose();
  }
  // e = A b, A = [4 K, 10 K, 0; 0, 0, 10 K]
  Eigen::Matrix<double, 2, 3> A;
  A << 4, 10, 0, 0, 0, 10;
  Eigen::Matrix2d expected = A * thermal.covariance * A.transpose();
  expected.diagonal() += Eigen::Vector2d(0.0625, 0.25);
  EXPECT_TRUE(sum.isApprox(expected, 1e-6)) << sum << "\n" << expected;
}

}  // namespace
}  // namespace abbe
