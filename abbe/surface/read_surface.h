#pragma once

#include <string>
#include <string_view>

#include "abbe/core/diagnostic.h"
#include "abbe/surface/nurbs.h"

namespace abbe {

/// Reads a surface file (docs/surface-file.md): degrees, knots, the net of points, weights, the side of the
/// material. A surface that is read is valid, has a normal everywhere and does not cut itself (find_fault).
///
/// file     what diagnostics call it
/// errors   E-TOML, E-FORMAT, E-MISSING-KEY, E-UNKNOWN-KEY, E-VALUE, E-SURFACE-NET, E-SURFACE-KNOTS,
/// E-SURFACE-FOLD,
///          each with its place; total on any bytes
/// laws     AnyBytesGiveASurfaceOrAReason
/// cost     linear in the text, and find_fault
[[nodiscard]] Parsed<NurbsSurface> read_surface(std::string_view text, const std::string& file);

}  // namespace abbe
