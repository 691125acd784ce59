#ifndef SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_ALLOCATIONS_H
#define SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_ALLOCATIONS_H

#include <cstddef>

namespace selfproj::test {

// How often the program has called operator new since it began.
std::size_t allocations();

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_HOST_STRUCTURED_LIGHT_ALLOCATIONS_H
