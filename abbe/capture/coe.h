#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace abbe {

/// A value of a slave's object dictionary that went over its mailbox, either way.
struct SdoValue {
  std::uint16_t station = 0, index = 0;
  std::uint8_t subindex = 0;
  bool complete = false;  ///< all subindices at once; subindex 0 then fills two bytes
  bool download = false;  ///< written by the master
  std::vector<std::uint8_t> data;
};

/// Puts together what masters and slaves say by CoE SDO: expedited, normal and segmented transfers, complete
/// access. Any bytes are allowed; what is no CoE changes nothing.
/// source   ETG.1000.6 section 5.6
class SdoListener {
 public:
  /// A mailbox as it was written to, or read from, a slave. Gives the value when its transfer is finished.
  [[nodiscard]] std::optional<SdoValue> hear(std::uint16_t station, std::span<const std::uint8_t> mailbox);
  [[nodiscard]] std::uint64_t aborted() const { return aborted_; }

 private:
  struct Transfer {
    SdoValue value;
    std::size_t expected = 0;
    bool last = false;  ///< the segment under way is the last
  };
  [[nodiscard]] std::optional<SdoValue> finish(std::uint16_t station);
  void request(std::uint16_t station, std::span<const std::uint8_t> sdo);
  [[nodiscard]] std::optional<SdoValue> respond(std::uint16_t station, std::span<const std::uint8_t> sdo);

  std::map<std::uint16_t, Transfer> transfers_;
  std::uint64_t aborted_ = 0;
};

}  // namespace abbe
