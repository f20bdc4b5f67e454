#include "abbe/cl/test_cl_files.h"

// A verifier is worth what it catches: each way to spoil an output, one by one.

namespace abbe::cl {
namespace {

const char* const kProgram =
    "PARTNO/A\nUNITS/MM\nLOADTL/3\nSPINDL/RPM,2000,CLW\nCOOLNT/ON\nMULTAX/ON\nRAPID\nGOTO/"
    "100,20,60,0.1,0.5,0.8602325\nFEDRAT/100,MMPM\nGOTO/100,20,0,0.1,0.5,0.8602325 $$ down\n"
    "GOTO/140,60,-5,0.2,0.5,0.8426150\nGOTO/150,60,-5\nGODLTA/5,0,0\nCIRCLE/145,60,-5,0,0,1\nGOTO/"
    "145,70,-5\nCYCLE/DRILL,FEDTO,8,RAPTO,2,MMPM,100\nGOTO/120,30,0\nCYCLE/OFF\nCOOLNT/OFF\nFINI\n";

class Mutation : public ::testing::Test {
 protected:
  Mutation() : plan_(plan_of(five_axes_with_errors())) {
    options_.start[1] = 30 * deg;
    const ClRun run = run_cl(plan_, kProgram, options_);
    EXPECT_TRUE(run.verify.agrees) << run.findings();
    good_ = run.output;
  }
  std::string verdict(const std::string& output) {
    const VerifyReport report = verify_texts(plan_, kProgram, output, options_);
    for (const Diagnostic& d : report.diagnostics) {
      if (d.severity == Severity::error) {
        EXPECT_FALSE(report.agrees);
        return d.code;
      }
    }
    return report.agrees ? "agrees" : "silent";
  }
  /// The output with the n-th occurrence of `from` changed.
  std::string changed(const std::string& from, const std::string& to, int n = 0) {
    std::size_t at = good_.find(from);
    for (; n > 0; --n) at = good_.find(from, at + 1);
    EXPECT_NE(at, std::string::npos) << from;
    std::string text = good_;
    return text.replace(at, from.size(), to);
  }
  std::string line_with(const std::string& word, int n = 0) {
    std::size_t at = good_.find(word);
    for (; n > 0; --n) at = good_.find(word, at + 1);
    const std::size_t begin = good_.rfind('\n', at) + 1;
    return good_.substr(begin, good_.find('\n', at) + 1 - begin);
  }

  Plan plan_;
  Options options_;
  std::string good_;
};

TEST_F(Mutation, TheTruthAgrees) { EXPECT_EQ(verdict(good_), "agrees"); }

TEST_F(Mutation, LostAndChangedRecordsAreSeen) {
  EXPECT_EQ(verdict(changed("COOLNT/ON\n", "")), "V-EVENT");
  EXPECT_EQ(verdict(changed("FEDRAT/100,MMPM", "FEDRAT/101,MMPM")), "V-EVENT");
  EXPECT_EQ(verdict(changed("SPINDL/RPM,2000,CLW", "SPINDL/RPM,2000,CCLW")), "V-EVENT");
  EXPECT_EQ(verdict(changed("LOADTL/3", "LOADTL/4")), "V-EVENT");
  EXPECT_EQ(verdict(changed("RAPID\n", "")), "V-ORDER");
  EXPECT_EQ(verdict(changed("CYCLE/OFF\n", "")), "V-EVENT");
  EXPECT_EQ(verdict(changed("CYCLE/DRILL,FEDTO,8", "CYCLE/DRILL,FEDTO,9")), "V-EVENT");
  EXPECT_EQ(verdict(changed("MULTAX/ON\n", "MULTAX/OFF\n")), "V-EVENT");
  EXPECT_EQ(verdict(changed(" $$ down", "")), "V-EVENT");
  EXPECT_EQ(verdict(changed("FINI\n", "")), "V-MISSING");
  EXPECT_EQ(verdict(good_ + "$$ more\n"), "V-EXTRA");
}

TEST_F(Mutation, LostAndDoubledMotionsAreSeen) {
  EXPECT_NE(verdict(changed(line_with("$$ down"), "")), "agrees");
  EXPECT_NE(verdict(changed(line_with("GODLTA"), "")), "agrees");
  EXPECT_NE(verdict(changed(line_with("GODLTA"), line_with("GODLTA") + line_with("GODLTA"))), "agrees");
  EXPECT_EQ(verdict(changed(line_with("CIRCLE"), "")), "V-ORDER");
}

TEST_F(Mutation, WrongNumbersAreSeen) {
  // 3 um anywhere, in every motion and every coordinate
  const std::string original = good_;
  int tried = 0;
  for (std::size_t at = original.find("GO"); at != std::string::npos; at = original.find("GO", at + 1)) {
    std::size_t begin = original.find('/', at) + 1;
    for (int k = 0; k < 3; ++k) {
      const std::size_t end = original.find_first_of(",\n $", begin);
      const double value = std::stod(original.substr(begin, end - begin));
      std::string text = original;
      text.replace(begin, end - begin, std::to_string(value + 0.003));
      EXPECT_NE(verdict(text), "agrees") << text.substr(at, 60);
      ++tried;
      begin = end + 1;
    }
  }
  EXPECT_GE(tried, 18);
}

TEST_F(Mutation, SwappedSignsAndLostNumbersAreSeen) {
  EXPECT_NE(verdict(changed("GOTO/1", "GOTO/-1")), "agrees");
  const std::string motion = line_with("$$ down");
  EXPECT_NE(verdict(changed(motion, motion.substr(0, motion.find(',')) +
                                        motion.substr(motion.find(',', motion.find(',') + 1)))),
            "agrees");
  EXPECT_EQ(verdict(changed(",0,0,1\n", ",0,0,-1\n")), "V-PATH");  // the circle goes round the other way
}

TEST_F(Mutation, ToolAxesThatGetWorseAreSeen) {
  // as far wrong as it was, on the other side
  const std::string motion = line_with("$$ down");
  const std::size_t j =
      motion.find(',', motion.find(',', motion.find(',', motion.find(',') + 1) + 1) + 1) + 1;
  const std::size_t end = motion.find(',', j);
  std::string worse = motion;
  worse.replace(j, end - j, std::to_string(1.0 - std::stod(motion.substr(j, end - j)) + 0.0002));
  EXPECT_NE(verdict(changed(motion, worse)), "agrees");
}

TEST_F(Mutation, AnUncompensatedOutputIsSeen) {
  const std::string code = verdict(kProgram);
  EXPECT_TRUE(code == "V-END" || code == "V-PATH") << code;
}

}  // namespace
}  // namespace abbe::cl
