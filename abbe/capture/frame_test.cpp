#include "abbe/capture/frame.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "abbe/capture/bits.h"
#include "abbe/capture/coe.h"
#include "abbe/capture/field.h"

namespace abbe {
namespace {

using Bytes = std::vector<std::uint8_t>;

/// A BRD of two bytes and an LRW of four in one frame.
Bytes two_datagrams() {
  return {0x01, 0x01, 0x05, 0x01, 0x00, 0x00, 0x02, 0x1b, 0x21, 0xab, 0xbe, 0x00, 0x88, 0xa4,  // Ethernet
          0x1e, 0x10,  // 30 bytes, type 1
          0x07, 0x33, 0x05, 0x00, 0x30, 0x01, 0x02, 0x80, 0x00, 0x00, 0x08, 0x00, 0x05, 0x00,  // BRD 0x0130
          0x0c, 0x34, 0x00, 0x00, 0x01, 0x00, 0x04, 0x40, 0x11, 0x22, 0x78, 0x56, 0x34, 0x12, 0x03, 0x00};
}

TEST(ParseFrame, DatagramsAreThoseOfTheBytes) {
  const Bytes packet = two_datagrams();
  const EcatFrame frame = parse_frame(packet);
  ASSERT_EQ(frame.kind, EcatFrame::Kind::datagrams);
  EXPECT_EQ(frame.source, 0x021b21abbe00U);
  DatagramReader reader(frame.body);
  Datagram d;
  ASSERT_TRUE(reader.next(d));
  EXPECT_EQ(d.command, EcatCommand::brd);
  EXPECT_EQ(d.index, 0x33);
  EXPECT_EQ(d.station(), 5);
  EXPECT_EQ(d.offset(), 0x0130);
  EXPECT_EQ(d.working_counter, 5);
  EXPECT_FALSE(d.circulating);
  ASSERT_TRUE(reader.next(d));
  EXPECT_TRUE(d.logical());
  EXPECT_EQ(d.address, 0x10000U);
  EXPECT_TRUE(d.circulating);
  EXPECT_EQ(d.interrupt, 0x2211);
  EXPECT_EQ(load_little<std::uint32_t>(d.data.data()), 0x12345678U);
  EXPECT_EQ(d.working_counter, 3);
  EXPECT_FALSE(reader.next(d));
  EXPECT_FALSE(reader.bad());
}

TEST(ParseFrame, SwitchLinkIsReadBeforeAndBehind) {
  // Port 9 (bit 14), timestamp valid (13), alignment error (11).
  const Bytes esl = {0x01, 0x01, 0x05, 0x10, 0x00, 0x00, 0x00, 0x68, 0x15, 0xcd, 0x5b, 0x07, 0, 0, 0, 0};
  for (const bool before : {true, false}) {
    Bytes packet = two_datagrams();
    packet.insert(before ? packet.begin() : packet.end(), esl.begin(), esl.end());
    const EcatFrame frame = parse_frame(packet);
    ASSERT_TRUE(frame.esl) << before;
    EXPECT_EQ(frame.esl->port, 9);
    EXPECT_TRUE(frame.esl->alignment_error);
    EXPECT_FALSE(frame.esl->crc_error);
    EXPECT_EQ(frame.esl->timestamp_ns, 123456789U);
    EXPECT_EQ(frame.kind, EcatFrame::Kind::datagrams);
    EXPECT_EQ(frame.body.size(), 30U);
    // A packet that the recorder cut has no end to look at.
    EXPECT_EQ(parse_frame(packet, false).esl.has_value(), before);
  }
}

TEST(ParseFrame, UdpIsLookedThrough) {
  Bytes packet = two_datagrams();
  const Bytes ip = {0x45, 0,    0,    60,   0, 0,  0, 0, 64, 17, 0, 0, 10, 0, 0, 1, 10, 0, 0, 2,  // IPv4, UDP
                    0x12, 0x34, 0x88, 0xa4, 0, 40, 0, 0};
  packet[12] = 0x08;
  packet[13] = 0x00;
  packet.insert(packet.begin() + 14, ip.begin(), ip.end());
  const EcatFrame frame = parse_frame(packet);
  EXPECT_TRUE(frame.udp);
  EXPECT_EQ(frame.body.size(), 30U);
  packet[14 + 22] = 0x12;  // another port
  EXPECT_EQ(parse_frame(packet).kind, EcatFrame::Kind::other);
}

TEST(ParseFrame, NonsenseLengthsAreBad) {
  Bytes packet = two_datagrams();
  packet[14] = 0x1f;
  EXPECT_EQ(parse_frame(packet).kind, EcatFrame::Kind::bad);
  packet[14] = 0x1d;  // one byte too few for the second datagram
  const EcatFrame frame = parse_frame(packet);
  DatagramReader reader(frame.body);
  Datagram d;
  EXPECT_TRUE(reader.next(d));
  EXPECT_FALSE(reader.next(d));
  EXPECT_TRUE(reader.bad());
  packet[15] = 0x40;
  EXPECT_EQ(parse_frame(packet).kind, EcatFrame::Kind::other_ethercat);
  for (std::size_t size = 0; size < packet.size(); ++size)
    EXPECT_NE(parse_frame(std::span(packet).first(size)).kind, EcatFrame::Kind::datagrams);
}

TEST(Bits, StoredBitsAreLoaded) {
  std::mt19937_64 random(1);
  for (int run = 0; run < 2000; ++run) {
    Bytes bytes(20), before;
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random());
    before = bytes;
    const int bits = 1 + static_cast<int>(random() % 64);
    const std::size_t at = random() % 90;
    const std::uint64_t value = random() & (~std::uint64_t{0} >> (64 - bits));
    store_bits(bytes, at, bits, value);
    EXPECT_EQ(load_bits(bytes, at, bits), value);
    for (std::size_t k = 0; k < 160; ++k) {
      if (k >= at && k < at + static_cast<std::size_t>(bits)) continue;
      ASSERT_EQ(bytes[k / 8] >> (k % 8) & 1, before[k / 8] >> (k % 8) & 1) << k;
    }
  }
  EXPECT_EQ(sign_extended(0xfff, 12), -1);
  EXPECT_EQ(sign_extended(0x7ff, 12), 2047);
  EXPECT_EQ(sign_extended(~std::uint64_t{0}, 64), -1);
}

/// A mailbox with a CoE SDO message in it.
Bytes mailbox(int service, const Bytes& sdo, std::size_t size = 64) {
  Bytes m = {static_cast<std::uint8_t>(sdo.size() + 2), 0, 0, 0, 0, 0x13, 0,
             static_cast<std::uint8_t>(service << 4)};
  m.insert(m.end(), sdo.begin(), sdo.end());
  m.resize(std::max(size, m.size()));
  return m;
}

TEST(SdoListener, ExpeditedDownloadCountsOnceConfirmed) {
  SdoListener listener;
  EXPECT_FALSE(listener.hear(7, mailbox(2, {0x2b, 0x12, 0x1c, 1, 0x00, 0x16, 0, 0})));
  const auto value = listener.hear(7, mailbox(3, {0x60, 0x12, 0x1c, 1, 0, 0, 0, 0}));
  ASSERT_TRUE(value);
  EXPECT_EQ(value->index, 0x1c12);
  EXPECT_EQ(value->subindex, 1);
  EXPECT_TRUE(value->download);
  EXPECT_THAT(value->data, testing::ElementsAre(0x00, 0x16));
  EXPECT_FALSE(listener.hear(7, mailbox(3, {0x60, 0x12, 0x1c, 1, 0, 0, 0, 0})));
}

TEST(SdoListener, AbortedTransfersDoNotCount) {
  SdoListener listener;
  EXPECT_FALSE(listener.hear(7, mailbox(2, {0x23, 0x00, 0x16, 1, 0x20, 0, 0x64, 0x60})));
  EXPECT_FALSE(listener.hear(7, mailbox(2, {0x80, 0x00, 0x16, 1, 0, 0, 2, 6})));
  EXPECT_FALSE(listener.hear(7, mailbox(3, {0x60, 0x00, 0x16, 1, 0, 0, 0, 0})));
  EXPECT_EQ(listener.aborted(), 1U);
}

TEST(SdoListener, SegmentedUploadIsPutTogether) {
  SdoListener listener;
  EXPECT_FALSE(listener.hear(1, mailbox(2, {0x40, 0x08, 0x10, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(listener.hear(1, mailbox(3, {0x41, 0x08, 0x10, 0, 12, 0, 0, 0, 'a', 'b', 'c'})));
  EXPECT_FALSE(listener.hear(1, mailbox(2, {0x60, 0, 0, 0, 0, 0, 0, 0})));
  EXPECT_FALSE(listener.hear(1, mailbox(3, {0x00, 'd', 'e', 'f', 'g', 'h', 'i', 'j'})));
  // The last segment is shorter than seven bytes: five are not used.
  const auto value = listener.hear(1, mailbox(3, {0x1b, 'k', 'l', 0, 0, 0, 0, 0}));
  ASSERT_TRUE(value);
  EXPECT_EQ(std::string(value->data.begin(), value->data.end()), "abcdefghijkl");
  EXPECT_FALSE(value->download);
}

TEST(SdoListener, AnyBytesAreSafe) {
  SdoListener listener;
  std::mt19937 random(3);
  for (int run = 0; run < 20000; ++run) {
    Bytes bytes(random() % 40);
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random() % 3 == 0 ? random() % 256 : random() % 8);
    if (bytes.size() > 8) {
      bytes[0] = static_cast<std::uint8_t>(bytes.size() - 6);
      bytes[1] = 0;
      bytes[5] = 3;
      bytes[7] = static_cast<std::uint8_t>(0x20 + 0x10 * (random() % 2));
    }
    static_cast<void>(listener.hear(static_cast<std::uint16_t>(random() % 3), bytes));
  }
}

TEST(Field, RealNumbersThatAreNoneReadAsZero) {
  PdoObject object;
  object.type = PdoType::real;
  const Bytes nan = {0, 0, 0xc0, 0x7f}, inf = {0, 0, 0x80, 0xff}, half = {0, 0, 0, 0x3f};
  double value = -1;
  const Field field = make_field(object, 0, &value);
  const auto read = [&](const Bytes& bytes) {
    read_fields({&field, 1}, bytes, 0);
    return value;
  };
  EXPECT_EQ(read(nan), 0);
  EXPECT_EQ(read(inf), 0);
  EXPECT_EQ(read(half), 0.5);
}

}  // namespace
}  // namespace abbe
