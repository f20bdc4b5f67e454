#include "abbe/rt/abbe_rt.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <exception>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "abbe/chain/correct.h"
#include "abbe/chain/plan_impl.h"
#include "abbe/core/number.h"
#include "abbe/kernel/flat_plan.h"
#include "abbe/kernel/kernel.h"
#include "abbe/machine/read_machine.h"

struct abbe_rt_model {
  abbe::Machine machine;
  std::shared_ptr<const abbe::kernel::FlatPlan> flat;
  const abbe::kernel::Kernel* kernel = nullptr;
  abbe::Vec3 tool_origin = abbe::Vec3::Zero(), tool_axis = abbe::Vec3::UnitZ();
  abbe::AxisSet free = 0;
  std::array<double, abbe::kMaxAxes> lo{}, hi{};
  double max_correction = 0;  ///< mm
};

namespace {

using namespace abbe;

void tell(char* message, std::size_t size, std::string_view text) {
  if (message == nullptr || size == 0) return;
  const std::size_t n = std::min(size - 1, text.size());
  std::memcpy(message, text.data(), n);
  message[n] = '\0';
}

/// "T1=23.4,t=0"; nullopt with the part that is not understood.
std::optional<Environment> environment_of(std::string_view text, std::string& bad) {
  Environment environment;
  while (!text.empty()) {
    const std::string_view part = text.substr(0, text.find(','));
    text.remove_prefix(std::min(text.size(), part.size() + 1));
    const std::size_t equals = part.find('=');
    const auto value = equals == std::string_view::npos ? std::nullopt : read_number(part.substr(equals + 1));
    if (!value || equals == 0) {
      bad = std::string(part);
      return std::nullopt;
    }
    environment[std::string(part.substr(0, equals))] = *value;
  }
  return environment;
}

/// The model, or why there is none.
std::unique_ptr<abbe_rt_model> load(const char* machine_file, const char* sensors, double max_correction,
                                    std::string& why) {
  constexpr double kUsualLimit = 0.5;  // mm, as for programs
  if (!(max_correction >= 0 && max_correction - max_correction == 0)) {
    why = "the largest correction is not a length";
    return nullptr;
  }
  if (machine_file == nullptr) {
    why = "no machine file is named";
    return nullptr;
  }
  const auto environment = environment_of(sensors == nullptr ? "" : sensors, why);
  if (!environment) {
    why = "sensors: \"" + why + "\" is not NAME=NUMBER";
    return nullptr;
  }
  Parsed<Machine> parsed = read_machine_file(machine_file);
  if (!parsed.value) {
    for (const Diagnostic& diagnostic : parsed.diagnostics) why += to_text(diagnostic);
    return nullptr;
  }
  auto model = std::make_unique<abbe_rt_model>();
  model->machine = as_controlled(*parsed.value);
  if (const auto names = errors_of_one_test(model->machine); !names.empty()) {
    why = names.front() + " is true of one test only (scope = \"test\"): it may not move the machine";
    return nullptr;
  }
  const auto plan = make_plan(model->machine, *environment);
  if (const auto* missing = std::get_if<MissingSensors>(&plan)) {
    why = "errors depend on sensors without a value:";
    for (const std::string& name : missing->names) why += " " + name;
    return nullptr;
  }
  const Plan::Impl& impl = std::get<Plan>(plan).impl();
  model->flat = kernel::FlatPlan::make(std::get<Plan>(plan));
  if (model->flat == nullptr) {
    why =
        "some error depends on several axes or on a velocity, or is frozen outside its domain: the real-time "
        "core "
        "knows functions of one position only";
    return nullptr;
  }
  model->kernel = &kernel::best();
  model->free = free_axes(model->machine, 0).value_or(0);
  if (!kernel::corrects(model->flat->view(), model->free)) {
    why = "the machine needs three linear and at most two rotary axes that may be corrected";
    return nullptr;
  }
  model->max_correction = max_correction > 0 ? max_correction : kUsualLimit;
  model->tool_origin = model->machine.tool.origin;
  model->tool_axis = model->machine.tool.axis;
  model->lo = impl.lo;
  model->hi = impl.hi;
  return model;
}

[[nodiscard]] bool is_number(double x) { return x - x == 0; }

}  // namespace

extern "C" {

int abbe_rt_version(void) { return ABBE_RT_VERSION; }

abbe_rt_model* abbe_rt_load(const char* machine_file, const char* sensors, double max_correction,
                            char* message, std::size_t size) {
  tell(message, size, "");
  try {
    std::string why;
    auto model = load(machine_file, sensors, max_correction, why);
    if (model == nullptr) tell(message, size, why);
    return model.release();
  } catch (const std::exception& e) {  // out of memory
    tell(message, size, e.what());
    return nullptr;
  }
}

void abbe_rt_free(abbe_rt_model* model) { delete model; }

int abbe_rt_axis_count(const abbe_rt_model* model) { return model->flat->view().axis_count; }

const char* abbe_rt_axis_name(const abbe_rt_model* model, int axis) {
  if (axis < 0 || axis >= abbe_rt_axis_count(model)) return nullptr;
  return model->machine.axis(axis).name.c_str();
}

int abbe_rt_is_rotary(const abbe_rt_model* model, int axis) {
  return axis >= 0 && axis < abbe_rt_axis_count(model) && (model->flat->view().rotary >> axis & 1) != 0 ? 1
                                                                                                        : 0;
}

double abbe_rt_gauge_length(const abbe_rt_model* model) { return model->machine.tool.length; }

abbe_rt_status abbe_rt_correct(const abbe_rt_model* model, const double* commanded, double gauge_length,
                               double* corrected, double* last_step) {
  const abbe::kernel::FlatView& view = model->flat->view();
  const auto axes = static_cast<std::size_t>(view.axis_count);
  abbe::kernel::Setting setting;
  // tip = origin - length * axis
  for (int k = 0; k < 3; ++k) {
    setting.tip[k] = model->tool_origin[k] - gauge_length * model->tool_axis[k];
    setting.axis[k] = model->tool_axis[k];
  }
  setting.free = model->free;

  std::array<double, abbe::kMaxAxes> from{}, to{};
  std::array<const double*, abbe::kMaxAxes> in{};
  std::array<double*, abbe::kMaxAxes> out{};
  bool numbers = is_number(gauge_length);
  for (std::size_t i = 0; i < axes; ++i) {
    from[i] = commanded[i];
    numbers = numbers && is_number(from[i]);
    in[i] = &from[i];
    out[i] = &to[i];
  }
  double last = 0;
  unsigned char lane = abbe::kernel::Lane::ordinary;
  if (!numbers) return ABBE_RT_INVALID;
  model->kernel->correct_poses(view, setting, in.data(), 1, out.data(), &last, &lane);
  bool usual = (lane & abbe::kernel::Lane::unusual) == 0 && is_number(last);
  // A command outside the travels may stay there, not go farther.
  for (std::size_t i = 0; usual && i < axes; ++i) {
    const bool rotary = (view.rotary >> i & 1) != 0;
    usual = to[i] >= std::min(model->lo[i], from[i]) && to[i] <= std::max(model->hi[i], from[i]) &&
            (rotary || std::abs(to[i] - from[i]) <= model->max_correction);
  }
  for (std::size_t i = 0; i < axes; ++i) corrected[i] = usual ? to[i] : from[i];
  if (last_step != nullptr) *last_step = usual ? last : 0;
  if (!usual) return ABBE_RT_HELD;
  return (lane & abbe::kernel::Lane::outside) != 0 ? ABBE_RT_OUTSIDE : ABBE_RT_OK;
}

}  // extern "C"
