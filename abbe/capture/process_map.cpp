#include "abbe/capture/process_map.h"

#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <tuple>

namespace abbe {
namespace {

using Quantity = Cia402Object::Quantity;

constexpr std::uint16_t kFirstProfile = 0x6000, kProfileStep = 0x800;
constexpr int kAxesPerDrive = 8;
constexpr std::array<std::uint16_t, 2> kServoOutputs = {0x6040, 0x607A};
constexpr std::array<std::uint16_t, 4> kServoInputs = {0x6041, 0x6064, 0x606C, 0x60F4};

constexpr PdoType kUnsigned = PdoType::unsigned_integer, kSigned = PdoType::signed_integer;

constexpr std::array kObjects = {
    Cia402Object{0x603F, "error_code", kUnsigned, 16, Quantity::none},
    Cia402Object{0x6040, "controlword", kUnsigned, 16, Quantity::none},
    Cia402Object{0x6041, "statusword", kUnsigned, 16, Quantity::none},
    Cia402Object{0x6060, "operation_mode", kSigned, 8, Quantity::none},
    Cia402Object{0x6061, "operation_mode_display", kSigned, 8, Quantity::none},
    Cia402Object{0x6062, "position_demand", kSigned, 32, Quantity::position},
    Cia402Object{0x6063, "position_actual_internal", kSigned, 32, Quantity::none},
    Cia402Object{0x6064, "position_actual", kSigned, 32, Quantity::position},
    Cia402Object{0x606B, "velocity_demand", kSigned, 32, Quantity::velocity},
    Cia402Object{0x606C, "velocity_actual", kSigned, 32, Quantity::velocity},
    Cia402Object{0x6071, "target_torque", kSigned, 16, Quantity::none},
    Cia402Object{0x6074, "torque_demand", kSigned, 16, Quantity::none},
    Cia402Object{0x6077, "torque_actual", kSigned, 16, Quantity::none},
    Cia402Object{0x6078, "current_actual", kSigned, 16, Quantity::none},
    Cia402Object{0x607A, "target_position", kSigned, 32, Quantity::position},
    Cia402Object{0x6081, "profile_velocity", kUnsigned, 32, Quantity::velocity},
    Cia402Object{0x60B0, "position_offset", kSigned, 32, Quantity::position},
    Cia402Object{0x60B1, "velocity_offset", kSigned, 32, Quantity::velocity},
    Cia402Object{0x60B2, "torque_offset", kSigned, 16, Quantity::none},
    Cia402Object{0x60B8, "touch_probe_function", kUnsigned, 16, Quantity::none},
    Cia402Object{0x60B9, "touch_probe_status", kUnsigned, 16, Quantity::none},
    Cia402Object{0x60BA, "touch_probe_1_rise", kSigned, 32, Quantity::position},
    Cia402Object{0x60BB, "touch_probe_1_fall", kSigned, 32, Quantity::position},
    Cia402Object{0x60F4, "following_error", kSigned, 32, Quantity::position},
    Cia402Object{0x60FA, "control_effort", kSigned, 32, Quantity::velocity},
    Cia402Object{0x60FC, "position_demand_internal", kSigned, 32, Quantity::none},
    Cia402Object{0x60FD, "digital_inputs", kUnsigned, 32, Quantity::none},
    Cia402Object{0x60FE, "digital_outputs", kUnsigned, 32, Quantity::none},
    Cia402Object{0x60FF, "target_velocity", kSigned, 32, Quantity::velocity},
};

auto order_of(const PdoObject& o) { return std::tuple(o.direction == PdoDirection::input, o.bit, o.station); }

void sort_by_address(std::vector<PdoObject>& objects) {
  std::stable_sort(objects.begin(), objects.end(),
                   [](const PdoObject& a, const PdoObject& b) { return order_of(a) < order_of(b); });
}

/// The object's own part of the name, and what it measures.
std::string name_of(const PdoObject& object, Quantity& quantity) {
  quantity = Quantity::none;
  const auto known = find_cia402(object.index);
  if (!known)
    return object.index == 0 ? "padding" : fmt::format("{:04X}:{:02}", object.index, object.subindex);
  quantity = known->quantity;
  const int axis = (object.index - kFirstProfile) / kProfileStep;
  std::string name(known->name);
  if (axis > 0) name += fmt::format("_{}", axis + 1);
  if (object.subindex != 0) name += fmt::format(":{:02}", object.subindex);
  return name;
}

/// Of another axis than the first of its drive.
bool of_second_axis(const PdoObject& object) {
  return find_cia402(object.index) && object.index >= kFirstProfile + kProfileStep;
}

void number_twins(std::vector<PdoObject>& objects) {
  std::map<std::string, int> seen;
  for (PdoObject& object : objects) {
    const int count = ++seen[object.name];
    if (count > 1) object.name += fmt::format(".{}", count);
  }
}

PdoObject servo_object(const ServoAxis& axis, std::uint16_t index, PdoDirection direction,
                       std::uint64_t& bit) {
  const Cia402Object known = *find_cia402(index);
  PdoObject object;
  object.station = axis.station;
  object.pdo = direction == PdoDirection::output ? 0x1600 : 0x1A00;
  object.index = index;
  object.direction = direction;
  object.type = known.type;
  object.bits = known.bits;
  object.bit = bit;
  bit += static_cast<std::uint64_t>(known.bits);
  return object;
}

}  // namespace

std::optional<Cia402Object> find_cia402(std::uint16_t index) {
  if (index < kFirstProfile || index >= kFirstProfile + kAxesPerDrive * kProfileStep) return std::nullopt;
  const auto of_first = static_cast<std::uint16_t>(kFirstProfile + (index - kFirstProfile) % kProfileStep);
  for (const Cia402Object& object : kObjects) {
    if (object.index == of_first) return object;
  }
  return std::nullopt;
}

std::optional<Cia402Object> find_cia402(std::string_view name) {
  for (const Cia402Object& object : kObjects) {
    if (object.name == name) return object;
  }
  return std::nullopt;
}

ProcessMap named(ProcessMap map, const std::vector<ServoAxis>& axes) {
  sort_by_address(map.objects);
  for (PdoObject& object : map.objects) {
    Quantity quantity{};
    const std::string own = name_of(object, quantity);
    const auto axis = std::find_if(axes.begin(), axes.end(), [&](const ServoAxis& a) {
      return a.station == object.station && !of_second_axis(object);
    });
    const std::string device = axis != axes.end() ? axis->name : fmt::format("{}", object.station);
    if (object.name.empty()) object.name = device + "." + own;
    if (axis == axes.end() || quantity == Quantity::none || !object.unit.empty()) continue;
    // value = counts / (counts per unit)
    object.scale = 1 / axis->counts_per_unit;
    object.unit = axis->unit + (quantity == Quantity::velocity ? "/s" : "");
  }
  number_twins(map.objects);
  return map;
}

ProcessMap servo_map(const std::vector<ServoAxis>& axes, std::uint32_t logical_address) {
  ProcessMap map;
  map.origin = "our own machine";
  std::uint64_t bit = std::uint64_t{logical_address} * 8;
  for (const ServoAxis& axis : axes) {
    for (const std::uint16_t index : kServoOutputs)
      map.objects.push_back(servo_object(axis, index, PdoDirection::output, bit));
  }
  for (const ServoAxis& axis : axes) {
    for (const std::uint16_t index : kServoInputs)
      map.objects.push_back(servo_object(axis, index, PdoDirection::input, bit));
  }
  return named(std::move(map), axes);
}

std::optional<std::string> map_mistake(const ProcessMap& map) {
  std::vector<PdoObject> objects = map.objects;
  sort_by_address(objects);
  const PdoObject* before = nullptr;
  for (const PdoObject& o : objects) {
    if (o.bits < 1 || o.bits > 64) return fmt::format("{} has {} bits; 1 to 64 can be read", o.name, o.bits);
    if (o.type == PdoType::real && o.bits != 32 && o.bits != 64)
      return fmt::format("{} is a real number of {} bits; 32 or 64 can be read", o.name, o.bits);
    if (o.type == PdoType::real && o.bit % 8 != 0)
      return fmt::format("{} is a real number that begins inside a byte", o.name);
    if (!std::isfinite(o.scale) || o.scale == 0) return fmt::format("{} has the scale {}", o.name, o.scale);
    if (o.bit + static_cast<std::uint64_t>(o.bits) > (std::uint64_t{1} << 35))
      return fmt::format("{} lies beyond the 32-bit logical addresses", o.name);
    if (before != nullptr && before->direction == o.direction &&
        before->bit + static_cast<std::uint64_t>(before->bits) > o.bit)
      return fmt::format("{} and {} overlap at logical address {:#x}", before->name, o.name, o.bit / 8);
    before = &o;
  }
  return std::nullopt;
}

}  // namespace abbe
