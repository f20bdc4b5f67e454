#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace abbe {

/// A set of word letters: bit 0 = A .. bit 25 = Z.
using LetterSet = std::uint32_t;
[[nodiscard]] constexpr LetterSet letter_set(std::string_view letters) {
  LetterSet set = 0;
  for (const char letter : letters) set |= LetterSet{1} << (letter - 'A');
  return set;
}

/// Letters of the components of a tool axis vector whose words have names of their own (A3= B3= C3=): the
/// three bytes behind Z, which no program can write as a letter.
inline constexpr std::string_view kVectorLetters = "[\\]";

/// What a G or M code means. A control's profile gives each of its codes one of these; what the reader, the
/// rewriter and the verifying reader then do is their own affair. `unknown` codes are refused.
enum class Meaning : std::uint8_t {
  unknown,
  // motions
  rapid,
  line,
  arc_cw,
  arc_ccw,
  nurbs,
  no_motion,
  chip_break,
  tap_left,
  fine_bore,
  drill,
  drill_dwell,
  peck,
  tap,
  bore,
  bore_stop,
  bore_dwell,
  // codes of one block
  dwell,
  set_data,
  home,
  other_home,
  local_shift,
  machine_coordinates,
  set_position,
  clear_position,
  suspend_position,
  restore_position,
  exact_stop_once,
  // modes
  plane_xy,
  plane_zx,
  plane_yz,
  absolute,
  incremental,
  centre_absolute,
  centre_incremental,
  inverse_time,
  per_minute,
  per_turn,
  units_inch,
  units_mm,
  cutter_off,
  cutter_left,
  cutter_right,
  cutter_left_direct,
  cutter_right_direct,
  tool_length,
  tool_length_minus,
  tool_length_direct,
  tool_length_off,
  retract_initial,
  retract_r,
  work_offset,
  numbered_work_offset,
  path_control,
  spindle_mode,
  radius_mode,
  rotate,
  rotate_off,
  transformation_off,
  smoothing,
  copy,
  // frames made by a word: they replace what stands, or come on top of it
  frame_shift,
  frame_shift_further,
  frame_turn,
  frame_turn_further,
  frame_scale,
  frame_scale_further,
  frame_mirror,
  frame_mirror_further,
  // frames of a group of their own: G51 and G50, G51.1 and G50.1, G68.2 and G53.1
  scale,
  scale_off,
  mirror,
  mirror_off,
  tilted_plane,
  tool_to_plane,
  // PLANE SPATIAL, PLANE RESET; CYCLE800(..)
  spatial_plane,
  plane_off,
  swivel_plane,
  // cycles 10, 8, 26 and 11 of conversational programs: about the datum
  datum_turn,
  datum_mirror,
  datum_scale,
  datum_scale_evenly,
  tcp_on,
  tcp_off,
  // how rotary axes go from end to end: ORIWKS ORIMKS, ORIAXES ORIVECT
  turns_of_workpiece,
  turns_of_machine,
  axes_evenly,
  tool_evenly,
  // CYCLE81(..), MCALL
  bracket_cycle,
  modal_call,
  // M codes
  stop,
  end,
  tool_change,
  set_tool,
  spindle,
  coolant,
  override_switch,
  signal,
  call_subprogram,
  end_subprogram,
  // conversational programs: a cycle that a block defines and others call
  hole_cycle,
  cycle_call,
  cycle_call_modal,
  retract_tool,
  shortest_way,
  straight_way,
  auxiliary,
};
inline constexpr std::size_t kMeanings = static_cast<std::size_t>(Meaning::auxiliary) + 1;

/// How programs with a code are treated (docs/dialects.md): exact at the ends, with splitting (X); kept as
/// arcs (A); end points only (E); shifted as a whole (S); copied (P); copied with a warning (P!); refused
/// (R).
struct MeaningInfo {
  Meaning meaning;
  std::string_view name;  ///< as profiles spell it
  char kind;              ///< G or M
  std::string_view policy;
  LetterSet words;         ///< letters the code takes, unless the profile says otherwise
  std::string_view sense;  ///< for people
};
[[nodiscard]] const MeaningInfo& about(Meaning meaning);
[[nodiscard]] std::span<const MeaningInfo> all_meanings();

/// One code of a control.
struct CodeUse {
  Meaning meaning = Meaning::unknown;
  bool after = false;        ///< of an M code: it acts when the motion of its block is done
  std::uint8_t refusal = 0;  ///< 1 + index into Profile::refusals; 0: no special reason
  std::uint16_t number = 0;  ///< of a work offset: 1..9 = G54 .. G59.3, 9 + n = the further one n
  LetterSet words = 0;       ///< value letters that belong to it
};

/// Why a code is refused, where the reason is worth more than "not known".
struct CodeRefusal {
  std::string error, why, fix;
};

/// What the readers of programs must know of a control: plain values, read from a profile file
/// (docs/dialects.md). Lengths are mm unless they are digits of the program.
struct Profile {
  static constexpr std::size_t kGCodes = 8192;   ///< index = ten times the number: G59.1 = 591
  static constexpr std::size_t kKeywords = 512;  ///< behind them, codes that are words: SUPA
  static constexpr std::size_t kMCodes = 1024;

  std::string name, title, about;
  std::vector<std::string> sources;
  std::string file;  ///< where it was read from
  std::array<CodeUse, kGCodes + kKeywords> g;
  std::array<CodeUse, kMCodes> m;
  std::vector<CodeRefusal> refusals;
  LetterSet letters = 0;  ///< value letters of all codes together

  /// What a dimension word without a decimal point means: `ask` refuses the program (E-DECIMAL).
  enum class IntegerWords : std::uint8_t { units, increments, ask };
  struct Numbers {
    IntegerWords integer_words = IntegerWords::units;
    int decimals_mm = 4, decimals_inch = 5, decimals_degree = 4,
        decimals_feed = 4;    ///< digits after the point that are written
    int decimals_vector = 6;  ///< of the components of a tool axis vector
    int digits = 0;           ///< most digits of a number, 0 = any
    /// What a scale factor without a point counts: a thousandth, a hundred-thousandth; `ask` refuses it.
    enum class Scale : std::uint8_t { thousandths, hundred_thousandths, ask };
    Scale scale_words = Scale::ask;
    /// What one factor for all (CYCL DEF 11) scales: X and Y, or Z, too; `ask` refuses it.
    enum class ScaleAxes : std::uint8_t { plane, space, ask };
    ScaleAxes scale_axes = ScaleAxes::ask;
    bool finer = true;  ///< words with more decimals are read as they stand; else refused (E-DIGITS)
  } numbers;

  enum class Skip : std::uint8_t {
    none,
    plain,
    numbered,
    ignored
  };  ///< '/': unknown, '/', '/' '/1'..'/9', no meaning
  struct Text {
    std::size_t block_bytes = 254;              ///< without the end of line
    bool parentheses = true, semicolon = true;  ///< comments ( ), ;
    bool percent = true;                        ///< '%' at both ends
    bool colon = false;                         ///< ":1234" is a program number, too
    bool program_number = true;                 ///< "O1234"
    Skip skip = Skip::plain;
    bool names = false;           ///< words may have names: "X=10.5", "CR=5", "SUPA", "MSG(..)"; else RS274
    bool conversational = false;  ///< blocks are Klartext: "12 L X+10 IZ-5 R0 FMAX M3"
  } text;

  /// What follows the word of a code: nothing; nothing or "()"; "(..)" or nothing; "=" and a number, "[..]"
  /// between.
  enum class Form : std::uint8_t { alone, empty, arguments, value };
  struct Keyword {
    std::string name;       ///< capitals
    std::size_t index = 0;  ///< into `g`
    Form form = Form::alone;
  };
  std::vector<Keyword> keywords;  ///< in alphabetical order
  /// A value word with a name: "CR=" is an R.
  struct Address {
    std::string name;
    char letter = 0;
  };
  std::vector<Address> addresses;  ///< in alphabetical order

  /// Radii at both ends of an arc may differ by `tolerance`, by `relative` of the radius if more, never by
  /// `limit`.
  struct Arcs {
    double tolerance = 0.0282842712474619, limit = 2.82842712474619, relative = 1e-3;
    double inch_scale = 2.54;  ///< of the first two where the program is in inches, as the control has it
    bool radius_form = true, helix = true;
    bool turns = true;  ///< P = number of turns
  } arcs;

  /// What R and the bottom of a cycle are for later holes: the numbers as written, read anew in G90 and G91;
  /// the levels they made; or not to be used in the other mode (refused).
  enum class Sticky : std::uint8_t { numbers, levels, same_mode };
  struct Cycles {
    Sticky sticky = Sticky::numbers;
    char repeats = 'L';         ///< word that counts holes
    bool dwell_needed = true;   ///< a dwelling cycle must say P
    bool xy_only = false;       ///< in other planes refused
    bool level_below_r = true;  ///< the height before may lie below R; false: refused
    bool dwell_as_g4 = true;    ///< P of a cycle counts as P of G4 does; false: cycles with it stay cycles
  } cycles;

  struct Tools {
    bool h_needed = false;      ///< G43 without H is refused; false: the tool in the spindle
    bool z_only = false;        ///< the table's X and Y offsets do not act
    bool moves = false;         ///< the control may move when an offset changes without a Z word, or not
    bool change_first = true;   ///< M6 beside a motion comes before it; false: refused
    bool home_cancels = false;  ///< after a reference return or G53 the offset may be gone
    /// D: not known; puts the offset of the tool in the spindle in force (D1, D0 none); that of the table's
    /// row D.
    enum class Edges : std::uint8_t { none, tool, table };
    Edges edges = Edges::none;            ///< with either the offset must be stated after M6 and at the start
    bool follows_plane = false;           ///< in G18 and G19 the length acts along Y and X: refused
    bool in_machine_coordinates = false;  ///< it acts there too: refused unless it is zero
  } tools;

  /// What holds before the program says anything; `stated`: nothing is assumed (E-START).
  enum class Units : std::uint8_t { metric, imperial, stated };
  enum class Distance : std::uint8_t { absolute, incremental, stated };
  struct Start {
    Units units = Units::metric;
    Distance distance = Distance::absolute;
    bool first_offset = true;  ///< G54 is chosen; false: nothing is assumed (E-START)
    bool retract_to_r = true;  ///< G99
  } start;

  struct Offsets {
    int fixed = 9;    ///< how many of G54 .. G59.3 exist
    int further = 0;  ///< how many beyond them (G54.1 P, G154 P)
    bool l20_reads =
        true;  ///< G10 L20 makes the present position read the values; false: it sets a further offset
    bool keeps_shift =
        true;  ///< a shift of the program outlives the choice of another offset; false: refused
    bool increments_sure = true;  ///< G91 counts from where the axis stands when its zero has moved; false:
                                  ///< the control may add the shift: refused
    bool p0_active = true;        ///< G10 L2 P0 is the active one; false: the external offset, refused
  } offsets;

  /// A group-0 code that takes axis words may stand beside a motion code, which then only becomes the mode.
  bool home_beside_motion = false;
  bool feed_of_linear =
      true;  ///< beside turning axes F is of the linear ones where these move; false: not sure
  bool turns_evenly = true;       ///< with tool centre point control each rotary axis goes evenly from end to
                                  ///< end; false: ORIAXES ORIVECT ORIMKS ORIWKS say, else it is not sure
  bool rapid_straight = true;     ///< rapids go straight; else their path is the control's
  bool arc_centre_switch = true;  ///< arcs may have absolute centres (a code says so)
  double block_time = 0;  ///< a feed block that lasts shorter starves the control, s; 0: not known, no limit
};

/// The word that is a code of this control, or none. `name` in capitals. cost log(count).
[[nodiscard]] const Profile::Keyword* find_keyword(const Profile& profile, std::string_view name);
/// The letter that the value word `name` (capitals) stands for; 0: none.
[[nodiscard]] char find_address(const Profile& profile, std::string_view name);

/// Spells a code of the table: "G59.1", "SUPA".
[[nodiscard]] std::string g_name(const Profile& profile, std::size_t index);
/// "G43.4", "M3": the letter and the index into Profile::g or ::m; kind 0: not a code.
struct CodeName {
  char kind = 0;
  std::size_t index = 0;
};
[[nodiscard]] CodeName read_code_name(std::string_view text);

}  // namespace abbe
