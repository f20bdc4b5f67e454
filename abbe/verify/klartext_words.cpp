// Lines of conversational programs. A line is cut into items at its blanks; the first says what the block
// does, and every other one must have a place in it.
#include "abbe/verify/klartext_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "abbe/core/number.h"
#include "abbe/verify/word_taker.h"

namespace abbe::verifying {
namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kDigits = "0123456789";

std::string_view stripped(std::string_view text) {
  const auto begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  return text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
}

bool goes_on(std::string_view line) {
  const std::string_view said = stripped(line);
  return !said.empty() && said.back() == '~';
}

bool begins(std::string_view text, std::string_view with) { return text.substr(0, with.size()) == with; }

bool is_hole(std::string_view cycle) {
  return cycle.size() == 3 && begins(cycle, "20") && kDigits.find(cycle[2]) != std::string_view::npos;
}

bool begins_q_word(std::string_view text) {
  return text.size() > 1 && text[0] == 'Q' && kDigits.find(text[1]) != std::string_view::npos;
}

class KlartextScanner : public WordTaker {
 public:
  using WordTaker::WordTaker;

  bool scan(Continued continued) {
    long number = -1;
    std::string_view rest = continued.open ? line_ : behind_block_number(line_, number);
    rest = stripped(rest);
    if (!rest.empty() && rest.back() == '~') rest.remove_suffix(1);
    const auto semicolon = rest.find(';');
    const bool q_words = continued.hole != 0 && (continued.open || begins_q_word(rest));
    if (rest.substr(0, 1) == "*" || semicolon == 0 || (continued.open && !continued.preset && !q_words))
      return keep_text(stripped(rest));
    if (semicolon != std::string_view::npos) {
      if (!keep_text(stripped(rest.substr(semicolon)))) return false;
      rest = rest.substr(0, semicolon);
    }
    rest = stripped(rest);
    if (q_words) return hole_words(continued.hole, rest);
    if (rest.empty()) return !continued.preset || goes_on(line_) || lacks_preset(line_.substr(0, 1));
    whole_ = rest;
    if (!cut(rest)) return false;
    if (continued.open) return preset(0);
    const bool followed =
        items_[0] == "BLK" || (items_[0] == "CYCL" && (item(2) == "247" || is_hole(item(2))));
    if (goes_on(line_) && !followed)
      return bad(items_[0], "E-BLOCK", "a block that goes on in the next line",
                 "what stands there would not be read", "write it in one line");
    return block();
  }

 private:
  static constexpr std::size_t kMostItems = 40;

  bool keep_text(std::string_view text) {
    if (text.empty()) return true;
    block_.comments[static_cast<std::size_t>(block_.comment_count++)] = text;
    return true;
  }
  /// The column of an item, from 1; at_ is put behind it.
  std::size_t column(std::string_view item) {
    const auto begin = static_cast<std::size_t>(item.data() - line_.data());
    at_ = begin + item.size();
    return begin + 1;
  }
  bool bad(std::string_view item, const char* code, std::string message, const char* why, const char* fix) {
    const std::size_t place = column(item);
    return refuse(fault_, place, std::max<std::size_t>(1, item.size()), code, std::move(message), why, fix);
  }
  bool cut(std::string_view rest) {
    for (std::size_t at = 0; at < rest.size();) {
      at = rest.find_first_not_of(kBlanks, at);
      if (at == std::string_view::npos) break;
      const std::size_t end = std::min(rest.size(), rest.find_first_of(kBlanks, at));
      if (count_ == kMostItems)
        return bad(rest.substr(at, 1), "E-BLOCK", "too many words in a block",
                   "no control accepts such a block", "use two blocks");
      items_[count_++] = rest.substr(at, end - at);
      at = end;
    }
    return true;
  }
  [[nodiscard]] std::string_view item(std::size_t i) const {
    return i < count_ ? items_[i] : std::string_view();
  }

  bool block() {
    const std::string_view first = items_[0];
    if (first == "L") return line();
    if (first == "C") return arc(false);
    if (first == "CR") return arc(true);
    if (first == "CC") return pole();
    if (first == "TOOL" && item(1) == "CALL") return tool_call();
    if (first == "TOOL" && item(1) == "DEF") {
      const bool number_only = count_ == 3 && item(2).find_first_not_of(kDigits) == std::string_view::npos;
      return number_only ? keep_text(whole_) : tool_data();
    }
    if (first == "PLANE") return plane();
    if (first == "LBL" || (first == "CALL" && item(1) == "LBL")) return label(first == "CALL");
    if (whole_is({"FUNCTION", "RESET", "TCPM"})) return m_word(129, column(first));
    if (whole_is({"FUNCTION", "TCPM", "F", "TCP", "AXIS", "POS", "PATHCTRL", "AXIS"}) ||
        whole_is({"FUNCTION", "TCPM", "F", "TCP", "AXIS", "POS", "PATHCTRL", "AXIS", "REFPNT", "TIP-TIP"}))
      return m_word(128, column(first));
    if ((first == "CYCL" || first == "CYCLE") && item(1) == "DEF") return definition();
    if (first == "CYCL" && item(1) == "CALL") {
      column(items_[1]);
      return m_word(99, 1) && functions(2);
    }
    if ((first == "BEGIN" || first == "END") && item(1) == "PGM") return limit(first);
    if (first == "BLK") return keep_text(whole_);
    if (first == "STOP") {
      column(first);
      return m_word(0, 1) && functions(1);
    }
    if (first[0] == 'M') return functions(0);
    return unknown(first);
  }

  [[nodiscard]] bool whole_is(std::initializer_list<std::string_view> words) const {
    return count_ == words.size() && std::equal(words.begin(), words.end(), items_.begin());
  }
  /// A block that is one code, by the name that the profile has for it.
  bool named(std::string_view said, const char* name) {
    const Profile::Keyword* word = find_keyword(profile_, name);
    return word != nullptr ? keyword(*word, whole_, column(said)) : unknown(said);
  }

  /// "5" or "\"NAME\"" behind LBL or CALL LBL; nothing may follow, REP least of all.
  bool label(bool called) {
    const std::string_view first = item(called ? 2 : 1);
    const auto from = first.empty() ? whole_.size() : static_cast<std::size_t>(first.data() - whole_.data());
    const std::string_view said = whole_.substr(from);
    const bool number = !said.empty() && said.find_first_not_of(kDigits) == std::string_view::npos;
    const bool quoted = said.size() > 2 && said[0] == '"' && said.find('"', 1) + 1 == said.size();
    const bool zero = number && said.find_first_not_of('0') == std::string_view::npos;
    if ((!number && !quoted) || (called && zero))
      return bad(items_[0], "E-OWORD", "a label or call that is more than its name",
                 "what runs, and how often, is not known", "expand repeats and calls");
    block_.flow = called ? Block::Flow::call : zero ? Block::Flow::end : Block::Flow::label;
    block_.label = said;
    return keep_text(whole_);
  }

  /// "TOOL DEF 5 L+10 R+3".
  bool tool_data() {
    block_.tool_data = true;
    std::size_t i = 2;
    for (const char letter : {'T', 'L', 'R'}) {
      const std::string_view said = item(i);
      if (said.empty() || (letter != 'T' && said[0] != letter)) continue;
      std::string_view digits = said.substr(letter == 'T' ? 0 : 1);
      if (digits.empty()) digits = item(++i);
      double value = 0;
      if (!number(digits, said, value) || !value_word(letter, value, column(said), false)) return false;
      ++i;
    }
    constexpr Letters tool = letters('T');
    if (i == count_ && block_.has('T') && block_.words != tool) return keep_text(whole_);
    return bad(items_[0], "E-TOOL", "TOOL DEF with other words than a number, L and R",
               "the tool may be another one", "write TOOL DEF n L.. R..");
  }

  /// The rest of an M code that has words of its own, from item i on; `i` becomes the last of them.
  bool points(std::size_t& i, std::string_view said) {
    const Profile::Keyword* word = find_keyword(profile_, "MPOINTS");
    if (word == nullptr) return unknown(said);
    std::string_view end = items_[i];
    if (item(i + 1).substr(0, 1) == "T") {
      std::string_view digits = items_[++i].substr(1);
      if (digits.empty()) digits = item(++i);
      double value = 0;
      if (!number(digits, said, value)) return false;
      end = items_[std::min(i, count_ - 1)];
    }
    return keyword(*word, from_to(said, end), column(said));
  }
  bool retract(std::size_t& i, std::string_view said) {
    const std::string_view by = item(i + 1);
    std::string_view way = by.substr(std::min<std::size_t>(2, by.size()));
    i += 1;
    if (way.empty()) way = item(++i);
    double value = 0;
    const bool read = way == "MAX" || (!way.empty() && number(way, said, value));
    if (!begins(by, "MB") || !read || i + 1 != count_)
      return bad(said, "E-MCODE", "M140 in another form", "where the tool goes is not sure",
                 "write M140 MB MAX or MB and a number at the end");
    const std::string_view text = from_to(said, items_[i]);
    return keep_text(text) && m_word(140, column(said));
  }
  [[nodiscard]] static std::string_view from_to(std::string_view first, std::string_view last) {
    return {first.data(), static_cast<std::size_t>(last.data() - first.data()) + last.size()};
  }

  bool unknown(std::string_view said) {
    std::size_t length = 0;
    while (length < said.size() && said[length] >= 'A' && said[length] <= 'Z') ++length;
    const std::string_view name = said.substr(0, length);
    column(said);
    if (const Profile::Keyword* word = find_keyword(profile_, name);
        word != nullptr && profile_.g[word->index].refusal != 0)
      return keyword(*word, name, column(said));
    if (name == "Q")
      return bad(said, "E-EXPR", "variables are not read", "their value is known only to the control",
                 "post the program with literal numbers");
    return bad(said, "E-GCODE", fmt::format("{} is not understood for {}", said, profile_.title),
               "an unknown word may move the machine or change its state", "post the program without it");
  }

  /// A literal number that is the whole of `digits`, with a point or a comma. `of`: the item it belongs to.
  bool number(std::string_view digits, std::string_view of, double& value) {
    std::string text(digits.substr(0, 40));
    std::replace(text.begin(), text.end(), ',', '.');
    const Decimal read = read_decimal(text);
    if (read.length == 0 || read.length != digits.size())
      return bad(of, "E-EXPR", fmt::format("{} has no literal number", of),
                 "its value is known only to the control", "post the program with literal numbers");
    value = read.value;
    if (std::abs(value) <= kMaxNumber) return true;
    return bad(of, "E-NUMBER", "the number is too large", "no machine goes there", "correct the number");
  }

  /// Coordinates from item i on, which becomes the first that is none.
  bool coordinates(std::size_t& i, std::string_view letters) {
    for (; i < count_; ++i) {
      std::string_view said = items_[i];
      const bool distance = said[0] == 'I';
      if (distance) said.remove_prefix(1);
      const bool named = !said.empty() && letters.find(said[0]) != std::string_view::npos &&
                         (said.size() == 1 || said[1] < 'A' || said[1] > 'Z');
      if (!named) return true;
      const char letter = said[0];
      std::string_view digits = said.substr(1);
      if (digits.empty()) digits = item(++i);
      double value = 0;
      if (!number(digits, said, value)) return false;
      if (distance) {
        if (letter < 'X')
          return bad(said, "E-ROTARY", "an increment of a rotary axis", "its whole turns are not sure",
                     "post the angle itself");
        block_.increments |= std::uint32_t{1} << (letter - 'X');
      }
      if (!value_word(letter, value, column(said), false)) return false;
    }
    return true;
  }

  bool line() {
    std::size_t i = 1;
    if (!coordinates(i, "XYZABC")) return false;
    const bool rapid = std::find(items_.begin() + static_cast<std::ptrdiff_t>(i),
                                 items_.begin() + static_cast<std::ptrdiff_t>(count_),
                                 "FMAX") != items_.begin() + static_cast<std::ptrdiff_t>(count_);
    return g_word(rapid ? 0 : 1, column(items_[0])) && functions(i, true);
  }

  bool arc(bool by_radius) {
    std::size_t i = 1;
    if (!coordinates(i, "XYZ")) return false;
    if (by_radius) {
      double radius = 0;
      if (item(i).substr(0, 1) != "R")
        return bad(items_[0], "E-ARC", "CR without its radius", "no arc is defined", "add R");
      std::string_view digits = items_[i].substr(1);
      if (digits.empty()) digits = item(++i);
      if (!number(digits, items_[0], radius) || !value_word('R', radius, column(items_[0]), false))
        return false;
      ++i;
    } else {
      block_.pole = Block::Pole::used;
    }
    const std::string_view sense = item(i);
    if (sense != "DR+" && sense != "DR-")
      return bad(items_[0], "E-ARC", "the sense of the arc is not stated with its end",
                 "it depends on the blocks before", "write DR+ or DR-");
    return g_word(sense == "DR-" ? 2 : 3, column(items_[0])) && functions(i + 1);
  }

  bool pole() {
    std::size_t i = 1;
    const bool read = coordinates(i, "XY");
    if (!read) return false;
    constexpr Letters both = letters('X', 'Y');
    if (i != count_ || block_.words != both || block_.increments != 0)
      return bad(items_[0], "E-ARC", "CC is read with X and Y as places only",
                 "the pole depends on the blocks before otherwise", "write CC X.. Y..");
    block_.pole = Block::Pole::set;
    return true;
  }

  /// R0, RL, RR, F, FMAX (of L), F AUTO, S, M from item i on.
  bool functions(std::size_t i, bool may_be_rapid = false) {
    int feeds = 0;
    for (; i < count_; ++i) {
      const std::string_view said = items_[i];
      double value = 0;
      if (said[0] == 'F' && ++feeds > 1)
        return bad(said, "E-FEED", "two feeds in a block", "it is not defined which one holds", "keep one");
      if (said == "R0") {
        if (!g_word(40, column(said))) return false;
      } else if (said == "RL" || said == "RR") {
        if (!g_word(said[1] == 'L' ? 41 : 42, column(said))) return false;
      } else if (said == "FMAX" && may_be_rapid) {
        continue;
      } else if (said == "FMAX") {
        return bad(said, "E-FEED", "FMAX on an arc", "the control may not obey", "give a feed");
      } else if (said == "FAUTO" || (said == "F" && item(i + 1) == "AUTO")) {
        const Profile::Keyword* word = find_keyword(profile_, "AUTO");
        if (word == nullptr) return unknown(said);
        if (said == "F") ++i;
        if (!keyword(*word, "AUTO", column(said))) return false;
      } else if (said[0] == 'F' || said[0] == 'S' || said[0] == 'M') {
        std::string_view digits = said.substr(1);
        if (!digits.empty() && digits[0] >= 'A' && digits[0] <= 'Z' && digits[0] != 'Q') return unknown(said);
        if (digits.empty()) digits = item(++i);
        if (!number(digits, said, value)) return false;
        if (said[0] == 'M' && (value == 124 || value == 140)) {
          if (!(value == 124 ? points(i, said) : retract(i, said))) return false;
          continue;
        }
        if (said[0] == 'M' ? !function(value, said) : !value_word(said[0], value, column(said), false))
          return false;
      } else {
        return unknown(said);
      }
    }
    return true;
  }
  bool function(double code, std::string_view said) {
    constexpr double machine_places = 91;
    if (code != machine_places) return m_word(code, column(said));
    if (block_.increments != 0)
      return bad(said, "E-G53", "increments with M91", "they count from another block", "write places");
    return g_word(28, column(said));  // a way to a place of the machine's own
  }

  bool tool_call() {
    std::size_t i = 2;
    const std::string_view tool = item(2);
    if (!tool.empty() && tool[0] == '"') {
      const auto open = static_cast<std::size_t>(tool.data() - line_.data());
      const auto close = line_.find('"', open + 1);
      const auto whole_end = static_cast<std::size_t>(whole_.data() - line_.data()) + whole_.size();
      if (close == std::string_view::npos || close >= whole_end)
        return bad(tool, "E-TOOL", "a tool's name that does not end", "the tool is not known", "close it");
      block_.tool_name = line_.substr(open + 1, close - open - 1);
      while (i < count_ && static_cast<std::size_t>(items_[i].data() - line_.data()) <= close) ++i;
      at_ = close + 1;
      if (!value_word('T', 0, open + 1, false) || !m_word(6, 1) || !g_word(43, 1)) return false;
    } else if (!tool.empty() && kDigits.find(tool[0]) != std::string_view::npos) {
      double value = 0;
      if (!number(tool, tool, value) || !value_word('T', value, column(tool), false) || !m_word(6, 1) ||
          !g_word(value == 0 ? 49 : 43, 1))
        return false;
      ++i;
    }
    for (; i < count_; ++i) {
      const std::string_view said = items_[i];
      double value = 0;
      if (said == "Z") continue;
      const bool allowance = begins(said, "DL") || begins(said, "DR");
      if (!allowance && said[0] != 'S' && said[0] != 'F')
        return bad(said, "E-TOOL", fmt::format("{} in TOOL CALL", said), "the tool may be another one",
                   "write TOOL CALL n Z S.. F..");
      std::string_view digits = said.substr(allowance ? 2 : 1);
      if (digits.empty()) digits = item(++i);
      if (!number(digits, said, value)) return false;
      if (allowance && value != 0)
        return bad(said, "E-TOOL", "an allowance of the tool", "its length is not that of the table",
                   "put it into the table");
      if (!allowance && !value_word(said[0], value, column(said), false)) return false;
    }
    return true;
  }

  bool limit(std::string_view first) {
    const std::string_view unit = items_[count_ - 1];
    if (count_ < 3 || (unit != "MM" && unit != "INCH"))
      return bad(first, "E-START", "the unit of the program is not stated",
                 "its numbers mean nothing without", "write BEGIN PGM name MM or INCH");
    if (first == "END") return m_word(2, column(first));
    return g_word(unit == "MM" ? 21 : 20, column(first));
  }

  /// PLANE SPATIAL with its three angles, PLANE RESET; STAY, TURN or MOVE, and how the control gets there.
  bool plane() {
    const Profile::Keyword* word = find_keyword(profile_, item(1));
    const Meaning meaning = word != nullptr ? profile_.g[word->index].meaning : Meaning::unknown;
    const bool spatial = meaning == Meaning::spatial_plane;
    if (!spatial && meaning != Meaning::plane_off)
      return bad(items_[0], "E-PLANE", "another plane than PLANE SPATIAL", "where it lies is not followed",
                 "post PLANE SPATIAL");
    bool by_table = false;
    for (std::size_t i = 2; i < count_; ++i) {
      const std::string_view said = items_[i];
      const bool rot = (said == "COORD" || said == "TABLE") && item(i + 1) == "ROT";
      double value = 0;
      if (said == "STAY" || said == "TURN" || said == "MOVE") {
        if (!value_word('P', said == "STAY" ? 0 : 1, column(said), false)) return false;
      } else if (said == "SEQ+" || said == "SEQ-") {
        if (!value_word('Q', said == "SEQ+" ? 1 : -1, column(said), false)) return false;
      } else if (rot) {
        by_table = by_table || said == "TABLE";
        ++i;
      } else if (begins(said, "SPA") || begins(said, "SPB") || begins(said, "SPC")) {
        const std::string_view digits = said.size() > 3 ? said.substr(3) : item(++i);
        if (!number(digits, said, value) ||
            !value_word(static_cast<char>(said[2] - 'A' + 'I'), value, column(said), false))
          return false;
      } else if (said != "FMAX") {
        const std::size_t letters_of = begins(said, "DIST") ? 4 : begins(said, "F") ? 1 : 0;
        if (letters_of == 0) return unknown(said);
        const std::string_view digits = said.size() > letters_of ? said.substr(letters_of) : item(++i);
        if (!number(digits, said, value)) return false;
      }
    }
    const Letters needed = spatial ? letters('I', 'J', 'K', 'P') : letter_bit('P');
    const bool turns = block_.has('P') && block_['P'] != 0;
    if ((block_.words & needed) != needed || (!spatial && (block_.words & letters('I', 'J', 'K')) != 0) ||
        (turns && by_table))
      return bad(items_[0], "E-PLANE", "a plane without its angles or without STAY, TURN or MOVE",
                 "where the rotary axes go is not known", "write SPA.. SPB.. SPC.. STAY");
    return keyword(*word, "", column(items_[0]));
  }

  bool definition() {
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
    const int of_parts =
        meaning == Meaning::hole_cycle && cycle.size() < 3 ? std::stoi(std::string(cycle)) : 0;
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
  bool datum_frame(const Profile::Keyword& word, Meaning meaning) {
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

  bool lacks_preset(std::string_view at) {
    return bad(at, "E-WCS", "CYCL DEF 247 says no preset", "the frame is not known", "write Q339=+1");
  }

  /// "CYCL DEF 1.0 PECKING", "CYCL DEF 1.1 SET UP 2": the number at the end, behind a name in any language.
  bool hole_line(int cycle, int number_of_line) {
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
    bool variable =
        digits == std::string_view::npos || strange(name) || (!name.empty() && name.back() == '.');
    for (std::size_t i = 3; i + 1 < count_; ++i) variable = variable || strange(items_[i]);
    double value = 0;
    if (variable)
      return bad(items_[0], "E-EXPR", "a line of a cycle that does not end with a literal number",
                 "its value is known only to the control", "post literal numbers");
    return number(last.substr(digits), last, value) && block_.hole.take(number_of_line, value);
  }

  /// "Q200=+2 Q201 = -10,5": one name and value after the other, wherever blanks stand.
  bool hole_words(int cycle, std::string_view rest) {
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
  bool preset(std::size_t i) {
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

  std::string_view whole_;
  std::array<std::string_view, kMostItems> items_;
  std::size_t count_ = 0;
};

}  // namespace

std::string_view behind_block_number(std::string_view line, long& number) {
  number = -1;
  const auto begin = line.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  const auto end = std::min(line.size(), line.find_first_not_of(kDigits, begin));
  if (end == begin || end - begin > 9) return line.substr(begin);
  number = 0;
  for (std::size_t i = begin; i < end; ++i) number = 10 * number + (line[i] - '0');
  return stripped(line.substr(end));
}

Continued continued_after(std::string_view line, Continued before) {
  Continued after;
  after.open = goes_on(line);
  if (before.open) {  // the same block
    after.preset = after.open && before.preset;
    after.hole = before.hole;
    return after;
  }
  if (before.hole != 0 && begins_q_word(stripped(line))) {
    after.hole = before.hole;
    return after;
  }
  long number = 0;
  const std::string_view words = behind_block_number(line, number);
  const bool cycle = begins(words, "CYCL DEF ") || begins(words, "CYCLE DEF ");
  if (!cycle) return after;
  const std::string_view title = stripped(words.substr(words.find("DEF ") + 4));
  const std::string_view said = title.substr(0, title.find_first_of(" \t;~"));
  after.preset = after.open && said == "247";
  if (is_hole(said)) after.hole = 200 + (said[2] - '0');
  return after;
}

bool read_klartext_words(std::string_view line, const Profile& profile, Continued continued, Block& block,
                         Fault& fault, std::span<const TcpCode> tcp_codes) {
  block.tool_name = {};
  if (line.size() > profile.text.block_bytes)
    return refuse(fault, profile.text.block_bytes + 1, 1, "E-LINELEN",
                  fmt::format("the line has {} bytes, {} are read", line.size(), profile.text.block_bytes),
                  "longer lines are not read", "shorten the line");
  return KlartextScanner(line, 0, profile, block, fault, tcp_codes).scan(continued);
}

}  // namespace abbe::verifying
