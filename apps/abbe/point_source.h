#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/plan.h"
#include "command_line.h"
#include "common.h"
#include "csv.h"
#include "session.h"

namespace abbe::app {

struct PointArguments {
  std::vector<std::string> at;
  std::string points;
};

void add_point_options(Command& verb, PointArguments& arguments);

/// The questions of `predict` and `correct`: the one of --at, or the rows of --points, streamed.
/// Columns: every moving axis, and optionally sensors, v.X, a.X, X.dir; the plan is made anew when a
/// sensor changes. Positions are in the units of the machine file.
class PointSource {
 public:
  /// nullopt after reporting what is wrong with the options, the header or the sensors.
  [[nodiscard]] static std::optional<PointSource> open(const PointArguments& arguments,
                                                       const Setting& setting, Session& session);

  /// Goes to the next point; false at the end and after a reported mistake.
  [[nodiscard]] bool next(Session& session);

  /// Of the present point; valid until next().
  [[nodiscard]] Query query() const;
  [[nodiscard]] const Plan& plan() const { return *plan_; }
  /// "part.csv:7", or "--at".
  [[nodiscard]] std::string where() const;
  [[nodiscard]] bool single() const { return !csv_.has_value(); }
  [[nodiscard]] std::uint64_t bytes_read() const { return csv_ ? csv_->bytes_read() : 0; }
  [[nodiscard]] std::uint64_t bytes_total() const { return csv_ ? csv_->bytes_total() : 0; }

 private:
  struct Column {
    std::size_t index;
    NameMeaning meaning;
    std::string name;
  };
  explicit PointSource(const Setting& setting);
  [[nodiscard]] bool use_columns(const std::vector<std::string>& header, Session& session);
  [[nodiscard]] bool take_row(Session& session);
  void put(const NameMeaning& meaning, const std::string& name, double value);
  [[nodiscard]] bool remake_plan(Session& session);

  const Setting* setting_;
  Environment environment_;
  std::optional<CsvReader> csv_;
  std::string file_;
  std::vector<Column> columns_;
  std::optional<Plan> plan_;
  bool plan_is_old_ = true;
  bool has_rates_ = false;
  bool done_ = false;

  std::array<double, kMaxAxes> q_{};
  std::array<signed char, kMaxAxes> approach_{};
  std::vector<double> velocity_, acceleration_;  ///< per moving axis; empty unless some are given per point
};

}  // namespace abbe::app
