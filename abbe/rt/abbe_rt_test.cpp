#include "abbe/rt/abbe_rt.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <string>

#include "abbe/chain/correct.h"
#include "abbe/core/test_allocations.h"
#include "abbe/machine/read_machine.h"

namespace {

const char* const kMachine = R"(format = 1
[machine]
name = "five axes"
chain = "w C A Y b X Z t"
[axis.X]
range = [-300, 300]
[axis.Y]
range = [-300, 300]
errors_seen = "tool"
[axis.Z]
range = [-300, 300]
[axis.A]
direction = [-1, 0, 0]
origin = [0, 0, -50]
[axis.C]
direction = [0, 0, -1]
origin = [0, 30, -80]
errors_seen = "tool"
[tool]
origin = [0, 0, 300]
length = 150
[workpiece]
origin = [0, 30, -80]
[errors]
EXX = { poly = [0, 0.05, -1e-4] }
EYX = { sine = [3, 0.02, 0.4] }
EZZ = { poly = [2, 0.03], domain = [-280, 280] }
EBZ = { poly = [0, 0.05] }
EXC = { sine = [4, 1, 0] }
EAC = { sine = [20, 1, 0.5] }
EC0X = 30
EB0A = 25
EXY = { poly = [0, 0.2], of = "T1", reference = 20 }
)";

/// A machine file that is gone at the end of the test.
struct File {
  explicit File(const std::string& text)
      : path(testing::TempDir() + "abbe_rt_" + std::to_string(reinterpret_cast<std::uintptr_t>(this)) +
             ".toml") {
    std::FILE* f = std::fopen(path.c_str(), "w");
    std::fputs(text.c_str(), f);
    std::fclose(f);
  }
  ~File() { std::remove(path.c_str()); }
  std::string path;
};

struct Model {
  explicit Model(const std::string& text, const char* sensors = "T1=23.5", double limit = 0) : file(text) {
    std::array<char, 500> message;
    model = abbe_rt_load(file.path.c_str(), sensors, limit, message.data(), message.size());
    why = message.data();
  }
  ~Model() { abbe_rt_free(model); }
  File file;
  abbe_rt_model* model = nullptr;
  std::string why;
};

constexpr double kDeg = 3.14159265358979323846 / 180;

TEST(RealTime, CorrectsAsTheLibraryDoes) {
  const Model model(kMachine);
  ASSERT_NE(model.model, nullptr) << model.why;
  EXPECT_EQ(abbe_rt_version(), ABBE_RT_VERSION);
  ASSERT_EQ(abbe_rt_axis_count(model.model), 5);
  std::string names;
  for (int i = 0; i < 5; ++i) names += abbe_rt_axis_name(model.model, i);
  EXPECT_EQ(names, "CAYXZ");
  EXPECT_EQ(abbe_rt_axis_name(model.model, 5), nullptr);
  EXPECT_EQ(abbe_rt_is_rotary(model.model, 1), 1);
  EXPECT_EQ(abbe_rt_is_rotary(model.model, 2), 0);
  EXPECT_EQ(abbe_rt_gauge_length(model.model), 150);

  const auto machine = abbe::read_machine_file(model.file.path).value.value();
  const auto plan = std::get<abbe::Plan>(abbe::make_plan(machine, {{"T1", 23.5}}));
  for (int i = 0; i < 200; ++i) {
    const std::array<double, 5> q = {i * 0.03, 0.5 + 0.003 * i, 100.0 - i, -80.0 + i, 0.5 * i};
    const double length = 100 + 0.3 * i;
    abbe::Query query;
    std::copy(q.begin(), q.end(), query.q.begin());
    query.tool = abbe::tool_of(machine, length);
    const abbe::Correction expected = abbe::correct(plan, query, 31, {});
    ASSERT_EQ(expected.status, abbe::Status::ok);
    std::array<double, 5> corrected;
    double last = -1;
    EXPECT_EQ(abbe_rt_correct(model.model, q.data(), length, corrected.data(), &last), ABBE_RT_OK);
    double moved = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      EXPECT_NEAR(corrected[k], expected.corrected[k], k < 2 ? 2e-9 : 1e-6);
      moved = std::max(moved, std::abs(corrected[k] - q[k]));
    }
    EXPECT_GT(moved, 1e-3);
    EXPECT_GE(last, 0);
    EXPECT_LT(last, 1e-3);
  }
}

TEST(RealTime, CorrectingAllocatesNothing) {
  if (!ABBE_COUNTS_ALLOCATIONS) GTEST_SKIP() << "the sanitizer counts its own";
  const Model model(kMachine);
  ASSERT_NE(model.model, nullptr) << model.why;
  std::array<double, 5> q = {0.1, 0.5, 10, 20, 30};
  const std::size_t before = abbe::allocation_count();
  ASSERT_GT(before, 0U);  // it counts: the model was loaded
  for (int i = 0; i < 100; ++i) {
    q[0] += 0.01;
    std::array<double, 5> corrected;
    static_cast<void>(abbe_rt_correct(model.model, q.data(), 120, corrected.data(), nullptr));
  }
  EXPECT_EQ(abbe::allocation_count(), before);
}

TEST(RealTime, WhatCannotBeCorrectedIsHeld) {
  const Model model(kMachine);
  ASSERT_NE(model.model, nullptr) << model.why;
  const double infinity = std::numeric_limits<double>::infinity();
  const double strange[] = {std::nan(""), infinity, -infinity, 1e308};
  for (const double x : strange) {
    for (std::size_t axis = 0; axis < 5; ++axis) {
      std::array<double, 5> q = {0.1, 0.5, 10, 20, 30};
      const std::array<double, 5> before = {1, 2, 3, 4, 5};
      std::array<double, 5> corrected = before;
      q[axis] = x;
      const abbe_rt_status status = abbe_rt_correct(model.model, q.data(), 120, corrected.data(), nullptr);
      EXPECT_EQ(status == ABBE_RT_INVALID, !std::isfinite(x));
      if (status == ABBE_RT_INVALID) {
        EXPECT_EQ(corrected, before);
      }
      for (const double c : corrected) EXPECT_TRUE(std::isfinite(c));
    }
    const std::array<double, 5> q = {0.1, 0.5, 10, 20, 30};
    std::array<double, 5> corrected{};
    if (!std::isfinite(x)) {
      EXPECT_EQ(abbe_rt_correct(model.model, q.data(), x, corrected.data(), nullptr), ABBE_RT_INVALID);
    }
  }
  // A = 0: C does not turn the tool's direction any more.
  const std::array<double, 5> singular = {0.3, 0, 10, 20, 30};
  std::array<double, 5> corrected{};
  double last = -1;
  EXPECT_EQ(abbe_rt_correct(model.model, singular.data(), 120, corrected.data(), &last), ABBE_RT_HELD);
  EXPECT_EQ(corrected, singular);
  EXPECT_EQ(last, 0);
  // Beyond the domain of EZZ.
  const std::array<double, 5> far = {0.3, 30 * kDeg, 10, 20, 290};
  EXPECT_EQ(abbe_rt_correct(model.model, far.data(), 120, corrected.data(), nullptr), ABBE_RT_OUTSIDE);
  EXPECT_NE(corrected, far);
}

/// Five axes restore the whole tool, whatever its length; three leave the tilt, whose lever the length is.
TEST(RealTime, TheGaugeLengthIsALever) {
  const Model model(
      "format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n[errors]\nEBX = { poly = [0, 1] }\n",
      nullptr);
  ASSERT_NE(model.model, nullptr) << model.why;
  const std::array<double, 3> q = {100, 0, 0};
  for (const double length : {0.0, 200.0}) {
    std::array<double, 3> corrected{};
    EXPECT_EQ(abbe_rt_correct(model.model, q.data(), length, corrected.data(), nullptr), ABBE_RT_OK);
    // The tip is below: a turn of 100 urad about +Y moves it by -length * 100e-6 along X.
    EXPECT_NEAR(corrected[0], 100 + length * 100e-6, 1e-5);
  }
}

TEST(RealTime, LargeCorrectionsAreHeld) {
  // 40 mm instead of 40 um: a slip of the unit.
  const std::string text =
      "format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n[errors]\nEYY = 40000\n";
  const Model usual(text), allowed(text, "", 100);
  ASSERT_NE(usual.model, nullptr) << usual.why;
  ASSERT_NE(allowed.model, nullptr) << allowed.why;
  const std::array<double, 3> q = {10, 20, 30};
  std::array<double, 3> corrected{};
  EXPECT_EQ(abbe_rt_correct(usual.model, q.data(), 0, corrected.data(), nullptr), ABBE_RT_HELD);
  EXPECT_EQ(corrected, q);
  EXPECT_EQ(abbe_rt_correct(allowed.model, q.data(), 0, corrected.data(), nullptr), ABBE_RT_OK);
  EXPECT_NEAR(corrected[1], -20, 1e-6);
  EXPECT_EQ(abbe_rt_load(usual.file.path.c_str(), nullptr, -1, nullptr, 0), nullptr);
}

TEST(RealTime, ARotaryAxisParallelToTheToolRests) {
  const Model model(
      "format = 1\n[machine]\nname = \"m\"\nchain = \"w C b X Y Z t\"\n[axis.C]\ndirection = [0, 0, 1]\n"
      "errors_seen = \"body\"\n[errors]\nEA0C = 30\nEXX = { poly = [0, 0.02] }\n");
  ASSERT_NE(model.model, nullptr) << model.why;
  const std::array<double, 4> q = {0.5, 50, 20, 10};
  std::array<double, 4> corrected{};
  EXPECT_EQ(abbe_rt_correct(model.model, q.data(), 0, corrected.data(), nullptr), ABBE_RT_OK);
  EXPECT_NE(corrected[1], q[1]);
}

TEST(RealTime, InPlaceIsAllowed) {
  const Model model(kMachine);
  ASSERT_NE(model.model, nullptr) << model.why;
  const std::array<double, 5> q = {0.3, 0.5, 10, 20, 30};
  std::array<double, 5> apart{}, same = q;
  EXPECT_EQ(abbe_rt_correct(model.model, q.data(), 120, apart.data(), nullptr), ABBE_RT_OK);
  EXPECT_EQ(abbe_rt_correct(model.model, same.data(), 120, same.data(), nullptr), ABBE_RT_OK);
  EXPECT_EQ(apart, same);
}

TEST(RealTime, WhyAMachineIsNotLoaded) {
  const std::string head = "format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n[errors]\n";
  EXPECT_EQ(abbe_rt_load(nullptr, nullptr, 0, nullptr, 0), nullptr);
  std::array<char, 12> small;
  EXPECT_EQ(abbe_rt_load("/nowhere/at/all.toml", nullptr, 0, small.data(), small.size()), nullptr);
  EXPECT_EQ(std::string(small.data()).size(), small.size() - 1);

  const Model sensor(kMachine, "");
  EXPECT_EQ(sensor.model, nullptr);
  EXPECT_NE(sensor.why.find("T1"), std::string::npos);
  const Model text(kMachine, "T1=warm");
  EXPECT_EQ(text.model, nullptr);
  EXPECT_NE(text.why.find("T1=warm"), std::string::npos);
  const Model broken(head + "EXQ = 1\n");
  EXPECT_EQ(broken.model, nullptr);
  EXPECT_NE(broken.why.find("error["), std::string::npos) << broken.why;
  const Model two_axes("format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Z t\"\n[errors]\nEXX = 1\n");
  EXPECT_EQ(two_axes.model, nullptr);
  EXPECT_NE(two_axes.why.find("three linear"), std::string::npos);
  const Model several(head + "EXX = { poly = [0, 1], of = \"X\", times = { poly = [0, 1], of = \"Y\" } }\n");
  EXPECT_EQ(several.model, nullptr);
  EXPECT_NE(several.why.find("several axes"), std::string::npos);
  const Model one_test(head + "EYY = 1\nEXX = { poly = [0, 1], scope = \"test\" }\n", nullptr);
  EXPECT_EQ(one_test.model, nullptr);
  EXPECT_NE(one_test.why.find("EXX is true of one test only"), std::string::npos) << one_test.why;
  const Model of_machine(head + "EXX = { poly = [0, 1], scope = \"machine\" }\n", nullptr);
  EXPECT_NE(of_machine.model, nullptr) << of_machine.why;
  const Model direction(head + "EXX = { forward = { poly = [1] }, backward = { poly = [2] } }\n", nullptr);
  ASSERT_NE(direction.model, nullptr) << direction.why;
  const std::array<double, 3> at = {10, 20, 30};
  std::array<double, 3> corrected{};
  EXPECT_EQ(abbe_rt_correct(direction.model, at.data(), 0, corrected.data(), nullptr), ABBE_RT_OK);
  EXPECT_NEAR(corrected[0], 10 - 1.5e-3, 1e-9);  // the mean of 1 and 2 um
  const Model simple(head + "EXX = { poly = [1, 0.1] }\n", nullptr);
  EXPECT_NE(simple.model, nullptr) << simple.why;
}

}  // namespace
