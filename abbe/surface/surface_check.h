#pragma once

#include <optional>
#include <string>

#include "abbe/surface/nurbs.h"

namespace abbe {

/// Why a surface has no side on which material could lie.
struct SurfaceFault {
  enum class Kind {
    degenerate,    ///< S_u and S_v are parallel or zero: no normal
    folded,        ///< the normal turns by more than a right angle between neighbouring samples
    intersecting,  ///< two parts of the surface that are no neighbours meet
  } kind = Kind::degenerate;
  SurfacePlace place, other;  ///< other: of the second part, if intersecting
  Vec3 point = Vec3::Zero();
};

/// Looks at the middle points of a net of `pieces` by `pieces` cells per knot span (at most 64 x 64 cells)
/// and for triangles of that net which cut each other. Finer folds than the net are not seen.
///
/// errors   none; `surface` must be valid
/// laws     AFlatPatchIsSound, ACrossingIsFound, AFoldIsFound
/// cost     10 ms for 64 x 64 cells
/// source   Moeller: A fast triangle-triangle intersection test (1997), by edges against triangles
[[nodiscard]] std::optional<SurfaceFault> find_fault(const NurbsSurface& surface, std::size_t pieces = 8);

[[nodiscard]] std::string to_text(const SurfaceFault& fault);

}  // namespace abbe
