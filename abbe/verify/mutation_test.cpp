// Every way in which an output can be wrong, made from a good pair: each must be found, under its name.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "abbe/verify/test_programs.h"

namespace abbe::verifying {
namespace {

struct Mutation {
  const char* name;
  Draw draw;
  std::string from, to;  ///< the first `from` in the output becomes `to`
  const char* code;
};

void PrintTo(const Mutation& mutation, std::ostream* out) { *out << mutation.name; }

/// The line of `text` that starts with `start`, with its end.
std::string line_of(const std::string& text, const std::string& start) {
  std::size_t at = text.rfind(start, 0) == 0 ? 0 : text.find("\n" + start);
  if (at == std::string::npos) return "(no line starts with " + start;
  if (at != 0) ++at;
  return text.substr(at, text.find('\n', at) + 1 - at);
}

std::vector<Mutation> mutations() {
  const Pen out(true);
  const std::string lines = rapid_lines(out), circle = circle_in_pieces(out), split = split_line(out),
                    timed = split_line_inverse_time(out), turns = helix_turns(out), set = position_set(out),
                    moves = machine_moves(out), drill = holes(out), steps = increments(out),
                    quarters = quarter_arcs(out);
  const auto line = [](const std::string& text, const std::string& start) { return line_of(text, start); };
  const std::string third_piece = out.at(-40, 15, 0) + "\n", piece = "G2" + out.at(0, -50, 0);
  std::vector<Mutation> all = {
      {"DroppedSpindleStart", rapid_lines, "S1000 M3", "S1000", "V-EVENT"},
      {"SpindleTheOtherWay", rapid_lines, "M3", "M4", "V-EVENT"},
      {"ChangedSpeed", rapid_lines, "S1000", "S100", "V-EVENT"},
      {"ChangedFeed", rapid_lines, "F200", "F2000", "V-FEED"},
      {"DroppedFeed", rapid_lines, "G1 F200", "G1", "V-EVENT"},
      {"RapidBecomesFeed", rapid_lines, "M8\nG1", "M8\nG0", "V-CLASS"},
      {"FeedBecomesRapid", rapid_lines, "M9\nG0", "M9\nG1", "V-CLASS"},
      {"ChangedDwell", rapid_lines, "G4 P0.5", "G4 P5", "V-EVENT"},
      {"DroppedDwell", rapid_lines, "G4 P0.5\n", "", "V-EVENT"},
      {"ChangedTool", rapid_lines, "T1", "T2", "V-EVENT"},
      {"DroppedUnits", rapid_lines, "G21 G90", "G90", "V-EVENT"},
      {"ChangedComment", rapid_lines, "(setup)", "(Setup)", "V-EVENT"},
      {"ChangedProgramNumber", rapid_lines, "O7", "O8", "V-EVENT"},
      {"DroppedEnd", rapid_lines, "M5 M2", "M5", "V-EVENT"},
      {"ChangedTail", rapid_lines, "trailing", "Trailing", "V-EVENT"},
      {"CutShort", rapid_lines, "%\ntrailing (text\n", "", "V-MISSING"},
      {"SomethingAdded", rapid_lines, "(text\n", "(text\nG0 X0\n", "V-EXTRA"},
      {"CoolantMovedAcrossTheMotion", rapid_lines, "M9\n" + line(lines, "G0" + out.at(0, 0, 100)),
       line(lines, "G0" + out.at(0, 0, 100)) + "M9\n", "V-ORDER"},
      {"SwappedSign", rapid_lines, "X" + out.number(out.command(40, 60, 30).x()) + " Y59",
       "X-" + out.number(out.command(40, 60, 30).x()) + " Y59", "V-PATH"},
      {"LostWord", rapid_lines, " Y" + out.number(out.command(40, 60, 30).y()), "", "V-EXTRA"},
      {"LostRapidWord", rapid_lines, " Z" + out.number(out.command(10, 20, 30).z()) + "\nM8", "\nM8",
       "V-END"},
      {"LostFeedLine", rapid_lines, "F300" + out.at(40, 60, 30), "F300", "V-ORDER"},
      {"LostRapidLine", rapid_lines, line(lines, "G0" + out.at(0, 0, 100)), "", "V-ORDER"},
      {"DoubledEvent", rapid_lines, "M9\n", "M9\nM9\n", "V-ORDER"},
      {"BecameDeletable", rapid_lines, "M9\n", "/M9\n", "V-EVENT"},
      {"OneMicrometreOff", rapid_lines, "Y" + out.number(out.command(40, 60, 30).y()),
       "Y" + out.number(out.command(40, 60, 30).y() + 0.0015), ""},
      {"LostLastPiece", split_line, out.at(100, 50, 0) + " M0\n", "M0\n", "V-END"},
      {"DoubledPiece", split_line, third_piece, third_piece + third_piece, "V-EXTRA"},
      {"BackAndForth", split_line, third_piece, third_piece + out.at(-60, 10, 0) + "\n" + third_piece,
       "V-PATH"},
      {"StopTooEarly", split_line, third_piece, " M0" + third_piece, "V-END"},
      {"DroppedBlockNumber", split_line, "N5 ", "", "V-EVENT"},
      {"FeedOfOnePieceInInverseTime", split_line_inverse_time, "F20", "F40", "V-FEED"},
      {"ArcTheOtherWay", circle_in_pieces, piece, "G3" + piece.substr(2), "V-PATH"},
      {"LostSubArc", circle_in_pieces, line(circle, piece), "", "E-ARC"},
      {"WholeArcTheOtherWay", quarter_arcs, "G2", "G3", "V-PATH"},
      {"WrongCentre", quarter_arcs, "I-9.9990", "I-9.9790", ""},
      {"WrongTurns", helix_turns, line(turns, "G3" + out.at(5, 0, 4)), "", "V-PATH"},
      {"UncorrectedOffset", position_set, line(set, "G92"), "G92 X5 Y0\n", "V-FRAME"},
      {"ChangedMachineMove", machine_moves, "G53 G0 Z200", "G53 G0 Z199.993", "V-END"},
      {"DroppedMachineCoordinates", machine_moves, "G53 ", "", "V-CLASS"},
      {"CorrectedAWithheldAxis", machine_moves, "G0 X4", "G0 Z199.993 X4", "V-END"},
      {"ChangedHome", machine_moves, "G28 Z5", "G28 Z6", "V-END"},
      {"CorrectedAtAnUnknownPosition", machine_moves, "G0 X5\n", "G0 X4.9995\n", "V-END"},
      {"ChangedRetract", holes, "R1.9930", "R1.9830", "V-CYCLE"},
      {"ChangedDepth", holes, "Z-5.0070", "Z-5.0170", "V-CYCLE"},
      {"HoleElsewhere", holes, "Y9.9999", "Y10.0029", "V-CYCLE"},
      {"ChangedPeck", holes, "Q1.5", "Q1.4", "V-CYCLE"},
      {"ChangedCycleDwell", holes, "P0.2", "P0.3", "V-CYCLE"},
      {"OtherCycle", holes, "G81", "G85", "V-CYCLE"},
      {"OtherRetractLevel", holes, "G99", "G98", "V-EVENT"},
      {"MoreHoles", holes, "G82", "G82 L2", "V-CYCLE"},
      {"DriftInIncrements", increments, "X1.4999", "X1.5025", ""},
  };
  return all;
}

class Mutated : public ::testing::TestWithParam<Mutation> {};

TEST_P(Mutated, IsFound) {
  const Mutation& m = GetParam();
  std::string output = m.draw(Pen(true));
  ASSERT_TRUE(verify(plan_of(kMachine), m.draw(Pen(false)), output, ideal_job()).agrees)
      << "the pair itself is good";
  const std::size_t at = output.find(m.from);
  ASSERT_NE(at, std::string::npos) << m.from << " not in\n" << output;
  output.replace(at, m.from.size(), m.to);
  const VerifyReport report = verify(plan_of(kMachine), m.draw(Pen(false)), output, ideal_job());
  EXPECT_FALSE(report.agrees) << output;
  ASSERT_FALSE(report.diagnostics.empty());
  EXPECT_LE(report.diagnostics.size(), 21u);
  if (*m.code != '\0') {
    EXPECT_EQ(report.diagnostics.front().code, m.code) << texts(report);
  } else {
    EXPECT_THAT(report.diagnostics.front().code, ::testing::AnyOf("V-PATH", "V-END", "V-CYCLE"))
        << texts(report);
  }
}

INSTANTIATE_TEST_SUITE_P(All, Mutated, ::testing::ValuesIn(mutations()),
                         [](const auto& test) { return std::string(test.param.name); });

/// Digits as coarse as 20 um: every single coordinate changed is found. Where two arcs of one circle meet may
/// slide along it, so there the change is larger.
TEST(Mutations, EveryCoordinateCounts) {
  for (const Pair& pair : good_pairs()) {
    const double change = std::string_view(pair.name) == "CircleInPieces" ? 0.5 : 20 * um;
    const std::string original = pair.draw(Pen(false)), output = pair.draw(Pen(true));
    const Plan plan = plan_of(kMachine);
    int changed = 0;
    for (std::size_t at = 0; at < output.size(); ++at) {
      const bool coordinate = std::string_view("XYZIJKR").find(output[at]) != std::string_view::npos &&
                              at + 1 < output.size() &&
                              std::string_view("-0123456789").find(output[at + 1]) != std::string_view::npos;
      if (!coordinate) continue;
      const Decimal number = read_decimal(std::string_view(output).substr(at + 1));
      std::string other = output.substr(0, at + 1);
      append_fixed(other, number.value + change, 4);
      other += output.substr(at + 1 + number.length);
      ++changed;
      const VerifyReport report = verify(plan, original, other, ideal_job());
      EXPECT_FALSE(report.agrees) << pair.name << ": " << output.substr(at, number.length + 1)
                                  << " changed passed";
    }
    EXPECT_GT(changed, 5) << pair.name;
  }
}

/// No line of the output may be missing or doubled. (A split line may well have a piece less.)
TEST(Mutations, EveryLineCounts) {
  for (const Pair& pair : good_pairs()) {
    if (std::string_view(pair.name) == "SplitLine") continue;
    const std::string original = pair.draw(Pen(false)), output = pair.draw(Pen(true));
    const Plan plan = plan_of(kMachine);
    for (std::size_t at = 0; at < output.size();) {
      const std::size_t end = std::min(output.find('\n', at), output.size() - 1) + 1;
      const std::string text = output.substr(at, end - at);
      const bool blank = text.find_first_not_of("\r\n") == std::string::npos;
      if (!blank) {
        const VerifyReport lost =
            verify(plan, original, output.substr(0, at) + output.substr(end), ideal_job());
        EXPECT_FALSE(lost.agrees) << pair.name << " passed without " << text;
        const VerifyReport doubled =
            verify(plan, original, output.substr(0, end) + text + output.substr(end), ideal_job());
        EXPECT_FALSE(doubled.agrees) << pair.name << " passed with twice " << text;
      }
      at = end;
    }
  }
}

}  // namespace
}  // namespace abbe::verifying
