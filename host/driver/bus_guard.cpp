#include "host/driver/bus_guard.h"

#include <sys/mman.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstddef>
#include <cstdint>
#include <mutex>

namespace selfproj::driver {
namespace {

struct Mapping {
  std::atomic<std::uintptr_t> begin{0};  // 0: this entry is free
  std::atomic<std::size_t> bytes{0};
};

std::array<Mapping, 64> mappings;          // NOLINT: a signal handler needs them
struct sigaction action_before {};         // NOLINT
std::atomic<std::uintptr_t> page_bytes{};  // NOLINT

// Calls only the kernel.
void on_bus_error(int number, siginfo_t* info, void* /*context*/) {
  const auto at = reinterpret_cast<std::uintptr_t>(info->si_addr);
  const std::uintptr_t page = page_bytes;
  for (const Mapping& mapping : mappings) {
    const std::uintptr_t begin = mapping.begin;
    if (begin != 0 && at >= begin && at - begin < mapping.bytes) {
      void* const place = reinterpret_cast<void*>(at / page * page);  // NOLINT(performance-no-int-to-ptr)
      if (mmap(place, page, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_FIXED, -1, 0) != MAP_FAILED) {
        return;
      }
    }
  }
  sigaction(number, &action_before, nullptr);  // the signal then comes again
}

void install() {
  page_bytes = static_cast<std::uintptr_t>(sysconf(_SC_PAGESIZE));
  struct sigaction action {};
  action.sa_sigaction = on_bus_error;
  action.sa_flags = SA_SIGINFO;
  sigemptyset(&action.sa_mask);
  sigaction(SIGBUS, &action, &action_before);
}

}  // namespace

void guard_mapping(const void* begin, std::size_t bytes) {
  static std::once_flag installed;
  std::call_once(installed, install);
  for (Mapping& mapping : mappings) {
    std::uintptr_t none = 0;
    if (mapping.begin.compare_exchange_strong(none, reinterpret_cast<std::uintptr_t>(begin))) {
      mapping.bytes = bytes;
      return;
    }
  }
}

void unguard_mapping(const void* begin) {
  for (Mapping& mapping : mappings) {
    if (mapping.begin == reinterpret_cast<std::uintptr_t>(begin)) {
      mapping.bytes = 0;
      mapping.begin = 0;
      return;
    }
  }
}

}  // namespace selfproj::driver
