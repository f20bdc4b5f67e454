#include "csv.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <utility>
#include <variant>

#include "abbe/core/number.h"
#include "session.h"

namespace abbe::app {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";

bool is_blank(std::string_view text) { return text.find_first_not_of(" \t") == std::string_view::npos; }

/// Puts a pipe in the place of standard input, so that an interrupt ends the wait for it, too. False: it is
/// none, or cannot be opened.
bool stand_in_for_standard_input(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0 || !S_ISFIFO(status.st_mode)) return false;
  int pipe = -1;
  do pipe = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  while (pipe < 0 && errno == EINTR && !interrupted());
  if (pipe < 0) return false;
  const bool stands_in = ::dup2(pipe, STDIN_FILENO) == STDIN_FILENO;
  ::close(pipe);
  return stands_in;
}

}  // namespace

FileResult<CsvReader> CsvReader::open(const std::string& path) {
  std::optional<SpooledInput> spooled;
  if (path == "-" || stand_in_for_standard_input(path)) {
    FileResult<SpooledInput> input = SpooledInput::from_standard_input();
    if (auto* error = std::get_if<FileError>(&input)) return std::move(*error);
    spooled.emplace(std::move(std::get<SpooledInput>(input)));
  }
  FileResult<LineReader> lines = LineReader::open(spooled ? spooled->path() : path);
  if (auto* error = std::get_if<FileError>(&lines)) return std::move(*error);
  CsvReader reader(path == "-" ? "<stdin>" : path, std::move(spooled),
                   std::move(std::get<LineReader>(lines)));
  if (!reader.read_line() || is_blank(reader.row_)) {
    if (!reader.failed()) {
      reader.failure_ = reader.error_at_line("E-CSV", "no header row");
      reader.failure_->fix = "the first line names the columns, as in X,Y,Z";
    }
    return reader;
  }
  if (reader.row_.starts_with(kByteOrderMark)) reader.row_.erase(0, kByteOrderMark.size());
  if (!reader.split()) return reader;
  for (std::size_t i = 0; i < reader.cells_.size(); ++i) reader.header_.emplace_back(reader.text(i));
  for (std::size_t i = 0; i < reader.header_.size() && !reader.failed(); ++i) {
    if (reader.header_[i].empty()) reader.fail_at(i, "E-CSV", "a column without a name");
    for (std::size_t k = 0; k < i && !reader.failed(); ++k) {
      if (reader.header_[k] == reader.header_[i]) {
        reader.fail_at(i, "E-CSV", fmt::format("a second column '{}'", reader.header_[i]));
      }
    }
  }
  return reader;
}

bool CsvReader::read_line() {
  const std::optional<std::string_view> line = lines_.next();
  if (!line) {
    if (lines_.error()) {
      failure_ = error_at_line("E-FILE", lines_.error()->message);
      broken_ = true;
    }
    return false;
  }
  line_ = lines_.line_number();
  std::string_view text = *line;
  while (!text.empty() && (text.back() == '\n' || text.back() == '\r')) text.remove_suffix(1);
  row_ = text;
  if (lines_.too_long()) {
    failure_ = error_at_line("E-CSV", "the line is too long");
    return false;
  }
  return true;
}

bool CsvReader::split() {
  cells_.clear();
  std::size_t start = 0;
  while (true) {
    std::size_t content = row_.find_first_not_of(" \t", start);
    if (content != std::string::npos && row_[content] == '"') {
      const std::size_t quote = row_.find('"', content + 1);
      const std::size_t after = quote == std::string::npos ? quote : row_.find_first_not_of(" \t", quote + 1);
      if (quote == std::string::npos || (after != std::string::npos && row_[after] != ',')) {
        cells_.push_back({content, 1});
        fail_at(cells_.size() - 1, "E-CSV", "a quotation mark that is not closed at the end of its cell");
        return false;
      }
      cells_.push_back({content + 1, quote - content - 1});
      if (after == std::string::npos) return true;
      start = after + 1;
      continue;
    }
    const std::size_t comma = row_.find(',', start);
    cells_.push_back({start, (comma == std::string::npos ? row_.size() : comma) - start});
    if (comma == std::string::npos) return true;
    start = comma + 1;
  }
}

bool CsvReader::next() {
  if (failed() || !read_line()) return false;
  if (is_blank(row_)) {
    // An empty line is the end of the file, unless rows follow.
    const std::size_t empty = line_;
    while (read_line()) {
      if (is_blank(row_)) continue;
      line_ = empty;
      row_.clear();
      failure_ = error_at_line("E-CSV", "an empty line between rows");
      return false;
    }
    return false;
  }
  if (!split()) return false;
  if (cells_.size() != header_.size()) {
    const std::size_t at = cells_.size() < header_.size() ? cells_.size() - 1 : header_.size();
    fail_at(at, "E-CSV", fmt::format("{} cells, but {} columns", cells_.size(), header_.size()));
    return false;
  }
  return true;
}

std::string_view CsvReader::text(std::size_t column) const {
  std::string_view cell = std::string_view(row_).substr(cells_[column].start, cells_[column].length);
  while (!cell.empty() && (cell.front() == ' ' || cell.front() == '\t')) cell.remove_prefix(1);
  while (!cell.empty() && (cell.back() == ' ' || cell.back() == '\t')) cell.remove_suffix(1);
  return cell;
}

std::optional<double> CsvReader::number(std::size_t column) {
  if (failed()) return std::nullopt;
  const std::string_view cell = text(column);
  const std::optional<double> value = read_number(cell);
  if (!value) {
    const std::string where = fmt::format("in column '{}'", header_[column]);
    fail_at(
        column, "E-CELL",
        cell.empty() ? fmt::format("an empty cell {}", where) : fmt::format("not a finite number {}", where));
  }
  return value;
}

Diagnostic CsvReader::error_at(std::size_t column, std::string code, std::string message) const {
  Diagnostic diagnostic = error_at_line(std::move(code), std::move(message));
  if (column < cells_.size()) {
    std::size_t start = cells_[column].start;
    std::size_t length = cells_[column].length;
    while (length > 1 && (row_[start] == ' ' || row_[start] == '\t')) ++start, --length;
    diagnostic.place.column = start + 1;
    diagnostic.place.length = length == 0 ? 1 : length;
  }
  return diagnostic;
}

Diagnostic CsvReader::error_at_line(std::string code, std::string message) const {
  Diagnostic diagnostic;
  diagnostic.code = std::move(code);
  diagnostic.place.file = name_;
  diagnostic.place.line = line_;
  diagnostic.place.column = line_ == 0 ? 0 : 1;
  diagnostic.place.source_line = row_;
  diagnostic.message = std::move(message);
  return diagnostic;
}

void CsvReader::fail_at(std::size_t column, std::string code, std::string message, std::string fix) {
  failure_ = error_at(column, std::move(code), std::move(message));
  failure_->fix = std::move(fix);
}

}  // namespace abbe::app
