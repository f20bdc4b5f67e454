#pragma once

#include <optional>
#include <string>
#include <vector>

#include "abbe/ballbar/ballbar_file.h"
#include "command_line.h"
#include "session.h"

namespace abbe::app {

/// Options for what ball-bar files may leave unsaid.
struct BallbarArguments {
  std::vector<std::string> files;
  std::string plane, direction;
  std::optional<double> radius, feed;  ///< mm, mm/min
};

void add_ballbar_options(Command& verb, BallbarArguments& arguments);

/// The options as defaults of the reader; nullopt after reporting a mistake.
[[nodiscard]] std::optional<BallbarDefaults> ballbar_defaults(const BallbarArguments& arguments,
                                                              Session& session);

/// Reads one file; nullopt after reporting what is wrong with it.
[[nodiscard]] std::optional<BallbarTest> load_ballbar(const std::string& file,
                                                      const BallbarDefaults& defaults, Session& session);

/// All files; nullopt if one of them cannot be used (the others are reported too), or if two hold the same
/// readings.
[[nodiscard]] std::optional<std::vector<BallbarTest>> load_ballbars(const BallbarArguments& arguments,
                                                                    Session& session);

}  // namespace abbe::app
