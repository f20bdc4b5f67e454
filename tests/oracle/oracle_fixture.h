#pragma once

// What the tests of this folder share: the oracle, its set-up, and the programs of must_accept.txt.

#include <gtest/gtest.h>

#include <iosfwd>
#include <string>
#include <vector>

#include "abbe/machine/control_setup.h"
#include "tests/oracle/interpreter.h"

namespace abbe::oracle {

inline constexpr const char* kNoOracle = "linuxcnc-uspace-dev or the oracle's source is absent";
[[nodiscard]] bool have_oracle();

/// A folder of its own for the running test.
[[nodiscard]] std::string scratch();

/// Runs a program with the tool table of this folder. nullopt: the oracle did not start.
[[nodiscard]] std::optional<Run> run(const std::string& program);

/// What the oracle assumes: at machine position 0, all work offsets 0, '/' lines run, tool.tbl.
[[nodiscard]] ControlSetup setup_of_oracle();

/// A line of must_accept.txt.
struct Listed {
  std::string root, path;
  long motions = 0;
  std::string needs;
  [[nodiscard]] std::string file() const;
  [[nodiscard]] bool has(const char* need) const { return needs.find(need) != std::string::npos; }
};
std::ostream& operator<<(std::ostream& out, const Listed& listed);

[[nodiscard]] std::vector<Listed> must_accept();
[[nodiscard]] std::string test_name(const testing::TestParamInfo<Listed>& info);

}  // namespace abbe::oracle
