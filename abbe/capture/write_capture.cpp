#include "abbe/capture/write_capture.h"

#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>

#include "abbe/capture/bits.h"
#include "abbe/capture/frame_writer.h"
#include "abbe/capture/slave_layout.h"

namespace abbe {
namespace {

constexpr std::uint64_t kMostImage = 1400;
constexpr std::int64_t kStep = 100'000;                          // ns between start-up frames
constexpr std::int64_t kEpochOfClock = 946'684'800'000'000'000;  // 2000-01-01 after 1970, ns
constexpr std::int64_t kSecond = 1'000'000'000;

Diagnostic misfit(std::string message, std::string fix = {}) {
  Diagnostic d;
  d.code = "E-SIMULATE";
  d.place.file = "capture to be written";
  d.message = std::move(message);
  d.why = "the capture would not say what the signals say";
  d.fix = std::move(fix);
  return d;
}

/// The bits of a value on the bus; nullopt if it does not fit.
std::optional<std::uint64_t> raw_of(const PdoObject& object, double value) {
  const double counts = value / object.scale;
  if (object.type == PdoType::real) {
    if (object.bits == 64) return std::bit_cast<std::uint64_t>(counts);
    const auto single = static_cast<float>(counts);
    if (!std::isfinite(single)) return std::nullopt;
    return std::bit_cast<std::uint32_t>(single);
  }
  const double rounded = std::nearbyint(counts);
  const bool with_sign = object.type == PdoType::signed_integer;
  const double limit = std::ldexp(1.0, with_sign ? object.bits - 1 : object.bits);
  if (!(rounded < limit && rounded >= (with_sign ? -limit : 0))) return std::nullopt;
  return with_sign ? static_cast<std::uint64_t>(static_cast<std::int64_t>(rounded))
                   : static_cast<std::uint64_t>(rounded);
}

/// A signal and where its bits go in the data of its datagram.
struct Placed {
  const CaptureColumn* column;
  const PdoObject* object;
  std::size_t at;
};

/// One datagram of process data: a stretch of the logical image without large gaps.
struct Part {
  std::uint64_t begin = 0, end = 0;  ///< logical bytes
  bool inputs = false, outputs = false;
  std::uint16_t readers = 0, writers = 0;  ///< slaves that take outputs from it, that put inputs into it
  std::vector<Placed> signals[2];          ///< inputs, outputs

  [[nodiscard]] std::size_t bytes() const { return static_cast<std::size_t>(end - begin); }
  [[nodiscard]] EcatCommand command() const {
    if (inputs && outputs) return EcatCommand::lrw;
    return inputs ? EcatCommand::lrd : EcatCommand::lwr;
  }
  /// A slave counts 1 for reading or writing; in an LRW 2 for what it takes.
  [[nodiscard]] std::uint16_t working_counter() const {
    return static_cast<std::uint16_t>(writers + (command() == EcatCommand::lrw ? 2 : 1) * readers);
  }
};

/// The process data of a cycle and the slaves it is for.
struct Image {
  std::vector<Part> parts;
  std::uint16_t reference = 0;  ///< station of the first slave
  std::uint16_t slaves = 0;
};

std::optional<Diagnostic> check_settings(const CaptureSettings& s) {
  if (!(s.cycle >= 1e-6 && s.cycle <= 1))
    return misfit(fmt::format("a cycle of {} s", s.cycle), "1e-6 to 1 s");
  constexpr std::int64_t kMostSeconds = 4'000'000'000;  // pcap counts seconds in 32 bits
  if (s.start_ns < 10 * kSecond || s.start_ns > kMostSeconds * kSecond)
    return misfit(fmt::format("a start at {} ns since 1970", s.start_ns), "between 1970 and 2096");
  return std::nullopt;
}

std::optional<Diagnostic> check_columns(std::span<const CaptureColumn> columns) {
  if (columns.empty() || columns.front().values.empty())
    return misfit("no signals", "give at least one column");
  std::map<std::string, int> seen;
  for (const CaptureColumn& column : columns) {
    if (column.values.size() != columns.front().values.size())
      return misfit(fmt::format("the signal {} has {} samples, {} has {}", column.name, column.values.size(),
                                columns.front().name, columns.front().values.size()));
    if (++seen[column.name] > 1) return misfit(fmt::format("the signal {} is given twice", column.name));
  }
  return std::nullopt;
}

std::optional<Diagnostic> place_columns(const ProcessMap& map, std::span<const CaptureColumn> columns,
                                        Image& image) {
  for (const CaptureColumn& column : columns) {
    const auto object = std::find_if(map.objects.begin(), map.objects.end(),
                                     [&](const PdoObject& o) { return o.name == column.name; });
    if (object == map.objects.end()) {
      std::vector<std::string> names;
      for (const PdoObject& o : map.objects) names.push_back(o.name);
      const auto like = closest(column.name, names);
      return misfit(fmt::format("no object of the map is named {}", column.name),
                    like ? fmt::format("did you mean {}?", *like) : std::string());
    }
    for (Part& part : image.parts) {
      if (object->bit / 8 < part.begin || object->bit / 8 >= part.end) continue;
      part.signals[object->direction == PdoDirection::output ? 1 : 0].push_back(
          {&column, &*object, static_cast<std::size_t>(object->bit - part.begin * 8)});
    }
  }
  return std::nullopt;
}

/// Stretches of the image, cut where nothing is for longer than a datagram's own 12 bytes.
std::vector<Part> parts_of(std::vector<SlaveRange> ranges) {
  constexpr std::uint64_t kOverhead = 12;
  std::sort(ranges.begin(), ranges.end(),
            [](const SlaveRange& a, const SlaveRange& b) { return a.begin < b.begin; });
  std::vector<Part> parts;
  for (const SlaveRange& range : ranges) {
    const std::uint64_t begin = range.begin / 8, end = (range.end + 7) / 8;
    if (parts.empty() || begin > parts.back().end + kOverhead)
      parts.push_back({begin, end, false, false, 0, 0, {}});
    Part& part = parts.back();
    part.end = std::max(part.end, end);
    const bool input = range.direction == PdoDirection::input;
    (input ? part.inputs : part.outputs) = true;
    ++(input ? part.writers : part.readers);
  }
  return parts;
}

std::variant<Image, Diagnostic> make_image(const ProcessMap& map, std::span<const CaptureColumn> columns) {
  if (map.objects.empty()) return misfit("the process-data map is empty");
  if (const auto mistake = map_mistake(map)) return misfit(*mistake, "correct the process-data map");
  Image image;
  const std::vector<SlaveRange> ranges = slave_ranges(map);
  for (const SlaveRange& range : ranges) {
    if (!can_be_mapped(range))
      return misfit(
          fmt::format("the objects of slave {} cannot be mapped by PDOs in this order", range.station),
          "let the objects of one PDO stand together, at most 254 of them");
    if (image.slaves == 0 || image.reference != range.station) ++image.slaves;
    image.reference = range.station;
  }
  image.reference = ranges.front().station;
  image.parts = parts_of(ranges);
  std::uint64_t bytes = 0;
  for (const Part& part : image.parts) bytes += part.bytes() + 12;
  if (bytes > kMostImage)
    return misfit(fmt::format("the process data takes {} bytes of a frame; {} fit", bytes, kMostImage));
  if (auto d = place_columns(map, columns, image)) return *d;
  return image;
}

std::optional<Diagnostic> fill(const std::vector<Placed>& signals, std::size_t cycle,
                               std::span<std::uint8_t> bytes) {
  for (const Placed& signal : signals) {
    const double value = signal.column->values[cycle];
    const auto raw = std::isfinite(value) ? raw_of(*signal.object, value) : std::nullopt;
    if (!raw)
      return misfit(
          fmt::format("sample {} of {} is {} {}, which an object of {} bits and scale {} cannot hold",
                      cycle + 1, signal.column->name, value, signal.object->unit, signal.object->bits,
                      signal.object->scale),
          "check the unit of the signal and the counts per unit of the axis");
    store_bits(bytes, signal.at, signal.object->bits, *raw);
  }
  return std::nullopt;
}

std::vector<std::uint8_t> clock_bytes(std::int64_t time_ns) {
  std::vector<std::uint8_t> bytes(8);
  const std::int64_t clock = time_ns - kEpochOfClock;
  std::memcpy(bytes.data(), &clock, sizeof clock);
  return bytes;
}

}  // namespace

std::optional<Diagnostic> write_capture(const ProcessMap& map, std::span<const CaptureColumn> columns,
                                        const CaptureSettings& settings, SpoolFile& out) {
  if (auto d = check_settings(settings)) return d;
  if (auto d = check_columns(columns)) return d;
  const std::variant<Image, Diagnostic> made = make_image(map, columns);
  if (const auto* d = std::get_if<Diagnostic>(&made)) return *d;
  const Image& image = std::get<Image>(made);

  const std::size_t steps = settings.startup ? write_startup(map, 0, kStep, nullptr) : 0;
  const std::int64_t since = settings.start_ns - static_cast<std::int64_t>(steps + 1) * kStep;
  FrameWriter writer(settings, since - kStep, out);
  if (settings.startup) write_startup(map, since, kStep, &writer);

  std::vector<SentDatagram> cyclic(settings.clock ? 1 : 0);
  for (const Part& part : image.parts) {
    const std::vector<std::uint8_t> zeros(part.bytes());
    cyclic.push_back(
        {part.command(), static_cast<std::uint32_t>(part.begin), zeros, zeros, part.working_counter()});
  }
  const std::size_t cycles = columns.front().values.size();
  for (std::size_t cycle = 0; cycle < cycles && writer.ok(); ++cycle) {
    const auto time = settings.start_ns + std::llround(static_cast<double>(cycle) * settings.cycle * 1e9);
    if (settings.clock)
      cyclic.front() = {EcatCommand::frmw, device_address(image.reference, 0x0910),
                        clock_bytes(kEpochOfClock), clock_bytes(time + FrameWriter::kRoundTrip),
                        image.slaves};
    for (std::size_t i = 0; i < image.parts.size(); ++i) {
      SentDatagram& data = cyclic[i + (settings.clock ? 1 : 0)];
      if (auto d = fill(image.parts[i].signals[1], cycle, data.out)) return d;
      // What the slaves take stays in the frame, what they give replaces what was there.
      data.back = data.out;
      if (auto d = fill(image.parts[i].signals[0], cycle, data.back)) return d;
    }
    writer.exchange(time, cyclic);
  }
  if (!writer.ok()) {
    Diagnostic d;
    d.code = "E-FILE";
    d.place.file = "capture to be written";
    d.message = out.error() ? out.error()->message : "writing failed";
    return d;
  }
  return std::nullopt;
}

}  // namespace abbe
