#include "abbe/fit/state_grids.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>

#include "abbe/fit/choose_form.h"
#include "abbe/fit/function_model.h"

namespace abbe {
namespace {

constexpr std::size_t kNodes = 33;

std::string joined(const std::vector<double>& values) {
  std::string text;
  for (const double value : values) text += (text.empty() ? "" : ", ") + file_number(value);
  return "[" + text + "]";
}

double value_at(const FoundFunction& found, double v) { return found.unknown.mean.row(v).dot(found.mean); }

/// The same function in every state; empty if some state lacks it.
std::vector<const FoundFunction*> in_all(const std::vector<ThermalState>& states, const std::string& name) {
  std::vector<const FoundFunction*> out;
  for (const ThermalState& state : states)
    for (const FoundFunction& found : state.result.functions)
      if (found.unknown.name == name) out.push_back(&found);
  if (out.size() != states.size()) out.clear();
  return out;
}

double reversal_at(const FoundFunction& found, double v) {
  return found.reversal.size() == 0 ? 0 : found.unknown.reversal->row(v).dot(found.reversal);
}

/// Most that a function bends away from the straight lines between the nodes, looked at in their middles.
template <class Function>
double largest_bend(const Function& f, const std::vector<double>& nodes) {
  double most = 0;
  for (std::size_t i = 0; i + 1 < nodes.size(); ++i) {
    const double line = (f(nodes[i]) + f(nodes[i + 1])) / 2;
    most = std::max(most, std::abs(f((nodes[i] + nodes[i + 1]) / 2) - line));
  }
  return most;
}

/// Half of the mean reversal of all states, by the sign of the approach: a number, or a table over the nodes.
std::string half_reversal(const std::vector<const FoundFunction*>& found, const std::vector<double>& nodes,
                          int approach) {
  const auto half = [&](double v) {
    double sum = 0;
    for (const FoundFunction* f : found) sum += reversal_at(*f, v);
    return file_number(approach * sum / (2 * static_cast<double>(found.size())));
  };
  if (std::all_of(found.begin(), found.end(), [](const FoundFunction* f) { return f->reversal.size() == 1; }))
    return half(nodes.front());
  std::string samples;
  for (const double v : nodes)
    samples += fmt::format("{}[{}, {}]", samples.empty() ? "" : ", ", file_number(v), half(v));
  return "{ table = [" + samples + "] }";
}

/// What follows the grid in a list: empty if no state has a reversal, nullopt if only some have.
std::optional<std::string> reversal_text(const std::vector<const FoundFunction*>& found,
                                         const std::vector<double>& nodes) {
  const auto with = std::count_if(found.begin(), found.end(),
                                  [](const FoundFunction* f) { return f->reversal.size() > 0; });
  if (with == 0) return std::string();
  if (with != static_cast<std::ptrdiff_t>(found.size())) return std::nullopt;
  return fmt::format(", {{ forward = {}, backward = {} }}", half_reversal(found, nodes, +1),
                     half_reversal(found, nodes, -1));
}

/// Writes one errors file.
class Grids {
 public:
  Grids(const FitJob& job, const std::string& sensor, const std::vector<ThermalState>& states)
      : job_(job), sensor_(sensor), states_(states) {
    for (const ThermalState& state : states) temperatures_.push_back(state.temperature);
  }

  StateGrids write() {
    const FitResult& first = states_.front().result;
    for (const FoundFunction& found : first.functions)
      if (!add_function(found.unknown.name)) return {{}, obstacle_};
    for (const FoundValue& value : first.locations)
      if (!add_location(value.name)) return {{}, obstacle_};
    for (const ThermalState& state : states_)
      if (state.result.functions.size() != first.functions.size() ||
          state.result.locations.size() != first.locations.size())
        return {{}, "the states were not measured alike: some found more errors than the first"};
    return {
        fmt::format(
            "# Written by abbe fit: errors of {} in {} thermal states, by {}.\n# Between their positions the "
            "functions bend by {:.2g} (um, urad) at most.\nformat = 1\n\n[units]\nlength = \"mm\"\nangle = "
            "\"deg\"\nerror_length = \"um\"\nerror_angle = \"urad\"\n\n[errors]\n{}\n[uncertainty]\n{}",
            job_.machine.name, states_.size(), sensor_, bend_, errors_, uncertainties_),
        {}};
  }

 private:
  bool add_function(const std::string& name) {
    const auto found = in_all(states_, name);
    if (found.empty()) return refuse(name + " was not found in every state");
    double lo = found.front()->unknown.mean.lo(), hi = found.front()->unknown.mean.hi(), u = 0;
    for (const FoundFunction* f : found) {
      lo = std::max(lo, f->unknown.mean.lo());
      hi = std::min(hi, f->unknown.mean.hi());
      u = std::max(u, f->u);
    }
    if (!(lo < hi)) return refuse(name + " was not measured over a common travel");
    const std::vector<double> nodes = even_nodes(lo, hi, kNodes);
    std::string rows;
    for (const double v : nodes) {
      std::vector<double> row;
      for (const FoundFunction* f : found) row.push_back(value_at(*f, v));
      rows += (rows.empty() ? "" : ", ") + joined(row);
    }
    for (const FoundFunction* f : found)
      bend_ = std::max({bend_, largest_bend([&](double v) { return value_at(*f, v); }, nodes),
                        largest_bend([&](double v) { return reversal_at(*f, v) / 2; }, nodes)});
    const std::string grid =
        fmt::format("{{ grid = [{}], at = [{}, {}], of = [\"{}\", \"{}\"] }}", rows, joined(nodes),
                    joined(temperatures_), job_.machine.axis(found.front()->unknown.axis).name, sensor_);
    const auto reversal = reversal_text(found, nodes);
    if (!reversal) return refuse("the reversal of " + name + " was not found in every state");
    errors_ += fmt::format("{} = {}\n", name, reversal->empty() ? grid : "[" + grid + *reversal + "]");
    uncertainties_ += fmt::format("{} = {}\n", name, file_number(u));
    return true;
  }

  bool add_location(const std::string& name) {
    std::string samples;
    double u = 0;
    for (const ThermalState& state : states_) {
      const auto& list = state.result.locations;
      const auto found =
          std::find_if(list.begin(), list.end(), [&](const FoundValue& v) { return v.name == name; });
      if (found == list.end()) return refuse(name + " was not found in every state");
      samples += fmt::format("{}[{}, {}]", samples.empty() ? "" : ", ", file_number(state.temperature),
                             file_number(found->value));
      u = std::max(u, found->u);
    }
    errors_ += fmt::format("{} = {{ table = [{}], of = \"{}\" }}\n", name, samples, sensor_);
    uncertainties_ += fmt::format("{} = {}\n", name, file_number(u));
    return true;
  }

  bool refuse(std::string why) {
    obstacle_ = std::move(why);
    return false;
  }

  const FitJob& job_;
  const std::string& sensor_;
  const std::vector<ThermalState>& states_;
  std::vector<double> temperatures_;
  std::string errors_, uncertainties_, obstacle_;
  double bend_ = 0;
};

}  // namespace

StateGrids write_state_grids(const FitJob& job, const std::string& sensor,
                             const std::vector<ThermalState>& states) {
  return Grids(job, sensor, states).write();
}

}  // namespace abbe
