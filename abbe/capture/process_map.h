#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace abbe {

/// Which way a mapped object goes: `input` from the slave to the master (TxPDO), `output` to the slave
/// (RxPDO).
enum class PdoDirection { input, output };
enum class PdoType { unsigned_integer, signed_integer, real };

/// One object of the cyclic process data and where its bits are.
///
///   value = raw * scale
struct PdoObject {
  std::string name;           ///< of its column: "X.position_actual"
  std::uint16_t station = 0;  ///< configured address of the slave
  std::uint16_t pdo = 0;      ///< 0x1600.. or 0x1A00.., 0 = not known
  std::uint16_t index = 0;    ///< in the object dictionary, 0 = padding
  std::uint8_t subindex = 0;
  PdoDirection direction = PdoDirection::input;
  PdoType type = PdoType::signed_integer;
  int bits = 32;          ///< 1 to 64; of a real 32 or 64
  std::uint64_t bit = 0;  ///< 8 * logical address + the bit in that byte, least significant first
  double scale = 1;       ///< unit per count, finite, not 0
  std::string unit;       ///< "mm", "deg", "mm/s", "deg/s"; empty: raw counts
};

/// Where the signals are in the process image. Objects of one direction do not overlap.
struct ProcessMap {
  std::vector<PdoObject> objects;  ///< by rising address, outputs before inputs
  std::string origin;              ///< for people: "ENI machine.xml", "learned from start-up traffic"
};

/// An object of the CiA 402 drive profile, or of none.
struct Cia402Object {
  std::uint16_t index;
  std::string_view name;  ///< "position_actual"
  PdoType type;
  int bits;
  enum class Quantity { none, position, velocity } quantity;
};
/// The object of that index; axes 2 to 8 of one drive (0x6800 steps: 0x6864 is 0x6064 of axis 2) included.
/// nullopt for objects of no profile.
/// source   IEC 61800-7-201, ETG.6010
[[nodiscard]] std::optional<Cia402Object> find_cia402(std::uint16_t index);
[[nodiscard]] std::optional<Cia402Object> find_cia402(std::string_view name);

/// A machine axis and the drive that moves it: gives columns their names and units.
struct ServoAxis {
  std::string name;            ///< "X"
  std::uint16_t station = 0;   ///< configured address of the drive
  double counts_per_unit = 0;  ///< encoder counts per mm or deg, not 0; negative if it counts the other way
  std::string unit = "mm";     ///< "mm" or "deg"
};

/// Names objects of known drives "X.position_actual" and scales positions and velocities (counts/s) to the
/// axis' unit; objects of other slaves become "1001.digital_inputs", unknown ones "1001.2065:00". So do those
/// of the other axes of a drive that moves several ("1001.position_actual_2"): they have counts of their own,
/// which a ServoAxis does not state. A name that would appear twice gets ".2", ".3" ...
[[nodiscard]] ProcessMap named(ProcessMap map, const std::vector<ServoAxis>& axes);

/// The map of a machine of ours: per axis one drive with 0x6040 controlword, 0x607A target_position as
/// outputs (PDO 0x1600) and 0x6041 statusword, 0x6064 position_actual, 0x606C velocity_actual, 0x60F4
/// following_error as inputs (PDO 0x1A00); all outputs from `logical_address` on, all inputs behind them.
[[nodiscard]] ProcessMap servo_map(const std::vector<ServoAxis>& axes,
                                   std::uint32_t logical_address = 0x10000);

/// An overlap or another mistake of a map, in words; nullopt if there is none.
[[nodiscard]] std::optional<std::string> map_mistake(const ProcessMap& map);

}  // namespace abbe
