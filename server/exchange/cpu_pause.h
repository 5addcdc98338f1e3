// What a thread that polls does between two looks.
#pragma once

namespace mwidth::exchange {

/// Tells the CPU that this thread only waits: it draws less power and leaves more to its hyper-thread
/// sibling. Rt.
inline void PauseCpu() noexcept {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace mwidth::exchange
