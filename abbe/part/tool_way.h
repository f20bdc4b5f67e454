#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "abbe/evaluate/monte_carlo.h"
#include "abbe/part/sweep.h"

namespace abbe {

/// The poses of one motion of a program, in the order in which the tool takes them, part axes.
struct MotionPoses {
  std::uint64_t line = 0;  ///< of the program, from 1
  bool rapid = false;
  bool connected = true;  ///< the first pose is where the motion before ended
  double length = 0;      ///< mm, of the tip's nominal way
  double time = 0;        ///< s since the first motion, at its end
  std::vector<ToolPose> poses;
  std::vector<double> share;  ///< of the motion, per pose: 0 .. 1
};

/// What else than the machine's geometry moves the surface. All zero: nothing.
struct Disturbance {
  double noise =
      0;  ///< mm: standard deviation of each coordinate of the tip, drawn anew at the end of every motion
  double wear = 0;         ///< mm of the cutter, all over, per mm of feed
  double worn = 0;         ///< mm that the cutter lacks from the beginning
  std::uint64_t seed = 1;  ///< of the noise: the same seed gives the same part
};

/// A box of part space: only what may reach it is kept.
struct PartBox {
  Vec3 low = Vec3::Zero(), high = Vec3::Zero();
};

/// Puts motions together to the pieces that a cutter sweeps, with noise (linear between the ends of a motion)
/// and wear (by the feed length so far).
///
/// errors   is_full(): kMostPieces were kept, the rest was dropped
/// laws     WithoutDisturbanceThePosesAreThePieces, WearIsOfTheFeedLength, SameSeedSameWay
/// cost     100 bytes per piece kept
class ToolWay {
 public:
  static constexpr std::size_t kMostPieces = 1500000;  ///< with the tree over them 300 MB

  ToolWay(const Cutter& cutter, const Disturbance& disturbance, const PartBox& region);

  void add(const MotionPoses& motion);
  [[nodiscard]] std::vector<SweepPiece> take() { return std::move(pieces_); }
  [[nodiscard]] bool is_full() const { return full_; }
  [[nodiscard]] double feed_length() const { return feed_; }  ///< mm
  [[nodiscard]] double worn() const { return disturbance_.worn + disturbance_.wear * feed_; }

 private:
  [[nodiscard]] bool reaches(const SweepPiece& piece) const;
  [[nodiscard]] Vec3 draw();

  Cutter cutter_;
  Disturbance disturbance_;
  PartBox region_;
  RandomStream random_;
  Vec3 noise_ = Vec3::Zero();  ///< at the end of the last motion
  double feed_ = 0;
  bool full_ = false;
  std::vector<SweepPiece> pieces_;
};

}  // namespace abbe
