// Counts allocations. allocations.cpp replaces operator new, also that of the address sanitizer, which then does not
// see what is freed in the wrong way. So the tests that count are programs of their own.
#ifndef SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H
#define SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H

#include <cstdint>

namespace selfproj::test {

// How often the program has called operator new since it began, in any thread.
std::uint64_t allocations();

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_ALLOCATIONS_H
