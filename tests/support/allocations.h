// Counts allocations. allocations.cpp replaces operator new, even that of the address sanitizer. The sanitizer then
// does not find memory that is freed by the wrong function. So tests that count allocations are in programs of their
// own.
#ifndef SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H
#define SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H

#include <cstdint>

namespace selfproj::test {

// Returns how often this program has called operator new(std::size_t), in all threads. The standard library's new[] and
// nothrow new call it too. Those of the address sanitizer do not, and aligned new never does.
std::uint64_t allocations();

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H
