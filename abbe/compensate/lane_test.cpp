// Lines corrected together are those corrected one by one, byte for byte.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <variant>

#include "abbe/compensate/correction_field.h"
#include "abbe/compensate/plain_line.h"
#include "abbe/compensate/plain_program_fixture.h"
#include "abbe/compensate/rewrite_fixture.h"
#include "abbe/compensate/turning_packet.h"
#include "abbe/program/block.h"

namespace abbe {
namespace {

using testing::five_axes;
using testing::RandomProgram;
using testing::rewrite;
using testing::Rewritten;

TEST(Lane, LinesTogetherAreLinesOneByOne) {
  const Machine machine = five_axes();
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::string program = RandomProgram(seed).text(400);
    RewriteJob job = testing::plain_job();
    job.probed_datum = seed % 2 == 0;
    job.setup.work_offsets[0]->origin = {seed * 3.0, 5, -7};
    const Rewritten together = rewrite(machine, program, job);
    job.one_by_one = true;
    const Rewritten alone = rewrite(machine, program, job);
    ASSERT_TRUE(alone.report.complete) << alone.findings();
    EXPECT_EQ(together.text, alone.text) << "seed " << seed;
    EXPECT_EQ(together.findings(), alone.findings());
    EXPECT_GT(together.report.blocks.together, 80u);
    EXPECT_EQ(alone.report.blocks.together, 0u);
    EXPECT_EQ(together.report.lines_out, alone.report.lines_out);
    EXPECT_EQ(together.report.blocks.motion, alone.report.blocks.motion);
    EXPECT_EQ(together.report.blocks.rewritten, alone.report.blocks.rewritten);
    EXPECT_EQ(together.report.blocks.split, alone.report.blocks.split);
    EXPECT_EQ(together.report.max_line, alone.report.max_line);
    for (std::size_t k = 0; k < 3; ++k)
      EXPECT_NEAR(together.report.max_correction[k], alone.report.max_correction[k], 1e-8);
  }
}

TEST(Lane, LinesTogetherAreLinesOneByOneOnACrookedMachine) {
  const Machine machine = five_axes("EA0Z = 900\nEB0Z = -1100\nEB0A = 800\n");
  for (unsigned seed = 1; seed <= 12; ++seed) {
    const std::string program = RandomProgram(seed).text(400);
    RewriteJob job = testing::plain_job();
    job.max_correction = 5;
    job.max_gradient = 1;
    const Rewritten together = rewrite(machine, program, job);
    job.one_by_one = true;
    const Rewritten alone = rewrite(machine, program, job);
    EXPECT_EQ(together.text, alone.text) << "seed " << seed;
    EXPECT_GT(together.report.blocks.together, 40u);
  }
}

TEST(Lane, ProgramsOfOthersAreTheSameOneByOne) {
  const std::filesystem::path folder = ABBE_SOURCE_DIR "/../shared/data/gcode";
  if (!std::filesystem::exists(folder)) GTEST_SKIP() << "no programs beside the sources";
  const Machine machine = five_axes();
  constexpr std::uintmax_t kLongest = 300000;  // bytes
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (!entry.is_regular_file() || entry.file_size() > kLongest) continue;
    const std::string program = testing::slurp(entry.path().string());
    RewriteJob job = testing::plain_job();
    const Rewritten together = rewrite(machine, program, job);
    job.one_by_one = true;
    const Rewritten alone = rewrite(machine, program, job);
    EXPECT_EQ(together.text, alone.text) << entry.path();
    EXPECT_EQ(together.findings(), alone.findings()) << entry.path();
  }
}

TEST(Lane, ALineThatIsTooFarOffIsRefusedAsAlone) {
  const Machine machine = five_axes();
  std::string program = "G21 G90 G17 G54 G94\nG0 X0 Y10 Z20 A30 C0\nG1 X1 Y10 Z20 A30.5 C0.5 F2000\n";
  for (int i = 0; i < 60; ++i)
    program += "X" + std::to_string(2 + 0.5 * i) + " A" + std::to_string(31 + 0.1 * i) + " C" +
               std::to_string(1 + 0.1 * i) + "\n";
  for (const char* last : {"X500 A40 C9\n", "X30 A120 C9\n", "X30 B1 A40 C9\n", "X30 A40 C9 X4\n"}) {
    RewriteJob job = testing::plain_job();
    const Rewritten together = rewrite(machine, program + last + "M2\n", job);
    job.one_by_one = true;
    const Rewritten alone = rewrite(machine, program + last + "M2\n", job);
    EXPECT_FALSE(alone.report.complete) << last;
    EXPECT_EQ(together.findings(), alone.findings());
  }
}

TEST(Lane, LongNumbersGoTheGeneralWay) {
  Machine machine = five_axes();
  for (auto& body : machine.bodies) body.range.reset();
  std::string program = "G21 G90 G17 G54 G94\nG0 X0 Y10 Z20 A30 C0\nG1 X1 Y10 Z20 A30.5 C0.5 F2000\n";
  for (int i = 0; i < 60; ++i)
    program += "X" + std::to_string(2 + 0.5 * i) + " A" + std::to_string(31 + 0.1 * i) + " C0.123456789012" +
               (i % 2 == 0 ? "3\n" : "\n");
  for (const char* last : {"X99999999999999 A40 C9\n", "X30 A40 C99999999999999.9\n",
                           "X30.00000000001 A40 C9\n", "X30 A-999999999999999 C9\n"}) {
    RewriteJob job = testing::plain_job();
    const Rewritten together = rewrite(machine, program + last + last + "M2\n", job);
    job.one_by_one = true;
    const Rewritten alone = rewrite(machine, program + last + last + "M2\n", job);
    EXPECT_EQ(together.text, alone.text) << last;
    EXPECT_EQ(together.findings(), alone.findings()) << last;
  }
}

TEST(TurningPacket, PlacesAreThoseOfTheField) {
  const Machine machine = five_axes();
  const Plan plan = std::get<Plan>(make_plan(machine, {}));
  const AddressedAxes axes = addressed_axes(machine);
  TurningPacket packet(plan, axes);
  ASSERT_TRUE(packet.usable());
  packet.set_tool(tool_of(machine));
  CorrectionField field(plan, axes, true);
  std::array<Vec3, TurningPacket::kMost> m;
  std::array<Turns, TurningPacket::kMost> turns;
  for (std::size_t i = 0; i < m.size(); ++i) {
    const double t = static_cast<double>(i);
    m[i] = {10 + 0.6 * t, -20 + 0.3 * t, 30 - 0.2 * t};
    turns[i] = {(25 + 0.2 * t) * deg, 0, (40 - 0.3 * t) * deg};
    packet.command(i, m[i], turns[i]);
  }
  packet.estimate(m.size(), field.datum());
  std::array<Turns, TurningPacket::kMost> stand, wanted;
  for (std::size_t i = 0; i < m.size(); ++i) {
    field.set_stance({turns[i], turns[i], false});
    const auto alone = field.turns_at(m[i], turns[i], 5);
    stand[i] = turns[i];
    for (std::size_t j = 0; j < 2; ++j) {
      const std::size_t k = packet.rotary()[j];
      EXPECT_GT(std::abs(alone.turns[k] - turns[i][k]), 1e-7);
      EXPECT_NEAR(packet.stand(i, j), alone.turns[k], 1e-7);
      wanted[i][k] = alone.turns[k];
      packet.stand(i, j) = stand[i][k] = alone.turns[k] + 4e-7;
    }
  }
  packet.settle();
  for (std::size_t i = 0; i < m.size(); ++i) {
    EXPECT_TRUE(packet.ordinary(i));
    for (std::size_t j = 0; j < 2; ++j)
      EXPECT_NEAR(packet.turn(i, j), wanted[i][packet.rotary()[j]], packet.turn_doubt(i));
    field.set_stance({turns[i], stand[i], false});
    EXPECT_LE((packet.place(i) - field.at(m[i]).q).cwiseAbs().maxCoeff(), packet.place_doubt(i));
    // 4e-7 rad move the tip by some 1e-4 mm: the axes follow that, so the last step is as short as errors are
    // small
    EXPECT_LT(packet.place_doubt(i), 2.1e-8);
  }
}

TEST(PlainLine, SaysWhatTheBlockSays) {
  for (const char* text : {"X1.5 Y-2. Z.25 A-30.25 C0 F800", "A1", "C-360.00001X2\r\n", "Z12.3456B7\n",
                           "N120 G1 X2 C3", "G01X2", "N7A1"}) {
    PlainLine line;
    ASSERT_TRUE(read_plain_line(text, line)) << text;
    Block block;
    ASSERT_FALSE(read_block(text, block));
    const auto axis_word = [](const Word& word) { return word.letter != 'N' && word.letter != 'G'; };
    const auto words =
        std::stable_partition(block.words.begin(), block.words.begin() + block.count, axis_word);
    ASSERT_EQ(line.count, static_cast<std::size_t>(words - block.words.begin()));
    EXPECT_EQ(line.text, block.text);
    EXPECT_EQ(line.eol, block.eol);
    for (std::size_t w = 0; w < line.count; ++w) {
      const PlainLine::Number& number = line.numbers[line.order[w]];
      EXPECT_EQ("XYZABCF"[line.order[w]], block.words[w].letter);
      EXPECT_EQ(number.value, block.words[w].value);
      EXPECT_EQ(number.begin, block.words[w].number);
      EXPECT_EQ(number.end, block.words[w].end);
      EXPECT_EQ(number.decimals, block.words[w].decimals);
    }
  }
  for (const char* text :
       {"",        "\n",       "F800", "G1",    "N5",   "N X2", "N5.1 X2", "G0 X2", "G10 X2",
        "G1.1 X2", "G1 N5 X2", "x2",   "X2 X3", "X +2", "X+2",  " X2",     "X2 ",   "X2  Y3",
        "X",       "X2(c)",    "X2;c", "/X2",   "X1E2", "X#1",  "X1.2.3",  "%",     "X--2"}) {
    PlainLine line;
    EXPECT_FALSE(read_plain_line(text, line)) << text;
  }
}

}  // namespace
}  // namespace abbe
