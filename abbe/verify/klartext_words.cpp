// Lines of conversational programs. A line is cut into items at its blanks; the first says what the block
// does, and every other one must have a place in it.
#include "abbe/verify/klartext_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <string>

#include "abbe/verify/klartext_cycles.h"

namespace abbe::verifying {
namespace {

class KlartextScanner : public KlartextCycles {
 public:
  using KlartextCycles::KlartextCycles;

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
