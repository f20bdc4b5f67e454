// Any bytes as CL data through both readers, on a machine without errors: refused, or byte for byte the same.

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <string>
#include <variant>

#include "abbe/cl/rewrite_cl.h"
#include "abbe/cl/verify_cl.h"
#include "abbe/machine/read_machine.h"

namespace {

constexpr const char* kMachine =
    "format = 1\n[machine]\nname = \"ideal\"\nchain = \"w C A Y b X Z t\"\n[axis.C]\ndirection = [0, 0, -1]\n"
    "[axis.A]\ndirection = [-1, 0, 0]\nrange = [-120, 120]\norigin = [0, 0, -60]\n[tool]\norigin = [0, 0, "
    "150]\nlength = 150\n";

const abbe::Plan& ideal_plan() {
  static const abbe::Machine machine = *abbe::read_machine({"ideal.toml", kMachine}, std::nullopt, {}).value;
  static const abbe::Plan plan = std::get<abbe::Plan>(abbe::make_plan(machine, {}));
  return plan;
}

bool says_why(const abbe::Diagnostics& diagnostics) { return abbe::has_errors(diagnostics); }

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string path = "/tmp/abbe_fuzz_cl_" + std::to_string(::getpid());
  const std::string text(reinterpret_cast<const char*>(data), size);
  std::ofstream(path, std::ios::binary) << text;
  abbe::ClJob job;
  job.path = job.name = path;
  auto spool = abbe::SpoolFile::create("-");
  auto& out = std::get<abbe::SpoolFile>(spool);
  const auto report = abbe::rewrite_cl(ideal_plan(), job, out);
  if (report.complete) {
    std::ifstream in(out.temporary_path(), std::ios::binary);
    const std::string written((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (written != text) std::abort();
    abbe::ClVerifyJob verify;
    verify.original_path = verify.original_name = path;
    verify.output_path = verify.output_name = out.temporary_path();
    const auto verified = abbe::verify_cl(ideal_plan(), verify);
    if (!verified.agrees && !says_why(verified.diagnostics)) std::abort();
  } else if (!says_why(report.diagnostics)) {
    std::abort();
  }
  std::remove(path.c_str());
  return 0;
}
