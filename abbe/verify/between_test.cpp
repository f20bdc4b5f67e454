// How the tool turns between the ends of a block, as the verifying reader takes it from the codes.
#include <gtest/gtest.h>

#include <string>

#include "abbe/chain/test_plan.h"
#include "abbe/core/test_files.h"
#include "abbe/machine/read_profile.h"
#include "abbe/verify/verify.h"

namespace abbe {
namespace {

using testing::plan_of;
using testing::TestFile;

/// What the reader says of a program, "" if it follows it.
std::string said(const std::string& codes, const std::string& block, const std::string& between = "") {
  const Plan plan = plan_of(
      "format = 1\n[machine]\nchain = \"w C A b X Y Z t\"\n[axis.A]\ndirection = [1, 0, 0]\n"
      "[axis.C]\ndirection = [0, 0, 1]\n[tool]\nlength = 100\n[control]\nmode = \"axis\"\n"
      "vectors = { turns = \"nearest\"" +
      between + " }\n");
  const TestFile file("G17 G90 G94 G710 G54 D0\nG0 X0 Y0 Z0 A-30 C0\nTRAORI\nG0 X0 Y0 Z0\n" + codes + block +
                      "\nM30\n");
  VerifyJob job;
  job.original_path = job.output_path = file.path();
  job.original_name = job.output_name = "part.mpf";
  job.setup.work_offsets[0] = WorkOffset{};
  job.setup.profile = embedded_profile("siemens");
  std::string codes_found;
  for (const Diagnostic& d : verify_program(plan, job).diagnostics) codes_found += d.code + " ";
  return codes_found;
}
const char* const kFar = "G1 X5 A-40 C60 F500";
const char* const kNear = "G1 X5 A-30.5 C1 F500";
const char* const kEvenly = ", between = \"axes\"";

TEST(ControlBetween, CodesThatAgreeAreSure) {
  EXPECT_EQ(said("ORIMKS ORIAXES\n", kFar), "");
  EXPECT_EQ(said("ORIWKS ORIAXES\n", kFar, kEvenly), "");
  EXPECT_EQ(said("ORIMKS\n", kFar, kEvenly), "");
}

TEST(ControlBetween, OthersAreRefusedUnlessTheBlockIsShort) {
  for (const char* const codes :
       {"ORIWKS\n", "ORIVECT\n", "ORIMKS\n", "ORIWKS ORIAXES\n", "ORIMKS ORIVECT\n"}) {
    EXPECT_NE(said(codes, kFar).find("E-TCP"), std::string::npos) << codes;
    EXPECT_EQ(said(codes, kNear), "") << codes;
  }
  EXPECT_NE(said("ORIVECT\n", kFar, kEvenly).find("E-TCP"), std::string::npos);
  EXPECT_NE(said("ORIWKS\n", kFar, kEvenly).find("E-TCP"), std::string::npos);
}

TEST(ControlBetween, ThePoleIsNotPassedUnseen) {
  EXPECT_NE(said("ORIVECT\nG0 A0 C0\n", "G1 X5 A-0.001 C20 F500").find("E-TCP"), std::string::npos);
  EXPECT_NE(said("ORIVECT\nG0 A0 C0\n", "G1 X5 C20 F500").find("E-TCP"), std::string::npos);
  EXPECT_EQ(said("ORIVECT\nG0 A-20 C0\n", "G1 X5 A20 F500"), "");
}

TEST(ControlBetween, DirectionsAreOfTheWorkpiece) {
  EXPECT_NE(said("ORIMKS\n", "G1 X1 A3=0 B3=-0.5 C3=0.866025 F500").find("E-VECTOR"), std::string::npos);
  EXPECT_EQ(said("ORIWKS\n", "G1 X1 A3=0 B3=-0.5 C3=0.866025 F500"), "");
}

}  // namespace
}  // namespace abbe
