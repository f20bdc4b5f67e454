// Any bytes as a program for the verifying reader: it must understand or refuse them, never give a number
// that is not finite, and a program compared with itself on a machine without errors must agree.
#include <unistd.h>

#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "abbe/machine/read_machine.h"
#include "abbe/machine/read_profile.h"
#include "abbe/verify/reader.h"
#include "abbe/verify/verify.h"

namespace {

using abbe::verifying::ListedMotion;

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "%s\n", what);
  std::abort();
}

const abbe::Plan& perfect_machine() {
  static const abbe::Plan plan = [] {
    const auto machine = abbe::read_machine(
        {"m.toml",
         "format = 1\n[machine]\nname = \"m\"\nchain = \"w b X Y Z t\"\n[axis.X]\n[axis.Y]\n[axis.Z]\n"},
        std::nullopt, [](const std::string&) { return std::nullopt; });
    require(machine.value.has_value(), "the machine of this target is wrong");
    return std::get<abbe::Plan>(abbe::make_plan(*machine.value, {}));
  }();
  return plan;
}

/// One file for the life of the process, rewritten for every input.
struct Scratch {
  std::string path =
      (std::filesystem::temp_directory_path() / ("abbe_fuzz_" + std::to_string(getpid()))).string();
  ~Scratch() { std::remove(path.c_str()); }
};

/// As this control reads it, with what a program may leave open stated.
void judge(const std::string& path, abbe::VerifyJob job, const char* dialect) {
  abbe::Profile profile = *abbe::embedded_profile(dialect);
  profile.numbers.integer_words = abbe::Profile::IntegerWords::units;
  profile.start.units = abbe::Profile::Units::metric;
  profile.start.distance = abbe::Profile::Distance::absolute;
  job.setup.profile = std::make_shared<const abbe::Profile>(std::move(profile));
  const auto refused = abbe::verifying::list_motions(path, "fuzz.ngc", job.setup, [](const ListedMotion& m) {
    require(m.end.allFinite() && m.centre.allFinite(), "a position is not finite");
  });
  for (const auto& d : refused)
    require(!d.code.empty() && !abbe::to_text(d).empty(), "a refusal says nothing");

  const abbe::VerifyReport report = abbe::verify_program(perfect_machine(), job);
  require(std::isfinite(report.after.max) && std::isfinite(report.before.max), "a deviation is not finite");
  for (const auto& d : report.diagnostics)
    if (d.code.rfind("E-", 0) != 0) {
      std::fprintf(stderr, "%s: %s\n", dialect, abbe::to_text(d).c_str());
      require(false, "a program disagrees with itself");
    }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const Scratch scratch;
  std::ofstream(scratch.path, std::ios::binary | std::ios::trunc)
      .write(reinterpret_cast<const char*>(data), static_cast<std::streamsize>(size));

  abbe::VerifyJob job;
  job.setup.work_offsets[0] = abbe::WorkOffset{};
  job.setup.work_offsets[1] = abbe::WorkOffset{{10, -20, 5}, 0.5};
  job.setup.tools[1].offset = {0, 0, 50};
  if (size > 0 && data[0] % 2 == 0) job.setup.start = {1.0, 2.0, 3.0};
  job.original_path = job.output_path = scratch.path;
  job.original_name = job.output_name = "fuzz.ngc";

  for (const char* dialect : {"linuxcnc", "fanuc", "siemens", "heidenhain"})
    judge(scratch.path, job, dialect);
  return 0;
}
