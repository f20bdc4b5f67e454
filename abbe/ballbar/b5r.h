#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "abbe/ballbar/trace.h"
#include "abbe/core/diagnostic.h"

namespace abbe {

/// One analysed figure of a Renishaw Ballbar 20 file as it states it.
struct B5rFeature {
  std::string name;  ///< "AF_SQUARENESS"
  std::string type;  ///< "UT_SQUARENESS"
  std::string unit;  ///< of `value`: "um/m", "ms", "um", ..; empty if the type is not known
  double value = 0;
};

/// The header and the features of a .b5r file (XML). Its raw samples are not read: how they are stored is not
/// published.
struct B5rReport {
  std::string test, operator_name, date, machine, serial_number, last_calibrated;
  std::optional<TestPlane> plane;
  std::vector<B5rFeature> features;
};

/// errors   no XML, no feature, a feature whose value is not a finite number
/// laws     total on any bytes
/// source   the element names are those that a published third-party reader asks for
[[nodiscard]] Parsed<B5rReport> read_b5r(const std::string& file, std::string_view text);

}  // namespace abbe
