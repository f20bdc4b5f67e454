#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <string_view>

#include "abbe/core/number.h"
#include "abbe/program/block.h"

namespace abbe {

/// append_fixed as the program spells its numbers.
double append_number(std::string& to, double number, int decimals, NumberStyle style);

/// Changes to one line of a program: digits of words replaced, words added or removed; every other byte
/// stays. Begin with reset(); text() builds the line.
class LineEdit {
 public:
  void reset(const Block& block);
  /// Where the new number of a word goes: empty, to be appended to.
  [[nodiscard]] std::string& replace(const Word& word);
  /// The word gets this number; returns it as it will be read (append_fixed).
  double replace(const Word& word, double number, int decimals);
  void remove(const Word& word);
  /// Adds a word where the block ends its words (Block::words_end): what its number is appended to.
  [[nodiscard]] std::string& add(char letter);
  /// Adds already spelled words after the last one ("M30").
  void add(std::string_view words);

  [[nodiscard]] bool changed() const { return (replaced_ | removed_) != 0 || !added_.empty(); }
  /// The line without end-of-line bytes, appended to `out`.
  void append_to(std::string& out) const;

 private:
  [[nodiscard]] std::size_t index_of(const Word& word) const;

  const Block* block_ = nullptr;
  bool spaced_ = true;
  // Bit i = word i of the block; its new number is fixed_[i] if it is spelled later, else numbers_[i].
  static_assert(Block::kMaxWords <= 64);
  std::uint64_t replaced_ = 0, removed_ = 0, spelled_later_ = 0;
  std::array<FixedNumber, Block::kMaxWords> fixed_;
  std::array<std::string, Block::kMaxWords> numbers_;
  std::string added_;
};

}  // namespace abbe
