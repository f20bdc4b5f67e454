#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

namespace abbe {

class FileGrowth;

/// Why a file operation failed, in words with the path: "part.ngc: No such file or directory".
struct FileError {
  std::string message;
  bool missing = false;     ///< no such file (exit code 2 instead of 1)
  bool unsuitable = false;  ///< exists, but is a directory, is not readable, or is too large
};

template <class T>
using FileResult = std::variant<T, FileError>;

/// The whole file as bytes; refuses directories and anything above `limit` bytes.
[[nodiscard]] FileResult<std::string> read_file(const std::string& path,
                                                std::size_t limit = std::size_t{1} << 28);

/// What a file was when it was opened, to notice that it changed while it was read.
struct FileIdentity {
  std::uint64_t device = 0, inode = 0, size = 0;
  std::int64_t mtime_ns = 0;
  friend bool operator==(const FileIdentity&, const FileIdentity&) = default;
};

[[nodiscard]] std::optional<FileIdentity> identity_of(const std::string& path);

/// True if both paths name the same existing file, also through links.
[[nodiscard]] bool same_file(const std::string& a, const std::string& b);

/// SHA-256 of a stream of bytes.
class Sha256 {
 public:
  Sha256();
  ~Sha256();
  Sha256(Sha256&&) noexcept;
  Sha256& operator=(Sha256&&) noexcept;
  void add(std::string_view bytes);
  [[nodiscard]] std::string hex();  ///< finishes: 64 lower-case digits

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Reads a file line by line in constant memory. A line is returned with its end-of-line bytes.
/// A line longer than kMaxLine is cut there and `too_long` is set; reading may go on.
class LineReader {
 public:
  static constexpr std::size_t kMaxLine = std::size_t{1} << 16;

  /// `hashed` false: sha256() is not asked for, reading is faster. `growth`, kept by the caller: of a file that
  /// another thread still writes.
  [[nodiscard]] static FileResult<LineReader> open(const std::string& path, bool hashed = true,
                                                   FileGrowth* growth = nullptr);
  ~LineReader();
  LineReader(LineReader&&) noexcept;
  LineReader& operator=(LineReader&&) noexcept;

  /// The next line, valid until the next call; nullopt at the end or after an I/O error.
  [[nodiscard]] std::optional<std::string_view> next();

  /// Some next lines at once, valid until the next call: as many as are in memory and fit into `lines`. 0 at
  /// the end or after an I/O error; a line that was cut comes alone.
  [[nodiscard]] std::size_t next(std::span<std::string_view> lines);

  [[nodiscard]] bool too_long() const;             ///< the line just returned was cut
  [[nodiscard]] std::size_t line_number() const;   ///< of the line just returned (the last one), from 1
  [[nodiscard]] std::uint64_t bytes_read() const;  ///< consumed so far
  [[nodiscard]] const std::optional<FileError>& error() const;
  [[nodiscard]] FileIdentity identity() const;  ///< at the time of opening
  [[nodiscard]] std::string sha256();           ///< of all bytes; call after the end; empty if not hashed

  /// Reads to the end without looking at lines one by one; the numbers above are then of the whole file.
  void read_on();

 private:
  LineReader();
  struct State;
  std::unique_ptr<State> state_;
};

/// A file that appears whole or not at all: bytes go to a temporary file beside `path`
/// (for "-" to the temporary directory), publish() flushes them to the disk and renames
/// (for "-": copies to standard output). Destroyed unpublished, it leaves nothing behind.
class SpoolFile {
 public:
  [[nodiscard]] static FileResult<SpoolFile> create(const std::string& path);
  ~SpoolFile();
  SpoolFile(SpoolFile&&) noexcept;
  SpoolFile& operator=(SpoolFile&&) noexcept;

  /// From now on `growth`, which must outlive this file, says how far temporary_path() can be read.
  void tell(FileGrowth& growth);
  [[nodiscard]] bool write(std::string_view bytes);  ///< false: see error()
  [[nodiscard]] bool flush();                        ///< so that temporary_path() can be read
  [[nodiscard]] const std::string& temporary_path() const;
  [[nodiscard]] std::uint64_t size() const;
  [[nodiscard]] bool publish();
  [[nodiscard]] const std::optional<FileError>& error() const;

 private:
  SpoolFile();
  struct State;
  std::unique_ptr<State> state_;
};

/// Standard input copied to a temporary file, so that it can be read more than once by its path.
/// The file is removed with this object.
class SpooledInput {
 public:
  [[nodiscard]] static FileResult<SpooledInput> from_standard_input();
  [[nodiscard]] const std::string& path() const { return file_.temporary_path(); }

 private:
  explicit SpooledInput(SpoolFile file) : file_(std::move(file)) {}
  SpoolFile file_;
};

}  // namespace abbe
