#include <cmath>

#include "abbe/verify/reader.h"

namespace abbe::verifying {
namespace {

/// How far LinuxCNC stays above the last depth when it returns into a pecked hole (0.010 inch).
constexpr double kPeckClearance = 0.254;  // mm

class Lister {
 public:
  explicit Lister(const std::function<void(const ListedMotion&)>& found) : found_(found) {}

  void list(const Motion& motion, std::uint64_t line) {
    line_ = line;
    switch (motion.kind) {
      case MotionKind::rapid:
      case MotionKind::line:
        return give(motion.kind == MotionKind::rapid ? ListedMotion::Kind::rapid : ListedMotion::Kind::line,
                    motion.end);
      case MotionKind::arc:
        return list_arc(motion);
      case MotionKind::cycle:
        return list_cycle(motion);
      case MotionKind::nurbs:  // LinuxCNC has none of this kind
        return;
      case MotionKind::home: {
        if (motion.named != 0) rapid(motion.end);
        Position home = motion.end;
        home.known &= motion.named == 0 ? 0u : ~motion.named;
        return rapid(home);
      }
    }
  }

 private:
  void list_arc(const Motion& motion) {
    ListedMotion listed;
    listed.kind = ListedMotion::Kind::arc;
    listed.line = line_;
    listed.end = motion.end.at;
    listed.centre = motion.arc.centre;
    listed.plane = motion.arc.plane;
    listed.turns = motion.arc.sweep > 0 ? motion.arc.turns : -motion.arc.turns;
    found_(listed);
  }

  void list_cycle(const Motion& motion) {
    const Cycle& cycle = motion.cycle;
    if ((cycle.lifted - motion.start.at).norm() > 0) rapid(cycle.lifted);
    for (int k = 0; k < cycle.holes; ++k) {
      const Vec3 shift = cycle.step * k;
      const Vec3 travel = (k == 0 ? cycle.travel : cycle.clear) + shift;
      const Vec3 retract = cycle.retract + shift, bottom = cycle.bottom + shift, clear = cycle.clear + shift;
      rapid(travel);
      if ((travel - retract).norm() > 0) rapid(retract);
      if (cycle.peck > 0) list_pecks(motion, retract, bottom);
      feed(bottom);
      if (motion.code == 850) feed(retract);
      const bool feeds_out = motion.code == 740 || motion.code == 840 || motion.code == 890;
      feeds_out ? feed(clear) : rapid(clear);
    }
  }

  /// G83 retracts to R after every peck, G73 only breaks the chip.
  void list_pecks(const Motion& motion, const Vec3& retract, const Vec3& bottom) {
    const double depth = (bottom - retract).norm();
    if (!(depth > 0)) return;
    const Vec3 down = (bottom - retract) / depth;
    for (double reached = motion.cycle.peck; reached < depth; reached += motion.cycle.peck) {
      feed(retract + down * reached);
      if (motion.code == 830) rapid(retract);
      rapid(retract + down * (reached - kPeckClearance));
    }
  }

  void rapid(const Vec3& end) { give(ListedMotion::Kind::rapid, {end, kAllAxes}); }
  void rapid(const Position& end) { give(ListedMotion::Kind::rapid, end); }
  void feed(const Vec3& end) { give(ListedMotion::Kind::line, {end, kAllAxes}); }
  void give(ListedMotion::Kind kind, const Position& end) {
    ListedMotion listed;
    listed.kind = kind;
    listed.line = line_;
    listed.end = end.at;
    listed.known = end.known;
    found_(listed);
  }

  const std::function<void(const ListedMotion&)>& found_;
  std::uint64_t line_ = 0;
};

}  // namespace

Diagnostics list_motions(const std::string& path, const std::string& name, const ControlSetup& setup,
                         const std::function<void(const ListedMotion&)>& found) {
  ProgramReader::Options options;
  options.hashed = false;
  options.skip_deletable = setup.block_delete == ControlSetup::BlockDelete::on;
  auto opened = ProgramReader::open(path, name, setup, options);
  if (const auto* error = std::get_if<FileError>(&opened))
    return {{Severity::error,
             "E-FILE",
             {name, 0, 0, 0, {}},
             error->message,
             "the program could not be read",
             "check the path"}};
  auto& reader = std::get<ProgramReader>(opened);
  Lister lister(found);
  for (;;) {
    switch (reader.next()) {
      case ProgramReader::Item::event:
        break;
      case ProgramReader::Item::motion:
        if (reader.motion().cutter.offset != 0)
          return {{Severity::error,
                   "E-CUTCOM",
                   {name, static_cast<std::size_t>(reader.line()), 1, 1, reader.source_line()},
                   "cutter compensation: the program states the contour",
                   "where the cutter's centre runs beside it is the control's affair",
                   "post the tool-centre path"}};
        lister.list(reader.motion(), reader.line());
        break;
      case ProgramReader::Item::end:
        return {};
      case ProgramReader::Item::refused:
        return {reader.refusal()};
    }
  }
}

}  // namespace abbe::verifying
