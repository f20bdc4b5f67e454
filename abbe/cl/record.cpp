#include "abbe/cl/record.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/core/number.h"

namespace abbe::cl {
namespace {

constexpr std::array<std::string_view, 9> kTextMajors = {"PARTNO", "PPRINT", "REMARK", "INSERT", "PPFUN",
                                                         "TPRINT", "LETTER", "TITLES", "DISPLY"};

bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }
bool is_letter(char c) { return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z'); }
bool is_digit(char c) { return c >= '0' && c <= '9'; }
bool in_major(char c) { return is_letter(c) || is_digit(c) || c == '_' || c == '-'; }
char upper(char c) { return c >= 'a' && c <= 'z' ? static_cast<char>(c - 'a' + 'A') : c; }

std::string upper(std::string_view text) {
  std::string result(text);
  std::transform(result.begin(), result.end(), result.begin(), [](char c) { return upper(c); });
  return result;
}

std::size_t skip_blanks(std::string_view text, std::size_t at) {
  while (at < text.size() && is_blank(text[at])) ++at;
  return at;
}

/// "1.5E-3", "1.5D+02": the exponent of Fortran's writers. Its length; 0 if there is none.
std::size_t exponent_length(std::string_view text) {
  if (text.size() < 2 || (upper(text[0]) != 'E' && upper(text[0]) != 'D')) return 0;
  std::size_t at = text[1] == '+' || text[1] == '-' ? 2 : 1;
  const std::size_t first = at;
  while (at < text.size() && is_digit(text[at])) ++at;
  return at > first && at - first <= 3 ? at : 0;
}

/// The whole text as a number, or false.
bool read_item_number(std::string_view text, Item& item) {
  const Decimal decimal = read_decimal(text);
  if (decimal.length == 0) return false;
  item.value = decimal.value;
  item.decimals = decimal.decimals;
  item.trailing_zero = decimal.decimals > 0 && text[decimal.length - 1] == '0';
  if (decimal.length == text.size()) return true;
  const std::string_view rest = text.substr(decimal.length);
  if (exponent_length(rest) != rest.size()) return false;
  std::string general(text);
  general[decimal.length] = 'e';
  const auto value = read_number(general);
  if (!value) return false;
  item.value = *value;
  return true;
}

}  // namespace

std::string_view end_of_line(std::string_view line) {
  std::size_t size = line.size();
  while (size > 0 && (line[size - 1] == '\n' || line[size - 1] == '\r')) --size;
  return line.substr(size);
}

bool is_text_major(std::string_view major) {
  return std::find(kTextMajors.begin(), kTextMajors.end(), major) != kTextMajors.end();
}

std::size_t Record::leading_numbers() const {
  const auto word =
      std::find_if(items.begin(), items.end(), [](const Item& item) { return !item.is_number; });
  return static_cast<std::size_t>(word - items.begin());
}

RecordReader::State RecordReader::fail(const char* code, std::size_t at, std::string message, const char* why,
                                       const char* fix) {
  open_ = false;
  error_ = {code, std::min(at, record_.bytes.size()), 1, std::move(message), why, fix};
  return State::error;
}

RecordReader::State RecordReader::add(std::string_view line, std::uint64_t number) {
  if (!open_) {
    record_ = Record{};
    record_.line = number;
    data_.clear();
  }
  const std::size_t at = record_.bytes.size();
  record_.bytes += line;
  ++record_.line_count;
  if (record_.bytes.size() > kMaxBytes)
    return fail("E-LINELEN", at, "the record is longer than 64 KiB",
                "no writer of CL data makes such records", "check that this is a CL file");
  if (const std::size_t zero = line.find('\0'); zero != std::string_view::npos)
    return fail("E-CHAR", at + zero, "a zero byte", "the text is damaged, or no CL data",
                "write the CL file again");
  data_ += line;
  if (!open_) {
    // A text record ends with its line: '$' is text in it.
    read_major();
    if (record_.is_text || record_.is_remark()) return parse();
    if (data_[record_.major_begin] == '$')
      return fail("E-CONTINUE", record_.major_begin, "'$' with nothing before it",
                  "whether the next line is a record of its own depends on the reader", "remove the '$'");
  }
  const std::size_t dollar = data_.find('$', at);
  open_ = dollar != std::string::npos && (dollar + 1 >= data_.size() || data_[dollar + 1] != '$');
  if (dollar != std::string::npos)
    std::fill(data_.begin() + static_cast<std::ptrdiff_t>(dollar), data_.end(), ' ');
  return open_ ? State::wants_more : parse();
}

RecordReader::State RecordReader::finish() {
  if (!open_) return State::complete;
  return fail("E-CONTINUE", record_.bytes.size(), "the file ends in a record that '$' continues",
              "what follows is missing", "write the CL file again");
}

/// Returns where the data begins.
std::size_t RecordReader::read_major() {
  const std::size_t begin = skip_blanks(data_, 0);
  record_.major_begin = begin;
  if (begin == data_.size() || data_.compare(begin, 2, "$$") == 0) {
    const std::size_t text = std::min(begin + 2, data_.size());
    record_.text =
        data_.substr(text, data_.size() - text - end_of_line(data_).size() * (text < data_.size() ? 1 : 0));
    return data_.size();
  }
  std::size_t end = begin;
  while (end < data_.size() && in_major(data_[end])) ++end;
  record_.major = upper(std::string_view(data_).substr(begin, end - begin));
  if (record_.major == "TOOL") {
    const std::size_t second = skip_blanks(data_, end);
    if (second > end && data_.compare(second, 4, "PATH") == 0) {
      record_.major = "TOOL PATH";
      end = second + 4;
    }
  }
  if (end == begin) record_.major = "?";
  record_.is_text = is_text_major(record_.major);
  return end;
}

RecordReader::State RecordReader::parse() {
  open_ = false;
  if (record_.is_remark()) return State::complete;
  const std::size_t end = read_major();
  if (record_.is_text) {
    std::string_view rest = std::string_view(data_).substr(end);
    rest.remove_suffix(std::min(rest.size(), end_of_line(rest).size()));
    while (!rest.empty() && is_blank(rest.back())) rest.remove_suffix(1);
    if (rest.ends_with('$') && !rest.ends_with("$$"))
      return fail("E-CONTINUE", end + rest.size() - 1, record_.major + " ends with '$'",
                  "whether the next line is text or a record depends on the reader", "remove the '$'");
    record_.text = std::string(rest);
    return State::complete;
  }
  const std::size_t slash = skip_blanks(data_, end);
  if (slash == data_.size()) return State::complete;
  if (data_[slash] != '/') {
    record_.is_plain = false;
    return State::complete;
  }
  record_.has_slash = true;
  read_items(slash + 1);
  return State::complete;
}

void RecordReader::read_items(std::size_t from) {
  if (skip_blanks(data_, from) == data_.size()) return;  // "RAPID/"
  std::size_t begin = from;
  for (std::size_t at = from; at <= data_.size(); ++at) {
    if (at < data_.size() && data_[at] != ',') continue;
    add_item(begin, at);
    begin = at + 1;
  }
}

void RecordReader::add_item(std::size_t begin, std::size_t end) {
  while (begin < end && is_blank(data_[begin])) ++begin;
  while (end > begin && is_blank(data_[end - 1])) --end;
  Item item;
  item.begin = begin;
  item.end = end;
  const std::string_view text = std::string_view(data_).substr(begin, end - begin);
  item.is_number = read_item_number(text, item);
  if (!item.is_number) item.word = upper(text);
  record_.items.push_back(std::move(item));
}

}  // namespace abbe::cl
