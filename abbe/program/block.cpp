#include "abbe/program/block.h"

#include <fmt/format.h>

#include "abbe/core/number.h"

namespace abbe {
namespace {

enum class Kind : std::uint8_t { bad, blank, letter, digit, open, semicolon, percent, slash, expression };

constexpr std::array<Kind, 256> make_kinds() {
  std::array<Kind, 256> kinds{};
  for (auto& kind : kinds) kind = Kind::bad;
  for (const char c : {' ', '\t', '\r'}) kinds[static_cast<unsigned char>(c)] = Kind::blank;
  for (int c = 'A'; c <= 'Z'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::letter;
  for (int c = 'a'; c <= 'z'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::letter;
  for (int c = '0'; c <= '9'; ++c) kinds[static_cast<std::size_t>(c)] = Kind::digit;
  for (const char c : {'+', '-', '.'}) kinds[static_cast<unsigned char>(c)] = Kind::digit;
  for (const char c : {'#', '[', ']', '=', '<', '>', '*'})
    kinds[static_cast<unsigned char>(c)] = Kind::expression;
  kinds['('] = Kind::open;
  kinds[';'] = Kind::semicolon;
  kinds['%'] = Kind::percent;
  kinds['/'] = Kind::slash;
  return kinds;
}
constexpr std::array<Kind, 256> kKinds = make_kinds();

Kind kind_of(char c) { return kKinds[static_cast<unsigned char>(c)]; }

std::size_t skip_blanks(std::string_view text, std::size_t at) {
  while (at < text.size() && kind_of(text[at]) == Kind::blank) ++at;
  return at;
}

BlockError bad_character(std::string_view text, std::size_t at) {
  const auto byte = static_cast<unsigned char>(text[at]);
  if (text[at] == '*') {
    return {"E-CHAR",
            at,
            1,
            "'*': checksums of lines are not read",
            "a block that is changed would need another one, and those behind it other numbers",
            "write the program without checksums: senders add them"};
  }
  if (kind_of(text[at]) == Kind::expression) {
    return {"E-EXPR",
            at,
            1,
            fmt::format("'{}': variables and expressions are not literal numbers", text[at]),
            "where the axes go depends on values that only the control knows when the program runs",
            "post the program with literal coordinates (loops and variables resolved)"};
  }
  const std::string what =
      byte >= 0x20 && byte < 0x7f ? fmt::format("'{}'", text[at]) : fmt::format("byte 0x{:02X}", byte);
  return {"E-CHAR",
          at,
          1,
          what + " outside a comment",
          "this is not RS274/NGC, so its meaning is unknown",
          "remove it, or put it into a comment"};
}

/// A number with blanks inside ("1 . 5"), which RS274 reads as if they were not there.
bool read_spaced_number(std::string_view text, std::size_t at, Word& word, std::size_t& end) {
  std::array<char, kMaxBlockBytes + 2> compact{};
  std::size_t n = 0, last = at;
  for (std::size_t i = at; i < text.size() && n < kMaxBlockBytes; ++i) {
    const Kind kind = kind_of(text[i]);
    if (kind == Kind::blank) continue;
    if (kind != Kind::digit || (n > 0 && (text[i] == '+' || text[i] == '-'))) break;
    compact[n++] = text[i];
    last = i + 1;
  }
  const Decimal decimal = read_decimal(std::string_view(compact.data(), n));
  if (decimal.length == 0 || decimal.length != n) return false;
  word.value = decimal.value;
  word.decimals = static_cast<std::uint16_t>(decimal.decimals);
  word.tidy = false;
  end = last;
  return true;
}

/// Usual words: a letter, at once its number, then the end or a blank and the next letter. Reads as many as
/// there are from `at` on and returns where they end.
std::size_t read_plain_words(std::string_view text, std::size_t at, Block& block) {
  const char* const begin = text.data();
  const char* const end = begin + text.size();
  const char* p = begin + at;
  const auto is_capital = [](char c) { return c >= 'A' && c <= 'Z'; };
  int count = block.count;
  while (p != end && is_capital(*p) && count < Block::kMaxWords) {
    Word& word = block.words[static_cast<std::size_t>(count)];
    int decimals = 0;
    const char* const behind = read_plain_decimal(begin, p + 1, end, word.value, decimals);
    if (behind == nullptr) break;
    const char* const next = behind + (behind != end && *behind == ' ' ? 1 : 0);
    if (next != end && !is_capital(*next)) break;
    word.letter = *p;
    word.tidy = true;
    word.begin = static_cast<std::uint16_t>(p - begin);
    word.number = static_cast<std::uint16_t>(word.begin + 1);
    word.end = block.words_end = static_cast<std::uint16_t>(behind - begin);
    word.decimals = static_cast<std::uint16_t>(decimals);
    p = next;
    ++count;
  }
  block.count = count;
  return static_cast<std::size_t>(p - begin);
}

BlockError no_number(char letter, std::size_t at) {
  return {"E-NUMBER",
          at,
          1,
          fmt::format("the letter {} is not followed by a number", letter),
          "a word is a letter and a number",
          "complete the word or remove it"};
}

}  // namespace

std::string_view without_eol(std::string_view line) {
  while (!line.empty() && (line.back() == '\n' || line.back() == '\r')) line.remove_suffix(1);
  return line;
}

std::optional<BlockError> begin_block(std::string_view line, Block& block) {
  block.text = without_eol(line);
  block.eol = line.substr(block.text.size());
  block.slash = block.percent = block.has_comment = block.has_semicolon = false;
  block.slash_begin = block.slash_end = block.words_end = 0;
  block.count = 0;
  block.increments = block.places = 0;
  if (block.text.size() <= kMaxBlockBytes) return std::nullopt;
  return BlockError{"E-LINELEN",
                    kMaxBlockBytes,
                    1,
                    fmt::format("the line has {} bytes, {} is the limit", block.text.size(), kMaxBlockBytes),
                    "the control refuses longer lines",
                    "break the block into two"};
}

namespace {

std::optional<BlockError> read_words(std::string_view line, Block& block, bool numbered_skip) {
  if (auto error = begin_block(line, block)) return error;
  const std::string_view text = block.text;
  std::size_t at = skip_blanks(text, 0);
  if (at < text.size() && text[at] == '%') {
    const std::size_t rest = skip_blanks(text, at + 1);
    if (rest < text.size()) return bad_character(text, rest);
    block.percent = true;
    return std::nullopt;
  }
  if (at < text.size() && text[at] == '/') {
    block.slash = true;
    block.slash_begin = static_cast<std::uint16_t>(at++);
    if (numbered_skip && at < text.size() && text[at] >= '1' && text[at] <= '9') ++at;
    block.slash_end = block.words_end = static_cast<std::uint16_t>(at);
  }
  while (at < text.size()) {
    const char c = text[at];
    if (c == ' ') {
      ++at;
      continue;
    }
    const std::size_t behind = read_plain_words(text, at, block);
    if (behind != at) {
      at = behind;
      continue;
    }
    at = skip_blanks(text, at);
    if (at == text.size()) break;
    switch (kind_of(text[at])) {
      case Kind::semicolon:
        block.has_comment = block.has_semicolon = true;
        return std::nullopt;
      case Kind::open: {
        const std::size_t close = text.find(')', at);
        if (close == std::string_view::npos) {
          return BlockError{"E-COMMENT",
                            at,
                            1,
                            "the comment is not closed on its line",
                            "what follows could be program or comment",
                            "add ')'"};
        }
        const std::size_t nested = text.find('(', at + 1);
        if (nested < close) {
          return BlockError{"E-COMMENT",
                            nested,
                            1,
                            "'(' inside a comment",
                            "comments do not nest: controls read this differently",
                            "use other brackets inside comments"};
        }
        block.has_comment = true;
        at = close + 1;
        break;
      }
      case Kind::letter: {
        if (block.count == Block::kMaxWords) {
          return BlockError{"E-BLOCK",
                            at,
                            1,
                            fmt::format("more than {} words in one block", Block::kMaxWords),
                            "no control accepts such a block",
                            "break the block into several"};
        }
        Word& word = block.words[static_cast<std::size_t>(block.count)];
        word.letter = text[at] >= 'a' ? static_cast<char>(text[at] - 'a' + 'A') : text[at];
        word.begin = static_cast<std::uint16_t>(at);
        word.tidy = true;
        std::size_t number = at + 1;
        if (number >= text.size() || kind_of(text[number]) != Kind::digit) {
          number = skip_blanks(text, number);
          if (number >= text.size()) return no_number(word.letter, at);
          if (kind_of(text[number]) == Kind::expression) return bad_character(text, number);
        }
        const Decimal decimal = read_decimal(text.substr(number));
        word.number = static_cast<std::uint16_t>(number);
        std::size_t end = number + decimal.length;
        const std::size_t next = skip_blanks(text, end);
        if (decimal.length == 0 || (next < text.size() && kind_of(text[next]) == Kind::digit)) {
          if (!read_spaced_number(text, number, word, end)) {
            if (number < text.size() && kind_of(text[number]) != Kind::letter &&
                kind_of(text[number]) != Kind::digit && kind_of(text[number]) != Kind::open &&
                kind_of(text[number]) != Kind::semicolon) {
              return bad_character(text, number);
            }
            return no_number(word.letter, at);
          }
        } else {
          word.value = decimal.value;
          word.decimals = static_cast<std::uint16_t>(decimal.decimals);
        }
        word.end = static_cast<std::uint16_t>(end);
        block.words_end = word.end;
        ++block.count;
        at = end;
        break;
      }
      case Kind::slash:
        return BlockError{"E-SLASH",
                          at,
                          1,
                          "'/' in the middle of a block",
                          "block delete stands at the start of a line",
                          "move it to the start or remove it"};
      default:
        return bad_character(text, at);
    }
  }
  return std::nullopt;
}

}  // namespace

std::optional<BlockError> read_block(std::string_view line, Block& block, bool numbered_skip) {
  std::optional<BlockError> error = read_words(line, block, numbered_skip);
  if (!error || (error->code != std::string_view("E-NUMBER") && error->code != std::string_view("E-EXPR")))
    return error;
  // O100 SUB, O<NAME> CALL: what is not a word belongs to the subprogram or loop.
  const std::string_view text = block.text;
  std::size_t at = block.count == 0 ? skip_blanks(text, block.slash_end) : block.words[0].begin;
  if (block.count > 0 && block.words[0].letter == 'N') at = skip_blanks(text, block.words[0].end);
  if (at >= text.size() || (text[at] != 'O' && text[at] != 'o')) return error;
  return BlockError{"E-OWORD",
                    at,
                    1,
                    "subprograms and flow control are not followed",
                    "where the axes go depends on how the program runs",
                    "post the program without loops and calls"};
}

}  // namespace abbe
