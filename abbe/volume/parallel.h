#pragma once

#include <cstddef>
#include <functional>

#include "abbe/core/progress.h"

namespace abbe {

/// Calls body(k) once for every k < chunks, on `threads` threads (0: one per processor). Which thread does
/// which chunk is left open, so a body writes to places of its own and sums are made afterwards, in order.
/// That way results do not depend on the number of threads.
///
/// `progress` is called from the calling thread only, with done_before + chunks done out of total.
/// Returns false if it asked to stop; then some chunks were not done. What a body throws is
/// thrown again here, after all threads have ended.
[[nodiscard]] bool for_each_chunk(std::size_t chunks, unsigned threads,
                                  const std::function<void(std::size_t)>& body, const Progress& progress = {},
                                  std::size_t done_before = 0, std::size_t total = 0);

}  // namespace abbe
