#include "abbe/capture/packet_source.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <pcap/pcap.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>
#include <utility>
#include <vector>

namespace abbe {
namespace {

constexpr std::size_t kPiece = std::size_t{1} << 17;  ///< stays in the caches
constexpr std::size_t kFileHeader = 24, kPacketHeader = 16;
constexpr std::uint32_t kMicroseconds = 0xa1b2c3d4, kNanoseconds = 0xa1b23c4d;
constexpr std::uint32_t kEthernet = 1;
constexpr std::int64_t kSecond = 1'000'000'000;

std::uint32_t swapped(std::uint32_t v) { return __builtin_bswap32(v); }

std::uint32_t load32(const std::uint8_t* p) {
  std::uint32_t v = 0;
  std::memcpy(&v, p, sizeof v);
  return v;
}

/// A file descriptor that closes itself.
class Descriptor {
 public:
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() {
    if (fd_ >= 0) ::close(fd_);
  }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

/// A classic pcap file: 24 bytes of header, then 16 bytes before each packet, in the writer's byte order.
class ClassicFile {
 public:
  ClassicFile(Descriptor fd, bool swap, std::int64_t fraction)
      : fd_(std::move(fd)), swap_(swap), fraction_(fraction), buffer_(kPiece) {}

  /// 1: a packet, 0: the end, -1: see `error`.
  int next(Packet& packet, std::string& error) {
    if (!have(kPacketHeader)) return broken(error);
    const std::uint8_t* p = buffer_.data() + at_;
    const std::uint32_t captured = word(p + 8);
    if (captured > kMostPacket) {
      error = fmt::format("a packet of {} bytes: the file is damaged here", captured);
      return -1;
    }
    if (!have(kPacketHeader + captured)) return broken(error);
    p = buffer_.data() + at_;
    packet.time_ns = std::int64_t{word(p)} * kSecond + std::int64_t{word(p + 4)} * fraction_;
    packet.original = word(p + 12);
    packet.bytes = {p + kPacketHeader, captured};
    at_ += kPacketHeader + captured;
    return 1;
  }

 private:
  [[nodiscard]] std::uint32_t word(const std::uint8_t* p) const {
    return swap_ ? swapped(load32(p)) : load32(p);
  }

  /// True once `size` bytes lie behind at_.
  bool have(std::size_t size) { return size <= filled_ - at_ || refill(size); }

  bool refill(std::size_t size) {
    std::memmove(buffer_.data(), buffer_.data() + at_, filled_ - at_);
    filled_ -= at_;
    at_ = 0;
    if (buffer_.size() < size) buffer_.resize(size);
    while (filled_ < size) {
      const ssize_t got = ::read(fd_.get(), buffer_.data() + filled_, buffer_.size() - filled_);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) failed_ = errno;
      if (got <= 0) return false;
      filled_ += static_cast<std::size_t>(got);
    }
    return true;
  }

  int broken(std::string& error) const {
    if (failed_ != 0) {
      error = std::generic_category().message(failed_);
      return -1;
    }
    if (filled_ == at_) return 0;
    error = "the file ends inside a packet";
    return -1;
  }

  Descriptor fd_;
  bool swap_;
  std::int64_t fraction_;
  std::vector<std::uint8_t> buffer_;
  std::size_t at_ = 0, filled_ = 0;
  int failed_ = 0;
};

struct PcapCloser {
  void operator()(pcap_t* p) const { pcap_close(p); }
};
using PcapHandle = std::unique_ptr<pcap_t, PcapCloser>;

int next_of_libpcap(pcap_t* handle, Packet& packet, std::string& error) {
  pcap_pkthdr* header = nullptr;
  const u_char* data = nullptr;
  const int got = pcap_next_ex(handle, &header, &data);
  if (got == PCAP_ERROR_BREAK) return 0;
  if (got != 1) {
    error = pcap_geterr(handle);
    return -1;
  }
  const std::int64_t seconds{header->ts.tv_sec};
  if (seconds < 0 || seconds >= kLatestTime / kSecond) {
    error = fmt::format("a packet {} s after 1970: the file is damaged here", seconds);
    return -1;
  }
  // With PCAP_TSTAMP_PRECISION_NANO tv_usec counts nanoseconds.
  packet.time_ns = seconds * kSecond + std::int64_t{header->ts.tv_usec};
  packet.original = header->len;
  packet.bytes = {data, header->caplen};
  return 1;
}

FileError cannot(const std::string& path, std::string_view why, bool unsuitable = true) {
  FileError error;
  error.message = fmt::format("{}: {}", path, why);
  error.unsuitable = unsuitable;
  return error;
}

std::string wrong_link(const char* name) {
  return fmt::format(
      "link type {}: EtherCAT captures are recorded from an Ethernet adapter (link type EN10MB)", name);
}

}  // namespace

struct PacketSource::State {
  std::unique_ptr<ClassicFile> classic;
  PcapHandle pcap;
  std::uint64_t packets = 0, bytes = 0;
  bool ended = false;
  std::string message;  ///< why the last packet could not be read
  std::optional<std::string> error;
};

PacketSource::PacketSource() : state_(std::make_unique<State>()) {}
PacketSource::~PacketSource() = default;
PacketSource::PacketSource(PacketSource&&) noexcept = default;
PacketSource& PacketSource::operator=(PacketSource&&) noexcept = default;

FileResult<PacketSource> PacketSource::open(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) {
    FileError error = cannot(path, std::generic_category().message(errno), errno == EACCES);
    error.missing = errno == ENOENT || errno == ENOTDIR;
    return error;
  }
  Descriptor file(fd);
  struct stat status {};
  if (::fstat(fd, &status) == 0 && S_ISDIR(status.st_mode)) return cannot(path, "is a directory");
  std::array<std::uint8_t, kFileHeader> header{};
  const ssize_t got = ::pread(fd, header.data(), header.size(), 0);
  const std::uint32_t magic = load32(header.data());
  const bool swap = magic == swapped(kMicroseconds) || magic == swapped(kNanoseconds);
  const std::uint32_t plain = swap ? swapped(magic) : magic;
  const std::uint32_t link = swap ? swapped(load32(header.data() + 20)) : load32(header.data() + 20);

  PacketSource source;
  // The upper bits of the link type say how long a frame check sequence is; libpcap deals with those.
  if (got == static_cast<ssize_t>(kFileHeader) && (plain == kMicroseconds || plain == kNanoseconds) &&
      link == kEthernet) {
    if (::lseek(file.get(), kFileHeader, SEEK_SET) < 0)
      return cannot(path, std::generic_category().message(errno), false);
    source.state_->classic =
        std::make_unique<ClassicFile>(std::move(file), swap, plain == kNanoseconds ? 1 : 1000);
    return source;
  }
  char why[PCAP_ERRBUF_SIZE] = {};
  source.state_->pcap.reset(
      pcap_open_offline_with_tstamp_precision(path.c_str(), PCAP_TSTAMP_PRECISION_NANO, why));
  if (!source.state_->pcap) return cannot(path, why);
  const int type = pcap_datalink(source.state_->pcap.get());
  if (type != DLT_EN10MB) {
    const char* name = pcap_datalink_val_to_name(type);
    return cannot(path, wrong_link(name != nullptr ? name : "unknown"));
  }
  return source;
}

bool PacketSource::next(Packet& packet) {
  State& s = *state_;
  if (s.ended) return false;
  const int got =
      s.classic ? s.classic->next(packet, s.message) : next_of_libpcap(s.pcap.get(), packet, s.message);
  if (got == 1) {
    ++s.packets;
    s.bytes += kPacketHeader + packet.bytes.size();
    return true;
  }
  s.ended = true;
  if (got < 0) s.error = fmt::format("packet {}: {}", s.packets + 1, s.message);
  return false;
}

const std::optional<std::string>& PacketSource::error() const { return state_->error; }
std::uint64_t PacketSource::packets() const { return state_->packets; }
std::uint64_t PacketSource::bytes() const { return state_->bytes; }

}  // namespace abbe
