// Runs of plain lines that turn both rotary axes, corrected many at a time. Everything else, and every line
// whose digits, path or feed are not beyond doubt, goes the general way: what is written is the same.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// Smaller ways of linear axes, and of rotary ones (rad): as in rewriter_turning.cpp.
constexpr double kNoWay = 1e-7, kNoTurn = 0.5e-4 * deg;
// The way of the linear axes may change by this share, less what single precision makes of it.
constexpr double kFeedChange = 0.0999;
// Of what the interpolation may leave: the rest is for the ends, which are solved to 20 nm.
constexpr double kShareInside = 0.9;
// What the tool axis may lean more inside a move than at its ends, rad.
constexpr double kLean = 10 * urad;

constexpr double kDegrees = 1 / deg;
// Numbers of more decimals go the general way.
constexpr int kMostDecimals = 9;
// Of a digit: a tie is not written again (Rewriter::half_digit), and arithmetic leaves this much.
constexpr double kTie = 1e-6, kArithmetic = 2e-6;

// Larger numbers, in units of the last digit, go the general way, too.
constexpr double kMostUnits = 1e15;

double units_per(int decimals) { return number_detail::kPower10[static_cast<std::size_t>(decimals)]; }

/// A number to be written or left as it stands, in units of its last digit.
struct Digits {
  double n = 0;
  bool stays = false;
};
/// `change` (of what stands) is so small that this stays, or `wanted` is rounded. Both in units of the last
/// digit.
Digits digits_for(double change, double wanted) {
  return {nearest_integer(wanted), std::abs(change) <= 0.5 * (1 + kTie)};
}
/// The same decision would be made of numbers that are off by `doubt`.
bool surely(const Digits& digits, double change, double wanted, double doubt) {
  const double room = doubt + kArithmetic;
  if (!(std::abs(wanted) < kMostUnits)) return false;
  return digits.stays ? std::abs(change) + room < 0.5
                      : std::abs(change) - room > 0.5 && std::abs(wanted - digits.n) + room < 0.5;
}

/// A plain line with a rotary word.
bool turns_an_axis(const PlainLine& line, std::string_view bytes) {
  return line.eol.data() + line.eol.size() == bytes.data() + bytes.size() && (line.named >> 3 & 7u) != 0;
}

}  // namespace

// What a plain line needs and does not say is in force, and in its simplest form.
bool Rewriter::lane_is_open(std::uint64_t number, std::size_t rows) const {
  const bool simple_text = profile_.numbers.integer_words == Profile::IntegerWords::units &&
                           profile_.numbers.finer && !profile_.text.conversational && !profile_.text.names;
  const bool lines = modal_.motion == 10 || (modal_.motion == 0 && line_words_);
  const bool simple_modes = lines && modal_.stated && !modal_.incremental && modal_.feed_mode == 940 &&
                            !offset_doubtful_ && cycle_.code == -1 && !tcp_ && !cutter_.acts();
  const bool stands = known_ == needed_ && withheld_ == 0 && shifted_ == 0 && start_corrected_ &&
                      !datum_dirty_ && in_.frames.known() && !in_.frames.rotated() && !in_.frames.placed();
  const bool in_program = any_block_ && header_written_ && !ended_ && depth_ == 0 && !held_pole_ &&
                          number > kMarkLines && !findings_.refused();
  const bool traced = job_.trace_line >= number && job_.trace_line < number + rows;
  return packet_.usable() && !job_.one_by_one && !job_.reversal && !field_.depends_on_direction() &&
         simple_text && simple_modes && stands && in_program && !traced;
}

LaneDigits Rewriter::digits_of_lane() const {
  LaneDigits digits;
  digits.linear = decimals_of(-1);
  for (std::size_t k = 0; k < 3; ++k) {
    if (axes_.rotary[k] < 0) continue;
    const auto axis = static_cast<std::size_t>(axes_.rotary[k]);
    digits.turn[k] = turn_decimals(static_cast<int>(k), -1);
    digits.fixed[k] = axis < machine_.control.axes.size() && machine_.control.axes[axis].resolution;
  }
  return digits;
}

// Reads the lines that follow as long as they are plain and turn both axes. Returns how many.
std::size_t Rewriter::read_ahead(std::span<const std::string_view> texts) {
  const std::size_t most = std::min(texts.size(), TurningPacket::kMost);
  const Turns offsets = in_.frames.turn_offset();
  const double unit = modal_.unit();
  Vec3 m = in_.m;
  Turns turns = in_.turns;
  std::size_t count = 0;
  for (; count < most; ++count) {
    LaneLine& ahead = ahead_[count];
    const PlainLine& line = ahead.line;
    if (!read_plain_line(texts[count], ahead.line)) break;
    const bool feeds = line.has(PlainLine::kFeed) ? line.numbers[PlainLine::kFeed].value > 0
                                                  : count > 0 || (modal_.has_feed && modal_.feed > 0);
    if (!feeds || (count == 0 && modal_.motion != 10 && !line.says_line)) break;
    // Room for longer numbers, and for words that are added.
    constexpr std::size_t kRoom = 80;
    if (line.text.size() + kRoom > profile_.text.block_bytes) break;
    const bool names_all = (line.named & 7u) == 7u;
    Vec3 p = names_all ? Vec3(line.numbers[0].value, line.numbers[1].value, line.numbers[2].value) * unit
                       : in_.frames.to_program(m);
    for (int k = 0; !names_all && k < 3; ++k)
      if (line.has(static_cast<std::size_t>(k)))
        p[k] = line.numbers[static_cast<std::size_t>(k)].value * unit;
    const Vec3 there = in_.frames.to_machine(p);
    bool turning = true;
    for (std::size_t k = 0; k < 3; ++k) {
      if (line.has(k)) m[static_cast<Eigen::Index>(k)] = there[static_cast<Eigen::Index>(k)];
      if (line.has(3 + k) != (axes_.rotary[k] >= 0)) turning = false;
      if (!line.has(3 + k) || !turning) continue;
      const double to = line.numbers[3 + k].value * deg + offsets[k];
      turning = packet_.goes_as_written(k) && std::abs(to - turns[k]) > kNoTurn;
      turns[k] = to;
    }
    if (!turning) break;
    ahead.m = m;
    ahead.turns = turns;
    packet_.command(count, m, turns);
  }
  return count;
}

// Where the rotary axes will stand, as their words can say it, from where they nearly belong.
void Rewriter::choose_turns(std::size_t i, const Turns& offsets) {
  LaneLine& ahead = ahead_[i];
  ahead.stand = ahead.turns;
  ahead.sure = true;
  for (std::size_t j = 0; j < 2; ++j) {
    const std::size_t k = packet_.rotary()[j];
    const PlainLine::Number& word = ahead.line.numbers[3 + k];
    const int decimals = lane_digits_.of_turn(k, word.decimals);
    ahead.sure = ahead.sure && decimals <= kMostDecimals;
    if (!ahead.sure) return;
    double& stand = packet_.stand(i, j);
    const double units = units_per(decimals), change = (stand - ahead.turns[k]) * kDegrees;
    const Digits digits = digits_for(change * units, (word.value + change) * units);
    ahead.sure = std::abs(digits.n) < kMostUnits;
    if (!ahead.sure) return;
    FixedNumber& spelled = ahead.spelled[3 + k];
    spelled = fixed_number(digits.n, decimals);
    ahead.turn_stays[j] = digits.stays;
    if (digits.stays) spelled.value = word.value;
    stand = ahead.stand[k] = spelled.value * deg + offsets[k];
  }
}

// Now it is known where they belong: are their words those that this asks for?
bool Rewriter::turns_are_sure(std::size_t i) const {
  const LaneLine& ahead = ahead_[i];
  for (std::size_t j = 0; j < 2; ++j) {
    const std::size_t k = packet_.rotary()[j];
    const FixedNumber& spelled = ahead.spelled[3 + k];
    const double units = units_per(spelled.decimals),
                 change = (packet_.turn(i, j) - ahead.turns[k]) * kDegrees;
    const double n =
        spelled.negative ? -static_cast<double>(spelled.digits) : static_cast<double>(spelled.digits);
    if (!surely({n, ahead.turn_stays[j]}, change * units, (ahead.line.numbers[3 + k].value + change) * units,
                packet_.turn_doubt(i) * kDegrees * units))
      return false;
  }
  return true;
}

// Rounding that is in doubt is decided from the places of the axes themselves, not from beside them.
void Rewriter::choose_all_turns(std::size_t count) {
  const Turns offsets = in_.frames.turn_offset();
  unsigned doubtful = 0;
  for (std::size_t i = 0; i < count; ++i) choose_turns(i, offsets);
  packet_.settle();
  for (std::size_t i = 0; i < count; ++i) {
    LaneLine& ahead = ahead_[i];
    if (!ahead.sure || !packet_.ordinary(i)) {
      ahead.sure = false;
    } else if (!turns_are_sure(i)) {
      doubtful |= 1u << i;
      for (std::size_t j = 0; j < 2; ++j) packet_.stand(i, j) = packet_.turn(i, j);
    }
  }
  if (doubtful == 0) return;
  packet_.settle();
  for (std::size_t i = 0; i < count; ++i) {
    if ((doubtful >> i & 1) == 0) continue;
    for (std::size_t j = 0; j < 2; ++j) packet_.stand(i, j) = packet_.turn(i, j);
    choose_turns(i, offsets);
    ahead_[i].sure = ahead_[i].sure && packet_.ordinary(i) && turns_are_sure(i);
  }
  packet_.settle();
  for (std::size_t i = 0; i < count; ++i) ahead_[i].sure = ahead_[i].sure && packet_.ordinary(i);
}

// The numbers of the linear axes, from where they belong. False: not beyond doubt.
bool Rewriter::choose_places(std::size_t i, const Vec3& place, const Vec3& p_before) {
  LaneLine& ahead = ahead_[i];
  const PlainLine& line = ahead.line;
  const double unit = modal_.unit(), per_unit = modal_.inch ? 1 / unit : 1.0;
  const double doubt = packet_.place_doubt(i) * per_unit;
  const Vec3 want = out_.frames.to_program(place);
  Vec3 p_out = p_before;
  ahead.written = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    const bool named = line.has(k);
    const PlainLine::Number& word = line.numbers[k];
    const auto x = static_cast<Eigen::Index>(k);
    const int decimals = std::max<int>(lane_digits_.linear, named ? word.decimals : 0);
    if (decimals > kMostDecimals) return false;
    const double units = units_per(decimals);
    const double wanted = want[x] * per_unit, stands = named ? word.value : p_out[x] * per_unit;
    const double change = (wanted - stands) * units;
    const Digits digits = digits_for(change, wanted * units);
    if (!surely(digits, change, wanted * units, doubt * units)) return false;
    if (!digits.stays) {
      ahead.spelled[k] = fixed_number(digits.n, decimals);
      p_out[x] = ahead.spelled[k].value * unit;
      ahead.written |= 1u << k;
    } else if (named) {
      p_out[x] = word.value * unit;
    }
  }
  for (std::size_t j = 0; j < 2; ++j)
    if (!ahead.turn_stays[j]) ahead.written |= 8u << packet_.rotary()[j];
  ahead.p_out = p_out;
  ahead.m_out = out_.frames.to_machine(p_out);
  return true;
}

// Line i, which begins where `before` ends, is what it seems: numbers beyond doubt, no limit near, F goes on
// meaning the same speed.
bool Rewriter::choose_line(std::size_t i, const LaneReach& before) {
  LaneLine& ahead = ahead_[i];
  if (!ahead.sure) return false;
  const Vec3 place = packet_.place(i);
  ahead.correction = place - ahead.m;
  if (!(ahead.correction.squaredNorm() <= job_.max_correction * job_.max_correction)) return false;
  const Vec3 meant = ahead.m - before.m_in, done = place - before.m_out;
  ahead.way_square = meant.squaredNorm();
  ahead.change_square = (done - meant).squaredNorm();
  // | |done| - |meant| | <= |done - meant|
  const bool same_speed = ahead.change_square <= kFeedChange * kFeedChange * ahead.way_square ||
                          std::abs(done.norm() - meant.norm()) <= kFeedChange * meant.norm();
  return ahead.way_square > kNoWay * kNoWay && same_speed && choose_places(i, place, before.p_out);
}

void Rewriter::enter(std::size_t at, const Vec3& meant, const Turns& meant_turns, const Vec3& done,
                     const Turns& done_turns) {
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(axes_.linear[k]);
    lane_run_.meant[i][at] = meant[static_cast<Eigen::Index>(k)];
    lane_run_.done[i][at] = done[static_cast<Eigen::Index>(k)];
    if (axes_.rotary[k] < 0) continue;
    const auto r = static_cast<std::size_t>(axes_.rotary[k]);
    lane_run_.meant[r][at] = meant_turns[k];
    lane_run_.done[r][at] = done_turns[k];
  }
}

bool Rewriter::run_is_straight(std::size_t first, std::size_t end) const {
  const auto axes = static_cast<std::size_t>(machine_.axis_count());
  return is_straight(bend_.bound(lane_run_.extent(first, end, axes)), rounded_away());
}

bool Rewriter::is_straight(const TurningBend::Bound& bound, double at_start) const {
  return at_start + bound.position <= kShareInside * interpolation_ && bound.direction <= kLean;
}

bool Rewriter::surely_straight(const Move& move, const Vec3& from, const Turns& from_turns, const Vec3& to,
                               const Turns& to_turns, double at_start) const {
  EvenMove even;
  for (std::size_t k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(axes_.linear[k]);
    const auto x = static_cast<Eigen::Index>(k);
    even.meant_from[i] = move.m0[x], even.meant_to[i] = move.m1[x];
    even.done_from[i] = from[x], even.done_to[i] = to[x];
    if (axes_.rotary[k] < 0) continue;
    const auto r = static_cast<std::size_t>(axes_.rotary[k]);
    even.meant_from[r] = move.turns0[k], even.meant_to[r] = move.turns1[k];
    even.done_from[r] = from_turns[k], even.done_to[r] = to_turns[k];
  }
  return is_straight(bend_.bound(even), at_start);
}

double Rewriter::rounded_away() const {
  return std::sqrt(3.0) * half_digit(decimals_of(nullptr)) * modal_.unit();
}

// The line with its new numbers; words that it lacks stand behind the others. Returns the end of the text.
char* Rewriter::write_plain(const LaneLine& ahead, char* to) const {
  const PlainLine& line = ahead.line;
  const char* const text = line.text.data();
  std::size_t copied = 0;
  const auto copy = [&](std::size_t end) {
    constexpr std::size_t kAtOnce = 8;  // mostly it is a blank and a letter, and there is room for more
    if (end - copied > kAtOnce || copied + kAtOnce > line.text.size()) {
      to = std::copy(text + copied, text + end, to);
    } else {
      std::memcpy(to, text + copied, kAtOnce);
      to += end - copied;
    }
    copied = end;
  };
  for (std::size_t w = 0; w < line.count; ++w) {
    const std::size_t place = line.order[w];
    if ((ahead.written >> place & 1) == 0) continue;
    copy(line.numbers[place].begin);
    to = write_fixed(to, ahead.spelled[place]);
    copied = line.numbers[place].end;
  }
  copy(line.text.size());
  for (std::size_t k = 0; k < 3; ++k) {
    if (line.has(k) || (ahead.written >> k & 1) == 0) continue;
    if (line.spaced) *to++ = ' ';
    *to++ = "XYZ"[k];
    to = write_fixed(to, ahead.spelled[k]);
  }
  return std::copy(line.eol.begin(), line.eol.end(), to);
}

// A line that is decided: into the report.
void Rewriter::count_line(const LaneLine& ahead) {
  if (ahead.change_square > report_.max_gradient * report_.max_gradient * ahead.way_square &&
      ahead.way_square > kGradientBase * kGradientBase)
    report_.max_gradient = std::sqrt(ahead.change_square / ahead.way_square);
  const Vec3 size = ahead.correction.cwiseAbs();
  if (size.x() > report_.max_correction[0] || size.y() > report_.max_correction[1] ||
      size.z() > report_.max_correction[2])
    note_correction(ahead.m, ahead.correction);
  if (ahead.written != 0) ++report_.blocks.rewritten;
  if (ahead.line.has(PlainLine::kFeed)) {
    modal_.feed = ahead.line.numbers[PlainLine::kFeed].value;
    modal_.has_feed = true;
  }
}

// The lines from `first` on of which nothing is in doubt. Returns where they end.
std::size_t Rewriter::take_run(std::size_t first, std::size_t count, std::uint64_t number, std::string& out) {
  LaneReach before = {in_.m, out_.m, out_.p()};
  enter(first, in_.m, in_.turns, out_.m, out_.turns);
  std::size_t end = first, room = 0;
  for (; end < count && choose_line(end, before); ++end) {
    const LaneLine& ahead = ahead_[end];
    enter(end + 1, ahead.m, ahead.turns, ahead.m_out, ahead.stand);
    before = {ahead.m, ahead.m_out, ahead.p_out};
    room += ahead.line.text.size() + ahead.line.eol.size() + (PlainLine::kFeed + 3) * (kFixedRoom + 2);
  }
  if (end == first) return first;
  if (!run_is_straight(first, end)) {
    std::size_t straight = first;
    while (straight < end && run_is_straight(straight, straight + 1)) ++straight;
    end = straight;
  }
  if (lane_text_.size() < room) lane_text_.resize(room);
  char* to = lane_text_.data();
  last_correction_.reset();
  for (std::size_t i = first; i < end; ++i) {
    number_ = number + i;
    count_line(ahead_[i]);
    to = write_plain(ahead_[i], to);
  }
  if (end == first) return first;
  out.append(lane_text_.data(), to);
  const auto lines = static_cast<std::uint64_t>(end - first);
  report_.lines_out += lines;
  report_.blocks.motion += lines;
  report_.blocks.together += lines;
  modal_.motion = 10;
  modal_.motion_words = *line_words_;
  const LaneLine& last = ahead_[end - 1];
  in_.m = last.m;
  in_.turns = last.turns;
  out_.m = last.m_out;
  out_.turns = last.stand;
  for (const std::size_t k : packet_.rotary()) turned_ |= 1u << k;
  return end;
}

void Rewriter::one_line(std::string_view text, std::string& out) {
  stand(in_.turns, out_.turns);
  block_ = blocks_.data();
  const std::optional<BlockError> error = read_line(text, *block_);
  line(error, false, out);
}

std::size_t Rewriter::lane(std::span<const std::string_view> texts, std::uint64_t number, std::string& out) {
  if (modal_.motion == 10) line_words_ = modal_.motion_words;
  if (!lane_is_open(number, texts.size())) return 0;
  const std::size_t count = read_ahead(texts);
  if (count == 0) {
    // Others of its kind may follow: nothing is read ahead of it.
    if (!turns_an_axis(ahead_[0].line, texts[0])) return 0;
    number_ = number;
    one_line(texts[0], out);
    return 1;
  }
  lane_digits_ = digits_of_lane();
  packet_.estimate(count, field_.datum());
  choose_all_turns(count);
  std::size_t i = take_run(0, count, number, out);
  while (i < count) {
    number_ = number + i;
    one_line(texts[i], out);
    if (++i == count || !lane_is_open(number, count)) break;
    i = take_run(i, count, number, out);
  }
  stand(in_.turns, out_.turns);
  return i;
}

}  // namespace abbe
