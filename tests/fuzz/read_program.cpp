// Any bytes as a program through the rewriter, without errors: refused, or byte for byte the same.

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>
#include <variant>

#include "abbe/compensate/rewrite.h"
#include "abbe/machine/read_machine.h"

namespace {

constexpr const char* kMachine = "format = 1\n[machine]\nname = \"ideal\"\nchain = \"w X b Y Z t\"\n";

const abbe::Plan& ideal_plan() {
  static const abbe::Machine machine = *abbe::read_machine({"ideal.toml", kMachine}, std::nullopt, {}).value;
  static const abbe::Plan plan = std::get<abbe::Plan>(abbe::make_plan(machine, {}));
  return plan;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string stem = "/tmp/abbe_fuzz_" + std::to_string(::getpid());
  const std::string program(reinterpret_cast<const char*>(data), size);
  std::ofstream(stem + ".ngc", std::ios::binary) << program;
  abbe::RewriteJob job;
  job.path = job.name = stem + ".ngc";
  job.setup.work_offsets[0] = abbe::WorkOffset{};
  job.setup.block_delete = abbe::ControlSetup::BlockDelete::off;
  job.setup.start = {0.0, 0.0, 0.0};
  auto spool = abbe::SpoolFile::create(stem + ".out");
  auto& out = std::get<abbe::SpoolFile>(spool);
  const auto report = abbe::rewrite_program(ideal_plan(), job, out);
  if (report.complete) {
    if (!out.flush()) return 0;
    std::ifstream in(out.temporary_path(), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (text != program) std::abort();
  } else {
    bool said_why = false;
    for (const auto& d : report.diagnostics) said_why = said_why || d.severity == abbe::Severity::error;
    if (!said_why) std::abort();
  }
  std::remove((stem + ".ngc").c_str());
  return 0;
}
