// Where the balls of a [[ball]] entry lie that is still to be measured.

#include <fmt/format.h>

#include <utility>
#include <variant>

#include "abbe/fit/ball_plan.h"
#include "abbe/fit/job_reader.h"
#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

constexpr std::size_t kMostPoses = 10'000;

std::vector<double> angles_of(const TomlNode& list, double unit, const std::string& axis,
                              Findings& findings) {
  std::vector<double> out;
  if (!expect_kind(list, TomlNode::Kind::array, axis, findings)) return out;
  for (const TomlNode& item : list.items)
    if (const auto angle = read_quantity(item, unit, axis, findings)) out.push_back(*angle);
  return out;
}

}  // namespace

void JobReader::plan_ball_entry(const TomlNode& entry, FitPoints points) {
  const TomlEntry *places = entry.find("places"), *angles = entry.find("angles");
  if (places == nullptr || angles == nullptr) {
    findings_.error("E-MISSING-KEY", entry.mark, "places and angles are needed to plan",
                    "where do the balls lie, and how do the rotary axes stand?",
                    "places = [[100, 0, 50], [0, 100, 150]] and angles = { C = [0, 90, 180, 270] }");
    return;
  }
  if (!plan_file(entry, points.file) ||
      !expect_kind(places->value, TomlNode::Kind::array, "places", findings_) ||
      !expect_kind(angles->value, TomlNode::Kind::table, "angles", findings_))
    return;
  BallPlan plan;
  for (const TomlNode& item : places->value.items)
    if (const auto place = read_vector(item, units_.length, "places", findings_))
      plan.places.push_back(*place);
  std::size_t poses = plan.places.size();
  for (const TomlEntry& item : angles->value.entries) {
    const int axis = job_.machine.find_axis(item.key);
    if (axis < 0 || job_.machine.axis(axis).type != AxisType::rotary) {
      findings_.error("E-JOB-AXIS", item.mark, in_quotes(item.key) + " is no rotary axis of the machine", "",
                      "name those of the chain: " + job_.machine.chain);
      return;
    }
    auto& list = plan.angles[static_cast<std::size_t>(axis)];
    list = angles_of(item.value, units_.angle, item.key, findings_);
    poses *= std::max<std::size_t>(list.size(), 1);
  }
  if (poses == 0 || poses > kMostPoses) {
    findings_.error("E-JOB-VALUE", entry.mark, fmt::format("{} poses of balls", poses), "",
                    "write 1 to 10000");
    return;
  }
  auto planned = plan_balls(job_.machine, plan);
  if (const auto* why = std::get_if<std::string>(&planned)) {
    findings_.error("E-JOB-BALL", entry.mark, "a ball cannot be reached: " + *why, "",
                    "move it, or turn less");
    return;
  }
  auto& found = std::get<FitPoints>(planned);
  found.file = points.file;
  found.instrument = points.instrument;
  found.nest_on_work = points.nest_on_work;
  job_.points.push_back(std::move(found));
}

}  // namespace abbe
