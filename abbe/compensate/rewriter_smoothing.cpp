// What the control does to the path by itself: how far it may move the tool, as far as the program says.
#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "abbe/compensate/rewriter.h"
#include "abbe/core/number.h"

namespace abbe {
namespace {

constexpr double kAny = std::numeric_limits<double>::infinity();

/// The number behind `mark` in a code that is a word: "CTOL=0.01", "CYCLE832(0.01,3)", "32.1 T0.01".
std::optional<double> number_behind(std::string_view text, char mark) {
  for (std::size_t at = text.find(mark); at != std::string_view::npos; at = text.find(mark, at + 1)) {
    const std::size_t digits = std::min(text.find_first_not_of(" \t", at + 1), text.size());
    std::string spelled(text.substr(digits));
    std::replace(spelled.begin(), spelled.end(), ',', mark == 'T' ? '.' : ',');
    if (const Decimal number = read_decimal(spelled); number.length > 0) return number.value;
  }
  return std::nullopt;
}

}  // namespace

// How far the control may move the tool from here on, mm: 0 where the code switches smoothing off, infinity
// where it may be any distance; nullopt: the program does not say.
std::optional<double> Rewriter::smoothing_tolerance() const {
  const double unit = modal_.unit();
  const Word* p = instruction_.find(*block_, 'P');
  const Word* q = instruction_.find(*block_, 'Q');
  if (!instruction_.smooths) {
    // G64 P Q of controls that take them: without P the speed comes first, however far off
    for (int i = 0; i < block_->count; ++i) {
      const Word& word = block_->words[static_cast<std::size_t>(i)];
      const bool blends = word.letter == 'G' && word.value == 64 && p == nullptr &&
                          (profile_.g[640].words & letter_set("P")) != 0;
      if (blends) return kAny;
    }
    return std::max(p ? p->value * unit : 0.0, q ? q->value * unit : 0.0);
  }
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const double index = word.value * 10;
    if (word.letter != 'G' || index < static_cast<double>(Profile::kGCodes)) continue;
    const auto use = static_cast<std::size_t>(index + 0.5);
    if (use >= profile_.g.size() || profile_.g[use].meaning != Meaning::smoothing) continue;
    const std::string_view text =
        block_->text.substr(word.begin, static_cast<std::size_t>(word.end - word.begin));
    if (profile_.text.conversational) return number_behind(text, 'T').value_or(0) * unit;
    if (text.find("TOL") == 1 && text[0] != 'C' && text[0] != 'c') return std::nullopt;  // OTOL: an angle
    const char mark = text.find('(') != std::string_view::npos ? '(' : '=';
    const auto number = number_behind(text, mark);
    return number ? std::optional(*number * unit) : std::nullopt;
  }
  if (const Word* e = instruction_.find(*block_, 'E')) return e->value * unit;
  const Word* sets = q != nullptr ? q : p;
  return sets != nullptr && sets->value == 0 ? std::optional(0.0) : std::nullopt;
}

// Said once in a program.
void Rewriter::warn_of_smoothing() {
  const auto tolerance = smoothing_tolerance();
  if (tolerance && *tolerance <= job_.tolerance) return;
  smoothing_said_ = true;
  const std::string how_far = !tolerance           ? std::string()
                              : *tolerance == kAny ? std::string(", by any distance")
                                                   : fmt::format(", by up to {:.3g} um", *tolerance / um);
  warn("W-SMOOTH",
       fmt::format("from here on the control's own smoothing may move the tool{}: it is not modelled",
                   how_far),
       "it joins or rounds blocks within its tolerance, after the correction",
       "set that tolerance well below the one of the compensation");
}

}  // namespace abbe
