#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "abbe/core/diagnostic.h"
#include "abbe/machine/control_setup.h"
#include "abbe/pipeline/compensate_program.h"
#include "command_line.h"

namespace abbe::app {

/// Options of CL data, as typed (docs/cl-data.md).
struct ClArguments {
  std::string tool_axis = "auto", circle_hand;
  std::vector<std::string> pass_records, near;
};

/// `near`: --near too; verbs that have one of their own leave it out.
void add_cl_options(Command& verb, ClArguments& arguments, bool near = true);

/// CL data by their dialect (cl, apt, clsf), or by the name of the file: .cls .clsf .apt .aptsource .ncl .cl
[[nodiscard]] bool is_cl_data(std::string_view dialect, std::string_view path);

[[nodiscard]] ClSetting read_cl_setting(const ClArguments& arguments, const std::string& units,
                                        const Machine& machine, const ControlSetup& setup,
                                        Diagnostics& findings);

}  // namespace abbe::app
