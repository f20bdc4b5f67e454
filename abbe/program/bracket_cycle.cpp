#include "abbe/program/bracket_cycle.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/core/number.h"

namespace abbe {
namespace {

enum Place : std::size_t { kClear, kSurfacePlane, kAbove, kDepth, kDepthBelow, kClassic };
constexpr std::size_t kNone = BracketCycle::kMost;

/// What stands where behind the first five.
struct Signature {
  int number;
  std::size_t classic;  ///< how many arguments the cycle had before it had modes
  std::size_t axis;     ///< _AXN, or kNone
  std::size_t modes;    ///< _GMODE _DMODE _AMODE begin here, or kNone
};
constexpr Signature kSignatures[] = {
    {81, 5, kNone, 5},     {82, 6, kNone, 6},       {83, 12, 12, 17},      {84, 12, 12, 21},
    {85, 8, kNone, 8},     {86, 11, kNone, 11},     {87, 6, kNone, kNone}, {88, 7, kNone, kNone},
    {89, 6, kNone, kNone}, {840, 11, kNone, kNone},
};
constexpr std::size_t kAside = 7;  // RPA and RPO of CYCLE86
constexpr double kSame = 1e-9;
constexpr double kLargestNumber = 1e8;

const Signature* signature_of(int number) {
  const auto* found = std::find_if(std::begin(kSignatures), std::end(kSignatures),
                                   [&](const Signature& known) { return known.number == number; });
  return found == std::end(kSignatures) ? nullptr : found;
}

/// The arguments between `at`, behind the bracket, and `end`, where it closes. False: one is no literal.
bool read_arguments(std::string_view text, std::size_t at, std::size_t end, BracketCycle& cycle) {
  const auto skip = [&] { at = std::min(end, text.find_first_not_of(" \t", at)); };
  for (;; ++at) {
    if (cycle.count == BracketCycle::kMost) return false;
    BracketCycle::Argument& argument = cycle.arguments[cycle.count++];
    skip();
    const Decimal number = read_decimal(text.substr(at, end - at));
    if (number.length > 0) {
      if (!(std::abs(number.value) <= kLargestNumber)) return false;
      argument = {true, number.value, number.decimals, at, at + number.length};
      at += number.length;
    } else if (text.substr(at, 2) == "\"\"") {
      at += 2;
    }
    skip();
    if (at == end) return true;
    if (text[at] != ',') return false;
  }
}

/// The modes say no more than that the depth is DP or DPR, and the plane the one in force.
bool modes_are_plain(const BracketCycle& cycle, const Signature& known) {
  const auto value = [&](std::size_t i) { return cycle.arguments[i].value; };
  const bool axis = known.axis == kNone || value(known.axis) == 0 || value(known.axis) == 3;
  const std::size_t most = known.modes == kNone ? known.classic : known.modes + 3;
  if (!axis || cycle.count > most) return false;
  if (known.modes == kNone || cycle.count <= known.modes) return true;
  const double plane = value(known.modes + 1), alternatives = value(known.modes + 2);
  const double depth = std::fmod(alternatives, 10);  // its last digit: 2, from DP
  const bool by_place = depth == 2 && !cycle.arguments[kDepthBelow].said;
  return value(known.modes) == 0 && (plane == 0 || plane == 1) && alternatives >= 0 &&
         (depth == 0 || by_place);
}

bool depth_below(const BracketCycle& cycle) {
  return cycle.arguments[kDepthBelow].said && cycle.arguments[kDepthBelow].value != 0;
}

/// Why the heights are not sure, or nothing.
const char* read_span(BracketCycle& cycle) {
  const auto& said = cycle.arguments;
  const double surface = said[kSurfacePlane].value, above = said[kAbove].value;
  if (!said[kClear].said || !said[kSurfacePlane].said || (!said[kDepth].said && !depth_below(cycle)))
    return "RTP, RFP or the depth is missing";
  cycle.span.top = surface + above;
  cycle.span.clear = said[kClear].value;
  cycle.span.bottom = depth_below(cycle) ? surface - said[kDepthBelow].value : said[kDepth].value;
  const bool two_depths = depth_below(cycle) && said[kDepth].said && said[kDepth].value != 0 &&
                          std::abs(said[kDepth].value - cycle.span.bottom) > kSame;
  if (two_depths) return "DP and DPR say two depths";
  if (above < 0 || !(cycle.span.bottom < surface) || cycle.span.clear < cycle.span.top - kSame)
    return "RTP, RFP + SDIS, RFP and the depth are not one below the other";
  if (cycle.number == 86) cycle.span.aside = std::hypot(said[kAside].value, said[kAside + 1].value);
  return nullptr;
}

}  // namespace

int bracket_cycle_number(std::string_view name) {
  constexpr std::string_view begin = "CYCLE";
  if (name.substr(0, begin.size()) != begin) return 0;
  const Decimal number = read_decimal(name.substr(begin.size()));
  const bool whole = number.length + begin.size() == name.size() && number.length <= 3;
  const Signature* known = whole ? signature_of(static_cast<int>(number.value)) : nullptr;
  return known != nullptr ? known->number : 0;
}

BracketAnswer read_bracket_cycle(std::string_view code) {
  const std::size_t open = code.find('('), close = code.rfind(')');
  if (open == std::string_view::npos || close == std::string_view::npos || close < open)
    return {std::nullopt, "a drilling cycle without its brackets"};
  std::string name(code.substr(0, code.find_last_not_of(" \t", open - 1) + 1));
  for (char& c : name) c = c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c;
  BracketCycle cycle;
  cycle.number = bracket_cycle_number(name);
  cycle.text = std::string(code);
  const Signature* known = signature_of(cycle.number);
  if (known == nullptr) return {std::nullopt, name + " is no drilling cycle that is known"};
  if (!read_arguments(code, open + 1, close, cycle))
    return {std::nullopt, "an argument that is no literal number"};
  if (!modes_are_plain(cycle, *known))
    return {std::nullopt, "an axis, a plane or a mode that is not followed"};
  if (const char* why = read_span(cycle)) return {std::nullopt, why};
  return {std::move(cycle), {}};
}

int BracketCycle::decimals() const {
  int most = 0;
  for (std::size_t i = 0; i < kClassic; ++i) most = std::max(most, arguments[i].decimals);
  return most;
}

std::string BracketCycle::moved(double shift, int digits) const {
  std::string result = text;
  const bool below = depth_below(*this);
  // from behind: what stands before keeps its place
  for (const std::size_t i : {kDepth, kSurfacePlane, kClear}) {
    const Argument& place = arguments[i];
    if (!place.said || (i == kDepth && below)) continue;
    std::string spelled;
    append_fixed(spelled, place.value + shift, digits);
    result.replace(place.begin, place.end - place.begin, spelled);
  }
  return result;
}

}  // namespace abbe
