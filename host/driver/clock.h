// The clock that all processes of a machine share.
#ifndef SELFPROJ_HOST_DRIVER_CLOCK_H
#define SELFPROJ_HOST_DRIVER_CLOCK_H

#include <chrono>
#include <cstdint>

namespace selfproj {

// Nanoseconds of std::chrono::steady_clock (CLOCK_MONOTONIC).
inline std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// Tells the processor that this is a waiting loop.
inline void relax() {
#if defined(__x86_64__) || defined(__i386__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_CLOCK_H
