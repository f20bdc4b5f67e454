#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "abbe/chain/axis_table.h"
#include "abbe/chain/plan.h"

namespace abbe {

/// Which share of a location error a factor takes (docs/theory/chain.md, section 3).
enum class Part : std::uint8_t { all, along, across };

/// One step of a tool point on its way from the tool frame through the bed into the workpiece frame.
/// Every step ends with p += t, so that constant offsets cost no step of their own.
struct Op {
  enum class Kind : std::uint8_t {
    tip,     ///< p += tip of the query's tool
    slide,   ///< p += q u
    turn,    ///< p = Rot(u, q) p
    affine,  ///< p = A p, A = matrices[index]: a constant error factor
    shift,   ///< p += d (or -= d): an error factor without rotation
    rigid,   ///< p = Exp(e) p + d, or the inverse
    linear,  ///< p = (I + [e]x) p + d, or the inverse
    twist,   ///< first order: deviation += (d + e x p), or -=
  };
  Kind kind = Kind::tip;
  bool inverse = false;
  Part part = Part::all;
  std::int8_t axis = -1;    ///< moving axis of slide and turn
  std::int32_t index = -1;  ///< of groups (shift, rigid, linear, twist) or matrices (affine)
  Vec3 u = Vec3::UnitZ();   ///< axis of slide and turn (negated where the motion is inverted) and of part
  Vec3 t = Vec3::Zero();    ///< mm
};

/// The error factor of one body and class: constants plus functions of the query.
struct Group {
  std::array<double, kComponents> constant{};  ///< of tables: folded into the first one
  Vec3 lever = Vec3::Zero();                   ///< measured_at - origin: d -= e x lever
  bool has_lever = false;
  bool varies = false;     ///< has tables or terms
  bool rotates = false;    ///< some e is not identically zero
  bool is_rotary = false;  ///< of a rotary axis: how a location error is split
  std::uint32_t first_table = 0, table_count = 0;
  std::uint32_t first_term = 0, term_count = 0;
};

/// Any other function: component += scale * function(variables of the file).
struct GeneralTerm {
  const ErrorFunction* function = nullptr;
  double scale = 1;
  int component = 0;
};

/// The compiled machine. Three walks over the same chain: without errors, with the model's matrices,
/// and with first-order twists.
struct Plan::Impl {
  std::shared_ptr<const Machine> machine;
  ErrorModel model = ErrorModel::rigid;
  std::vector<double> variables;  ///< file units; positions 0, sensors and held velocities frozen
  bool needs_variables = false;   ///< some general term is evaluated
  bool directional = false;       ///< some general term depends on the approach
  bool constant_outside = false;  ///< a frozen function is beyond its ends
  bool error_free = true;

  std::vector<Op> nominal, actual, first_order;  ///< actual is empty in the first-order model
  std::vector<Group> groups;
  std::vector<Mat3> matrices;
  std::vector<AxisTable> tables;
  std::vector<double> knots, coefficients;
  std::vector<std::uint32_t> buckets;
  std::vector<Wave> waves;
  std::vector<GeneralTerm> terms;
  std::array<double, kMaxAxes> unit{};  ///< mm or rad per unit of the file, per moving axis
  int axis_count = 0;
  std::uint32_t rotary = 0;                 ///< bit i: moving axis i is rotary
  std::array<double, kMaxAxes> lo{}, hi{};  ///< travels, infinite where none is given
};

/// Compiles for an environment that is already frozen in `variables` (file units, positions ignored).
/// `only` >= 0 keeps that one of the machine's errors and drops the others.
[[nodiscard]] Plan compile_plan(std::shared_ptr<const Machine> machine, std::vector<double> variables,
                                ErrorModel model, int only = -1);

}  // namespace abbe
