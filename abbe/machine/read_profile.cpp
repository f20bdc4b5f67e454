#include "abbe/machine/read_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "abbe/machine/profile_sections.h"

namespace abbe {
namespace {

// The root of every embedded profile is reached in fewer steps.
constexpr int kDeepestExtends = 8;
constexpr std::size_t kLargestProfile = std::size_t{1} << 20;

const std::vector<std::string> kTables{"format",  "title", "about",  "sources", "extends",  "text",
                                       "numbers", "arcs",  "cycles", "tools",   "start",    "offsets",
                                       "motion",  "codes", "order",  "refused", "addresses"};

void read_numbers(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(root, "numbers",
                        {"integer_words", "decimals", "digits", "finer_words", "scale_words", "scale_axes"},
                        findings);
  Profile::Numbers& numbers = profile.numbers;
  section.choice("integer_words", {"units", "increments", "ask"}, numbers.integer_words);
  section.choice("finer_words", "keep", "refuse", numbers.finer);
  section.choice("scale_words", {"thousandths", "hundred-thousandths", "ask"}, numbers.scale_words);
  section.choice("scale_axes", {"plane", "space", "ask"}, numbers.scale_axes);
  section.whole("digits", numbers.digits, 0, 15);
  const TomlNode* decimals = section.find("decimals");
  if (decimals == nullptr || !expect_kind(*decimals, TomlNode::Kind::table, "numbers.decimals", findings))
    return;
  refuse_other_keys(*decimals, {"mm", "inch", "degree", "feed", "vector"}, "numbers.decimals", findings);
  for (const auto& [key, value] : {std::pair{"mm", &numbers.decimals_mm},
                                   {"inch", &numbers.decimals_inch},
                                   {"degree", &numbers.decimals_degree},
                                   {"feed", &numbers.decimals_feed},
                                   {"vector", &numbers.decimals_vector}}) {
    if (const TomlEntry* entry = decimals->find(key))
      section.read_whole(entry->value, fmt::format("numbers.decimals.{}", key), *value, 1, 8);
  }
}

/// Texts out of a list of allowed ones; `present` gets those that stand there.
bool read_subset(const Section& section, std::string_view key, const std::vector<std::string>& allowed,
                 std::vector<bool>& present, Findings& findings) {
  const TomlNode* node = section.find(key);
  if (node == nullptr || !expect_kind(*node, TomlNode::Kind::array, section.what(key), findings))
    return false;
  present.assign(allowed.size(), false);
  for (const TomlNode& item : node->items) {
    if (const auto at = read_choice(item, allowed, section.what(key), findings)) present[*at] = true;
  }
  return true;
}

void read_text_rules(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(
      root, "text",
      {"block_bytes", "comments", "percent", "program_number", "block_delete", "names", "conversational"},
      findings);
  Profile::Text& text = profile.text;
  section.whole("block_bytes", text.block_bytes, 60, 254);
  section.flag("percent", text.percent);
  section.flag("names", text.names);
  section.flag("conversational", text.conversational);
  section.choice("block_delete", {"none", "plain", "numbered", "ignored"}, text.skip);
  std::vector<bool> present;
  if (read_subset(section, "comments", {"()", ";"}, present, findings)) {
    text.parentheses = present[0];
    text.semicolon = present[1];
  }
  if (read_subset(section, "program_number", {"O", ":"}, present, findings)) {
    text.program_number = present[0];
    text.colon = present[1];
  }
}

void read_arcs(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(
      root, "arcs",
      {"centres", "radius_form", "helix", "turns", "tolerance_mm", "limit_mm", "relative", "inch_scale"},
      findings);
  Profile::Arcs& arcs = profile.arcs;
  section.choice("centres", "either", "incremental", profile.arc_centre_switch);
  section.flag("radius_form", arcs.radius_form);
  section.flag("helix", arcs.helix);
  section.flag("turns", arcs.turns);
  section.positive("tolerance_mm", arcs.tolerance);
  section.positive("limit_mm", arcs.limit);
  section.positive("relative", arcs.relative);
  section.positive("inch_scale", arcs.inch_scale);
}

void read_cycles(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(root, "cycles",
                        {"repeats", "sticky", "dwell_needed", "xy_only", "level_below_r", "dwell_as_g4"},
                        findings);
  bool with_l = profile.cycles.repeats == 'L';
  section.choice("repeats", "L", "K", with_l);
  profile.cycles.repeats = with_l ? 'L' : 'K';
  section.choice("sticky", {"numbers", "levels", "same_mode"}, profile.cycles.sticky);
  section.flag("dwell_needed", profile.cycles.dwell_needed);
  section.flag("xy_only", profile.cycles.xy_only);
  section.flag("level_below_r", profile.cycles.level_below_r);
  section.flag("dwell_as_g4", profile.cycles.dwell_as_g4);
}

void read_states(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section tools(root, "tools",
                      {"h_needed", "z_only", "moves", "change_first", "home_cancels", "edges",
                       "follows_plane", "in_machine_coordinates"},
                      findings);
  tools.flag("h_needed", profile.tools.h_needed);
  tools.flag("z_only", profile.tools.z_only);
  tools.flag("moves", profile.tools.moves);
  tools.flag("change_first", profile.tools.change_first);
  tools.flag("home_cancels", profile.tools.home_cancels);
  tools.choice("edges", {"none", "tool", "table"}, profile.tools.edges);
  tools.flag("follows_plane", profile.tools.follows_plane);
  tools.flag("in_machine_coordinates", profile.tools.in_machine_coordinates);
  const Section start(root, "start", {"units", "distance", "offset", "retract"}, findings);
  start.choice("units", {"mm", "inch", "stated"}, profile.start.units);
  start.choice("distance", {"absolute", "incremental", "stated"}, profile.start.distance);
  start.choice("offset", "first", "stated", profile.start.first_offset);
  start.choice("retract", "r", "initial", profile.start.retract_to_r);
  const Section offsets(root, "offsets", {"fixed", "further", "l20", "p0", "keeps_shift", "increments"},
                        findings);
  offsets.whole("further", profile.offsets.further, 0, kMostFurtherOffsets);
  offsets.whole("fixed", profile.offsets.fixed, 1, kFixedOffsets);
  offsets.flag("keeps_shift", profile.offsets.keeps_shift);
  offsets.choice("increments", "place", "unsure", profile.offsets.increments_sure);
  offsets.choice("l20", "reads", "further", profile.offsets.l20_reads);
  offsets.choice("p0", "active", "external", profile.offsets.p0_active);
  const Section motion(root, "motion",
                       {"home_beside_motion", "rapid_straight", "rotary_feed", "turning", "block_time_ms"},
                       findings);
  motion.flag("home_beside_motion", profile.home_beside_motion);
  motion.flag("rapid_straight", profile.rapid_straight);
  motion.choice("rotary_feed", "linear", "unsure", profile.feed_of_linear);
  motion.choice("turning", "evenly", "codes", profile.turns_evenly);
  double milliseconds = profile.block_time * 1e3;
  motion.positive("block_time_ms", milliseconds);
  profile.block_time = milliseconds / 1e3;
}

/// What the repeats word and the further offsets bring with them.
void complete(Profile& profile) {
  profile.letters = 0;
  for (CodeUse& use : profile.g) {
    const bool arc = use.meaning == Meaning::arc_cw || use.meaning == Meaning::arc_ccw;
    if (arc && !profile.arcs.turns) use.words &= ~letter_set("P");
    if (arc && !profile.arcs.radius_form) use.words &= ~letter_set("R");
    const bool cycle = use.meaning >= Meaning::chip_break && use.meaning <= Meaning::bore_dwell;
    if (cycle && profile.cycles.repeats == 'K') use.words = (use.words & ~letter_set("L")) | letter_set("K");
    profile.letters |= use.words;
  }
  for (CodeUse& use : profile.m) {
    use.after = use.after || use.meaning == Meaning::stop || use.meaning == Meaning::end ||
                use.meaning == Meaning::call_subprogram || use.meaning == Meaning::end_subprogram;
    profile.letters |= use.words;
  }
}

void apply(const TomlNode& root, Profile& profile, Findings& findings) {
  const auto text = [&](const char* key, std::string& value) {
    if (const TomlEntry* entry = root.find(key))
      value = read_text(entry->value, key, findings).value_or(value);
  };
  text("title", profile.title);
  text("about", profile.about);
  if (const TomlEntry* sources = root.find("sources");
      sources != nullptr && expect_kind(sources->value, TomlNode::Kind::array, "sources", findings)) {
    profile.sources.clear();
    for (const TomlNode& item : sources->value.items) {
      if (auto source = read_text(item, "sources", findings)) profile.sources.push_back(std::move(*source));
    }
  }
  read_text_rules(root, profile, findings);
  read_numbers(root, profile, findings);
  read_arcs(root, profile, findings);
  read_cycles(root, profile, findings);
  read_states(root, profile, findings);
  read_codes(root, profile, findings);
  read_addresses(root, profile, findings);
  read_order(root, profile, findings);
  read_refusals(root, profile, findings);
}

std::string name_of_file(const std::string& file) {
  const std::size_t slash = file.find_last_of('/');
  const std::string name = slash == std::string::npos ? file : file.substr(slash + 1);
  return name.substr(0, name.rfind(".toml") == std::string::npos ? name.size() : name.rfind(".toml"));
}

std::string_view embedded_text(std::string_view name) {
  for (const EmbeddedProfile& profile : embedded_profiles()) {
    if (profile.name == name) return profile.text;
  }
  return {};
}

/// False after a mistake. `depth` guards against embedded profiles that extend each other in a circle.
bool read_layer(const std::string& file, std::string_view text, int depth, Profile& profile,
                Diagnostics& out) {
  Findings findings(file, text, out);
  if (text.size() > kLargestProfile) {
    findings.error("E-FILE", {}, fmt::format("{} bytes are too many for a profile", text.size()), "",
                   "check that the right file is named");
    return false;
  }
  const auto root = read_toml(text, findings);
  if (!root) return false;
  refuse_other_keys(*root, kTables, "the profile", findings);
  const TomlEntry* format = root->find("format");
  if (format == nullptr || format->value.kind != TomlNode::Kind::number || !format->value.is_integer ||
      format->value.integer != 1) {
    findings.error("E-FORMAT", format == nullptr ? Mark{1, 1, 1} : format->value.mark,
                   "format = 1 is missing", "formats may change; the number says how to read the file",
                   "begin the file with format = 1");
  }
  if (const TomlEntry* extends = root->find("extends")) {
    const auto names = embedded_profile_names();
    const auto at = read_choice(extends->value, names, "extends", findings);
    if (!at || depth == kDeepestExtends) return false;
    if (!read_layer(names[*at] + ".toml", embedded_text(names[*at]), depth + 1, profile, out)) return false;
  } else if (root->find("codes") == nullptr) {
    findings.error("E-MISSING-KEY", Mark{1, 1, 1}, "no [codes] and no extends",
                   "without codes every program is refused",
                   "add extends = \"fanuc\", or list the control's codes");
  }
  apply(*root, profile, findings);
  return findings.error_count() == 0;
}

}  // namespace

std::vector<std::string> embedded_profile_names() {
  std::vector<std::string> names;
  for (const EmbeddedProfile& profile : embedded_profiles()) names.emplace_back(profile.name);
  return names;
}

Parsed<Profile> read_profile(const std::string& file, std::string_view text) {
  Parsed<Profile> out;
  Profile profile;
  if (!read_layer(file, text, 0, profile, out.diagnostics) || has_errors(out.diagnostics)) return out;
  profile.name = name_of_file(file);
  profile.file = file;
  if (profile.title.empty()) profile.title = profile.name;
  complete(profile);
  out.value = std::move(profile);
  return out;
}

std::shared_ptr<const Profile> embedded_profile(std::string_view name) {
  using Profiles = std::map<std::string, std::shared_ptr<const Profile>, std::less<>>;
  static const Profiles all = [] {
    Profiles read;
    for (const EmbeddedProfile& embedded : embedded_profiles()) {
      auto parsed = read_profile(std::string(embedded.name) + ".toml", embedded.text);
      if (parsed.value)
        read.emplace(embedded.name, std::make_shared<const Profile>(std::move(*parsed.value)));
    }
    return read;
  }();
  const auto found = all.find(name);
  return found == all.end() ? nullptr : found->second;
}

}  // namespace abbe
