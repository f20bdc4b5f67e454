// What a corrected pose costs, in units of one forward kinematics + Jacobian call of Orocos KDL on the same
// chain: batches and single poses, every instruction set of this processor, five machines.
//
//   build/release/bench/kernel_ratios [ROUNDS [WHAT]]   default 40, the best round counts; WHAT: only names
//   with it
// "scattered" are the same poses in no order; "fixed" is the kernel's first-order batch for a topology known
// when it was compiled.
//
// All candidates take turns in one run, on path data: 1024 neighbouring poses, 40 error functions, 100 nodes
// each. Every candidate's result is checked before it is timed.

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainiksolverpos_nr.hpp>
#include <kdl/chainiksolvervel_pinv.hpp>
#include <kdl/chainjnttojacsolver.hpp>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/predict.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"
#include "abbe/machine/read_machine.h"
#include "bench/fixed_topology.h"
#include "bench/path_data.h"

namespace {

using namespace abbe;
using bench::kPoses;
using bench::path;
using bench::table;

struct Topology {
  const char* name;
  const char* text;
};
const Topology kTopologies[] = {
    {"table-table",
     "chain = \"w C A Y b X Z t\"\n[axis.A]\ndirection = [-1, 0, 0]\norigin = [0, 0, -50]\nerrors_seen = "
     "\"tool\"\n[axis.C]\ndirection = [0, 0, -1]\norigin = [0, 30, -80]\nerrors_seen = \"tool\"\n"
     "[axis.Y]\nerrors_seen = \"tool\"\n"},
    {"table, three below",
     "chain = \"w C A Y X b Z t\"\n[axis.A]\ndirection = [-1, 0, 0]\norigin = [0, 0, -50]\n"
     "errors_seen = \"tool\"\n[axis.C]\ndirection = [0, 0, -1]\norigin = [0, 30, -80]\n"
     "errors_seen = \"tool\"\n[axis.X]\nerrors_seen = \"tool\"\n[axis.Y]\nerrors_seen = \"tool\"\n"},
    {"head-head",
     "chain = \"w b X Y Z C A t\"\n[axis.C]\norigin = [0, 30, 400]\n[axis.A]\norigin = [0, 30, 380]\n"},
    {"mixed",
     "chain = \"w C X b Y Z A t\"\n[axis.C]\ndirection = [0, 0, -1]\norigin = [0, 30, -80]\nerrors_seen = "
     "\"tool\"\n[axis.X]\nerrors_seen = \"tool\"\n[axis.A]\norigin = [0, 30, 380]\n"},
    {"odd",
     "chain = \"w X Y b C A Z t\"\n[axis.C]\norigin = [0, 30, 400]\n[axis.A]\norigin = [0, 30, 380]\n"
     "[axis.X]\nerrors_seen = \"tool\"\n[axis.Y]\nerrors_seen = \"tool\"\n"}};

Machine machine_of(const Topology& topology) {
  std::string text =
      "format = 1\n[machine]\nname = \"" + std::string(topology.name) + "\"\n" + topology.text +
      "[tool]\norigin = [0, 0, 300]\nlength = 150\n[workpiece]\norigin = [0, 30, -80]\n[errors]\n";
  int seed = 1;
  for (const std::string axis : {"X", "Y", "Z", "A", "C"}) {
    for (const char d : std::string("XYZABC")) {
      const bool rotary = axis == "A" || axis == "C";
      text += table(std::string("E") + d + axis, seed++, 10, rotary ? -180 : -500, rotary ? 180 : 500);
    }
  }
  text +=
      "EC0X = 20\nEB0X = -5\nEA0Z = -12\nEB0Z = 9\nEA0C = 14\nEB0C = -8\nEY0A = 11\nEZ0A = 6\nEB0A = 7\nEC0A "
      "= -9\n";
  const Parsed<Machine> parsed = read_machine(
      {"bench.toml", text}, std::nullopt, [](const std::string&) { return std::optional<std::string>(); });
  if (!parsed.value) {
    std::fprintf(stderr, "%s: the machine is not valid\n", topology.name);
    std::exit(1);
  }
  return *parsed.value;
}

/// Everything of one machine that the candidates need.
struct Subject {
  Subject(const Topology& topology, bool scattered)
      : name(std::string(topology.name) + (scattered ? ", scattered" : "")),
        machine(machine_of(topology)),
        plan(std::get<Plan>(make_plan(machine, {}))),
        flat(kernel::FlatPlan::make(plan)),
        queries(path(machine, 0.004)) {
    if (scattered) std::shuffle(queries.begin(), queries.end(), std::mt19937(1));
    for (std::size_t k = 0; k < 5; ++k) {
      q.emplace_back();
      corrected.emplace_back(kPoses);
      for (const Query& query : queries) q.back().push_back(query.q[k]);
    }
    for (auto& column : q) from.push_back(column.data());
    for (auto& column : corrected) to.push_back(column.data());
    last.resize(kPoses);
    lanes.resize(kPoses);
    const Tool tool = tool_of(machine);
    for (int k = 0; k < 3; ++k) {
      setting.tip[k] = tool.tip[k];
      setting.axis[k] = tool.axis[k];
    }
    setting.free = 31;
  }

  /// Worst distance from the converged correction, mm and rad.
  void worst(double& linear, double& rotary) const {
    linear = rotary = 0;
    for (std::size_t i = 0; i < kPoses; i += 7) {
      const Correction exact = correct(plan, queries[i], 31, {});
      for (std::size_t k = 0; k < 5; ++k) {
        double& w = (flat->view().rotary >> k & 1) != 0 ? rotary : linear;
        w = std::max(w, std::abs(corrected[k][i] - exact.corrected[k]));
      }
    }
  }

  std::string name;
  Machine machine;
  Plan plan;
  std::shared_ptr<const kernel::FlatPlan> flat;
  std::vector<Query> queries;
  std::vector<std::vector<double>> q, corrected;
  std::vector<const double*> from;
  std::vector<double*> to;
  std::vector<double> last;
  std::vector<unsigned char> lanes;
  kernel::Setting setting;
};

/// What the compiler may round differently in the same code, mm and rad.
constexpr double kSameStep = 1e-7;

struct Candidate {
  std::string name;
  std::function<void()> run;  ///< kPoses poses
  std::string note;
  double best = 1e300;  ///< ns per pose
};

/// The kernel's code for one topology, beside the kernel; false: it computes something else.
bool add_fixed(const std::string& name, Subject& s, std::vector<Candidate>& candidates) {
  bench::FixedTopology fixed = nullptr;
#if defined(__x86_64__)
  if (name == "avx2") fixed = bench::correct_fixed_avx2;
  if (name == "avx512") fixed = bench::correct_fixed_avx512;
#endif
  if (fixed == nullptr) return true;
  const auto run = [&s, fixed] {
    return fixed(s.flat->view(), s.setting, s.from.data(), kPoses, s.to.data(), s.last.data());
  };
  s.setting.exact_steps = 0;
  kernel::named(name)->correct_poses(s.flat->view(), s.setting, s.from.data(), kPoses, s.to.data(),
                                     s.last.data(), s.lanes.data());
  const auto expected = s.corrected;
  double difference = run() ? 0 : 1;
  for (std::size_t k = 0; k < expected.size(); ++k)
    for (std::size_t i = 0; i < kPoses; ++i)
      difference = std::max(difference, std::abs(s.corrected[k][i] - expected[k][i]));
  if (difference > kSameStep) {
    std::fprintf(stderr, "%s: the fixed topology is not the machine's (%g)\n", name.c_str(), difference);
    return false;
  }
  candidates.push_back({name + " batch, first order, fixed table-table", run, "", 1e300});
  return true;
}

/// What a chain known only at run time costs, and how far the topologies are apart.
void print_spread(const std::string& name, const std::vector<Candidate>& candidates) {
  const std::string batch = name + " batch, first order, ";
  double least = 1e300, most = 0, first = 0, fixed = 0;
  for (const Candidate& c : candidates) {
    if (c.best > 1e200 || c.name.rfind(batch, 0) != 0 || c.name == batch + "table-table, scattered") continue;
    if (c.name == batch + "table-table") first = c.best;
    if (c.name == batch + "fixed table-table") {
      fixed = c.best;
      continue;
    }
    least = std::min(least, c.best);
    most = std::max(most, c.best);
  }
  if (most > 0) std::printf("%s: slowest topology / fastest %.2f", name.c_str(), most / least);
  if (most > 0 && fixed > 0) std::printf(", run-time topology / compile-time %.2f", first / fixed);
  if (most > 0) std::printf("\n");
}

KDL::Chain kdl_chain(const Machine& machine) {
  KDL::Chain chain;
  Vec3 at = machine.workpiece_origin;
  for (int i = 0; i <= machine.axis_count(); ++i) {
    const bool tip = i == machine.axis_count();
    const Vec3 to = tip ? tool_of(machine).tip : machine.axis(i).origin;
    const KDL::Frame step(KDL::Vector(to.x() - at.x(), to.y() - at.y(), to.z() - at.z()));
    at = to;
    // The offset in front of a joint belongs to the segment before it: KDL's fastest form.
    if (i == 0) {
      chain.addSegment(KDL::Segment(KDL::Joint(KDL::Joint::None), step));
    } else {
      const Body& body = machine.axis(i - 1);
      const Vec3 u = body.branch == Branch::workpiece ? Vec3(-body.direction) : body.direction;
      const auto type = body.type == AxisType::rotary ? KDL::Joint::RotAxis : KDL::Joint::TransAxis;
      chain.addSegment(
          KDL::Segment(KDL::Joint(KDL::Vector::Zero(), KDL::Vector(u.x(), u.y(), u.z()), type), step));
    }
  }
  return chain;
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 40;
  std::vector<std::unique_ptr<Subject>> subjects;
  for (const Topology& topology : kTopologies) subjects.push_back(std::make_unique<Subject>(topology, false));
  subjects.push_back(std::make_unique<Subject>(kTopologies[0], true));
  Subject& first = *subjects.front();
  std::vector<Candidate> candidates;

  // KDL
  const KDL::Chain chain = kdl_chain(first.machine);
  KDL::ChainFkSolverPos_recursive position(chain);
  KDL::ChainJntToJacSolver jacobian_solver(chain);
  KDL::ChainIkSolverVel_pinv velocity(chain);
  KDL::ChainIkSolverPos_NR inverse(chain, position, velocity, 100, 1e-9);
  KDL::Frame frame;
  KDL::Jacobian jacobian(5);
  std::vector<KDL::JntArray> joints;
  std::vector<KDL::Frame> frames;
  for (const Query& query : first.queries) {
    KDL::JntArray array(5);
    for (unsigned k = 0; k < 5; ++k) array(k) = query.q[k];
    joints.push_back(array);
    position.JntToCart(array, frame);
    frames.push_back(frame);
    const Vec3 tip = nominal_tip(first.plan, query);
    if ((tip - Vec3(frame.p.x(), frame.p.y(), frame.p.z())).norm() > 1e-9) {
      std::fprintf(stderr, "KDL has another chain\n");
      return 1;
    }
  }
  candidates.push_back({"KDL forward + Jacobian",
                        [&] {
                          for (const auto& q : joints) {
                            position.JntToCart(q, frame);
                            jacobian_solver.JntToJac(q, jacobian);
                            asm volatile("" : : "r"(jacobian.data.data()), "r"(&frame) : "memory");
                          }
                        },
                        "", 1e300});
  candidates.push_back({"KDL inverse (NR, start 1e-4 away)",
                        [&] {
                          KDL::JntArray start(5), out(5);
                          for (std::size_t i = 0; i < kPoses; i += 16) {
                            for (unsigned k = 0; k < 5; ++k) start(k) = joints[i](k) + 1e-4;
                            inverse.CartToJnt(start, frames[i], out);
                            asm volatile("" : : "r"(out.data.data()) : "memory");
                          }
                        },
                        "", 1e300});

  for (const char* name : {"baseline", "avx2", "avx512"}) {
    const kernel::Kernel* k = kernel::named(name);
    if (k == nullptr) continue;
    for (const auto& subject : subjects) {
      for (const int steps : {0, 1}) {
        Subject& s = *subject;
        const auto batch = [&s, k, steps] {
          s.setting.exact_steps = steps;
          k->correct_poses(s.flat->view(), s.setting, s.from.data(), kPoses, s.to.data(), s.last.data(),
                           s.lanes.data());
        };
        const auto single = [&s, k, steps] {
          s.setting.exact_steps = steps;
          std::array<const double*, 5> from;
          std::array<double*, 5> to;
          for (std::size_t i = 0; i < kPoses; ++i) {
            for (std::size_t a = 0; a < 5; ++a) {
              from[a] = s.from[a] + i;
              to[a] = s.to[a] + i;
            }
            k->correct_poses(s.flat->view(), s.setting, from.data(), 1, to.data(), &s.last[i], &s.lanes[i]);
          }
        };
        double linear = 0, rotary = 0;
        char note[100];
        batch();
        s.worst(linear, rotary);
        std::snprintf(note, sizeof note, "%.1e mm, %.1e rad from converged", linear, rotary);
        const std::string what = std::string(steps == 0 ? "first order" : "exact") + ", " + s.name;
        candidates.push_back({std::string(name) + " batch, " + what, batch, note, 1e300});
        if (&s == &first) candidates.push_back({std::string(name) + " single, " + what, single, "", 1e300});
      }
    }
    if (!add_fixed(name, first, candidates)) return 1;
  }

  const std::string wanted = argc > 2 ? argv[2] : "";
  for (int round = 0; round < rounds; ++round) {
    for (Candidate& c : candidates) {
      const bool peer = c.name.rfind("KDL", 0) == 0 && (wanted.empty() || round < 10);
      if (c.name.find(wanted) == std::string::npos && !peer) continue;
      const auto begin = std::chrono::steady_clock::now();
      c.run();
      const std::chrono::duration<double, std::nano> took = std::chrono::steady_clock::now() - begin;
      const std::size_t poses = c.name.rfind("KDL inverse", 0) == 0 ? kPoses / 16 : kPoses;
      c.best = std::min(c.best, took.count() / static_cast<double>(poses));
    }
  }
  const double unit = candidates[0].best, inverse_unit = candidates[1].best;
  std::printf("%-46s %9s %10s %10s\n", "best of the rounds, one core", "ns/pose", "FK+J / us", "IK / us");
  for (const Candidate& c : candidates) {
    if (c.best > 1e200) continue;
    std::printf("%-46s %9.1f %10.1f %10.0f  %s\n", c.name.c_str(), c.best, unit / c.best,
                inverse_unit / c.best, c.note.c_str());
  }
  for (const char* name : {"baseline", "avx2", "avx512"}) print_spread(name, candidates);
  return 0;
}
