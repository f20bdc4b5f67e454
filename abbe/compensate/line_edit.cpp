#include "abbe/compensate/line_edit.h"

#include <bit>
#include <cstring>

namespace abbe {
namespace {

/// The bytes of most pieces between numbers: a blank and a letter.
constexpr std::size_t kShortPiece = 3;

}  // namespace

double append_number(std::string& to, double number, int decimals, NumberStyle style) {
  const std::size_t begin = to.size();
  const double read = append_fixed(to, number, decimals);
  if (style.comma) {
    if (const std::size_t point = to.find('.', begin); point != std::string::npos) to[point] = ',';
  }
  if (style.sign && to[begin] != '-') to.insert(begin, 1, '+');
  return read;
}

void LineEdit::reset(const Block& block) {
  block_ = &block;
  replaced_ = removed_ = spelled_later_ = 0;
  added_.clear();
  // "G1X1Y2" gets "Z3", "G1 X1 Y2" and "X1" get " Z3".
  spaced_ = block.style.sign || block.count < 2 || block.words[1].begin != block.words[0].end;
}

std::size_t LineEdit::index_of(const Word& word) const {
  return static_cast<std::size_t>(&word - block_->words.data());
}

std::string& LineEdit::replace(const Word& word) {
  const std::size_t i = index_of(word);
  replaced_ |= std::uint64_t{1} << i;
  spelled_later_ &= ~(std::uint64_t{1} << i);
  numbers_[i].clear();
  return numbers_[i];
}

double LineEdit::replace(const Word& word, double number, int decimals) {
  const std::size_t i = index_of(word);
  const NumberStyle style = block_->style;
  if (style.sign || !to_fixed(number, decimals, fixed_[i]))
    return append_number(replace(word), number, decimals, style);
  replaced_ |= std::uint64_t{1} << i;
  spelled_later_ |= std::uint64_t{1} << i;
  return fixed_[i].value;
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
  // Room for all there is, then what was written: one growth of the string instead of one per word.
  std::size_t room =
      text.size() + added_.size() + kFixedRoom * static_cast<std::size_t>(std::popcount(spelled_later_));
  for (std::uint64_t left = replaced_ & ~spelled_later_; left != 0; left &= left - 1)
    room += numbers_[static_cast<std::size_t>(std::countr_zero(left))].size();
  const std::size_t begin = out.size();
  out.resize(begin + room);
  char* to = out.data() + begin;
  const auto write = [&to](std::string_view bytes) {
    if (bytes.size() > kShortPiece) {
      std::memcpy(to, bytes.data(), bytes.size());
    } else {
      for (std::size_t i = 0; i < bytes.size(); ++i) to[i] = bytes[i];
    }
    to += bytes.size();
  };
  std::size_t at = 0;
  bool to_add = true;
  const auto add_words = [&] {
    to_add = false;
    write(text.substr(at, block_->words_end - at));
    write(added_);
    at = block_->words_end;
  };
  for (std::uint64_t left = replaced_ | removed_; left != 0; left &= left - 1) {
    const auto i = static_cast<std::size_t>(std::countr_zero(left));
    const Word& word = block_->words[i];
    if (to_add && word.begin >= block_->words_end) add_words();
    if ((removed_ >> i & 1) != 0) {
      std::size_t end = word.begin;
      while (end > at && (text[end - 1] == ' ' || text[end - 1] == '\t')) --end;
      write(text.substr(at, end - at));
    } else {
      write(text.substr(at, word.number - at));
      if ((spelled_later_ >> i & 1) != 0) {
        to = write_fixed(to, fixed_[i]);
      } else {
        write(numbers_[i]);
      }
    }
    at = word.end;
  }
  if (to_add) add_words();
  write(text.substr(at));
  out.resize(static_cast<std::size_t>(to - out.data()));
}

}  // namespace abbe
