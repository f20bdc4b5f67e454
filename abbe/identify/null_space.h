#pragma once

#include <string>
#include <vector>

#include "abbe/core/least_squares.h"
#include "abbe/identify/model_term.h"

namespace abbe {

/// A combination of unknowns that no row of an identification sees: this much of each at once changes no
/// measured value.
struct UnseenCombination {
  struct Part {
    std::size_t unknown = 0;
    double amount = 0;  ///< mm, rad per mm^n .., relative to the first part, whose amount is 1
  };
  std::vector<Part> parts;  ///< the one with the largest effect first
  std::string words;        ///< "EYX X^2 and ECX X only as EYX X^2 - 1 ECX X", ..
};

/// The null space as combinations of few unknowns each (reduced row echelon form with the largest effects as
/// pivots), with words. `terms` are the first unknowns, so that static and dynamic terms which are one on a
/// circle of one feed can be explained.
[[nodiscard]] std::vector<UnseenCombination> unseen_combinations(const LeastSquaresSolution& solution,
                                                                 const std::vector<std::string>& names,
                                                                 const std::vector<ModelTerm>& terms);

/// The solution in which of every unseen combination one unknown is zero: `zeros` names them (unknowns that
/// no row sees are among them). Unknowns from `first_bar` on are bar lengths; those between the terms and
/// them are centres, which are never taken.
struct ZeroedSolution {
  LeastSquaresSolution solution;
  std::vector<std::size_t> zeros;
};
[[nodiscard]] ZeroedSolution solve_with_zeros(const TriangularFactor& factor,
                                              const LeastSquaresOptions& options,
                                              const std::vector<std::string>& names,
                                              const std::vector<ModelTerm>& terms, std::size_t first_bar);

}  // namespace abbe
