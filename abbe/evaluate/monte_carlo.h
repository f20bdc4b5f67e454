#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

namespace abbe {

/// Random numbers that are the same on every platform for the same seed: the generator is the standard's, the
/// distributions are written out here because those of the standard library differ between implementations.
class RandomStream {
 public:
  explicit RandomStream(std::uint64_t seed) : bits_(seed) {}

  [[nodiscard]] double uniform();            ///< within (0, 1)
  [[nodiscard]] double normal();             ///< mean 0, standard deviation 1
  [[nodiscard]] double gamma(double shape);  ///< shape > 0, scale 1

 private:
  std::mt19937_64 bits_;
  double spare_ = 0;
  bool has_spare_ = false;
};

/// What is known of an input, as a distribution (JCGM 101:2008, 6.4).
struct Distribution {
  enum class Kind {
    normal,                 ///< width = standard deviation
    student,                ///< width = scale, extra = degrees of freedom
    rectangular,            ///< within centre +- width
    arcsine,                ///< U-shaped within centre +- width
    curvilinear_trapezoid,  ///< within centre +- width, the limits themselves known to +- extra
  };
  Kind kind = Kind::normal;
  double centre = 0, width = 0, extra = 0;

  [[nodiscard]] double draw(RandomStream& random) const;
};

/// Values of a result, drawn many times, in few numbers.
struct MonteCarloResult {
  double mean = 0, u = 0;
  std::array<double, 2> symmetric{};  ///< equal probability left out on both sides
  std::array<double, 2> shortest{};
};

/// probability in (0, 1). Values that are not finite are left out; fewer than two give zeros.
/// cost     one sort
[[nodiscard]] MonteCarloResult summarise(std::vector<double> values, double probability);

/// Results of one set of inputs.
using MonteCarloModel = std::function<std::vector<double>(const std::vector<double>& inputs)>;

/// Draws `trials` sets of inputs, evaluates the model on each and summarises each of its results.
/// laws     SumOfNormals, SumOfRectangles, GaugeBlock, SameSeedSameNumbers
/// cost     trials * (inputs + model); memory 8 bytes a trial and result
/// source   JCGM 101:2008, 7
[[nodiscard]] std::vector<MonteCarloResult> propagate(const std::vector<Distribution>& inputs,
                                                      const MonteCarloModel& model, std::size_t trials,
                                                      double probability, std::uint64_t seed);

}  // namespace abbe
