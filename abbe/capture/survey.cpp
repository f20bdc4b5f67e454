#include "abbe/capture/survey.h"

#include <algorithm>

#include "abbe/capture/learn.h"

namespace abbe {
namespace {

constexpr std::uint16_t kSystemTime = 0x0910;
constexpr std::size_t kMostIntervals = 65536, kMostProcess = 4096;
constexpr std::uint64_t kReportEvery = 1U << 16;
constexpr auto kLatest = static_cast<std::uint64_t>(kLatestTime);

/// Times between frames of each process datagram, for the cycle, and since the one before it, whichever.
class CycleWatch {
 public:
  void see(std::size_t datagram, std::int64_t time_ns) {
    if (last_.size() <= datagram) {
      last_.resize(datagram + 1);
      intervals_.resize(datagram + 1);
      leads_.resize(datagram + 1);
    }
    if (before_ && leads_[datagram].size() < kMostIntervals) leads_[datagram].push_back(time_ns - *before_);
    before_ = time_ns;
    if (last_[datagram] && intervals_[datagram].size() < kMostIntervals)
      intervals_[datagram].push_back(time_ns - *last_[datagram]);
    last_[datagram] = time_ns;
  }
  [[nodiscard]] std::optional<double> median() {
    const auto most = std::max_element(intervals_.begin(), intervals_.end(),
                                       [](const auto& a, const auto& b) { return a.size() < b.size(); });
    if (most == intervals_.end() || most->size() < 2) return std::nullopt;
    const auto middle = most->begin() + static_cast<std::ptrdiff_t>(most->size() / 2);
    std::nth_element(most->begin(), middle, most->end());
    if (*middle <= 0) return std::nullopt;
    return static_cast<double>(*middle) * 1e-9;
  }
  /// s, exceeded by all but 2 %: a frame lost before it makes a lead longer, and one of a slower task is
  /// shorter.
  [[nodiscard]] double lead(std::size_t datagram) {
    if (datagram >= leads_.size() || leads_[datagram].empty()) return 0;
    std::vector<std::int64_t>& leads = leads_[datagram];
    const auto low = leads.begin() + static_cast<std::ptrdiff_t>(leads.size() / 50);
    std::nth_element(leads.begin(), low, leads.end());
    return static_cast<double>(*low) * 1e-9;
  }

 private:
  std::optional<std::int64_t> before_;
  std::vector<std::optional<std::int64_t>> last_;
  std::vector<std::vector<std::int64_t>> intervals_, leads_;
};

class Surveyor {
 public:
  void see(const BusFrame& frame) {
    ++s_.packets;
    if (s_.packets == 1) s_.first_ns = s_.last_ns = frame.packet.time_ns;
    s_.first_ns = std::min(s_.first_ns, frame.packet.time_ns);
    s_.last_ns = std::max(s_.last_ns, frame.packet.time_ns);
    if (frame.packet.bytes.size() < frame.packet.original) ++s_.cut;
    see_link(frame.ethernet);
    switch (frame.ethernet.kind) {
      case EcatFrame::Kind::other:
        ++s_.other;
        return;
      case EcatFrame::Kind::other_ethercat:
        ++s_.other_ethercat;
        return;
      case EcatFrame::Kind::bad:
        ++s_.bad;
        if (s_.faults.size() < CaptureSurvey::kMostListed)
          s_.faults.push_back({frame.number, frame.ethernet.fault});
        return;
      case EcatFrame::Kind::datagrams:
        break;
    }
    ++s_.ethercat;
    see_datagrams(frame);
  }

  [[nodiscard]] CaptureSurvey finish() {
    s_.cycle = cycle_.median();
    for (std::size_t i = 0; i < s_.process.size(); ++i) s_.process[i].lead = cycle_.lead(i);
    s_.slaves = setup_.slaves();
    s_.states = setup_.states();
    s_.sdo_values = setup_.sdo_values();
    s_.sdo_aborts = setup_.sdo_aborts();
    std::sort(s_.process.begin(), s_.process.end(),
              [](const ProcessDatagram& a, const ProcessDatagram& b) { return a.address < b.address; });
    return std::move(s_);
  }

 private:
  void see_link(const EcatFrame& frame) {
    s_.vlan += frame.vlan_tags > 0 ? 1 : 0;
    s_.udp += frame.udp ? 1 : 0;
    if (!frame.esl) return;
    ++s_.esl;
    s_.esl_timed += time_of(*frame.esl) ? 1 : 0;
    s_.esl_errors += frame.esl->alignment_error || frame.esl->crc_error ? 1 : 0;
    if (frame.esl->port >= 0) ++s_.esl_ports[static_cast<std::size_t>(frame.esl->port)];
  }

  void see_datagrams(const BusFrame& frame) {
    ++(frame.returning ? s_.returned : s_.sent);
    s_.paired += frame.partner != 0 ? 1 : 0;
    bool process = false;
    for (const Datagram& d : frame.datagrams) {
      const auto command = static_cast<std::size_t>(d.command);
      ++(command < s_.commands.size() ? s_.commands[command] : s_.unknown_commands);
      if (frame.returning) setup_.hear(d);
      if (d.logical()) process |= see_process(frame, d);
    }
    if (!process || !frame.returning) return;
    ++s_.process_returned;
    s_.clock_returned += clock_of(frame) ? 1 : 0;
  }

  bool see_process(const BusFrame& frame, const Datagram& d) {
    const auto length = static_cast<std::uint32_t>(d.data.size());
    auto at = std::find_if(s_.process.begin(), s_.process.end(), [&](const ProcessDatagram& p) {
      return p.address == d.address && p.length == length && p.command == d.command;
    });
    if (at == s_.process.end()) {
      if (s_.process.size() >= kMostProcess) return false;  // nonsense, or a bus that nobody has
      at = s_.process.insert(at, {d.command, d.address, length, 0, 0, {}, 0});
    }
    if (!frame.returning) {
      ++at->sent;
      return true;
    }
    ++at->returned;
    ++at->counters[d.working_counter];
    cycle_.see(static_cast<std::size_t>(at - s_.process.begin()), frame.packet.time_ns);
    return true;
  }

  CaptureSurvey s_;
  CycleWatch cycle_;
  SetupListener setup_;
};

}  // namespace

std::uint16_t ProcessDatagram::expected() const {
  std::uint16_t best = 0;
  std::uint64_t most = 0;
  for (const auto& [counter, frames] : counters) {
    if (counter == 0 || frames < most) continue;
    most = frames;
    best = counter;
  }
  return best;
}

const ProcessDatagram* first_of_cycle(const std::vector<ProcessDatagram>& process) {
  const auto first =
      std::max_element(process.begin(), process.end(),
                       [](const ProcessDatagram& a, const ProcessDatagram& b) { return a.lead < b.lead; });
  return first != process.end() && first->lead > 0 ? &*first : nullptr;
}

std::optional<ClockReading> clock_of(const BusFrame& frame) {
  for (const Datagram& d : frame.datagrams) {
    if (d.logical() || d.offset() != kSystemTime || d.working_counter == 0) continue;
    using C = EcatCommand;
    const bool reads =
        d.command == C::frmw || d.command == C::armw || d.command == C::fprd || d.command == C::aprd;
    if (!reads) continue;
    if (d.data.size() == 8) {
      const auto ns = load_little<std::uint64_t>(d.data.data());
      if (ns > kLatest) continue;
      return ClockReading{ns, true};
    }
    if (d.data.size() == 4) return ClockReading{load_little<std::uint32_t>(d.data.data()), false};
  }
  return std::nullopt;
}

std::optional<std::int64_t> time_of(const EslInfo& esl) {
  if (esl.timestamp_ns == 0 || esl.timestamp_ns > kLatest) return std::nullopt;
  return static_cast<std::int64_t>(esl.timestamp_ns);
}

FileResult<CaptureSurvey> survey_capture(const std::string& path, std::uint64_t most,
                                         const Progress& progress) {
  FileResult<BusReader> opened = BusReader::open(path);
  if (auto* error = std::get_if<FileError>(&opened)) return std::move(*error);
  auto& reader = std::get<BusReader>(opened);
  Surveyor surveyor;
  bool complete = true;
  for (BusFrame frame; complete && reader.next(frame);) {
    surveyor.see(frame);
    if (most != 0 && frame.number >= most) complete = false;
    if (progress && frame.number % kReportEvery == 0 && !progress(reader.bytes(), 0)) complete = false;
  }
  CaptureSurvey survey = surveyor.finish();
  survey.bytes = reader.bytes();
  survey.complete = complete;
  survey.error = reader.error();
  return survey;
}

}  // namespace abbe
