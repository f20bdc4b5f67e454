#include "abbe/cl/verify_statement.h"

#include <algorithm>
#include <cctype>
#include <cmath>

#include "abbe/core/number.h"

namespace abbe::cl::verifying {
namespace {

constexpr std::size_t kLongest = std::size_t{1} << 16;
constexpr std::string_view kBlanks = " \t\r\n";

std::string capitals(std::string_view text) {
  std::string result;
  for (const char c : text) result += static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return result;
}

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(kBlanks) - first + 1);
}

bool starts_number(std::string_view text) {
  const std::size_t at = text.find_first_not_of("+-.");
  return at != std::string_view::npos && text[at] >= '0' && text[at] <= '9';
}

/// Plain decimals and exponents with E or D.
std::optional<double> value_of(std::string_view text) {
  if (!starts_number(text)) return std::nullopt;
  std::string plain = capitals(text);
  std::replace(plain.begin(), plain.end(), 'D', 'E');
  if (plain.find_first_not_of("0123456789+-.E") != std::string::npos) return std::nullopt;
  return read_number(plain.starts_with('+') ? std::string_view(plain).substr(1) : std::string_view(plain));
}

bool is_text_word(std::string_view word) {
  for (const char* text :
       {"PARTNO", "PPRINT", "REMARK", "INSERT", "PPFUN", "TPRINT", "LETTER", "TITLES", "DISPLY"}) {
    if (word == text) return true;
  }
  return false;
}

std::string first_word(std::string_view text) {
  std::size_t end = 0;
  const auto in_word = [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-';
  };
  while (end < text.size() && in_word(text[end])) ++end;
  return capitals(text.substr(0, end));
}

/// Fields between commas, and the skeleton of the statement.
void read_fields(std::string_view data, Statement& statement) {
  const std::size_t slash = data.find('/');
  statement.word = capitals(trimmed(data.substr(0, std::min(slash, data.size()))));
  statement.skeleton = statement.word;
  // "TOOL   PATH" is one word
  if (const std::size_t gap = statement.word.find_first_of(kBlanks); gap != std::string::npos) {
    statement.word = statement.word.substr(0, gap) + ' ' + std::string(trimmed(statement.word.substr(gap)));
  }
  if (slash == std::string_view::npos) return;
  statement.skeleton += '/';
  std::string_view rest = data.substr(slash + 1);
  if (trimmed(rest).empty()) return;
  for (bool more = true; more;) {
    const std::size_t comma = rest.find(',');
    more = comma != std::string_view::npos;
    const std::string_view text = trimmed(rest.substr(0, comma));
    statement.fields.push_back({capitals(text), value_of(text)});
    statement.skeleton += statement.fields.back().value ? "#" : std::string(text);
    if (!more) break;
    statement.skeleton += ',';
    rest.remove_prefix(comma + 1);
  }
}

}  // namespace

bool Statement::numbers(std::size_t count) const {
  return fields.size() >= count &&
         std::all_of(fields.begin(), fields.begin() + static_cast<std::ptrdiff_t>(count),
                     [](const Field& f) { return f.value.has_value(); });
}

bool Statement::has(std::string_view text) const {
  return std::any_of(fields.begin(), fields.end(), [&](const Field& f) { return f.text == text; });
}

Diagnostic finding(const std::string& file, const Statement& at, const char* code, std::string message,
                   std::string why, std::string fix) {
  Place place;
  place.file = file;
  place.line = at.line;
  place.column = 1;
  place.source_line = at.bytes.substr(0, std::min(at.bytes.find_first_of("\r\n"), at.bytes.size()));
  return {Severity::error, code, std::move(place), std::move(message), std::move(why), std::move(fix)};
}

std::optional<Statement> StatementReader::next() {
  Statement statement;
  std::string data;
  while (const auto line = reader_.next()) {
    if (statement.bytes.empty()) statement.line = reader_.line_number();
    statement.bytes += *line;
    if (statement.bytes.size() > kLongest || reader_.too_long() ||
        line->find('\0') != std::string_view::npos) {
      fault_ = finding(name_, statement, "E-LINELEN", "a statement of more than 64 KiB, or with a zero byte",
                       "it is no CL data", "check the file");
      return std::nullopt;
    }
    const std::string_view text = trimmed(*line);
    if (data.empty() && is_text_word(first_word(text))) {
      statement.word = first_word(text);
      statement.free_text = true;
      return statement;
    }
    const std::size_t mark = text.find('$');
    data += text.substr(0, std::min(mark, text.size()));
    data += ' ';
    const bool remark = mark != std::string_view::npos && text.substr(mark, 2) == "$$";
    if (remark) statement.remark = text.substr(mark);
    if (mark != std::string_view::npos && !remark) continue;  // goes on in the next line
    if (!trimmed(data).empty()) read_fields(trimmed(data), statement);
    return statement;
  }
  if (!statement.bytes.empty())
    fault_ = finding(name_, statement, "E-CONTINUE", "the file ends in a statement that '$' continues",
                     "what follows is missing", "write the file again");
  if (reader_.error())
    fault_ =
        finding(name_, statement, "E-FILE", reader_.error()->message, "", "check the file and its medium");
  return std::nullopt;
}

}  // namespace abbe::cl::verifying
