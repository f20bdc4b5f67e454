#include "abbe/surface/read_surface.h"

#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "abbe/machine/machine_sections.h"
#include "abbe/machine/toml_values.h"
#include "abbe/surface/surface_check.h"

namespace abbe {
namespace {

constexpr std::size_t kMaxBytes = 16u << 20;

/// The value of a key that must be there.
const TomlNode* needed(const TomlNode& table, const char* key, const char* example, Findings& findings) {
  if (const TomlEntry* found = table.find(key)) return &found->value;
  findings.error("E-MISSING-KEY", table.mark, fmt::format("the key surface.{} is missing", key),
                 "a surface is not known without it", example);
  return nullptr;
}

void net_error(const TomlNode& node, std::string message, Findings& findings) {
  findings.error("E-SURFACE-NET", node.mark, std::move(message),
                 "the net has rows of equal length, more points than the degree in each direction",
                 "points = [[[x, y, z], ..], ..]: outer list along u, inner lists along v");
}

/// The lists of a net: as many in every row. False after reporting.
bool read_rows(const TomlNode& node, const char* what, NurbsSurface& surface, Findings& findings) {
  if (!expect_kind(node, TomlNode::Kind::array, what, findings)) return false;
  const std::size_t rows = node.items.size();
  for (const TomlNode& row : node.items) {
    if (!expect_kind(row, TomlNode::Kind::array, what, findings)) return false;
    if (row.items.size() == node.items.front().items.size()) continue;
    net_error(row,
              fmt::format("a row of {} in a net with rows of {}", row.items.size(),
                          node.items.front().items.size()),
              findings);
    return false;
  }
  const std::size_t columns = rows == 0 ? 0 : node.items.front().items.size();
  if (rows * columns <= NurbsSurface::kMaxPoints && rows > 0 && columns > 0) {
    surface.count = {rows, columns};
    return true;
  }
  net_error(node, fmt::format("a net of {} x {} points", rows, columns), findings);
  return false;
}

bool read_points(const TomlNode& node, double unit, NurbsSurface& surface, Findings& findings) {
  if (!read_rows(node, "surface.points", surface, findings)) return false;
  for (const TomlNode& row : node.items) {
    for (const TomlNode& item : row.items) {
      const auto point = read_vector(item, unit, "a point of the net", findings);
      if (!point) return false;
      if (point->cwiseAbs().maxCoeff() > NurbsSurface::kLongest) {
        net_error(item, "a point more than 1 km away", findings);
        return false;
      }
      surface.points.push_back(*point);
    }
  }
  return true;
}

bool read_weights(const TomlNode& node, NurbsSurface& surface, Findings& findings) {
  NurbsSurface shape;
  if (!read_rows(node, "surface.weights", shape, findings)) return false;
  if (shape.count != surface.count) {
    net_error(node,
              fmt::format("{} x {} weights for {} x {} points", shape.count[0], shape.count[1],
                          surface.count[0], surface.count[1]),
              findings);
    return false;
  }
  surface.weights.clear();
  for (const TomlNode& row : node.items) {
    for (const TomlNode& item : row.items) {
      const auto weight = read_value(item, "a weight", findings);
      if (!weight) return false;
      if (*weight < 1e-6 || *weight > 1e6) {
        net_error(item, fmt::format("the weight {}; weights are from 1e-6 to 1e6", *weight), findings);
        return false;
      }
      surface.weights.push_back(*weight);
    }
  }
  return true;
}

bool read_degree(const TomlNode& node, NurbsSurface& surface, Findings& findings) {
  const auto degree = read_values(node, 2, "surface.degree", findings);
  if (!degree) return false;
  for (std::size_t d = 0; d < 2; ++d) {
    const double p = (*degree)[d];
    if (p < 1 || p > NurbsSurface::kMaxDegree || p != std::floor(p)) {
      findings.error("E-VALUE", node.mark, fmt::format("the degree {}", p),
                     "degrees are whole numbers from 1 to 7", "degree = [3, 3]");
      return false;
    }
    surface.degree[d] = static_cast<int>(p);
  }
  return true;
}

/// Knots of one direction, from the file or uniform. Whether they fit is asked of the whole surface.
bool read_knots(const TomlNode& table, std::size_t direction, NurbsSurface& surface, Findings& findings) {
  const char* const key = direction == 0 ? "knots_u" : "knots_v";
  const TomlEntry* entry = table.find(key);
  const std::size_t order = static_cast<std::size_t>(surface.degree[direction]) + 1;
  if (entry == nullptr) {
    surface.knots[direction] =
        uniform_knots(std::max(surface.count[direction], order), surface.degree[direction]);
    return true;
  }
  auto knots = read_values(entry->value, 0, key, findings);
  if (!knots) return false;
  const std::size_t wanted = surface.count[direction] + order;
  surface.knots[direction] = std::move(*knots);
  NurbsSurface alone = surface;  // with knots that are right in the other direction
  alone.knots[1 - direction] = uniform_knots(surface.count[1 - direction], surface.degree[1 - direction]);
  if (surface.knots[direction].size() == wanted && alone.is_valid()) return true;
  findings.error("E-SURFACE-KNOTS", entry->mark,
                 fmt::format("{} knots in {}, or knots that decrease or tear the surface",
                             surface.knots[direction].size(), key),
                 fmt::format("{} points of degree {} need {} knots, none more than degree times inside",
                             surface.count[direction], surface.degree[direction], wanted),
                 fmt::format("correct them, or leave {} out for uniform knots", key));
  return false;
}

bool read_side(const TomlNode& table, NurbsSurface& surface, Findings& findings) {
  const TomlEntry* entry = table.find("outward");
  if (entry == nullptr) return true;
  const auto side = read_choice(entry->value, {"u x v", "v x u"}, "surface.outward", findings);
  if (side) surface.outward = *side == 0 ? 1 : -1;
  return side.has_value();
}

std::optional<NurbsSurface> read_table(const TomlNode& table, double unit, Findings& findings) {
  refuse_other_keys(table, {"name", "degree", "points", "weights", "knots_u", "knots_v", "outward"},
                    "[surface]", findings);
  NurbsSurface surface;
  const TomlNode* degree = needed(table, "degree", "degree = [3, 3]", findings);
  const TomlNode* points = needed(table, "points", "points = [[[0, 0, 0], ..], ..]", findings);
  if (degree == nullptr || points == nullptr || !read_degree(*degree, surface, findings) ||
      !read_points(*points, unit, surface, findings))
    return std::nullopt;
  for (std::size_t d = 0; d < 2; ++d) {
    if (surface.count[d] > static_cast<std::size_t>(surface.degree[d])) continue;
    net_error(*points,
              fmt::format("{} points along {} for degree {}", surface.count[d], "uv"[d], surface.degree[d]),
              findings);
    return std::nullopt;
  }
  surface.weights.assign(surface.points.size(), 1.0);
  const TomlEntry* weights = table.find("weights");
  const TomlEntry* name = table.find("name");
  if (weights != nullptr && !read_weights(weights->value, surface, findings)) return std::nullopt;
  if (name != nullptr) surface.name = read_text(name->value, "surface.name", findings).value_or("");
  if (!read_knots(table, 0, surface, findings) || !read_knots(table, 1, surface, findings) ||
      !read_side(table, surface, findings))
    return std::nullopt;
  return surface;
}

void check_shape(const NurbsSurface& surface, const TomlNode& table, Findings& findings) {
  if (const auto fault = find_fault(surface))
    findings.error("E-SURFACE-FOLD", table.mark, to_text(*fault),
                   "such a surface has no side that could be cut",
                   "correct the net, or split the surface there");
}

}  // namespace

Parsed<NurbsSurface> read_surface(std::string_view text, const std::string& file) {
  Parsed<NurbsSurface> out;
  Findings findings(file, text, out.diagnostics);
  if (text.size() > kMaxBytes) {
    findings.error("E-FILE", {}, fmt::format("{} bytes are too many for a surface file", text.size()), "",
                   "split the part");
    return out;
  }
  const auto root = read_toml(text, findings);
  if (!root) return out;
  refuse_other_keys(*root, {"format", "units", "surface"}, "a surface file", findings);
  check_format(*root, findings);
  const FileUnits units = read_units(*root, findings);
  const TomlNode* table = find_table(*root, "surface", findings);
  if (table == nullptr && findings.error_count() == 0)
    findings.error("E-MISSING-KEY", {}, "no table [surface]", "there is nothing to cut or inspect",
                   "see docs/surface-file.md");
  if (table == nullptr || findings.error_count() > 0) return out;
  auto surface = read_table(*table, units.length, findings);
  if (surface && findings.error_count() == 0) check_shape(*surface, *table, findings);
  if (findings.error_count() == 0) out.value = std::move(surface);
  return out;
}

}  // namespace abbe
