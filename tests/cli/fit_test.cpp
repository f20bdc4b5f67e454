// `abbe simulate measurements` and `abbe fit`: the way from instruments to an errors file, and what is
// refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;
using ::testing::Not;

class Fit : public ::testing::Test {
 protected:
  Fit() {
    folder_.put(
        "mill.toml",
        "format = 1\n[machine]\nname = \"mill\"\nchain = \"w X b Y Z t\"\n[axis.X]\nrange = [0, 500]\n"
        "errors_seen = \"tool\"\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [-300, 0]\n");
    folder_.put("hidden.toml", "format = 1\n[errors]\nEXX = { poly = [0, 0.02] }\nEC0Y = 25\n");
  }
  ProgramRun run(std::vector<std::string> arguments) { return run_abbe(arguments, {}, folder_.path()); }

  Folder folder_;
  std::string job_ = folder_.put("job.toml",
                                 "format = 1\nmachine = \"mill.toml\"\n[[square]]\nname = \"s\"\nu = 0.2\n"
                                 "[[run]]\nfile = \"exx.csv\"\nerror = \"EXX\"\n"
                                 "[[run]]\nfile = \"eyx.csv\"\nerror = \"EYX\"\nsquare = \"s\"\n"
                                 "[[run]]\nfile = \"exy.csv\"\nerror = \"EXY\"\nsquare = \"s\"\n");
};

TEST_F(Fit, HiddenErrorsAreFoundAndUsed) {
  ASSERT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 0);
  const ProgramRun fit = run({"fit", job_, "-o", folder_ / "errors.toml", "--json"});
  ASSERT_EQ(fit.exit, 0) << fit.err;
  const json answer = json::parse(fit.out);
  EXPECT_EQ(answer["verb"], "fit");
  EXPECT_EQ(answer["rank"].get<std::size_t>() + answer["not_determined"].size(),
            answer["unknowns"].get<std::size_t>());
  ASSERT_EQ(answer["locations"].size(), 1U);
  EXPECT_EQ(answer["locations"][0]["name"], "EC0Y");
  EXPECT_NEAR(answer["locations"][0]["value"], 25, 3);
  const ProgramRun predict =
      run({"predict", "mill.toml", "--errors", "errors.toml", "--at", "X=500,Y=400,Z=0", "--json"});
  ASSERT_EQ(predict.exit, 0) << predict.err;
  const json deviation = json::parse(predict.out)["points"][0]["deviation"]["position_mm"];
  EXPECT_NEAR(deviation[0], 0, 1.5e-3);  // EXX adds 10 um, EC0Y takes 10 um
}

TEST_F(Fit, MeasurementsAreNotOverwritten) {
  ASSERT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 0);
  EXPECT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 2);
  EXPECT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml", "--force"}).exit, 0);
  EXPECT_EQ(run({"fit", job_, "-o", folder_ / "exx.csv"}).exit, 2);
}

TEST_F(Fit, WhatIsNotDeterminedIsSaid) {
  ASSERT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 0);
  const std::string asked = folder_.put("asked.toml",
                                        "format = 1\nmachine = \"mill.toml\"\nlocations = "
                                        "[\"EA0Z\"]\n[[run]]\nfile = \"exx.csv\"\nerror = \"EXX\"\n");
  const ProgramRun fit = run({"fit", asked, "--strict"});
  EXPECT_EQ(fit.exit, 4);
  EXPECT_THAT(fit.err, HasSubstr("W-FIT-RANK"));
  EXPECT_THAT(fit.err, HasSubstr("EA0Z"));
  EXPECT_THAT(fit.err, HasSubstr("[[value]]"));
  // One number does not make a function: [[value]] would be refused.
  const std::string function = folder_.put(
      "function.toml",
      "format = 1\nmachine = \"mill.toml\"\n[functions]\nECX = { form = \"polynomial\", order = 1 "
      "}\n[[run]]\nfile = \"exx.csv\"\nerror = \"EXX\"\n");
  const ProgramRun unseen = run({"fit", function});
  EXPECT_EQ(unseen.exit, 0) << unseen.err;
  EXPECT_THAT(unseen.err, HasSubstr("ECX is not determined"));
  EXPECT_THAT(unseen.err, HasSubstr("add a [[run]] of ECX"));
  EXPECT_THAT(unseen.err, Not(HasSubstr("[[value]]")));
}

// Targets every 50 mm say nothing of a pitch of 10 mm, but tell the rest of the function.
TEST_F(Fit, AFunctionToldInPartIsNotCalledUnseen) {
  ASSERT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 0);
  const std::string pitch = folder_.put(
      "pitch.toml",
      "format = 1\nmachine = \"mill.toml\"\n[functions]\nEXX = { form = \"polynomial\", order = 2, "
      "pitch = 10 }\n[[run]]\nfile = \"exx.csv\"\nerror = \"EXX\"\n");
  const ProgramRun told = run({"fit", pitch, "--json"});
  ASSERT_EQ(told.exit, 0) << told.err;
  EXPECT_THAT(told.err, HasSubstr("parameters of EXX are not determined"));
  EXPECT_THAT(told.err, Not(HasSubstr("no measurement shows it")));
  const json missing = json::parse(told.out)["not_determined"][0];
  EXPECT_EQ(missing["name"], "EXX");
  EXPECT_GE(missing["missing"], 1);
  EXPECT_LT(missing["missing"], missing["parameters"]);
}

TEST_F(Fit, StatesThatCannotBeComparedAreRefused) {
  ASSERT_EQ(run({"simulate", "measurements", job_, "--errors", "hidden.toml"}).exit, 0);
  const auto refusal = [&](const std::string& warm, std::vector<std::string> more) {
    std::vector<std::string> arguments = {"fit", job_, warm, "-o", "states.toml"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramRun result = run(arguments);
    EXPECT_EQ(std::filesystem::exists(folder_ / "states.toml"), result.exit == 0);
    std::filesystem::remove(folder_ / "states.toml");
    return result.exit == 0 ? "written" : result.err;
  };
  const auto job_with = [&](const char* machine, const char* more) {
    return folder_.put("warm.toml", std::string("format = 1\nmachine = \"") + machine + "\"\n" + more +
                                        "[[square]]\nname = \"s\"\nu = 0.2\n"
                                        "[[run]]\nfile = \"exx.csv\"\nerror = \"EXX\"\n"
                                        "[[run]]\nfile = \"eyx.csv\"\nerror = \"EYX\"\nsquare = \"s\"\n"
                                        "[[run]]\nfile = \"exy.csv\"\nerror = \"EXY\"\nsquare = \"s\"\n");
  };
  const std::vector<std::string> states = {"--states", "T1=18/28"};
  EXPECT_EQ(refusal(job_with("mill.toml", ""), states), "written");
  EXPECT_THAT(refusal(job_with("mill.toml", "[reference]\nX = 250\n"), states), HasSubstr("[reference]"));
  folder_.put("other.toml",
              "format = 1\n[machine]\nname = \"mill\"\nchain = \"w X b Y Z t\"\n[axis.X]\nrange = [0, 500]\n"
              "errors_seen = \"body\"\n[axis.Y]\nrange = [0, 400]\n[axis.Z]\nrange = [-300, 0]\n");
  EXPECT_THAT(refusal(job_with("other.toml", ""), states), HasSubstr("another machine file"));
  // An axis in place of a temperature would be read as its position.
  EXPECT_THAT(refusal(job_with("mill.toml", ""), {"--states", "Z=18/28"}), HasSubstr("Z is no sensor"));
  EXPECT_THAT(refusal(job_with("mill.toml", ""), {"--states", "T1=18/28", "--covariance"}),
              HasSubstr("--covariance"));
}

TEST_F(Fit, MissingFilesAreNamed) {
  const ProgramRun fit = run({"fit", job_});
  EXPECT_EQ(fit.exit, 2);
  EXPECT_THAT(fit.err, HasSubstr("exx.csv"));
  EXPECT_EQ(run({"fit", "none.toml"}).exit, 2);
}

}  // namespace
}  // namespace abbe::cli
