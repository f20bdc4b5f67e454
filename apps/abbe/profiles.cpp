// The verb that lists and explains the controls whose programs are understood.

#include <fmt/format.h>

#include <memory>
#include <string>

#include "abbe/machine/read_profile.h"
#include "abbe/report/json_writer.h"
#include "command_line.h"
#include "profile_options.h"
#include "verbs.h"

namespace abbe::app {
namespace {

std::string letters_of(LetterSet set) {
  std::string text;
  for (char letter = 'A'; letter <= 'Z'; ++letter)
    if ((set & letter_set({&letter, 1})) != 0) text += letter;
  return text;
}

/// A code with what the profile says of it.
struct Row {
  std::string code;
  const CodeUse* use;
};

std::vector<Row> rows_of(const Profile& profile) {
  std::vector<Row> rows;
  const auto told = [](const CodeUse& use) { return use.meaning != Meaning::unknown || use.refusal != 0; };
  for (std::size_t i = 0; i < profile.g.size(); ++i)
    if (told(profile.g[i])) rows.push_back({g_name(profile, i), &profile.g[i]});
  for (std::size_t i = 0; i < Profile::kMCodes; ++i)
    if (told(profile.m[i])) rows.push_back({fmt::format("M{}", i), &profile.m[i]});
  return rows;
}

const char* name_of(Profile::IntegerWords words) {
  static constexpr std::array<const char*, 3> kNames{"units", "increments", "ask"};
  return kNames[static_cast<std::size_t>(words)];
}

void write_json(const Profile& profile, JsonWriter& json) {
  json.begin_object();
  json.member("name", profile.name);
  json.member("title", profile.title);
  json.member("about", profile.about);
  json.key("sources");
  json.begin_array();
  for (const std::string& source : profile.sources) json.value(source);
  json.end();
  json.member("integer_words", name_of(profile.numbers.integer_words));
  json.key("decimals");
  json.begin_object();
  json.member("mm", profile.numbers.decimals_mm);
  json.member("inch", profile.numbers.decimals_inch);
  json.member("degree", profile.numbers.decimals_degree);
  json.end();
  json.member("block_bytes", static_cast<std::uint64_t>(profile.text.block_bytes));
  json.member("arc_tolerance_mm", profile.arcs.tolerance);
  json.key("codes");
  json.begin_array();
  for (const Row& row : rows_of(profile)) {
    const MeaningInfo& info = about(row.use->meaning);
    json.begin_object();
    json.member("code", row.code);
    json.member("meaning", std::string(info.name));
    json.member("policy", std::string(info.policy));
    json.member("words", letters_of(row.use->words));
    if (row.use->after) json.member("after_motion", true);
    if (row.use->refusal != 0) json.member("why", profile.refusals[row.use->refusal - 1U].why);
    json.end();
  }
  json.end();
  json.end();
}

std::string text_of(const Profile& profile) {
  const auto& numbers = profile.numbers;
  std::string text = fmt::format("{}: {}\n", profile.name, profile.about);
  for (const std::string& source : profile.sources) text += fmt::format("  source    {}\n", source);
  text += fmt::format("  numbers   {} decimals in mm, {} in inch; without a point: {}\n", numbers.decimals_mm,
                      numbers.decimals_inch, name_of(numbers.integer_words));
  text += fmt::format("  lines     up to {} bytes\n", profile.text.block_bytes);
  text += fmt::format("  arcs      radii may differ by {:.4g} mm\n", profile.arcs.tolerance);
  for (const Row& row : rows_of(profile)) {
    const MeaningInfo& info = about(row.use->meaning);
    const std::string sense = row.use->refusal != 0
                                  ? "refused: " + profile.refusals[row.use->refusal - 1U].why
                                  : std::string(info.sense);
    text += fmt::format("  {:<7} {:<4} {:<8} {}{}\n", row.code, info.policy, letters_of(row.use->words),
                        sense, row.use->after ? " (after the motion)" : "");
  }
  return text + "  every other code is refused\n";
}

std::string meanings_text() {
  std::string text;
  for (const MeaningInfo& info : all_meanings())
    text += fmt::format("  {}  {:<22} {:<4} {:<8} {}\n", info.kind, info.name, info.policy,
                        letters_of(info.words), info.sense);
  return text;
}

struct Arguments {
  ProfileArguments profile;
  bool json = false, meanings = false;
};

void list_all(bool as_json, Session& session) {
  JsonWriter json;
  std::string text;
  json.begin_array();
  for (const std::string& name : embedded_profile_names()) {
    const auto profile = embedded_profile(name);
    if (profile == nullptr) continue;
    if (as_json) write_json(*profile, json);
    text += fmt::format("  {:<10} {}\n", name, profile->about);
  }
  json.end();
  session.out.write(as_json ? json.take() + "\n"
                            : text + "`abbe profiles NAME` explains one, `--profile FILE` reads your own\n");
}

void run(const Arguments& arguments, Session& session) {
  if (arguments.meanings) return session.out.write(meanings_text());
  if (arguments.profile.dialect.empty() && arguments.profile.file.empty())
    return list_all(arguments.json, session);
  const auto profile = load_profile(arguments.profile, session);
  if (profile == nullptr) return;
  if (!arguments.json) return session.out.write(text_of(*profile));
  JsonWriter json;
  write_json(*profile, json);
  session.out.write(json.take() + "\n");
}

}  // namespace

Verb profiles_verb(Command& program, Session& session) {
  auto arguments = std::make_shared<Arguments>();
  Command* verb = program.add_subcommand("profiles", "the controls whose programs are understood, and how");
  verb->add_option("name", arguments->profile.dialect, "control to explain");
  verb->add_option("--profile", arguments->profile.file, "a profile file of your own");
  verb->add_flag("--meanings", arguments->meanings, "what a code may mean in a profile");
  verb->add_flag("--json", arguments->json, "answer as JSON");
  return {verb, [arguments, &session] { run(*arguments, session); }};
}

}  // namespace abbe::app
