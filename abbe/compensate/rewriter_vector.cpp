// The tool's direction as a vector: G43.5 I J K, TRAORI with A3= B3= C3= (docs/theory/five-axes.md).
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"
#include "abbe/core/units.h"

namespace abbe {
namespace {

// A rotary axis is not corrected by more: near the pole the direction is left as it is written, rad.
constexpr double kMostCorrection = 0.5 * deg;
constexpr int kMostDecimals = 9;

}  // namespace

bool Rewriter::vector_words_allowed() {
  const Word& first = direction_word(0);
  if (!machine_.control.declared || !machine_.control.vectors.nearest) {
    refuse(first, "E-VECTOR", "the tool's direction as a vector",
           "which positions of the rotary axes the control takes for it is not declared",
           "state it in the machine file, if it is so: [control] vectors = { turns = \"nearest\" }");
    return false;
  }
  const bool tcp = instruction_.tcp >= 0 ? instruction_.tcp == 1 : tcp_;
  if (!tcp || instruction_.zero == 530) {
    refuse(first, "E-VECTOR", "the tool's direction without tool centre point control, or beside G53",
           "what the control makes of it then is not known", "switch it on before (G43.5, TRAORI)");
    return false;
  }
  if (modal_.turn_codes.frame == TurnCodes::Frame::machine ||
      instruction_.turn_codes.frame == TurnCodes::Frame::machine) {
    refuse(first, "E-VECTOR", "the tool's direction while ORIMKS is in force",
           "whether it is then a direction of the machine is not sure", "write ORIWKS before");
    return false;
  }
  if (modal_.incremental || instruction_.distance == 910) {
    refuse(first, "E-VECTOR", "the tool's direction in G91",
           "whether it is added to the last one is not known", "post such blocks in G90");
    return false;
  }
  return true;
}

Vec3 Rewriter::written_direction() const {
  return {direction_word(0).value, direction_word(1).value, direction_word(2).value};
}

int Rewriter::direction_decimals() const {
  int decimals = profile_.numbers.decimals_vector;
  for (std::size_t k = 0; k < 3; ++k) decimals = std::max<int>(decimals, direction_word(k).decimals);
  return std::min(decimals, kMostDecimals);
}

/// Where the control turns for a direction in program coordinates. Nothing: refused.
std::optional<Turns> Rewriter::turns_of_vector(const Vec3& words, const Turns& from) {
  using Trouble = ToolVectors::Trouble;
  const ToolVectors::Answer answer = vectors_.turns_of(in_.frames.vector_to_machine(words), from);
  const char *what = "", *fix = "post the block with rotary words (G43.4, A= C=)";
  switch (answer.trouble) {
    case Trouble::none:
      return answer.turns;
    case Trouble::axes:
      what = "the tool's direction is zero, or the machine has not two rotary axes that tilt the tool";
      break;
    case Trouble::unreachable:
      what = "no position of the rotary axes gives the tool this direction";
      break;
    case Trouble::travel:
      what = "the positions that give the tool this direction are beyond the travels";
      break;
    case Trouble::pole:
      what = "the tool's direction is almost that of the rotary axis at the workpiece, which would turn far";
      break;
    case Trouble::several:
      what = "two positions of the rotary axes give this direction, and which is nearer is not clear";
      fix = "post a block between, or with rotary words; state the travels (`range`) of the rotary axes";
      break;
  }
  refuse(direction_word(0), "E-VECTOR", what, "where the rotary axes go decides on the errors of the machine",
         fix);
  return std::nullopt;
}

// Where the original turns to.
bool Rewriter::read_vector(Move& move) {
  const auto offsets = in_.frames.turn_offset();
  if (std::any_of(offsets.begin(), offsets.end(), [](double offset) { return offset != 0; })) {
    refuse(direction_word(0), "E-VECTOR", "a work offset of a rotary axis beside the tool's direction",
           "whether the direction turns with the offset is not known", "set the offset to zero");
    return false;
  }
  for (unsigned k = 0; k < 3; ++k)
    if (axes_.rotary[k] >= 0) move.turning |= 1u << k;
  if ((known_ >> 3 & move.turning) != move.turning) {
    refuse(direction_word(0), "E-VECTOR",
           "the tool's direction while the position of a rotary axis is not known",
           "the control takes the position nearest to it", "command the rotary axes before");
    return false;
  }
  const auto turns = turns_of_vector(written_direction(), in_.turns);
  if (!turns) return false;
  move.turns1 = *turns;
  move.by_vector = true;
  move.named |= move.turning << 3;
  turned_ |= move.turning;
  return true;
}

// The words that turn the output's axes from `from` as near to `wanted` as digits allow. What is written
// stays if it does; so it does near the pole, where the outer axis would turn far for a small correction.
bool Rewriter::settle_vector(double s, const Turns& meant, const Turns& wanted, const Turns& from,
                             Stop& stop) {
  const Frames& frames = out_.frames;
  const int decimals = direction_decimals();
  const Vec3 written = written_direction();
  // longer vectors stay as long, shorter ones would lose digits
  const double length = std::max(1.0, written.norm());
  const auto rounded = [&](const Vec3& direction, double size) {
    Vec3 words = size * frames.vector_to_program(direction);
    for (double& word : words) word = abbe::rounded(word, decimals);
    return words;
  };
  const auto take = [&](const Vec3& words) {
    const auto answer = vectors_.turns_of(frames.vector_to_machine(words), from);
    for (std::size_t k = 0; k < 3; ++k) {
      stop.numbers[k] = words[static_cast<Eigen::Index>(k)];
      stop.turns[k] = answer.turns[k];
      if (!(std::abs(answer.turns[k] - meant[k]) <= kMostCorrection)) return false;
    }
    return answer.trouble == ToolVectors::Trouble::none;
  };
  const Vec3 best = vectors_.vector_of(wanted);
  const Vec3 off = length * (frames.vector_to_program(best) - written.normalized());
  const bool last = s >= 1;
  const bool stays = last && off.cwiseAbs().maxCoeff() <= half_digit(decimals);
  if (take(stays ? written : rounded(best, length))) return true;
  stop.held = true;
  if (take(last ? written : rounded(vectors_.vector_of(meant), length))) return true;
  refuse(direction_word(0), "E-VECTOR", "the digits of the tool's direction turn a rotary axis elsewhere",
         "near the direction of the rotary axis at the workpiece its position hangs on them",
         "post the block with rotary words (G43.4, A= C=)");
  return false;
}

void Rewriter::command_vector(const Piece& piece, bool first, std::string* extra) {
  for (std::size_t k = 0; k < 3; ++k) {
    const Word& word = direction_word(k);
    const double number = piece.turn_numbers[k];
    if (first && number == word.value) continue;
    if (!first) {
      *extra += ' ';
      *extra += block_->text.substr(word.begin, static_cast<std::size_t>(word.number - word.begin));
    }
    append_number(first ? edit_.replace(word) : *extra, number, direction_decimals(), block_->style);
  }
}

}  // namespace abbe
