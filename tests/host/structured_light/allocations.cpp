#include "tests/host/structured_light/allocations.h"

#include <cstddef>
#include <cstdlib>
#include <new>

namespace {
std::size_t count = 0;
}  // namespace

// Not inlined; otherwise the compiler reports malloc and delete as a mismatch.
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++count;
  void* const memory = std::malloc(size == 0 ? 1 : size);
  if (memory == nullptr) {
    throw std::bad_alloc();
  }
  return memory;
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t /*size*/) noexcept { std::free(memory); }

std::size_t selfproj::test::allocations() { return count; }
