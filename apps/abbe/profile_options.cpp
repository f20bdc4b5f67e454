#include "profile_options.h"

#include <fmt/format.h>

#include <optional>
#include <utility>

#include "abbe/core/file.h"
#include "abbe/machine/read_profile.h"

namespace abbe::app {
namespace {

constexpr const char* kDefault = "linuxcnc";

std::optional<Profile> profile_from_file(const std::string& path, Session& session) {
  const auto text = read_file(path);
  if (const auto* error = std::get_if<FileError>(&text)) {
    session.report(*error, path);
    return std::nullopt;
  }
  auto parsed = read_profile(path, std::get<std::string>(text));
  session.report(parsed.diagnostics);
  return std::move(parsed.value);
}

std::optional<Profile> profile_of_name(const std::string& name, Session& session) {
  if (const auto profile = embedded_profile(name)) return *profile;
  const auto names = embedded_profile_names();
  const auto like = closest(name, names);
  std::string known;
  for (const std::string& other : names) known += (known.empty() ? "" : ", ") + other;
  session.report(option_error("--dialect", fmt::format("'{}' is no control that is known here", name),
                              like ? fmt::format("did you mean '{}'?", *like)
                                   : fmt::format("known: {}; or describe yours: --profile FILE", known)));
  return std::nullopt;
}

}  // namespace

void add_profile_options(Command& verb, ProfileArguments& a) {
  verb.add_option(
      "--dialect", a.dialect,
      "control the program is for (abbe profiles lists them; default linuxcnc); cl, apt, clsf: CL data");
  verb.add_option("--profile", a.file, "the same from a profile file");
  verb.add_option("--integer-words", a.integer_words,
                  "a coordinate without a decimal point counts units (X100 = 100 mm) or increments (0.1 mm)")
      ->check(one_of({"units", "increments"}));
  verb.add_option("--units", a.units, "units before the program says G20 or G21; CL data without UNITS")
      ->check(one_of({"mm", "inch"}));
}

std::shared_ptr<const Profile> load_profile(const ProfileArguments& a, Session& session) {
  if (!a.dialect.empty() && !a.file.empty()) {
    session.report(option_error("--profile", "a control is named by --dialect, too",
                                "give one of them; a profile file may say extends = \"fanuc\""));
    return nullptr;
  }
  auto profile = a.file.empty() ? profile_of_name(a.dialect.empty() ? kDefault : a.dialect, session)
                                : profile_from_file(a.file, session);
  if (!profile) return nullptr;
  using Words = Profile::IntegerWords;
  if (!a.integer_words.empty())
    profile->numbers.integer_words = a.integer_words == "units" ? Words::units : Words::increments;
  if (!a.units.empty())
    profile->start.units = a.units == "mm" ? Profile::Units::metric : Profile::Units::imperial;
  return std::make_shared<const Profile>(std::move(*profile));
}

}  // namespace abbe::app
