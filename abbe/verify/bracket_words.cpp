// Cycles as SINUMERIK controls run them: at rapid to RFP + SDIS, down to the depth, and back to RTP.
#include "abbe/verify/bracket_words.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include "abbe/core/number.h"

namespace abbe::verifying {
namespace {

constexpr std::string_view kBlanks = " \t";
constexpr std::size_t kMostArguments = 24;
constexpr double kBeyond = 1e8;
constexpr int kOther = 300;  // argument n, from 1, that is no height: 300 + n

/// How many numbers a cycle has, and which of them, from 1, are its three modes; 0: it has none.
struct Layout {
  int cycle = 0;
  std::size_t numbers = 0, modes = 0;
};
constexpr std::array kLayouts = {
    Layout{81, 8, 6},   Layout{82, 9, 7}, Layout{83, 20, 18}, Layout{84, 24, 22}, Layout{85, 11, 9},
    Layout{86, 14, 12}, Layout{87, 6, 0}, Layout{88, 7, 0},   Layout{89, 6, 0},   Layout{840, 11, 0}};

std::optional<Layout> layout_of(int cycle) {
  for (const Layout& layout : kLayouts)
    if (layout.cycle == cycle) return layout;
  return std::nullopt;
}

using Arguments = std::vector<std::optional<double>>;

/// The numbers between the brackets; nothing where a place is left empty. False: something else is there.
bool split(std::string_view inside, Arguments& arguments) {
  for (bool more = true; more;) {
    const std::size_t comma = inside.find(',');
    more = comma != std::string_view::npos;
    std::string_view one = inside.substr(0, comma);
    inside.remove_prefix(more ? comma + 1 : inside.size());
    one.remove_prefix(std::min(one.size(), one.find_first_not_of(kBlanks)));
    one = one.substr(0, one.find_last_not_of(kBlanks) + 1);
    if (arguments.size() == kMostArguments) return false;
    arguments.emplace_back();
    if (one.empty() || one == "\"\"") continue;
    const Decimal number = read_decimal(one);
    if (number.length != one.size() || !(std::abs(number.value) < kBeyond)) return false;
    arguments.back() = number.value;
  }
  return true;
}

/// Neither axis nor modes say what is not followed here.
bool modes_agree(const Layout& layout, const Arguments& arguments) {
  const auto at = [&](std::size_t i) { return i <= arguments.size() ? arguments[i - 1].value_or(0) : 0.0; };
  if (arguments.size() > layout.numbers) return false;
  constexpr std::size_t axis = 13;
  if ((layout.cycle == 83 || layout.cycle == 84) && at(axis) != 0 && at(axis) != 3) return false;
  if (layout.modes == 0) return true;
  const double shape = at(layout.modes), plane = at(layout.modes + 1), other = at(layout.modes + 2);
  const double depth = other - 10 * std::floor(other / 10);
  const bool relative = arguments.size() >= 5 && arguments[4].has_value();
  return shape == 0 && (plane == 0 || plane == 1) && other >= 0 && (depth == 0 || (depth == 2 && !relative));
}

}  // namespace

int bracket_cycle(std::string_view name) {
  constexpr std::string_view stem = "CYCLE";
  if (name.size() <= stem.size() || name.size() > stem.size() + 3) return 0;
  int number = 0;
  for (std::size_t i = 0; i < name.size(); ++i) {
    const char c = name[i];
    if (i < stem.size()) {
      if ((c & ~0x20) != stem[i]) return 0;
    } else if (c < '0' || c > '9') {
      return 0;
    } else {
      number = 10 * number + (c - '0');
    }
  }
  return layout_of(number) && name[stem.size()] != '0' ? number : 0;
}

bool take_brackets(std::string_view text, HoleWords& words, std::string& fault) {
  const auto bad = [&](const char* why) {
    fault = why;
    return false;
  };
  const std::size_t open = text.find('(');
  if (open == std::string_view::npos || text.back() != ')') return bad("a cycle without numbers");
  const std::string_view name = text.substr(0, text.find_first_of(" \t("));
  const int cycle = bracket_cycle(name);
  const auto layout = layout_of(cycle);
  Arguments arguments;
  if (!layout || !split(text.substr(open + 1, text.size() - open - 2), arguments))
    return bad("something in the brackets that is no number");
  if (!modes_agree(*layout, arguments)) return bad("a mode of the cycle that is not followed");
  arguments.resize(std::max<std::size_t>(arguments.size(), 5));
  const auto retract = arguments[0], surface = arguments[1], place = arguments[3], below = arguments[4];
  const bool by_distance = below.value_or(0) != 0;
  if (!retract || !surface || (!place && !by_distance)) return bad("a plane or the depth is left out");
  const double depth = by_distance ? -*below : *place - *surface;
  constexpr double same = 1e-9;
  if (by_distance && place.value_or(0) != 0 && !(std::abs(*place - *surface - depth) < same))
    return bad("two depths that differ");
  const double set_up = arguments[2].value_or(0), back = *retract - *surface;
  if (!(depth < 0) || set_up < 0 || back < set_up - same) return bad("planes in another order");
  words.cycle = cycle;
  words.count = 0;
  bool room = words.take(kSurfaceQ, *surface) && words.take(200, set_up) && words.take(201, depth) &&
              words.take(204, std::max(back, set_up));
  for (std::size_t i = 4; i < arguments.size(); ++i)
    if (arguments[i]) room = room && words.take(kOther + static_cast<int>(i) + 1, *arguments[i]);
  return room || bad("too many numbers");
}

}  // namespace abbe::verifying
