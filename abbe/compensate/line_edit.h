#pragma once

#include <array>
#include <string>
#include <string_view>

#include "abbe/program/block.h"

namespace abbe {

/// Changes to one line of a program: digits of words replaced, words added or removed; every other byte
/// stays. Begin with reset(); text() builds the line.
class LineEdit {
 public:
  void reset(const Block& block);
  void replace(const Word& word, std::string_view number);
  void remove(const Word& word);
  /// Adds a word after the last one.
  void add(char letter, std::string_view number);
  /// Adds already spelled words after the last one ("M30").
  void add(std::string_view words);

  [[nodiscard]] bool changed() const { return changed_; }
  /// The line without end-of-line bytes, appended to `out`.
  void append_to(std::string& out) const;

 private:
  [[nodiscard]] std::size_t index_of(const Word& word) const;

  const Block* block_ = nullptr;
  bool changed_ = false;
  bool spaced_ = true;
  struct Change {
    bool replaced = false, removed = false;
    std::string number;
  };
  std::array<Change, Block::kMaxWords> changes_;
  std::string added_;
};

}  // namespace abbe
