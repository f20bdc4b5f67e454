#include "tests/oracle/random_program.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>
#include <vector>

#include "abbe/pipeline/test_random_contour.h"

namespace abbe::oracle {
namespace {

using Point = std::array<double, 3>;
constexpr const char* kAxisLetters = "XYZ";
constexpr const char* kCentreLetters = "IJK";

class Generator {
 public:
  Generator(std::uint64_t seed, const Ingredients& ingredients) : random_(seed), with_(ingredients) {}

  std::string program() {
    line("G21 G90 G54 G17 G94 G64 M3 S1000 F500");
    absolute_move();
    for (int k = 0; k < 60; ++k) {
      switch (draw(12)) {
        case 0:
          units();
          break;
        case 1:
          line(pick({"G17", "G18", "G19"}));
          break;
        case 2:
          work_offset();
          break;
        case 3:
          axis_offset();
          break;
        case 4:
          tool();
          break;
        case 5:
          with_.machine_moves ? machine_move() : absolute_move();
          break;
        case 6:
          absolute_move();
          break;
        case 7:
          increments();
          break;
        case 8:
        case 9:
          arcs();
          break;
        case 10:
          with_.cycles ? cycles() : arcs();
          break;
        default:
          other();
          break;
      }
    }
    line(pick({"M2", "m30", "M5 M9 M2 (end)"}));
    return text_;
  }

 private:
  int draw(int below) { return static_cast<int>(random_() % static_cast<std::uint64_t>(below)); }
  bool chance(int percent) { return draw(100) < percent; }
  double between(double lo, double hi) {
    return lo + (hi - lo) * (static_cast<double>(random_() >> 11U) * 0x1p-53);
  }
  const char* pick(std::initializer_list<const char*> list) {
    return *(list.begin() + draw(static_cast<int>(list.size())));
  }

  double scale() const { return inch_ ? 1 / 25.4 : 1; }
  int digits() const { return inch_ ? 5 : 4; }
  double to_digits(double value) const {
    const double power = inch_ ? 1e5 : 1e4;
    return std::round(value * power) / power;
  }
  double coordinate() { return to_digits(between(-60, 60) * scale()); }

  void line(const std::string& words) {
    if (chance(15)) text_ += "N" + std::to_string(10 * ++number_) + pick({"", " ", "\t"});
    text_ += words;
    if (chance(8)) text_ += pick({" (comment)", " ; to the end", "(a)(b)"});
    text_ += chance(10) ? "\r\n" : "\n";
    if (chance(4)) text_ += pick({"\n", "(alone)\n", "   \n", "; line\n"});
  }

  // A word in one of the spellings that mean the same.
  std::string word(char letter, double value) {
    char digits_text[40];
    std::snprintf(digits_text, sizeof digits_text, "%.*f", digits(), value == 0 ? 0.0 : value);
    std::string number = digits_text;
    if (chance(10) && value > 0) number.insert(0, "+");
    if (chance(10)) {
      if (const auto zero = number.find("0.");
          zero != std::string::npos && (zero == 0 || number[zero - 1] == '-')) {
        number.erase(zero, 1);
      }
    }
    if (chance(10)) number.insert(number.find_first_of(".0123456789"), "0");
    if (chance(5)) number.insert(number.find('.'), " ");
    const char shown = chance(10) ? static_cast<char>(letter + ('a' - 'A')) : letter;
    return (chance(60) ? " " : "") + std::string(1, shown) + (chance(5) ? " " : "") + number;
  }

  std::string words(const Point& at, unsigned axes) {
    std::string text;
    for (unsigned i = 0; i < 3; ++i) {
      if ((axes >> i & 1U) != 0) text += word(kAxisLetters[i], at[i]);
    }
    return text;
  }

  unsigned some_axes() { return 1U + static_cast<unsigned>(draw(7)); }
  Point point() { return {coordinate(), coordinate(), coordinate()}; }

  void units() {
    inch_ = chance(50);
    line(std::string(inch_ ? "G20" : "G21") + (chance(50) ? " F30" : ""));
  }

  // All three axes: afterwards the position in the frame in force is what was written.
  void absolute_move(const std::string& before = "") {
    at_ = point();
    line(before + "G90 " + pick({"G0", "G1", "G01", "g0"}) + words(at_, 7));
  }

  void work_offset() {
    switch (draw(4)) {
      case 0:
        absolute_move(
            std::string(pick({"G54", "G55", "G56", "G57", "G58", "G59", "G59.1", "G59.2", "G59.3"})) + " ");
        break;
      case 1:
        line(std::string(pick({"G54", "G55", "G59.3"})));
        break;
      case 2: {
        std::string text = "G10 L2 P" + std::to_string(draw(10)) + words(point(), some_axes());
        if (with_.rotations && chance(30)) text += word('R', chance(30) ? 0 : std::round(between(-180, 180)));
        line(text);
        break;
      }
      default:
        line("G10 L20 P" + std::to_string(draw(10)) + words(point(), some_axes()));
        break;
    }
    if (chance(50)) absolute_move();
  }

  void axis_offset() {
    switch (draw(6)) {
      case 0:
      case 1:
        line("G92" + words(point(), some_axes()));
        g92_given_ = true;
        break;
      case 2:
        line("G52" + words(point(), some_axes()));
        g92_given_ = true;
        break;
      case 3:
        line("G92.1");
        g92_given_ = false;
        break;
      case 4:
        line("G92.2");
        break;
      default:
        if (g92_given_) line("G92.3");
        break;
    }
    if (chance(50)) absolute_move();
  }

  void tool() {
    const std::string number = std::to_string(1 + draw(20));
    switch (draw(6)) {
      case 0:
        line("T" + number + " M6");
        absolute_move();  // after a tool change the oracle, unlike a control, does not know where it stands
        break;
      case 1:
        line("T" + number + " M6 G43");
        absolute_move();
        break;
      case 2:
        line((with_.tool_numbers ? "M61 Q" : "M6 T") + number);
        absolute_move();
        break;
      case 3:
        line("G43 H" + number);
        break;
      case 4:
        line("G43.1" + words(point(), some_axes()));
        break;
      default:
        line("G49");
        break;
    }
    if (chance(30)) absolute_move("G43 H" + number + " ");
  }

  void machine_move() {
    line(std::string("G90 G53 ") + pick({"G0", "G1"}) + words(point(), some_axes()));
    if (chance(40)) line("G1" + words(point(), some_axes()));
  }

  void increments() {
    absolute_move();
    const int count = 1 + draw(5);
    for (int k = 0; k < count; ++k) {
      const unsigned axes = some_axes();
      line(std::string(k == 0 ? "G91 " : "") + pick({"G0", "G1"}) + words(point(), axes));
    }
    line("G90");
  }

  // One arc from at_; the mode words stand in the block itself.
  void arc() {
    static constexpr std::array<std::array<int, 3>, 3> kPlanes = {{{0, 1, 2}, {2, 0, 1}, {1, 2, 0}}};
    const int plane = with_.all_planes ? draw(3) : 0;
    const auto [a, b, c] = kPlanes[static_cast<std::size_t>(plane)];
    const auto ia = static_cast<std::size_t>(a), ib = static_cast<std::size_t>(b),
               ic = static_cast<std::size_t>(c);
    const bool incremental = chance(30), radius_form = chance(35), full = !radius_form && chance(20);
    const bool clockwise = chance(50), absolute_centre = chance(30), helix = chance(40);
    const double radius = between(0.5, 40) * scale();
    const double from = between(-std::numbers::pi, std::numbers::pi);
    double sweep = between(5, 175) * std::numbers::pi / 180;
    const bool major = chance(40);
    if (major) sweep += std::numbers::pi;
    const Point centre_exact{at_[ia] - radius * std::cos(from), at_[ib] - radius * std::sin(from), 0};
    const double to = from + (clockwise ? -sweep : sweep);

    Point end = at_;
    if (!full) {
      end[ia] = to_digits(centre_exact[0] + radius * std::cos(to));
      end[ib] = to_digits(centre_exact[1] + radius * std::sin(to));
    }
    if (helix) end[ic] = to_digits(at_[ic] + between(-5, 5) * scale());
    Point shown = end;
    if (incremental) {
      for (std::size_t i = 0; i < 3; ++i) shown[i] = to_digits(end[i] - at_[i]);
    }

    const unsigned in_plane = (1U << ia) | (1U << ib);
    unsigned axes = full && chance(50) ? 0U : in_plane;
    if (helix || chance(20)) axes |= 1U << ic;
    std::string text = plane == 0 ? "G17" : plane == 1 ? "G18" : "G19";
    text += incremental ? " G91" : " G90";
    text += absolute_centre ? " G90.1" : " G91.1";
    text += clockwise ? " G2" : " G3";
    text += words(shown, axes);
    if (radius_form) {
      text += word('R', to_digits(major ? -radius : radius));
    } else if (absolute_centre) {
      text += word(kCentreLetters[ia], to_digits(centre_exact[0])) +
              word(kCentreLetters[ib], to_digits(centre_exact[1]));
    } else {
      text += word(kCentreLetters[ia], to_digits(centre_exact[0] - at_[ia]));
      text += word(kCentreLetters[ib], to_digits(centre_exact[1] - at_[ib]));
    }
    if (!radius_form && chance(15)) text += " P" + std::to_string(1 + draw(3));
    line(text);
    at_ = end;
  }

  void arcs() {
    absolute_move();
    const int count = 1 + draw(4);
    for (int k = 0; k < count; ++k) arc();
    line("G90 G17 G91.1");
  }

  void cycles() {
    absolute_move("G17 ");
    const bool incremental = chance(40);
    const std::string code = pick({"G81", "G82", "G83", "G73", "G84", "G85", "G86", "G89", "G74"});
    // LinuxCNC 2.9.0~pre1 taps along permuted axes in G18 and G19; a reader refuses these two.
    const bool taps = code == "G74" || code == "G84";
    const std::string plane = taps ? "G17" : pick({"G17", "G17", "G18", "G19"});
    const std::array<char, 3> letters = plane == "G17"   ? std::array<char, 3>{'X', 'Y', 'Z'}
                                        : plane == "G18" ? std::array<char, 3>{'Z', 'X', 'Y'}
                                                         : std::array<char, 3>{'Y', 'Z', 'X'};
    const double bottom = to_digits((incremental ? between(-30, -1) : between(-60, 0)) * scale());
    const double retract = to_digits((incremental ? between(-20, 20) : between(1, 40)) * scale());
    std::string text = plane + (incremental ? " G91 " : " G90 ") + pick({"G98 ", "G99 ", ""}) + code;
    text += word(letters[0], coordinate()) + word(letters[1], coordinate());
    text += word(letters[2], bottom) + word('R', retract);
    if (code == "G82" || code == "G86" || code == "G89") text += " P0.1";
    if (code == "G83" || code == "G73") text += word('Q', to_digits(between(0.5, 9) * scale()));
    if (code != "G74" && chance(30))
      text += " L" + std::to_string(1 + draw(4));   // LinuxCNC refuses L with G74
    line(code == "G74" ? "M4 S1000" : "M3 S1000");  // M6 stopped it
    line(text);
    const int more = draw(4);
    for (int k = 0; k < more; ++k) {
      std::string next = word(letters[0], coordinate());
      if (chance(60)) next += word(letters[1], coordinate());
      if (chance(20)) next += word('R', to_digits((incremental ? between(-5, 5) : between(1, 40)) * scale()));
      line(next);
    }
    line("G80");
    line("G90 G17 G98");
    absolute_move();
  }

  void other() {
    switch (draw(9)) {
      case 0:
        line("G4 P0.01");
        break;
      case 1:
        line("G93 G1" + words(point(), some_axes()) + " F2");
        line("G94 F400");
        break;
      case 2:
        line("M3 S1000 G95 F0.1");
        line("G1" + words(point(), some_axes()));
        line("G94 F400");
        break;
      case 3:
        line("G61");
        break;
      case 4:
        line("G64 P0.01");
        break;
      case 5:
        line("M8");
        break;
      case 6:
        text_ += "/";
        line("G1" + words(point(), some_axes()));
        break;
      case 7:
        line("S" + std::to_string(draw(9000)));
        break;
      default:
        line("G0" + words(point(), some_axes()) + " M1");
        break;
    }
  }

  std::mt19937_64 random_;
  std::string text_;
  long number_ = 0;
  Ingredients with_;
  bool inch_ = false, g92_given_ = false;
  Point at_{};  ///< in the frame in force, as written; valid after absolute_move
};

}  // namespace

std::string random_program(std::uint64_t seed, const Ingredients& ingredients) {
  return Generator(seed, ingredients).program();
}

std::string random_contour(std::uint64_t seed, bool worn_only) {
  using abbe::testing::RandomContour;
  static constexpr std::array<RandomContour::Tool, 4> kTools = {{{1, 10}, {2, 6}, {8, 4}, {9, 12}}};
  abbe::testing::Random random(seed);
  return RandomContour(random, kTools[seed % kTools.size()], worn_only).write(seed % 3 == 0);
}

}  // namespace abbe::oracle
