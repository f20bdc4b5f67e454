// Runs of plain lines that turn both rotary axes, corrected many at a time. Everything else, and every line
// whose digits, path or feed are not beyond doubt, goes the general way: what is written is the same.
#include <algorithm>
#include <cmath>

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

/// Is the number rounded to the same digits if it is off by `doubt`?
bool rounds_surely(double number, int decimals, double doubt) {
  const double scale = number_detail::kPower10[static_cast<std::size_t>(decimals)];
  const double x = number * scale;
  return std::abs(x - std::floor(x) - 0.5) > doubt * scale + 1e-6;
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
  const bool simple_modes = modal_.motion == 10 && modal_.stated && !modal_.incremental &&
                            modal_.feed_mode == 940 && !offset_doubtful_ && cycle_.code == -1 && !tcp_ &&
                            !cutter_.acts();
  const bool stands = known_ == needed_ && withheld_ == 0 && shifted_ == 0 && start_corrected_ &&
                      !datum_dirty_ && in_.frames.known() && !in_.frames.rotated() && !in_.frames.placed();
  const bool in_program = any_block_ && header_written_ && !ended_ && depth_ == 0 && !held_pole_ &&
                          number > kMarkLines && !findings_.refused();
  const bool traced = job_.trace_line >= number && job_.trace_line < number + rows;
  return packet_.usable() && !job_.one_by_one && !job_.reversal && !field_.depends_on_direction() &&
         simple_text && simple_modes && stands && in_program && !traced;
}

// Reads the lines that follow as long as they are plain and turn both axes. Returns how many.
std::size_t Rewriter::read_ahead(std::span<const std::string_view> texts) {
  const std::size_t most = std::min(texts.size(), TurningPacket::kMost);
  const Turns offsets = in_.frames.turn_offset();
  Vec3 m = in_.m;
  Turns turns = in_.turns;
  std::size_t count = 0;
  for (; count < most; ++count) {
    Ahead& ahead = ahead_[count];
    const PlainLine& line = ahead.line;
    if (!read_plain_line(texts[count], ahead.line)) break;
    // Room for longer numbers, and for words that are added.
    constexpr std::size_t kRoom = 80;
    if (line.text.size() + kRoom > profile_.text.block_bytes) break;
    Vec3 p = in_.frames.to_program(m);
    for (int k = 0; k < 3; ++k)
      if (line.has(static_cast<std::size_t>(k)))
        p[k] = line.numbers[static_cast<std::size_t>(k)].value * modal_.unit();
    const Vec3 there = in_.frames.to_machine(p);
    bool turning = true;
    for (std::size_t k = 0; k < 3; ++k) {
      if (line.has(k)) m[static_cast<Eigen::Index>(k)] = there[static_cast<Eigen::Index>(k)];
      if (line.has(3 + k) != (axes_.rotary[k] >= 0)) turning = false;
      if (!line.has(3 + k) || !turning) continue;
      const double to = line.numbers[3 + k].value * deg + offsets[k];
      turning = turning_of(static_cast<int>(k)) == Turning::linear && std::abs(to - turns[k]) > kNoTurn;
      turns[k] = to;
    }
    if (!turning) break;
    ahead.m = m;
    ahead.turns = ahead.stand = turns;
    packet_.command(count, m, turns);
  }
  return count;
}

// The words of the rotary axes, from where they belong. False: not beyond doubt.
bool Rewriter::decide_turns(std::size_t i) {
  Ahead& ahead = ahead_[i];
  const Turns offsets = in_.frames.turn_offset();
  const double doubt = packet_.turn_doubt(i);
  bool sure = packet_.ordinary(i);
  for (std::size_t k = 0; sure && k < 3; ++k) {
    if (!ahead.line.has(3 + k)) continue;
    const PlainLine::Number& word = ahead.line.numbers[3 + k];
    const int decimals = turn_decimals(static_cast<int>(k), word.decimals);
    const double wanted = packet_.turn(i, k), change = wanted - ahead.turns[k];
    const TurnWord found =
        turn_word(Turning::linear, word.value, ahead.turns[k], ahead.turns[k], wanted, offsets[k], decimals);
    // a change of half a digit decides whether the word stays
    const double digits =
        std::abs(change) / deg * number_detail::kPower10[static_cast<std::size_t>(decimals)];
    const bool decided = rounds_surely(change / deg, decimals, doubt / deg) || digits > 1;
    sure = !found.clamped && decided && rounds_surely(word.value + change / deg, decimals, doubt / deg);
    ahead.stand[k] = found.position;
    ahead.numbers[k] = found.number;
  }
  if (sure) packet_.stand(i, ahead.stand);
  return sure;
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
  const TurningBend::Bound bound = bend_.bound(even);
  return at_start + bound.position <= kShareInside * interpolation_ && bound.direction <= kLean;
}

double Rewriter::rounded_away() const {
  return std::sqrt(3.0) * half_digit(decimals_of(nullptr)) * modal_.unit();
}

// Is there nothing to say about the motion of line i but where it ends?
bool Rewriter::is_ordinary(std::size_t i, const Vec3& place) const {
  const Ahead& ahead = ahead_[i];
  const Vec3 correction = place - ahead.m;
  if (!(correction.squaredNorm() <= job_.max_correction * job_.max_correction)) return false;
  // F goes on meaning the same speed.
  const double meant = (ahead.m - in_.m).norm(), now = (place - out_.m).norm();
  if (!(meant > kNoWay && std::abs(now - meant) <= kFeedChange * meant)) return false;
  Move move;
  move.m0 = in_.m, move.m1 = ahead.m;
  move.turns0 = in_.turns, move.turns1 = ahead.turns;
  return surely_straight(move, out_.m, out_.turns, place, ahead.stand, rounded_away());
}

// Finds the numbers of line i for the place where it ends. False: not beyond doubt.
bool Rewriter::decide_places(std::size_t i, const Vec3& place) {
  const Ahead& ahead = ahead_[i];
  const PlainLine& line = ahead.line;
  const double unit = modal_.unit(), doubt = packet_.place_doubt(i) / unit;
  const Vec3 want = out_.frames.to_program(place);
  Vec3 p_out = out_.p();
  written_ = 0;
  for (std::size_t k = 0; k < PlainLine::kFeed; ++k) {
    const bool named = line.has(k);
    const PlainLine::Number& word = line.numbers[k];
    if (k < 3) {
      const auto x = static_cast<Eigen::Index>(k);
      const double wanted = want[x] / unit, stands = named ? word.value : p_out[x] / unit;
      const int decimals = decimals_of(named ? word.decimals : -1);
      const double change = std::abs(wanted - stands), half = half_digit(decimals);
      if (!(std::abs(change - half) > doubt + 2e-6 * half)) return false;
      double number = stands;
      if (change > half) {
        if (!rounds_surely(wanted, decimals, doubt) || !to_fixed(wanted, decimals, spelled_[k])) return false;
        number = spelled_[k].value;
        written_ |= 1u << k;
      }
      if (named || change > half) p_out[x] = number * unit;
    } else if (named && ahead.numbers[k - 3] != word.value) {
      const int decimals = turn_decimals(static_cast<int>(k - 3), word.decimals);
      if (!to_fixed(ahead.numbers[k - 3], decimals, spelled_[k])) return false;
      written_ |= 1u << k;
    }
  }
  out_.m = out_.frames.to_machine(p_out);
  return true;
}

// The line with its new numbers; words that it lacks stand behind the others.
void Rewriter::write_plain(const PlainLine& line, std::string& out) const {
  const std::size_t begin = out.size();
  out.resize(begin + line.text.size() + (PlainLine::kFeed + 3) * (kFixedRoom + 2) + line.eol.size());
  char* to = out.data() + begin;
  std::size_t copied = 0;
  const auto copy = [&](std::size_t end) {
    to = std::copy(line.text.data() + copied, line.text.data() + end, to);
  };
  for (std::size_t w = 0; w < line.count; ++w) {
    const std::size_t place = line.order[w];
    if ((written_ >> place & 1) == 0) continue;
    copy(line.numbers[place].begin);
    to = write_fixed(to, spelled_[place]);
    copied = line.numbers[place].end;
  }
  copy(line.text.size());
  for (std::size_t k = 0; k < 3; ++k) {
    if (line.has(k) || (written_ >> k & 1) == 0) continue;
    if (line.spaced) *to++ = ' ';
    *to++ = "XYZ"[k];
    to = write_fixed(to, spelled_[k]);
  }
  to = std::copy(line.eol.begin(), line.eol.end(), to);
  out.resize(static_cast<std::size_t>(to - out.data()));
}

// One line of the packet, if nothing about it is in doubt.
bool Rewriter::take_plain(std::size_t i, std::string& out) {
  const Ahead& ahead = ahead_[i];
  if (!ahead.sure || !packet_.ordinary(i)) return false;
  const Vec3 place = packet_.place(i);
  const Vec3 meant = ahead.m - in_.m, done = place - out_.m;
  if (!is_ordinary(i, place) || !decide_places(i, place)) return false;
  last_correction_.reset();
  note_turning_gradient(meant, done);
  note_correction(ahead.m, place - ahead.m);
  write_plain(ahead.line, out);
  ++report_.lines_out;
  ++report_.blocks.motion;
  ++report_.blocks.together;
  if (written_ != 0) ++report_.blocks.rewritten;
  if (ahead.line.has(PlainLine::kFeed)) {
    modal_.feed = ahead.line.numbers[PlainLine::kFeed].value;
    modal_.has_feed = true;
  }
  in_.m = ahead.m;
  in_.turns = ahead.turns;
  out_.turns = ahead.stand;
  for (unsigned k = 0; k < 3; ++k)
    if (ahead.line.has(3 + k)) turned_ |= 1u << k;
  return true;
}

void Rewriter::one_line(std::string_view text, std::string& out) {
  stand(in_.turns, out_.turns);
  block_ = blocks_.data();
  const std::optional<BlockError> error = read_line(text, *block_);
  line(error, false, out);
}

std::size_t Rewriter::lane(std::span<const std::string_view> texts, std::uint64_t number, std::string& out) {
  if (!lane_is_open(number, texts.size())) return 0;
  const std::size_t count = read_ahead(texts);
  if (count == 0) {
    // Others of its kind may follow: nothing is read ahead of it.
    if (!turns_an_axis(ahead_[0].line, texts[0])) return 0;
    number_ = number;
    one_line(texts[0], out);
    return 1;
  }
  packet_.solve(count, field_.datum());
  for (std::size_t i = 0; i < count; ++i) ahead_[i].sure = decide_turns(i);
  packet_.settle(count);
  std::size_t i = 0;
  do {
    number_ = number + i;
    if (!take_plain(i, out)) one_line(texts[i], out);
  } while (++i < count && lane_is_open(number, count));
  stand(in_.turns, out_.turns);
  return i;
}

}  // namespace abbe
