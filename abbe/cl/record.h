#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace abbe::cl {

/// What stands between two commas of a record: a number, or a word.
struct Item {
  bool is_number = false;
  double value = 0;
  int decimals = 0;                ///< digits after the point
  bool trailing_zero = false;      ///< "1.50": its writer does not strip zeros
  std::size_t begin = 0, end = 0;  ///< in Record::bytes, blanks around it left out
  std::string word;                ///< upper case; numbers: empty
};

/// Why bytes are no record: where in them, what, why it matters, what to do.
struct RecordError {
  std::string code;
  std::size_t begin = 0, length = 1;  ///< in Record::bytes
  std::string message, why, fix;
};

/// One statement of an APT or CLSF file: `MAJOR/item,item,..`, over as many lines as `$` continues it.
struct Record {
  std::string bytes;       ///< of all its lines, ends of line included
  std::uint64_t line = 0;  ///< of its first line, from 1
  std::uint64_t line_count = 0;
  std::string major;  ///< upper case; empty: a blank line or a remark
  std::size_t major_begin = 0;
  bool has_slash = false;
  bool is_text = false;  ///< PARTNO and its like: the rest of the line is text, not items
  bool is_plain = true;  ///< false: something follows the major word that is neither '/' nor the end
  std::string text;      ///< of text records and remarks: what follows the major word, `$$` or '/'
  std::vector<Item> items;

  [[nodiscard]] bool is_remark() const { return major.empty(); }
  /// The numbers before the first word.
  [[nodiscard]] std::size_t leading_numbers() const;
};

/// Puts lines together to records. Blanks around items are free; a blank inside a number is an error, because
/// readers differ on it (some drop blanks, some drop what stands behind column 72).
/// laws   EveryByteIsKept: the bytes of all records are those of the file
/// cost   linear; a record has at most kMaxBytes bytes
/// source docs/cl-data.md, section The text
class RecordReader {
 public:
  static constexpr std::size_t kMaxBytes = std::size_t{1} << 16;

  enum class State { complete, wants_more, error };

  /// Adds a line with its end-of-line bytes. After `complete` or `error` the next line begins a new record.
  [[nodiscard]] State add(std::string_view line, std::uint64_t number);
  /// At the end of the file: an open continuation is an error.
  [[nodiscard]] State finish();

  [[nodiscard]] const Record& record() const { return record_; }
  [[nodiscard]] const RecordError& error() const { return error_; }

 private:
  [[nodiscard]] State fail(const char* code, std::size_t at, std::string message, const char* why,
                           const char* fix);
  [[nodiscard]] State parse();
  std::size_t read_major();
  void read_items(std::size_t from);
  void add_item(std::size_t begin, std::size_t end);

  Record record_;
  RecordError error_;
  std::string data_;  ///< the bytes with remarks, `$` and ends of line blanked
  bool open_ = false;
};

/// The end-of-line bytes at the end of a line: "\r\n", "\n" or nothing.
[[nodiscard]] std::string_view end_of_line(std::string_view line);

/// Majors whose rest of the line is text: PARTNO PPRINT REMARK INSERT PPFUN TPRINT LETTER TITLES DISPLY.
[[nodiscard]] bool is_text_major(std::string_view major);

}  // namespace abbe::cl
