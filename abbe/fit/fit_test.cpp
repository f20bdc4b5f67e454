#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "abbe/fit/joint_fit.h"
#include "abbe/fit/test_hidden_machine.h"

namespace abbe {
namespace {

using namespace test;

constexpr double kSecondOrder = 20 * nm;  // products of angles, over the lever arms of this machine

struct Fitted {
  FitJob job;
  Observations observations;
  FitResult result;
  std::string text;
};

Fitted fit(const std::string& job_text, const Files& files) {
  Parsed<FitJob> job = read_job(job_text, files);
  if (!job.value) throw std::runtime_error(codes(job.diagnostics));
  Parsed<Observations> observations = observations_of(*job.value);
  if (!observations.value) throw std::runtime_error(codes(observations.diagnostics));
  Parsed<Unknowns> unknowns = unknowns_of(*job.value, *observations.value);
  if (!unknowns.value) throw std::runtime_error(codes(unknowns.diagnostics));
  Fitted out{*job.value, *observations.value, fit_jointly(*job.value, *observations.value, *unknowns.value),
             ""};
  out.text = write_errors_file(out.job, out.result);
  return out;
}

Plan plan_of(const HiddenMachine& hidden, const Fitted& fitted) {
  Parsed<Machine> machine =
      read_machine({"hidden.toml", hidden.text}, MachineText{"errors.toml", fitted.text}, {});
  if (!machine.value) throw std::runtime_error(codes(machine.diagnostics));
  EXPECT_TRUE(machine.diagnostics.empty()) << codes(machine.diagnostics);
  return HiddenMachine::plan(*machine.value);
}

double location(const FitResult& result, const std::string& name) {
  for (const FoundValue& value : result.locations)
    if (value.name == name) return value.value;
  return NAN;
}

/// All 18 runs of a three-axis machine, each on a line of its own, and three squares.
struct Campaign {
  Files files;
  std::string job =
      "format = 1\nmachine = \"hidden.toml\"\n"
      "[[square]]\nname = \"xy\"\nu = 0\ndeviation = 5\n[[square]]\nname = \"yz\"\nu = 0\n"
      "[[square]]\nname = \"zx\"\nu = 0\ndeviation = -8\n";

  Campaign(const HiddenMachine& hidden, int targets, Instrument instrument) {
    const std::array<std::array<double, 2>, 3> travel = {{{-200, 300}, {-200, 200}, {-150, 150}}};
    constexpr const char* kLetters = "XYZABC";
    files["hidden.toml"] = hidden.text;
    for (int axis = 0; axis < 3; ++axis) {
      const auto& ends = travel[static_cast<std::size_t>(axis)];
      const std::vector<double> positions = spaced_targets(ends[0], ends[1], targets);
      for (int direction = 0; direction < 6; ++direction) {
        const std::string name = fmt::format("E{}{}", kLetters[direction], kLetters[axis]);
        std::array<double, kMaxAxes> at = {20.0 * direction - 30, 40.0 - 25 * direction,
                                           10.0 * direction - 20};
        at[static_cast<std::size_t>(axis)] = 0;
        const Vec3 optic(15 - 4 * direction, 10 + 3 * direction, -30 + 5 * axis);
        const bool straightness = direction < 3 && direction != axis;
        instrument.slope = straightness ? slope_of(axis, direction) : 0;
        ++instrument.seed;
        files[name + ".csv"] = run_file(hidden, axis, direction, positions, at, optic, instrument);
        job += fmt::format(
            "[[run]]\nfile = \"{0}.csv\"\nerror = \"{0}\"\nat = {{ X = {1}, Y = {2}, Z = {3} }}\n"
            "optic = [{4}, {5}, {6}]\n{7}",
            name, at[0], at[1], at[2], optic[0], optic[1], optic[2],
            straightness ? fmt::format("square = \"{}\"\n", plane_of(axis, direction)) : "");
      }
    }
  }

  static const char* plane_of(int axis, int direction) {
    return axis + direction == 1 ? "xy" : axis + direction == 3 ? "yz" : "zx";
  }
  /// A square that lies rotated by g about n and whose second arm (j of i x j = n) is turned by a more: the
  /// reading falls by across . ((g [+ a]) n x along) per length.
  static double slope_of(int axis, int direction) {
    const Vec3 along = Vec3::Unit(axis), across = Vec3::Unit(direction);
    const Vec3 normal = along.cross(across).cwiseAbs();
    const bool second = normal.dot(along.cross(across)) < 0;
    const std::string plane = plane_of(axis, direction);
    const double lies = plane == "xy" ? 80 * urad : plane == "yz" ? -50 * urad : 30 * urad;
    const double angle = plane == "xy" ? 5 * urad : plane == "zx" ? -8 * urad : 0;
    return -(lies + (second ? angle : 0)) * across.dot(normal.cross(along));
  }
};

TEST(Fit, FindsWhatWasMeasured) {
  for (const char* seen : {"tool", "body"}) {
    const HiddenMachine hidden(three_axis_machine(seen), kHiddenErrors);
    const Campaign campaign(hidden, 11, {});
    const Fitted fitted = fit(campaign.job, campaign.files);
    ASSERT_EQ(fitted.result.status, FitResult::Status::ok);
    EXPECT_TRUE(fitted.result.not_determined.empty());
    EXPECT_EQ(fitted.result.locations.size(), 3U);
    EXPECT_LT(largest_difference(hidden, plan_of(hidden, fitted), volume_grid()), kSecondOrder)
        << fitted.text;
    for (const SetResidual& set : fitted.result.sets) EXPECT_LT(set.max, kSecondOrder) << set.name;
  }
}

// Without errors_seen the sign of what a table's errors are called is anybody's guess.
TEST(Fit, ATableHasToSayWhoseErrorsItStates) {
  const std::string line = "errors_seen = \"tool\"\n";
  const Campaign campaign(HiddenMachine(three_axis_machine(), kHiddenErrors), 11, {});
  Files files = campaign.files;
  std::string& machine = files.at("hidden.toml");
  machine.erase(machine.find(line), line.size());
  const Parsed<FitJob> job = read_job(campaign.job, files);
  ASSERT_TRUE(job.value) << codes(job.diagnostics);
  const Parsed<Unknowns> unknowns = unknowns_of(*job.value, *observations_of(*job.value).value);
  EXPECT_FALSE(unknowns.value);
  ASSERT_EQ(unknowns.diagnostics.size(), 1U) << codes(unknowns.diagnostics);
  EXPECT_EQ(unknowns.diagnostics.front().code, "E-ERRORS-SEEN");
}

TEST(Fit, SomeErrorWouldBeSeen) {
  // The test above has teeth: without errors the volume is wrong by 16 um, with one optic misplaced by some.
  const HiddenMachine hidden(three_axis_machine(), kHiddenErrors);
  EXPECT_GT(largest_difference(hidden, hidden.ideal, volume_grid()), 10 * um);
  Campaign campaign(hidden, 11, {});
  const std::string optic = "optic = [15, 10, -30]";
  campaign.job.replace(campaign.job.find(optic), optic.size(), "optic = [15, 60, -30]");
  EXPECT_GT(largest_difference(hidden, plan_of(hidden, fit(campaign.job, campaign.files)), volume_grid()),
            0.5 * um);
}

TEST(Fit, RemovesNineTenthsWithNoise) {
  const HiddenMachine hidden(three_axis_machine(), kHiddenErrors);
  const Campaign campaign(hidden, 11, {.noise = 0.3, .runs = 3});
  const Fitted fitted = fit(campaign.job, campaign.files);
  const Plan found = plan_of(hidden, fitted);
  EXPECT_LT(largest_difference(hidden, found, volume_grid()),
            0.1 * largest_difference(hidden, hidden.ideal, volume_grid()));
  EXPECT_NEAR(fitted.result.variance_ratio, 1, 0.4);
}

TEST(Fit, ReversalAndMeanAreApart) {
  const std::string errors =
      "[errors]\nEXX = { forward = { poly = [1, 0.02] }, backward = { poly = [-1.5, 0.02] } }\n"
      "ECY = { forward = 3, backward = -1 }\n";
  const HiddenMachine hidden(three_axis_machine(), errors);
  Files files = {{"hidden.toml", hidden.text}};
  files["x.csv"] =
      run_file(hidden, 0, 0, spaced_targets(-200, 300, 9), {}, Vec3::Zero(), {.bidirectional = true});
  files["y.csv"] =
      run_file(hidden, 1, 5, spaced_targets(-200, 200, 9), {}, Vec3::Zero(), {.bidirectional = true});
  const Fitted fitted =
      fit("format = 1\nmachine = \"hidden.toml\"\n[[run]]\nfile = \"x.csv\"\nerror = \"EXX\"\n"
          "[[run]]\nfile = \"y.csv\"\nerror = \"ECY\"\n",
          files);
  ASSERT_EQ(fitted.result.functions.size(), 2U);
  EXPECT_NEAR(fitted.result.functions[0].reversal[0], 2.5, 1e-6);
  EXPECT_NEAR(fitted.result.functions[1].reversal[0], 4, 1e-6);
  const Plan found = plan_of(hidden, fitted);
  const Query forward = hidden.query({100, 0, 0}, Vec3::Zero(), 0, 1),
              backward = hidden.query({100, 0, 0}, Vec3::Zero(), 0, -1);
  EXPECT_NEAR((actual_tip(found, forward) - actual_tip(found, backward)).x() / um, 2.5, 1e-4);
}

TEST(Fit, StraightnessWithoutASquareIsNoSquareness) {
  const HiddenMachine hidden(three_axis_machine(), kHiddenErrors);
  Files files = {{"hidden.toml", hidden.text}};
  files["s.csv"] = run_file(hidden, 1, 0, spaced_targets(-200, 200, 9), {}, Vec3::Zero(), {.slope = 50e-6});
  const Fitted fitted =
      fit("format = 1\nmachine = \"hidden.toml\"\nlocations = [\"EC0Y\"]\n[[run]]\nfile = \"s.csv\"\nerror = "
          "\"EXY\"\n",
          files);
  ASSERT_EQ(fitted.result.not_determined.size(), 1U);
  EXPECT_EQ(fitted.result.not_determined[0].name, "EC0Y");
  EXPECT_TRUE(fitted.result.not_determined[0].asked);
  EXPECT_THAT(fitted.result.not_determined[0].like.front(), ::testing::HasSubstr("alignment of s.csv"));
  EXPECT_TRUE(fitted.result.locations.empty());
  (void)plan_of(hidden, fitted);  // reads without a warning about a slope
}

TEST(Fit, ReversedSquareFindsItsOwnAngle) {
  const HiddenMachine hidden(three_axis_machine(), "[errors]\nEC0Y = 24\n");
  Files files = {{"hidden.toml", hidden.text}};
  const auto add = [&](const char* name, int axis, int direction, double slope) {
    files[name] =
        run_file(hidden, axis, direction, spaced_targets(-150, 150, 7), {}, Vec3::Zero(), {.slope = slope});
  };
  // The square lies at 60, then at -20 urad; its angle is 15 urad too large.
  add("x1.csv", 0, 1, -60e-6);
  add("y1.csv", 1, 0, 75e-6);
  add("x2.csv", 0, 1, 20e-6);
  add("y2.csv", 1, 0, -35e-6);
  const Fitted fitted =
      fit("format = 1\nmachine = \"hidden.toml\"\n[[square]]\nname = \"granite\"\n"
          "[[run]]\nfile = \"x1.csv\"\nerror = \"EYX\"\nsquare = \"granite\"\n"
          "[[run]]\nfile = \"y1.csv\"\nerror = \"EXY\"\nsquare = \"granite\"\n"
          "[[run]]\nfile = \"x2.csv\"\nerror = \"EYX\"\nsquare = \"granite\"\nreversed = true\n"
          "[[run]]\nfile = \"y2.csv\"\nerror = \"EXY\"\nsquare = \"granite\"\nreversed = true\n",
          files);
  EXPECT_NEAR(location(fitted.result, "EC0Y"), 24, 1e-2);
}

TEST(Fit, DiagonalsShowSquareness) {
  const HiddenMachine hidden(three_axis_machine(), "[errors]\nEC0Y = 20\n");
  Files files = {{"hidden.toml", hidden.text}};
  std::string job =
      "format = 1\nmachine = \"hidden.toml\"\n[functions]\nEXX = { form = \"polynomial\", order = 1 }\n";
  for (const double sign : {1.0, -1.0}) {
    const Vec3 way(400, sign * 300, 0);
    RunTable table;
    table.targets = spaced_targets(0, 500, 6);
    table.forward.resize(6, 1);
    for (Eigen::Index i = 0; i < 6; ++i) {
      const double t = table.targets[static_cast<std::size_t>(i)] / 500;
      table.forward(i, 0) =
          hidden.displacement(hidden.query({-100 + 400 * t, sign * (-150 + 300 * t), 0})).dot(way) / 500;
    }
    const std::string name = sign > 0 ? "pp.csv" : "pn.csv";
    files[name] = write_runs(table);
    job += fmt::format(
        "[[diagonal]]\nfile = \"{}\"\nfrom = {{ X = -100, Y = {} }}\nto = {{ X = 300, Y = {} }}\n", name,
        sign * -150, sign * 150);
  }
  const Fitted fitted = fit(job, files);
  EXPECT_NEAR(location(fitted.result, "EC0Y"), 20, 1e-2);
}

TEST(Fit, VolumePointsGiveAllErrorsAtOnce) {
  const HiddenMachine hidden(three_axis_machine(), kHiddenErrors);
  std::string csv = "X [mm],Y [mm],Z [mm],x [mm],y [mm],z [mm]\n",
              job = "format = 1\nmachine = \"hidden.toml\"\n[functions]\n";
  // A tracker far away, seen from two tool lengths: only so the rotations of Z show.
  const Eigen::AngleAxisd turn(0.7, Vec3(1, 2, 3).normalized());
  Files files = {{"hidden.toml", hidden.text}};
  for (const char* name : {"EXX", "EYX", "EZX", "EAX", "EBX", "ECX", "EXY", "EYY", "EZY", "EAY", "EBY", "ECY",
                           "EXZ", "EYZ", "EZZ", "EAZ", "EBZ", "ECZ"})
    job += fmt::format("{} = {{ form = \"polynomial\", order = 3 }}\n", name);
  int number = 0;
  for (const Vec3& optic : {Vec3(0, 0, 0), Vec3(60, -40, -80), Vec3(-30, 70, 10)}) {
    std::string text = csv;
    for (const double x : spaced_targets(-200, 300, 5))
      for (const double y : spaced_targets(-200, 200, 5))
        for (const double z : spaced_targets(-150, 150, 5)) {
          const Vec3 seen =
              turn * actual_tip(hidden.actual, hidden.query({x, y, z}, optic)) + Vec3(2000, -500, 300);
          text += fmt::format("{},{},{},{:.17g},{:.17g},{:.17g}\n", x, y, z, seen.x(), seen.y(), seen.z());
        }
    const std::string name = fmt::format("points{}.csv", ++number);
    files[name] = text;
    job += fmt::format("[[points]]\nfile = \"{}\"\noptic = [{}, {}, {}]\nnoise = 1\n", name, optic.x(),
                       optic.y(), optic.z());
  }
  const Fitted fitted = fit(job, files);
  ASSERT_EQ(fitted.result.status, FitResult::Status::ok);
  for (const SetResidual& set : fitted.result.sets) EXPECT_LT(set.max, 5 * kSecondOrder) << set.name;
  EXPECT_LT(largest_difference(hidden, plan_of(hidden, fitted), volume_grid()), 5 * kSecondOrder);
}

TEST(Fit, SquarenessIntervalsCoverTheTruth) {
  const HiddenMachine hidden(three_axis_machine(), "[errors]\nEC0Y = 24\nEB0Z = -18\nEA0Z = 11\n");
  double sum = 0;
  int count = 0, covered = 0;
  for (std::uint64_t seed = 0; seed < 40; ++seed) {
    Campaign campaign(hidden, 5, {.noise = 0.3, .runs = 2, .seed = 1000 * seed + 1});
    const FitResult result = fit(campaign.job, campaign.files).result;
    for (const auto& [name, truth] :
         {std::pair("EC0Y", 24.0), std::pair("EB0Z", -18.0), std::pair("EA0Z", 11.0)}) {
      for (const FoundValue& value : result.locations) {
        if (value.name != name) continue;
        const double z = (value.value - truth) / value.u;
        sum += z * z;
        covered += std::abs(z) < 1.96;
        ++count;
      }
    }
  }
  ASSERT_EQ(count, 120);
  EXPECT_NEAR(std::sqrt(sum / count), 1, 0.2);
  EXPECT_GE(covered, 106);  // 114 expected, standard deviation 2.4
}

}  // namespace
}  // namespace abbe
