#include "abbe/capture/decode.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "abbe/capture/field.h"

namespace abbe {
namespace {

constexpr std::size_t kBlock = 1024;
constexpr std::size_t kIndices = 256;  ///< of datagrams
constexpr std::uint64_t kReportEvery = 1U << 16;
constexpr double kGap = 1.5;  // cycles

std::uint64_t end_of(const PdoObject& o) { return o.bit + static_cast<std::uint64_t>(o.bits); }

bool carries(const ProcessDatagram& p, const PdoObject& o) {
  const std::uint64_t first = std::uint64_t{p.address} * 8, end = first + std::uint64_t{p.length} * 8;
  const EcatCommand wrong = o.direction == PdoDirection::input ? EcatCommand::lwr : EcatCommand::lrd;
  return p.command != wrong && p.returned > 0 && o.bit >= first && end_of(o) <= end;
}

bool overlaps_input(const std::vector<PdoObject>& objects, const PdoObject& output) {
  return std::any_of(objects.begin(), objects.end(), [&](const PdoObject& o) {
    return o.direction == PdoDirection::input && o.bit < end_of(output) && output.bit < end_of(o);
  });
}

/// The datagram that carries an object most often.
const ProcessDatagram* carrier_of(const PdoObject& o, const std::vector<ProcessDatagram>& process) {
  const ProcessDatagram* best = nullptr;
  for (const ProcessDatagram& p : process) {
    if (carries(p, o) && (best == nullptr || p.returned > best->returned)) best = &p;
  }
  return best;
}

/// How a process datagram is read.
struct Route {
  EcatCommand command{};
  std::uint32_t address = 0;
  std::size_t length = 0;
  std::uint16_t expected = 0;
  bool hides_outputs = false;  ///< inputs lie over outputs: these are only in frames on their way out
  std::vector<Field> inputs;
  std::vector<Field>
      sent;  ///< outputs of frames on their way out: row is the index of the frame's first datagram
  std::vector<Field> outputs;  ///< the same of returning frames
  struct Held {
    const double* from;  ///< where `sent` puts it
    double* to;          ///< its column
  };
  std::vector<Held> held;
};

/// `kind`: a Route or a ProcessDatagram.
template <class Kind>
bool is(const Datagram& d, const Kind& kind) {
  return d.address == kind.address && d.data.size() == kind.length && d.command == kind.command;
}

/// The reference clock has 32 bits in some frames: it is unwrapped, over pauses of more than half a turn
/// (2.1 s) with the recorder's time.
class Clock {
 public:
  explicit Clock(TimeBase base) : base_(base) {}
  /// False: the frame has no time of this base. (An optional would cost a stalled load for every row.)
  [[nodiscard]] bool read(const BusFrame& frame, std::int64_t& ns) {
    if (base_ == TimeBase::recorder) {
      ns = frame.packet.time_ns;
      return true;
    }
    const std::optional<std::int64_t> time = of_device(frame);
    ns = time.value_or(0);
    return time.has_value();
  }

 private:
  [[nodiscard]] std::optional<std::int64_t> of_device(const BusFrame& frame) {
    if (base_ == TimeBase::esl) return frame.ethernet.esl ? time_of(*frame.ethernet.esl) : std::nullopt;
    const auto reading = clock_of(frame);
    if (!reading) return std::nullopt;
    if (reading->whole) return static_cast<std::int64_t>(reading->ns);
    const auto low = static_cast<std::uint32_t>(reading->ns);
    total_ += last_ ? step(low, frame.packet.time_ns) : static_cast<std::int64_t>(low);
    last_ = low;
    last_recorded_ = frame.packet.time_ns;
    return total_;
  }

  /// The step modulo one turn that is nearest to what the recorder's clock says.
  [[nodiscard]] std::int64_t step(std::uint32_t low, std::int64_t recorded) const {
    constexpr double kTurn = 4294967296.0;
    const std::int64_t shortest = static_cast<std::int32_t>(low - *last_);
    const auto rest = static_cast<double>(recorded - last_recorded_ - shortest);
    return shortest + std::llround(rest / kTurn) * (std::int64_t{1} << 32);
  }

  TimeBase base_;
  std::optional<std::uint32_t> last_;
  std::int64_t total_ = 0, last_recorded_ = 0;
};

class Decoder {
 public:
  Decoder(const DecodePlan& plan, const CaptureSurvey& survey, const DecodeOptions& options,
          const ColumnSink& sink)
      : options_(options), sink_(sink), clock_(options.base) {
    columns_.assign(plan.columns.size(), std::vector<double>(kBlock));
    sent_.assign(plan.columns.size(), std::vector<double>(kIndices));
    time_.resize(kBlock);
    if (survey.cycle) longest_ = kGap * *survey.cycle;
    std::vector<const ProcessDatagram*> carriers;
    for (const PdoObject& o : plan.columns) carriers.push_back(carrier_of(o, survey.process));
    for (const ProcessDatagram& p : survey.process) add_route(p, plan, carriers);
    if (const ProcessDatagram* first = first_of_cycle(survey.process)) first_ = *first;
    seen_.assign(routes_.size(), false);
  }

  /// False: the sink asked to stop.
  bool see(const BusFrame& frame) {
    if (frame.ethernet.kind == EcatFrame::Kind::bad) ++report_.bad_frames;
    if (frame.datagrams.empty() || frame.ethernet.kind != EcatFrame::Kind::datagrams) return true;
    const std::size_t slot = frame.datagrams.front().index;
    for (const Datagram& d : frame.datagrams) {
      if (!d.logical()) continue;
      if (frame.returning && first_ && is(d, *first_)) begin_row();
      const std::size_t r = find_route(d);
      if (r == routes_.size()) continue;
      if (!frame.returning) {
        read_fields(routes_[r].sent, d.data, slot);
      } else if (!take(frame, d, r, slot)) {
        return false;
      }
    }
    return true;
  }

  [[nodiscard]] DecodeReport finish() {
    if (!stopped_) flush();
    report_.stopped = stopped_;
    return std::move(report_);
  }

 private:
  void add_route(const ProcessDatagram& p, const DecodePlan& plan,
                 const std::vector<const ProcessDatagram*>& carriers) {
    Route route;
    route.command = p.command;
    route.address = p.address;
    route.length = p.length;
    route.expected = p.expected();
    for (std::size_t c = 0; c < plan.columns.size(); ++c) {
      const PdoObject& o = plan.columns[c];
      if (carriers[c] != &p) continue;
      const std::uint64_t bit = o.bit - std::uint64_t{p.address} * 8;
      if (o.direction == PdoDirection::input) {
        route.inputs.push_back(make_field(o, bit, columns_[c].data()));
        continue;
      }
      route.hides_outputs |= overlaps_input(plan.inputs, o);
      route.outputs.push_back(make_field(o, bit, columns_[c].data()));
      route.sent.push_back(make_field(o, bit, sent_[c].data()));
      route.held.push_back({sent_[c].data(), columns_[c].data()});
    }
    for (auto* fields : {&route.inputs, &route.outputs, &route.sent}) sort_by_kind(*fields);
    if (!route.inputs.empty() || !route.outputs.empty()) routes_.push_back(std::move(route));
  }

  [[nodiscard]] std::size_t find_route(const Datagram& d) const {
    std::size_t r = 0;
    while (r < routes_.size() && !is(d, routes_[r])) ++r;
    return r;
  }

  bool take(const BusFrame& frame, const Datagram& d, std::size_t r, std::size_t slot) {
    const Route& route = routes_[r];
    if (seen_[r]) begin_row();
    seen_[r] = true;
    ++seen_count_;
    short_ |= d.working_counter < route.expected || d.working_counter == 0;
    read_fields(route.inputs, d.data, fill_);
    const bool known = frame.partner != 0;
    if (known) {
      for (const Route::Held& held : route.held) held.to[fill_] = held.from[slot];
    } else {
      read_fields(route.outputs, d.data, fill_);
    }
    unknown_output_ |= route.hides_outputs && !known;
    return seen_count_ < routes_.size() || end_row(frame);
  }

  /// What was seen of a cycle that did not become complete is of no use.
  void begin_row() {
    if (seen_count_ == 0) return;
    ++report_.incomplete_rows;
    forget();
  }

  void forget() {
    std::fill(seen_.begin(), seen_.end(), false);
    seen_count_ = 0;
    short_ = unknown_output_ = false;
  }

  bool end_row(const BusFrame& frame) {
    const bool is_short = short_, unknown = unknown_output_;
    forget();
    std::int64_t time = 0;
    const bool timed = clock_.read(frame, time);
    if (is_short) ++report_.short_rows;
    if (unknown) ++report_.incomplete_rows;
    if (!timed) ++report_.untimed_rows;
    if ((is_short && !options_.keep_short) || unknown || !timed) return true;
    const std::uint64_t row = report_.rows++;
    if (row == 0) report_.first_ns = time;
    const double seconds = static_cast<double>(time - report_.first_ns) * 1e-9;
    if (row > 0) watch(row, seconds);
    last_ = seconds;
    time_[fill_] = seconds;
    return ++fill_ < kBlock || flush();
  }

  void watch(std::uint64_t row, double seconds) {
    if (seconds <= last_) ++report_.backward;
    if (longest_ <= 0 || seconds - last_ <= longest_) return;
    ++report_.gap_count;
    if (report_.gaps.size() < DecodeReport::kMostGaps)
      report_.gaps.push_back({row, seconds, seconds - last_});
  }

  bool flush() {
    if (fill_ == 0) return true;
    ColumnBlock block;
    block.time = {time_.data(), fill_};
    for (const std::vector<double>& column : columns_) block.columns.emplace_back(column.data(), fill_);
    fill_ = 0;
    stopped_ = !sink_(block);
    return !stopped_;
  }

  DecodeOptions options_;
  const ColumnSink& sink_;
  Clock clock_;
  std::optional<ProcessDatagram> first_;  ///< of a cycle
  std::vector<Route> routes_;
  std::vector<std::vector<double>> columns_;
  std::vector<double> time_;
  std::vector<std::vector<double>>
      sent_;  ///< outputs on their way, by the index of the frame's first datagram
  std::vector<char> seen_;
  std::size_t seen_count_ = 0, fill_ = 0;
  bool short_ = false, unknown_output_ = false, stopped_ = false;
  double longest_ = 0, last_ = 0;
  DecodeReport report_;
};

}  // namespace

std::string_view to_string(TimeBase base) {
  switch (base) {
    case TimeBase::esl:
      return "esl";
    case TimeBase::clock:
      return "clock";
    case TimeBase::recorder:
      break;
  }
  return "recorder";
}

TimeBase best_time_base(const CaptureSurvey& survey) {
  if (survey.ethercat > 0 && survey.esl_timed >= survey.ethercat) return TimeBase::esl;
  if (survey.process_returned > 0 && survey.clock_returned == survey.process_returned) return TimeBase::clock;
  return TimeBase::recorder;
}

DecodePlan plan_columns(const ProcessMap& map, const CaptureSurvey& survey) {
  DecodePlan plan;
  for (const PdoObject& object : map.objects) {
    if (object.direction == PdoDirection::input) plan.inputs.push_back(object);
    const bool carried = std::any_of(survey.process.begin(), survey.process.end(),
                                     [&](const ProcessDatagram& p) { return carries(p, object); });
    if (!carried) {
      plan.missing.push_back(object.name);
    } else if (object.direction == PdoDirection::output && survey.sent == 0 &&
               overlaps_input(map.objects, object)) {
      plan.hidden.push_back(object.name);
    } else {
      plan.columns.push_back(object);
    }
  }
  return plan;
}

FileResult<DecodeReport> decode_capture(const std::string& path, const DecodePlan& plan,
                                        const CaptureSurvey& survey, const DecodeOptions& options,
                                        const ColumnSink& sink, const Progress& progress) {
  FileResult<BusReader> opened = BusReader::open(path);
  if (auto* error = std::get_if<FileError>(&opened)) return std::move(*error);
  auto& reader = std::get<BusReader>(opened);
  Decoder decoder(plan, survey, options, sink);
  bool stopped = false;
  for (BusFrame frame; !stopped && reader.next(frame);) {
    stopped = !decoder.see(frame);
    if (progress && frame.number % kReportEvery == 0 && !progress(reader.bytes(), 0)) stopped = true;
  }
  DecodeReport report = decoder.finish();
  report.stopped |= stopped;
  report.error = reader.error();
  return report;
}

}  // namespace abbe
