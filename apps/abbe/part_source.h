#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "abbe/part/cutter.h"
#include "abbe/part/inspection.h"
#include "abbe/report/json_writer.h"
#include "abbe/surface/nurbs.h"
#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// The surface of a file; nullopt after reporting all mistakes.
[[nodiscard]] std::optional<NurbsSurface> load_surface(const std::string& path, Session& session);

/// "ball:3", "flat:10", "bull:10,2" (radius, corner radius), mm; nullopt after reporting.
[[nodiscard]] std::optional<Cutter> read_cutter(const std::string& text, double length, Session& session);

/// "10x10": rows and columns of cells, at most a million in all; nullopt after reporting.
struct GridSize {
  std::size_t rows = 10, columns = 10;
};
[[nodiscard]] std::optional<GridSize> read_grid(const std::string& text, Session& session);

/// Names of the columns of a table of points, as typed.
struct PointColumns {
  std::string measured = "x,y,z";   ///< where the point is
  std::string target = "xn,yn,zn";  ///< where it should be; the file may lack them ..
  bool target_needed = false;       ///< .. unless they were asked for
};

/// Points of a CSV file, mm. `nominal` finds the place of the targets. nullopt after reporting, and where the
/// user interrupts.
[[nodiscard]] std::optional<std::vector<TouchedPoint>> load_points(const std::string& path,
                                                                   const PointColumns& columns,
                                                                   const NearestPoint& nominal,
                                                                   Session& session);

/// Deviations of points of a surface: mean, rms, extremes, profile. For people, with its definitions.
[[nodiscard]] std::string figures_text(const InspectionFigures& figures);
/// The member "deviation".
void write_figures(JsonWriter& json, const InspectionFigures& figures);

}  // namespace abbe::app
