#pragma once

// Counts calls of operator new. Test support: include it in one file of a test program, for it replaces the
// operators of the whole program.

#include <cstddef>
#include <cstdlib>
#include <new>

#if defined(__SANITIZE_ADDRESS__)
#define ABBE_COUNTS_ALLOCATIONS 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define ABBE_COUNTS_ALLOCATIONS 0
#endif
#endif
#ifndef ABBE_COUNTS_ALLOCATIONS
#define ABBE_COUNTS_ALLOCATIONS 1
#endif

namespace abbe {

inline std::size_t allocations = 0;
[[gnu::noinline]] inline std::size_t allocation_count() { return allocations; }

}  // namespace abbe

#if ABBE_COUNTS_ALLOCATIONS  // the sanitizer has operators of its own, and does not like half of them
                             // replaced
// Out of line, or the compiler pairs malloc with delete and complains.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++abbe::allocations;
  if (void* p = std::malloc(size == 0 ? 1 : size)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }
#endif
