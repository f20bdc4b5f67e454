// The codes of a control: what they mean, what belongs to them, which are refused.
#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <string>

#include "abbe/machine/profile_sections.h"

namespace abbe {
namespace {

/// Codes of refusals a profile may use.
const std::vector<std::string> kRefusalCodes{"E-GCODE", "E-MCODE", "E-CUTCOM", "E-FRAME", "E-TCP",
                                             "E-CYCLE", "E-EXPR",  "E-OWORD",  "E-ROTARY"};
const std::vector<std::string> kForms{"alone", "empty", "arguments", "value"};  // as Profile::Form
constexpr std::size_t kLongestName = 32;

std::vector<std::string> meaning_names(char kind) {
  std::vector<std::string> names{"unknown"};
  for (const MeaningInfo& info : all_meanings()) {
    if (info.kind == kind && info.meaning != Meaning::unknown) names.emplace_back(info.name);
  }
  return names;
}

std::optional<Meaning> read_meaning(const TomlNode& node, char kind, const std::string& what,
                                    Findings& findings) {
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
  const bool allowed = std::all_of(text.begin(), text.end(),
                                   [&](char c) { return letter(c) || c == '_' || (c >= '0' && c <= '9'); });
  return allowed && text.size() >= 2 && text.size() <= kLongestName && (letter(text[0]) || text[0] == '_');
}

/// A code that is a word, new if the profile has not had it.
Profile::Keyword* keyword_of(std::string_view name, Mark mark, Profile& profile, Findings& findings) {
  auto& words = profile.keywords;
  const auto at = std::lower_bound(words.begin(), words.end(), name,
                                   [](const auto& word, std::string_view key) { return word.name < key; });
  if (at != words.end() && at->name == name) return &*at;
  if (words.size() == Profile::kKeywords) {
    findings.error("E-COUNT", mark, fmt::format("more than {} codes that are words", Profile::kKeywords), "",
                   "leave out what programs do not use");
    return nullptr;
  }
  return &*words.insert(at, {std::string(name), Profile::kGCodes + words.size(), Profile::Form::alone});
}

/// The code that a key or a text names, or E-VALUE.
CodeUse* find_code(std::string_view name, Mark mark, Profile& profile, Findings& findings) {
  const CodeName code = read_code_name(name);
  if (code.kind == 'G') return &profile.g[code.index];
  if (code.kind == 'M') return &profile.m[code.index];
  const bool misspelled =
      name.size() > 1 && (name[0] == 'G' || name[0] == 'M') && name[1] >= '0' && name[1] <= '9';
  if (profile.text.names && is_name(name) && !misspelled) {
    const Profile::Keyword* keyword = keyword_of(name, mark, profile, findings);
    return keyword == nullptr ? nullptr : &profile.g[keyword->index];
  }
  findings.error("E-VALUE", mark, fmt::format("{} is no G or M code", in_quotes(name)),
                 "codes are G0 to G819 with at most one digit after the point, and M0 to M1023; words where "
                 "[text] has names = true",
                 "write \"G59.1\" or M30, in capitals and without leading zeros");
  return nullptr;
}

std::optional<LetterSet> read_letters(const TomlNode& node, const std::string& what, Findings& findings) {
  const auto text = read_text(node, what, findings);
  if (!text) return std::nullopt;
  const bool letters = std::all_of(text->begin(), text->end(), [](char c) {
    return c >= 'A' && c <= 'Z' && c != 'G' && c != 'M' && c != 'N' && c != 'O';
  });
  if (letters) return letter_set(*text);
  findings.error(
      "E-VALUE", node.mark, fmt::format("{} is {}, expected capital letters", what, in_quotes(*text)),
      "they are the words that belong to the code; G M N O belong to no code", "write words = \"PQ\"");
  return std::nullopt;
}

/// What may follow the word of a code; whatever it was before, `alone` if nothing is said.
void read_form(const TomlEntry& entry, bool detailed, Profile& profile, Findings& findings) {
  const TomlEntry* said = detailed ? entry.value.find("form") : nullptr;
  if (read_code_name(entry.key).kind != 0) {
    if (said != nullptr)
      findings.error("E-VALUE", said->mark, fmt::format("{} has a number, and so no form", entry.key), "",
                     "remove form");
    return;
  }
  Profile::Keyword* keyword = keyword_of(entry.key, entry.mark, profile, findings);
  if (keyword == nullptr) return;
  keyword->form = Profile::Form::alone;
  if (said == nullptr) return;
  if (const auto at = read_choice(said->value, kForms, "codes." + entry.key + ".form", findings))
    keyword->form = static_cast<Profile::Form>(*at);
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
      findings.error("E-MISSING-KEY", entry.value.mark, fmt::format("no meaning in {}", what),
                     "it says what the code does",
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
    findings.error("E-MISSING-KEY", entry.value.mark, fmt::format("no number in {}", what),
                   "1 to 9 are G54 to G59.3, 9 + n is the further one n",
                   "write { meaning = \"work-offset\", number = 1 }");
    return;
  }
  const Section none(TomlNode{}, "codes", {}, findings);
  none.read_whole(number->value, what + ".number", use->number, 1, kFixedOffsets + kMostFurtherOffsets);
}

void read_refusal(const TomlNode& table, Profile& profile, Findings& findings) {
  if (!expect_kind(table, TomlNode::Kind::table, "refused", findings)) return;
  refuse_other_keys(table, {"codes", "error", "why", "fix"}, "[[refused]]", findings);
  const auto text = [&](const char* key) {
    const TomlEntry* entry = table.find(key);
    if (entry != nullptr)
      return read_text(entry->value, fmt::format("refused.{}", key), findings).value_or("");
    findings.error("E-MISSING-KEY", table.mark, fmt::format("no {} in [[refused]]", key),
                   "who is refused must learn why and what to do", fmt::format("add {} = \"..\"", key));
    return std::string();
  };
  const TomlEntry* codes = table.find("codes");
  if (codes == nullptr || !expect_kind(codes->value, TomlNode::Kind::array, "refused.codes", findings)) {
    if (codes == nullptr)
      findings.error("E-MISSING-KEY", table.mark, "no codes in [[refused]]", "they are what is refused",
                     "add codes = [\"G41\", \"G42\"]");
    return;
  }
  CodeRefusal refusal{"", text("why"), text("fix")};
  if (const TomlEntry* error = table.find("error")) {
    if (const auto at = read_choice(error->value, kRefusalCodes, "refused.error", findings))
      refusal.error = kRefusalCodes[*at];
  }
  if (profile.refusals.size() == 255) {
    findings.error("E-COUNT", table.mark, "more than 255 [[refused]] tables", "",
                   "put codes with one reason into one table");
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

}  // namespace

void read_codes(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("codes");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, "codes", findings)) return;
  for (const TomlEntry& code : entry->value.entries) {
    if (findings.full()) return;
    read_code(code, profile, findings);
  }
}

/// `CR = "R"`: no letter of an axis, whose words are also added and are spelled by their letter. `A3 = "TX"`:
/// a component of the tool's direction.
void read_addresses(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("addresses");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::table, "addresses", findings)) return;
  const std::vector<std::string> letters{"D", "F", "H", "L", "M", "P", "Q", "R", "S", "T", "TX", "TY", "TZ"};
  const auto letter_of = [&](std::size_t at) {
    return letters[at].size() == 1 ? letters[at][0]
                                   : kVectorLetters[static_cast<std::size_t>(letters[at][1] - 'X')];
  };
  for (const TomlEntry& address : entry->value.entries) {
    const auto at = read_choice(address.value, letters, "addresses." + address.key, findings);
    if (!is_name(address.key)) {
      findings.error("E-VALUE", address.mark, fmt::format("{} is no name of a word", in_quotes(address.key)),
                     "names are two or more capitals and digits", "write CR = \"R\"");
    } else if (at) {
      auto& list = profile.addresses;
      const auto place =
          std::lower_bound(list.begin(), list.end(), address.key,
                           [](const auto& known, const std::string& key) { return known.name < key; });
      if (place != list.end() && place->name == address.key)
        place->letter = letter_of(static_cast<std::size_t>(*at));
      else
        list.insert(place, {address.key, letter_of(static_cast<std::size_t>(*at))});
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

void read_refusals(const TomlNode& root, Profile& profile, Findings& findings) {
  const TomlEntry* entry = root.find("refused");
  if (entry == nullptr || !expect_kind(entry->value, TomlNode::Kind::array, "refused", findings)) return;
  for (const TomlNode& table : entry->value.items) read_refusal(table, profile, findings);
}

}  // namespace abbe
