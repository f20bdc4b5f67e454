#pragma once

#include <condition_variable>
#include <cstdint>
#include <mutex>

namespace abbe {

/// How far a file has been written that one thread writes and others read at the same time: a reader that
/// comes to the present end waits for more instead of taking it for the end of the file.
///
/// cost    a lock for every piece that is written, and for every piece that a reader waits for
class FileGrowth {
 public:
  void grown_to(std::uint64_t size);  ///< so many bytes can be read now
  void finish();                      ///< there will be no more; may be said more than once

  /// Waits until more than `seen` bytes can be read; false if there will be none.
  [[nodiscard]] bool wait_beyond(std::uint64_t seen);

 private:
  std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t size_ = 0;
  bool finished_ = false;
};

}  // namespace abbe
