// One pose at a time: prediction and correction, beside forward kinematics and Jacobian of the same
// chain by Orocos KDL where it is installed. Every benchmark checks its own result before timing.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/predict.h"
#include "abbe/machine/read_machine.h"
#include "bench/path_data.h"

#ifdef ABBE_HAVE_KDL
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#endif

namespace {

using namespace abbe;
using bench::path;
using bench::table;
using Commands = std::array<double, kMaxAxes>;

std::string cubic(const std::string& name, int seed, double first) {
  const double s = (seed % 7) - 3, t = (seed % 5) - 2;
  return name + " = { poly = [0, " + std::to_string(first * s) + ", " + std::to_string(first * t * 1e-3) +
         ", " + std::to_string(first * s * 1e-6) + "] }\n";
}

/// 6 functions per axis and, on five axes, 2 squareness or location angles each: 40 functions.
std::string errors(const std::vector<std::string>& axes, bool tables) {
  std::string text = "[errors]\n";
  int seed = 1;
  for (const std::string& axis : axes) {
    for (const char d : std::string("XYZABC")) {
      const std::string name = std::string("E") + d + axis;
      const bool rotary = axis == "A" || axis == "C";
      text += tables ? table(name, seed, 10, rotary ? -180 : -500, rotary ? 180 : 500)
                     : cubic(name, seed, rotary ? 0.05 : 0.02);
      ++seed;
    }
  }
  return text;
}

Machine read(const std::string& text) {
  const Parsed<Machine> parsed = read_machine(
      {"bench.toml", text}, std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  return parsed.value.value();
}

Machine three_axes(bool tables) {
  return read(
      "format = 1\n[machine]\nname = \"bench\"\nchain = \"w X b Y Z t\"\n[axis.X]\nerrors_seen = "
      "\"tool\"\n[tool]\nlength = 120\n" +
      errors({"X", "Y", "Z"}, tables) + "EC0Y = 20\nEA0Z = -12\nEB0Z = 9\n");
}

Machine five_axes(bool tables) {
  return read(
      "format = 1\n[machine]\nname = \"bench\"\nchain = \"w C A Y b X Z t\"\n"
      "[axis.Y]\nerrors_seen = \"tool\"\n"
      "[axis.A]\ndirection = [-1, 0, 0]\norigin = [0, 0, -50]\nerrors_seen = \"tool\"\n"
      "[axis.C]\ndirection = [0, 0, -1]\norigin = [0, 30, -80]\nerrors_seen = \"tool\"\n"
      "[tool]\norigin = [0, 0, 300]\nlength = 150\n[workpiece]\norigin = [0, 30, -80]\n" +
      errors({"X", "Y", "Z", "A", "C"}, tables) +
      "EC0X = 20\nEB0X = -5\nEA0Z = -12\nEB0Z = 9\nEA0C = 14\nEB0C = -8\nEY0A = 11\nEZ0A = 6\nEB0A = 7\nEC0A "
      "= -9\n");
}

Plan plan_of(const Machine& machine) { return std::get<Plan>(make_plan(machine, {})); }

bool corrects(const Plan& plan, const Query& query, const Correction& c, double limit) {
  Query there = query;
  there.q = c.corrected;
  return c.status == Status::ok && (actual_tip(plan, there) - nominal_tip(plan, query)).norm() <= limit;
}

void actual_tip_per_pose(benchmark::State& state, const Machine& machine) {
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  if ((actual_tip(plan, queries[5]) - predict(plan, queries[5]).actual.position).norm() > 1e-10)
    state.SkipWithError("wrong tip");
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(actual_tip(plan, queries[i++ & 1023]));
}

void nominal_tip_per_pose(benchmark::State& state, const Machine& machine) {
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  if ((nominal_tip(plan, queries[5]) - predict(plan, queries[5]).nominal.position).norm() > 1e-10)
    state.SkipWithError("wrong tip");
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(nominal_tip(plan, queries[i++ & 1023]));
}

void predict_pose(benchmark::State& state, const Machine& machine) {
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  const Prediction first = predict(plan, queries[5]);
  if (!first.finite || first.deviation.position.norm() == 0) state.SkipWithError("nothing predicted");
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(predict(plan, queries[i++ & 1023]));
}

void correct_cold(benchmark::State& state, const Machine& machine) {
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  const AxisSet free = free_axes(machine, 0).value();
  int evaluations = 0;
  for (const Query& query : queries) {
    const Correction c = correct(plan, query, free, {});
    evaluations += c.iterations;
    if (!corrects(plan, query, c, 1e-9)) state.SkipWithError("not corrected");
  }
  state.counters["evaluations"] = evaluations / 1024.0;
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(correct(plan, queries[i++ & 1023], free, {}));
}

void correct_warm(benchmark::State& state, const Machine& machine) {
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  const AxisSet free = free_axes(machine, 0).value();
  CorrectOptions options;
  options.position_tolerance = 1e-6;
  options.rotation_tolerance = 1e-9;
  std::vector<Commands> starts;
  int evaluations = 0;
  for (const Query& query : queries) {
    starts.push_back(correct(plan, query, free, {}).corrected);
    starts.back()[0] += 1e-5;
    const Correction c = correct(plan, query, free, options, &starts.back());
    evaluations += c.iterations;
    if (!corrects(plan, query, c, 1e-6)) state.SkipWithError("not corrected");
  }
  state.counters["evaluations"] = evaluations / 1024.0;
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(correct(plan, queries[i & 1023], free, options, &starts[i & 1023]));
    ++i;
  }
}

#ifdef ABBE_HAVE_KDL
/// The same five axes as a serial chain from the workpiece to the tool: work-branch motions inverted.
KDL::Chain kdl_chain(const Machine& machine) {
  KDL::Chain chain;
  Vec3 at = machine.workpiece_origin;
  const auto offset = [&](const Vec3& to) {
    const Vec3 by = to - at;
    at = to;
    return KDL::Vector(by.x(), by.y(), by.z());
  };
  for (int i = 0; i < machine.axis_count(); ++i) {
    const Body& body = machine.axis(i);
    const Vec3 u = body.branch == Branch::workpiece ? Vec3(-body.direction) : body.direction;
    const KDL::Vector axis(u.x(), u.y(), u.z());
    const auto type = body.type == AxisType::rotary ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(offset(body.origin))));
    chain.addSegment(KDL::Segment(KDL::Joint(KDL::Vector::Zero(), axis, type)));
  }
  chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), KDL::Frame(offset(tool_of(machine).tip))));
  return chain;
}

/// Fixed segments are folded into the joints' frames: KDL's fastest form of the chain.
KDL::Chain folded(const KDL::Chain& chain) {
  KDL::Chain out;
  KDL::Frame before = KDL::Frame::Identity();
  KDL::Joint joint(KDL::Joint::None);
  bool have = false;
  for (const KDL::Segment& segment : chain.segments) {
    if (segment.getJoint().getType() == KDL::Joint::None) {
      before = before * segment.getFrameToTip();
      continue;
    }
    if (have)
      out.addSegment(KDL::Segment(joint, before));
    else if (!KDL::Equal(before, KDL::Frame::Identity()))
      out.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), before));
    joint = segment.getJoint();
    before = KDL::Frame::Identity();
    have = true;
  }
  out.addSegment(KDL::Segment(joint, before));
  return out;
}

void kdl_fk_and_jacobian(benchmark::State& state) {
  const Machine machine = five_axes(false);
  const Plan plan = plan_of(machine);
  const std::vector<Query> queries = path(machine, 0.006);
  const KDL::Chain chain = folded(kdl_chain(machine));
  KDL::ChainFkSolverPos_recursive position(chain);
  KDL::ChainJntToJacSolver solver(chain);
  const auto joints = chain.getNrOfJoints();
  std::vector<KDL::JntArray> q;
  for (const Query& query : queries) {
    KDL::JntArray array(joints);
    for (unsigned i = 0; i < joints; ++i) array(i) = query.q[i];
    q.push_back(array);
  }
  KDL::Frame frame;
  KDL::Jacobian jacobian(joints);
  position.JntToCart(q[5], frame);
  const Vec3 tip = nominal_tip(plan, queries[5]);
  if ((tip - Vec3(frame.p.x(), frame.p.y(), frame.p.z())).norm() > 1e-9)
    state.SkipWithError("KDL has another chain");
  std::size_t i = 0;
  for (auto _ : state) {
    position.JntToCart(q[i & 1023], frame);
    solver.JntToJac(q[i & 1023], jacobian);
    benchmark::DoNotOptimize(frame);
    benchmark::DoNotOptimize(jacobian.data.data());
    ++i;
  }
}
BENCHMARK(kdl_fk_and_jacobian);
#endif

BENCHMARK_CAPTURE(nominal_tip_per_pose, three_axes, three_axes(false));
BENCHMARK_CAPTURE(actual_tip_per_pose, three_axes_21_cubics, three_axes(false));
BENCHMARK_CAPTURE(actual_tip_per_pose, three_axes_21_splines, three_axes(true));
BENCHMARK_CAPTURE(correct_warm, three_axes_21_cubics, three_axes(false));
BENCHMARK_CAPTURE(correct_cold, three_axes_21_cubics, three_axes(false));
BENCHMARK_CAPTURE(correct_cold, three_axes_21_splines, three_axes(true));
BENCHMARK_CAPTURE(actual_tip_per_pose, five_axes_40_cubics, five_axes(false));
BENCHMARK_CAPTURE(predict_pose, five_axes_40_cubics, five_axes(false));
BENCHMARK_CAPTURE(predict_pose, five_axes_40_splines, five_axes(true));
BENCHMARK_CAPTURE(correct_warm, five_axes_40_cubics, five_axes(false));
BENCHMARK_CAPTURE(correct_cold, five_axes_40_cubics, five_axes(false));
BENCHMARK_CAPTURE(correct_cold, five_axes_40_splines, five_axes(true));

}  // namespace
