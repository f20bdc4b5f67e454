#include "column_output.h"

#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <iterator>
#include <nlohmann/json.hpp>

namespace abbe::app {
namespace {

static_assert(std::endian::native == std::endian::little, "the binary form is little-endian");

template <class T>
void append_raw(std::string& out, const T* values, std::size_t count) {
  out.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

/// Names with separators or quotation marks are quoted.
std::string csv_cell(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? '\'' : (c == '\n' || c == '\r' ? ' ' : c);
  return quoted + '"';
}

nlohmann::ordered_json header_json(const ColumnHeader& header) {
  nlohmann::ordered_json columns = nlohmann::ordered_json::array();
  columns.push_back({{"name", "t"}, {"unit", "s"}});
  for (const ColumnName& c : header.columns) columns.push_back({{"name", c.name}, {"unit", c.unit}});
  return {{"format", 1},
          {"verb", header.verb},
          {"source", header.source},
          {"time_base", header.time_base},
          {"columns", columns}};
}

std::string dumped(const nlohmann::ordered_json& json) {
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

// 15 digits: a count of 32 bits divided by anything comes back, and 12.3456 stays 12.3456.
void append_number(std::string& out, double value) {
  fmt::format_to(std::back_inserter(out), "{:.15g}", value);
}

}  // namespace

std::string ColumnName::label() const {
  std::string label = name;
  if (unit.empty()) return label;
  label += '_';
  for (const char c : unit) label += c == '/' ? std::string("_per_") : std::string(1, c);
  return label;
}

ColumnFormat column_format(const std::string& format, const std::string& path) {
  if (format == "json" || (format.empty() && path.ends_with(".json"))) return ColumnFormat::json;
  if (format == "binary" || (format.empty() && path.ends_with(".abbecol"))) return ColumnFormat::binary;
  return ColumnFormat::csv;
}

std::optional<ColumnOutput> ColumnOutput::create(const std::string& path, ColumnFormat format,
                                                 ColumnHeader header, Session& session) {
  ColumnOutput output(format, std::move(header), session);
  if (!path.empty() && path != "-") {
    FileResult<SpoolFile> created = SpoolFile::create(path);
    if (const auto* error = std::get_if<FileError>(&created)) {
      session.report(*error, path);
      return std::nullopt;
    }
    output.file_.emplace(std::move(std::get<SpoolFile>(created)));
  }
  output.varies_.assign(output.header_.columns.size(), 0);
  output.begin();
  return output;
}

void ColumnOutput::begin() {
  const std::string header = dumped(header_json(header_));
  switch (format_) {
    case ColumnFormat::csv:
      text_ = "t_s";
      for (const ColumnName& column : header_.columns) text_ += ',' + csv_cell(column.label());
      text_ += '\n';
      break;
    case ColumnFormat::json:
      text_ = header;
      text_.back() = ',';  // the object goes on
      text_ += "\n\"rows\":[";
      break;
    case ColumnFormat::binary: {
      text_ = "ABBECOL1";
      const auto length = static_cast<std::uint64_t>(header.size());
      append_raw(text_, &length, 1);
      text_ += header;
      break;
    }
  }
}

bool ColumnOutput::put(const std::string& text) {
  if (file_) {
    if (file_->write(text)) return true;
    session_->report(*file_->error(), "output");
    return false;
  }
  session_->out.write(text);
  return session_->out.ok();
}

bool ColumnOutput::write(const ColumnBlock& block) {
  const std::size_t rows = block.time.size();
  if (rows == 0) return true;
  if (rows_ == 0) {
    for (const auto& column : block.columns) first_.push_back(column[0]);
  }
  for (std::size_t c = 0; c < block.columns.size(); ++c) {
    for (const double value : block.columns[c]) varies_[c] |= static_cast<char>(value != first_[c]);
  }
  if (format_ == ColumnFormat::binary) {
    const auto count = static_cast<std::uint64_t>(rows);
    append_raw(text_, &count, 1);
    append_raw(text_, block.time.data(), rows);
    for (const auto& column : block.columns) append_raw(text_, column.data(), rows);
  } else {
    const bool json = format_ == ColumnFormat::json;
    for (std::size_t row = 0; row < rows; ++row) {
      if (json) text_ += rows_ + row == 0 ? "\n[" : ",\n[";
      append_number(text_, block.time[row]);
      for (const auto& column : block.columns) {
        text_ += ',';
        append_number(text_, column[row]);
      }
      text_ += json ? "]" : "\n";
    }
  }
  rows_ += rows;
  const bool written = put(text_);
  text_.clear();
  return written;
}

bool ColumnOutput::finish(const std::string& closing_members) {
  if (format_ == ColumnFormat::json) text_ += "\n]" + closing_members + "}\n";
  if (format_ == ColumnFormat::binary) {
    const std::uint64_t none = 0;
    append_raw(text_, &none, 1);
  }
  if (!put(text_)) return false;
  text_.clear();
  if (!file_ || file_->publish()) return true;
  session_->report(*file_->error(), "output");
  return false;
}

std::vector<std::string> ColumnOutput::constant_columns() const {
  std::vector<std::string> names;
  for (std::size_t c = 0; rows_ > 1 && c < varies_.size(); ++c) {
    if (varies_[c] == 0) names.push_back(header_.columns[c].name);
  }
  return names;
}

}  // namespace abbe::app
