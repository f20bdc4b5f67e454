#pragma once

#include <string>
#include <vector>

#include "abbe/identify/joint.h"
#include "abbe/identify/paper.h"
#include "abbe/report/json_writer.h"

namespace abbe::app {

/// A value of a term for people and its unit: um or urad per unit of the basis.
struct ShownTerm {
  std::string value, uncertainty, unit;
};
[[nodiscard]] ShownTerm shown(const IdentifiedTerm& term);

/// Terms with value and uncertainty (or, of a plan, the expected uncertainty), rank, what is not seen, the
/// uncertainty of the deviation over the tested space, doubts.
[[nodiscard]] std::string identification_text(const Machine& machine, const Identification& found,
                                              const std::vector<BallbarTest>& tests, bool plan);
/// Per run: measured, servo, static, dynamic, residual, dynamic share with its interval.
[[nodiscard]] std::string balance_text(const Identification& found, const std::vector<BallbarTest>& tests);
void write_identification(JsonWriter& json, const Machine& machine, const Identification& found,
                          const std::vector<BallbarTest>& tests, bool plan);

[[nodiscard]] std::string paper_text(const PaperResult& result);
void write_paper(JsonWriter& json, const PaperResult& result);

}  // namespace abbe::app
