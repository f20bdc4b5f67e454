// Our reader against LinuxCNC's own interpreter, motion by motion: kind, line, end point, and for arcs
// centre, turns and the points in between.

#include "abbe/verify/reader.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <sstream>
#include <string>
#include <vector>

#include "abbe/machine/control_setup.h"
#include "tests/oracle/interpreter.h"
#include "tests/oracle/oracle_fixture.h"
#include "tests/oracle/random_program.h"

namespace abbe::oracle {
namespace {

constexpr double kSameDouble = 1e-9;  // mm: rounding of a few additions of coordinates up to 1 m

// The centre of an R arc is sqrt(r^2 - chord^2 / 4) away from the chord: near 180 degrees its last
// digits are lost, by eps r^2 / distance, at most sqrt(eps) r.
double centre_tolerance(const Motion& arc) {
  const Vec3 a = arc.start - arc.centre, b = arc.end - arc.centre;
  const double radius = a.norm();
  const double distance = (0.5 * (a + b)).norm();
  const double eps = std::numeric_limits<double>::epsilon();
  return kSameDouble + 16 * eps * radius * radius / std::max(distance, std::sqrt(eps) * radius);
}

std::string describe(const Motion& m) {
  std::ostringstream text;
  text.precision(15);
  text << "line " << m.line << " kind " << static_cast<int>(m.kind) << " from " << m.start.transpose()
       << " to " << m.end.transpose();
  if (m.kind == Motion::Kind::arc) text << " centre " << m.centre.transpose() << " turns " << m.turns;
  return text.str();
}

Motion same_form(const verifying::ListedMotion& listed, const Vec3& start) {
  using Kind = verifying::ListedMotion::Kind;
  Motion motion;
  motion.kind = listed.kind == Kind::rapid  ? Motion::Kind::rapid
                : listed.kind == Kind::line ? Motion::Kind::feed
                                            : Motion::Kind::arc;
  motion.line = static_cast<long>(listed.line);
  motion.start = start;
  motion.end = listed.end;
  motion.centre = listed.centre;
  motion.turns = listed.turns;
  return motion;
}

// Lines that go nowhere: cycles of LinuxCNC make them, a machine does not notice.
std::vector<Motion> without_rests(const std::vector<Motion>& all) {
  std::vector<Motion> motions;
  std::copy_if(all.begin(), all.end(), std::back_inserter(motions), [](const Motion& motion) {
    return motion.kind == Motion::Kind::arc || (motion.end - motion.start).norm() > kSameDouble;
  });
  return motions;
}

// The first difference, in words; empty if there is none.
std::string compare(const std::string& program, const Run& run, const ControlSetup& setup) {
  std::vector<Motion> listed;
  Vec3 at = Vec3::Zero();
  const auto diagnostics =
      verifying::list_motions(program, program, setup, [&](const verifying::ListedMotion& motion) {
        listed.push_back(same_form(motion, at));
        at = motion.end;
      });
  if (has_errors(diagnostics)) return "refused: " + to_text(diagnostics.front());

  const std::vector<Motion> theirs = without_rests(run.motions), ours = without_rests(listed);
  for (std::size_t k = 0; k < std::max(ours.size(), theirs.size()); ++k) {
    const std::string number = "motion " + std::to_string(k) + "\n";
    if (k >= ours.size()) return number + "missing: " + describe(theirs[k]);
    if (k >= theirs.size()) return number + "too many: " + describe(ours[k]);
    const Motion& a = theirs[k];
    const Motion& b = ours[k];
    const std::string both = number + "LinuxCNC " + describe(a) + "\nours     " + describe(b);
    if (a.kind != b.kind || a.line != b.line || a.turns != b.turns) return both;
    if (!((a.end - b.end).norm() <= kSameDouble)) return both;
    if (a.kind != Motion::Kind::arc) continue;
    const Vec3 off = (a.centre - b.centre) - (a.centre - b.centre).dot(a.normal) * a.normal;
    if (!(off.norm() <= centre_tolerance(a))) return both;
  }
  return {};
}

// The arcs as the verifier samples them, point by point.
std::string compare_points(const std::string& program, const Run& expected, const ControlSetup& setup) {
  auto opened = verifying::ProgramReader::open(program, program, setup, {});
  auto* reader = std::get_if<verifying::ProgramReader>(&opened);
  if (reader == nullptr) return "cannot be opened";
  std::vector<const Motion*> arcs;
  for (const Motion& motion : expected.motions) {
    if (motion.kind == Motion::Kind::arc) arcs.push_back(&motion);
  }
  std::size_t next = 0;
  for (;;) {
    const auto item = reader->next();
    if (item == verifying::ProgramReader::Item::refused) return "refused: " + to_text(reader->refusal());
    if (item == verifying::ProgramReader::Item::end) break;
    if (item != verifying::ProgramReader::Item::motion || reader->motion().kind != verifying::MotionKind::arc)
      continue;
    if (next == arcs.size()) return "an arc too many at line " + std::to_string(reader->line());
    const Motion& arc = *arcs[next++];
    for (const double s : {0.0, 0.1, 0.35, 0.5, 0.8, 1.0}) {
      const Vec3 theirs = point_at(arc, s), mine = verifying::point_at(reader->motion(), s);
      if (!((theirs - mine).norm() <= 4 * centre_tolerance(arc))) {
        std::ostringstream text;
        text.precision(15);
        text << describe(arc) << "\nat " << s << ": LinuxCNC " << theirs.transpose() << ", ours "
             << mine.transpose();
        return text.str();
      }
    }
  }
  return next == arcs.size() ? "" : "an arc is missing";
}

class MustAccept : public testing::TestWithParam<Listed> {};

TEST_P(MustAccept, MovesAsLinuxCnc) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  const Listed& listed = GetParam();
  if (!std::filesystem::exists(listed.file())) GTEST_SKIP() << listed.file() << " is absent";
  const auto expected = run(listed.file());
  ASSERT_TRUE(expected.has_value());
  ASSERT_TRUE(expected->accepted || (listed.has("open") && expected->open_end)) << expected->message;
  EXPECT_EQ(static_cast<long>(expected->motions.size()), listed.motions);
  EXPECT_THAT(compare(listed.file(), *expected, setup_of_oracle()), testing::IsEmpty());
  EXPECT_THAT(compare_points(listed.file(), *expected, setup_of_oracle()), testing::IsEmpty());
}

INSTANTIATE_TEST_SUITE_P(Programs, MustAccept, testing::ValuesIn(must_accept()), test_name);

// Fifty programs each, from consecutive seeds; a program that differs stays in the scratch folder.
void expect_random_programs_move_alike(int block, bool with_cycles) {
  constexpr int kPerBlock = 50, kShown = 3;
  const std::string folder = scratch();
  int different = 0;
  for (int k = 0; k < kPerBlock && different < kShown; ++k) {
    const auto seed = static_cast<std::uint64_t>(block * kPerBlock + k + 1);
    const std::string program = folder + "/seed_" + std::to_string(seed) + ".ngc";
    std::ofstream(program, std::ios::binary) << random_program(seed, {.cycles = with_cycles});
    const auto expected = run(program);
    ASSERT_TRUE(expected.has_value());
    ASSERT_TRUE(expected->accepted) << program << "\n" << expected->message;
    std::string difference = compare(program, *expected, setup_of_oracle());
    if (difference.empty()) difference = compare_points(program, *expected, setup_of_oracle());
    if (difference.empty()) {
      std::filesystem::remove(program);
    } else {
      ++different;
      ADD_FAILURE() << program << "\n" << difference;
    }
  }
}

class RandomPrograms : public testing::TestWithParam<int> {};

TEST_P(RandomPrograms, MoveAsLinuxCnc) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  expect_random_programs_move_alike(GetParam(), false);
}

TEST_P(RandomPrograms, WithCyclesMoveAsLinuxCnc) {
  if (!have_oracle()) GTEST_SKIP() << kNoOracle;
  expect_random_programs_move_alike(GetParam(), true);
}

INSTANTIATE_TEST_SUITE_P(Seeds, RandomPrograms, testing::Range(0, 6));

}  // namespace
}  // namespace abbe::oracle
