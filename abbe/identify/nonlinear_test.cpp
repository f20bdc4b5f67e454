#include "abbe/identify/nonlinear.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <functional>
#include <numbers>
#include <sstream>
#include <string>
#include <vector>

namespace abbe {
namespace {

using Model = std::function<double(std::span<const double> b, double x)>;

struct NistCase {
  const char* name;
  Model model;
};

const std::vector<NistCase>& nist_cases() {
  static const auto gauss = [](std::span<const double> b, double x) {
    return b[0] * std::exp(-b[1] * x) + b[2] * std::exp(-std::pow(x - b[3], 2) / (b[4] * b[4])) +
           b[5] * std::exp(-std::pow(x - b[6], 2) / (b[7] * b[7]));
  };
  static const auto rational = [](std::span<const double> b, double x) {
    return (b[0] + x * (b[1] + x * (b[2] + x * b[3]))) / (1 + x * (b[4] + x * (b[5] + x * b[6])));
  };
  static const std::vector<NistCase> cases = {
      {"Misra1a", [](auto b, double x) { return b[0] * (1 - std::exp(-b[1] * x)); }},
      {"Chwirut2", [](auto b, double x) { return std::exp(-b[0] * x) / (b[1] + b[2] * x); }},
      {"DanWood", [](auto b, double x) { return b[0] * std::pow(x, b[1]); }},
      {"Lanczos3",
       [](auto b, double x) {
         return b[0] * std::exp(-b[1] * x) + b[2] * std::exp(-b[3] * x) + b[4] * std::exp(-b[5] * x);
       }},
      {"Gauss1", gauss},
      {"Kirby2",
       [](auto b, double x) { return (b[0] + x * (b[1] + x * b[2])) / (1 + x * (b[3] + x * b[4])); }},
      {"Hahn1", rational},
      {"Thurber", rational},
      {"ENSO",
       [](auto b, double x) {
         const double w = 2 * std::numbers::pi * x;
         return b[0] + b[1] * std::cos(w / 12) + b[2] * std::sin(w / 12) + b[4] * std::cos(w / b[3]) +
                b[5] * std::sin(w / b[3]) + b[7] * std::cos(w / b[6]) + b[8] * std::sin(w / b[6]);
       }},
      {"MGH17",
       [](auto b, double x) { return b[0] + b[1] * std::exp(-x * b[3]) + b[2] * std::exp(-x * b[4]); }},
      {"Roszman1",
       [](auto b, double x) { return b[0] - b[1] * x - std::atan(b[2] / (x - b[3])) / std::numbers::pi; }},
      {"Rat42", [](auto b, double x) { return b[0] / (1 + std::exp(b[1] - b[2] * x)); }},
      {"Eckerle4",
       [](auto b, double x) { return b[0] / b[1] * std::exp(-0.5 * std::pow((x - b[2]) / b[1], 2)); }},
      {"BoxBOD", [](auto b, double x) { return b[0] * (1 - std::exp(-b[1] * x)); }},
  };
  return cases;
}

/// Starts, certified values and data of a file of the collection.
struct NistData {
  std::vector<double> start1, start2, certified, y, x;
};

NistData read_nist(const std::string& path) {
  NistData out;
  std::ifstream file(path);
  bool data = false;
  for (std::string line; std::getline(file, line);) {
    std::istringstream words(line);
    std::string first, equals;
    if (line.rfind("Data:", 0) == 0 && line.find("Response") == std::string::npos) {
      data = true;
    } else if (data) {
      double y = 0, x = 0;
      if (words >> y >> x) out.y.push_back(y), out.x.push_back(x);
    } else if (words >> first >> equals && first[0] == 'b' && equals == "=") {
      double a = 0, b = 0, c = 0;
      if (words >> a >> b >> c) out.start1.push_back(a), out.start2.push_back(b), out.certified.push_back(c);
    }
  }
  return out;
}

/// Digits that agree, of the worst parameter.
double digits(const Eigen::VectorXd& x, const std::vector<double>& certified) {
  double worst = 12;
  for (std::size_t k = 0; k < certified.size(); ++k)
    worst =
        std::min(worst, -std::log10(std::abs(x[static_cast<Eigen::Index>(k)] / certified[k] - 1) + 1e-12));
  return worst;
}

NonlinearSolution solve_nist(const NistCase& nist, const NistData& data, const std::vector<double>& start) {
  NonlinearProblem problem;
  problem.count = static_cast<Eigen::Index>(data.y.size());
  problem.start = Eigen::Map<const Eigen::VectorXd>(start.data(), static_cast<Eigen::Index>(start.size()));
  problem.most_iterations = 5000;
  problem.residuals = [&](std::span<const double> b, std::span<double> r, Eigen::MatrixXd*) {
    for (std::size_t i = 0; i < data.y.size(); ++i) r[i] = nist.model(b, data.x[i]) - data.y[i];
    return std::all_of(r.begin(), r.end(), [](double v) { return std::isfinite(v); });
  };
  return minimise(problem);
}

// National Institute of Standards and Technology, Statistical Reference Datasets, nonlinear regression: from
// the second start, which is near the solution, every set; from the first, which is far, at least half of
// them.
TEST(Nonlinear, NistCertifiedParameters) {
  const std::string folder = ABBE_SOURCE_DIR "/../shared/data/numerics/nist-nonlinear/";
  if (!std::ifstream(folder + "Misra1a.dat")) GTEST_SKIP() << "no NIST data sets beside the sources";
  constexpr double kDigits = 6;
  int far = 0;
  for (const NistCase& nist : nist_cases()) {
    NistData data = read_nist(folder + nist.name + ".dat");
    // The copy of this file has a misprint in b1 (1.20..E-0): with it the certified sum of squares is not
    // reached.
    if (nist.name == std::string("Roszman1")) data.certified[0] = 2.0196866396e-1;
    ASSERT_FALSE(data.y.empty()) << nist.name;
    ASSERT_FALSE(data.certified.empty()) << nist.name;
    EXPECT_GT(digits(solve_nist(nist, data, data.start2).x, data.certified), kDigits) << nist.name;
    if (digits(solve_nist(nist, data, data.start1).x, data.certified) > kDigits) ++far;
  }
  EXPECT_GE(far, 10);
}

TEST(Nonlinear, NothingToSolve) {
  EXPECT_FALSE(minimise({}).converged);
  NonlinearProblem nan;
  nan.start = Eigen::VectorXd::Constant(1, std::nan(""));
  nan.count = 1;
  nan.residuals = [](auto, auto, auto) { return true; };
  EXPECT_FALSE(minimise(nan).converged);
}

}  // namespace
}  // namespace abbe
