#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "abbe/core/progress.h"
#include "abbe/core/units.h"
#include "abbe/surface/nearest.h"

namespace abbe {

/// How a ball-end mill shall go over a surface, its axis along +z of the part.
struct ToolPathJob {
  double radius = 3;          ///< mm, of the ball
  double scallop = 5 * um;    ///< mm: height of what is left between passes; 0: by `step`
  double step = 0;            ///< mm: distance of the contact points of neighbouring passes
  bool along_v = true;        ///< passes run along v and follow each other in u; else the other way
  bool zigzag = true;         ///< every other pass goes back; else all go the same way
  double tolerance = 1 * um;  ///< mm: chords are nearer than this to the way of the ball's centre
};

/// Cutter contact and cutter location.
struct ToolContact {
  SurfacePlace place;
  Vec3 contact = Vec3::Zero();  ///< CC: where the ball touches, mm
  Vec3 normal = Vec3::UnitZ();
  Vec3 tip = Vec3::Zero();  ///< CL: of the tool, mm
};

struct ToolPass {
  bool linked =
      false;  ///< goes on from the end of the pass before, along the surface; else the tool is lifted between
  std::vector<ToolContact> points;
};

struct ToolPath {
  std::vector<ToolPass> passes;
  double length = 0;                     ///< mm, of the tip in feed
  double least_step = 0, most_step = 0;  ///< mm, between contacts of neighbouring passes
  std::size_t points = 0;
};

/// Why there is none.
struct ToolPathFault {
  enum class Kind {
    curvature,  ///< a hollow narrower than the ball: value = its radius, mm
    pole,       ///< the lines of one parameter meet here: passes would have no width
    undercut,   ///< a tool along z cannot touch this: value = slope of the normal, n.z
    gouge,      ///< the ball cuts another part of the surface, or a crease on its way: value = how deep, mm
    endless,    ///< more passes than kMostPasses, or more points than kMostPoints
    stopped,    ///< by `progress`
  } kind = Kind::curvature;
  SurfacePlace place;
  Vec3 point = Vec3::Zero();
  double value = 0;
};

inline constexpr std::size_t kMostPasses = 20000, kMostPathPoints = 2000000;

/// The passes of a ball over the whole patch, from one rim to the other.
///
///     centre = CC + R n,   tip = centre - R z
///     scallop:  (centre_1 + centre_2) / 2 - n sqrt(R^2 - d^2 / 4) stands h over the surface, d the centres'
///     distance
///               across the pass; a flat gives d = 2 sqrt(2 R h - h^2), a hollow of radius q about sqrt(8 h R
///               q / (q - R))
///
/// Passes are lines in the parameters: at fixed stations the next pass is where scallop or step have the
/// wanted value (fixed point, 1e-13), straight between them. The last pass is the rim; what is then nearer
/// than wanted stays so.
///
/// errors   ToolPathFault: poles and the hollow are looked for at every contact, the rest of the surface by
///          its nearest point, a crease between two points at the middle of their chord
/// laws     CurvatureDecidesTheStep, FlatStepIsTheFormula, ChordsKeepTheTolerance, NoPointGouges,
///          ACreaseIsNotCutOff; the scallop: Analytic.APerfectMachineLeavesTheScallopAndNothingElse
/// cost     25 us per point, for the gouge check
/// source   Suresh, Yang: Constant scallop-height machining of free-form surfaces (1994)
[[nodiscard]] std::variant<ToolPath, ToolPathFault> make_tool_path(const NearestPoint& nominal,
                                                                   const ToolPathJob& job,
                                                                   const Progress& progress = {});

/// Step between passes that leaves the scallop h over a surface of normal curvature k (1/mm, + in a hollow),
/// for the ball of radius R; 0 if there is none.
///
///     centres on a circle of radius q - R (q = 1 / k), cusp on q - h:  the triangle of both by the law of
///     cosines
///
/// laws     FlatStepIsTheFormula, CurvatureDecidesTheStep
[[nodiscard]] double step_for_scallop(double radius, double scallop, double curvature);

[[nodiscard]] std::string to_text(const ToolPathFault& fault);

}  // namespace abbe
