#include "abbe/gear/flank_tolerances.h"

#include <gtest/gtest.h>

#include <array>

#include "abbe/gear/test_gears.h"

namespace abbe {
namespace {

using Row = std::array<double, 6>;

// f_p F_p f_Ha f_fa F_a F_r of the seed's gear, classes 5 to 8, um: computed apart from the formulas of
// ISO 1328-1:2013.
constexpr std::array<Row, 4> kUnrounded = {{{10.928, 41.1281, 9.928, 11.6, 15.2684, 37.0153},
                                            {15.4545, 58.1640, 14.0403, 16.4049, 21.5928, 52.3476},
                                            {21.856, 82.2563, 19.856, 23.2, 30.5369, 74.0307},
                                            {30.9091, 116.328, 28.0806, 32.8098, 43.1857, 104.695}}};
constexpr std::array<Row, 4> kRounded = {{{11, 41, 10, 12, 15, 37},
                                          {15, 58, 14, 16, 22, 52},
                                          {22, 82, 20, 23, 31, 74},
                                          {31, 116, 28, 33, 43, 105}}};
// f_Hb f_fb F_b at 100 and 200 mm.
constexpr std::array<std::array<double, 3>, 4> kNarrow = {{{9.1793, 10.851, 14.2128},
                                                           {12.9815, 15.3456, 20.0999},
                                                           {18.3586, 21.702, 28.4256},
                                                           {25.9629, 30.6913, 40.1998}}};
constexpr std::array<std::array<double, 3>, 4> kWide = {{{10.629, 12.715, 16.5725},
                                                         {15.0317, 17.9817, 23.4370},
                                                         {21.2581, 25.4299, 33.1449},
                                                         {30.0634, 35.9633, 46.874}}};

Row row_of(const FlankTolerances& t) { return {t.f_p, t.F_p, t.f_H_alpha, t.f_f_alpha, t.F_alpha, t.F_r}; }

TEST(FlankTolerances, SeedGearHasItsTolerances) {
  Gear gear = test::gear_of(test::seed_spec());
  for (int a = 5; a <= 8; ++a) {
    const auto i = static_cast<std::size_t>(a - 5);
    const Row row = row_of(*flank_tolerances(gear, a));
    for (std::size_t k = 0; k < row.size(); ++k) {
      EXPECT_NEAR(row[k] / um, kUnrounded[i][k], 6e-6 * kUnrounded[i][k] + 5e-5) << a << ' ' << k;
      EXPECT_NEAR(rounded_tolerance(row[k]) / um, kRounded[i][k], 1e-9) << a << ' ' << k;
    }
    for (const auto& [b, table] : {std::pair{100.0, kNarrow}, std::pair{200.0, kWide}}) {
      gear.spec.face_width = b;
      const FlankTolerances t = *flank_tolerances(gear, a);
      EXPECT_NEAR(t.f_H_beta / um, table[i][0], 1e-4);
      EXPECT_NEAR(t.f_f_beta / um, table[i][1], 1e-4);
      EXPECT_NEAR(t.F_beta / um, table[i][2], 1e-4);
    }
  }
}

TEST(FlankTolerances, ASmallGearOfClassSix) {
  GearSpec spec = test::seed_spec();
  spec.module = 3;
  spec.teeth = 40;
  spec.face_width = 30;
  const FlankTolerances t = *flank_tolerances(test::gear_of(spec), 6);
  EXPECT_NEAR(t.f_p / um, 8.9378, 1e-4);
  EXPECT_NEAR(t.F_p / um, 28.8004, 1e-4);
  EXPECT_NEAR(t.F_alpha / um, 12.0437, 1e-4);
  EXPECT_NEAR(t.F_beta / um, 13.7178, 1e-4);
  EXPECT_NEAR(t.F_r / um, 25.9203, 1e-4);
}

TEST(FlankTolerances, RoundingOfTheStandard) {
  const std::array<std::array<double, 2>, 6> cases = {
      {{12.49, 12}, {10.4, 10}, {7.3, 7.5}, {7.2, 7.0}, {4.96, 5.0}, {4.94, 4.9}}};
  for (const auto& [value, wanted] : cases) EXPECT_NEAR(rounded_tolerance(value * um) / um, wanted, 1e-9);
}

TEST(FlankTolerances, AClassIsARootOfTwo) {
  const Gear gear = test::gear_of(test::seed_spec());
  for (int a = 1; a < 11; ++a)
    EXPECT_NEAR(flank_tolerances(gear, a + 1)->F_p / flank_tolerances(gear, a)->F_p, std::sqrt(2), 1e-12);
  EXPECT_EQ(class_of(gear, &FlankTolerances::F_p, 58 * um), 6);
  EXPECT_EQ(class_of(gear, &FlankTolerances::F_p, 58.1 * um), 7);
  EXPECT_EQ(class_of(gear, &FlankTolerances::f_H_alpha, -14 * um), 6);
  EXPECT_EQ(class_of(gear, &FlankTolerances::F_p, 10), std::nullopt);
}

TEST(FlankTolerances, NoExtrapolation) {
  GearSpec spec = test::seed_spec();
  EXPECT_FALSE(flank_tolerances(test::gear_of(spec), 0));
  EXPECT_FALSE(flank_tolerances(test::gear_of(spec), 12));
  spec.face_width = 1201;
  EXPECT_FALSE(flank_tolerances(test::gear_of(spec), 6));
  spec.face_width = 100;
  spec.module = 0.4;
  EXPECT_FALSE(flank_tolerances(test::gear_of(spec), 6));
}

}  // namespace
}  // namespace abbe
