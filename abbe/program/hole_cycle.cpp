#include "abbe/program/hole_cycle.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <span>
#include <utility>

#include "abbe/program/klartext_number.h"
#include "abbe/program/klartext_scan.h"

namespace abbe {
namespace {

// The words of each cycle. Those before the zero must stand there: they say where the hole is.
constexpr std::array kDrill = {200, 201, 203, 204, 0, 206, 202, 210, 211, 395};
constexpr std::array kReam = {200, 201, 203, 204, 0, 206, 211, 208};
constexpr std::array kBore = {200, 201, 203, 204, 0, 206, 211, 208, 214, 336};
constexpr std::array kUniversal = {200, 201, 203, 204, 0, 206, 202, 210, 212, 213, 205, 211, 208, 256, 395};
constexpr std::array kBackBore = {200, 249, 250, 251, 252, 203, 204, 214, 0, 253, 254, 255, 336};
constexpr std::array kPeck = {200, 201, 203, 204, 0,   206, 202, 212, 205,
                              258, 259, 257, 256, 211, 379, 253, 208, 395};
constexpr std::array kFloatingTap = {200, 201, 203, 204, 0, 206, 211};
constexpr std::array kTap = {200, 201, 203, 204, 0, 239};
constexpr std::array kBoreMill = {200, 201, 203, 204, 335, 0, 206, 334, 342, 351};
constexpr std::array kChipTap = {200, 201, 203, 204, 0, 239, 257, 256, 336, 403};
constexpr std::array<std::span<const int>, 10> kWords = {kDrill, kReam,        kBore, kUniversal, kBackBore,
                                                         kPeck,  kFloatingTap, kTap,  kBoreMill,  kChipTap};
constexpr int kFirst = 200;
// Of the older ones: set-up clearance, depth; then pecking depth, dwell and feed; dwell and feed; pitch.
constexpr std::array kOldPeck = {1, 2, 3, 4, 5};
constexpr std::array kOldTap = {1, 2, 3, 4};
constexpr std::array kOldRigidTap = {1, 2, 3};
constexpr int kPecking = 1, kTapping = 2, kRigidTapping = 17;
constexpr int kSetUp = 1, kDepth = 2;
constexpr int kFromBehind = 204, kMilled = 208;
// Feeds may be named.
constexpr std::array kFeeds = {206, 208, 253, 254};
constexpr std::array<std::string_view, 4> kNamedFeeds = {"FAUTO", "AUTO", "FMAX", "MAX"};

std::span<const int> words_of(int cycle) {
  switch (cycle) {
    case kPecking:
      return kOldPeck;
    case kTapping:
      return kOldTap;
    case kRigidTapping:
      return kOldRigidTap;
    default:
      return kWords[static_cast<std::size_t>(cycle - kFirst)];
  }
}

/// The name of a feed at the start of `text`, or nothing.
std::string_view named_feed(int parameter, std::string_view text) {
  if (std::find(kFeeds.begin(), kFeeds.end(), parameter) == kFeeds.end()) return {};
  const auto blank = std::find_if(text.begin(), text.end(), is_blank);
  const std::string_view word = text.substr(0, static_cast<std::size_t>(blank - text.begin()));
  const bool known = std::find(kNamedFeeds.begin(), kNamedFeeds.end(), word) != kNamedFeeds.end();
  return known ? word : std::string_view();
}

BlockError refused(const char* code, std::size_t at, std::size_t length, std::string message,
                   const char* fix) {
  return {code,
          at,
          std::max<std::size_t>(1, length),
          std::move(message),
          "where the control moves in the cycle depends on it",
          fix};
}

/// One more word with the letter Q; there is room. `begin`: of the word, `at`: of its number.
void add_value(Block& block, int parameter, std::size_t begin, std::size_t at, const KlartextNumber& number) {
  const auto i = static_cast<std::size_t>(block.count++);
  block.parameters[i] = static_cast<std::uint16_t>(parameter);
  block.words[i] = {'Q',
                    true,
                    static_cast<std::uint16_t>(begin),
                    static_cast<std::uint16_t>(at),
                    static_cast<std::uint16_t>(at + number.length),
                    static_cast<std::uint16_t>(number.decimals),
                    number.value};
}

}  // namespace

const HoleDefinition::Word* HoleDefinition::find(int parameter) const {
  const auto found =
      std::find_if(words.begin(), words.end(), [&](const Word& word) { return word.parameter == parameter; });
  return found == words.end() ? nullptr : &*found;
}

int hole_cycle_number(std::string_view keyword) {
  constexpr std::string_view begin = "CYCL20";
  const bool known = keyword.size() == begin.size() + 1 && keyword.substr(0, begin.size()) == begin &&
                     is_digit(keyword.back());
  for (const int old : {kPecking, kTapping, kRigidTapping})
    if (keyword == fmt::format("CYCL{}", old)) return old;
  return known ? kFirst + (keyword.back() - '0') : 0;
}

HoleAnswer span_of(const HoleDefinition& definition) {
  for (const int parameter : words_of(definition.cycle)) {
    if (parameter == 0) break;
    if (definition.find(parameter) == nullptr)
      return {std::nullopt,
              has_parts(definition.cycle)
                  ? fmt::format("cycle {0} without its line {0}.{1}", definition.cycle, parameter)
                  : fmt::format("cycle {} without Q{}", definition.cycle, parameter)};
  }
  const auto value = [&](int parameter) {
    const HoleDefinition::Word* word = definition.find(parameter);
    return word != nullptr ? word->value : 0.0;
  };
  const auto unsure = [](const char* what) { return HoleAnswer{std::nullopt, what}; };
  if (has_parts(definition.cycle)) {
    const bool peck = definition.cycle == kPecking, rigid = definition.cycle == kRigidTapping;
    if (value(kSetUp) < 0 || !(value(kDepth) < 0))
      return unsure("a set-up clearance that is negative, or a depth that is not");
    if (rigid  ? value(3) == 0
        : peck ? !(value(3) > 0) || value(4) < 0 || !(value(5) > 0)
               : value(3) < 0 || !(value(4) > 0))
      return unsure("a pecking depth, pitch or feed that is not positive, or a negative dwell");
    HoleSpan span;
    span.from_start = true;
    span.top = -value(kSetUp);
    span.bottom = span.top + value(kDepth);
    return {span, {}};
  }
  const double above = value(200), second = value(204), surface = value(kSurface);
  if (above < 0 || second < 0 || (second > 0 && second < above))
    return unsure("a set-up clearance Q200 or Q204 that is negative, or Q204 below Q200");
  if (value(395) != 0) return unsure("Q395 counts the depth from another point than the tip");
  HoleSpan span;
  span.top = surface + above;
  span.clear = surface + std::max(above, second);
  if (definition.cycle == kFromBehind) {
    if (!(value(249) > 0 && value(250) > 0) || value(251) < 0 || value(252) < 0)
      return unsure("Q249, Q250, Q251 or Q252 that is no length");
    // below the plate by the clearance, and the tip below the edge
    span.bottom = surface - value(250) - above - value(252);
    span.aside = value(251);
    return {span, {}};
  }
  if (!(value(201) < 0)) return unsure("a depth Q201 that is not negative");
  span.bottom = surface + value(201);
  if (definition.cycle == kMilled) {
    if (!(value(335) > 0)) return unsure("a diameter Q335 that is not positive");
    span.aside = value(335) / 2;
  }
  return {span, {}};
}

std::optional<BlockError> read_hole_words(int cycle, std::size_t at, std::size_t end, bool& comma,
                                          Block& block) {
  const std::string_view text = block.text.substr(0, end);
  const auto skip = [&] {
    while (at < end && is_blank(text[at])) ++at;
  };
  for (skip(); at < end; skip()) {
    const std::size_t begin = at;
    int parameter = 0;
    for (++at; at < end && is_digit(text[at]) && parameter < 1000; ++at)
      parameter = 10 * parameter + (text[at] - '0');
    const std::string_view name = text.substr(begin, at - begin);
    const std::span<const int> known = words_of(cycle);
    if (text[begin] != 'Q' || parameter == 0 ||
        std::find(known.begin(), known.end(), parameter) == known.end())
      return refused("E-CYCLE", begin, name.size(), fmt::format("{} is no word of cycle {}", name, cycle),
                     "write the Q words of the cycle as the control does");
    const auto same = [&](int i) { return block.parameters[static_cast<std::size_t>(i)] == parameter; };
    for (int i = 0; i < block.count; ++i)
      if (same(i)) return refused("E-CYCLE", begin, name.size(), fmt::format("{} twice", name), "keep one");
    skip();
    const bool assigned = at < end && text[at] == '=';
    if (assigned) ++at;
    skip();
    KlartextNumber number = read_klartext_number(text.substr(at));
    if (number.length == 0) {
      number = {-1, 0, named_feed(parameter, text.substr(at)).size(), false};
    } else if (std::find(kFeeds.begin(), kFeeds.end(), parameter) != kFeeds.end() && number.value < 0) {
      number.length = 0;  // no feed
    }
    if (!assigned || number.length == 0)
      return refused("E-EXPR", begin, at - begin + 1, fmt::format("{} without a literal number", name),
                     "post the cycle with literal numbers (Q parameters resolved)");
    if (block.count == Block::kMaxWords)
      return refused("E-BLOCK", begin, 1, "too many words in one line", "break the line into several");
    comma = comma || number.comma;
    add_value(block, parameter, begin, at, number);
    at += number.length;
  }
  return std::nullopt;
}

std::optional<BlockError> read_hole_value(int cycle, int part, std::size_t at, std::size_t end, bool& comma,
                                          Block& block) {
  const std::span<const int> known = words_of(cycle);
  if (std::find(known.begin(), known.end(), part) == known.end())
    return refused("E-CYCLE", 0, end, fmt::format("cycle {} has no line {}.{}", cycle, cycle, part),
                   "write the lines of the cycle as the control does");
  // Q5, or a name in which a variable could hide, is no number: "SET UP Q1"
  const std::string_view text = block.text.substr(0, end);
  const std::size_t begin = at;
  const auto of_name = [](char c) { return is_letter(c) || is_blank(c) || c == '.'; };
  while (at < end && of_name(text[at]) && text[at] != 'Q') ++at;
  const bool point = at > begin && text[at - 1] == '.';  // ".5" behind a name, or the end of a short one
  const KlartextNumber number = read_klartext_number(text.substr(at));
  if (number.length == 0 || at + number.length != end || point)
    return refused("E-EXPR", begin, end - begin,
                   fmt::format("CYCL DEF {}.{} without a literal number", cycle, part),
                   "post the cycle with literal numbers (Q parameters resolved)");
  comma = comma || number.comma;
  add_value(block, part, begin, at, number);
  return std::nullopt;
}

}  // namespace abbe
