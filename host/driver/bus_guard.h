// Mapped files that another process may make shorter while they are used.
#ifndef SELFPROJ_HOST_DRIVER_BUS_GUARD_H
#define SELFPROJ_HOST_DRIVER_BUS_GUARD_H

#include <cstddef>

namespace selfproj {

// From guard_mapping to unguard_mapping, reading and writing behind the end of the mapped file does not end the program
// (SIGBUS): zeros of this process alone take the place of the pages that are no longer there. Other bus errors do what
// they always did. A few dozen mappings at a time; those beyond are not guarded.
void guard_mapping(const void* begin, std::size_t bytes);
void unguard_mapping(const void* begin);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_BUS_GUARD_H
