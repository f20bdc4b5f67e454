#include "abbe/core/file_growth.h"

#include <gtest/gtest.h>

#include <random>
#include <string>
#include <thread>

#include "abbe/core/file.h"

namespace abbe {
namespace {

std::string lines_of_random_length(std::size_t count) {
  std::mt19937 random(5);
  std::string text;
  for (std::size_t i = 0; i < count; ++i) text += std::string(random() % 80, 'x') + std::to_string(i) + '\n';
  return text + "the last, without its end";
}

// Pieces smaller and larger than a buffer; the reader is always ahead or behind, never at the end too early.
TEST(FileGrowth, AReaderGetsEveryLineOfAFileThatIsBeingWritten) {
  const std::string text = lines_of_random_length(60000);
  auto created = SpoolFile::create("-");
  auto& spool = std::get<SpoolFile>(created);
  FileGrowth growth;
  spool.tell(growth);
  std::thread writer([&] {
    std::mt19937 random(6);
    for (std::size_t at = 0; at < text.size();) {
      const std::size_t size = random() % 8 == 0 ? 300000 : random() % 3000;
      ASSERT_TRUE(spool.write(std::string_view(text).substr(at, size)));
      if (random() % 4 == 0) {
        ASSERT_TRUE(spool.flush());
      }
      at += size;
    }
    ASSERT_TRUE(spool.flush());
    growth.finish();
  });
  auto opened = LineReader::open(spool.temporary_path(), true, &growth);
  auto& reader = std::get<LineReader>(opened);
  std::string read;
  while (const auto line = reader.next()) read += *line;
  writer.join();
  EXPECT_EQ(read, text);
  EXPECT_FALSE(reader.error());
  Sha256 hash;
  hash.add(text);
  EXPECT_EQ(reader.sha256(), hash.hex());
}

TEST(FileGrowth, WhatIsFinishedIsNotWaitedFor) {
  FileGrowth growth;
  growth.grown_to(10);
  EXPECT_TRUE(growth.wait_beyond(9));
  growth.finish();
  EXPECT_TRUE(growth.wait_beyond(9));
  EXPECT_FALSE(growth.wait_beyond(10));
}

}  // namespace
}  // namespace abbe
