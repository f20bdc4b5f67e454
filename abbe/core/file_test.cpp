#include "abbe/core/file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>
#include <span>
#include <vector>

namespace abbe {
namespace {

namespace fs = std::filesystem;

class FileTest : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "abbe-file-test-XXXXXX").string();
    ASSERT_NE(::mkdtemp(pattern.data()), nullptr);
    folder_ = pattern;
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  std::string make(const std::string& name, const std::string& bytes) const {
    std::ofstream(path(name), std::ios::binary) << bytes;
    return path(name);
  }
  [[nodiscard]] std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_), fs::directory_iterator()));
  }

  fs::path folder_;
};

std::string content(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

mode_t mode_of(const std::string& path) {
  struct stat status {};
  EXPECT_EQ(::stat(path.c_str(), &status), 0);
  return status.st_mode & 0777U;
}

std::string hash_of(std::string_view bytes) {
  Sha256 hash;
  hash.add(bytes);
  return hash.hex();
}

// File descriptor `fd` stands for another one as long as this object lives.
class Redirected {
 public:
  Redirected(int fd, int other) : fd_(fd), saved_(::dup(fd)) { ::dup2(other, fd); }
  ~Redirected() {
    ::dup2(saved_, fd_);
    ::close(saved_);
  }
  Redirected(const Redirected&) = delete;
  Redirected& operator=(const Redirected&) = delete;

 private:
  int fd_, saved_;
};

TEST(Sha256, GivesTheDigestsOfTheStandard) {
  // FIPS 180-4 examples
  EXPECT_EQ(hash_of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(hash_of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  Sha256 parts;
  parts.add("a");
  parts.add("bc");
  EXPECT_EQ(parts.hex(), hash_of("abc"));
  EXPECT_EQ(parts.hex(), hash_of("abc"));  // finished, and stays so
}

TEST_F(FileTest, ReadsAWholeFile) {
  std::string bytes(100'000, '\0');
  std::mt19937_64 rng{1};
  for (char& c : bytes) c = static_cast<char>(rng());
  EXPECT_EQ(std::get<std::string>(read_file(make("a", bytes))), bytes);
  EXPECT_EQ(std::get<std::string>(read_file(make("empty", ""))), "");
  EXPECT_EQ(std::get<std::string>(read_file(path("a"), bytes.size())), bytes);
}

TEST_F(FileTest, SaysWhyAFileCannotBeRead) {
  const auto missing = std::get<FileError>(read_file(path("none")));
  EXPECT_TRUE(missing.missing);
  EXPECT_EQ(missing.message, path("none") + ": No such file or directory");
  const auto folder = std::get<FileError>(read_file(folder_.string()));
  EXPECT_TRUE(folder.unsuitable);
  EXPECT_NE(folder.message.find("Is a directory"), std::string::npos);
  const auto large = std::get<FileError>(read_file(make("a", "12345"), 4));
  EXPECT_TRUE(large.unsuitable);
  EXPECT_TRUE(std::get<FileError>(read_file("")).missing);
  EXPECT_TRUE(std::get<FileError>(read_file("/dev/zero", 100'000)).unsuitable);
}

TEST_F(FileTest, KnowsTheSameFileThroughLinks) {
  const std::string a = make("a", "x"), b = make("b", "x");
  fs::create_symlink(a, path("soft"));
  fs::create_hard_link(a, path("hard"));
  EXPECT_TRUE(same_file(a, path("soft")));
  EXPECT_TRUE(same_file(a, path("hard")));
  EXPECT_TRUE(same_file(a, (folder_ / "." / "a").string()));
  EXPECT_FALSE(same_file(a, b));
  EXPECT_FALSE(same_file(path("none"), path("none")));
}

TEST_F(FileTest, IdentityShowsAChange) {
  const std::string a = make("a", "x");
  const auto before = identity_of(a);
  EXPECT_EQ(before, identity_of(a));
  make("a", "xy");
  EXPECT_NE(before, identity_of(a));
  EXPECT_FALSE(identity_of(path("none")).has_value());
}

TEST_F(FileTest, LinesTogetherAreTheFile) {
  std::mt19937_64 rng{2};
  for (int k = 0; k < 20; ++k) {
    std::string bytes;
    std::size_t lines = 0;
    // Lines of all lengths, so that some lie across the ends of the buffer; 2.5 MB and some.
    while (bytes.size() < (k < 3 ? 2'500'000U : 2000U)) {
      const std::size_t length = k == 0 ? rng() % 60'000 : rng() % 80;
      for (std::size_t i = 0; i < length; ++i) bytes += static_cast<char>(' ' + rng() % 90);
      bytes += rng() % 3 == 0 ? "\r\n" : "\n";
      ++lines;
    }
    if (k % 2 == 0) {
      bytes += "last";
      ++lines;
    }
    auto opened = LineReader::open(make("a", bytes));
    auto& reader = std::get<LineReader>(opened);
    std::string joined;
    while (const auto line = reader.next()) {
      joined += *line;
      ASSERT_EQ(line->find('\n') == std::string_view::npos ? bytes.size() : joined.size(), joined.size());
      ASSERT_FALSE(reader.too_long());
      ASSERT_EQ(reader.bytes_read(), joined.size());
    }
    ASSERT_TRUE(joined == bytes);
    EXPECT_EQ(reader.line_number(), lines);
    EXPECT_FALSE(reader.error().has_value());
    EXPECT_EQ(reader.sha256(), hash_of(bytes));
    EXPECT_EQ(reader.identity(), identity_of(path("a")));
  }
}

TEST_F(FileTest, EmptyFileHasNoLines) {
  auto opened = LineReader::open(make("a", ""));
  auto& reader = std::get<LineReader>(opened);
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_FALSE(reader.next().has_value());
  EXPECT_EQ(reader.line_number(), 0U);
  EXPECT_EQ(reader.sha256(), hash_of(""));
}

TEST_F(FileTest, LongLineIsCutAndTheNextIsWhole) {
  for (const std::size_t length : {LineReader::kMaxLine - 1, LineReader::kMaxLine, LineReader::kMaxLine + 1,
                                   std::size_t{1} << 20, std::size_t{3'000'001}}) {
    for (const bool at_end : {false, true}) {
      const std::string tail = at_end ? "" : "\nG1 X2\nlast";
      const std::string bytes = "G0\n" + std::string(length, 'x') + tail;
      auto opened = LineReader::open(make("a", bytes));
      auto& reader = std::get<LineReader>(opened);
      EXPECT_EQ(reader.next(), "G0\n");
      const auto line = reader.next();
      ASSERT_TRUE(line.has_value());
      const std::size_t whole = length + (at_end ? 0 : 1);
      EXPECT_EQ(line->size(), std::min(whole, LineReader::kMaxLine)) << length;
      EXPECT_EQ(reader.too_long(), whole > LineReader::kMaxLine) << length;
      EXPECT_EQ(reader.line_number(), 2U);
      if (!at_end) {
        EXPECT_EQ(reader.next(), "G1 X2\n");
        EXPECT_FALSE(reader.too_long());
        EXPECT_EQ(reader.line_number(), 3U);
        EXPECT_EQ(reader.next(), "last");
      }
      EXPECT_FALSE(reader.next().has_value());
      EXPECT_EQ(reader.bytes_read(), bytes.size());
      EXPECT_EQ(reader.sha256(), hash_of(bytes));
    }
  }
}

TEST_F(FileTest, LineReaderRefusesWhatIsNoFile) {
  EXPECT_TRUE(std::get<FileError>(LineReader::open(path("none"))).missing);
  EXPECT_TRUE(std::get<FileError>(LineReader::open(folder_.string())).unsuitable);
  EXPECT_TRUE(std::get<FileError>(LineReader::open("/dev/null")).unsuitable);
  ASSERT_EQ(::mkfifo(path("pipe").c_str(), 0600), 0);
  EXPECT_TRUE(std::get<FileError>(LineReader::open(path("pipe"))).unsuitable);  // and does not wait
}

TEST_F(FileTest, SpoolAppearsWhole) {
  std::string expected;
  {
    auto created = SpoolFile::create(path("out.ngc"));
    auto& spool = std::get<SpoolFile>(created);
    EXPECT_EQ(fs::path(spool.temporary_path()).parent_path(), folder_);
    EXPECT_EQ(fs::path(spool.temporary_path()).filename().string().substr(0, 14), ".out.ngc.abbe-");
    std::mt19937_64 rng{3};
    for (int k = 0; k < 1000; ++k) {
      const std::string part(rng() % (k == 500 ? 3'000'000 : 5000), static_cast<char>('a' + k % 26));
      ASSERT_TRUE(spool.write(part));
      expected += part;
    }
    EXPECT_EQ(spool.size(), expected.size());
    EXPECT_FALSE(fs::exists(path("out.ngc")));
    ASSERT_TRUE(spool.flush());
    EXPECT_TRUE(content(spool.temporary_path()) == expected);
    ASSERT_TRUE(spool.publish());
    EXPECT_FALSE(spool.error().has_value());
    EXPECT_TRUE(content(path("out.ngc")) == expected);
    EXPECT_FALSE(spool.publish());  // once
  }
  EXPECT_TRUE(content(path("out.ngc")) == expected);
  EXPECT_EQ(entries(), 1U);
  const mode_t mask = ::umask(0);
  ::umask(mask);
  EXPECT_EQ(mode_of(path("out.ngc")), 0666U & ~mask);
}

TEST_F(FileTest, UnpublishedSpoolLeavesNothingAndTheOldFile) {
  make("out", "old");
  {
    auto created = SpoolFile::create(path("out"));
    auto& spool = std::get<SpoolFile>(created);
    ASSERT_TRUE(spool.write("new") && spool.flush());
    SpoolFile moved = std::move(spool);
    EXPECT_EQ(entries(), 2U);
  }
  EXPECT_EQ(content(path("out")), "old");
  EXPECT_EQ(entries(), 1U);
}

TEST_F(FileTest, SpoolKeepsTheModeAndTheLinkOfWhatItReplaces) {
  make("real", "old");
  ASSERT_EQ(::chmod(path("real").c_str(), 0640), 0);
  fs::create_symlink("real", path("link"));
  auto created = SpoolFile::create(path("link"));
  auto& spool = std::get<SpoolFile>(created);
  ASSERT_TRUE(spool.write("new") && spool.publish());
  EXPECT_TRUE(fs::is_symlink(path("link")));
  EXPECT_EQ(content(path("real")), "new");
  EXPECT_EQ(mode_of(path("real")), 0640U);
}

TEST_F(FileTest, SpoolSaysWhyItCannotWrite) {
  const auto nowhere = std::get<FileError>(SpoolFile::create(path("no/such/out")));
  EXPECT_TRUE(nowhere.missing);
  EXPECT_NE(nowhere.message.find("No such file or directory"), std::string::npos);
  EXPECT_TRUE(std::get<FileError>(SpoolFile::create(folder_.string())).unsuitable);
  EXPECT_TRUE(std::holds_alternative<FileError>(SpoolFile::create("")));
  EXPECT_TRUE(std::holds_alternative<FileError>(SpoolFile::create(path("new/"))));
  if (::geteuid() != 0) {  // root may write everywhere
    make("kept", "x");
    ASSERT_EQ(::chmod(path("kept").c_str(), 0444), 0);
    EXPECT_TRUE(std::get<FileError>(SpoolFile::create(path("kept"))).unsuitable);
    ASSERT_EQ(::chmod(folder_.c_str(), 0555), 0);
    EXPECT_TRUE(std::get<FileError>(SpoolFile::create(path("out"))).unsuitable);
    ASSERT_EQ(::chmod(folder_.c_str(), 0755), 0);
  }
  EXPECT_EQ(entries(), ::geteuid() != 0 ? 1U : 0U);
}

TEST_F(FileTest, FullDiskIsAnErrorAndLeavesNothing) {
  struct rlimit old {};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &old), 0);
  struct rlimit small = old;
  small.rlim_cur = 100'000;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  {
    auto created = SpoolFile::create(path("out"));
    auto& spool = std::get<SpoolFile>(created);
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    bool written = true;
    for (int k = 0; k < 300 && written; ++k) written = spool.write(std::string(10'000, 'x'));
    EXPECT_FALSE(written);
    EXPECT_TRUE(spool.error().has_value());
    EXPECT_FALSE(spool.publish());
    EXPECT_FALSE(spool.write("more"));
  }
  ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &old), 0);
  std::signal(SIGXFSZ, handler);
  EXPECT_EQ(entries(), 0U);
}

TEST_F(FileTest, SpoolForStandardOutputIsCopiedOnPublish) {
  std::string temporary;
  const int out = ::open(path("stdout").c_str(), O_RDWR | O_CREAT, 0600);
  {
    const Redirected redirected(STDOUT_FILENO, out);
    auto created = SpoolFile::create("-");
    auto& spool = std::get<SpoolFile>(created);
    temporary = spool.temporary_path();
    EXPECT_TRUE(spool.write(std::string(3'000'000, 'a')));
    EXPECT_TRUE(spool.flush());
    EXPECT_EQ(fs::file_size(path("stdout")), 0U);
    EXPECT_TRUE(spool.publish());
  }
  ::close(out);
  EXPECT_EQ(fs::file_size(path("stdout")), 3'000'000U);
  EXPECT_FALSE(fs::exists(temporary));
}

TEST_F(FileTest, SpoolDoesNotReplaceADevice) {
  auto created = SpoolFile::create("/dev/null");
  auto& spool = std::get<SpoolFile>(created);
  EXPECT_TRUE(spool.write("x") && spool.publish());
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
}

TEST_F(FileTest, StandardInputCanBeReadTwice) {
  const std::string bytes(2'500'000, 'b');
  const int in = ::open(make("stdin", bytes).c_str(), O_RDONLY);
  std::string spooled;
  {
    const Redirected redirected(STDIN_FILENO, in);
    auto input = SpooledInput::from_standard_input();
    spooled = std::get<SpooledInput>(input).path();
    EXPECT_TRUE(content(spooled) == bytes);
    EXPECT_TRUE(content(spooled) == bytes);
    EXPECT_EQ(mode_of(spooled), 0600U);
  }
  ::close(in);
  EXPECT_FALSE(fs::exists(spooled));
}

TEST(LineReader, ReadingOnCountsTheSameLines) {
  for (const std::string text : {"", "a", "a\n", "a\nb", "\n\nb\r\n"}) {
    const std::string path = ::testing::TempDir() + "abbe_read_on_" + std::to_string(::getpid());
    std::ofstream(path, std::ios::binary) << text;
    auto one = LineReader::open(path), other = LineReader::open(path);
    auto& slow = std::get<LineReader>(one);
    auto& fast = std::get<LineReader>(other);
    while (slow.next()) {
    }
    fast.read_on();
    EXPECT_EQ(fast.line_number(), slow.line_number()) << text;
    EXPECT_EQ(fast.bytes_read(), slow.bytes_read());
    EXPECT_EQ(fast.sha256(), slow.sha256());
    std::remove(path.c_str());
  }
}

TEST(LineReader, ManyLinesAreTheLinesOneByOne) {
  std::mt19937_64 rng{9};
  const std::string path = ::testing::TempDir() + "abbe_many_lines_" + std::to_string(::getpid());
  for (int round = 0; round < 30; ++round) {
    std::string text;
    const std::size_t longest = round % 3 == 0 ? LineReader::kMaxLine + 3 : 90;
    for (int k = 0; k < (round % 3 == 0 ? 20 : 9000); ++k)
      text += std::string(rng() % longest, 'x') + (rng() % 5 == 0 ? "\r\n" : "\n");
    if (round % 2 == 0) text += "end";
    std::ofstream(path, std::ios::binary) << text;
    auto one = LineReader::open(path), other = LineReader::open(path);
    auto& slow = std::get<LineReader>(one);
    auto& fast = std::get<LineReader>(other);
    std::array<std::string_view, 7> lines;
    while (const std::size_t count = fast.next(std::span(lines).first(1 + rng() % lines.size()))) {
      for (std::size_t i = 0; i < count; ++i) ASSERT_EQ(slow.next(), lines[i]);
      ASSERT_EQ(fast.line_number(), slow.line_number());
      ASSERT_EQ(fast.too_long(), slow.too_long());
      ASSERT_EQ(fast.bytes_read(), slow.bytes_read());
    }
    EXPECT_FALSE(slow.next());
    EXPECT_EQ(fast.sha256(), slow.sha256());
  }
  std::remove(path.c_str());
}

}  // namespace
}  // namespace abbe
