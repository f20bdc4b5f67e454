#include "abbe/cl/words.h"

#include <algorithm>
#include <array>

namespace abbe::cl {
namespace {

constexpr std::string_view kSurface = "the curve is made by the post-processor or the control";
constexpr std::string_view kTurned = "where the axes then stand is the post-processor's affair";
constexpr std::string_view kLanguage = "the record is run again, or not: one correction does not fit both";
constexpr std::string_view kSource = "it is APT source: the path is found by an APT processor";
constexpr std::string_view kDriven = "it moves the tool along a path that the record does not state";

// Sorted by name.
constexpr std::array kRules = {
    WordRule{"AIR", Policy::pass, {}},
    WordRule{"ARC", Policy::refuse, kSurface},
    WordRule{"AUXFUN", Policy::pass, {}},
    WordRule{"BREAK", Policy::pass, {}},
    WordRule{"CALL", Policy::refuse, kLanguage},
    WordRule{"CHECK", Policy::pass, {}},
    WordRule{"CIRCLE", Policy::motion, {}},
    WordRule{"CLAMP", Policy::pass, {}},
    WordRule{"CLEARP", Policy::pass, {}},
    WordRule{"COOLNT", Policy::pass, {}},
    WordRule{"COPY", Policy::refuse, kLanguage},
    WordRule{"COUPLE", Policy::refuse, "spindle and feed are coupled: the length of the motion matters"},
    WordRule{"CSI_SET_EXTENSION_LENGTH", Policy::pass, {}},
    WordRule{"CSI_SET_FLUTE_LENGTH", Policy::pass, {}},
    WordRule{"CSYS", Policy::follow, {}},
    WordRule{"CUTCOM", Policy::follow, {}},
    WordRule{"CUTTER", Policy::follow, {}},
    WordRule{"CYCLE", Policy::follow, {}},
    WordRule{"DELAY", Policy::pass, {}},
    WordRule{"DISPLY", Policy::pass, {}},
    WordRule{"END", Policy::pass, {}},
    WordRule{"END-OF-PATH", Policy::pass, {}},
    WordRule{"FEDRAT", Policy::follow, {}},
    WordRule{"FINI", Policy::follow, {}},
    WordRule{"FROM", Policy::motion, {}},
    WordRule{"GO", Policy::refuse, kSource},
    WordRule{"GOBACK", Policy::refuse, kSource},
    WordRule{"GODLTA", Policy::motion, {}},
    WordRule{"GODOWN", Policy::refuse, kSource},
    WordRule{"GOFWD", Policy::refuse, kSource},
    WordRule{"GOHOME", Policy::follow, {}},
    WordRule{"GOLFT", Policy::refuse, kSource},
    WordRule{"GORGT", Policy::refuse, kSource},
    WordRule{"GOTO", Policy::motion, {}},
    WordRule{"GOUP", Policy::refuse, kSource},
    WordRule{"HEAD", Policy::refuse, kTurned},
    WordRule{"HELIX", Policy::refuse, kSurface},
    WordRule{"IF", Policy::refuse, kLanguage},
    WordRule{"INDEX", Policy::refuse, kLanguage},
    WordRule{"INDIRP", Policy::refuse, kSource},
    WordRule{"INDIRV", Policy::refuse, kSource},
    WordRule{"INSERT", Policy::follow, {}},
    WordRule{"INTOL", Policy::pass, {}},
    WordRule{"JUMPTO", Policy::refuse, kLanguage},
    WordRule{"LEADER", Policy::pass, {}},
    WordRule{"LETTER", Policy::pass, {}},
    WordRule{"LINTOL", Policy::pass, {}},
    WordRule{"LOAD", Policy::follow, {}},
    WordRule{"LOADTL", Policy::follow, {}},
    WordRule{"LOOPND", Policy::refuse, kLanguage},
    WordRule{"LOOPST", Policy::refuse, kLanguage},
    WordRule{"MACHIN", Policy::pass, {}},
    WordRule{"MACRO", Policy::refuse, kLanguage},
    WordRule{"MCHTOL", Policy::pass, {}},
    WordRule{"MODE", Policy::refuse, "it may switch to incremental coordinates"},
    WordRule{"MOVARC", Policy::motion, {}},
    WordRule{"MSYS", Policy::follow, {}},
    WordRule{"MULTAX", Policy::follow, {}},
    WordRule{"NURBS", Policy::refuse, kSurface},
    WordRule{"OPSKIP", Policy::refuse, kLanguage},
    WordRule{"OPSTOP", Policy::pass, {}},
    WordRule{"ORIGIN", Policy::follow, {}},
    WordRule{"OUTTOL", Policy::pass, {}},
    WordRule{"PAINT", Policy::pass, {}},
    WordRule{"PARTNO", Policy::pass, {}},
    WordRule{"PLUNGE", Policy::refuse, kDriven},
    WordRule{"POLYGON", Policy::refuse, kSurface},
    WordRule{"PPFUN", Policy::pass, {}},
    WordRule{"PPRINT", Policy::pass, {}},
    WordRule{"PREFUN", Policy::refuse, "it puts a G code into the program"},
    WordRule{"PRINT", Policy::pass, {}},
    WordRule{"RAPID", Policy::follow, {}},
    WordRule{"REMARK", Policy::pass, {}},
    WordRule{"RETRCT", Policy::refuse, kDriven},
    WordRule{"REWIND", Policy::pass, {}},
    WordRule{"ROTABL", Policy::refuse, kTurned},
    WordRule{"ROTATE", Policy::refuse, kTurned},
    WordRule{"ROTHED", Policy::refuse, kTurned},
    WordRule{"SELECT", Policy::pass, {}},
    WordRule{"SEQNO", Policy::pass, {}},
    WordRule{"SETUP", Policy::pass, {}},
    WordRule{"SPINDL", Policy::pass, {}},
    WordRule{"SPLINE", Policy::refuse, kSurface},
    WordRule{"STOP", Policy::pass, {}},
    WordRule{"THREAD", Policy::refuse, "spindle and feed are coupled: the length of the motion matters"},
    WordRule{"TITLES", Policy::pass, {}},
    WordRule{"TLAXIS", Policy::follow, {}},
    WordRule{"TLDATA", Policy::follow, {}},
    WordRule{"TLON", Policy::refuse, kSource},
    WordRule{"TOLER", Policy::pass, {}},
    WordRule{"TOOL PATH", Policy::follow, {}},
    WordRule{"TOOLNO", Policy::pass, {}},
    WordRule{"TPRINT", Policy::pass, {}},
    WordRule{"TRACUT", Policy::refuse, kTurned},
    WordRule{"TRANS", Policy::follow, {}},
    WordRule{"TRNTYP", Policy::follow, {}},
    WordRule{"TURRET", Policy::follow, {}},
    WordRule{"UNIT", Policy::follow, {}},
    WordRule{"UNITS", Policy::follow, {}},
};

constexpr bool sorted() {
  for (std::size_t i = 1; i < kRules.size(); ++i) {
    if (!(kRules[i - 1].major < kRules[i].major)) return false;
  }
  return true;
}
static_assert(sorted(), "found by bisection");

}  // namespace

std::optional<WordRule> rule_of(std::string_view major) {
  const auto found =
      std::lower_bound(kRules.begin(), kRules.end(), major,
                       [](const WordRule& rule, std::string_view word) { return rule.major < word; });
  if (found == kRules.end() || found->major != major) return std::nullopt;
  return *found;
}

}  // namespace abbe::cl
