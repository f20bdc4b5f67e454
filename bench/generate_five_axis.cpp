// Writes what the five-axis bench needs; the same arguments give the same bytes.
//   generate_five_axis machine  > machine.toml     table-table, 40 functions of 100 nodes, axis mode
//   generate_five_axis smooth N > part.ngc         XYZAC of 4 decimals, 0.2 to 0.6 mm apart
//   generate_five_axis random N > part.ngc         rows at places of random magnitude, random steps of
//                                                  0.2 to 2 mm, 1 to 5 decimals, drawn for every word
#include <array>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
#include <string_view>

#include "bench/draw.h"
#include "bench/path_data.h"

namespace {

using abbe::bench::Draw;
using Place = std::array<double, 5>;  ///< X Y Z mm, A C degrees
constexpr double kDegree = 3.14159265358979323846 / 180;

void machine() {
  std::fputs(
      "format = 1\n[machine]\nname = \"five-axis bench\"\nchain = \"w C A Y b X Z t\"\n"
      "[axis.X]\nrange = [-450, 450]\n[axis.Z]\nrange = [-300, 300]\n"
      "[axis.A]\nrange = [-30, 110]\ndirection = [-1, 0, 0]\norigin = [0, 0, -50]\nerrors_seen = \"tool\"\n"
      "[axis.C]\ndirection = [0, 0, -1]\norigin = [0, 30, -80]\nerrors_seen = \"tool\"\n"
      "[axis.Y]\nrange = [-350, 350]\nerrors_seen = \"tool\"\n[control]\nmode = \"axis\"\n"
      "[tool]\norigin = [0, 0, 300]\nlength = 150\n[workpiece]\norigin = [0, 30, -80]\n[errors]\n",
      stdout);
  int seed = 1;
  for (const std::string axis : {"X", "Y", "Z", "A", "C"}) {
    const double range = axis == "A" || axis == "C" ? 180 : 500;
    for (const char d : std::string("XYZABC"))
      std::fputs(abbe::bench::table(std::string("E") + d + axis, seed++, 10, -range, range).c_str(), stdout);
  }
  std::fputs(
      "EC0X = 20\nEB0X = -5\nEA0Z = -12\nEB0Z = 9\nEA0C = 14\nEB0C = -8\nEY0A = 11\nEZ0A = 6\nEB0A = 7\n"
      "EC0A = -9\n",
      stdout);
}

void block(const char* code, const Place& at, const std::array<int, 5>& decimals) {
  std::fputs(code, stdout);
  for (std::size_t k = 0; k < 5; ++k)
    std::printf("%s%c%.*f", k > 0 ? " " : "", "XYZAC"[k], decimals[k], at[k] == 0 ? 0.0 : at[k]);
  std::fputc('\n', stdout);
}

/// A place of the smooth surface's path; t grows by about 1/400 per block.
Place on_path(double t) {
  return {200 * std::sin(t), 150 * std::cos(1.3 * t), 60 * std::sin(0.7 * t) - 40,
          (0.6 + 0.4 * std::sin(0.9 * t)) / kDegree, 1.5 * std::sin(0.5 * t) / kDegree};
}

void smooth(long lines) {
  Draw draw;
  double t = 0;
  for (long i = 0; i < lines; ++i, t += 1e-3 * (1 + 2 * draw()))
    block(i == 0 ? "G0 " : i == 1 ? "G1 F2400 " : "", on_path(t), {4, 4, 4, 4, 4});
}

Place somewhere(Draw& draw) {
  const auto magnitude = [&](double most) {
    return (draw() < 0.5 ? -1 : 1) * std::pow(10, -2 + draw() * (2 + std::log10(most)));
  };
  return {magnitude(300), magnitude(200), magnitude(100), 8 + 60 * draw(), magnitude(160)};
}

void random(long lines) {
  constexpr int kRow = 100;
  Draw draw;
  Place at{};
  for (long i = 0; i < lines; ++i) {
    const long in_row = i % kRow;
    if (in_row == 0) at = somewhere(draw);
    for (std::size_t k = 0; in_row > 0 && k < 5; ++k)
      at[k] += (draw() < 0.5 ? -1 : 1) * (k < 3 ? 0.2 + 1.8 * draw() * draw() : 0.1 + 0.3 * draw());
    std::array<int, 5> decimals{};
    for (int& d : decimals) d = 1 + static_cast<int>(5 * draw());
    block(in_row == 0 ? "G0 " : in_row == 1 ? "G1 F2400 " : "", at, decimals);
  }
}

}  // namespace

int main(int count, char** arguments) {
  const std::string_view what = count > 1 ? arguments[1] : "";
  const long lines = count > 2 ? std::strtol(arguments[2], nullptr, 10) : 0;
  if (what == "machine" && count == 2) {
    machine();
  } else if ((what == "smooth" || what == "random") && lines >= 20) {
    std::puts("G21 G90 G17 G54 G94");
    what == "smooth" ? smooth(lines - 2) : random(lines - 2);
    std::puts("M2");
  } else {
    std::fputs("usage: generate_five_axis machine | smooth LINES | random LINES (at least 20)\n", stderr);
    return 2;
  }
  return 0;
}
