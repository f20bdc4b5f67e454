#pragma once

#include <string>
#include <vector>

#include "abbe/cl/record.h"

namespace abbe::cl {

/// Digits behind the point that a corrected number has at least.
struct Digits {
  int length = 5;  ///< mm: 10 nm; inch: 6
  int axis = 8;    ///< i j k: 10 nrad
};

/// New numbers in the bytes of a record; every other byte stays.
/// law   UnchangedNumbersKeepTheirBytes: a number that is as near as half its last digit is not touched
class NumberEdit {
 public:
  explicit NumberEdit(const Record& record) : record_(&record), texts_(record.items.size()) {}

  /// Writes `value` (units of the record) with the digits of the old number, `least_decimals` at least.
  /// Returns the value that a reader will see.
  double set(std::size_t item, double value, int least_decimals);

  [[nodiscard]] bool changed() const { return changed_; }

  /// The record with its new numbers. Lines that would pass column 72, where some readers stop, are broken
  /// with
  /// `$` between two items, if the record kept to it before.
  [[nodiscard]] std::string bytes() const;

 private:
  [[nodiscard]] std::string join(bool broken) const;

  const Record* record_;
  std::vector<std::string> texts_;
  bool changed_ = false;
};

}  // namespace abbe::cl
