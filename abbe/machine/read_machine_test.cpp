#include "abbe/machine/read_machine.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "abbe/core/file.h"
#include "abbe/machine/test_machines.h"

namespace abbe {
namespace {

using test::all_of;
using test::five_axis;
using test::read;
using ::testing::ElementsAre;
using ::testing::HasSubstr;

const Body& body(const Machine& machine, const std::string& name) {
  for (const Body& candidate : machine.bodies) {
    if (candidate.name == name) return candidate;
  }
  ADD_FAILURE() << "no body " << name;
  return machine.bodies.front();
}

#define READ_OR_FAIL(machine, ...)                                             \
  const auto parsed_##machine = read(__VA_ARGS__);                             \
  ASSERT_TRUE(parsed_##machine.value) << all_of(parsed_##machine.diagnostics); \
  const Machine& machine = *parsed_##machine.value

TEST(ReadMachine, LettersGiveTypeAndDirection) {
  READ_OR_FAIL(machine, "format = 1\n[machine]\nname = \"m\"\nchain = \"w b X U Y V Z W A B C S t\"\n");
  EXPECT_EQ(machine.name, "m");
  EXPECT_EQ(machine.chain, "w b X U Y V Z W A B C S t");
  const std::vector<std::pair<std::string, Vec3>> expected{
      {"X", Vec3::UnitX()}, {"U", Vec3::UnitX()}, {"Y", Vec3::UnitY()},
      {"V", Vec3::UnitY()}, {"Z", Vec3::UnitZ()}, {"W", Vec3::UnitZ()},
      {"A", Vec3::UnitX()}, {"B", Vec3::UnitY()}, {"C", Vec3::UnitZ()}};
  for (const auto& [name, direction] : expected) {
    EXPECT_EQ(body(machine, name).direction, direction) << name;
    EXPECT_EQ(body(machine, name).type, name < "D" ? AxisType::rotary : AxisType::linear) << name;
    EXPECT_EQ(body(machine, name).order, line_order());
    EXPECT_EQ(body(machine, name).address, name);
    EXPECT_TRUE(body(machine, name).correctable);
  }
  EXPECT_EQ(body(machine, "S").type, AxisType::fixed);
  EXPECT_EQ(body(machine, "S").axis, -1);
  EXPECT_EQ(body(machine, "S").address, "");
  EXPECT_FALSE(body(machine, "S").correctable);
  EXPECT_EQ(body(machine, "S").order.size(), 4u);
  EXPECT_EQ(body(machine, "S").order.front(), (Factor{FactorKind::location, false}));
  EXPECT_EQ(machine.axis_count(), 9);
  EXPECT_EQ(machine.variables.size(), 9u);
  EXPECT_EQ(machine.sha256.size(), 64u);
  EXPECT_TRUE(machine.errors.empty());
}

TEST(ReadMachine, LinearAxesOfTheWorkpieceBranchMoveTheOtherWay) {
  // ISO 841: +X moves the tool relative to the work, so the table moves towards -x
  READ_OR_FAIL(machine, five_axis(""));
  EXPECT_EQ(body(machine, "X").direction, Vec3(-1, 0, 0));
  EXPECT_EQ(body(machine, "X").branch, Branch::workpiece);
  EXPECT_EQ(body(machine, "C").direction, Vec3(0, 0, 1));
  EXPECT_EQ(body(machine, "Y").direction, Vec3(0, 1, 0));
  READ_OR_FAIL(stated, "format = 1\n[machine]\nchain = \"w X' b Y t\"\n[axis.X]\ndirection = [2, 0, 0]\n");
  EXPECT_EQ(body(stated, "X").direction, Vec3(1, 0, 0));  // as stated, normalised, the prime ignored
}

TEST(ReadMachine, OtherLettersAreWhatTheirTableSays) {
  READ_OR_FAIL(
      machine,
      "format = 1\n[machine]\nchain = \"w b Q R12 H t\"\n[axis.Q]\ntype = \"linear\"\ndirection = [0, 3, 4]\n"
      "[axis.R12]\ntype = \"rotary\"\ndirection = [0, -1, 0]\naddress = \"R\"\n[axis.H]\ntype = \"fixed\"\n");
  EXPECT_TRUE(body(machine, "Q").direction.isApprox(Vec3(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(body(machine, "R12").type, AxisType::rotary);
  EXPECT_EQ(body(machine, "R12").address, "R");
  EXPECT_EQ(body(machine, "H").type, AxisType::fixed);
}

TEST(ReadMachine, LengthsAndAnglesAreConverted) {
  READ_OR_FAIL(machine,
               five_axis("range = [-1, 2]\norigin = [1, 2, 3]\nmeasured_at = [0, 0, 1]\n"
                         "[axis.A]\nrange = [-90, 45]\n"
                         "[units]\nlength = \"in\"\nerror_length = \"nm\"\nerror_angle = \"arcsec\"\n"
                         "[tool]\norigin = [0, 0, 10]\nlength = 4\naxis = [0, 3, 4]\n"
                         "[workpiece]\norigin = [1, 0, 0]\n"
                         "[errors]\nEYY = 2\nEAY = 3\n"));
  EXPECT_EQ(body(machine, "X").origin, Vec3(25.4, 50.8, 3 * 25.4));
  EXPECT_EQ(*body(machine, "X").measured_at, Vec3(0, 0, 25.4));
  EXPECT_THAT(*body(machine, "X").range, ElementsAre(-25.4, 50.8));
  EXPECT_DOUBLE_EQ((*body(machine, "A").range)[0], -std::acos(0.0));
  EXPECT_EQ(machine.tool.origin, Vec3(0, 0, 254));
  EXPECT_DOUBLE_EQ(machine.tool.length, 101.6);
  EXPECT_TRUE(machine.tool.axis.isApprox(Vec3(0, 0.6, 0.8), 1e-15));
  EXPECT_EQ(machine.workpiece_origin, Vec3(25.4, 0, 0));
  ASSERT_EQ(machine.errors.size(), 2u);
  EXPECT_DOUBLE_EQ(machine.errors[0].scale, 1e-6);
  EXPECT_DOUBLE_EQ(machine.errors[1].scale, std::acos(-1.0) / 180 / 3600);
  EXPECT_DOUBLE_EQ(machine.axis_unit(machine.find_axis("Y")), 25.4);
}

TEST(ReadMachine, EveryUnitHasItsFactor) {
  const auto units = [](const std::string& key, const std::string& word) {
    return read("format = 1\n[machine]\nchain = \"w b t\"\n[units]\n" + key + " = \"" + word + "\"\n")
        .value->units;
  };
  EXPECT_DOUBLE_EQ(units("length", "mm").length, 1);
  EXPECT_DOUBLE_EQ(units("length", "m").length, 1000);
  EXPECT_DOUBLE_EQ(units("length", "in").length, 25.4);
  EXPECT_DOUBLE_EQ(units("angle", "deg").angle, std::acos(-1.0) / 180);
  EXPECT_DOUBLE_EQ(units("angle", "rad").angle, 1);
  EXPECT_DOUBLE_EQ(units("error_length", "um").error_length, 1e-3);
  EXPECT_DOUBLE_EQ(units("error_length", "mm").error_length, 1);
  EXPECT_DOUBLE_EQ(units("error_length", "nm").error_length, 1e-6);
  EXPECT_DOUBLE_EQ(units("error_length", "in").error_length, 25.4);
  EXPECT_DOUBLE_EQ(units("error_angle", "urad").error_angle, 1e-6);
  EXPECT_DOUBLE_EQ(units("error_angle", "mrad").error_angle, 1e-3);
  EXPECT_DOUBLE_EQ(units("error_angle", "rad").error_angle, 1);
  EXPECT_DOUBLE_EQ(units("error_angle", "arcsec").error_angle, 4.84813681109536e-6);
  EXPECT_DOUBLE_EQ(units("error_angle", "deg").error_angle, 0.0174532925199433);
  EXPECT_DOUBLE_EQ(units("angle", "deg").length, 1);
  EXPECT_DOUBLE_EQ(units("angle", "deg").error_length, 1e-3);
  EXPECT_DOUBLE_EQ(units("angle", "deg").error_angle, 1e-6);
}

TEST(ReadMachine, ToolOriginDefaultsToTheLastToolBranchBody) {
  READ_OR_FAIL(machine, five_axis("[axis.S]\norigin = [1, 2, 3]\n"));
  EXPECT_EQ(machine.tool.origin, Vec3(1, 2, 3));
  EXPECT_EQ(machine.tool.axis, Vec3::UnitZ());
  EXPECT_EQ(machine.tool.length, 0);
  READ_OR_FAIL(table_only, "format = 1\n[machine]\nchain = \"w X b t\"\n[axis.X]\norigin = [1, 2, 3]\n");
  EXPECT_EQ(table_only.tool.origin, Vec3::Zero());
}

TEST(ReadMachine, OrdersAndPresets) {
  READ_OR_FAIL(
      machine,
      five_axis("location = \"after\"\n[axis.Y]\nlocation = \"frame\"\n[axis.S]\nlocation = \"after\"\n"
                "[axis.A]\norder = [\"location\", \"motion\", \"static\", \"-location\"]\n"));
  EXPECT_EQ(body(machine, "X").order, after_order());
  EXPECT_EQ(body(machine, "X").location, "after");
  EXPECT_EQ(body(machine, "Y").order, frame_order());
  EXPECT_EQ(body(machine, "Z").order, line_order());
  EXPECT_EQ(body(machine, "Z").location, std::nullopt);
  EXPECT_EQ(body(machine, "S").order.size(), 4u);
  EXPECT_THAT(body(machine, "A").order,
              ElementsAre(Factor{FactorKind::location, false}, Factor{FactorKind::motion, false},
                          Factor{FactorKind::component, false}, Factor{FactorKind::location, true}));
}

TEST(ReadMachine, ErrorsFindTheirBodies) {
  READ_OR_FAIL(
      machine,
      five_axis(
          "correctable = false\n[errors]\nEXX = 1\nC0Y = 2\nTZZ = 3\nDAA = 4\nEXt = 5\nECw = 6\nEXS = 7\n"));
  std::vector<std::string> names;
  std::vector<int> bodies;
  for (const ErrorTerm& term : machine.errors) {
    names.push_back(to_string(term.name));
    bodies.push_back(term.body);
  }
  EXPECT_THAT(names, ElementsAre("EXX", "EC0Y", "TZZ", "DAA", "EXt", "ECw", "EXS"));
  EXPECT_THAT(bodies, ElementsAre(1, 2, 3, 4, kToolBody, kWorkpieceBody, 5));
  EXPECT_TRUE(body(machine, "X").errors_seen_at_tool);
  EXPECT_FALSE(body(machine, "C").errors_seen_at_tool);
  EXPECT_FALSE(body(machine, "X").correctable);
}

TEST(ReadMachine, ErrorsOfATableHaveASignOnceItIsStated) {
  const std::string head =
      "format = 1\n[machine]\nchain = \"w X Y b Z t\"\n[axis.X]\nerrors_seen = \"body\"\n";
  READ_OR_FAIL(machine, head);
  for (const Machine& same : {machine, as_controlled(machine), as_believed(machine)}) {
    EXPECT_FALSE(body(same, "X").errors_have_no_sign());
    EXPECT_TRUE(body(same, "Y").errors_have_no_sign());
    EXPECT_FALSE(body(same, "Z").errors_have_no_sign());  // it carries the tool
  }
}

TEST(ReadMachine, ErrorsOfOneTestAreNamed) {
  READ_OR_FAIL(
      machine,
      "format = 1\n[machine]\nchain = \"w b X Y Z t\"\n[errors]\n"
      "EXX = { sine = [1, 2, 0], of = \"t\", scope = \"test\" }\nEYY = { poly = [3], scope = \"machine\" }\n"
      "EZZ = [{ poly = [1] }, { poly = [2], scope = \"test\" }]\nEC0Y = 4\n");
  EXPECT_THAT(errors_of_one_test(machine), ElementsAre("EXX", "EZZ"));
  EXPECT_THAT(errors_of_one_test(as_controlled(machine)), ElementsAre("EXX", "EZZ"));
  EXPECT_THAT(errors_of_one_test(as_believed(machine)), ElementsAre());
  const auto refusal = refusal_of_one_test(machine);
  ASSERT_TRUE(refusal);
  EXPECT_EQ(refusal->code, "E-SCOPE");
  EXPECT_THAT(refusal->message, testing::StartsWith("EXX EZZ are true of one test only"));
  EXPECT_FALSE(refusal_of_one_test(as_believed(machine)));
}

TEST(ReadMachine, LocationErrorsAloneNeedNoErrorsSeen) {
  READ_OR_FAIL(machine, "format = 1\n[machine]\nchain = \"w X b Y t\"\n[errors]\nEC0X = 1\nEXY = 2\n");
  EXPECT_FALSE(body(machine, "X").errors_seen_at_tool);
}

TEST(ReadMachine, CalibrationIsKept) {
  READ_OR_FAIL(machine, five_axis("[calibration]\ndate = 2026-03-02\nmachine_id = 17\ntemperature = 20.5\n"
                                  "control_compensation = \"pitch on\"\nvalid_to = \"2028-02-29\"\n"));
  EXPECT_EQ(machine.calibration.date, "2026-03-02");
  EXPECT_EQ(machine.calibration.valid_to, "2028-02-29");
  EXPECT_EQ(machine.calibration.machine_id, "17");
  EXPECT_EQ(machine.calibration.control_compensation, "pitch on");
  EXPECT_DOUBLE_EQ(*machine.calibration.temperature, 20.5);
}

TEST(ReadMachine, AnErrorsFileReplacesTheErrors) {
  // Other units in both: positions are in m there and in inches here.
  READ_OR_FAIL(machine,
               five_axis("[units]\nlength = \"in\"\n[calibration]\nmachine_id = \"17\"\ndate = 2020-01-01\n"
                         "[errors]\nEXQ = { csv = \"missing\" }\n"),
               {},
               "format = 1\n[units]\nlength = \"m\"\nangle = \"rad\"\nerror_length = \"mm\"\n"
               "[calibration]\nmachine_id = \"17\"\n"
               "[errors]\nEYY = { poly = [1, 2, 3], reference = 0.1 }\nEYA = { sine = [1, 2, 0.5] }\n"
               "[uncertainty]\nEYY = 0.5\n");
  EXPECT_THAT(parsed_machine.diagnostics, ::testing::IsEmpty());
  ASSERT_EQ(machine.errors.size(), 2u);
  EXPECT_EQ(machine.calibration.date, "");
  EXPECT_DOUBLE_EQ(machine.errors[0].scale, 1);
  std::vector<double> variables(machine.variables.size(), 0.0);
  variables[static_cast<std::size_t>(machine.find_axis("Y"))] = 20;  // inches = 0.508 m
  variables[static_cast<std::size_t>(machine.find_axis("A"))] = 30;  // degrees
  const double v = 0.508 - 0.1;
  EXPECT_NEAR(machine.errors[0].function.value<double>(variables.data(), nullptr, nullptr),
              1 + 2 * v + 3 * v * v, 1e-14);
  EXPECT_NEAR(machine.errors[1].function.value<double>(variables.data(), nullptr, nullptr),
              std::sin(2 * 30 * deg + 0.5), 1e-14);
  ASSERT_TRUE(machine.errors[0].uncertainty);
  EXPECT_DOUBLE_EQ(machine.errors[0].uncertainty->value<double>(variables.data(), nullptr, nullptr), 0.5);
  EXPECT_THAT(machine.files, ElementsAre("folder/machine.toml", "folder/errors.toml"));
}

TEST(ReadMachine, Sha256IsThatOfTheBytes) {
  const std::string text = five_axis("");
  Sha256 sha;
  sha.add(text);
  EXPECT_EQ(read(text).value->sha256, sha.hex());
}

TEST(ReadMachine, FilesAreReadFromTheDisk) {
  const std::string folder = ::testing::TempDir() + "/abbe_read_machine";
  const auto save = [&](const std::string& name, const std::string& text) {
    auto file = SpoolFile::create(folder + name);
    ASSERT_TRUE(std::holds_alternative<SpoolFile>(file));
    auto& spool = std::get<SpoolFile>(file);
    ASSERT_TRUE(spool.write(text) && spool.publish());
  };
  save(".toml", five_axis("[errors]\nEYY = { csv = \"abbe_read_machine.csv\", column = \"EYY\" }\n"));
  save(".csv", "Y,EYY\n0,1\n100,2\n");
  const auto good = read_machine_file(folder + ".toml");
  ASSERT_TRUE(good.value) << all_of(good.diagnostics);
  EXPECT_EQ(good.value->files.size(), 2u);
  const auto missing = read_machine_file(folder + ".nowhere");
  ASSERT_EQ(missing.diagnostics.size(), 1u);
  EXPECT_EQ(missing.diagnostics[0].code, "E-FILE");
  EXPECT_FALSE(missing.value);
  EXPECT_EQ(read_machine_file(::testing::TempDir()).diagnostics[0].code, "E-FILE");
  EXPECT_EQ(read_machine_file(folder + ".toml", folder + ".nowhere").diagnostics[0].code, "E-FILE");
}

TEST(ReadMachine, EmptyAndHugeTextsAreRefused) {
  EXPECT_FALSE(read("").value);
  EXPECT_FALSE(read(std::string(1 << 25, 'x')).value);
  EXPECT_FALSE(read(std::string(100, '\0')).value);
  EXPECT_TRUE(read("format = 1\n[machine]\nchain = \"w b t\"\n").value);
}

TEST(ReadMachine, DiagnosticsAreBoundedAndInFileOrder) {
  std::string text = five_axis("[errors]\n");
  for (int i = 0; i < 5000; ++i) text += "Q" + std::to_string(i) + " = 1\n";
  const auto parsed = read(text);
  EXPECT_FALSE(parsed.value);
  EXPECT_LT(parsed.diagnostics.size(), 600u);
  for (std::size_t i = 1; i < parsed.diagnostics.size(); ++i) {
    EXPECT_LE(parsed.diagnostics[i - 1].place.line, parsed.diagnostics[i].place.line);
  }
}

}  // namespace
}  // namespace abbe
