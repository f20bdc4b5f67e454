#include "abbe/fit/fit_job.h"

#include <gtest/gtest.h>

#include <random>

#include "abbe/core/test_mutation.h"
#include "abbe/fit/test_hidden_machine.h"

namespace abbe {
namespace {

const std::string kHead = "format = 1\nmachine = \"hidden.toml\"\n";
const std::string kRun = "[[run]]\nfile = \"x.csv\"\nerror = \"EXX\"\n";

test::Files files() {
  return {
      {"hidden.toml", test::three_axis_machine()},
      {"x.csv", "target [mm],run,direction,deviation [um]\n0,1,+,0\n100,1,+,1\n200,1,+,3\n"},
      {"copy.csv", "target [mm],run,direction,deviation [um]\n0,1,+,0\n100,1,+,1\n200,1,+,3\n"},
      {"far.csv", "target [mm],run,direction,deviation [um]\n0,1,+,0\n1000,1,+,1\n"},
      {"angle.csv", "target [mm],run,direction,deviation [arcsec]\n0,1,+,0\n100,1,+,1\n"},
      {"points.csv", "X [mm],Y [mm],Z [mm],x [mm],y [mm],z [mm]\n0,0,0,0,0,180\n100,0,0,100,0,180\n"},
      {"balls.csv", "X [mm],Y [mm],Z [mm],ball,x [um],y [um],z [um]\n0,0,0,1,1,2,3\n0,0,0,1,2,2,3\n"},
      {"log.csv",
       "time [min],T1 [degC],Z1 [um]\n0,20,0\n1,21,1\n2,22,2\n3,23,3\n4,24,4\n5,24,4\n6,24,5\n7,23,4\n8,22,"
       "3\n9,22,2\n"}};
}

std::string code_of(const std::string& job) {
  const Parsed<FitJob> parsed = test::read_job(job, files());
  EXPECT_EQ(parsed.value.has_value(), !has_errors(parsed.diagnostics));
  for (const Diagnostic& diagnostic : parsed.diagnostics)
    if (diagnostic.severity == Severity::error) return diagnostic.code;
  return "";
}

TEST(ReadFitJob, UnitsSignsAndPoints) {
  const Parsed<FitJob> parsed =
      test::read_job(kHead + "[units]\nerror_length = \"nm\"\n[reference]\nY = 5\n" + kRun +
                         "at = { Z = -20 }\noptic = [1, 2, 3]\nsign = \"reversed\"\nnoise = 200\ntemperature "
                         "= 22\nexpansion_ppm = 11.5\n",
                     files());
  ASSERT_TRUE(parsed.value) << test::codes(parsed.diagnostics);
  const FitRun& run = parsed.value->runs.front();
  EXPECT_EQ(run.name, "EXX");
  EXPECT_EQ(parsed.value->machine.axis(run.axis).name, "X");
  EXPECT_EQ(run.at[2], -20);
  EXPECT_EQ(run.instrument.point, Vec3(1, 2, 300 - 120 + 3));
  EXPECT_EQ(run.instrument.sign, -1);
  EXPECT_NEAR(*run.instrument.noise, 200 * nm, 1e-15);
  EXPECT_NEAR(run.thermal, 23e-6, 1e-15);
  EXPECT_EQ(parsed.value->reference[1], 5);
}

TEST(ReadFitJob, EveryMistakeHasItsName) {
  EXPECT_EQ(code_of(kHead + kRun), "");
  EXPECT_EQ(code_of(kHead), "E-JOB-EMPTY");
  EXPECT_EQ(code_of("format = 1\n" + kRun), "E-MISSING-KEY");
  EXPECT_EQ(code_of("format = 1\nmachine = \"none.toml\"\n"), "E-CSV-FILE");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"none.csv\"\nerror = \"EXX\"\n"), "E-CSV-FILE");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"x.csv\"\nerror = \"EXQ\"\n"), "E-JOB-ERROR");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"x.csv\"\nerror = \"EC0Y\"\n"), "E-JOB-ERROR");
  EXPECT_EQ(code_of(kHead + kRun + "at = { Q = 1 }\n"), "E-JOB-AXIS");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"angle.csv\"\nerror = \"EXX\"\n"), "E-JOB-KIND");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"x.csv\"\nerror = \"EAX\"\n"), "E-JOB-KIND");
  EXPECT_EQ(code_of(kHead + "[[run]]\nfile = \"far.csv\"\nerror = \"EXX\"\n"), "E-JOB-RANGE");
  EXPECT_EQ(code_of(kHead + kRun + "[[run]]\nfile = \"copy.csv\"\nerror = \"EYX\"\n"), "E-JOB-TWICE");
  EXPECT_EQ(code_of(kHead + kRun + "square = \"granite\"\n"), "E-JOB-SQUARE");
  EXPECT_EQ(code_of(kHead + kRun + "noise = 0\n"), "E-JOB-VALUE");
  EXPECT_EQ(code_of(kHead + kRun + "temperature = 22\n"), "E-JOB-VALUE");
  EXPECT_EQ(code_of(kHead + kRun + "temperature = 72\nexpansion_ppm = 11\n"), "E-JOB-VALUE");
  EXPECT_EQ(code_of(kHead + kRun + "optic = [0, 0, 0]\nmeasured_at = [0, 0, 0]\n"), "E-JOB-VALUE");
  EXPECT_EQ(code_of(kHead + kRun + "colour = 3\n"), "E-UNKNOWN-KEY");
  EXPECT_EQ(code_of(kHead + "[functions]\nEXX = { form = \"polynomial\" }\n" + kRun), "E-MISSING-KEY");
  EXPECT_EQ(code_of(kHead + "[[value]]\nerror = \"EC0Y\"\nvalue = 3\n"), "E-MISSING-KEY");
  EXPECT_EQ(code_of(kHead + "[[value]]\nerror = \"EC0Y\"\nvalue = 3\nu = 0\n"), "E-JOB-VALUE");
  EXPECT_EQ(code_of(kHead + "[[points]]\nfile = \"x.csv\"\n"), "E-JOB-KIND");
  EXPECT_EQ(code_of(kHead + "[[points]]\nfile = \"points.csv\"\n"), "");
  EXPECT_EQ(code_of(kHead + "[[diagonal]]\nfile = \"x.csv\"\n"), "E-JOB-KIND");
}

TEST(ReadFitJob, ThermalErrorsNeedALogToFit) {
  const std::string thermal = kHead + "[thermal]\nerrors = [\"EZt\"]\n" + kRun;
  const std::string log = "[[drift]]\nfile = \"log.csv\"\nreadings = { Z1 = { direction = \"Z\" } }\n";
  EXPECT_EQ(code_of(thermal + log), "");
  EXPECT_EQ(code_of(thermal), "E-JOB-EMPTY");
  EXPECT_EQ(code_of(thermal + log + "use = \"validation\"\n"), "E-JOB-EMPTY");
}

TEST(ReadFitJob, TotalOnAnyBytes) {
  std::mt19937 random(20260303);
  const std::string seed =
      kHead + "[units]\nerror_angle = \"arcsec\"\n[functions]\nEXX = { form = \"cubic\", count = 4 }\n" +
      kRun + "at = { Y = 2 }\nsquare = \"s\"\n[[square]]\nname = \"s\"\nu = 1\n" +
      "[[value]]\nerror = \"EC0Y\"\nvalue = 3\nu = 1\n[[points]]\nfile = \"points.csv\"\n" +
      "[[diagonal]]\nfile = \"x.csv\"\nfrom = { X = 0 }\nto = { X = 200 }\n" +
      "[[ball]]\nfile = \"balls.csv\"\nnest = \"work\"\n[thermal]\nerrors = [\"EZt\"]\nsensors = [\"T1\"]\n" +
      "[[drift]]\nfile = \"log.csv\"\nreadings = { Z1 = { direction = \"Z\", optic = [1, 2, 3] } }\n";
  for (int round = 0; round < 2000; ++round) {
    const std::string text = test::damaged(seed, random, 1 + round % 4);
    const Parsed<FitJob> parsed = test::read_job(text, files());
    EXPECT_NE(parsed.value.has_value(), has_errors(parsed.diagnostics)) << text;
  }
}

}  // namespace
}  // namespace abbe
