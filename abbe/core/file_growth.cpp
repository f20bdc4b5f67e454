#include "abbe/core/file_growth.h"

namespace abbe {

void FileGrowth::grown_to(std::uint64_t size) {
  const std::lock_guard lock(mutex_);
  size_ = size;
  changed_.notify_all();
}

void FileGrowth::finish() {
  const std::lock_guard lock(mutex_);
  finished_ = true;
  changed_.notify_all();
}

bool FileGrowth::wait_beyond(std::uint64_t seen) {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [&] { return size_ > seen || finished_; });
  return size_ > seen;
}

}  // namespace abbe
