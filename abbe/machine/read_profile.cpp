#include "abbe/machine/read_profile.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <utility>

#include "abbe/machine/toml_values.h"

namespace abbe {
namespace {

// The root of every embedded profile is reached in fewer steps.
constexpr int kDeepestExtends = 8;
constexpr std::size_t kLargestProfile = std::size_t{1} << 20;
constexpr int kMostFurtherOffsets = 300;
constexpr int kFixedOffsets = 9;

const std::vector<std::string> kTables{"format",  "title",  "about",   "sources", "extends", "text",
                                       "numbers", "arcs",   "cycles",  "tools",   "start",   "offsets",
                                       "motion",  "codes",  "order",   "refused", "addresses"};
/// Codes of refusals a profile may use.
const std::vector<std::string> kRefusalCodes{"E-GCODE", "E-MCODE", "E-CUTCOM", "E-FRAME", "E-TCP", "E-CYCLE", "E-EXPR", "E-OWORD", "E-ROTARY"};
const std::vector<std::string> kForms{"alone", "empty", "arguments", "value"};  // as Profile::Form
constexpr std::size_t kLongestName = 32;

/// One table of a profile: what it names is changed, the rest stays.
class Section {
 public:
  Section(const TomlNode& root, std::string name, const std::vector<std::string>& keys, Findings& findings)
      : name_(std::move(name)), findings_(findings) {
    const TomlEntry* entry = root.find(name_);
    if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, name_, findings)) return;
    table_ = &entry->value;
    refuse_other_keys(*table_, keys, "[" + name_ + "]", findings);
  }

  [[nodiscard]] const TomlNode* find(std::string_view key) const {
    const TomlEntry* entry = table_ == nullptr ? nullptr : table_->find(key);
    return entry == nullptr ? nullptr : &entry->value;
  }
  [[nodiscard]] std::string what(std::string_view key) const { return fmt::format("{}.{}", name_, key); }

  void flag(std::string_view key, bool& value) const {
    if (const TomlNode* node = find(key)) value = read_flag(*node, what(key), findings_).value_or(value);
  }

  /// A flag that reads better as one of two words.
  void choice(std::string_view key, const char* yes, const char* no, bool& value) const {
    if (const TomlNode* node = find(key)) {
      if (const auto at = read_choice(*node, {yes, no}, what(key), findings_)) value = *at == 0;
    }
  }

  template <class Enum>
  void choice(std::string_view key, const std::vector<std::string>& words, Enum& value) const {
    if (const TomlNode* node = find(key)) {
      if (const auto at = read_choice(*node, words, what(key), findings_)) value = static_cast<Enum>(*at);
    }
  }

  void positive(std::string_view key, double& value) const {
    const TomlNode* node = find(key);
    const auto number = node == nullptr ? std::nullopt : read_value(*node, what(key), findings_);
    if (!number) return;
    if (*number > 0) {
      value = *number;
    } else {
      findings_.error("E-VALUE", node->mark, fmt::format("{} is not positive", what(key)), "", "write a positive number");
    }
  }

  template <class Int>
  void whole(std::string_view key, Int& value, int low, int high) const {
    if (const TomlNode* node = find(key)) read_whole(*node, what(key), value, low, high);
  }

  template <class Int>
  void read_whole(const TomlNode& node, const std::string& name, Int& value, int low, int high) const {
    if (!expect_kind(node, TomlNode::Kind::number, name, findings_)) return;
    if (node.is_integer && node.integer >= low && node.integer <= high) {
      value = static_cast<Int>(node.integer);
    } else {
      findings_.error("E-VALUE", node.mark, fmt::format("{} is not a whole number from {} to {}", name, low, high), "",
                      "correct the number");
    }
  }

  [[nodiscard]] std::vector<std::string> texts(std::string_view key) const {
    std::vector<std::string> list;
    const TomlNode* node = find(key);
    if (node == nullptr || !expect_kind(*node, TomlNode::Kind::array, what(key), findings_)) return list;
    for (const TomlNode& item : node->items) {
      if (auto text = read_text(item, what(key), findings_)) list.push_back(std::move(*text));
    }
    return list;
  }

  [[nodiscard]] const TomlNode* table() const { return table_; }

 private:
  std::string name_;
  Findings& findings_;
  const TomlNode* table_ = nullptr;
};

std::vector<std::string> meaning_names(char kind) {
  std::vector<std::string> names{"unknown"};
  for (const MeaningInfo& info : all_meanings()) {
    if (info.kind == kind && info.meaning != Meaning::unknown) names.emplace_back(info.name);
  }
  return names;
}

std::optional<Meaning> read_meaning(const TomlNode& node, char kind, const std::string& what, Findings& findings) {
  const auto names = meaning_names(kind);
  const auto at = read_choice(node, names, what, findings);
  if (!at) return std::nullopt;
  for (const MeaningInfo& info : all_meanings()) {
    if (info.name == names[*at]) return info.meaning;
  }
  return std::nullopt;
}

/// Capitals, digits and '_', two at least, a letter first.
bool is_name(std::string_view text) {
  const auto letter = [](char c) { return c >= 'A' && c <= 'Z'; };
  const bool allowed = std::all_of(text.begin(), text.end(), [&](char c) { return letter(c) || c == '_' || (c >= '0' && c <= '9'); });
  return allowed && text.size() >= 2 && text.size() <= kLongestName && (letter(text[0]) || text[0] == '_');
}

/// A code that is a word, new if the profile has not had it.
Profile::Keyword* keyword_of(std::string_view name, Mark mark, Profile& profile, Findings& findings) {
  auto& words = profile.keywords;
  const auto at = std::lower_bound(words.begin(), words.end(), name, [](const auto& word, std::string_view key) { return word.name < key; });
  if (at != words.end() && at->name == name) return &*at;
  if (words.size() == Profile::kKeywords) {
    findings.error("E-COUNT", mark, fmt::format("more than {} codes that are words", Profile::kKeywords), "", "leave out what programs do not use");
    return nullptr;
  }
  return &*words.insert(at, {std::string(name), Profile::kGCodes + words.size(), Profile::Form::alone});
}

/// The code that a key or a text names, or E-VALUE.
CodeUse* find_code(std::string_view name, Mark mark, Profile& profile, Findings& findings) {
  const CodeName code = read_code_name(name);
  if (code.kind == 'G') return &profile.g[code.index];
  if (code.kind == 'M') return &profile.m[code.index];
  const bool misspelled = name.size() > 1 && (name[0] == 'G' || name[0] == 'M') && name[1] >= '0' && name[1] <= '9';
  if (profile.text.names && is_name(name) && !misspelled) {
    const Profile::Keyword* keyword = keyword_of(name, mark, profile, findings);
    return keyword == nullptr ? nullptr : &profile.g[keyword->index];
  }
  findings.error("E-VALUE", mark, fmt::format("{} is no G or M code", in_quotes(name)),
                 "codes are G0 to G819 with at most one digit after the point, and M0 to M1023; words where [text] has names = true",
                 "write \"G59.1\" or M30, in capitals and without leading zeros");
  return nullptr;
}

std::optional<LetterSet> read_letters(const TomlNode& node, const std::string& what, Findings& findings) {
  const auto text = read_text(node, what, findings);
  if (!text) return std::nullopt;
  const bool letters = std::all_of(text->begin(), text->end(), [](char c) { return c >= 'A' && c <= 'Z' && c != 'G' && c != 'M' && c != 'N' && c != 'O'; });
  if (letters) return letter_set(*text);
  findings.error("E-VALUE", node.mark, fmt::format("{} is {}, expected capital letters", what, in_quotes(*text)),
                 "they are the words that belong to the code; G M N O belong to no code", "write words = \"PQ\"");
  return std::nullopt;
}

/// What may follow the word of a code; whatever it was before, `alone` if nothing is said.
void read_form(const TomlEntry& entry, bool detailed, Profile& profile, Findings& findings) {
  const TomlEntry* said = detailed ? entry.value.find("form") : nullptr;
  if (read_code_name(entry.key).kind != 0) {
    if (said != nullptr)
      findings.error("E-VALUE", said->mark, fmt::format("{} has a number, and so no form", entry.key), "", "remove form");
    return;
  }
  Profile::Keyword* keyword = keyword_of(entry.key, entry.mark, profile, findings);
  if (keyword == nullptr) return;
  keyword->form = Profile::Form::alone;
  if (said == nullptr) return;
  if (const auto at = read_choice(said->value, kForms, "codes." + entry.key + ".form", findings)) keyword->form = static_cast<Profile::Form>(*at);
}

/// `G64 = "path-control"` or `G64 = { meaning = "path-control", words = "PQ" }`.
void read_code(const TomlEntry& entry, Profile& profile, Findings& findings) {
  CodeUse* use = find_code(entry.key, entry.mark, profile, findings);
  if (use == nullptr) return;
  const std::string what = "codes." + entry.key;
  const bool detailed = entry.value.kind == TomlNode::Kind::table;
  const TomlEntry* said = detailed ? entry.value.find("meaning") : nullptr;
  if (detailed) {
    refuse_other_keys(entry.value, {"meaning", "words", "number", "form"}, what, findings);
    if (said == nullptr) {
      findings.error("E-MISSING-KEY", entry.value.mark, fmt::format("no meaning in {}", what), "it says what the code does",
                     "add meaning = \"copy\" or another of `abbe profiles --meanings`");
      return;
    }
  }
  const char kind = read_code_name(entry.key).kind == 'M' ? 'M' : 'G';
  const auto meaning = read_meaning(detailed ? said->value : entry.value, kind, what, findings);
  if (!meaning) return;
  read_form(entry, detailed, profile, findings);
  const bool after = use->after;  // [order] is another matter
  *use = CodeUse{};
  use->after = after;
  use->meaning = *meaning;
  use->words = about(*meaning).words;
  if (const TomlEntry* words = detailed ? entry.value.find("words") : nullptr)
    use->words = read_letters(words->value, what + ".words", findings).value_or(use->words);
  if (*meaning != Meaning::work_offset) return;
  const TomlEntry* number = detailed ? entry.value.find("number") : nullptr;
  if (number == nullptr) {
    findings.error("E-MISSING-KEY", entry.value.mark, fmt::format("no number in {}", what), "1 to 9 are G54 to G59.3, 9 + n is the further one n",
                   "write { meaning = \"work-offset\", number = 1 }");
    return;
  }
  const Section none(TomlNode{}, "codes", {}, findings);
  none.read_whole(number->value, what + ".number", use->number, 1, kFixedOffsets + kMostFurtherOffsets);
}

void read_codes(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("codes");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, "codes", findings)) return;
  for (const TomlEntry& code : entry->value.entries) {
    if (findings.full()) return;
    read_code(code, profile, findings);
  }
}

/// `CR = "R"`: no letter of an axis, whose words are also added and are spelled by their letter.
void read_addresses(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("addresses");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, "addresses", findings)) return;
  const std::vector<std::string> letters{"D", "F", "H", "L", "M", "P", "Q", "R", "S", "T"};
  for (const TomlEntry& address : entry->value.entries) {
    const auto at = read_choice(address.value, letters, "addresses." + address.key, findings);
    if (!is_name(address.key)) {
      findings.error("E-VALUE", address.mark, fmt::format("{} is no name of a word", in_quotes(address.key)),
                     "names are two or more capitals and digits", "write CR = \"R\"");
    } else if (at) {
      auto& list = profile.addresses;
      const auto place = std::lower_bound(list.begin(), list.end(), address.key, [](const auto& known, const std::string& key) { return known.name < key; });
      if (place != list.end() && place->name == address.key) place->letter = letters[*at][0];
      else list.insert(place, {address.key, letters[*at][0]});
    }
  }
}

void read_order(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section order(root, "order", {"after"}, findings);
  const TomlNode* list = order.find("after");
  if (list == nullptr) return;
  for (CodeUse& use : profile.m) use.after = false;
  const auto names = order.texts("after");
  for (const std::string& name : names) {
    if (CodeUse* use = find_code(name, list->mark, profile, findings)) use->after = true;
  }
}

void read_refusal(const TomlNode& table, Profile& profile, Findings& findings) {
  if (!expect_kind(table, TomlNode::Kind::table, "refused", findings)) return;
  refuse_other_keys(table, {"codes", "error", "why", "fix"}, "[[refused]]", findings);
  const auto text = [&](const char* key) {
    const TomlEntry* entry = table.find(key);
    if (entry != nullptr) return read_text(entry->value, fmt::format("refused.{}", key), findings).value_or("");
    findings.error("E-MISSING-KEY", table.mark, fmt::format("no {} in [[refused]]", key), "who is refused must learn why and what to do", fmt::format("add {} = \"..\"", key));
    return std::string();
  };
  const TomlEntry* codes = table.find("codes");
  if (codes == nullptr || !expect_kind(codes->value, TomlNode::Kind::array, "refused.codes", findings)) {
    if (codes == nullptr) findings.error("E-MISSING-KEY", table.mark, "no codes in [[refused]]", "they are what is refused", "add codes = [\"G41\", \"G42\"]");
    return;
  }
  CodeRefusal refusal{"", text("why"), text("fix")};
  if (const TomlEntry* error = table.find("error")) {
    if (const auto at = read_choice(error->value, kRefusalCodes, "refused.error", findings)) refusal.error = kRefusalCodes[*at];
  }
  if (profile.refusals.size() == 255) {
    findings.error("E-COUNT", table.mark, "more than 255 [[refused]] tables", "", "put codes with one reason into one table");
    return;
  }
  profile.refusals.push_back(std::move(refusal));
  for (const TomlNode& item : codes->value.items) {
    const auto name = read_text(item, "refused.codes", findings);
    CodeUse* use = name ? find_code(*name, item.mark, profile, findings) : nullptr;
    if (use == nullptr) continue;
    *use = CodeUse{};
    use->refusal = static_cast<std::uint8_t>(profile.refusals.size());
  }
}

void read_refusals(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("refused");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::array, "refused", findings)) return;
  for (const TomlNode& table : entry->value.items) read_refusal(table, profile, findings);
}

void read_numbers(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(root, "numbers", {"integer_words", "decimals", "digits", "finer_words"}, findings);
  Profile::Numbers& numbers = profile.numbers;
  section.choice("integer_words", {"units", "increments", "ask"}, numbers.integer_words);
  section.choice("finer_words", "keep", "refuse", numbers.finer);
  section.whole("digits", numbers.digits, 0, 15);
  const TomlNode* decimals = section.find("decimals");
  if (decimals == nullptr || !expect_kind(*decimals, TomlNode::Kind::table, "numbers.decimals", findings)) return;
  refuse_other_keys(*decimals, {"mm", "inch", "degree", "feed"}, "numbers.decimals", findings);
  for (const auto& [key, value] : {std::pair{"mm", &numbers.decimals_mm}, {"inch", &numbers.decimals_inch}, {"degree", &numbers.decimals_degree}, {"feed", &numbers.decimals_feed}}) {
    if (const TomlEntry* entry = decimals->find(key)) section.read_whole(entry->value, fmt::format("numbers.decimals.{}", key), *value, 1, 8);
  }
}

/// Texts out of a list of allowed ones; `present` gets those that stand there.
bool read_subset(const Section& section, std::string_view key, const std::vector<std::string>& allowed, std::vector<bool>& present, Findings& findings) {
  const TomlNode* node = section.find(key);
  if (node == nullptr || !expect_kind(*node, TomlNode::Kind::array, section.what(key), findings)) return false;
  present.assign(allowed.size(), false);
  for (const TomlNode& item : node->items) {
    if (const auto at = read_choice(item, allowed, section.what(key), findings)) present[*at] = true;
  }
  return true;
}

void read_text_rules(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section section(root, "text", {"block_bytes", "comments", "percent", "program_number", "block_delete", "names"}, findings);
  Profile::Text& text = profile.text;
  section.whole("block_bytes", text.block_bytes, 60, 254);
  section.flag("percent", text.percent);
  section.flag("names", text.names);
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
  const Section section(root, "arcs", {"centres", "radius_form", "helix", "turns", "tolerance_mm", "limit_mm", "relative", "inch_scale"}, findings);
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
  const Section section(root, "cycles", {"repeats", "sticky", "dwell_needed", "xy_only", "level_below_r"}, findings);
  bool with_l = profile.cycles.repeats == 'L';
  section.choice("repeats", "L", "K", with_l);
  profile.cycles.repeats = with_l ? 'L' : 'K';
  section.choice("sticky", {"numbers", "levels", "same_mode"}, profile.cycles.sticky);
  section.flag("dwell_needed", profile.cycles.dwell_needed);
  section.flag("xy_only", profile.cycles.xy_only);
  section.flag("level_below_r", profile.cycles.level_below_r);
}

void read_states(const TomlNode& root, Profile& profile, Findings& findings) {
  const Section tools(root, "tools", {"h_needed", "z_only", "moves", "change_first", "home_cancels", "edges", "follows_plane", "in_machine_coordinates"}, findings);
  tools.flag("h_needed", profile.tools.h_needed);
  tools.flag("z_only", profile.tools.z_only);
  tools.flag("moves", profile.tools.moves);
  tools.flag("change_first", profile.tools.change_first);
  tools.flag("home_cancels", profile.tools.home_cancels);
  tools.choice("edges", {"none", "tool", "table"}, profile.tools.edges);
  tools.flag("follows_plane", profile.tools.follows_plane);
  tools.flag("in_machine_coordinates", profile.tools.in_machine_coordinates);
  const Section start(root, "start", {"units", "distance", "retract"}, findings);
  start.choice("units", {"mm", "inch", "stated"}, profile.start.units);
  start.choice("distance", {"absolute", "incremental", "stated"}, profile.start.distance);
  start.choice("retract", "r", "initial", profile.start.retract_to_r);
  const Section offsets(root, "offsets", {"fixed", "further", "l20", "p0", "keeps_shift"}, findings);
  offsets.whole("further", profile.offsets.further, 0, kMostFurtherOffsets);
  offsets.whole("fixed", profile.offsets.fixed, 1, kFixedOffsets);
  offsets.flag("keeps_shift", profile.offsets.keeps_shift);
  offsets.choice("l20", "reads", "further", profile.offsets.l20_reads);
  offsets.choice("p0", "active", "external", profile.offsets.p0_active);
  const Section motion(root, "motion", {"home_beside_motion", "rapid_straight", "rotary_feed"}, findings);
  motion.flag("home_beside_motion", profile.home_beside_motion);
  motion.flag("rapid_straight", profile.rapid_straight);
  motion.choice("rotary_feed", "linear", "unsure", profile.feed_of_linear);
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
    use.after = use.after || use.meaning == Meaning::stop || use.meaning == Meaning::end || use.meaning == Meaning::call_subprogram || use.meaning == Meaning::end_subprogram;
    profile.letters |= use.words;
  }
}

void apply(const TomlNode& root, Profile& profile, Findings& findings) {
  const auto text = [&](const char* key, std::string& value) {
    if (const TomlEntry* entry = root.find(key)) value = read_text(entry->value, key, findings).value_or(value);
  };
  text("title", profile.title);
  text("about", profile.about);
  if (const TomlEntry* sources = root.find("sources"); sources != nullptr && expect_kind(sources->value, TomlNode::Kind::array, "sources", findings)) {
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
bool read_layer(const std::string& file, std::string_view text, int depth, Profile& profile, Diagnostics& out) {
  Findings findings(file, text, out);
  if (text.size() > kLargestProfile) {
    findings.error("E-FILE", {}, fmt::format("{} bytes are too many for a profile", text.size()), "", "check that the right file is named");
    return false;
  }
  const auto root = read_toml(text, findings);
  if (!root) return false;
  refuse_other_keys(*root, kTables, "the profile", findings);
  const TomlEntry* format = root->find("format");
  if (format == nullptr || format->value.kind != TomlNode::Kind::number || !format->value.is_integer || format->value.integer != 1) {
    findings.error("E-FORMAT", format == nullptr ? Mark{1, 1, 1} : format->value.mark, "format = 1 is missing", "formats may change; the number says how to read the file",
                   "begin the file with format = 1");
  }
  if (const TomlEntry* extends = root->find("extends")) {
    const auto names = embedded_profile_names();
    const auto at = read_choice(extends->value, names, "extends", findings);
    if (!at || depth == kDeepestExtends) return false;
    if (!read_layer(names[*at] + ".toml", embedded_text(names[*at]), depth + 1, profile, out)) return false;
  } else if (root->find("codes") == nullptr) {
    findings.error("E-MISSING-KEY", Mark{1, 1, 1}, "no [codes] and no extends", "without codes every program is refused",
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
      if (parsed.value) read.emplace(embedded.name, std::make_shared<const Profile>(std::move(*parsed.value)));
    }
    return read;
  }();
  const auto found = all.find(name);
  return found == all.end() ? nullptr : found->second;
}

}  // namespace abbe
