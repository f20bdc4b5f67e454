#pragma once

#include <string>
#include <vector>

#include "abbe/identify/joint.h"
#include "abbe/identify/paper.h"

namespace abbe {

/// What goes into the head of the file, as remarks and as [calibration].
struct ErrorsFileHead {
  std::vector<std::string> remarks;
  Calibration calibration;
};

/// A joint identification as an errors file (docs/machine-file.md) for `abbe predict MACHINE --errors FILE`:
/// mm, um and urad; every static function with the positions that were tested as its domain; [uncertainty]
/// with the largest standard uncertainty of the error over that domain (and over the tested rates). What is
/// assumed or an artefact is said beside it.
///
/// errors   terms whose value is 0 by assumption are left out and named in a remark
/// laws     PredictsWhatWasIdentified
[[nodiscard]] std::string errors_file_of(const Machine& machine, const Identification& identification,
                                         const std::vector<BallbarTest>& tests, const ErrorsFileHead& head);

/// The published identification: static polynomials of the displacement from the start point of the test they
/// come from, sines of time with scope = "test". The deviation holds for a machine of the chain w b X Y Z t
/// whose tool point is at the workpiece ball's centre plus the radius along X at the start.
[[nodiscard]] std::string errors_file_of(const PaperResult& result, const std::vector<PaperTest>& tests,
                                         const std::vector<BallbarTest>& circles, const ErrorsFileHead& head);

}  // namespace abbe
