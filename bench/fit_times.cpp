// fit_times points | files
//
// points: 100 000 points of a volume, 100 unknowns, by fit_jointly; beside it Eigen's complete orthogonal
//         decomposition of a dense matrix of as many rows and columns. Prints seconds of processor time, the
//         ratio, and the memory that the fit took above what the job holds (peak resident, kB).
// files:  50 runs, 21 functions: reading the files, choosing forms, fitting, writing. Seconds of processor
// time.
#include <sys/resource.h>

#include <Eigen/QR>
#include <cstdio>
#include <cstring>
#include <ctime>
#include <map>
#include <string>

#include "abbe/core/units.h"
#include "abbe/fit/errors_file.h"
#include "abbe/fit/fit_job.h"
#include "abbe/fit/joint_fit.h"
#include "abbe/fit/observations.h"
#include "abbe/fit/unknowns.h"
#include "abbe/machine/read_machine.h"
#include "abbe/simulate/measurements.h"

namespace {

constexpr const char* kMachine =
    "format = 1\n[machine]\nname = \"m\"\nchain = \"w X b Y Z t\"\n[axis.X]\nrange = [0, 500]\nerrors_seen = "
    "\"tool\"\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [-300, 0]\n[tool]\norigin = [0, 0, 500]\nlength "
    "= 150\n";
constexpr const char* kErrors =
    "EXX = { poly = [0, 0.03, -4e-5] }\nEBX = { poly = [0, -0.03, 4e-5] }\nEC0Y = 28\n";

double seconds() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

long peak_kb() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage.ru_maxrss;
}

using Files = std::map<std::string, std::string>;

abbe::FileFetcher fetch_from(const Files& files) {
  return [&files](const std::string& path) -> std::optional<std::string> {
    const auto found = files.find(path);
    return found == files.end() ? std::nullopt : std::optional(found->second);
  };
}

/// Reads, fits, writes; the number of unknowns.
std::size_t fit(const abbe::FitJob& job) {
  const auto observations = abbe::observations_of(job);
  const auto unknowns = abbe::unknowns_of(job, *observations.value);
  const abbe::FitResult result = abbe::fit_jointly(job, *observations.value, *unknowns.value);
  return abbe::write_errors_file(job, result).empty() ? 0 : result.unknowns;
}

/// 18 functions of five or six parameters each, by points in a fixed frame.
int time_points() {
  constexpr int kSide = 46, kSides[] = {kSide, kSide, 48};  // 101 568 points
  std::string job = "format = 1\nmachine = \"m.toml\"\n[functions]\n";
  for (const char* name : {"EXX", "EYX", "EZX", "EAX", "EBX", "ECX", "EXY", "EYY", "EZY", "EAY", "EBY", "ECY",
                           "EXZ", "EYZ", "EZZ", "EAZ", "EBZ"})
    job += std::string(name) + " = { form = \"polynomial\", order = 6 }\n";
  job += "[[points]]\nfile = \"p.csv\"\nframe = \"fixed\"\nnoise = 1\n";
  std::string csv = "X [mm],Y [mm],Z [mm],x [mm],y [mm],z [mm]\n";
  for (int i = 0; i < kSides[0]; ++i)
    for (int j = 0; j < kSides[1]; ++j)
      for (int k = 0; k < kSides[2]; ++k) {
        const double x = 500.0 * i / (kSide - 1), y = 400.0 * j / (kSide - 1), z = -300.0 * k / 47;
        char row[160];
        std::snprintf(row, sizeof row, "%.17g,%.17g,%.17g,%.17g,%.17g,%.17g\n", x, y, z, x + 3e-5 * x,
                      y - 1e-8 * y * y, 350 + z + 2e-5 * x);
        csv += row;
      }
  Files files = {{"m.toml", kMachine}, {"p.csv", std::move(csv)}};
  const auto read = abbe::read_fit_job({"job.toml", job}, fetch_from(files));
  if (!read.value) return std::fprintf(stderr, "%s\n", abbe::to_text(read.diagnostics.front()).c_str()), 1;
  files.clear();
  const long before = peak_kb();
  double begin = seconds();
  const std::size_t unknowns = fit(*read.value);
  const double ours = seconds() - begin;
  const long memory = peak_kb() - before;
  const auto rows = static_cast<Eigen::Index>(3 * read.value->points.front().poses.size());
  const Eigen::MatrixXd dense = Eigen::MatrixXd::Random(rows, static_cast<Eigen::Index>(unknowns));
  const Eigen::VectorXd values = Eigen::VectorXd::Random(rows);
  begin = seconds();
  const double sum = dense.completeOrthogonalDecomposition().solve(values).sum();
  const double eigen = seconds() - begin;
  std::printf("rows %ld unknowns %zu: fit %.2f s, %ld kB more; Eigen %.2f s (%.3g): %.2f times\n",
              static_cast<long>(rows), unknowns, ours, memory, eigen, sum, eigen / ours);
  return 0;
}

int time_files() {
  std::string job =
      "format = 1\nmachine = \"m.toml\"\n[[square]]\nname = \"xy\"\nu = 0.3\n[[square]]\nname = \"zx\"\nu = "
      "0.3\n[[square]]\nname = \"yz\"\nu = 0.3\n";
  int count = 0;
  for (int pass = 0; pass < 3; ++pass)
    for (const char axis : {'X', 'Y', 'Z'})
      for (const char direction : {'X', 'Y', 'Z', 'A', 'B', 'C'}) {
        if (count == 50) break;
        job += "[[run]]\nfile = \"" + std::to_string(count++) + ".csv\"\nerror = \"E" + direction + axis +
               "\"\nnoise = 1\n";
        const std::string pair = std::string{std::min(axis, direction), std::max(axis, direction)};
        if (direction < 'X' || direction == axis) continue;
        job += std::string("square = \"") + (pair == "XY" ? "xy" : pair == "XZ" ? "zx" : "yz") + "\"\n";
      }
  Files files = {{"m.toml", kMachine}};
  const auto planned = abbe::plan_fit_job({"job.toml", job}, fetch_from(files), {21, 5, true});
  if (!planned.value)
    return std::fprintf(stderr, "%s\n", abbe::to_text(planned.diagnostics.front()).c_str()), 1;
  const auto hidden =
      abbe::read_machine({"m.toml", std::string(kMachine) + "[errors]\n" + kErrors}, std::nullopt, {});
  const auto observations = abbe::observations_of(*planned.value);
  for (const abbe::SimulatedFile& file :
       abbe::simulate_measurements(*planned.value, *observations.value, *hidden.value, {}, 1))
    files[file.path] = file.text;
  double best = 1e9;
  std::size_t unknowns = 0;
  for (int round = 0; round < 5; ++round) {
    const double begin = seconds();
    const auto read = abbe::read_fit_job({"job.toml", job}, fetch_from(files));
    unknowns = fit(*read.value);
    best = std::min(best, seconds() - begin);
  }
  std::printf("%d files, %zu unknowns: %.3f s\n", count, unknowns, best);
  return 0;
}

}  // namespace

int main(int count, char** words) {
  if (count == 2 && std::strcmp(words[1], "points") == 0) return time_points();
  if (count == 2 && std::strcmp(words[1], "files") == 0) return time_files();
  std::fprintf(stderr, "usage: fit_times points | files\n");
  return 2;
}
