#include "abbe/program/frames.h"

#include <Eigen/LU>

namespace abbe {
namespace {

constexpr double kEven = 1e-12;  // factors that differ by less are one: rounding of their product

}  // namespace

Frames::Frames(const ControlSetup& setup) : work_(setup.work_offsets.begin(), setup.work_offsets.end()) {
  work_.resize(work_.size() + static_cast<std::size_t>(profile_of(setup)->offsets.further));
  for (const auto& [number, offset] : setup.further_offsets) {
    const auto index = static_cast<std::size_t>(kFixedWorkOffsets - 1 + number);
    if (index < work_.size()) work_[index] = offset;
  }
  select(0);
}

void Frames::set_g92(const Vec3& offset) {
  g92_ = offset;
  refresh();
}

void Frames::turn(const Vec3& centre, double angle) {
  centre_ = centre;
  angle_ = angle;
  refresh();
}

void Frames::place(const Mat3& matrix, const Vec3& at) {
  placed_ = true;
  matrix_ = matrix;
  back_ = matrix.inverse();
  tilted_ = !matrix.isDiagonal(0);
  stretch_ = matrix.colwise().norm().maxCoeff();
  even_ = (matrix.transpose() * matrix - stretch_ * stretch_ * Mat3::Identity()).cwiseAbs().maxCoeff() <
          kEven * stretch_ * stretch_;
  at_ = at;
  refresh();
}

void Frames::place_nothing() {
  placed_ = tilted_ = false;
  even_ = true;
  stretch_ = 1;
  matrix_ = back_ = Mat3::Identity();
  refresh();
}

void Frames::select(int index) {
  active_ = index;
  refresh();
}

void Frames::set_work_offset(int index, const WorkOffset& offset) {
  work_[static_cast<std::size_t>(index)] = offset;
  refresh();
}

void Frames::set_tool_offset(const Vec3& tlo) {
  tlo_ = tlo;
  refresh();
}

void Frames::refresh() {
  const auto& work = work_[static_cast<std::size_t>(active_)];
  const double rotation = angle_ != 0 ? angle_ : work ? work->rotation : 0.0;
  sin_ = std::sin(rotation);
  cos_ = std::cos(rotation);
  origin_ = tlo_;
  if (work) origin_ += Vec3(work->origin[0], work->origin[1], work->origin[2]);
  if (placed_) {
    // m = (M p + o) + g92 + g5x + tlo
    outer_ = at_ + g92_ + origin_;
    return;
  }
  // m = Rz(a) (p - k) + (k + g92 + g5x + tlo), or (1)
  inner_ = angle_ != 0 ? Vec3(-centre_) : g92_;
  outer_ = angle_ != 0 ? Vec3(centre_ + g92_ + origin_) : origin_;
}

}  // namespace abbe
