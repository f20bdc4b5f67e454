#include "tests/oracle/oracle_fixture.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <ostream>
#include <sstream>

namespace abbe::oracle {
namespace {

const std::string kHere = std::string(ABBE_SOURCE_DIR) + "/tests/oracle";
const std::string kToolTable = kHere + "/tool.tbl";

}  // namespace

bool have_oracle() { return !std::string(ABBE_ORACLE).empty() && std::filesystem::exists(ABBE_ORACLE); }

std::string scratch() {
  const auto* test = testing::UnitTest::GetInstance()->current_test_info();
  std::string name = std::string(test->test_suite_name()) + "." + test->name();
  std::replace(name.begin(), name.end(), '/', '_');
  std::string folder = std::string(ABBE_SCRATCH_DIR) + "/" + name;
  std::filesystem::create_directories(folder);
  return folder;
}

std::optional<Run> run(const std::string& program) {
  return run(ABBE_ORACLE, kToolTable, std::filesystem::canonical(program).string(), scratch());
}

ControlSetup setup_of_oracle() {
  ControlSetup setup;
  setup.work_offsets.fill(WorkOffset{});
  setup.start = {0.0, 0.0, 0.0};
  setup.block_delete = ControlSetup::BlockDelete::off;
  setup.tool_change_keeps_place = true;  // the interpreter alone has no place for changing tools
  std::ifstream file(kToolTable);
  std::ostringstream text;
  text << file.rdbuf();
  auto tools = read_tool_table(kToolTable, text.str());
  if (tools.value) setup.tools = *tools.value;
  return setup;
}

std::string Listed::file() const {
  if (root == "data") return std::string(ABBE_SOURCE_DIR) + "/../shared/data/gcode/" + path;
  if (root == "ncfiles") return "/usr/share/linuxcnc/ncfiles/" + path;
  return "/usr/share/doc/linuxcnc/examples/sample-configs/" + path;
}

std::ostream& operator<<(std::ostream& out, const Listed& listed) {
  return out << listed.root << "/" << listed.path;
}

std::vector<Listed> must_accept() {
  std::vector<Listed> list;
  std::ifstream file(kHere + "/must_accept.txt");
  for (std::string text; std::getline(file, text);) {
    if (text.empty() || text[0] == '#') continue;
    std::istringstream line(text);
    std::string name;
    Listed listed;
    line >> name >> listed.motions;
    std::getline(line, listed.needs);
    const auto slash = name.find('/');
    listed.root = name.substr(0, slash);
    listed.path = name.substr(slash + 1);
    list.push_back(listed);
  }
  return list;
}

std::string test_name(const testing::TestParamInfo<Listed>& info) {
  std::string name = info.param.root + "_" + info.param.path;
  std::replace_if(
      name.begin(), name.end(), [](char c) { return std::isalnum(static_cast<unsigned char>(c)) == 0; }, '_');
  return name;
}

}  // namespace abbe::oracle
