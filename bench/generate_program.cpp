// Writes a three-axis finishing program of N lines: zigzag rows at 30 degrees over a wavy surface of
// 400 x 240 mm, points 0.4 to 1.2 mm apart, an arc every 41 lines, a rapid to each row, a comment
// to every second one. The same N gives the same bytes.
//   generate_program N > part.ngc
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "bench/draw.h"

namespace {

using abbe::bench::Draw;

constexpr double kLength = 400, kWidth = 240, kRowDistance = 0.35;  // mm
constexpr int kArcEvery = 41;

struct Point {
  double x = 0, y = 0, z = 0;
};

// Rows lie at 30 degrees, so that every word of every block changes.
Point on_surface(double along, double across) {
  constexpr double kAngle = std::numbers::pi / 6;
  const double x = along * std::cos(kAngle) - across * std::sin(kAngle) + kWidth * std::sin(kAngle);
  const double y = along * std::sin(kAngle) + across * std::cos(kAngle);
  return {x, y, -12 + 8 * std::sin(x / 37) * std::cos(y / 29) + 0.01 * along};
}

double to_digits(double value) { return std::round(value * 1e4) / 1e4; }

class Writer {
 public:
  explicit Writer(long lines) : left_(lines) {}

  [[nodiscard]] bool room_for(long lines) const { return left_ >= lines; }

  void line(const char* text) {
    std::fputs(text, stdout);
    std::fputc('\n', stdout);
    --left_;
  }

  void rapid(const Point& p) { motion(0, p); }

  void feed(const Point& p) { motion(1, p); }

  // Over the XY chord to p with a sagitta of a tenth of the chord; Z goes along (a helix).
  void arc(const Point& p, bool clockwise) {
    const double dx = p.x - at_.x, dy = p.y - at_.y;
    // sagitta s c over the chord c: the centre is (1 / (4 s) - s) c / 2 from the chord
    constexpr double kSagitta = 0.1, kCentre = (0.25 / kSagitta - kSagitta) / 2;
    const double side = clockwise ? -1 : 1;
    const double i = to_digits(dx / 2 - side * kCentre * dy), j = to_digits(dy / 2 + side * kCentre * dx);
    text_ = clockwise ? "G2" : "G3";
    words(p);
    word('I', i);
    word('J', j);
    mode_ = clockwise ? 2 : 3;
    line(text_.c_str());
  }

 private:
  void motion(int mode, const Point& p) {
    text_.clear();
    if (mode != mode_) text_ = mode == 0 ? "G0" : "G1";
    mode_ = mode;
    words(p);
    if (mode == 1 && !feed_given_) {
      text_ += " F2400";
      feed_given_ = true;
    }
    line(text_.c_str());
  }

  // Modal: words that keep their value are left out.
  void words(const Point& p) {
    const Point to{to_digits(p.x), to_digits(p.y), to_digits(p.z)};
    if (to.x != at_.x) word('X', to.x);
    if (to.y != at_.y) word('Y', to.y);
    if (to.z != at_.z) word('Z', to.z);
    at_ = to;
  }

  void word(char letter, double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%s%c%.4f", text_.empty() ? "" : " ", letter,
                  value == 0 ? 0.0 : value);
    text_ += buffer;
  }

  long left_;
  int mode_ = -1;
  bool feed_given_ = false;
  Point at_{1e9, 1e9, 1e9};
  std::string text_;
};

}  // namespace

int main(int count, char** arguments) {
  const long lines = count == 2 ? std::strtol(arguments[1], nullptr, 10) : 0;
  if (lines < 20) {
    std::fputs("usage: generate_program LINES (at least 20) > part.ngc\n", stderr);
    return 2;
  }
  Writer writer(lines - 3);  // the last three are written below
  writer.line("(zigzag finishing, generated)");
  writer.line("G21 G90 G17 G54");
  writer.line("S12000 M3");

  Draw draw;
  bool forward = true;
  long row = 0;
  int since_arc = 0;
  double across = 0;
  while (writer.room_for(12)) {
    double along = forward ? 0 : kLength;
    Point start = on_surface(along, across);
    start.z += 5;
    if (row % 2 == 0) writer.line(("(row " + std::to_string(row) + ")").c_str());
    writer.rapid(start);
    writer.feed(on_surface(along, across));
    while (writer.room_for(2)) {
      const double next = along + (forward ? 1 : -1) * (0.4 + 0.8 * draw());
      if (next < 0 || next > kLength) break;
      along = next;
      const Point p = on_surface(along, across);
      if (++since_arc % kArcEvery == 0) {
        writer.arc(p, row % 2 == 0);
      } else {
        writer.feed(p);
      }
    }
    Point lift = on_surface(along, across);
    lift.z += 5;
    if (writer.room_for(1)) writer.feed(lift);
    forward = !forward;
    ++row;
    across = across + kRowDistance > kWidth ? 0 : across + kRowDistance;
  }
  while (writer.room_for(1)) writer.line("(end of rows)");
  writer.line("G0 Z50.0000");
  writer.line("M5");
  writer.line("M2");
  return 0;
}
