#include "abbe/capture/decode.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>

#include "abbe/capture/frame.h"
#include "abbe/capture/frame_writer.h"
#include "abbe/capture/read_map.h"
#include "abbe/capture/test_captures.h"

namespace abbe {
namespace {

constexpr double kHalfCount = 0.5 + 1e-9;
constexpr double kNanosecond = 1e-9;

struct Decoded {
  DecodeReport report;
  std::vector<double> time;
  std::map<std::string, std::vector<double>> columns;
};

CaptureSurvey survey_of(const std::string& path) {
  auto survey = survey_capture(path);
  EXPECT_TRUE(std::holds_alternative<CaptureSurvey>(survey));
  return std::get<CaptureSurvey>(survey);
}

ProcessMap learned(const CaptureSurvey& survey) {
  Diagnostics findings;
  return named(map_of(survey.slaves, findings), two_axes());
}

Decoded decode(const std::string& path, const ProcessMap& map, DecodeOptions options = {}) {
  const CaptureSurvey survey = survey_of(path);
  const DecodePlan plan = plan_columns(map, survey);
  Decoded decoded;
  auto report = decode_capture(path, plan, survey, options, [&](const ColumnBlock& block) {
    decoded.time.insert(decoded.time.end(), block.time.begin(), block.time.end());
    for (std::size_t c = 0; c < plan.columns.size(); ++c) {
      auto& column = decoded.columns[plan.columns[c].name];
      column.insert(column.end(), block.columns[c].begin(), block.columns[c].end());
    }
    return true;
  });
  decoded.report = std::get<DecodeReport>(report);
  return decoded;
}

/// Signals of both axes, within the range of the objects.
struct Signals {
  std::vector<double> x, target, y, status;
  explicit Signals(std::size_t n) {
    std::mt19937 random(4);
    std::uniform_real_distribution<double> noise(-0.001, 0.001);
    for (std::size_t i = 0; i < n; ++i) {
      const double t = static_cast<double>(i) * 1e-3;
      x.push_back(100 * std::cos(t) + noise(random));
      target.push_back(100 * std::cos(t));
      y.push_back(-30 * std::sin(t));
      status.push_back(static_cast<double>(i % 65536));
    }
  }
  [[nodiscard]] std::vector<CaptureColumn> columns() const {
    return {{"X.position_actual", x},
            {"X.target_position", target},
            {"Y.position_actual", y},
            {"Y.statusword", status}};
  }
};

void expect_counts(const std::vector<double>& is, const std::vector<double>& should, double counts_per_unit) {
  ASSERT_EQ(is.size(), should.size());
  for (std::size_t i = 0; i < is.size(); ++i)
    ASSERT_NEAR(is[i] * counts_per_unit, should[i] * counts_per_unit, kHalfCount) << "row " << i;
}

// Synthetic: no public capture holds cyclic positions of drives with the times of a switch link.
TEST(Decode, WrittenColumnsAreReadBack) {
  const Signals signals(9000);
  for (const EslPlace esl : {EslPlace::none, EslPlace::header, EslPlace::trailer}) {
    for (const bool forward : {true, false}) {
      const ScratchFile file("columns.pcap");
      CaptureSettings settings;
      settings.esl = esl;
      settings.forward = forward;
      settings.cycle = 250e-6;
      ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), signals.columns(), settings));
      const CaptureSurvey survey = survey_of(file.path());
      EXPECT_EQ(best_time_base(survey), esl == EslPlace::none ? TimeBase::clock : TimeBase::esl);
      EXPECT_EQ(survey.bad, 0U);
      EXPECT_EQ(survey.paired, forward ? survey.returned : 0);
      for (const TimeBase base : {TimeBase::recorder, TimeBase::clock, best_time_base(survey)}) {
        DecodeOptions options;
        options.base = base;
        const Decoded decoded = decode(file.path(), learned(survey), options);
        ASSERT_EQ(decoded.report.rows, signals.x.size());
        EXPECT_EQ(decoded.report.short_rows + decoded.report.incomplete_rows + decoded.report.gap_count, 0U);
        EXPECT_NEAR(decoded.time[8000], 8000 * settings.cycle, kNanosecond);
        expect_counts(decoded.columns.at("X.position_actual"), signals.x, 10000);
        expect_counts(decoded.columns.at("X.target_position"), signals.target, 10000);
        expect_counts(decoded.columns.at("Y.position_actual"), signals.y, -3600);
        expect_counts(decoded.columns.at("Y.statusword"), signals.status, 1);
      }
    }
  }
}

TEST(Decode, LearnedMapIsTheWrittenOne) {
  const Signals signals(5);
  const ScratchFile file("learned.pcap");
  const ProcessMap map = servo_map(two_axes());
  ASSERT_FALSE(put_capture(file.path(), map, signals.columns()));
  const ProcessMap back = learned(survey_of(file.path()));
  ASSERT_EQ(back.objects.size(), map.objects.size());
  for (std::size_t i = 0; i < map.objects.size(); ++i) {
    EXPECT_EQ(back.objects[i].name, map.objects[i].name);
    EXPECT_EQ(back.objects[i].bit, map.objects[i].bit);
    EXPECT_EQ(back.objects[i].bits, map.objects[i].bits);
    EXPECT_EQ(back.objects[i].pdo, map.objects[i].pdo);
    EXPECT_EQ(back.objects[i].scale, map.objects[i].scale);
    EXPECT_EQ(back.objects[i].unit, map.objects[i].unit);
    EXPECT_EQ(back.objects[i].type, map.objects[i].type);
  }
}

/// The packets of a classic pcap file with their headers.
std::vector<std::vector<std::uint8_t>> packets_of(const std::vector<std::uint8_t>& file) {
  std::vector<std::vector<std::uint8_t>> packets;
  for (std::size_t at = 24; at + 16 <= file.size();) {
    const std::size_t size = 16 + load_little<std::uint32_t>(file.data() + at + 8);
    packets.emplace_back(file.begin() + static_cast<std::ptrdiff_t>(at),
                         file.begin() + static_cast<std::ptrdiff_t>(at + size));
    at += size;
  }
  return packets;
}

void put_packets(const ScratchFile& file, const std::vector<std::vector<std::uint8_t>>& packets) {
  std::vector<std::uint8_t> bytes = file.bytes();
  bytes.resize(24);
  for (const auto& packet : packets) bytes.insert(bytes.end(), packet.begin(), packet.end());
  file.put(bytes);
}

TEST(Decode, OddBitsAndSharedAddressesAreReadBack) {
  // Inputs lie over outputs, as in masters that save addresses; objects begin inside bytes.
  ProcessMap map;
  const auto add = [&](const char* name, PdoDirection direction, PdoType type, int bits, std::uint64_t bit) {
    PdoObject o;
    o.name = name;
    o.station = 7;
    o.index = static_cast<std::uint16_t>(0x2000 + map.objects.size());
    o.direction = direction;
    o.type = type;
    o.bits = bits;
    o.bit = 8 * 0x500 + bit;
    map.objects.push_back(o);
  };
  add("a", PdoDirection::output, PdoType::unsigned_integer, 3, 0);
  add("b", PdoDirection::output, PdoType::signed_integer, 13, 5);
  add("c", PdoDirection::input, PdoType::signed_integer, 12, 1);
  add("d", PdoDirection::input, PdoType::real, 32, 16);
  add("e", PdoDirection::input, PdoType::real, 64, 48);
  add("f", PdoDirection::input, PdoType::signed_integer, 64, 115);
  const std::vector<double> a = {0, 7, 5}, b = {-4096, 4095, -1}, c = {2047, -2048, 3},
                            d = {0.5, -1e10F, 0.25}, e = {1.1, -2.2e-300, 3}, f = {-1e15, 1, 2e15};
  const std::vector<CaptureColumn> columns = {{"a", a}, {"b", b}, {"c", c}, {"d", d}, {"e", e}, {"f", f}};
  const ScratchFile file("bits.pcap");
  ASSERT_FALSE(put_capture(file.path(), map, columns));
  const Decoded decoded = decode(file.path(), map);
  EXPECT_EQ(decoded.columns.at("a"), a);
  EXPECT_EQ(decoded.columns.at("b"), b);
  EXPECT_EQ(decoded.columns.at("c"), c);
  EXPECT_EQ(decoded.columns.at("d"), d);
  EXPECT_EQ(decoded.columns.at("e"), e);
  EXPECT_EQ(decoded.columns.at("f"), f);

  // A cycle whose frame on its way out was lost cannot say a, also where no input is a column.
  const CaptureSurvey survey = survey_of(file.path());
  auto packets = packets_of(file.bytes());
  packets.erase(packets.end() - 4);
  put_packets(file, packets);
  DecodePlan plan = plan_columns(map, survey);
  plan.columns = {plan.columns.front()};
  std::vector<double> of_a;
  const auto report = decode_capture(file.path(), plan, survey, {}, [&](const ColumnBlock& block) {
    of_a.assign(block.columns[0].begin(), block.columns[0].end());
    return true;
  });
  EXPECT_THAT(of_a, testing::ElementsAre(0, 5));
  EXPECT_EQ(std::get<DecodeReport>(report).incomplete_rows, 1U);

  // Without the frames on their way out nobody can know a and b.
  CaptureSettings one_way;
  one_way.forward = false;
  ASSERT_FALSE(put_capture(file.path(), map, columns, one_way));
  EXPECT_THAT(plan_columns(map, survey_of(file.path())).hidden, testing::ElementsAre("a", "b"));
}

TEST(Decode, GapsShortCountersAndLostFramesAreCounted) {
  const Signals signals(100);
  const ScratchFile file("gaps.pcap");
  CaptureSettings settings;
  settings.esl = EslPlace::none;
  ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), signals.columns(), settings));
  auto packets = packets_of(file.bytes());
  const std::size_t first = packets.size() - 200;
  packets[first + 2 * 40 + 1][packets[0].size() > 0 ? packets[first + 81].size() - 2 : 0] =
      // The counter of the LRW stands behind its 40 bytes: 16 + 14 + 2 + (10 + 8 + 2) + 10 + 40.
      packets[first + 2 * 40 + 1][16 + 14 + 2 + 20 + 10 + 40] = 5;
  packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(first + 2 * 60),
                packets.begin() + static_cast<std::ptrdiff_t>(first + 2 * 63));
  put_packets(file, packets);
  const Decoded decoded = decode(file.path(), learned(survey_of(file.path())));
  EXPECT_EQ(decoded.report.rows, 96U);
  EXPECT_EQ(decoded.report.short_rows, 1U);
  EXPECT_EQ(decoded.report.gap_count, 2U);
  ASSERT_EQ(decoded.report.gaps.size(), 2U);
  EXPECT_EQ(decoded.report.gaps[0].row, 40U);
  EXPECT_NEAR(decoded.report.gaps[0].length, 0.002, kNanosecond);
  EXPECT_EQ(decoded.report.gaps[1].row, 59U);
  EXPECT_NEAR(decoded.report.gaps[1].length, 0.004, kNanosecond);
  DecodeOptions keep;
  keep.keep_short = true;
  EXPECT_EQ(decode(file.path(), learned(survey_of(file.path())), keep).report.rows, 97U);
}

/// Two frames a cycle, the second 50 us behind the first: X in one, Y in the other, returning ones only.
std::vector<std::vector<std::uint8_t>> two_frames_a_cycle(const ScratchFile& file, const Signals& signals) {
  CaptureSettings settings;
  settings.esl = EslPlace::none;
  settings.startup = settings.forward = settings.clock = false;
  const std::vector<ServoAxis> axes = two_axes();
  std::vector<std::vector<std::uint8_t>> of_axis[2];
  for (std::size_t k = 0; k < 2; ++k) {
    const auto address = static_cast<std::uint32_t>(0x10000 * (k + 1));
    EXPECT_FALSE(put_capture(file.path(), servo_map({axes[k]}, address),
                             {{axes[k].name + ".position_actual", signals.x}}, settings));
    of_axis[k] = packets_of(file.bytes());
  }
  std::vector<std::vector<std::uint8_t>> packets;
  for (std::size_t i = 0; i < of_axis[0].size(); ++i) {
    const std::uint32_t later = load_little<std::uint32_t>(of_axis[1][i].data() + 4) + 50'000;
    std::memcpy(of_axis[1][i].data() + 4, &later, sizeof later);
    packets.push_back(of_axis[0][i]);
    packets.push_back(of_axis[1][i]);
  }
  return packets;
}

TEST(Decode, RowsNeverMixCycles) {
  const Signals signals(100);
  const ScratchFile file("mixed.pcap");
  const auto whole = two_frames_a_cycle(file, signals);
  ProcessMap map = servo_map({two_axes()[0]}, 0x10000);
  for (const PdoObject& o : servo_map({two_axes()[1]}, 0x20000).objects) map.objects.push_back(o);
  const auto rows_without = [&](std::size_t lost) {
    auto packets = whole;
    packets.erase(packets.begin() + static_cast<std::ptrdiff_t>(lost));
    put_packets(file, packets);
    const Decoded decoded = decode(file.path(), map);
    const auto& x = decoded.columns.at("X.position_actual");
    const auto& y = decoded.columns.at("Y.position_actual");
    for (std::size_t i = 0; i < x.size(); ++i)
      EXPECT_NEAR(x[i], y[i], 0.5 / 3600 + 0.5 / 10000) << "row " << i;
    return decoded.report.rows;
  };
  EXPECT_EQ(rows_without(0), 99U);   // the recording begins inside a cycle
  EXPECT_EQ(rows_without(80), 99U);  // the first frame of a cycle is lost
  EXPECT_EQ(rows_without(81), 99U);  // the second
}

// The link saw a broken frame: a cycle without it, whichever way it went, and nothing old in place of
// outputs.
TEST(Decode, FramesThatTheLinkMarksAsDamagedAreNotUsed) {
  const Signals signals(300);  // the index comes round after 128 cycles
  const ScratchFile file("damaged.pcap");
  ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), signals.columns()));
  auto packets = packets_of(file.bytes());
  const std::size_t first = packets.size() - 600;
  const auto mark = [&](std::size_t packet, std::uint8_t bit) {
    packets[packet][packets[packet].size() - 9] |= bit;
  };
  mark(first + 2 * 200, 0x10);      // on its way out, checksum
  mark(first + 2 * 250 + 1, 0x08);  // on its way back, alignment
  put_packets(file, packets);
  const CaptureSurvey survey = survey_of(file.path());
  EXPECT_EQ(survey.bad, 2U);
  EXPECT_EQ(survey.esl_errors, 2U);
  ASSERT_FALSE(survey.faults.empty());
  EXPECT_THAT(std::string(survey.faults[0].fault), testing::HasSubstr("damaged"));
  const Decoded decoded = decode(file.path(), learned(survey));
  EXPECT_EQ(decoded.report.bad_frames, 2U);
  ASSERT_EQ(decoded.report.rows, 299U);
  Signals left = signals;
  left.x.erase(left.x.begin() + 250);
  left.target.erase(left.target.begin() + 250);
  expect_counts(decoded.columns.at("X.position_actual"), left.x, 10000);
  // The outputs of cycle 200 are those that its returning frame still carries, not those of 128 cycles
  // before.
  expect_counts(decoded.columns.at("X.target_position"), left.target, 10000);
}

// A clock of 32 bits turns over every 4.3 s; the bus stood still for longer.
TEST(Decode, ShortClockIsUnwrappedOverPauses) {
  const ScratchFile file("clock.pcap");
  const std::vector<std::int64_t> seconds = {10, 11, 12, 20, 21, 31};
  CaptureSettings settings;
  settings.esl = EslPlace::none;
  {
    auto created = SpoolFile::create(file.path());
    auto& out = std::get<SpoolFile>(created);
    FrameWriter writer(settings, 0, out);
    for (const std::int64_t s : seconds) {
      const std::int64_t ns = s * 1'000'000'000 + 77;
      SentDatagram clock{
          EcatCommand::frmw, device_address(1001, 0x0910), std::vector<std::uint8_t>(4), {}, 1};
      for (int byte = 0; byte < 4; ++byte) clock.back.push_back(static_cast<std::uint8_t>(ns >> 8 * byte));
      const std::vector<std::uint8_t> value = {static_cast<std::uint8_t>(s), 0, 0, 0};
      const SentDatagram data{EcatCommand::lrd, 0x10000, std::vector<std::uint8_t>(4), value, 1};
      writer.exchange(ns + 1'600'000'000'000'000'000, std::vector<SentDatagram>{clock, data});
    }
    ASSERT_TRUE(out.publish());
  }
  ProcessMap map;
  map.objects.push_back({});
  PdoObject& o = map.objects.back();
  o.name = "s";
  o.direction = PdoDirection::input;
  o.type = PdoType::unsigned_integer;
  o.bits = 32;
  o.bit = 8 * 0x10000;
  DecodeOptions options;
  options.base = TimeBase::clock;
  const Decoded decoded = decode(file.path(), map, options);
  ASSERT_EQ(decoded.report.rows, seconds.size());
  for (std::size_t i = 0; i < seconds.size(); ++i) {
    EXPECT_EQ(decoded.columns.at("s")[i], static_cast<double>(seconds[i]));
    EXPECT_NEAR(decoded.time[i], static_cast<double>(seconds[i] - seconds[0]), kNanosecond);
  }
}

TEST(Decode, VlanTagsAndPaddingChangeNothing) {
  const Signals signals(50);
  const ScratchFile file("vlan.pcap");
  CaptureSettings settings;
  settings.esl = EslPlace::none;
  ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), signals.columns(), settings));
  const Decoded plain = decode(file.path(), learned(survey_of(file.path())));
  auto packets = packets_of(file.bytes());
  const std::vector<std::uint8_t> tags = {0x88, 0xa8, 0x00, 0x05, 0x81, 0x00, 0x60, 0x07};
  for (auto& packet : packets) {
    packet.insert(packet.begin() + 16 + 12, tags.begin(), tags.end());
    const auto size = static_cast<std::uint32_t>(packet.size() - 16);
    std::memcpy(packet.data() + 8, &size, 4);
    std::memcpy(packet.data() + 12, &size, 4);
  }
  put_packets(file, packets);
  const CaptureSurvey survey = survey_of(file.path());
  EXPECT_EQ(survey.vlan, survey.packets);
  EXPECT_EQ(decode(file.path(), learned(survey)).columns, plain.columns);
}

TEST(Decode, TruncatedFilesGiveWhatIsThere) {
  const Signals signals(40);
  const ScratchFile file("cut.pcap");
  ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), signals.columns()));
  const std::vector<std::uint8_t> whole = file.bytes();
  const Decoded all = decode(file.path(), servo_map(two_axes()));
  for (const std::size_t less : {1U, 17U, 50U, 1000U}) {
    std::vector<std::uint8_t> cut = whole;
    cut.resize(whole.size() - less);
    file.put(cut);
    const Decoded decoded = decode(file.path(), servo_map(two_axes()));
    EXPECT_TRUE(decoded.report.error);
    EXPECT_LT(decoded.report.rows, 40U);
    for (std::size_t i = 0; i < decoded.time.size(); ++i)
      ASSERT_EQ(decoded.columns.at("X.position_actual")[i], all.columns.at("X.position_actual")[i]);
  }
}

TEST(WriteCapture, WhatDoesNotFitIsNamed) {
  const ProcessMap map = servo_map(two_axes());
  const ScratchFile file("misfit.pcap");
  const std::vector<double> two = {1, 2}, three = {1, 2, 3}, huge = {1, 3e6}, nan = {1, std::nan("")};
  const auto message = [&](const std::vector<CaptureColumn>& columns, const CaptureSettings& settings = {}) {
    const auto misfit = put_capture(file.path(), map, columns, settings);
    return misfit ? misfit->code + " " + misfit->message + " " + misfit->fix : std::string();
  };
  using testing::HasSubstr;
  EXPECT_THAT(message({}), HasSubstr("no signals"));
  EXPECT_THAT(message({{"X.position_actual", two}, {"Y.position_actual", three}}), HasSubstr("has 3"));
  EXPECT_THAT(message({{"X.position_actul", two}}), HasSubstr("did you mean X.position_actual"));
  EXPECT_THAT(message({{"X.position_actual", two}, {"X.position_actual", two}}), HasSubstr("twice"));
  EXPECT_THAT(message({{"X.position_actual", huge}}), HasSubstr("sample 2 of X.position_actual"));
  EXPECT_THAT(message({{"X.position_actual", nan}}), HasSubstr("E-SIMULATE sample 2"));
  CaptureSettings slow;
  slow.cycle = 10;
  EXPECT_THAT(message({{"X.position_actual", two}}, slow), HasSubstr("cycle"));
  ProcessMap overlapping = map;
  overlapping.objects[3].bit -= 8;
  EXPECT_THAT(map_mistake(overlapping).value_or(""), HasSubstr("overlap"));
  EXPECT_FALSE(std::filesystem::exists(file.path()));
}

}  // namespace
}  // namespace abbe
