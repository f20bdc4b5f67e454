#include "abbe/program/frames.h"

namespace abbe {

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
  const double rotation = work ? work->rotation : 0.0;
  sin_ = std::sin(rotation);
  cos_ = std::cos(rotation);
  origin_ = tlo_;
  if (work) origin_ += Vec3(work->origin[0], work->origin[1], work->origin[2]);
}

}  // namespace abbe
