#include "abbe/fit/unknowns.h"

#include <fmt/format.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <set>

#include "abbe/core/units.h"
#include "abbe/evaluate/text_findings.h"
#include "abbe/fit/choose_form.h"

namespace abbe {
namespace {

constexpr double kAligned = 1e-9;

double position_unit(const Machine& machine, int axis) {
  return machine.axis(axis).type == AxisType::rotary ? deg : mm;
}

bool is_straightness(const Machine& machine, const ErrorName& name, int axis) {
  const Body& body = machine.axis(axis);
  return body.type == AxisType::linear && !name.is_rotation() &&
         std::abs(std::abs(body.direction[name.direction]) - 1) > kAligned;
}

/// Mean deviations at the targets of the run of this error with most targets, numbers of the file.
std::vector<CoursePoint> course_of(const FitRun& run, double position, double error) {
  std::vector<CoursePoint> course;
  for (Eigen::Index i = 0; i < run.runs.target_count(); ++i) {
    double sum = 0, count = 0;
    for (const Eigen::MatrixXd* values : {&run.runs.forward, &run.runs.backward}) {
      if (values->cols() == 0) continue;
      sum += values->row(i).mean();
      ++count;
    }
    course.push_back({run.runs.targets[static_cast<std::size_t>(i)] / position,
                      run.instrument.sign * sum / count / error});
  }
  return course;
}

class Chooser {
 public:
  Chooser(const FitJob& job, const Observations& observations)
      : job_(job), observations_(observations), findings_(job.file) {}

  Parsed<Unknowns> choose() {
    std::set<std::string> known;
    for (const FitRun& run : job_.runs)
      if (known.insert(run.name).second) add_measured(run.name);
    for (const FitFunction& function : job_.functions)
      if (known.insert(function.name).second) add_declared(function);
    refuse_without_sign();
    out_.locations_asked = !job_.locations.empty();
    out_.locations = out_.locations_asked ? job_.locations : likely_locations();
    for (const FitValue& value : job_.values)
      if (std::find(out_.locations.begin(), out_.locations.end(), value.name) == out_.locations.end())
        out_.locations.push_back(value.name);
    Parsed<Unknowns> parsed;
    if (!findings_.failed()) parsed.value = std::move(out_);
    parsed.diagnostics = findings_.take();
    return parsed;
  }

 private:
  /// Once per axis: whoever states errors_seen afterwards may turn the sign of what was found.
  void refuse_without_sign() {
    std::set<int> told;
    for (const UnknownFunction& function : out_.functions) {
      const Body& body = job_.machine.axis(function.axis);
      if (!body.errors_have_no_sign() || !told.insert(function.axis).second) continue;
      findings_.error(
          "E-ERRORS-SEEN", 0,
          fmt::format("{} is to be found, and the machine file has no errors_seen for axis {}, which carries "
                      "the workpiece",
                      function.name, body.name),
          "an error of the table itself and the error of the tool seen from the work have opposite signs",
          fmt::format("add errors_seen = \"body\" or \"tool\" to [axis.{}]; the errors are written as it "
                      "says",
                      body.name));
    }
  }

  FunctionGauge gauge_of(const ErrorName& name, int axis) const {
    const double reference =
        job_.reference[static_cast<std::size_t>(axis)] / position_unit(job_.machine, axis);
    return {reference, is_straightness(job_.machine, name, axis)};
  }

  UnknownFunction blank(const std::string& text) const {
    const ErrorName name = *read_error_name(text);
    UnknownFunction out;
    out.name = text;
    out.axis = job_.machine.find_axis(name.axis);
    out.rotation = name.is_rotation();
    out.position_unit = position_unit(job_.machine, out.axis);
    out.error_unit = out.rotation ? urad : um;
    return out;
  }

  FunctionForm form_of(const FitFunction& wanted, const FunctionGauge& gauge,
                       const std::vector<CoursePoint>& course) {
    using Form = FitFunction::Form;
    FunctionForm form;
    const double lo = course.front().position, hi = course.back().position;
    if (wanted.form == Form::automatic) {
      form = choose_form(gauge, course, job_.most_order);
    } else if (wanted.form == Form::polynomial) {
      form.order = wanted.order;
    } else {
      form.kind = wanted.form == Form::table ? FunctionForm::Kind::table : FunctionForm::Kind::cubic;
      if (wanted.count > 1) {
        form.nodes = even_nodes(lo, hi, static_cast<std::size_t>(wanted.count));
      } else {
        for (const CoursePoint& point : course) form.nodes.push_back(point.position);
      }
    }
    if (wanted.pitch > 0) {
      form.pitch = wanted.pitch;
      form.harmonics = wanted.harmonics;
    }
    return form;
  }

  void add_measured(const std::string& text) {
    UnknownFunction function = blank(text);
    const FitFunction* declared = job_.find_function(text);
    const FitFunction wanted = declared != nullptr ? *declared : FitFunction{};
    const FitRun* longest = nullptr;
    double lo = 0, hi = 0;
    bool bidirectional = false;
    for (const FitRun& run : job_.runs) {
      if (run.name != text) continue;
      lo = longest == nullptr ? run.runs.targets.front() : std::min(lo, run.runs.targets.front());
      hi = longest == nullptr ? run.runs.targets.back() : std::max(hi, run.runs.targets.back());
      if (longest == nullptr || run.runs.targets.size() > longest->runs.targets.size()) longest = &run;
      bidirectional = bidirectional || run.runs.bidirectional();
    }
    const std::vector<CoursePoint> course = course_of(*longest, function.position_unit, function.error_unit);
    const FunctionGauge gauge = gauge_of(longest->error, function.axis);
    FunctionForm form = form_of(wanted, gauge, course);
    stretch(form, lo / function.position_unit, hi / function.position_unit);
    function.mean = FunctionModel(form, gauge, lo / function.position_unit, hi / function.position_unit);
    // Every run also has a free zero, straightness a free slope: they take the place of what the gauge fixed.
    const Eigen::Index free = function.mean.parameters() + (gauge.without_trend ? 2 : 1);
    if (free > static_cast<Eigen::Index>(course.size()))
      findings_.error(
          "E-JOB-FORM", 0,
          fmt::format("{}: {} has more unknowns than there are targets", text, function.mean.describe()),
          "it would pass between the targets as it likes", "a lower order, fewer values, or more targets");
    if (bidirectional && wanted.reversal != FitFunction::Reversal::none)
      function.reversal = reversal_model(wanted.reversal, course, function);
    out_.functions.push_back(std::move(function));
  }

  /// Nodes chosen over one run are laid over the whole range of all.
  static void stretch(FunctionForm& form, double lo, double hi) {
    if (form.nodes.empty()) return;
    if (form.nodes.front() > lo) form.nodes.front() = lo;
    if (form.nodes.back() < hi) form.nodes.back() = hi;
  }

  static FunctionModel reversal_model(FitFunction::Reversal kind, const std::vector<CoursePoint>& course,
                                      const UnknownFunction& function) {
    FunctionForm form;
    form.order = 0;
    if (kind == FitFunction::Reversal::table) {
      form.kind = FunctionForm::Kind::table;
      for (const CoursePoint& point : course) form.nodes.push_back(point.position);
      stretch(form, function.mean.lo(), function.mean.hi());
    }
    return {form, {}, function.mean.lo(), function.mean.hi()};
  }

  /// A function without runs of its own, seen by diagonals, points or balls.
  void add_declared(const FitFunction& wanted) {
    UnknownFunction function = blank(wanted.name);
    double lo = 0, hi = 0;
    for (std::size_t i = 0; i < observations_.poses.size(); ++i) {
      const double q =
          observations_.poses[i].q[static_cast<std::size_t>(function.axis)] / function.position_unit;
      lo = i == 0 ? q : std::min(lo, q);
      hi = i == 0 ? q : std::max(hi, q);
    }
    if (wanted.form == FitFunction::Form::automatic || !(lo < hi) ||
        (wanted.form != FitFunction::Form::polynomial && wanted.count < 2)) {
      findings_.error("E-JOB-FORM", 0,
                      fmt::format("{} has no runs, and {}", wanted.name,
                                  lo < hi ? "its form leaves something open" : "nothing moves its axis"),
                      "a form is chosen by cross-validation over runs only",
                      "form = \"polynomial\" and order, or \"cubic\" and count; or measure runs");
      return;
    }
    const FunctionGauge gauge = gauge_of(*read_error_name(wanted.name), function.axis);
    function.mean = FunctionModel(form_of(wanted, gauge, {{lo, 0}, {hi, 0}}), gauge, lo, hi);
    out_.functions.push_back(std::move(function));
  }

  /// Location errors of an axis: rotations, and for rotary axes displacements, perpendicular to it.
  void add_perpendicular(int axis, std::vector<std::string>& names) const {
    const Body& body = job_.machine.axis(axis);
    for (int direction = body.type == AxisType::rotary ? 0 : 3; direction < 6; ++direction)
      if (std::abs(std::abs(body.direction[direction % 3]) - 1) > kAligned)
        names.push_back(to_string(ErrorName{ErrorClass::location, direction, body.name}));
  }

  [[nodiscard]] std::vector<std::string> likely_locations() const {
    std::vector<int> linear, rotary;
    for (int i = 0; i < job_.machine.axis_count(); ++i)
      (job_.machine.axis(i).type == AxisType::rotary ? rotary : linear).push_back(i);
    const auto dominant = [&](int axis) {
      Eigen::Index at = 0;
      job_.machine.axis(axis).direction.cwiseAbs().maxCoeff(&at);
      return at;
    };
    std::stable_sort(linear.begin(), linear.end(), [&](int a, int b) { return dominant(a) < dominant(b); });
    std::vector<std::string> names;
    for (std::size_t k = 1; k < linear.size(); ++k) {
      if (k > 1) {
        add_perpendicular(linear[k], names);
        continue;
      }
      // Of the second axis the rotation about the normal of its plane with the first one.
      const Vec3 normal =
          job_.machine.axis(linear[0]).direction.cross(job_.machine.axis(linear[1]).direction);
      Eigen::Index about = 0;
      normal.cwiseAbs().maxCoeff(&about);
      names.push_back(to_string(
          ErrorName{ErrorClass::location, 3 + static_cast<int>(about), job_.machine.axis(linear[1]).name}));
    }
    for (const int axis : rotary) add_perpendicular(axis, names);
    const std::vector<std::string> carried = error_inventory(job_.machine);
    names.erase(std::remove_if(names.begin(), names.end(),
                               [&](const std::string& name) {
                                 return std::find(carried.begin(), carried.end(), name) == carried.end();
                               }),
                names.end());
    return names;
  }

  const FitJob& job_;
  const Observations& observations_;
  TextFindings findings_;
  Unknowns out_;
};

}  // namespace

Parsed<Unknowns> unknowns_of(const FitJob& job, const Observations& observations) {
  return Chooser(job, observations).choose();
}

}  // namespace abbe
