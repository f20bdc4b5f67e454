// A whole gear (94 teeth, two flanks each, 200 x 50 points) cut on a machine with errors, beside 10^7 calls
// of predict on the same machine; and how it is judged.
//   build/release/bench/gear_bench

#include <benchmark/benchmark.h>

#include <variant>

#include "abbe/chain/predict.h"
#include "abbe/gear/machine_cut.h"
#include "abbe/machine/read_machine.h"

namespace {

constexpr const char* kMachine =
    "format = 1\n[machine]\nchain = \"w C b X Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\nerrors_seen = "
    "\"body\"\n"
    "[tool]\naxis = [0, 1, 0]\n[errors]\nEXX = { poly = [0, 0.012] }\nEYX = { poly = [0, 0, 1.1e-5] }\n"
    "EBX = { poly = [0, 0.021] }\nEZZ = { poly = [0, -0.017] }\nEYZ = { poly = [0, 0.03] }\nEAZ = { poly = "
    "[0, 0.034] }\n"
    "EZC = { sine = [2.1, 0.0174533, 0.4] }\nECC = { sine = [9, 0.0174533, 0] }\nEXw = 4\n";

struct Work {
  abbe::Machine machine = *abbe::read_machine({"m.toml", kMachine}, std::nullopt, nullptr).value;
  abbe::GearJob job;
  abbe::WheelInGap wheel;
  abbe::CuttingMotion motion;
  std::vector<double> z;

  Work() {
    abbe::GearSpec spec;
    spec.module = 12;
    spec.teeth = 94;
    spec.face_width = 100;
    job.gear = std::get<abbe::Gear>(abbe::make_gear(spec));
    job.wheel.diameter = 300;
    wheel = std::get<abbe::WheelInGap>(abbe::fit_wheel(job.gear, job.wheel, abbe::even_rolls(job.gear, 200)));
    motion = std::get<abbe::CuttingMotion>(abbe::plan_cutting(machine, job, wheel, 33, {}));
    z = abbe::even_heights(job.gear, 50);
  }
};

const Work& work() {
  static const Work made;
  return made;
}

/// From the machine file's errors to 1.88 million flank points; the nominal commands are planned in every
/// round.
void whole_gear(benchmark::State& state) {
  const Work& w = work();
  for (auto _ : state) {
    const auto motion = std::get<abbe::CuttingMotion>(abbe::plan_cutting(w.machine, w.job, w.wheel, 33, {}));
    const auto cut = std::get<abbe::MachineCut>(abbe::cut_on_machine(w.machine, w.job, w.wheel, motion, {}));
    const std::vector<double> field = abbe::flank_field(w.job.gear, w.wheel, cut.deviations, w.z);
    if (field.size() != 94U * 2 * 200 * 50) state.SkipWithError("points are missing");
    benchmark::DoNotOptimize(field.data());
  }
  state.SetItemsProcessed(state.iterations() * 94 * 2 * 200 * 50);
}

void flank_points(benchmark::State& state) {
  const Work& w = work();
  const auto cut = std::get<abbe::MachineCut>(abbe::cut_on_machine(w.machine, w.job, w.wheel, w.motion, {}));
  for (auto _ : state) {
    const std::vector<double> field = abbe::flank_field(w.job.gear, w.wheel, cut.deviations, w.z);
    benchmark::DoNotOptimize(field.data());
  }
  state.SetItemsProcessed(state.iterations() * 94 * 2 * 200 * 50);
}

void inspect_all_teeth(benchmark::State& state) {
  const Work& w = work();
  const auto cut = std::get<abbe::MachineCut>(abbe::cut_on_machine(w.machine, w.job, w.wheel, w.motion, {}));
  const auto inspection = abbe::GearInspection::make(w.job.gear, w.wheel, {});
  for (auto _ : state) {
    const abbe::GearFigures figures = inspection->figures(cut.deviations);
    benchmark::DoNotOptimize(figures.F_r);
  }
}

/// 10^5 calls of predict: a hundredth of what the whole gear is to be faster than.
void predict_100k(benchmark::State& state) {
  const Work& w = work();
  const abbe::Plan plan = std::get<abbe::Plan>(abbe::make_plan(w.machine, {}));
  abbe::Query query;
  query.tool = abbe::tool_of(w.machine);
  double sum = 0;
  for (auto _ : state)
    for (std::size_t i = 0; i < 100'000; ++i) {
      query.q = w.motion.commands[i % w.motion.commands.size()];
      sum += abbe::predict(plan, query).deviation.position.x();
    }
  benchmark::DoNotOptimize(sum);
}

BENCHMARK(whole_gear)->Unit(benchmark::kMillisecond);
BENCHMARK(flank_points)->Unit(benchmark::kMillisecond);
BENCHMARK(inspect_all_teeth)->Unit(benchmark::kMillisecond);
BENCHMARK(predict_100k)->Unit(benchmark::kMillisecond);

}  // namespace
