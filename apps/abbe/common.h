#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/chain/correct.h"
#include "abbe/chain/plan.h"
#include "abbe/core/diagnostic.h"
#include "abbe/machine/machine.h"
#include "command_line.h"
#include "quick_machine.h"
#include "session.h"

namespace abbe::app {

/// Options that every verb with a machine understands, as typed.
struct CommonArguments {
  std::string machine;
  QuickMachine quick;  ///< verbs that take it: in place of `machine`
  std::string errors;
  std::vector<std::string> set;
  std::string environment;
  std::vector<std::string> approach;
  std::string model = "rigid";
  std::optional<double> limit_um, limit_angle_deg;
  bool json = false;
};

/// Refuses nan and inf, which CLI11's own checks let through.
[[nodiscard]] OptionCheck finite_number();

/// Those that name the machine, and how to answer.
void add_machine_options(Command& verb, CommonArguments& arguments, Session& session);
void add_common_options(Command& verb, CommonArguments& arguments, Session& session);
/// --skew, --scale, --pitch as well: then MACHINE is left out. After add_machine_options or
/// add_common_options.
void allow_quick_machine(Command& verb, CommonArguments& arguments);

/// `--at`, `--set`, `--gauge` and their like: "A=1,B=2" of one or several options, in order.
struct Assignment {
  std::string name, text;
};
[[nodiscard]] std::vector<Assignment> split_assignments(std::string_view option,
                                                        const std::vector<std::string>& arguments,
                                                        Diagnostics& diagnostics);

/// "Z1,B1": the pieces, blanks around them removed.
[[nodiscard]] std::vector<std::string> split_list(std::string_view text);

/// The number, or a diagnostic about the option and nothing.
[[nodiscard]] std::optional<double> option_number(std::string_view option, const std::string& name,
                                                  const std::string& text, Diagnostics& diagnostics);

/// What a name on the command line or a column of a CSV file means for a machine.
struct NameMeaning {
  enum class Kind { position, approach, velocity, acceleration, sensor, unknown } kind = Kind::unknown;
  int axis = -1;
};
[[nodiscard]] NameMeaning meaning_of(const Machine& machine, std::string_view name);
/// The known name most like `name`, as a remedy: "did you mean 'X.dir'?"; empty if none is close.
[[nodiscard]] std::string suggestion(const Machine& machine, std::string_view name);

/// -1, 0, +1 from - 0 + (also -1 +1 1); nullopt otherwise.
[[nodiscard]] std::optional<signed char> read_approach(std::string_view text);

/// Accepted deviation: --limit-um and --limit-angle-deg.
struct Limits {
  std::optional<double> position, angle;  ///< mm, rad
  [[nodiscard]] bool given() const { return position || angle; }
  [[nodiscard]] bool pass(double distance, double rotation) const {
    return (!position || distance <= *position) && (!angle || rotation <= *angle);
  }
};

/// A machine and the circumstances of its use, from the common options.
struct Setting {
  Machine machine;
  Environment environment;
  ErrorModel model = ErrorModel::rigid;
  std::array<signed char, kMaxAxes> approach{};
  Limits limits;
  Diagnostics findings;  ///< warnings and notes of the machine file, already reported
};

/// Reads everything the common options name; nullopt after reporting all mistakes.
[[nodiscard]] std::optional<Setting> load_setting(const CommonArguments& arguments, Session& session);

/// The same for verbs that move the machine: without the errors that its control corrects itself; nullopt,
/// too, after E-SCOPE for errors that are true of one test only.
[[nodiscard]] std::optional<Setting> load_controlled_setting(const CommonArguments& arguments,
                                                             Session& session);

/// Reads a file, or standard input for "-"; nullopt after reporting why not.
[[nodiscard]] std::optional<std::string> read_input(const std::string& path, Session& session);

/// The plan, or E-SENSOR for every sensor that nobody gave: which error needs it and how to give it.
[[nodiscard]] std::optional<Plan> plan_or_report(const Setting& setting, const Environment& environment,
                                                 Session& session);

/// --lock Z1,B1 as a set; unknown names are reported.
[[nodiscard]] AxisSet read_lock(const Machine& machine, const std::vector<std::string>& lock,
                                Diagnostics& diagnostics);

/// The axes a correction may move, or E-LOCK.
[[nodiscard]] std::optional<AxisSet> free_axes_or_report(const Machine& machine, AxisSet locked,
                                                         Session& session);

/// --method: newton, one-step, closed-form, printed.
void add_method_option(Command& verb, std::string& method);
[[nodiscard]] Method method_of(std::string_view text);
/// False after E-METHOD: the method does not fit this chain.
[[nodiscard]] bool method_fits_or_report(const Setting& setting, Method method, AxisSet free,
                                         Session& session);

/// Axes of q that are beyond their travel, by name.
[[nodiscard]] std::vector<std::string> outside_travel(const Machine& machine,
                                                      const std::array<double, kMaxAxes>& q);

[[nodiscard]] std::string_view to_string(ErrorModel model);

}  // namespace abbe::app
