#include "abbe/cl/interpreter.h"

#include "abbe/cl/test_cl_files.h"

// What is not surely understood is refused, each with its place and remedy.

namespace abbe::cl {
namespace {

std::string refusal(const std::string& text, const Conventions& conventions = {}) {
  Options options;
  options.conventions = conventions;
  const ClRun run = run_cl(plan_of(kThreeAxes), text, options);
  for (const Diagnostic& d : run.rewrite.diagnostics) {
    EXPECT_GT(d.place.line, 0U) << d.code;
    EXPECT_FALSE(d.why.empty()) << d.code;
    EXPECT_FALSE(d.fix.empty()) << d.code;
  }
  return run.refusal();
}

/// In millimetres, somewhere.
std::string body(const std::string& records) {
  return refusal("UNITS/MM\nGOTO/10,0,0\n" + records + "FINI\n");
}

TEST(Interpreter, UnknownRecordsAreRefusedUnlessTheUserVouches) {
  EXPECT_EQ(body("VOODOO/1\n"), "E-RECORD");
  Conventions vouched;
  vouched.pass_words = {"VOODOO"};
  EXPECT_EQ(refusal("UNITS/MM\nGOTO/1,2,3\nVOODOO/1\nFINI\n", vouched), "");
  for (const char* record :
       {"NURBS/1,2", "HELIX/1", "THREAD/TURN", "COPY/1", "MACRO/A", "CALL/A", "IF/A", "JUMPTO/A",
        "ROTATE/TABLE,90", "ROTABL/90", "ROTHED/90", "SELCTL/1", "TLON,GOFWD/(CIRCLE/0,0,0,1)", "PREFUN/68",
        "OPSKIP/ON", "RETRCT", "P1 = POINT/1,2,3", "MODE/INCR"})
    EXPECT_EQ(body(std::string(record) + "\n"), "E-RECORD") << record;
}

TEST(Interpreter, RecordsThatMoveNothingPass) {
  for (const char* record :
       {"PPRINT hello", "SPINDL/RPM,2000,CLW", "COOLNT/ON", "DELAY/2", "OPSTOP", "STOP", "PAINT/COLOR,3",
        "AUXFUN/8", "PPFUN/1", "TOOLNO/1,MILL", "TPRINT/T1", "REMARK x", "END-OF-PATH", "CLEARP/XYPLAN,3"})
    EXPECT_EQ(body(std::string(record) + "\n"), "") << record;
}

TEST(Interpreter, TheUnitMustBeKnown) {
  EXPECT_EQ(refusal("GOTO/1,2,3\nFINI\n"), "E-UNITS");
  Conventions said;
  said.unit = 1;
  EXPECT_EQ(refusal("GOTO/1,2,3\nFINI\n", said), "");
  EXPECT_EQ(refusal("UNITS/FURLONGS\nGOTO/1,2,3\n"), "E-UNITS");
}

TEST(Interpreter, CoordinatesAreThreeOrSixNumbers) {
  EXPECT_EQ(body("GOTO/1,2\n"), "E-RECORD");
  EXPECT_EQ(body("GOTO/1,2,3,0\n"), "E-RECORD");
  EXPECT_EQ(body("GOTO/P1\n"), "E-RECORD");
  EXPECT_EQ(body("GOTO/1,2,3      00000010\n"), "E-RECORD");
  EXPECT_EQ(body("GODLTA/-1\n"), "E-RECORD");
  EXPECT_EQ(body("GOTO/1e9,0,0\n"), "E-RANGE");
  EXPECT_EQ(refusal("UNITS/MM\nGODLTA/1,2,3\n"), "E-POS");
}

TEST(Interpreter, ToolAxesMustBeSure) {
  EXPECT_EQ(body("GOTO/1,2,3,0,0,0.5\n"), "E-TLAXIS");
  EXPECT_EQ(body("MULTAX/OFF\nGOTO/1,2,3,0,0.6,0.8\n"), "E-TLAXIS");
  EXPECT_EQ(body("MULTAX/SOMETIMES\n"), "E-RECORD");
  EXPECT_EQ(body("TLAXIS/0,0,2\n"), "E-TLAXIS");
  // after a turned plane a record without an axis is not sure
  EXPECT_EQ(body("TRNTYP/WORLD,0,0,0\nCSYS/0,0,1,0,0,1,0,0,-1,0,0,0\nGOTO/1,2,3\n"), "E-TLAXIS");
}

TEST(Interpreter, FramesAreLiteralOrRefused) {
  EXPECT_EQ(body("TRANS/1,2,3\nGOTO/1,2,3\n"), "");
  EXPECT_EQ(body("TRANS/SCALE,2\n"), "E-FRAME");
  EXPECT_EQ(body("ORIGIN/1,2,3,XYROT,30\n"), "E-FRAME");
  EXPECT_EQ(body("MSYS/0,0,0,1,0,0,1,0,0\n"), "E-FRAME");
  EXPECT_EQ(body("TRNTYP/LOCAL,0,0,0\n"), "E-FRAME");
  EXPECT_EQ(body("CSYS/0,-1,0,0,1,0,0,0,0,0,1,0\n"), "E-FRAME");
  EXPECT_EQ(body("TRNTYP/WORLD,0,0,0\nCSYS/0,-1,0,5,1,0,0,0,0,0,1,0\nGOTO/1,2,3\n"), "");
  const std::string first = "$$*CATIA0\n$$ Program.1\n$$ 1. 0. 0. 0.\n$$ 0. 1. 0. 0.\n$$ 0. 0. 1. 0.\n",
                    second = "$$*CATIA0\n$$ 1. 0. 0. 0.\n$$ 0. 1. 0. 0.\n$$ 0. 0. 1. 5.\n";
  EXPECT_EQ(body(first + "GOTO/1,2,3\n" + first + "GOTO/1,2,4\n"), "");
  EXPECT_EQ(body(first + "GOTO/1,2,3\n" + second), "E-FRAME");
}

TEST(Interpreter, CirclesMustBeDefined) {
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1,10\nGOTO/0,10,0\n"), "");
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1,11\nGOTO/0,10,0\n"), "E-ARC");    // radius
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1,10\nGOTO/0,12,0\n"), "E-ARC");    // end
  EXPECT_EQ(body("CIRCLE/10,0,0,0,0,1\nGOTO/10,0,0\n"), "E-ARC");      // no radius
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,2\nGOTO/0,10,0\n"), "E-ARC");       // axis
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\nGOTO/10,0.0004,0\n"), "E-ARC");  // a whole turn, or nothing
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\nFEDRAT/5,MMPM\nGOTO/0,10,0\n"), "E-ARC");
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\nPPRINT x\nGOTO/0,10,0\n"), "");
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\n"), "E-ARC");
  EXPECT_EQ(body("RAPID\nCIRCLE/0,0,0,0,0,1\nGOTO/0,10,0\n"), "E-ARC");
  EXPECT_EQ(body("MOVARC/0,0,0,0,0,1,10,ANGLE,90\nGOTO/0,10,0\n"), "");
  EXPECT_EQ(body("MOVARC/0,0,0,0,0,1,10,ANGLE,80\nGOTO/0,10,0\n"), "E-ARC");
  EXPECT_EQ(body("CIRCLE/9,0,0,0,0,1,1,TIMES,2\nGOTO/10,0,-2\n"), "");
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1,10,TIMES,2\nGOTO/0,10,-2\n"), "E-ARC");
}

// Some writers put the points of a circle behind its record, others only its end.
TEST(Interpreter, ChordsOfACircleAreRefused) {
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\nGOTO/9.848078,1.736482,0\nGOTO/9.396926,3.420201,0\n"), "E-ARC");
  // a line across is a path of its own: the letter D
  EXPECT_EQ(body("CIRCLE/0,0,0,0,0,1\nGOTO/-10,0,0\nGOTO/10,0,0\n"), "");
}

TEST(Interpreter, TheSenseOfAnNxCircleMustBeStated) {
  const std::string text =
      "UNITS/MM\nTOOL PATH/A,TOOL,B\nGOTO/10,0,0\nCIRCLE/0,0,0,0,0,1,10,0.002,0.5,10,0\nGOTO/0,10,0\nFINI\n";
  EXPECT_EQ(refusal(text), "E-ARC");
  Conventions hand;
  hand.circle_hand = CircleHand::right;
  EXPECT_EQ(refusal(text, hand), "");
}

TEST(Interpreter, CyclesAndCutterCompensationAreFollowedOrRefused) {
  EXPECT_EQ(body("CYCLE/DRILL,5.0,MMPM,100,2.0\nGOTO/20,0,0\nCYCLE/OFF\n"), "");
  EXPECT_EQ(body("CYCLE/MILL,5.0\n"), "E-CYCLE");
  EXPECT_EQ(body("CUTCOM/LEFT\nGOTO/20,0,0\nCUTCOM/OFF\nGOTO/30,0,0\n"), "");
  EXPECT_EQ(body("CUTCOM/ADJUST,5\n"), "E-CUTCOM");
  EXPECT_EQ(body("FEDRAT/5,FURLONGS\n"), "E-FEED");
  EXPECT_EQ(body("LOADTL\n"), "E-TOOL");
  EXPECT_EQ(body("LOADTL/2,IN,5\nGOTO/1,1,1\n"), "");
}

}  // namespace
}  // namespace abbe::cl
