#pragma once

#include <fmt/format.h>

#include <cstdint>
#include <cstdlib>
#include <numbers>
#include <random>
#include <string>

namespace abbe::testing {

class Random {
 public:
  explicit Random(std::uint64_t seed) : rng_(seed) {}
  double between(double lo, double hi) { return std::uniform_real_distribution<double>(lo, hi)(rng_); }
  int below(int n) { return static_cast<int>(rng_() % static_cast<std::uint64_t>(n)); }
  bool chance(double p) { return between(0, 1) < p; }

 private:
  std::mt19937_64 rng_;
};

/// Seeds of the random programs of a test: the first, and how many. Usually 1 and `usual`; ABBE_RANDOM_FIRST
/// and ABBE_RANDOM_PROGRAMS say otherwise (CONTRIBUTING.md).
struct Seeds {
  std::uint64_t first = 1, count = 0;
  [[nodiscard]] std::uint64_t end() const { return first + count; }
};
inline Seeds random_seeds(std::uint64_t usual) {
  const auto said = [](const char* name, std::uint64_t otherwise) {
    const char* const text = std::getenv(name);
    const std::uint64_t number = text == nullptr ? 0 : std::strtoull(text, nullptr, 10);
    return number > 0 ? number : otherwise;
  };
  return {said("ABBE_RANDOM_FIRST", 1), said("ABBE_RANDOM_PROGRAMS", usual)};
}

/// All 21 errors of a three-axis machine in every form, as a machine file.
inline std::string random_machine(Random& random, double scale) {
  static const char* const kChains[] = {"w X b Y Z t", "w b X Y Z t", "w Y X b Z t", "w X Y Z b t",
                                        "w Z b Y X t"};
  const std::string chain = kChains[random.below(5)];
  std::string text = fmt::format("format = 1\n[machine]\nname = \"random\"\nchain = \"{}\"\n", chain);
  for (const char axis : {'X', 'Y', 'Z'}) {
    text += fmt::format("[axis.{}]\nrange = [-600, 600]\n", axis);
    if (chain.find(axis) < chain.find('b')) text += "errors_seen = \"body\"\n";
  }
  text += fmt::format("[tool]\norigin = [0, 0, {:.3f}]\nlength = {:.3f}\n[errors]\n", random.between(0, 200),
                      random.between(20, 150));
  for (const char axis : {'X', 'Y', 'Z'}) {
    for (const char direction : {'X', 'Y', 'Z', 'A', 'B', 'C'}) {
      const double size = scale * (direction >= 'X' ? 20 : 40);  // um, urad
      const auto a = [&] { return random.between(-size, size); };
      switch (random.below(4)) {
        case 0:
          text += fmt::format("E{}{} = {{ poly = [0, {:.9g}, {:.9g}] }}\n", direction, axis, a() / 500,
                              a() / 250000);
          break;
        case 1:
          text += fmt::format(
              "E{}{} = {{ table = [[-700, {:.6g}], [-250, {:.6g}], [50, {:.6g}], [300, {:.6g}], [700, "
              "{:.6g}]], interpolation = \"cubic\" }}\n",
              direction, axis, a(), a(), a(), a(), a());
          break;
        case 2:
          text += fmt::format("E{}{} = {{ sine = [{:.6g}, {:.6g}, {:.6g}] }}\n", direction, axis, a() / 5,
                              2 * std::numbers::pi / random.between(150, 900), random.between(-3, 3));
          break;
        default:
          text += fmt::format(
              "E{}{} = {{ table = [[-700, {:.6g}], [-100, {:.6g}], [200, {:.6g}], [700, {:.6g}]] }}\n",
              direction, axis, a(), a(), a(), a());
          break;
      }
    }
  }
  for (const char* name : {"EC0Y", "EB0Z", "EA0Z"})
    text += fmt::format("{} = {:.6g}\n", name, scale * random.between(-60, 60));
  return text;
}

}  // namespace abbe::testing
