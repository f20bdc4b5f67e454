#pragma once

#include <Eigen/Core>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/evaluate/measured_table.h"

namespace abbe {

/// Repeated runs over the same targets: what ISO 230-2 evaluates.
///
///   forward(i, j)   deviation = actual - target at targets[i] in run j, approached with increasing position
///   backward(i, j)  the same, approached with decreasing position
///
/// shapes   targets: m, strictly increasing; forward, backward: m rows, one column per run, a direction
///          without runs has no columns
/// units    targets mm or rad by target_quantity, deviations mm or rad by quantity
struct RunTable {
  std::string file;
  std::vector<double> targets;
  Eigen::MatrixXd forward, backward;
  Quantity target_quantity = Quantity::length;
  Quantity quantity = Quantity::length;

  [[nodiscard]] Eigen::Index target_count() const { return static_cast<Eigen::Index>(targets.size()); }
  [[nodiscard]] bool bidirectional() const { return forward.cols() > 0 && backward.cols() > 0; }
};

/// Standard deviation of a reading about the mean of its target and direction, pooled over the table; 0 for
/// single runs.
[[nodiscard]] double reading_scatter(const RunTable& table);

/// A reading as files list them.
struct RunReading {
  double target = 0;     ///< mm or rad
  double deviation = 0;  ///< mm or rad
  int run = 0;
  bool increasing = true;  ///< direction of approach
  std::size_t line = 0;
};

/// Sorts readings into runs. Targets are the same if they differ by less than a millionth of their span.
///
/// errors   E-RUN-TWICE (the same target, run and direction again), E-RUN-MISSING (a run without one of the
///          targets), E-RUN-FEW (fewer than two targets), E-RUN-LARGE (deviations as large as the distance of
///          targets: swapped targets or a wrong unit), W-RUN-LARGE (more than 1 mm, or more than 0.01 rad),
///          W-RUN-OUTLIER (a reading far from the others of its target and direction)
[[nodiscard]] Parsed<RunTable> sort_runs(const std::string& file, const std::vector<RunReading>& readings,
                                         Quantity target_quantity, Quantity quantity);

/// The runs in a table with the columns target, run, direction and `column`; the column `measured` holds
/// actual positions, from which the target is subtracted, every other one deviations. An empty `column` means
/// the only one that is left.
///
/// errors   E-RUN-COLUMN (a column is missing, or has no unit, or is not told apart), and those of sort_runs
[[nodiscard]] Parsed<RunTable> runs_of(const MeasuredTable& table, std::string_view column);

/// Reads a file of runs: `.rtl` by its first section, every other text as a table.
///
/// `column` names the column of a table; `unit` (internal per number) is what an .rtl file's deviations are
/// in: 0 = um, if the file says that it is linear.
[[nodiscard]] Parsed<RunTable> read_runs(const std::string& file, std::string_view text,
                                         std::string_view column = {}, const MeasuredUnit* unit = nullptr);

/// A laser interferometer's .rtl file. The form is known from programs of third parties, not from its maker:
/// sections by name in any order, targets after "Targets :", then run, target number and deviation after "Run
/// Target Data:". A run whose targets fall was approached with decreasing position, in whichever order the
/// targets are listed.
///
/// Targets are mm (deg if the owner is rotary); deviations are um when the file's owner is Linear and no unit
/// is stated.
///
/// errors   E-RTL-FORM (a section or number that is missing or not understood), E-RTL-UNIT (the owner is not
///          Linear and no unit is stated), and those of sort_runs; W-RTL-FORM says where the form comes from
[[nodiscard]] Parsed<RunTable> read_rtl(const std::string& file, std::string_view text,
                                        const MeasuredUnit* unit = nullptr);

/// Writes the documented CSV that read_runs reads back to the same numbers: target, run, direction,
/// deviation. The texts of two tables are equal only if their readings are.
[[nodiscard]] std::string write_runs(const RunTable& table);

}  // namespace abbe
