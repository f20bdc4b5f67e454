#include "abbe/identify/errors_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/core/number.h"
#include "abbe/core/units.h"
#include "abbe/identify/covered.h"

namespace abbe {
namespace {

using Form = ModelTerm::Form;
using Origin = IdentifiedTerm::Origin;

double unit_of(const ErrorName& name) { return name.is_rotation() ? urad : um; }

std::string number(double value) { return to_shortest(value == 0 ? 0.0 : value); }  // no -0

/// Without what could end a remark.
std::string one_line(std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7F) c = ' ';
  return text;
}

std::string in_quotes_of_toml(const std::string& text) {
  std::string out = "\"";
  for (const char c : one_line(text)) {
    if (c == '"' || c == '\\') out += '\\';
    out += c;
  }
  return out + '"';
}

std::string head_of(const ErrorsFileHead& head) {
  std::string out;
  for (const std::string& remark : head.remarks) out += "# " + one_line(remark) + '\n';
  out +=
      "format = 1\n[units]\nlength = \"mm\"\nangle = \"deg\"\nerror_length = \"um\"\nerror_angle = "
      "\"urad\"\n";
  const Calibration& c = head.calibration;
  std::string calibration;
  if (!c.date.empty()) calibration += fmt::format("date = {}\n", c.date);
  if (!c.machine_id.empty()) calibration += fmt::format("machine_id = {}\n", in_quotes_of_toml(c.machine_id));
  if (c.temperature) calibration += fmt::format("temperature = {}\n", number(*c.temperature));
  if (!calibration.empty()) out += "[calibration]\n" + calibration;
  return out;
}

/// All terms of one error, by index.
using Group = std::vector<std::size_t>;

std::vector<Group> groups_of(const Identification& id) {
  std::vector<Group> groups;
  for (std::size_t k = 0; k < id.terms.size(); ++k) {
    if (id.terms[k].origin == Origin::assumed || (id.terms[k].value == 0 && id.terms[k].uncertainty == 0))
      continue;
    const auto same = std::find_if(groups.begin(), groups.end(), [&](const Group& g) {
      return id.terms[g.front()].term.name == id.terms[k].term.name;
    });
    if (same == groups.end()) {
      groups.push_back({k});
    } else {
      same->push_back(k);
    }
  }
  return groups;
}

std::string polynomial_of(const Identification& id, const Group& group, double unit, const Covered& covered) {
  std::vector<double> c;
  for (const std::size_t k : group) {
    const ModelTerm& term = id.terms[k].term;
    if (term.form != Form::power) continue;
    c.resize(std::max(c.size(), static_cast<std::size_t>(term.power) + 1));
    const double value = id.terms[k].value / unit;
    c[static_cast<std::size_t>(term.power)] += value;
    c[0] -= value * term.line[0];
    c[1] -= value * term.line[1];
  }
  if (c.empty()) return {};
  std::string list;
  for (const double x : c) list += (list.empty() ? "" : ", ") + number(x);
  return fmt::format("{{ poly = [{}], domain = [{}, {}] }}", list, number(covered.lo), number(covered.hi));
}

/// The sum of an error's splines, by its values at their nodes.
std::string spline_of(const Identification& id, const Group& group, double unit) {
  const NodalSpline* first = nullptr;
  for (const std::size_t k : group)
    if (first == nullptr) first = id.terms[k].term.spline.get();
  if (first == nullptr) return {};
  std::string list;
  for (const double q : first->nodes()) {
    double value = 0;
    for (const std::size_t k : group)
      if (const auto& spline = id.terms[k].term.spline) value += id.terms[k].value / unit * (*spline)(q);
    list += fmt::format("{}[{}, {}]", list.empty() ? "" : ", ", number(q), number(value));
  }
  return fmt::format("{{ table = [{}], interpolation = \"cubic\" }}", list);
}

std::string value_of(const Machine& machine, const Identification& id, const Group& group,
                     const Covered& covered) {
  const double unit = unit_of(id.terms[group.front()].term.name);
  std::vector<std::string> parts;
  if (std::string poly = polynomial_of(id, group, unit, covered); !poly.empty())
    parts.push_back(std::move(poly));
  if (std::string spline = spline_of(id, group, unit); !spline.empty()) parts.push_back(std::move(spline));
  for (const std::size_t k : group) {
    const ModelTerm& term = id.terms[k].term;
    const double c = id.terms[k].value / unit;
    const std::string axis = machine.axis(term.axis).name;
    switch (term.form) {
      case Form::constant:
        parts.push_back(number(c));
        break;
      case Form::lost_motion:
        parts.push_back(fmt::format("{{ forward = {{ poly = [{}] }}, backward = {{ poly = [{}] }} }}",
                                    number(-c / 2), number(c / 2)));
        break;
      case Form::velocity:
        parts.push_back(fmt::format("{{ poly = [0, {}], of = \"v.{}\" }}", number(c), axis));
        break;
      case Form::acceleration:
        parts.push_back(fmt::format("{{ poly = [0, {}], of = \"a.{}\" }}", number(c), axis));
        break;
      case Form::power:
      case Form::spline:
        break;
    }
  }
  if (parts.size() == 1) return parts.front();
  std::string list;
  for (const std::string& part : parts) list += (list.empty() ? "" : ", ") + part;
  return "[ " + list + " ]";
}

AxisState at_position(int axis, double q) {
  AxisState state;
  state.q[static_cast<std::size_t>(axis)] = q;
  return state;
}

/// Largest sqrt(b^T C b) over the tested positions and rates, in the unit of the file.
double uncertainty_of(const Identification& id, const Group& group, const Covered& covered) {
  constexpr int kSteps = 20;
  const double unit = unit_of(id.terms[group.front()].term.name);
  double largest = 0;
  for (int step = 0; step <= kSteps; ++step) {
    const double part = static_cast<double>(step) / kSteps;
    const auto factor = [&](const ModelTerm& term) {
      switch (term.form) {
        case Form::power:
        case Form::spline:
          return basis(term, at_position(term.axis, covered.lo + part * (covered.hi - covered.lo)));
        case Form::lost_motion:
          return 0.5;
        case Form::velocity:
          return covered.speed;
        case Form::acceleration:
          return covered.acceleration;
        case Form::constant:
          break;
      }
      return 1.0;
    };
    double variance = 0;
    for (const std::size_t a : group)
      for (const std::size_t b : group)
        variance += factor(id.terms[a].term) * factor(id.terms[b].term) *
                    id.covariance(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    largest = std::max(largest, std::sqrt(std::max(0.0, variance)) / unit);
  }
  return largest;
}

std::string remark_of(const Identification& id, const Group& group) {
  bool artefact = false, given = false;
  for (const std::size_t k : group) {
    artefact = artefact || id.terms[k].origin == Origin::artefact;
    given = given || !id.terms[k].identifiable;
  }
  return artefact ? "  # artefact: a share of a sum, see above"
         : given  ? "  # given the assumptions above"
                  : "";
}

const Covered& of_axis(const Identification& id, const Group& group, const std::vector<Covered>& covered) {
  return covered[static_cast<std::size_t>(id.terms[group.front()].term.axis)];
}

/// Name of a coefficient's error: E or D, direction, axis.
std::string error_of(const PaperCoefficient& c) {
  return to_string(ErrorName{c.dynamic ? ErrorClass::dynamic : ErrorClass::component, c.direction,
                             std::string(1, axis_letter(c.axis))});
}

}  // namespace

std::string errors_file_of(const Machine& machine, const Identification& identification,
                           const std::vector<BallbarTest>& tests, const ErrorsFileHead& head) {
  ErrorsFileHead full = head;
  if (!identification.trusted)
    full.remarks.push_back("DOUBTFUL: the residuals do not look like the stated noise:");
  for (const std::string& doubt : identification.doubts) full.remarks.push_back("  " + doubt);
  if (!identification.assumptions.empty())
    full.remarks.push_back("Not seen by these tests and taken for zero:");
  for (const std::string& zero : identification.assumptions) full.remarks.push_back("  " + zero);
  for (const UnseenCombination& c : identification.unseen)
    if (c.parts.size() > 1) full.remarks.push_back("seen only together: " + c.words);

  std::string out = head_of(full);
  const std::vector<Covered> covered = covered_by(machine, tests);
  const std::vector<Group> groups = groups_of(identification);
  out += "[errors]\n";
  for (const Group& group : groups)
    out += fmt::format("{} = {}{}\n", to_string(identification.terms[group.front()].term.name),
                       value_of(machine, identification, group, of_axis(identification, group, covered)),
                       remark_of(identification, group));
  out += "[uncertainty]\n";
  for (const Group& group : groups)
    out +=
        fmt::format("{} = {}\n", to_string(identification.terms[group.front()].term.name),
                    number(uncertainty_of(identification, group, of_axis(identification, group, covered))));
  return out;
}

std::string errors_file_of(const PaperResult& result, const std::vector<PaperTest>& tests,
                           const std::vector<BallbarTest>& circles, const ErrorsFileHead& head) {
  std::string out = head_of(head) + "[errors]\n";
  for (std::size_t i = 0; i + 1 < result.coefficients.size(); i += 2) {
    const PaperCoefficient &a = result.coefficients[i], &b = result.coefficients[i + 1];
    if (a.origin == PaperCoefficient::Origin::missing || a.test < 0) continue;
    const auto t = static_cast<std::size_t>(a.test);
    const double unit = a.direction < 3 ? um : urad;
    const std::size_t k = a.axis == tests[t].plane.second ? 1 : 0;
    std::string value;
    if (a.dynamic) {
      const auto sine = [&](const PaperCoefficient& c, const PaperSine& s) {
        return fmt::format("{{ sine = [{}, {}, {}], of = \"t\", scope = \"test\" }}", number(c.value / unit),
                           number(s.omega), number(s.phase));
      };
      value = fmt::format("[ {}, {} ]", sine(a, tests[t].velocity[k]), sine(b, tests[t].acceleration[k]));
    } else {
      // The displacement counts from the start point of the test.
      const double start =
          circles[t].centre[a.axis] + (a.axis == tests[t].plane.first ? tests[t].radius : 0.0);
      value = fmt::format("{{ poly = [{}{}, {}], reference = {} }}", a.order == 0 ? "" : "0, ",
                          number(a.value / unit), number(b.value / unit), number(start));
    }
    using PaperOrigin = PaperCoefficient::Origin;
    const char* remark = a.origin == PaperOrigin::assumed ? "  # assumed"
                         : a.origin == PaperOrigin::artefact || b.origin == PaperOrigin::artefact
                             ? "  # artefact"
                             : "";
    out += fmt::format("{} = {}{}\n", error_of(a), value, remark);
  }
  return out;
}

}  // namespace abbe
