#pragma once

#include <string>

#include "abbe/cl/findings.h"
#include "abbe/cl/record.h"

namespace abbe::cl {

/// Records that are no motions as words of a LinuxCNC program.
class EventWriter {
 public:
  /// The block, with its line feed; "" for records without one. What has no word is refused in `findings`.
  [[nodiscard]] std::string words_of(const Record& record, Findings& findings);

 private:
  [[nodiscard]] std::string spindle(const Record& record, Findings& findings);
  [[nodiscard]] std::string coolant(const Record& record, Findings& findings);

  std::string turning_;  ///< M3 or M4, as SPINDL said last
};

}  // namespace abbe::cl
