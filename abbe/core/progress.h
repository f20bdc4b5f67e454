#pragma once

#include <cstdint>
#include <functional>

namespace abbe {

/// Called now and then by long work with what is done and what there is to do (bytes, points; 0 =
/// unknown). Returning false asks the work to stop: it returns early with `stopped` set.
using Progress = std::function<bool(std::uint64_t done, std::uint64_t total)>;

}  // namespace abbe
