// How often the calling thread has asked for memory or given it back.
#pragma once

#include <cstdint>

namespace mwidth::bench {

/// Calls of malloc, calloc, realloc, aligned_alloc and free by this thread since it began.
uint64_t HeapCalls() noexcept;

}  // namespace mwidth::bench
