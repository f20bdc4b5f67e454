#include "cl_options.h"

#include <algorithm>
#include <array>
#include <cctype>

#include "abbe/core/units.h"
#include "common.h"
#include "pose_source.h"

namespace abbe::app {
namespace {

std::string changed(std::string text, int (*change)(int)) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [change](unsigned char c) { return static_cast<char>(change(c)); });
  return text;
}

}  // namespace

void add_cl_options(Command& verb, ClArguments& a, bool near) {
  verb.add_option("--tool-axis", a.tool_axis,
                  "CL data: correct the tool axes of all six-number records, keep them, or auto: those while "
                  "MULTAX is on")
      ->check(one_of({"auto", "correct", "keep"}))
      ->capture_default_str();
  verb.add_option("--circle-hand", a.circle_hand,
                  "CL data of NX: the hand about i,j,k that gives the sense of a circle")
      ->check(one_of({"right", "left"}));
  verb.add_option(
          "--pass-record", a.pass_records,
          "CL data: copy records of this major word; it must neither move nor change a frame (repeatable)")
      ->allow_extra_args(false);
  if (!near) return;
  verb.add_option("--near", a.near,
                  "CL data: where the rotary axes stand, so that the nearest solution is taken")
      ->type_name("AXIS=VALUE,..")
      ->allow_extra_args(false);
}

bool is_cl_data(std::string_view dialect, std::string_view path) {
  static constexpr std::array<std::string_view, 3> kDialects = {"cl", "apt", "clsf"};
  static constexpr std::array<std::string_view, 6> kEndings = {".cls",       ".clsf", ".apt",
                                                               ".aptsource", ".ncl",  ".cl"};
  if (std::find(kDialects.begin(), kDialects.end(), dialect) != kDialects.end()) return true;
  const std::string lower = changed(std::string(path), [](int c) { return std::tolower(c); });
  return std::any_of(kEndings.begin(), kEndings.end(),
                     [&](std::string_view ending) { return lower.ends_with(ending); });
}

ClSetting read_cl_setting(const ClArguments& a, const std::string& units, const Machine& machine,
                          const ControlSetup& setup, Diagnostics& findings) {
  ClSetting setting;
  cl::Conventions& conventions = setting.conventions;
  if (!units.empty()) conventions.unit = units == "mm" ? mm : inch;
  conventions.axis_rule = a.tool_axis == "correct" ? cl::AxisRule::correct
                          : a.tool_axis == "keep"  ? cl::AxisRule::keep
                                                   : cl::AxisRule::automatic;
  if (!a.circle_hand.empty())
    conventions.circle_hand = a.circle_hand == "right" ? cl::CircleHand::right : cl::CircleHand::left;
  for (const std::string& list : a.pass_records) {
    for (const std::string& word : split_list(list)) {
      const std::string major = changed(word, [](int c) { return std::toupper(c); });
      static constexpr std::array<std::string_view, 5> kMotions = {"GOTO", "FROM", "GODLTA", "CIRCLE",
                                                                   "MOVARC"};
      if (std::find(kMotions.begin(), kMotions.end(), major) != kMotions.end())
        findings.push_back(option_error("--pass-record", major + " moves the tool", "leave it out"));
      conventions.pass_words.insert(major);
    }
  }
  conventions.tool_change_keeps_place = setup.tool_change_keeps_place;
  if (setup.work_offsets[0] && setup.work_offsets[0]->turns != std::array<double, 3>{})
    findings.push_back(option_error("--offset", "CL data know no offset of rotary axes",
                                    "state where the part stands with the rotary axes at zero"));
  setting.start = read_near(machine, a.near, findings);
  return setting;
}

}  // namespace abbe::app
