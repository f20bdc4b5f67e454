#include "abbe/core/file.h"

#include <fcntl.h>
#include <fmt/core.h>
#include <poll.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>
#ifdef __SSE2__
#include <emmintrin.h>
#endif

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <system_error>
#include <vector>

#include "abbe/core/file_growth.h"

namespace abbe {
namespace {

constexpr std::size_t kBuffer = std::size_t{1} << 18;
constexpr int kAttempts = 100;  // at a name for a temporary file that nobody uses yet

// A file descriptor that is closed with this object.
class Descriptor {
 public:
  Descriptor() = default;
  explicit Descriptor(int fd) : fd_(fd) {}
  ~Descriptor() { static_cast<void>(close()); }
  Descriptor(Descriptor&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Descriptor& operator=(Descriptor&& other) noexcept {
    std::swap(fd_, other.fd_);
    return *this;
  }
  [[nodiscard]] int get() const { return fd_; }
  [[nodiscard]] bool close() {  // not repeated after EINTR: on Linux the descriptor is gone
    const int fd = std::exchange(fd_, -1);
    return fd < 0 || ::close(fd) == 0 || errno == EINTR;
  }

 private:
  int fd_ = -1;
};

FileError failure(const std::string& path, int code) {
  FileError error;
  error.message = fmt::format("{}: {}", path.empty() ? "''" : path, std::generic_category().message(code));
  error.missing = code == ENOENT || code == ENOTDIR;
  error.unsuitable =
      code == EISDIR || code == EACCES || code == EPERM || code == ELOOP || code == ENAMETOOLONG;
  return error;
}

FileError unsuitable(const std::string& path, std::string_view what) {
  return {fmt::format("{}: {}", path, what), false, true};
}

int open_retry(const char* path, int flags, mode_t mode = 0) {
  int fd = -1;
  do {
    fd = ::open(path, flags | O_CLOEXEC | O_NOCTTY, mode);
  } while (fd < 0 && errno == EINTR);
  return fd;
}

void wait_for(int fd, short events) {
  pollfd waiting{fd, events, 0};
  static_cast<void>(::poll(&waiting, 1, -1));
}

// Up to `size` bytes; 0 at the end, -1 with errno after an error.
ssize_t read_some(int fd, char* to, std::size_t size) {
  for (;;) {
    const ssize_t got = ::read(fd, to, size);
    if (got >= 0) return got;
    if (errno == EAGAIN || errno == EWOULDBLOCK) {
      wait_for(fd, POLLIN);
    } else if (errno != EINTR) {
      return -1;
    }
  }
}

bool write_all(int fd, const char* bytes, std::size_t size) {
  while (size > 0) {
    const ssize_t put = ::write(fd, bytes, size);
    if (put > 0) {
      bytes += put;
      size -= static_cast<std::size_t>(put);
    } else if (put == 0) {
      errno = EIO;
      return false;
    } else if (errno == EAGAIN || errno == EWOULDBLOCK) {
      wait_for(fd, POLLOUT);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

bool sync_to_disk(int fd) {
  int result = 0;
  do {
    result = ::fsync(fd);
  } while (result != 0 && errno == EINTR);
  return result == 0 || errno == EINVAL || errno == ENOTSUP;  // some file systems cannot
}

FileIdentity identity_from(const struct stat& status) {
  return {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino),
          static_cast<std::uint64_t>(status.st_size),
          static_cast<std::int64_t>(status.st_mtim.tv_sec) * 1'000'000'000 + status.st_mtim.tv_nsec};
}

// A new file that only we have: `folder`/`stem`-XXXXXX. Its name comes back in `path`.
Descriptor create_unique(const std::string& stem, mode_t mode, std::string& path) {
  static constexpr std::string_view kLetters = "abcdefghijklmnopqrstuvwxyz0123456789";
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    std::array<unsigned char, 6> random{};
    if (::getrandom(random.data(), random.size(), 0) != static_cast<ssize_t>(random.size())) continue;
    path = stem + '-';
    for (const unsigned char r : random) path += kLetters[r % kLetters.size()];
    const int fd = open_retry(path.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW, mode);
    if (fd >= 0 || errno != EEXIST) return Descriptor(fd);
  }
  errno = EEXIST;
  return {};
}

std::string temporary_folder() {
  const char* const named = std::getenv("TMPDIR");
  return named != nullptr && *named != '\0' ? named : "/tmp";
}

std::string folder_of(const std::string& path) {
  const std::size_t slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

std::size_t line_feeds(const char* p, const char* const end) {
  std::size_t count = 0;
#ifdef __SSE2__
  const __m128i feeds = _mm_set1_epi8('\n'), zero = _mm_setzero_si128();
  while (end - p >= 16) {
    // a lane counts to 255 at most
    const char* const stop = p + std::min<std::ptrdiff_t>(end - p, 255 * 16) / 16 * 16;
    __m128i lanes = zero;
    for (; p != stop; p += 16)
      lanes =
          _mm_sub_epi8(lanes, _mm_cmpeq_epi8(_mm_loadu_si128(reinterpret_cast<const __m128i*>(p)), feeds));
    const __m128i sums = _mm_sad_epu8(lanes, zero);
    count += static_cast<std::size_t>(_mm_cvtsi128_si64(sums)) +
             static_cast<std::size_t>(_mm_cvtsi128_si64(_mm_unpackhi_epi64(sums, sums)));
  }
#endif
  return count + static_cast<std::size_t>(std::count(p, end, '\n'));
}

}  // namespace

FileResult<std::string> read_file(const std::string& path, std::size_t limit) {
  const Descriptor file(open_retry(path.c_str(), O_RDONLY));
  if (file.get() < 0) return failure(path, errno);
  struct stat status {};
  if (::fstat(file.get(), &status) != 0) return failure(path, errno);
  if (S_ISDIR(status.st_mode)) return failure(path, EISDIR);
  const std::string too_large = fmt::format("larger than {} bytes, the most that is read at once", limit);
  const auto expected = static_cast<std::uint64_t>(std::max<off_t>(status.st_size, 0));
  if (expected > limit) return unsuitable(path, too_large);

  // One byte more than expected shows the end of the file without another turn.
  std::string bytes;
  std::size_t used = 0;
  bytes.resize(static_cast<std::size_t>(expected) + 1);
  for (;;) {
    const ssize_t got = read_some(file.get(), bytes.data() + used, bytes.size() - used);
    if (got < 0) return failure(path, errno);
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
    if (used > limit) return unsuitable(path, too_large);
    if (used == bytes.size()) bytes.resize(used + std::max(used, std::size_t{4096}));
  }
  bytes.resize(used);
  return bytes;
}

std::optional<FileIdentity> identity_of(const std::string& path) {
  struct stat status {};
  if (::stat(path.c_str(), &status) != 0) return std::nullopt;
  return identity_from(status);
}

bool same_file(const std::string& a, const std::string& b) {
  const auto first = identity_of(a), second = identity_of(b);
  return first && second && first->device == second->device && first->inode == second->inode;
}

// --- LineReader

struct LineReader::State {
  std::string path;
  Descriptor file;
  FileIdentity identity;
  std::vector<char> buffer = std::vector<char>(kBuffer);
  std::size_t begin = 0, end = 0;  // of the bytes in `buffer` that were not returned yet
  std::size_t searched = 0;        // no line feed in [begin, searched)
  bool at_end = false;
  bool skipping = false;  // the rest of a line that was cut
  bool too_long = false;
  std::size_t lines = 0;
  std::uint64_t consumed = 0;
  std::optional<FileError> error;
  FileGrowth* growth = nullptr;
  std::uint64_t taken = 0;  // from the file
  bool hashed = true;
  Sha256 hash;

  bool refill() {
    if (begin > 0) {
      std::memmove(buffer.data(), buffer.data() + begin, end - begin);
      end -= begin;
      searched -= begin;
      begin = 0;
    }
    ssize_t got = 0;
    do {
      got = read_some(file.get(), buffer.data() + end, buffer.size() - end);
    } while (got == 0 && growth != nullptr && growth->wait_beyond(taken));
    if (got < 0) error = failure(path, errno);
    if (got <= 0) {
      at_end = true;
      return false;
    }
    taken += static_cast<std::uint64_t>(got);
    if (hashed) hash.add({buffer.data() + end, static_cast<std::size_t>(got)});
    end += static_cast<std::size_t>(got);
    return true;
  }

  void consume(std::size_t count) {
    begin += count;
    searched = begin;
    consumed += count;
  }

  /// Whole lines of the buffer, as many as fit; one that is too long is left to next().
  std::size_t lines_at_hand(std::span<std::string_view> texts) {
    const char* from = buffer.data() + begin;
    const char* const to = buffer.data() + end;
    std::size_t count = 0;
    const auto take = [&](const char* feed) {
      const auto length = static_cast<std::size_t>(feed - from) + 1;
      if (count == texts.size() || length > kMaxLine) return false;
      texts[count++] = {from, length};
      from = feed + 1;
      return true;
    };
    const char* p = from;
#ifdef __SSE2__
    // Lines are short: all line feeds of 16 bytes at once.
    const __m128i feeds = _mm_set1_epi8('\n');
    for (bool more = true; more && count < texts.size() && to - p >= 16; p += more ? 16 : 0) {
      const __m128i bytes = _mm_loadu_si128(reinterpret_cast<const __m128i*>(p));
      auto found = static_cast<unsigned>(_mm_movemask_epi8(_mm_cmpeq_epi8(bytes, feeds)));
      for (; more && found != 0; found &= found - 1) more = take(p + std::countr_zero(found));
    }
    p = std::max(p, from);
#endif
    while (count < texts.size() && p < to) {
      const void* const feed = std::memchr(p, '\n', static_cast<std::size_t>(to - p));
      if (feed == nullptr || !take(static_cast<const char*>(feed))) break;
      p = from;
    }
    consume(static_cast<std::size_t>(from - (buffer.data() + begin)));
    lines += count;
    return count;
  }

  // Length up to and with the next line feed, or 0 if there is none in the buffer.
  std::size_t line_length() {
    const void* const feed = std::memchr(buffer.data() + searched, '\n', end - searched);
    searched = end;
    if (feed == nullptr) return 0;
    return static_cast<std::size_t>(static_cast<const char*>(feed) - (buffer.data() + begin)) + 1;
  }
};

LineReader::LineReader() : state_(std::make_unique<State>()) {}
LineReader::~LineReader() = default;
LineReader::LineReader(LineReader&&) noexcept = default;
LineReader& LineReader::operator=(LineReader&&) noexcept = default;

FileResult<LineReader> LineReader::open(const std::string& path, bool hashed, FileGrowth* growth) {
  LineReader reader;
  State& state = *reader.state_;
  state.hashed = hashed;
  state.growth = growth;
  state.path = path;
  // Not to wait for the other end of a pipe, which is refused below.
  state.file = Descriptor(open_retry(path.c_str(), O_RDONLY | O_NONBLOCK));
  if (state.file.get() < 0) return failure(path, errno);
  struct stat status {};
  if (::fstat(state.file.get(), &status) != 0) return failure(path, errno);
  if (S_ISDIR(status.st_mode)) return failure(path, EISDIR);
  if (!S_ISREG(status.st_mode)) return unsuitable(path, "not a regular file; use '-' to read standard input");
  static_cast<void>(::posix_fadvise(state.file.get(), 0, 0, POSIX_FADV_SEQUENTIAL));
  state.identity = identity_from(status);
  return reader;
}

std::optional<std::string_view> LineReader::next() {
  State& s = *state_;
  s.too_long = false;
  while (s.skipping) {
    const std::size_t length = s.line_length();
    s.skipping = length == 0;
    s.consume(length == 0 ? s.end - s.begin : length);
    if (s.skipping && !s.refill()) s.skipping = false;
  }
  std::size_t length = s.line_length();
  while (length == 0 && s.end - s.begin <= kMaxLine && !s.at_end && s.refill()) length = s.line_length();
  if (s.error) return std::nullopt;
  if (length == 0) length = s.end - s.begin;  // the last line, without a line feed, or a part of a long one
  if (length == 0) return std::nullopt;
  if (length > kMaxLine) {
    s.too_long = true;
    s.skipping = s.buffer[s.begin + length - 1] != '\n';
    const std::string_view line(s.buffer.data() + s.begin, kMaxLine);
    s.consume(length);
    ++s.lines;
    return line;
  }
  const std::string_view line(s.buffer.data() + s.begin, length);
  s.consume(length);
  ++s.lines;
  return line;
}

std::size_t LineReader::next(std::span<std::string_view> lines) {
  State& s = *state_;
  std::size_t count = s.skipping ? 0 : s.lines_at_hand(lines);
  if (count == 0 && !lines.empty()) {
    const auto first = next();
    if (!first) return 0;
    lines[0] = *first;
    return s.too_long ? 1 : 1 + s.lines_at_hand(lines.subspan(1));
  }
  s.too_long = false;
  return count;
}

bool LineReader::too_long() const { return state_->too_long; }
std::size_t LineReader::line_number() const { return state_->lines; }
std::uint64_t LineReader::bytes_read() const { return state_->consumed; }
const std::optional<FileError>& LineReader::error() const { return state_->error; }
FileIdentity LineReader::identity() const { return state_->identity; }
std::string LineReader::sha256() { return state_->hashed ? state_->hash.hex() : std::string(); }

void LineReader::read_on() {
  State& s = *state_;
  char last = '\n';
  do {
    if (s.end == s.begin) continue;
    s.lines += line_feeds(s.buffer.data() + s.begin, s.buffer.data() + s.end);
    last = s.buffer[s.end - 1];
    s.consume(s.end - s.begin);
  } while (s.refill());
  if (last != '\n') ++s.lines;
}

// --- SpoolFile

struct SpoolFile::State {
  std::string path;       // as the user gave it, for messages
  std::string target;     // what is replaced: `path` with its links followed
  std::string temporary;  // empty once there is none to remove
  bool copied = false;    // published by copying: standard output, a pipe, a device
  Descriptor file;
  std::string buffer;
  std::uint64_t size = 0;
  FileGrowth* growth = nullptr;
  std::optional<FileError> error;

  ~State() { discard(); }
  void discard() {
    if (!temporary.empty()) static_cast<void>(::unlink(temporary.c_str()));
    temporary.clear();
  }
  bool fail(FileError why) {
    if (!error) error = std::move(why);
    return false;
  }
  bool copy_out();
  bool replace_target();
};

SpoolFile::SpoolFile() : state_(std::make_unique<State>()) {}
SpoolFile::~SpoolFile() = default;
SpoolFile::SpoolFile(SpoolFile&&) noexcept = default;
SpoolFile& SpoolFile::operator=(SpoolFile&&) noexcept = default;

FileResult<SpoolFile> SpoolFile::create(const std::string& path) {
  if (path.empty()) return failure(path, ENOENT);
  SpoolFile spool;
  State& s = *spool.state_;
  s.path = path;
  s.target = path;

  struct stat old {};
  const bool exists = path != "-" && ::stat(path.c_str(), &old) == 0;
  if (exists) {
    if (S_ISDIR(old.st_mode)) return failure(path, EISDIR);
    if (::access(path.c_str(), W_OK) != 0) return failure(path, errno);
    std::error_code ignored;  // a path that cannot be resolved is used as it is
    if (auto real = std::filesystem::canonical(path, ignored); !ignored) s.target = real.string();
  }
  s.copied = path == "-" || (exists && !S_ISREG(old.st_mode));

  const std::string folder = s.copied ? temporary_folder() : folder_of(s.target);
  const std::size_t slash = s.target.rfind('/');
  std::string name = s.copied ? "output" : s.target.substr(slash == std::string::npos ? 0 : slash + 1);
  if (name.empty()) return failure(path, EISDIR);
  name.resize(std::min(name.size(), std::size_t{200}));  // room for the rest in 255 bytes
  const bool ours_alone = s.copied || exists;
  s.file = create_unique(fmt::format("{}/.{}.abbe", folder, name), ours_alone ? 0600 : 0666, s.temporary);
  if (s.file.get() < 0) {
    const int code = errno;
    s.temporary.clear();
    FileError error = failure(path, code);
    error.message += fmt::format(" (new file in the folder {})", folder);
    return error;
  }
  if (exists && !s.copied) {
    // Owner first: changing it clears mode bits. An owner that we may not give stays ours.
    if (::fchown(s.file.get(), old.st_uid, old.st_gid) != 0) errno = 0;
    if (::fchmod(s.file.get(), old.st_mode & 0777U) != 0) return failure(path, errno);
  }
  s.buffer.reserve(kBuffer);
  return spool;
}

bool SpoolFile::write(std::string_view bytes) {
  State& s = *state_;
  if (s.error) return false;
  if (s.buffer.size() + bytes.size() > kBuffer && !flush()) return false;
  s.size += bytes.size();
  if (bytes.size() >= kBuffer) {
    if (!write_all(s.file.get(), bytes.data(), bytes.size())) return s.fail(failure(s.path, errno));
    if (s.growth != nullptr) s.growth->grown_to(s.size);
    return true;
  }
  s.buffer.append(bytes);
  return true;
}

bool SpoolFile::flush() {
  State& s = *state_;
  if (s.error) return false;
  if (!write_all(s.file.get(), s.buffer.data(), s.buffer.size())) return s.fail(failure(s.path, errno));
  s.buffer.clear();
  if (s.growth != nullptr) s.growth->grown_to(s.size);
  return true;
}

void SpoolFile::tell(FileGrowth& growth) { state_->growth = &growth; }

const std::string& SpoolFile::temporary_path() const { return state_->temporary; }
std::uint64_t SpoolFile::size() const { return state_->size; }
const std::optional<FileError>& SpoolFile::error() const { return state_->error; }

bool SpoolFile::State::copy_out() {
  Descriptor opened;
  int out = STDOUT_FILENO;
  if (path != "-") {
    opened = Descriptor(open_retry(target.c_str(), O_WRONLY));
    if (opened.get() < 0) return fail(failure(path, errno));
    out = opened.get();
  }
  if (::lseek(file.get(), 0, SEEK_SET) != 0) return fail(failure(path, errno));
  std::vector<char> block(kBuffer);
  for (;;) {
    const ssize_t got = read_some(file.get(), block.data(), block.size());
    if (got < 0) return fail(failure(temporary, errno));
    if (got == 0) return true;
    if (!write_all(out, block.data(), static_cast<std::size_t>(got))) {
      return fail(failure(path == "-" ? "standard output" : path, errno));
    }
  }
}

bool SpoolFile::State::replace_target() {
  if (!sync_to_disk(file.get()) || !file.close()) return fail(failure(path, errno));
  if (::rename(temporary.c_str(), target.c_str()) != 0) return fail(failure(path, errno));
  temporary.clear();
  // The new name itself must reach the disk, too.
  const Descriptor folder(open_retry(folder_of(target).c_str(), O_RDONLY | O_DIRECTORY));
  if (folder.get() >= 0 && !sync_to_disk(folder.get())) return fail(failure(path, errno));
  return true;
}

bool SpoolFile::publish() {
  if (!flush()) return false;
  State& s = *state_;
  if (s.temporary.empty()) return s.fail({fmt::format("{}: already written", s.path), false, false});
  if (!s.copied) return s.replace_target();
  const bool done = s.copy_out();
  s.discard();
  return done;
}

FileResult<SpooledInput> SpooledInput::from_standard_input() {
  auto created = SpoolFile::create("-");
  if (auto* error = std::get_if<FileError>(&created)) return std::move(*error);
  auto& spool = std::get<SpoolFile>(created);
  std::vector<char> block(kBuffer);
  for (;;) {
    const ssize_t got = read_some(STDIN_FILENO, block.data(), block.size());
    if (got < 0) return failure("standard input", errno);
    if (got == 0) break;
    if (!spool.write({block.data(), static_cast<std::size_t>(got)})) return *spool.error();
  }
  if (!spool.flush()) return *spool.error();
  return SpooledInput(std::move(spool));
}

}  // namespace abbe
