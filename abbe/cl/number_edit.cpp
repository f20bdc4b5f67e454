#include "abbe/cl/number_edit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "abbe/core/number.h"

namespace abbe::cl {
namespace {

constexpr std::size_t kLastColumn = 72;
constexpr int kMostDecimals = 12;
constexpr std::string_view kIndent = "      ";

double half_digit(int decimals) {
  static constexpr std::array<double, kMostDecimals + 1> kHalf = {
      0.5, 0.5e-1, 0.5e-2, 0.5e-3, 0.5e-4, 0.5e-5, 0.5e-6, 0.5e-7, 0.5e-8, 0.5e-9, 0.5e-10, 0.5e-11, 0.5e-12};
  // the last part keeps a tie from being written again and again
  return kHalf[static_cast<std::size_t>(decimals)] * (1 + 1e-6);
}

/// Bytes of the longest line, end of line not counted.
std::size_t longest_line(std::string_view bytes) {
  std::size_t longest = 0;
  while (!bytes.empty()) {
    const std::size_t end = std::min(bytes.find('\n'), bytes.size() - 1) + 1;
    const std::string_view line = bytes.substr(0, end);
    longest = std::max(longest, line.size() - end_of_line(line).size());
    bytes.remove_prefix(end);
  }
  return longest;
}

}  // namespace

double NumberEdit::set(std::size_t item, double value, int least_decimals) {
  const Item& old = record_->items[item];
  const int decimals = std::clamp(std::max(old.decimals, least_decimals), 0, kMostDecimals);
  if (std::abs(value - old.value) <= half_digit(decimals) || rounded(value, decimals) == old.value) {
    texts_[item].clear();
    return old.value;
  }
  std::string& text = texts_[item];
  text.clear();
  const double written = append_fixed(text, value, decimals);
  if (!old.trailing_zero) {
    while (text.back() == '0') text.pop_back();
  }
  changed_ = true;
  return written;
}

std::string NumberEdit::join(bool broken) const {
  const std::string_view bytes = record_->bytes;
  const std::string_view eol = end_of_line(bytes).empty() ? std::string_view("\n") : end_of_line(bytes);
  std::string out;
  std::size_t at = 0, line_begin = 0;
  for (std::size_t i = 0; i < texts_.size(); ++i) {
    const Item& item = record_->items[i];
    const std::string_view between = bytes.substr(at, item.begin - at);
    out += between;
    if (between.find('\n') != std::string_view::npos) line_begin = out.rfind('\n') + 1;
    const std::string_view text =
        texts_[i].empty() ? bytes.substr(item.begin, item.end - item.begin) : std::string_view(texts_[i]);
    // one more column for the comma, one for '$'
    if (broken && i > 0 && out.size() - line_begin + text.size() + 2 > kLastColumn) {
      out += '$';
      out += eol;
      line_begin = out.size();
      out += kIndent;
    }
    out += text;
    at = item.end;
  }
  out += bytes.substr(at);
  return out;
}

std::string NumberEdit::bytes() const {
  if (!changed_) return record_->bytes;
  std::string text = join(false);
  if (longest_line(text) > kLastColumn && longest_line(record_->bytes) <= kLastColumn) text = join(true);
  return text;
}

}  // namespace abbe::cl
