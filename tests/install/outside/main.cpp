// A user's program: reads a machine, asks for the deviation of the tool at X = 10 mm.
#include <abbe/chain/plan.h>
#include <abbe/chain/predict.h>
#include <abbe/machine/read_machine.h>

#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <variant>

int main() {
  const abbe::MachineText text{"mill.toml", R"(
format = 1
[machine]
name = "mill"
chain = "w Y b X Z t"
[errors]
EXX = { poly = [0, 0.2] }
)"};
  const auto no_files = [](const std::string&) { return std::optional<std::string>{}; };
  const auto machine = abbe::read_machine(text, std::nullopt, no_files);
  for (const auto& diagnostic : machine.diagnostics) std::fputs(abbe::to_text(diagnostic).c_str(), stderr);
  if (!machine.value) return 1;

  const auto plan = abbe::make_plan(*machine.value, {});
  if (!std::holds_alternative<abbe::Plan>(plan)) return 1;
  abbe::Query query;
  query.tool = abbe::tool_of(*machine.value);
  query.q[static_cast<std::size_t>(machine.value->find_axis("X"))] = 10 * abbe::mm;
  const auto deviation = abbe::predict(std::get<abbe::Plan>(plan), query).deviation.position;

  // EXX = 0.2 um/mm * 10 mm: 2 um farther along +X than commanded
  std::printf("deviation %.6f %.6f %.6f mm\n", deviation.x(), deviation.y(), deviation.z());
  const bool as_expected = std::abs(deviation.x() - 2 * abbe::um) < 1e-12 &&
                           std::abs(deviation.y()) < 1e-12 && std::abs(deviation.z()) < 1e-12;
  return as_expected ? 0 : 1;
}
