#include "abbe/volume/field.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "abbe/errors/error_name.h"
#include "abbe/volume/parallel.h"

namespace abbe {

double angle_between(const Vec3& a, const Vec3& b) { return std::atan2(a.cross(b).norm(), a.dot(b)); }

std::size_t chunk_count(std::size_t points) { return (points + kFieldChunk - 1) / kFieldChunk; }

ChunkRange chunk_range(std::size_t chunk, std::size_t points) {
  return {chunk * kFieldChunk, std::min(points, (chunk + 1) * kFieldChunk)};
}

DeviationField deviation_field(const Plan& plan, const VolumeGrid& grid,
                               const FieldCircumstances& circumstances, const Progress& progress,
                               std::size_t done_before, std::size_t total) {
  const std::size_t points = grid.size(), chunks = chunk_count(points);
  DeviationField field;
  field.nominal.resize(points);
  field.nominal_axis.resize(points);
  field.deviation.resize(points);
  field.rotation.resize(points);
  field.tilt.resize(points);
  field.extrapolated.resize(points);
  std::vector<char> overflow(chunks, 0);
  std::vector<std::vector<std::string>> names(chunks);
  field.complete = for_each_chunk(
      chunks, circumstances.threads,
      [&](std::size_t chunk) {
        Query query;
        query.approach = circumstances.approach;
        query.tool = circumstances.tool;
        const ChunkRange range = chunk_range(chunk, points);
        for (std::size_t i = range.first; i < range.last; ++i) {
          query.q = grid.at(i);
          const Prediction p = predict(plan, query);
          if (!p.finite) overflow[chunk] = 1;
          field.nominal[i] = p.nominal.position;
          field.nominal_axis[i] = p.nominal.tool_axis;
          field.deviation[i] = p.deviation.position;
          // log(R_a R_n^T) = R_n log(R_n^T R_a)
          field.rotation[i] = nominal_pose(plan, query).R * p.tool_twist.e;
          field.tilt[i] = angle_between(p.nominal.tool_axis, p.actual.tool_axis);
          field.extrapolated[i] = p.extrapolated.empty() ? 0 : 1;
          for (const std::string& name : p.extrapolated) {
            std::vector<std::string>& seen = names[chunk];
            if (std::find(seen.begin(), seen.end(), name) == seen.end()) seen.push_back(name);
          }
        }
      },
      progress, done_before, total);
  field.finite = std::find(overflow.begin(), overflow.end(), 1) == overflow.end();
  if (!field.complete || !field.finite) {
    DeviationField nothing;
    nothing.complete = field.complete;
    nothing.finite = field.finite;
    return nothing;
  }
  for (const ErrorTerm& error : plan.machine().errors) {
    const std::string name = to_string(error.name);
    const bool held = std::any_of(names.begin(), names.end(), [&](const std::vector<std::string>& seen) {
      return std::find(seen.begin(), seen.end(), name) != seen.end();
    });
    std::vector<std::string>& all = field.extrapolated_names;
    if (held && std::find(all.begin(), all.end(), name) == all.end()) all.push_back(name);
  }
  return field;
}

}  // namespace abbe
