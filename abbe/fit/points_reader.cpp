// Entries [[points]] and [[ball]] of a job (balls that are only planned: ball_reader.cpp).

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "abbe/fit/choose_form.h"
#include "abbe/fit/job_reader.h"
#include "abbe/machine/toml_values.h"

namespace abbe {

/// A grid over the travels of all axes, not more than kMost points to each.
void JobReader::plan_points(const TomlNode& entry, FitPoints points) {
  constexpr int kMost = 7;
  if (!plan_file(entry, points.file)) return;
  points.planned = true;
  points.poses = {{}};
  for (int i = 0; i < job_.machine.axis_count(); ++i) {
    const auto& range = job_.machine.axis(i).range;
    if (!range || job_.machine.axis_count() > 3) {
      findings_.error("E-JOB-RANGE", entry.mark, "a grid needs three axes with known travels at most", "",
                      "state range in the machine file");
      return;
    }
    const auto nodes =
        even_nodes((*range)[0], (*range)[1], static_cast<std::size_t>(std::min(plan_->targets, kMost)));
    std::vector<Pose> finer;
    for (const Pose& pose : points.poses)
      for (const double node : nodes) {
        finer.push_back(pose);
        finer.back()[static_cast<std::size_t>(i)] = node;
      }
    points.poses = std::move(finer);
  }
  points.measured.assign(points.poses.size(), Vec3::Zero());
  job_.points.push_back(std::move(points));
}

void JobReader::take_points(const TomlNode& entry, const MeasuredTable& table, bool balls, FitPoints points) {
  const auto column = [&](const std::string& name, Quantity quantity) -> const MeasuredColumn* {
    const MeasuredColumn* found = table.find(name);
    if (found != nullptr && found->quantity == quantity) return found;
    findings_.error("E-JOB-KIND", entry.mark,
                    fmt::format("{} has no column '{}'{}", in_quotes(points.file), name,
                                quantity == Quantity::length  ? " in a unit of length"
                                : quantity == Quantity::angle ? " in a unit of angle"
                                                              : ""),
                    "every row is a pose of all axes and what was measured there",
                    balls ? "X [mm], Y [mm], .., ball" : "X [mm], Y [mm], .., x [mm], y [mm], z [mm]");
    return nullptr;
  };
  std::vector<const MeasuredColumn*> axes, measured;
  for (int i = 0; i < job_.machine.axis_count(); ++i) {
    const Body& axis = job_.machine.axis(i);
    axes.push_back(column(axis.name, axis.type == AxisType::rotary ? Quantity::angle : Quantity::length));
  }
  const bool reads = !balls || table.find("x") != nullptr;
  for (const char* name : {"x", "y", "z"})
    if (reads) measured.push_back(column(name, Quantity::length));
  const MeasuredColumn* number = balls ? column("ball", Quantity::number) : nullptr;
  if (std::count(axes.begin(), axes.end(), nullptr) + std::count(measured.begin(), measured.end(), nullptr) >
          0 ||
      (balls && number == nullptr))
    return;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    Pose& pose = points.poses.emplace_back();
    for (std::size_t k = 0; k < axes.size(); ++k) pose[k] = axes[k]->values[i];
    if (balls) points.ball.push_back(static_cast<int>(std::clamp(number->values[i], -1e6, 1e6)));
    if (reads)
      (balls ? points.readings : points.measured)
          .emplace_back(measured[0]->values[i], measured[1]->values[i], measured[2]->values[i]);
  }
  job_.points.push_back(std::move(points));
}

void JobReader::read_points(const TomlNode& entry, bool balls) {
  refuse_other_keys(entry,
                    balls ? std::vector<std::string>{"file", "noise", "sign", "nest", "places", "angles"}
                          : instrument_keys_and({"frame"}),
                    balls ? "[[ball]]" : "[[points]]", findings_);
  FitPoints points;
  const auto instrument = instrument_of(entry, false);
  if (const TomlEntry* found = entry.find("frame"))
    points.fixed = read_choice(found->value, {"free", "fixed"}, "frame", findings_).value_or(0) == 1;
  if (!instrument) return;
  points.instrument = *instrument;
  if (plan_ && !balls) return plan_points(entry, std::move(points));
  if (const TomlEntry* found = entry.find("nest"))
    points.nest_on_work = read_choice(found->value, {"tool", "work"}, "nest", findings_).value_or(0) == 1;
  if (plan_) return plan_ball_entry(entry, std::move(points));
  const std::optional<std::string> bytes = fetch(entry, points.file);
  if (!bytes) return;
  const Parsed<MeasuredTable> table = read_measured_table(points.file, *bytes);
  out_.insert(out_.end(), table.diagnostics.begin(), table.diagnostics.end());
  if (table.value) take_points(entry, *table.value, balls, std::move(points));
}

}  // namespace abbe
