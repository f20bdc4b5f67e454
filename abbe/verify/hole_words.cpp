// Drilling cycles as TNC controls run them: at rapid to Q203 + Q200, down to Q203 + Q201, back, and on to
// Q203 + Q204 if that is higher. The older cycles drill from where the tool stands: the surface is one set-up
// clearance below it.
#include "abbe/verify/hole_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace abbe::verifying {
namespace {

constexpr std::int16_t kOf1[] = {1, 2, 3, 4, 5};  // set-up, depth, pecking depth, dwell, feed
constexpr std::int16_t kOf2[] = {1, 2, 3, 4};     // set-up, depth, dwell, feed
constexpr std::int16_t kOf17[] = {1, 2, 3};       // set-up, depth, pitch
constexpr double kSameHeight = 1e-9;  // differences of places, rounded

constexpr std::int16_t kOf200[] = {200, 201, 202, 203, 204, 206, 210, 211, 395};
constexpr std::int16_t kOf201[] = {200, 201, 203, 204, 206, 208, 211};
constexpr std::int16_t kOf202[] = {200, 201, 203, 204, 206, 208, 211, 214, 336};
constexpr std::int16_t kOf203[] = {200, 201, 202, 203, 204, 205, 206, 208, 210, 211, 212, 213, 256, 395};
constexpr std::int16_t kOf204[] = {200, 203, 204, 214, 249, 250, 251, 252, 253, 254, 255, 336};
constexpr std::int16_t kOf205[] = {200, 201, 202, 203, 204, 205, 206, 208, 211,
                                   212, 253, 256, 257, 258, 259, 379, 395};
constexpr std::int16_t kOf206[] = {200, 201, 203, 204, 206, 211};
constexpr std::int16_t kOf207[] = {200, 201, 203, 204, 239};
constexpr std::int16_t kOf208[] = {200, 201, 203, 204, 206, 334, 335, 342, 351};
constexpr std::int16_t kOf209[] = {200, 201, 203, 204, 239, 256, 257, 336, 403};

}  // namespace

std::optional<double> HoleWords::find(int q) const {
  for (int i = 0; i < count; ++i)
    if (name[static_cast<std::size_t>(i)] == q) return value[static_cast<std::size_t>(i)];
  return std::nullopt;
}

bool HoleWords::take(int q, double number) {
  if (count == kMost || find(q)) return false;
  name[static_cast<std::size_t>(count)] = static_cast<std::int16_t>(q);
  value[static_cast<std::size_t>(count++)] = number;
  return true;
}

std::span<const std::int16_t> known_words(int cycle) {
  switch (cycle) {
    case 1:
      return kOf1;
    case 2:
      return kOf2;
    case 17:
      return kOf17;
    case 200:
      return kOf200;
    case 201:
      return kOf201;
    case 202:
      return kOf202;
    case 203:
      return kOf203;
    case 204:
      return kOf204;
    case 205:
      return kOf205;
    case 206:
      return kOf206;
    case 207:
      return kOf207;
    case 208:
      return kOf208;
    case 209:
      return kOf209;
    default:
      return {};
  }
}

namespace {

/// Of cycles 1, 2 and 17: every line must be there.
std::optional<HolePlace> place_from_tool(const HoleWords& words, std::string& fault) {
  const auto known = known_words(words.cycle);
  if (words.count != static_cast<int>(known.size())) {
    fault = fmt::format("cycle {} lacks one of its {} lines", words.cycle, known.size());
    return std::nullopt;
  }
  const auto line = [&](int number) { return words.find(number).value_or(0); };
  const double set_up = line(1), depth = line(2);
  const int feed = words.cycle == 1 ? 5 : 4, dwell = feed - 1;
  const bool cuts = words.cycle == 17 ? line(3) != 0 : line(feed) > 0 && line(dwell) >= 0;
  const bool pecks = words.cycle != 1 || line(3) > 0;
  if (!(set_up >= 0) || !(depth < 0) || !cuts || !pecks) {
    fault = fmt::format("a clearance, depth, feed or pitch of cycle {} leaves its motion open", words.cycle);
    return std::nullopt;
  }
  return HolePlace{-set_up, depth - set_up, 0, 0, true};
}

}  // namespace

std::optional<HolePlace> place_of(const HoleWords& words, std::string& fault) {
  if (of_lines(words.cycle)) return place_from_tool(words, fault);
  bool complete = true;
  const auto need = [&](int q) {
    const auto found = words.find(q);
    if (!found && complete) fault = fmt::format("cycle {} lacks Q{}", words.cycle, q);
    complete = complete && found.has_value();
    return found.value_or(0);
  };
  const double surface = need(kSurfaceQ), set_up = need(200), second = need(204);
  HolePlace place;
  const bool back_bore = words.cycle == 204;
  const double depth =
      back_bore ? -(need(250) + std::max(0.0, need(252)) + set_up) : need(201);  // from the surface
  if (words.cycle == 208) place.reach = need(335) / 2;
  if (back_bore) place.reach = need(251);
  constexpr int fine_bore = 86, first_step = 308, second_step = 309;  // RPA, RPO
  if (words.cycle == fine_bore)
    place.reach = std::hypot(words.find(first_step).value_or(0), words.find(second_step).value_or(0));
  if (!complete) return std::nullopt;
  const bool second_unsure = second != 0 && second < set_up;
  const bool lengths = set_up >= 0 && depth < 0 && place.reach >= 0 &&
                       (words.cycle != 208 || place.reach > 0) &&
                       (!back_bore || (need(249) > 0 && need(250) > 0 && need(252) >= 0 && complete));
  if (second_unsure || !lengths || words.find(395).value_or(0) != 0) {
    if (complete)
      fault = fmt::format("a clearance, depth or width of cycle {} leaves its motion open", words.cycle);
    return std::nullopt;
  }
  place.retract = surface + set_up;
  place.bottom = surface + depth;
  place.clear = second > set_up ? surface + second : place.retract;
  return place;
}

bool same_hole(const HoleWords& a, const HoleWords& b) {
  if (a.cycle != b.cycle || a.count != b.count) return false;
  for (int i = 0; i < a.count; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const auto other = b.find(a.name[k]);
    if (!other || (a.name[k] != kSurfaceQ && !(std::abs(*other - a.value[k]) <= kSameHeight))) return false;
  }
  return true;
}

}  // namespace abbe::verifying
