#pragma once

#include <cstdint>
#include <map>
#include <string>

#include "abbe/cl/record.h"
#include "abbe/core/diagnostic.h"

namespace abbe::cl {

/// What a finding says: its code, what was found, why it matters, what to do.
struct Complaint {
  const char* code;
  std::string message;
  std::string why, fix;
};

/// Collects what is wrong with one CL file: every finding with its place, at most kPerCode of a kind.
class Findings {
 public:
  static constexpr int kPerCode = 100;
  explicit Findings(std::string file) : file_(std::move(file)) {}

  /// About bytes [begin, begin + length) of a record.
  void add(Severity severity, const Record& record, std::size_t begin, std::size_t length,
           Complaint complaint);
  void refuse(const Record& record, Complaint complaint);                    ///< at its major word
  void refuse(const Record& record, const Item& item, Complaint complaint);  ///< at one item
  void warn(const Record& record, Complaint complaint);
  void refuse_file(Complaint complaint);

  [[nodiscard]] bool refused() const { return errors_ > 0; }
  /// Ends the collection: adds how many findings of a kind were not listed.
  [[nodiscard]] Diagnostics take();

 private:
  std::string file_;
  Diagnostics list_;
  std::map<std::string, int, std::less<>> count_;
  std::uint64_t errors_ = 0;
};

}  // namespace abbe::cl
