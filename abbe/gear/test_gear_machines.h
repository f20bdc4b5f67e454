#pragma once

#include <string>

#include "abbe/gear/machine_cut.h"
#include "abbe/machine/read_machine.h"

// The machines of the seeds, as they cut gears. Test support.

namespace abbe::test {

/// Seed 002: the gear on the table C; the cutter on the carriage Z on the column X, its axis along y.
inline std::string gear_mill(const std::string& errors = "") {
  return "format = 1\n[machine]\nname = \"mill\"\nchain = \"w C b X Z S t\"\n"
         "[axis.C]\ndirection = [0, 0, 1]\nerrors_seen = \"body\"\n"
         "[axis.X]\nrange = [100, 900]\n[axis.Z]\nrange = [-200, 300]\n[tool]\naxis = [0, 1, 0]\n[errors]\n" +
         errors;
}

/// Seed 003: the gear on the table C on the slide X; Y and Z carry the head, which tilts about A.
inline std::string gear_grinder(const std::string& errors = "") {
  return "format = 1\n[machine]\nname = \"grinder\"\nchain = \"w C X b Y Z A t\"\n"
         "[axis.X]\ndirection = [1, 0, 0]\nrange = [-400, 400]\nerrors_seen = \"body\"\n"
         "[axis.C]\ndirection = [0, 0, 1]\nlocation = \"frame\"\nerrors_seen = \"body\"\n"
         "[axis.Y]\nlocation = \"frame\"\nrange = [-400, 400]\n[axis.Z]\nlocation = \"frame\"\nrange = "
         "[-400, 300]\n"
         "[axis.A]\norigin = [0, 0, 200]\nrange = [-120, 120]\n"
         "order = [\"location\", \"motion\", \"static\", \"-location\"]\n[tool]\norigin = [0, 0, "
         "0]\n[errors]\n" +
         errors;
}

inline Machine machine_of(const std::string& text) {
  return *read_machine({"machine.toml", text}, std::nullopt, nullptr).value;
}

inline GearJob job_of(const GearSpec& spec, double wheel_diameter = 300) {
  GearJob job;
  job.gear = std::get<Gear>(make_gear(spec));
  job.wheel.diameter = wheel_diameter;
  return job;
}

}  // namespace abbe::test
