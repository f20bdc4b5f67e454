#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "abbe/core/diagnostic.h"
#include "abbe/core/file.h"
#include "abbe/machine/control_setup.h"
#include "abbe/verify/motion.h"
#include "abbe/verify/plain_motion.h"
#include "abbe/verify/rotary.h"

namespace abbe::verifying {

/// Reads a program as a stream of motions (in axis commands, mm) and events,
/// in the order in which the control executes them. Every byte is understood or refused.
///
/// cost    constant memory; about 150 ns per line of a 3-axis program, no allocation per line
/// source  docs/theory/verification.md
class ProgramReader {
 public:
  struct Options {
    bool hashed = true;              ///< file().sha256() will be asked for
    bool skip_deletable = false;     ///< blocks with '/' are not executed
    bool report_skipped = false;     ///< ... but come as events, with their text
    const Rotary* rotary = nullptr;  ///< kept by the caller; null: rotary words are refused
    bool looks_ahead = false;        ///< ahead() will be asked for
    FileGrowth* growth = nullptr;    ///< of a file that is still being written
  };
  [[nodiscard]] static FileResult<ProgramReader> open(const std::string& path, const std::string& name,
                                                      const ControlSetup& setup, const Options& options);
  ~ProgramReader();
  ProgramReader(ProgramReader&&) noexcept;
  ProgramReader& operator=(ProgramReader&&) noexcept;

  enum class Item : std::uint8_t { event, motion, end, refused };
  /// The next thing the program does. After `end` and `refused` it stays there.
  [[nodiscard]] Item next();

  [[nodiscard]] const Event& event() const;         ///< after Item::event, until the next call
  [[nodiscard]] const Motion& motion() const;       ///< after Item::motion, until the next call
  [[nodiscard]] const Diagnostic& refusal() const;  ///< after Item::refused

  /// Plain motions that come next, where nothing else comes first and no event is left; reads on for them.
  /// take() goes behind the first `count` of those that are left.
  [[nodiscard]] PlainRun plain();
  void take(std::size_t count);
  [[nodiscard]] PlainMotion here() const;  ///< where the last block has led

  /// Where the next motions seem to end, axis commands, mm: whenever new lines were read, once; else nothing.
  [[nodiscard]] std::span<const Vec3> ahead();

  [[nodiscard]] std::uint64_t line() const;  ///< of the current item, from 1
  [[nodiscard]] const std::string& name() const;
  [[nodiscard]] std::string source_line() const;  ///< text of that line, for excerpts
  [[nodiscard]] bool deletable() const;           ///< the current block starts with '/'
  [[nodiscard]] bool saw_deletable() const;       ///< some block so far did
  [[nodiscard]] const Frames& frames() const;     ///< in force for the current item
  [[nodiscard]] std::optional<int> tool() const;  ///< in the spindle
  [[nodiscard]] bool inch() const;                ///< units in force
  [[nodiscard]] const Profile& profile() const;   ///< of the control
  [[nodiscard]] const Turns& turns() const;       ///< of A B C after the current item's block, rad
  [[nodiscard]] bool tcp() const;                 ///< tool centre point control is on
  [[nodiscard]] LineReader& file();               ///< for bytes, identity and checksum

 private:
  struct State;
  explicit ProgramReader(std::unique_ptr<State> state);
  std::unique_ptr<State> state_;
};

/// One motion as LinuxCNC's interpreter would call it, in axis commands, mm.
struct ListedMotion {
  enum class Kind : std::uint8_t { rapid, line, arc } kind = Kind::rapid;
  std::uint64_t line = 0;
  Vec3 end = Vec3::Zero();
  Axes known = kAllAxes;       ///< axes of `end` that are known
  Vec3 centre = Vec3::Zero();  ///< arcs
  int plane = 17;              ///< arcs: 17 18 19
  int turns = 0;               ///< arcs: as in ARC_FEED, +1 counter-clockwise, -2 two turns clockwise
};

/// All motions of a program, canned cycles taken apart as LinuxCNC does (rapid over the hole, rapid to R,
/// feed, pecks with 0.254 mm clearance, retract). Stops at the first block that is not understood.
[[nodiscard]] Diagnostics list_motions(const std::string& path, const std::string& name,
                                       const ControlSetup& setup,
                                       const std::function<void(const ListedMotion&)>& found);

}  // namespace abbe::verifying
