// How long does the rewriter alone take, from a program in memory to text in memory?
//   build/release/bench/program_times MACHINE.toml PART.ngc [ROUNDS]    default 3; processor time, best round
#include <algorithm>
#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <span>
#include <string>
#include <variant>
#include <vector>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/file.h"
#include "abbe/machine/read_machine.h"

namespace {

using namespace abbe;

std::string slurp(const char* path) {
  auto read = read_file(path, std::size_t{1} << 32);
  if (auto* text = std::get_if<std::string>(&read)) return std::move(*text);
  std::fprintf(stderr, "program_times: %s\n", std::get<FileError>(read).message.c_str());
  std::exit(2);
}

std::vector<std::string_view> lines_of(std::string_view text) {
  std::vector<std::string_view> lines;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size() - 1) + 1;
    lines.push_back(text.substr(0, end));
    text.remove_prefix(end);
  }
  return lines;
}

/// Bytes written.
std::size_t rewrite(const Plan& plan, const RewriteJob& job, std::span<const std::string_view> lines,
                    RewriteReport& report) {
  constexpr std::size_t kSink = std::size_t{1} << 16;
  Rewriter rewriter(plan, addressed_axes(plan.machine()), job, report);
  std::string out;
  out.reserve(2 * kSink);
  std::size_t bytes = 0;
  for (std::size_t i = 0; i < lines.size(); i += Rewriter::kMostLines) {
    const std::size_t rows = std::min(Rewriter::kMostLines, lines.size() - i);
    rewriter.lines(lines.subspan(i, rows), i + 1, false, out);
    if (out.size() < kSink) continue;
    bytes += out.size();
    out.clear();
  }
  rewriter.finish(out);
  report.diagnostics = rewriter.findings().take();
  return bytes + out.size();
}

}  // namespace

int main(int count, char** arguments) {
  if (count < 3) {
    std::fputs("usage: program_times MACHINE.toml PART.ngc [ROUNDS]\n", stderr);
    return 2;
  }
  const Parsed<Machine> machine =
      read_machine({arguments[1], slurp(arguments[1])}, std::nullopt,
                   [](const std::string&) { return std::optional<std::string>(); });
  if (!machine.value) {
    std::fputs("program_times: the machine file is not valid\n", stderr);
    return 2;
  }
  const Plan plan = std::get<Plan>(make_plan(*machine.value, {}));
  RewriteJob job;
  job.name = arguments[2];
  job.setup.work_offsets[0] = WorkOffset{};
  const std::string text = slurp(arguments[2]);
  const std::vector<std::string_view> lines = lines_of(text);
  double best = 0;
  const int rounds = count > 3 ? std::atoi(arguments[3]) : 3;
  RewriteReport report;
  std::size_t bytes = 0;
  for (int i = 0; i < rounds; ++i) {
    report = {};
    const std::clock_t begin = std::clock();
    bytes = rewrite(plan, job, lines, report);
    const double took = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    best = i == 0 ? took : std::min(best, took);
  }
  for (const Diagnostic& d : report.diagnostics)
    if (d.severity == Severity::error) std::fprintf(stderr, "%s\n", to_text(d).c_str());
  std::printf(
      "%zu lines, %.1f -> %.1f MB: %.3f s, %.0f ns per line, %.2f million lines/s, %.2f %% of motions in "
      "runs\n",
      lines.size(), static_cast<double>(text.size()) / 1e6, static_cast<double>(bytes) / 1e6, best,
      1e9 * best / static_cast<double>(lines.size()), static_cast<double>(lines.size()) / best / 1e6,
      100.0 * static_cast<double>(report.blocks.together) /
          static_cast<double>(std::max<std::uint64_t>(1, report.blocks.motion)));
  return 0;
}
