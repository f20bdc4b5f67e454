// Definitions of cycles in conversational programs.
#include "abbe/verify/klartext_cycles.h"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "abbe/core/number.h"

namespace abbe::verifying {

bool KlartextCycles::definition() {
  const std::string_view number_and_part = item(2);
  const auto point = number_and_part.find('.');
  const std::string_view cycle = number_and_part.substr(0, point);
  const std::string_view part =
      point == std::string_view::npos ? std::string_view("-") : number_and_part.substr(point + 1);
  const Profile::Keyword* word = find_keyword(profile_, "CYCL" + std::string(cycle));
  const bool understood = word != nullptr && !cycle.empty() &&
                          cycle.find_first_not_of(kDigits) == std::string_view::npos && part.size() == 1;
  if (!understood)
    return bad(items_[0], "E-CYCLE", "a cycle that is not known", "it may move the machine or its frame",
               "post without it");
  const Meaning meaning = profile_.g[word->index].meaning;
  if (meaning == Meaning::unknown) return keyword(*word, whole_, column(items_[0]));
  const int of_parts = meaning == Meaning::hole_cycle && cycle.size() < 3 ? std::stoi(std::string(cycle)) : 0;
  if (of_lines(of_parts) && part != "-") return hole_line(of_parts, part[0] - '0');
  if (meaning == Meaning::hole_cycle && (part != "-" || !is_hole(cycle)))
    return bad(items_[0], "E-CYCLE", "a drilling cycle in another form", "where it drills is not known",
               "write CYCL DEF and its Q words");
  if (part == "0") return keep_text(whole_);
  if (meaning == Meaning::copy || meaning == Meaning::smoothing)
    return keyword(*word, whole_, column(items_[0]));
  if (meaning == Meaning::numbered_work_offset) {
    std::size_t i = 3;
    while (i < count_ && items_[i][0] != 'Q') ++i;
    return i == count_ ? goes_on(line_) || lacks_preset(items_[0]) : preset(i);
  }
  if (meaning == Meaning::hole_cycle) {
    block_.hole_begins = true;
    std::size_t i = 3;
    while (i < count_ && !begins_q_word(items_[i])) ++i;
    const std::size_t from =
        i < count_ ? static_cast<std::size_t>(items_[i].data() - whole_.data()) : whole_.size();
    return hole_words(200 + (cycle[2] - '0'), whole_.substr(from));
  }
  if (part == "1" && (meaning == Meaning::datum_turn || meaning == Meaning::datum_mirror ||
                      meaning == Meaning::datum_scale || meaning == Meaning::datum_scale_evenly))
    return datum_frame(*word, meaning);
  std::size_t i = 3;
  if (!coordinates(i, "XYZ")) return false;
  const bool one = block_.words != 0 && (block_.words & (block_.words - 1)) == 0;
  if (i != count_ || !one || block_.increments != 0 || meaning != Meaning::local_shift)
    return bad(items_[0], "E-FRAME", "a datum shift of another form", "the frame is not known",
               "shift one axis a line, by a number");
  return keyword(*word, "", column(items_[0]));
}

/// "ROT+35" of 10.1, "X Y" of 8.1, "X1.4 CCX+15" of 26.1, "SCL0.995" of 11.1.
bool KlartextCycles::datum_frame(const Profile::Keyword& word, Meaning meaning) {
  const bool mirrors = meaning == Meaning::datum_mirror, each = meaning == Meaning::datum_scale;
  const auto form = [&] {
    return bad(items_[0], "E-FRAME", "a frame of another form", "the frame is not known",
               "write 10.1 ROT, 8.1 X Y, 26.1 X Y Z CCX CCY or 11.1 SCL");
  };
  std::size_t i = 3;
  for (; i < count_; ++i) {
    const std::string_view said = items_[i];
    const auto digits = std::min(said.size(), said.find_first_of("+-.,0123456789"));
    const std::string_view name = said.substr(0, digits);
    const bool axis = name == "X" || name == "Y" || (name == "Z" && each);
    const bool centre = name == "CCX" || name == "CCY" || name == "CCZ";
    const bool single = i == 3 && (meaning == Meaning::datum_turn ? name == "ROT" : name == "SCL");
    if (mirrors ? !(axis && digits == said.size()) : each ? !(axis || centre) : !single) return form();
    char letter = meaning == Meaning::datum_turn ? 'R' : 'P';
    if (axis) letter = name[0];
    if (centre) letter = static_cast<char>('I' + (name[2] - 'X'));
    double value = 0;
    if (!mirrors && !number(digits < said.size() ? said.substr(digits) : item(++i), said, value))
      return false;
    if (!value_word(letter, value, column(said), false)) return false;
  }
  return i == 3 && !mirrors ? form() : keyword(word, "", column(items_[0]));
}

bool KlartextCycles::lacks_preset(std::string_view at) {
  return bad(at, "E-WCS", "CYCL DEF 247 says no preset", "the frame is not known", "write Q339=+1");
}

/// "CYCL DEF 1.0 PECKING", "CYCL DEF 1.1 SET UP 2": the number at the end, behind a name in any language.
bool KlartextCycles::hole_line(int cycle, int number_of_line) {
  block_.hole.cycle = cycle;
  block_.hole_begins = number_of_line == 0;
  if (block_.hole_begins) return keep_text(whole_);
  const auto known = known_words(cycle);
  if (std::find(known.begin(), known.end(), number_of_line) == known.end())
    return bad(items_[0], "E-CYCLE", fmt::format("cycle {} has no line {}", cycle, number_of_line),
               "what it changes is not known", "write the lines of the cycle");
  std::string_view last = count_ > 3 ? items_[count_ - 1] : std::string_view();
  const auto digits = last.find_first_of("+-0123456789");
  const std::string_view name = last.substr(0, digits);
  const auto strange = [](std::string_view said) {
    return said.find_first_not_of("ABCDEFGHIJKLMNOPRSTUVWXYZ.") != std::string_view::npos;
  };
  bool variable = digits == std::string_view::npos || strange(name) || (!name.empty() && name.back() == '.');
  for (std::size_t i = 3; i + 1 < count_; ++i) variable = variable || strange(items_[i]);
  double value = 0;
  if (variable)
    return bad(items_[0], "E-EXPR", "a line of a cycle that does not end with a literal number",
               "its value is known only to the control", "post literal numbers");
  return number(last.substr(digits), last, value) && block_.hole.take(number_of_line, value);
}

/// "Q200=+2 Q201 = -10,5": one name and value after the other, wherever blanks stand.
bool KlartextCycles::hole_words(int cycle, std::string_view rest) {
  block_.hole.cycle = cycle;
  const auto known = known_words(cycle);
  while (!rest.empty()) {
    const auto next = rest.find('Q', 1);
    const std::string_view word = rest.substr(0, next);
    const auto equals = word.find('=');
    const std::string_view name = stripped(word.substr(0, equals));
    const bool named = name.size() == 4 && begins_q_word(name) &&
                       name.find_first_not_of(kDigits, 1) == std::string_view::npos;
    const int q = named ? std::stoi(std::string(name.substr(1))) : 0;
    if (std::find(known.begin(), known.end(), q) == known.end())
      return bad(name, "E-CYCLE", fmt::format("{} does not belong to cycle {}", name, cycle),
                 "what it changes is not known", "write the words of the cycle");
    if (equals == std::string_view::npos)
      return bad(name, "E-EXPR", fmt::format("{} without a value", name), "it is known only to the control",
                 "post literal numbers");
    const std::string_view said = stripped(word.substr(equals + 1));
    const bool feed = q == 206 || q == 208 || q == 253 || q == 254;
    const bool rapid = said == "MAX" || said == "FMAX";
    double value = rapid ? HoleWords::kRapid : HoleWords::kFeedOfProgram;
    if (!feed || !(rapid || said == "AUTO" || said == "FAUTO")) {
      if (!number(said, name, value)) return false;
      if (feed && value < 0)
        return bad(name, "E-EXPR", "a negative feed", "no feed is negative", "correct it");
    }
    if (!block_.hole.take(q, value))
      return bad(name, "E-CYCLE", fmt::format("{} twice", name), "it is not defined which one holds",
                 "keep one");
    rest = next == std::string_view::npos ? std::string_view() : rest.substr(next);
  }
  return true;
}

/// "Q339=+1", "Q339 = +1".
bool KlartextCycles::preset(std::size_t i) {
  std::string said;
  for (std::size_t k = i; k < count_; ++k) said += items_[k];
  const Profile::Keyword* word = find_keyword(profile_, "CYCL247");
  if (word == nullptr || !begins(said, "Q339="))
    return bad(item(i), "E-WCS", "cycle 247 without Q339", "the frame is not known", "write Q339=+1");
  const std::string digits = said.substr(5);
  const Decimal read = read_decimal(digits);
  if (read.length == 0 || read.length != digits.size())
    return bad(item(i), "E-EXPR", "Q339 is no literal number", "the frame is not known", "write Q339=+1");
  return value_word('P', read.value, column(item(i)), false) && keyword(*word, "", column(item(i)));
}

}  // namespace abbe::verifying
