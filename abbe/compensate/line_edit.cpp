#include "abbe/compensate/line_edit.h"

#include <bit>

namespace abbe {

void LineEdit::reset(const Block& block) {
  block_ = &block;
  replaced_ = removed_ = 0;
  added_.clear();
  // "G1X1Y2" gets "Z3", "G1 X1 Y2" and "X1" get " Z3".
  spaced_ = block.count < 2 || block.words[1].begin != block.words[0].end;
}

std::size_t LineEdit::index_of(const Word& word) const { return static_cast<std::size_t>(&word - block_->words.data()); }

std::string& LineEdit::replace(const Word& word) {
  const std::size_t i = index_of(word);
  replaced_ |= std::uint64_t{1} << i;
  numbers_[i].clear();
  return numbers_[i];
}

void LineEdit::remove(const Word& word) { removed_ |= std::uint64_t{1} << index_of(word); }

std::string& LineEdit::add(char letter) {
  if (spaced_) added_ += ' ';
  added_ += letter;
  return added_;
}

void LineEdit::add(std::string_view words) {
  if (spaced_) added_ += ' ';
  added_ += words;
}

void LineEdit::append_to(std::string& out) const {
  const std::string_view text = block_->text;
  if (!changed()) {
    out += text;
    return;
  }
  std::size_t at = 0;
  for (std::uint64_t left = replaced_ | removed_; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const Word& word = block_->words[i];
    if ((removed_ >> i & 1) != 0) {
      std::size_t begin = word.begin;
      while (begin > at && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
      out += text.substr(at, begin - at);
    } else {
      out += text.substr(at, word.number - at);
      out += numbers_[i];
    }
    at = word.end;
  }
  out += text.substr(at, block_->words_end - at);
  out += added_;
  out += text.substr(block_->words_end);
}

}  // namespace abbe
