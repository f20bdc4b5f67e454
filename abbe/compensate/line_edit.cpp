#include "abbe/compensate/line_edit.h"

namespace abbe {

void LineEdit::reset(const Block& block) {
  block_ = &block;
  if (changed_) {
    for (auto& change : changes_) {
      change.replaced = change.removed = false;
      change.number.clear();
    }
    added_.clear();
    changed_ = false;
  }
  // "G1X1Y2" gets "Z3", "G1 X1 Y2" and "X1" get " Z3".
  spaced_ = block.count < 2 || block.words[1].begin != block.words[0].end;
}

std::size_t LineEdit::index_of(const Word& word) const { return static_cast<std::size_t>(&word - block_->words.data()); }

void LineEdit::replace(const Word& word, std::string_view number) {
  Change& change = changes_[index_of(word)];
  change.replaced = true;
  change.number = number;
  changed_ = true;
}

void LineEdit::remove(const Word& word) {
  changes_[index_of(word)].removed = true;
  changed_ = true;
}

void LineEdit::add(char letter, std::string_view number) {
  if (spaced_) added_ += ' ';
  added_ += letter;
  added_ += number;
  changed_ = true;
}

void LineEdit::add(std::string_view words) {
  if (spaced_) added_ += ' ';
  added_ += words;
  changed_ = true;
}

void LineEdit::append_to(std::string& out) const {
  const std::string_view text = block_->text;
  if (!changed_) {
    out += text;
    return;
  }
  std::size_t at = 0;
  for (int i = 0; i < block_->count; ++i) {
    const Word& word = block_->words[static_cast<std::size_t>(i)];
    const Change& change = changes_[static_cast<std::size_t>(i)];
    if (change.removed) {
      std::size_t begin = word.begin;
      while (begin > at && (text[begin - 1] == ' ' || text[begin - 1] == '\t')) --begin;
      out += text.substr(at, begin - at);
      at = word.end;
    } else if (change.replaced) {
      out += text.substr(at, word.number - at);
      out += change.number;
      at = word.end;
    }
  }
  out += text.substr(at, block_->words_end - at);
  out += added_;
  out += text.substr(block_->words_end);
}

}  // namespace abbe
