#include "abbe/kernel/flat_windows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace abbe::kernel {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// A table of cubics: segments of about 10 mm from -500 on, the first one open below, the last one above.
/// Displacements of 0.02 mm and rotations of 5e-5 rad, continuous unless a step is asked for.
struct Cubics {
  static constexpr std::uint32_t kSegments = 23, kRows = 4;
  std::vector<double> knots, rows;
  FlatTable table;

  explicit Cubics(double step, double unequal = 2) : rows(kSegments * kRows * kRow) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> uniform(-1, 1);
    for (std::uint32_t i = 0; i < kSegments; ++i)
      knots.push_back(i < 2 ? -500.0 : -510.0 + 10.0 * i + unequal * uniform(random));
    std::sort(knots.begin(), knots.end());
    for (int component = 0; component < kComponents; ++component) {
      const double size = component < 3 ? 0.02 : 5e-5;
      for (std::uint32_t i = 0; i < kSegments; ++i) {
        for (std::uint32_t power = 0; power < kRows; ++power)
          coefficient(i, power, component) = size * uniform(random) * std::pow(20, -static_cast<int>(power));
        if (i > 0) coefficient(i, 0, component) = value(i - 1, component, knots[i] - knots[i - 1]);
        if (i == 17) coefficient(i, 0, component) += size * step;
      }
    }
    table.knots = knots.data();
    table.rows = rows.data();
    table.segments = kSegments;
    table.row_count = kRows;
    table.lo = table.waves_lo = -kInfinity;
    table.hi = table.waves_hi = kInfinity;
  }
  double& coefficient(std::uint32_t i, std::uint32_t power, int component) {
    return rows[(i * kRows + kRows - 1 - power) * kRow + static_cast<std::size_t>(component)];
  }
  double value(std::uint32_t i, int component, double t) {
    double sum = 0;
    for (std::uint32_t power = kRows; power-- > 0;) sum = sum * t + coefficient(i, power, component);
    return sum;
  }
  /// The same constant everywhere.
  void make_level() { make_zigzag(0); }
  /// Straight lines up and down, from and to 0.02 mm at even knots.
  void make_zigzag(double slope) {
    std::fill(rows.begin(), rows.end(), 0.0);
    for (std::uint32_t i = 0; i < kSegments; ++i) {
      const double sign = i % 2 == 0 ? 1 : -1;
      coefficient(i, 1, 0) = -sign * slope;
      coefficient(i, 0, 0) = i == 0 ? 0.02 : value(i - 1, 0, knots[i] - knots[i - 1]);
    }
  }
  double terms(std::uint32_t i, int component, double t) {
    double sum = 0;
    for (std::uint32_t power = 0; power < kRows; ++power)
      sum += std::abs(coefficient(i, power, component) * std::pow(t, power));
    return sum;
  }
};

/// Number `number` of the rows of the window of segment `first`.
const WindowRow& row(const std::vector<WindowRow>& rows, std::uint32_t first, int number) {
  constexpr std::size_t kRowsOfWindow = 3 + kComponents * Cubics::kRows;
  return rows[first / kWindowStep * kRowsOfWindow + static_cast<std::size_t>(number)];
}

TEST(FlatWindows, KeepTheirBound) {
  Cubics cubics(0);
  cubics.table.lo = -503;
  const std::vector<WindowRow> rows = windows_of(cubics.table);
  std::mt19937 random(8);
  int compared = 0;
  double worst_mm = 0;
  for (std::uint32_t first = 0; first < Cubics::kSegments; first += kWindowStep) {
    for (std::uint32_t k = 0; k < std::min(kWindow, Cubics::kSegments - first); ++k) {
      const bool last = k + 1 == kWindow || first + k + 1 == Cubics::kSegments;
      const float begin = row(rows, first, 0).value[k];
      const float end = last ? row(rows, first, 2).value[0] : row(rows, first, 0).value[k + 1];
      ASSERT_TRUE(begin <= end) << first << " " << k;
      std::uniform_real_distribution<double> inside(begin, end);
      for (int i = 0; i < 200; ++i, ++compared) {
        const double q = cubics.knots[first] + inside(random);
        ASSERT_GE(q, cubics.table.lo);
        const float t = static_cast<float>(q - cubics.knots[first]) - row(rows, first, 1).value[k];
        for (int component = 0; component < kComponents; ++component) {
          float single = 0;
          for (int power = 0; power < static_cast<int>(Cubics::kRows); ++power)
            single = single * t + row(rows, first, 3 + power * kComponents + component).value[k];
          const double expected = cubics.value(first + k, component, q - cubics.knots[first + k]);
          const double most =
              (component < 3 ? kSingleMm : kSingleRad) + kSinglePart * cubics.terms(first + k, component, t);
          ASSERT_NEAR(single, expected, most) << first << " " << k;
          if (component < 3) worst_mm = std::max(worst_mm, std::abs(single - expected));
        }
      }
    }
  }
  EXPECT_GT(compared, 5000);
  EXPECT_GT(worst_mm, kSingleMm / 100);  // it is single precision that is tried
}

TEST(FlatWindows, FindEquallyWideSegmentsByAProduct) {
  Cubics cubics(0, 0);
  cubics.make_level();
  const std::vector<WindowRow> rows = windows_of(cubics.table);
  std::mt19937 random(9);
  std::uniform_real_distribution<double> inside(0, 10.0 * kWindow);
  // Segment 0 is open below, and the last two windows reach the segment that is open above.
  for (std::uint32_t first = kWindowStep; first + kWindow < Cubics::kSegments; first += kWindowStep) {
    const float end = row(rows, first, 2).value[0], per_unit = row(rows, first, 2).value[1];
    ASSERT_GT(per_unit, 0) << first;
    EXPECT_LT(end * per_unit, kWindow);
    for (int i = 0; i < 1000; ++i) {
      const double x = inside(random);
      if (std::abs(x / 10 - std::round(x / 10)) < 1e-5) continue;
      EXPECT_EQ(std::floor(static_cast<float>(x) * per_unit), std::floor(x / 10));
    }
  }
  EXPECT_EQ(row(rows, 0, 2).value[1], 0);
  Cubics unequal(0);
  unequal.make_level();
  EXPECT_EQ(row(windows_of(unequal.table), kWindowStep, 2).value[1], 0);
}

/// Its segment in the window as the kernel finds it.
std::uint32_t segment_of(const std::vector<WindowRow>& rows, std::uint32_t first, float x) {
  const float per_unit = row(rows, first, 2).value[1];
  if (per_unit > 0) return static_cast<std::uint32_t>(x * per_unit);
  std::uint32_t k = 0;
  while (k + 1 < kWindow && x >= row(rows, first, 0).value[k + 1]) ++k;
  return k;
}

/// Slopes that jump: a knot that is missed shows. Steep ones are left to comparisons, flat ones to the
/// product.
TEST(FlatWindows, KeepTheirBoundAtKnots) {
  std::mt19937 random(10);
  std::uniform_real_distribution<double> near(-1e-4, 1e-4);
  for (const double slope : {0.004, 2e-5}) {
    Cubics cubics(0, 0);
    cubics.make_zigzag(slope);
    const std::vector<WindowRow> rows = windows_of(cubics.table);
    for (std::uint32_t first = kWindowStep; first + kWindow < Cubics::kSegments; first += kWindowStep) {
      ASSERT_EQ(row(rows, first, 2).value[1] > 0, slope < 1e-4);
      for (int i = 0; i < 2000; ++i) {
        const std::uint32_t knot = first + 1 + static_cast<std::uint32_t>(random() % (kWindow - 1));
        const double q = cubics.knots[knot] + near(random), x = q - cubics.knots[first];
        const std::uint32_t k = segment_of(rows, first, static_cast<float>(x));
        const float t = static_cast<float>(x) - row(rows, first, 1).value[k];
        const float single = row(rows, first, 3 + 2 * kComponents).value[k] * t +
                             row(rows, first, 3 + 3 * kComponents).value[k];
        const std::uint32_t true_segment = q >= cubics.knots[knot] ? knot : knot - 1;
        const double expected = cubics.value(true_segment, 0, q - cubics.knots[true_segment]);
        ASSERT_NEAR(single, expected, 2 * (kSingleMm + kSinglePart * 0.02)) << slope << " " << x;
      }
    }
  }
}

TEST(FlatWindows, LeaveStepsToDoublePrecision) {
  Cubics cubics(0.01);
  const std::vector<WindowRow> rows = windows_of(cubics.table);
  for (std::uint32_t first = 0; first < Cubics::kSegments; first += kWindowStep) {
    const bool has_step = first < 17 && 17 < first + kWindow;
    EXPECT_EQ(std::isinf(row(rows, first, 0).value[1]), has_step) << first;
  }
}

/// A segment so short beside its neighbours that positions in single precision are too coarse for it.
TEST(FlatWindows, LeaveUnequalSegmentsToDoublePrecision) {
  Cubics cubics(0);
  for (std::uint32_t i = 0; i < 9; ++i) cubics.knots[i] -= 1000;
  cubics.knots[9] = cubics.knots[10] - 1e-4;
  for (int component = 0; component < kComponents; ++component) {
    for (std::uint32_t i = 8; i < 10; ++i)
      for (std::uint32_t power = 1; power < Cubics::kRows; ++power)
        cubics.coefficient(i, power, component) = 0;
    cubics.coefficient(9, 0, component) = cubics.coefficient(8, 0, component);
    cubics.coefficient(9, 1, component) =
        1e4 * (cubics.coefficient(10, 0, component) - cubics.coefficient(9, 0, component));
  }
  const std::vector<WindowRow> rows = windows_of(cubics.table);
  EXPECT_TRUE(std::isinf(row(rows, 8, 0).value[1]) || std::isinf(row(rows, 4, 0).value[1]));
  EXPECT_FALSE(std::isinf(row(rows, 12, 0).value[1]));
}

}  // namespace
}  // namespace abbe::kernel
