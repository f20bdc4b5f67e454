#include "abbe/surface/tool_path.h"

#include <gtest/gtest.h>

#include <cmath>

#include "abbe/machine/profile.h"
#include "abbe/surface/test_surfaces.h"
#include "abbe/surface/write_tool_path.h"

namespace abbe {
namespace {

constexpr double kPico = 1e-9;  // mm

ToolPath path_of(const NurbsSurface& surface, const ToolPathJob& job) {
  auto made = make_tool_path(NearestPoint(surface), job);
  if (const auto* fault = std::get_if<ToolPathFault>(&made)) {
    ADD_FAILURE() << to_text(*fault);
    return {};
  }
  return std::get<ToolPath>(std::move(made));
}

TEST(ToolPath, FlatStepIsTheFormula) {
  const double step = 2 * std::sqrt(2 * 3 * 0.005 - 0.005 * 0.005);
  EXPECT_NEAR(step_for_scallop(3, 0.005, 0), step, kPico);
  const ToolPath path = path_of(plane_patch(20, 10), {});
  EXPECT_NEAR(path.least_step, step, 1e-7);
  EXPECT_NEAR(path.most_step, step, 1e-7);
  EXPECT_EQ(path.passes.size(), 1 + static_cast<std::size_t>(std::ceil(20 / step)));
  for (const ToolPass& pass : path.passes)
    for (const ToolContact& point : pass.points) {
      EXPECT_LT((point.tip - point.contact).norm(), kPico) << "a ball on a plane stands on its tip";
      EXPECT_NEAR(point.tip.z(), 0, kPico);
    }
  EXPECT_NEAR(path.passes.back().points.back().tip.x(), 20, kPico) << "the last pass is the rim";
}

TEST(ToolPath, CurvatureDecidesTheStep) {
  for (const bool hollow : {true, false}) {
    const double k = (hollow ? 1.0 : -1.0) / 20;
    const ToolPath path = path_of(cylinder_patch(20, 0.6, 10, hollow), {});
    EXPECT_NEAR(path.least_step, step_for_scallop(3, 0.005, k), 2e-6);
    EXPECT_NEAR(path.most_step, step_for_scallop(3, 0.005, k), 2e-6);
  }
  EXPECT_GT(step_for_scallop(3, 0.005, 0.05), step_for_scallop(3, 0.005, 0)) << "hollow steps are wider";
  EXPECT_LT(step_for_scallop(3, 0.005, -0.05), step_for_scallop(3, 0.005, 0));
  EXPECT_NEAR(step_for_scallop(3, 0.005, 0.05), std::sqrt(8 * 0.005 * 3 * 20 / 17), 2e-4);
  EXPECT_EQ(step_for_scallop(3, 0.005, 0.4), 0);
}

TEST(ToolPath, ConstantStepIsConstant) {
  ToolPathJob job;
  job.scallop = 0;
  job.step = 0.7;
  const ToolPath path = path_of(cylinder_patch(20, 0.6, 10, true), job);
  EXPECT_NEAR(path.least_step, 0.7, 1e-6);
  EXPECT_NEAR(path.most_step, 0.7, 1e-6);
}

TEST(ToolPath, ChordsKeepTheTolerance) {
  const NurbsSurface surface = cylinder_patch(20, 0.6, 10, true);
  ToolPathJob job;
  job.along_v = false;  // around the hollow
  const ToolPath path = path_of(surface, job);
  for (const ToolPass& pass : path.passes) {
    for (std::size_t k = 1; k < pass.points.size(); ++k) {
      const Vec3 middle = (pass.points[k].tip + pass.points[k - 1].tip) / 2 + Vec3(0, 0, 3);
      EXPECT_LE(17 - std::hypot(middle.x(), middle.z()), 1 * um + kPico);
    }
  }
  EXPECT_GT(path.passes[0].points.size(), 20u);
}

TEST(ToolPath, NoPointGouges) {
  const NurbsSurface surface = wavy_patch(2);
  const NearestPoint nominal(surface);
  ToolPathJob job;
  job.scallop = 50 * um;
  for (const ToolPass& pass : path_of(surface, job).passes)
    for (const ToolContact& point : pass.points)
      EXPECT_GE(nominal(point.tip + Vec3(0, 0, 3)).distance, 3 - 1e-6);
}

TEST(ToolPath, ACreaseIsNotCutOff) {
  // A ridge between slopes of +-0.4: from contact to contact the ball would go R (1 - cos(atan 0.4)) deep.
  NurbsSurface tent;
  tent.degree = {1, 1};
  tent.count = {3, 2};
  tent.knots = {std::vector<double>{0, 0, 1, 2, 2}, uniform_knots(2, 1)};
  for (const Vec3& p : {Vec3(0, 0, 0), Vec3(10, 0, 4), Vec3(20, 0, 0)})
    for (const double y : {0.0, 20.0}) tent.points.push_back(p + Vec3(0, y, 0));
  tent.weights.assign(6, 1.0);
  ToolPathJob job;
  job.along_v = false;
  const auto across = make_tool_path(NearestPoint(tent), job);
  const auto* fault = std::get_if<ToolPathFault>(&across);
  ASSERT_TRUE(fault);
  EXPECT_EQ(fault->kind, ToolPathFault::Kind::gouge);
  EXPECT_NEAR(fault->point.x(), 10, 0.01);
  EXPECT_NEAR(fault->value, 3 * (1 - 1 / std::sqrt(1.16)), 5 * um);
  // Along the ridge, lifted between, nothing goes across it.
  job.along_v = true;
  job.zigzag = false;
  EXPECT_GT(path_of(tent, job).passes.size(), 20u);
}

TEST(ToolPath, FaultsAreNamed) {
  const auto kind_of = [](const NurbsSurface& surface, const ToolPathJob& job) {
    const auto made = make_tool_path(NearestPoint(surface), job);
    const auto* fault = std::get_if<ToolPathFault>(&made);
    return fault ? static_cast<int>(fault->kind) : -1;
  };
  ToolPathJob job;
  EXPECT_EQ(kind_of(cylinder_patch(2.9, 0.6, 10, true), job),
            static_cast<int>(ToolPathFault::Kind::curvature));
  EXPECT_EQ(kind_of(cylinder_patch(20, 1.58, 10, false), job),
            static_cast<int>(ToolPathFault::Kind::undercut));
  EXPECT_EQ(kind_of(sphere_patch(20, 0, 0.8, 1.4, true), job), static_cast<int>(ToolPathFault::Kind::pole));
  job.along_v = false;
  EXPECT_EQ(kind_of(sphere_patch(20, 0, 0.8, 1.4, true), job), static_cast<int>(ToolPathFault::Kind::pole));
  job.along_v = true;
  job.scallop = 1e-10;
  EXPECT_EQ(kind_of(plane_patch(20, 10), job), static_cast<int>(ToolPathFault::Kind::endless));
  // Wide enough everywhere by curvature, but the groove's other wall is nearer than the ball.
  NurbsSurface groove;
  groove.degree = {1, 1};
  groove.count = {4, 2};
  groove.knots = {std::vector<double>{0, 0, 1, 2, 3, 3}, uniform_knots(2, 1)};
  for (const Vec3& p : {Vec3(0, 0, 10), Vec3(2, 0, 0), Vec3(6, 0, 0), Vec3(8, 0, 10)})
    for (const double y : {0.0, 10.0}) groove.points.push_back(p + Vec3(0, y, 0));
  groove.weights.assign(8, 1.0);
  EXPECT_EQ(kind_of(groove, {}), static_cast<int>(ToolPathFault::Kind::gouge));
  EXPECT_EQ(kind_of(plane_patch(20, 10), {}), -1);
  const auto stop = [](std::uint64_t, std::uint64_t) { return false; };
  const auto stopped = make_tool_path(NearestPoint(plane_patch(20, 10)), {}, stop);
  EXPECT_EQ(std::get<ToolPathFault>(stopped).kind, ToolPathFault::Kind::stopped);
}

TEST(WriteToolPath, ProgramsSpeakTheControlsLanguage) {
  ToolPathJob job;
  job.scallop = 0;
  job.step = 5;
  const ToolPath path = path_of(plane_patch(10, 4), job);
  ToolPathText text;
  text.name = "plate (one)";
  Profile control;
  EXPECT_FALSE(write_program(path, text, control)) << "a control without codes";
  control.g[0].meaning = Meaning::rapid;
  control.g[10].meaning = Meaning::line;
  control.g[210].meaning = Meaning::units_mm;
  control.g[900].meaning = Meaning::absolute;
  control.g[940].meaning = Meaning::per_minute;
  control.g[540] = {Meaning::work_offset, false, 0, 1, 0};
  control.m[2].meaning = Meaning::end;
  const auto program = write_program(path, text, control);
  ASSERT_TRUE(program);
  EXPECT_EQ(*program,
            "%\n(plate  one , ball of 3 mm)\n(switch on spindle and coolant before)\nG21 G90 G94 G54\nG0 "
            "X0.0000 Y0.0000 Z5.0000\nG1 Z0.0000 "
            "F1000.0\nG1 Y4.0000\n"
            "G1 X5.0000\nG1 Y0.0000\nG1 X10.0000\nG1 Y4.0000\nG0 Z5.0000\nM2\n%\n");
  EXPECT_EQ(write_cl(path, text).substr(0, 120),
            std::string("PARTNO plate  one \nUNITS/MM\nCUTTER/6.0000,3.0000\nFEDRAT/1000.0,MMPM\nRAPID\n"
                        "GOTO/0.000000,0.000000,5.000000\nGOTO/0.000000,0.000000,0.000000\n")
                .substr(0, 120));
}

}  // namespace
}  // namespace abbe
