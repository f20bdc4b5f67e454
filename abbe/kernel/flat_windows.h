#pragma once

#include <vector>

#include "abbe/kernel/flat_view.h"

namespace abbe::kernel {

/// The numbers of kWindow segments side by side.
struct alignas(32) WindowRow {
  float value[kWindow] = {};
};

/// What single precision may change in one table's functions: so much, mm and rad, and this part of the
/// terms' sizes sum |c_k| h^k.
inline constexpr double kSingleMm = 1e-8, kSingleRad = 3e-11, kSinglePart = 4e-6;

/// A table's windows in single precision, one behind the other, every kWindowStep segments; see kBeginRow.
///
/// For one segment's polynomial of degree n at a distance of at most h from its origin, and of at most s from
/// the window's, single precision (u = 2^-24) misses at most
///
///   u ( (2 n + 1) sum |c_k| h^k + 2 s sum k |c_k| h^(k-1) )
///
/// and where slopes jump at a knot, and the knot is missed by rounding, once more what may be. A window in
/// which that is more, or in which the function makes a step, is marked as not for use; one in which only the
/// product would miss knots by too much has no segments per unit. Segments that reach to infinity end where
/// the bound does.
///
/// laws   FlatWindows.KeepTheirBound, FlatWindows.KeepTheirBoundAtKnots,
///        FlatWindows.FindEquallyWideSegmentsByAProduct, FlatWindows.LeaveStepsToDoublePrecision,
///        FlatWindows.LeaveUnequalSegmentsToDoublePrecision
/// cost   once per plan; about as many bytes as the table itself
/// source docs/theory/kernels.md
[[nodiscard]] std::vector<WindowRow> windows_of(const FlatTable& table);

}  // namespace abbe::kernel
