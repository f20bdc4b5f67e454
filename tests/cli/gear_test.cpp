// `abbe gear`: the answers of its kinds, files, and what is refused.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <sstream>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

class GearVerb : public ::testing::Test {
 protected:
  ProgramRun run(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "gear");
    return run_abbe(arguments, {}, folder_.path());
  }
  json answer(std::vector<std::string> arguments) {
    arguments.emplace_back("--json");
    const ProgramRun done = run(arguments);
    EXPECT_EQ(done.exit, 0) << done.err;
    return json::parse(done.out);
  }
  std::string text_of(const std::string& name) {
    std::ifstream file(folder_ / name);
    return {std::istreambuf_iterator<char>(file), {}};
  }
  static double worst(const json& cut, const std::string& name) {
    for (const json& figure : cut["worst"])
      if (figure["name"] == name) return figure["value_um"];
    ADD_FAILURE() << name;
    return 0;
  }

  Folder folder_;
  std::string mill_ = folder_.put(
      "mill.toml",
      "format = 1\n[machine]\nname = \"mill\"\nchain = \"w C b X Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\n"
      "errors_seen = \"body\"\n[axis.X]\nrange = [100, 900]\n[axis.Z]\nrange = [-200, 200]\n[tool]\naxis = "
      "[0, 1, 0]\n"
      "[errors]\nEXX = 5\nEYZ = { poly = [3, 0.1] }\nEXw = 10\nTXX = { poly = [0, 1], of = \"T1\", reference "
      "= 20 }\n");
  std::string gear_ =
      folder_.put("gear.toml",
                  "format = 1\n[gear]\nname = \"seed\"\nmodule = 12\nteeth = 94\nface_width = 100\n"
                  "[wheel]\ndiameter = 300\n[evaluation]\nclass = 6\nteeth = [1, 25, 48, 72]\n");
};

TEST_F(GearVerb, MakePrintsTheGearAndItsTolerances) {
  const json made = answer({"make", "gear.toml", "--points", "p.csv", "--profile", "w.csv"});
  EXPECT_EQ(made["verb"], "gear make");
  EXPECT_NEAR(made["gear"]["base_diameter_mm"], 1059.9732762465, 1e-9);
  EXPECT_EQ(made["tolerances_um"]["F_p"], 58);
  EXPECT_EQ(made["wheel"]["centre_distance_mm"], 699);
  EXPECT_THAT(text_of("p.csv"),
              HasSubstr("flank,roll_mm,z_mm,x_mm,y_mm,nx,ny,nz\nright,157.813708,-50.000000,"));
  EXPECT_THAT(text_of("w.csv"), HasSubstr("\nleft,"));
}

TEST_F(GearVerb, CutMeasuresWhatTheMachineMade) {
  const json cut = answer({"cut", "mill.toml", "gear.toml", "--set", "T1=20", "--svg", "c.svg", "--cl",
                           "c.cls", "--motions", "m.csv", "--points", "p.csv"});
  EXPECT_EQ(cut["teeth"].size(), 8U);
  EXPECT_NEAR(worst(cut, "F_r"), 20, 0.1);
  EXPECT_NEAR(worst(cut, "F_p"), 21.28, 0.1);
  EXPECT_NEAR(worst(cut, "f_H_beta"), 0.1 * 90 * 0.93385, 0.01);
  EXPECT_LT(cut["second_order_um"], 0.01);
  EXPECT_THAT(text_of("c.svg"), HasSubstr("</svg>"));
  EXPECT_THAT(text_of("c.cls"), HasSubstr("$$ gap 94"));
  EXPECT_THAT(text_of("m.csv"), HasSubstr("gap,height_mm,time_s,C,X,Z\n1,-52.000000,23.571,"));
  EXPECT_THAT(text_of("p.csv"), HasSubstr("tooth,flank,roll_mm,z_mm,deviation_um\n1,right,"));
  // The CL data are the cut: as a program for the ideal machine every stroke is at the centre distance.
  const ProgramRun program = run_abbe({"inverse", "mill.toml", "--poses", "c.cls", "--set", "T1=20",
                                       "--ideal", "--emit", "gcode", "-o", "c.ngc"},
                                      {}, folder_.path());
  EXPECT_EQ(program.exit, 0) << program.err;
  EXPECT_THAT(text_of("c.ngc"), HasSubstr("G1 X699.0000"));
}

TEST_F(GearVerb, CorrectionAndCourse) {
  const json warm = answer({"cut", "mill.toml", "gear.toml", "--set", "T1=30", "--correct", "flank"});
  EXPECT_LT(worst(warm, "F_p"), 0.01);
  EXPECT_LT(worst(warm, "F_r"), 0.01);
  // The column warms up by 30 degrees within the cut: the gaps become shallower.
  folder_.put("course.csv", "time [s],T1 [degC]\n0,20\n3000,50\n");
  const json course = answer({"cut", "mill.toml", "gear.toml", "--course", "course.csv"});
  EXPECT_GT(worst(course, "F_r"), 28);
  folder_.put("bad.csv", "time [s],T1 [degC]\n10,20\n0,50\n");
  EXPECT_THAT(run({"cut", "mill.toml", "gear.toml", "--course", "bad.csv"}).err, HasSubstr("E-GEAR-COURSE"));
}

TEST_F(GearVerb, NothingIsCorrectedByErrorsNobodyMeasured) {
  folder_.put("narrow.toml",
              "format = 1\n[machine]\nchain = \"w C b X Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\n"
              "errors_seen = \"body\"\n[tool]\naxis = [0, 1, 0]\n[errors]\nEXZ = { table = [[-20, 1], [20, "
              "3]] }\n");
  EXPECT_THAT(run({"cut", "narrow.toml", "gear.toml"}).out, HasSubstr("extrapolated"));
  const ProgramRun corrected =
      run({"cut", "narrow.toml", "gear.toml", "--correct", "flank", "--motions", "m.csv"});
  EXPECT_EQ(corrected.exit, 5);
  EXPECT_THAT(corrected.err, HasSubstr("E-VOL"));
  EXPECT_EQ(text_of("m.csv"), "");
}

TEST_F(GearVerb, SensitivityNamesWhatMakesWhat) {
  const json given = answer({"sensitivity", "mill.toml", "gear.toml", "--set", "T1=20"});
  ASSERT_EQ(given["rows"].size(), 4U);
  EXPECT_NEAR(given["rows"][0]["depth_um"], 5, 1e-6);
  EXPECT_NEAR(given["rows"][2]["F_r_um"], 20, 0.1);
  EXPECT_EQ(
      answer({"sensitivity", "mill.toml", "gear.toml", "--set", "T1=20", "--of", "poses"})["rows"].size(),
      24U);
  EXPECT_THAT(run({"sensitivity", "mill.toml", "gear.toml", "--set", "T1=20", "--of", "units"}).out,
              HasSubstr("nothing on the gear:"));
}

TEST_F(GearVerb, CorrectFindsThePosesBehindTheFlanks) {
  ASSERT_EQ(run({"cut", "mill.toml", "gear.toml", "--set", "T1=20", "--points", "p.csv"}).exit, 0);
  const json found = answer(
      {"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "p.csv", "--motions", "m.csv"});
  EXPECT_LT(found["rms_left_um"], 0.001);
  EXPECT_LT(found["rank"], 24);
  EXPECT_EQ(found["by_poses"], false);  // no axis along y
  EXPECT_EQ(found["left_out"], 0);
  EXPECT_GT(found["before"]["F_p_um"], 20);
  EXPECT_LT(found["after"]["F_p_um"], 0.05);
  EXPECT_LT(found["after"]["F_beta_um"], 0.05);
  EXPECT_EQ(
      run({"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "p.csv", "-o", "o.cls"}).exit,
      2);
}

TEST_F(GearVerb, WhatWasCutForTheFlanksIsCorrectedForThem) {
  // The machine has an error of 20 um that its file does not know; the gear was cut with --correct flank, so
  // that only this one is on the flanks. What is sent then must be what --correct flank sends for both.
  const auto mill = [&](const char* name, const std::string& errors) {
    return folder_.put(name,
                       "format = 1\n[machine]\nchain = \"w C b X Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\n"
                       "errors_seen = \"body\"\n[tool]\naxis = [0, 1, 0]\n[errors]\n" +
                           errors);
  };
  const std::string known = "EXX = 5\nEYZ = { poly = [3, 0.1] }\n";
  mill("known.toml", known + "EXw = 10\n");
  mill("hidden.toml", "EXw = 20\n");
  mill("both.toml", known + "EXw = 30\n");
  ASSERT_EQ(run({"cut", "hidden.toml", "gear.toml", "--points", "p.csv"}).exit, 0);
  ASSERT_EQ(run({"cut", "both.toml", "gear.toml", "--correct", "flank", "--motions", "wanted.csv"}).exit, 0);
  const json found = answer({"correct", "known.toml", "gear.toml", "--measured", "p.csv", "--cut-with",
                             "flank", "--motions", "found.csv"});
  EXPECT_EQ(found["cut_with"], "flank");
  std::istringstream wanted(text_of("wanted.csv")), sent(text_of("found.csv"));
  std::string a, b;
  for (int row = 0; std::getline(wanted, a) && std::getline(sent, b); ++row) {
    if (row == 0) continue;
    std::istringstream numbers_a(a), numbers_b(b);
    for (std::string x, y; std::getline(numbers_a, x, ',') && std::getline(numbers_b, y, ',');)
      ASSERT_NEAR(std::stod(x), std::stod(y), 1e-4) << a << "\n" << b;
  }
  EXPECT_THAT(
      run({"correct", "known.toml", "gear.toml", "--measured", "p.csv", "--cut-with", "flank", "-o", "o.cls"})
          .err,
      HasSubstr("axis commands, not poses"));
}

TEST_F(GearVerb, CorrectedCommandsKeepTheTravels) {
  // X stands at 699 mm in every gap: corrected by -5 um it would leave a travel that ends there.
  folder_.put(
      "tight.toml",
      "format = 1\n[machine]\nchain = \"w C b X Z S t\"\n[axis.C]\ndirection = [0, 0, 1]\n"
      "errors_seen = \"body\"\n[axis.X]\nrange = [699, 800]\n[tool]\naxis = [0, 1, 0]\n[errors]\nEXX = 5\n");
  EXPECT_EQ(run({"cut", "tight.toml", "gear.toml"}).exit, 0);
  const ProgramRun done = run({"cut", "tight.toml", "gear.toml", "--correct", "flank", "--motions", "m.csv"});
  EXPECT_EQ(done.exit, 5);
  EXPECT_THAT(done.err, HasSubstr("E-TRAVEL"));
  EXPECT_EQ(text_of("m.csv"), "");
}

TEST_F(GearVerb, ACourseThatEndsEarlyIsTold) {
  folder_.put("course.csv", "time [s],T1 [degC]\n0,20\n600,50\n");
  const ProgramRun done = run({"cut", "mill.toml", "gear.toml", "--course", "course.csv", "--strict"});
  EXPECT_EQ(done.exit, 4);
  EXPECT_THAT(done.err, HasSubstr("W-GEAR-COURSE"));
}

TEST_F(GearVerb, WhatCannotBeMeantIsTold) {
  // Millimetres where micrometres are meant, and a point that is not on the flank.
  folder_.put("large.csv",
              "tooth,flank,roll_mm,z_mm,deviation_um\n1,right,193,0,5000\n1,left,193,0,5000\n1,left,9,0,1\n");
  const ProgramRun done = run(
      {"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "large.csv", "--sigma-um", "1"});
  EXPECT_EQ(done.exit, 0);
  EXPECT_THAT(done.err, HasSubstr("W-GEAR-LARGE"));
  EXPECT_THAT(done.out, HasSubstr("1 points left out"));
  // Two points leave nothing over.
  EXPECT_THAT(run({"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "large.csv"}).err,
              HasSubstr("E-GEAR-POINTS"));
}

TEST_F(GearVerb, WrongInputIsNamed) {
  const auto error = [&](std::vector<std::string> arguments, int exit, const char* code) {
    const ProgramRun done = run(arguments);
    EXPECT_EQ(done.exit, exit) << done.err;
    EXPECT_THAT(done.err, HasSubstr(code));
    EXPECT_EQ(done.out, "");
  };
  folder_.put("helical.toml",
              "format = 1\n[gear]\nmodule = 4\nteeth = 41\nhelix_angle = 15\nhand = \"right\"\nface_width = "
              "60\n[wheel]\n"
              "diameter = 300\n");
  folder_.put(
      "high.toml",
      "format = 1\n[gear]\nmodule = 12\nteeth = 94\nface_width = 100\n[wheel]\ndiameter = 300\n[cutting]\n"
      "middle = 500\n");
  folder_.put("points.csv", "tooth,flank,roll_mm,z_mm,deviation_um\n1,up,160,0,1\n");
  folder_.put("off.csv", "tooth,flank,roll_mm,z_mm,deviation_um\n1,left,-160,0,1\n");
  error({"cut", "mill.toml", "helical.toml", "--set", "T1=20"}, 2, "E-GEAR-AXES");
  error({"cut", "mill.toml", "high.toml", "--set", "T1=20"}, 5, "E-TRAVEL");
  error({"cut", "mill.toml", "gear.toml"}, 2, "E-SENSOR");
  error({"cut", "mill.toml", "gear.toml", "--set", "T1=20", "--teeth", "95"}, 2, "E-OPTION");
  error({"cut", "mill.toml", "none.toml", "--set", "T1=20"}, 2, "E-FILE");
  error({"cut", "mill.toml", "gear.toml", "--set", "T1=20", "--cl", "gear.toml"}, 2, "E-OPTION");
  error({"cut", "mill.toml", "gear.toml", "--set", "T1=20", "--correct", "all"}, 2, "E-USAGE");
  error({"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "points.csv"}, 2, "E-CELL");
  error({"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "off.csv"}, 2, "E-GEAR-POINTS");
  error({"correct", "mill.toml", "gear.toml", "--set", "T1=20", "--measured", "gear.toml"}, 2, "E-");
  error({"make", "gear.toml", "--points", "p.csv", "--rolls", "10000", "--heights", "10000"}, 2, "E-OPTION");
  error({"mak", "gear.toml"}, 2, "did you mean make?");
}

}  // namespace
}  // namespace abbe::cli
