// `abbe capture`, `filter` and `simulate capture` as users run them: synthetic captures there and back, the
// members of the JSON answers, and a named error for every kind of wrong input.

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "run_program.h"

namespace abbe::cli {
namespace {

using nlohmann::json;
using ::testing::AllOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::Not;

constexpr int kRows = 200;
constexpr const char* kAxes = "X=1001:10000/mm,Y=1002:10000/mm";

class Captures : public ::testing::Test {
 protected:
  Folder folder_;

  std::string signals() {
    std::string text = "t_s,X.position_actual_mm,Y.position_actual_mm,X.target_position_mm\n";
    for (int i = 0; i < kRows; ++i) {
      const double angle = 0.05 * i;
      text += fmt::format("{},{:.4f},{:.4f},{:.4f}\n", 0.001 * i, 50 * std::cos(angle), 50 * std::sin(angle),
                          50 * std::cos(angle + 0.05));
    }
    return folder_.put("signals.csv", text);
  }

  std::string capture(const std::vector<std::string>& more = {}) {
    const std::string path = folder_ / "circle.pcap";
    std::vector<std::string> words = {"simulate", "capture", "--signals", signals(),
                                      "--axis",   kAxes,     "-o",        path};
    words.insert(words.end(), more.begin(), more.end());
    const ProgramRun run = run_abbe(words);
    EXPECT_EQ(run.exit, 0) << run.err;
    return path;
  }

  void cut(const std::string& path, std::size_t less) {
    std::filesystem::resize_file(path, std::filesystem::file_size(path) - less);
  }
};

TEST_F(Captures, ColumnsComeBackAsTheyWereWritten) {
  const std::string path = capture();
  const ProgramRun run = run_abbe({"capture", path, "--axis", kAxes, "--columns",
                                   "X.position_actual,Y.position_actual,X.target_position"});
  ASSERT_EQ(run.exit, 0) << run.err;
  std::ifstream written(folder_ / "signals.csv");
  std::istringstream read(run.out);
  std::string a, b;
  std::getline(written, a);
  std::getline(read, b);
  EXPECT_EQ(b, "t_s,X.position_actual_mm,Y.position_actual_mm,X.target_position_mm");
  int rows = 0;
  for (; std::getline(read, b) && std::getline(written, a); ++rows) {
    std::istringstream one(a), other(b);
    for (std::string x, y; std::getline(one, x, ',') && std::getline(other, y, ',');)
      ASSERT_NEAR(std::stod(x), std::stod(y), 1e-9) << rows;
  }
  EXPECT_EQ(rows, kRows);
}

TEST_F(Captures, JsonHasTheMembersOfTheContract) {
  const std::string path = capture();
  const json read = json::parse(run_abbe({"capture", path, "--axis", kAxes, "--json"}).out);
  EXPECT_EQ(read["verb"], "capture");
  EXPECT_EQ(read["time_base"], "esl");
  EXPECT_EQ(read["columns"][0]["name"], "t");
  EXPECT_EQ(read["rows"].size(), kRows);
  EXPECT_EQ(read["row_count"], kRows);
  EXPECT_EQ(read["gap_count"], 0);
  EXPECT_EQ(read["complete"], true);
  EXPECT_NEAR(read["cycle_s"].get<double>(), 0.001, 1e-9);
  const json summary = json::parse(run_abbe({"capture", path, "--summary", "--json", "--axis", kAxes}).out);
  EXPECT_EQ(summary["bad"], 0);
  EXPECT_EQ(summary["paired"], summary["returned"]);
  EXPECT_EQ(summary["process_data"][0]["expected_working_counter"], 6);
  EXPECT_EQ(summary["signals"].size(), 12U);
  EXPECT_THAT(run_abbe({"capture", path, "--summary"}).out,
              AllOf(HasSubstr("best clock: esl"), HasSubstr("signals (start-up traffic):")));
}

TEST_F(Captures, BinaryColumnsAreThoseOfCsv) {
  const std::string path = capture(), out = folder_ / "columns.abbecol";
  ASSERT_EQ(run_abbe({"capture", path, "--axis", kAxes, "--columns", "Y.position_actual", "-o", out}).exit,
            0);
  std::ifstream file(out, std::ios::binary);
  std::string magic(8, ' ');
  file.read(magic.data(), 8);
  EXPECT_EQ(magic, "ABBECOL1");
  std::uint64_t length = 0, rows = 0;
  file.read(reinterpret_cast<char*>(&length), 8);
  std::string header(length, ' ');
  file.read(header.data(), static_cast<std::streamsize>(length));
  EXPECT_EQ(json::parse(header)["columns"][1]["unit"], "mm");
  file.read(reinterpret_cast<char*>(&rows), 8);
  ASSERT_EQ(rows, static_cast<std::uint64_t>(kRows));
  std::vector<double> numbers(2 * rows);
  file.read(reinterpret_cast<char*>(numbers.data()), static_cast<std::streamsize>(16 * rows));
  EXPECT_NEAR(numbers[10], 0.010, 1e-9);
  EXPECT_NEAR(numbers[rows + 10], 50 * std::sin(0.5), 5e-5);
  file.read(reinterpret_cast<char*>(&rows), 8);
  EXPECT_EQ(rows, 0U);
}

TEST_F(Captures, DamagedFilesAreNamedAndUsedAsFarAsTheyGo) {
  const std::string path = capture();
  cut(path, 50);
  const ProgramRun run = run_abbe({"capture", path, "--axis", kAxes, "--json"});
  EXPECT_EQ(run.exit, 0);
  EXPECT_THAT(run.err, HasSubstr("W-CAPTURE-END"));
  const json read = json::parse(run.out);
  EXPECT_EQ(read["row_count"], kRows - 1);
  EXPECT_EQ(read["complete"], false);
  EXPECT_EQ(run_abbe({"capture", path, "--axis", kAxes, "--strict"}).exit, 4);
}

TEST_F(Captures, WrongInputIsNamed) {
  const auto error = [&](std::vector<std::string> words, int exit) {
    const ProgramRun run = run_abbe(words);
    EXPECT_EQ(run.exit, exit) << run.err;
    return run.err;
  };
  const std::string path = capture(), silent = folder_ / "silent.pcap";
  EXPECT_THAT(error({"capture", folder_ / "none.pcap"}, 2), HasSubstr("E-FILE"));
  EXPECT_THAT(error({"capture", folder_.put("text.pcap", "no capture at all, just text")}, 2),
              HasSubstr("E-FILE"));
  EXPECT_THAT(error({"capture", path, "--columns", "X.position_actul", "--axis", kAxes}, 2),
              HasSubstr("did you mean X.position_actual"));
  EXPECT_THAT(error({"capture", path, "--axis", "X=1001"}, 2), HasSubstr("E-OPTION"));
  EXPECT_THAT(error({"capture", path, "--axis", "X=1001:10000/mm,Y=1001:10000/mm"}, 2),
              HasSubstr("same drive"));
  EXPECT_THAT(error({"capture", path, "--map", folder_.put("m.toml", "format = 3\n")}, 2),
              HasSubstr("E-FORMAT"));
  EXPECT_THAT(error({"capture", path, "--eni", folder_.put("m.xml", "<a")}, 2), HasSubstr("E-ENI"));
  EXPECT_THAT(error({"capture", path, "-o", path}, 2), HasSubstr("the capture itself"));
  for (const char* whole : {"--summary", "--datagrams"}) {
    EXPECT_THAT(error({"capture", path, whole, "-o", silent}, 2), HasSubstr("excludes"));
    EXPECT_THAT(error({"capture", path, whole, "--columns", "X.position_actual"}, 2), HasSubstr("excludes"));
  }
  EXPECT_THAT(error({"capture", path, "--datagrams", "--json"}, 2), HasSubstr("excludes"));
  const std::string elsewhere = folder_.put("e.toml",
                                            "format = 1\n[[object]]\nstation = 1\nindex = 0x6064\ndirection "
                                            "= \"input\"\ntype = \"int32\"\naddress = 0\n");
  EXPECT_THAT(error({"capture", path, "--map", elsewhere}, 2), HasSubstr("E-CAPTURE-MAP"));
  std::filesystem::copy_file(capture({"--no-startup", "--esl", "none", "--no-clock"}), silent);
  EXPECT_THAT(error({"capture", silent}, 2), HasSubstr("E-CAPTURE-MAP"));
  EXPECT_THAT(error({"capture", silent, "--axis", kAxes, "--time", "esl", "--map", elsewhere}, 2),
              HasSubstr("E-CAPTURE-TIME"));
  std::filesystem::resize_file(silent, 24);
  EXPECT_THAT(error({"capture", silent}, 2), HasSubstr("E-CAPTURE-EMPTY"));
}

TEST_F(Captures, AnAxisWithoutADriveIsNamed) {
  const ProgramRun run = run_abbe({"capture", capture(), "--axis", "X=1001:10000/mm,Y=1020:10000/mm"});
  EXPECT_EQ(run.exit, 0);
  EXPECT_THAT(run.err, HasSubstr("axis Y: no signal of a drive 1020"));
  EXPECT_THAT(run.err, HasSubstr("1001, 1002"));
  EXPECT_THAT(run.err, Not(HasSubstr("axis X:")));
  EXPECT_THAT(run.out, HasSubstr("X.position_actual_mm"));
  EXPECT_THAT(run.out, HasSubstr(",1002.position_actual,"));
}

// A link type of its own in the header: captures of "any" interface, of USB, of loopback.
TEST_F(Captures, OtherLinkTypesAreRefused) {
  const std::string path = capture();
  std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(20);
  file.put(113);
  file.close();
  const ProgramRun run = run_abbe({"capture", path});
  EXPECT_EQ(run.exit, 2);
  EXPECT_THAT(run.err, HasSubstr("link type LINUX_SLL"));
}

TEST_F(Captures, UnfittingSignalsAreNotWritten) {
  const std::string out = folder_ / "out.pcap";
  const auto error = [&](const std::string& text) {
    const ProgramRun run = run_abbe(
        {"simulate", "capture", "--signals", folder_.put("s.csv", text), "--axis", kAxes, "-o", out});
    EXPECT_EQ(run.exit, 2);
    EXPECT_FALSE(std::filesystem::exists(out));
    return run.err;
  };
  EXPECT_THAT(error("X.position_actual_mm\n1\n1e9\n"), HasSubstr("E-SIMULATE"));
  EXPECT_THAT(error("X.posit_actual_mm\n1\n"), HasSubstr("E-SIMULATE"));
  EXPECT_THAT(error("X.position_actual_mm\nnan\n"), HasSubstr("E-CELL"));
  EXPECT_THAT(error("t_s\n1\n"), HasSubstr("E-SIMULATE"));
}

TEST_F(Captures, FilterStepsFollowEachOther) {
  const ProgramRun run = run_abbe({"filter", signals(), "--columns", "X.position_actual_mm", "--step",
                                   "smooth", "--step", "derivative", "--step", "derivative"});
  ASSERT_EQ(run.exit, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("t_s,X.position_actual_mm_per_s2\n"));
  const json wavelet =
      json::parse(run_abbe({"filter", signals(), "--step", "wavelet=sym5,levels=3,soft", "--json"}).out);
  EXPECT_EQ(wavelet["figures"].size(), 3U);
  EXPECT_EQ(wavelet["figures"][0]["sigma"].size(), 3U);
  EXPECT_GT(wavelet["figures"][0]["r2"], 0.999);
  const json sine = json::parse(run_abbe({"filter", signals(), "--sine", "--json"}).out);
  EXPECT_NEAR(sine["sines"][1]["amplitude"].get<double>(), 50, 1e-3);
  EXPECT_NEAR(sine["sines"][1]["omega_rad_per_s"].get<double>(), 50, 1e-3);
  const json delay = json::parse(
      run_abbe({"filter", signals(), "--delay", "X.target_position_mm,X.position_actual_mm", "--json"}).out);
  EXPECT_NEAR(delay["delay_s"].get<double>(), 0.001, 2e-5);
}

TEST_F(Captures, RowsAtAnglesAreThoseOfTheCircle) {
  const std::string angles = folder_.put("angles.csv", "angle_deg,radius_um\n10,0\n45,1\n370,2\n");
  const ProgramRun run = run_abbe(
      {"filter", signals(), "--circle", "X.position_actual_mm,Y.position_actual_mm", "--angles", angles});
  ASSERT_EQ(run.exit, 0) << run.err;
  std::istringstream text(run.out);
  std::string line;
  std::getline(text, line);
  EXPECT_EQ(line, "t_s,angle_deg,X.position_actual_mm,Y.position_actual_mm,X.target_position_mm");
  std::getline(text, line);
  // 10 degrees are passed at 0.17453 / 0.05 samples of 1 ms.
  EXPECT_NEAR(std::stod(line), 0.0034907, 1e-6);
}

TEST_F(Captures, WrongRecordsAreNamed) {
  const auto error = [&](std::vector<std::string> words) {
    words.insert(words.begin(), "filter");
    const ProgramRun run = run_abbe(words);
    EXPECT_EQ(run.exit, 2) << run.err;
    return run.err;
  };
  const std::string uneven = folder_.put("uneven.csv", "t_s,x\n0,1\n1,2\n3,1\n4,5\n5,6\n");
  const std::string flat = folder_.put("flat.csv", "t_s,x\n0,1\n1,1\n2,1\n3,1\n4,1\n");
  EXPECT_THAT(error({uneven, "--step", "smooth"}), HasSubstr("not equally spaced"));
  EXPECT_THAT(error({flat, "--sine"}), HasSubstr("does not vary"));
  EXPECT_THAT(error({flat, "--step", "savitzky-golay=4,2"}), HasSubstr("option"));
  EXPECT_THAT(error({flat, "--step", "savitzky-golay=7,2"}), HasSubstr("too short"));
  EXPECT_THAT(error({flat, "--step", "wavelet=haarr"}), HasSubstr("'haarr' is not understood"));
  EXPECT_THAT(error({flat, "--step", "wavelet=db3,levels=0"}), HasSubstr("option"));
  EXPECT_THAT(error({flat, "--step", "median"}), HasSubstr("E-OPTION"));
  EXPECT_THAT(error({flat, "--sine", "--delay", "x,x"}), HasSubstr("excludes"));
  EXPECT_THAT(error({flat, "--circle", "x,x", "--angles", flat, "--sine"}), HasSubstr("excludes"));
  EXPECT_THAT(error({flat, "--delay", "x,x", "-o", folder_ / "delay.csv"}), HasSubstr("excludes"));
  EXPECT_THAT(error({flat, "--sine", "--format", "json"}), HasSubstr("excludes"));
  EXPECT_NE(error({flat, "--delay", "x,x", "--delay", "x,x"}), "");
  EXPECT_THAT(error({flat, "--columns", "y"}), HasSubstr("no column 'y'"));
  EXPECT_THAT(error({folder_.put("n.csv", "x\n1\n2\n")}), HasSubstr("no column t_s"));
  EXPECT_THAT(error({folder_.put("c.csv", "t_s,x\n0,inf\n")}), HasSubstr("E-CELL"));
  EXPECT_EQ(run_abbe({"filter", uneven, "--step", "resample=0.5", "--step", "smooth"}).exit, 0);
}

}  // namespace
}  // namespace abbe::cli
