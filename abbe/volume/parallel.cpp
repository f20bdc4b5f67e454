#include "abbe/volume/parallel.h"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <system_error>
#include <thread>
#include <vector>

namespace abbe {

bool for_each_chunk(std::size_t chunks, unsigned threads, const std::function<void(std::size_t)>& body,
                    const Progress& progress, std::size_t done_before, std::size_t total) {
  std::atomic<std::size_t> next = 0, done = 0;
  std::atomic<bool> stop = false;
  std::exception_ptr failure;
  std::mutex failure_mutex;
  const auto work = [&](bool reports) {
    try {
      while (!stop) {
        const std::size_t chunk = next++;
        if (chunk >= chunks) return;
        body(chunk);
        ++done;
        if (reports && progress && !progress(done_before + done, total)) stop = true;
      }
    } catch (...) {
      const std::lock_guard<std::mutex> lock(failure_mutex);
      if (!failure) failure = std::current_exception();
      stop = true;
    }
  };
  unsigned wanted = threads > 0 ? threads : std::max(1U, std::thread::hardware_concurrency());
  wanted = static_cast<unsigned>(std::min<std::size_t>(wanted, std::max<std::size_t>(chunks, 1)));
  {
    std::vector<std::jthread> others;
    others.reserve(wanted);
    for (unsigned k = 1; k < wanted; ++k) {
      try {
        others.emplace_back(work, false);
      } catch (const std::system_error&) {
        break;  // no more threads to be had: those there are do the work
      }
    }
    work(true);
  }
  if (failure) std::rethrow_exception(failure);
  return !stop;
}

}  // namespace abbe
