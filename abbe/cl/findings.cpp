#include "abbe/cl/findings.h"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

namespace abbe::cl {
namespace {

constexpr std::size_t kLongestExcerpt = 254;

/// Line, column and text of the line that holds a byte of a record.
Place place_of(const std::string& file, const Record& record, std::size_t begin, std::size_t length) {
  const std::string_view bytes = record.bytes;
  begin = std::min(begin, bytes.size());
  const std::string_view before = bytes.substr(0, begin);
  const std::size_t start = before.rfind('\n') == std::string_view::npos ? 0 : before.rfind('\n') + 1;
  const std::size_t end = std::min(bytes.find('\n', begin), bytes.size());
  std::string_view line = bytes.substr(start, end - start);
  if (line.ends_with('\r')) line.remove_suffix(1);
  const auto lines_before = static_cast<std::uint64_t>(std::count(before.begin(), before.end(), '\n'));
  return {file, record.line + lines_before, begin - start + 1, std::max<std::size_t>(length, 1),
          std::string(line.substr(0, kLongestExcerpt))};
}

}  // namespace

void Findings::add(Severity severity, const Record& record, std::size_t begin, std::size_t length,
                   Complaint complaint) {
  if (severity == Severity::error) ++errors_;
  if (++count_[complaint.code] > kPerCode) return;
  list_.push_back({severity, complaint.code, place_of(file_, record, begin, length),
                   std::move(complaint.message), std::move(complaint.why), std::move(complaint.fix)});
}

void Findings::refuse(const Record& record, Complaint complaint) {
  add(Severity::error, record, record.major_begin, std::max<std::size_t>(record.major.size(), 1),
      std::move(complaint));
}

void Findings::refuse(const Record& record, const Item& item, Complaint complaint) {
  add(Severity::error, record, item.begin, item.end - item.begin, std::move(complaint));
}

void Findings::warn(const Record& record, Complaint complaint) {
  add(Severity::warning, record, record.major_begin, std::max<std::size_t>(record.major.size(), 1),
      std::move(complaint));
}

void Findings::refuse_file(Complaint complaint) {
  ++errors_;
  list_.push_back({Severity::error, complaint.code, Place{file_, 0, 0, 1, {}}, std::move(complaint.message),
                   std::move(complaint.why), std::move(complaint.fix)});
}

Diagnostics Findings::take() {
  for (const auto& [code, count] : count_) {
    if (count <= kPerCode) continue;
    list_.push_back({Severity::note,
                     code,
                     Place{file_, 0, 0, 1, {}},
                     fmt::format("{} more findings of this kind are not listed", count - kPerCode),
                     {},
                     {}});
  }
  count_.clear();
  return std::exchange(list_, {});
}

}  // namespace abbe::cl
