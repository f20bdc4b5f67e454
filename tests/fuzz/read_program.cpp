// Any bytes as a program of each control through the rewriter, without errors: refused, or byte for byte the
// same.

#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <utility>
#include <variant>

#include "abbe/compensate/rewrite.h"
#include "abbe/machine/read_machine.h"
#include "abbe/machine/read_profile.h"

namespace {

constexpr const char* kMachine = "format = 1\n[machine]\nname = \"ideal\"\nchain = \"w X b Y Z t\"\n";

const abbe::Plan& ideal_plan() {
  static const abbe::Machine machine = *abbe::read_machine({"ideal.toml", kMachine}, std::nullopt, {}).value;
  static const abbe::Plan plan = std::get<abbe::Plan>(abbe::make_plan(machine, {}));
  return plan;
}

/// Aborts if the program comes out otherwise than it went in, or is refused without a reason.
void rewrite_for(const std::string& stem, const std::string& program,
                 std::shared_ptr<const abbe::Profile> profile) {
  abbe::RewriteJob job;
  job.setup.profile = std::move(profile);
  job.path = job.name = stem + ".ngc";
  job.setup.work_offsets[0] = abbe::WorkOffset{};
  job.setup.block_delete = abbe::ControlSetup::BlockDelete::off;
  job.setup.start = {0.0, 0.0, 0.0};
  auto spool = abbe::SpoolFile::create(stem + ".out");
  auto& out = std::get<abbe::SpoolFile>(spool);
  const auto report = abbe::rewrite_program(ideal_plan(), job, out);
  if (report.complete) {
    if (!out.flush()) return;
    std::ifstream in(out.temporary_path(), std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
    if (text != program) std::abort();
  } else {
    bool said_why = false;
    for (const auto& d : report.diagnostics) said_why = said_why || d.severity == abbe::Severity::error;
    if (!said_why) std::abort();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const std::string stem = "/tmp/abbe_fuzz_" + std::to_string(::getpid());
  const std::string program(reinterpret_cast<const char*>(data), size);
  std::ofstream(stem + ".ngc", std::ios::binary) << program;
  for (const abbe::EmbeddedProfile& embedded : abbe::embedded_profiles()) {
    const auto profile = abbe::embedded_profile(embedded.name);
    rewrite_for(stem, program, profile);
    if (profile->numbers.integer_words == abbe::Profile::IntegerWords::units) continue;
    abbe::Profile stated = *profile;
    stated.numbers.integer_words = abbe::Profile::IntegerWords::increments;
    stated.start.units = abbe::Profile::Units::metric;
    stated.start.distance = abbe::Profile::Distance::absolute;
    rewrite_for(stem, program, std::make_shared<const abbe::Profile>(std::move(stated)));
  }
  std::remove((stem + ".ngc").c_str());
  return 0;
}
