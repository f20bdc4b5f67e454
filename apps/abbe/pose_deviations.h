#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "abbe/chain/relative_deviation.h"
#include "pose_source.h"
#include "session.h"

namespace abbe::app {

/// The 24 measured deviations of gear and tool: static and of the motion, from columns
///
///     {gear|tool}_{static|motion}_{x|y|z}_{um|mm}     {gear|tool}_{static|motion}_{a|b|c}_{urad|rad|arcsec}
///
/// in the file of the poses (each row its own) or in a file of one row (the same for all poses). A group
/// of six is given whole or not at all.
class DeviationColumns {
 public:
  struct Values {
    PoseDeviations fixed, moving;
  };

  DeviationColumns();
  /// All names, for PoseSource::open.
  [[nodiscard]] const std::vector<std::string>& names() const { return names_; }
  /// Reads the file of one row ("" = none) and sees what the poses bring. False after reporting mistakes.
  [[nodiscard]] bool open(const std::string& path, const PoseSource& poses, Session& session);
  /// For the present row of the poses.
  [[nodiscard]] Values values(const PoseSource& poses) const;
  [[nodiscard]] bool has_gear() const { return groups_[0] || groups_[1]; }
  [[nodiscard]] bool has_tool() const { return groups_[2] || groups_[3]; }

 private:
  static constexpr std::size_t kNumbers = 24;
  [[nodiscard]] bool read_row(const std::string& path, Session& session);
  [[nodiscard]] bool check_groups(Session& session);

  std::vector<std::string> names_;
  std::vector<std::size_t> number_;                          ///< per name: which of the 24
  std::vector<double> unit_;                                 ///< per name: mm or rad
  std::array<std::optional<double>, kNumbers> constant_;     ///< from the file of one row
  std::array<std::optional<std::size_t>, kNumbers> column_;  ///< from the poses: index of names_
  std::array<bool, 4> groups_{};  ///< gear static, gear motion, tool static, tool motion
};

}  // namespace abbe::app
