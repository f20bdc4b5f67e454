#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <random>

#include "abbe/capture/decode.h"
#include "abbe/capture/read_map.h"
#include "abbe/capture/test_captures.h"

namespace abbe {
namespace {

constexpr const char* kMap = R"(format = 1
[axis.X]
station = 1001
counts_per_mm = 10000
[axis.C]
station = 1003
counts_per_deg = -364.5
[[object]]
axis = "X"
index = 0x6064
direction = "input"
type = "int32"
address = 0x10000
[[object]]
station = 1002
index = 0x2001
subindex = 3
direction = "output"
type = "bits3"
address = 0x10004
bit = 5
name = "lamp"
)";

TEST(ReadMap, AxesAndObjects) {
  const Parsed<MapFile> parsed = read_map("m.toml", kMap);
  ASSERT_TRUE(parsed.value) << (parsed.diagnostics.empty() ? "" : to_text(parsed.diagnostics[0]));
  ASSERT_EQ(parsed.value->axes.size(), 2U);
  EXPECT_EQ(parsed.value->axes[1].counts_per_unit, -364.5);
  EXPECT_EQ(parsed.value->axes[1].unit, "deg");
  const ProcessMap map = named(parsed.value->map, parsed.value->axes);
  ASSERT_EQ(map.objects.size(), 2U);
  EXPECT_EQ(map.objects[0].name, "lamp");
  EXPECT_EQ(map.objects[0].bit, 0x10004U * 8 + 5);
  EXPECT_EQ(map.objects[0].bits, 3);
  EXPECT_EQ(map.objects[1].name, "X.position_actual");
  EXPECT_EQ(map.objects[1].scale, 1e-4);
  EXPECT_EQ(map.objects[1].unit, "mm");
}

// 0x6864 is 0x6064 of the second axis of a drive: the counts of the first one are not its counts.
TEST(Named, SecondAxesOfADriveStayInCounts) {
  ProcessMap map;
  for (const std::uint16_t index : std::array<std::uint16_t, 3>{0x6064, 0x6864, 0x7064}) {
    PdoObject object;
    object.station = 1001;
    object.index = index;
    object.bit = map.objects.size() * 32;
    map.objects.push_back(object);
  }
  const ProcessMap found = named(map, {{"X", 1001, -10000, "mm"}});
  EXPECT_EQ(found.objects[0].name, "X.position_actual");
  EXPECT_EQ(found.objects[0].scale, -1e-4);
  EXPECT_EQ(found.objects[1].name, "1001.position_actual_2");
  EXPECT_EQ(found.objects[2].name, "1001.position_actual_3");
  for (const std::size_t i : {1U, 2U}) {
    EXPECT_EQ(found.objects[i].scale, 1);
    EXPECT_EQ(found.objects[i].unit, "");
  }
}

TEST(ReadMap, MistakesAreNamed) {
  const auto codes = [](const std::string& text) {
    std::string list;
    for (const Diagnostic& d : read_map("m.toml", text).diagnostics)
      list += d.code + "@" + std::to_string(d.place.line) + " ";
    return list;
  };
  const std::string start = "format = 1\n";
  EXPECT_EQ(codes("format = 2"), "E-FORMAT@1 ");
  EXPECT_EQ(codes("format = \n"), "E-TOML@1 ");
  EXPECT_EQ(codes(start + "[axis.X]\nstation = 1001\n"), "E-MISSING-KEY@2 ");
  EXPECT_EQ(codes(start + "[axis.X]\nstation = 70000\ncounts_per_mm = 1\n"), "E-VALUE@3 ");
  EXPECT_EQ(codes(start + "[axis.X]\nstation = 1\ncounts_per_mm = 0\n"), "E-VALUE@2 ");
  EXPECT_EQ(codes(start + "[axis.X]\nstation = 1\ncounts_per_m = 5\ncounts_per_mm = 1\n"),
            "E-UNKNOWN-KEY@4 ");
  const std::string object =
      start + "[[object]]\nstation = 1\nindex = 0x6064\ndirection = \"input\"\naddress = 0\n";
  EXPECT_EQ(codes(object + "type = \"int32\"\n"), "");
  EXPECT_EQ(codes(object + "type = \"int31\"\n"), "E-VALUE@7 ");
  EXPECT_EQ(codes(object + "type = \"int32\"\nscale = 0\nunit = \"mm\"\n"), "E-VALUE@0 ");
  EXPECT_EQ(codes(object + "type = \"int32\"\nscale = 0.5\nunit = \"mm\"\n"), "");
  EXPECT_EQ(codes(object + "type = \"int32\"\nscale = 0.5\n"), "E-MISSING-KEY@2 ");
  EXPECT_EQ(codes(object + "type = \"int32\"\nunit = \"mm\"\n"), "E-MISSING-KEY@2 ");
  EXPECT_EQ(codes(object + "type = 5\n"), "E-TYPE@7 ");
  EXPECT_EQ(codes(start +
                  "[[object]]\naxis = \"X\"\nindex = 1\ndirection = \"in\"\naddress = 0\ntype = \"int8\"\n"),
            "E-VALUE@3 E-VALUE@5 ");
}

/// One slave with the given initial commands and PDOs, shortened to what counts.
std::string eni_of(const std::string& fmmu) {
  return R"(<?xml version="1.0"?><EtherCATConfig><Config><Slave><Info><Name>Drive</Name><PhysAddr>1002</PhysAddr></Info>
<ProcessData><Sm3><Pdo>6659</Pdo></Sm3>
<TxPdo Sm="3"><Index>#x1a03</Index>
<Entry><Index>#x6064</Index><SubIndex>0</SubIndex><BitLen>32</BitLen><DataType>DINT</DataType></Entry>
<Entry><Index>0</Index><BitLen>8</BitLen></Entry>
<Entry><Index>#x6041</Index><SubIndex>0</SubIndex><BitLen>16</BitLen><DataType>UINT</DataType></Entry></TxPdo>
<TxPdo><Index>#x1a00</Index><Entry><Index>#x6041</Index><SubIndex>0</SubIndex><BitLen>16</BitLen></Entry></TxPdo></ProcessData>
<InitCmds><InitCmd><Transition>PS</Transition><Cmd>5</Cmd><Adp>1002</Adp><Ado>2072</Ado><Data>8011070020000100</Data></InitCmd>
<InitCmd><Transition>PS</Transition><Cmd>5</Cmd><Adp>1002</Adp><Ado>1552</Ado><Data>)" +
         fmmu + R"(</Data></InitCmd>
<InitCmd><Transition>SP</Transition><Cmd>5</Cmd><Adp>1002</Adp><Ado>1552</Ado><Data>00000000000000000000000000000000</Data></InitCmd>
</InitCmds></Slave></Config></EtherCATConfig>)";
}

TEST(MapOf, NonsenseInRegistersStaysSmall) {
  std::vector<SlaveSetup> slaves(500);
  for (std::size_t s = 0; s < slaves.size(); ++s) {
    slaves[s].station = static_cast<std::uint16_t>(s + 1);
    // Sync manager 0: 1000 bytes from 0x1000 on. Every FMMU: 65535 bytes of it, as inputs.
    set_registers(slaves[s], 0x0800, std::vector<std::uint8_t>{0x00, 0x10, 0xe8, 0x03, 0x20, 0, 1, 0});
    for (std::uint16_t k = 0; k < 16; ++k) {
      const std::vector<std::uint8_t> fmmu = {
          0, 0, static_cast<std::uint8_t>(k), static_cast<std::uint8_t>(s), 0xff, 0xff, 0, 7, 0x00, 0x10, 0,
          1, 1};
      set_registers(slaves[s], static_cast<std::uint16_t>(0x0600 + 16 * k), fmmu);
    }
  }
  Diagnostics findings;
  EXPECT_LE(map_of(slaves, findings).objects.size(), 65536U);
  ASSERT_EQ(findings.size(), 1U);
  EXPECT_EQ(findings[0].code, "W-CAPTURE-MAP");
}

TEST(ReadEni, ObjectsStandWhereFmmusPutThem) {
  const Parsed<ProcessMap> parsed = read_eni("m.xml", eni_of("00080001070000078011000101000000"));
  ASSERT_TRUE(parsed.value) << (parsed.diagnostics.empty() ? "" : to_text(parsed.diagnostics[0]));
  const ProcessMap map = named(*parsed.value, {});
  ASSERT_EQ(map.objects.size(), 2U);
  EXPECT_EQ(map.objects[0].name, "1002.position_actual");
  EXPECT_EQ(map.objects[0].bit, 0x01000800U * 8);
  EXPECT_EQ(map.objects[1].name, "1002.statusword");
  EXPECT_EQ(map.objects[1].bit, 0x01000800U * 8 + 40);
  EXPECT_EQ(map.objects[1].direction, PdoDirection::input);
}

TEST(ReadEni, PartlyMappedObjectsAreLeftOut) {
  // The range ends inside the status word.
  const Parsed<ProcessMap> parsed = read_eni("m.xml", eni_of("00080001060000078011000101000000"));
  ASSERT_TRUE(parsed.value);
  EXPECT_EQ(parsed.value->objects.size(), 1U);
  ASSERT_EQ(parsed.diagnostics.size(), 1U);
  EXPECT_EQ(parsed.diagnostics[0].code, "W-CAPTURE-MAP");
}

TEST(ReadEni, MistakesAreNamed) {
  const auto message = [](const std::string& text) {
    const Parsed<ProcessMap> parsed = read_eni("m.xml", text);
    EXPECT_FALSE(parsed.value);
    return parsed.diagnostics.empty() ? std::string() : to_text(parsed.diagnostics[0]);
  };
  EXPECT_THAT(message("<a>\n<b></a>"), testing::HasSubstr("m.xml:2:"));
  EXPECT_THAT(message(""), testing::HasSubstr("E-ENI"));
  EXPECT_THAT(message("<EtherCATInfo/>"), testing::HasSubstr("no ENI"));
  EXPECT_THAT(message(eni_of("00000000000000000000000000000000")), testing::HasSubstr("no FMMU"));
  std::string nameless = eni_of("00");
  nameless.replace(nameless.find("<PhysAddr>1002"), 14, "<PhysAddr>99999");
  EXPECT_THAT(message(nameless), testing::HasSubstr("station address"));
}

// Facts of an ENI of four drives and an inertial sensor, as another reader's tests state them.
TEST(ReadEni, FourDrivesOfARealMachine) {
  std::ifstream file(ABBE_SOURCE_DIR "/../shared/data/ethercat/eni-4-elmo-drives.xml");
  if (!file) GTEST_SKIP() << "no ../shared/data/ethercat";
  const std::string text(std::istreambuf_iterator<char>(file), {});
  const Parsed<ProcessMap> parsed = read_eni("elmo.xml", text);
  ASSERT_TRUE(parsed.value);
  const ProcessMap map = named(*parsed.value, {});
  const auto find = [&](const std::string& name) {
    for (const PdoObject& o : map.objects)
      if (o.name == name) return o;
    ADD_FAILURE() << name;
    return PdoObject{};
  };
  EXPECT_EQ(map.objects.size(), 7U + 4 * 4 + 4 * 2);
  // The image of the second drive begins 14 bytes behind that of the first; inputs lie over outputs.
  EXPECT_EQ(find("1002.position_actual").bit, 16779264U * 8);
  EXPECT_EQ(find("1003.position_actual").bit, (16779264U + 14) * 8);
  EXPECT_EQ(find("1003.target_velocity").bit, (16779264U + 14) * 8);
  EXPECT_EQ(find("1002.statusword").bit, 16779264U * 8 + 96);
  EXPECT_EQ(find("1001.2065:00").bit, 16777216U * 8);

  const std::vector<double> position = {5, -7, 2e9}, speed = {-1, 2, -3}, inertial = {-100, 100, 0};
  const ScratchFile capture("elmo.pcap");
  ASSERT_FALSE(put_capture(
      capture.path(), map,
      {{"1005.position_actual", position}, {"1005.target_velocity", speed}, {"1001.2065:00", inertial}}));
  const auto survey = std::get<CaptureSurvey>(survey_capture(capture.path()));
  Diagnostics findings;
  const ProcessMap learned = named(map_of(survey.slaves, findings), {});
  ASSERT_EQ(learned.objects.size(), map.objects.size());
  for (std::size_t i = 0; i < map.objects.size(); ++i) {
    EXPECT_EQ(learned.objects[i].name, map.objects[i].name);
    EXPECT_EQ(learned.objects[i].bit, map.objects[i].bit);
  }
  const DecodePlan plan = plan_columns(map, survey);
  EXPECT_TRUE(plan.missing.empty());
  const auto decoded = decode_capture(capture.path(), plan, survey, {}, [&](const ColumnBlock& block) {
    for (std::size_t c = 0; c < plan.columns.size(); ++c) {
      const auto values = std::vector<double>(block.columns[c].begin(), block.columns[c].end());
      if (plan.columns[c].name == "1005.position_actual") {
        EXPECT_EQ(values, position);
      }
      if (plan.columns[c].name == "1005.target_velocity") {
        EXPECT_EQ(values, speed);
      }
      if (plan.columns[c].name == "1001.2065:00") {
        EXPECT_EQ(values, inertial);
      }
    }
    return true;
  });
  EXPECT_EQ(std::get<DecodeReport>(decoded).rows, 3U);
}

// A real servo drive asked for its objects by another master: 1600 = {6040}, 1601 = {6040, 6060}, 1602 =
// {6040, 607A}, 1603 = {6040, 60FF}; 1A00 = {6041}, 1A01 = {6041, 6061}, 1A02 = {6041, 6064}, 1A03 = {6041,
// 606C}.
TEST(Learn, RealDriveTellsItsMap) {
  const std::string path = ABBE_SOURCE_DIR "/../shared/data/ethercat/soem-sdinfo-akd-servo.pcapng";
  const auto surveyed = survey_capture(path);
  const auto* survey = std::get_if<CaptureSurvey>(&surveyed);
  if (survey == nullptr) GTEST_SKIP() << "no ../shared/data/ethercat";
  Diagnostics findings;
  const ProcessMap map = named(map_of(survey->slaves, findings), {{"X", 4097, 1, "mm"}});
  std::vector<std::pair<std::uint16_t, std::uint16_t>> entries;
  for (const PdoObject& o : map.objects) entries.emplace_back(o.pdo, o.index);
  using E = std::pair<std::uint16_t, std::uint16_t>;
  EXPECT_THAT(entries,
              testing::ElementsAre(E{0x1600, 0x6040}, E{0x1601, 0x6040}, E{0x1601, 0x6060}, E{0x1602, 0x6040},
                                   E{0x1602, 0x607A}, E{0x1603, 0x6040}, E{0x1603, 0x60FF}, E{0x1A00, 0x6041},
                                   E{0x1A01, 0x6041}, E{0x1A01, 0x6061}, E{0x1A02, 0x6041}, E{0x1A02, 0x6064},
                                   E{0x1A03, 0x6041}, E{0x1A03, 0x606C}));
  EXPECT_EQ(map.objects[11].name, "X.position_actual");
  EXPECT_EQ(map.objects[11].bit, 0x18U * 8);
  EXPECT_EQ(survey->states.at(4097), 2);
}

/// Changes a few bytes, cuts, doubles a piece.
template <class Text>
Text mutated(Text text, std::mt19937& random) {
  const int kind = static_cast<int>(random() % 4);
  for (int i = 0; i < 1 + static_cast<int>(random() % 6) && !text.empty(); ++i) {
    const std::size_t at = random() % text.size();
    const auto other = text[random() % text.size()];
    text[at] = random() % 3 == 0 ? static_cast<typename Text::value_type>(random() % 256) : other;
  }
  if (kind == 0 && !text.empty()) text.resize(random() % text.size());
  return text;
}

TEST(Readers, MutatedMapsAndEnisGiveAValueOrAnError) {
  std::mt19937 random(11);
  const std::string eni = eni_of("00080001070000078011000101000000");
  for (int run = 0; run < 3000; ++run) {
    const Parsed<MapFile> map = read_map("m", mutated(std::string(kMap), random));
    ASSERT_NE(map.value.has_value(), has_errors(map.diagnostics));
    const Parsed<ProcessMap> process = read_eni("m", mutated(eni, random));
    ASSERT_NE(process.value.has_value(), has_errors(process.diagnostics));
    if (process.value) {
      ASSERT_FALSE(map_mistake(*process.value));
    }
  }
}

std::string blocks_of(std::initializer_list<std::uint32_t> words) {
  std::string bytes(words.size() * 4, ' ');
  std::memcpy(bytes.data(), words.begin(), bytes.size());
  return bytes;
}

/// A pcapng file with two packets of Ethernet, whose times count seconds since 1970.
std::vector<std::uint8_t> pcapng_at(std::uint64_t first, std::uint64_t second) {
  std::string file = blocks_of({0x0A0D0D0A, 28, 0x1A2B3C4D, 1, 0xFFFFFFFF, 0xFFFFFFFF, 28});
  file += blocks_of({1, 32, 1, 65535, 0x00010009, 0, 0, 32});  // if_tsresol = 0: seconds
  for (const std::uint64_t t : {first, second})
    file += blocks_of({6, 48, 0, static_cast<std::uint32_t>(t >> 32), static_cast<std::uint32_t>(t), 16, 16,
                       0, 0, 0, 0, 48});
  return {file.begin(), file.end()};
}

TEST(Survey, TimesOfNoAgeEndTheFile) {
  const ScratchFile file("times.pcapng");
  const auto survey = [&](std::uint64_t second) {
    file.put(pcapng_at(1'600'000'000, second));
    return std::get<CaptureSurvey>(survey_capture(file.path()));
  };
  const CaptureSurvey good = survey(1'600'000'007);
  EXPECT_FALSE(good.error);
  EXPECT_EQ(good.last_ns - good.first_ns, 7'000'000'000);
  for (const std::uint64_t second :
       {~std::uint64_t{0}, std::uint64_t{1} << 63, std::uint64_t{1} << 62, std::uint64_t{4'700'000'000}}) {
    const CaptureSurvey bad = survey(second);
    EXPECT_EQ(bad.packets, 1U) << second;
    ASSERT_TRUE(bad.error) << second;
    EXPECT_THAT(*bad.error, testing::HasSubstr("damaged"));
  }
}

TEST(Survey, ClocksOfNoAgeAreNone) {
  std::array<std::uint8_t, 8> bytes{};
  Datagram d;
  d.command = EcatCommand::frmw;
  d.address = 0x09100000 + 1001;
  d.working_counter = 1;
  d.data = bytes;
  BusFrame frame;
  frame.datagrams = {&d, 1};
  bytes[7] = 0x3f;
  EXPECT_TRUE(clock_of(frame));
  bytes[7] = 0x41;
  EXPECT_FALSE(clock_of(frame));
  EslInfo esl;
  EXPECT_FALSE(time_of(esl));
  esl.timestamp_ns = 5;
  EXPECT_EQ(time_of(esl), 5);
  esl.timestamp_ns = ~std::uint64_t{0};
  EXPECT_FALSE(time_of(esl));
}

TEST(Readers, MutatedCapturesNeverGiveNumbersThatAreNone) {
  std::vector<double> x;
  for (int i = 0; i < 12; ++i) x.push_back(i);
  const ScratchFile file("mutated.pcap");
  ASSERT_FALSE(put_capture(file.path(), servo_map(two_axes()), {{"X.position_actual", x}}));
  const std::vector<std::uint8_t> whole = file.bytes();
  std::mt19937 random(12);
  for (int run = 0; run < 500; ++run) {
    file.put(mutated(whole, random));
    const auto surveyed = survey_capture(file.path());
    const auto* survey = std::get_if<CaptureSurvey>(&surveyed);
    if (survey == nullptr) continue;
    Diagnostics findings;
    const ProcessMap map = named(map_of(survey->slaves, findings), two_axes());
    if (map_mistake(map)) continue;
    const DecodePlan plan = plan_columns(map, *survey);
    DecodeOptions options;
    options.base = best_time_base(*survey);
    const auto decoded = decode_capture(file.path(), plan, *survey, options, [](const ColumnBlock& block) {
      for (const auto& column : block.columns)
        for (const double value : column) EXPECT_TRUE(std::isfinite(value));
      for (const double t : block.time) EXPECT_TRUE(std::isfinite(t));
      return true;
    });
    ASSERT_TRUE(std::holds_alternative<DecodeReport>(decoded));
  }
}

}  // namespace
}  // namespace abbe
