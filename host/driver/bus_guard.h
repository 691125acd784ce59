// Protects mapped files that another process may shorten while they are in use.
#ifndef SELFPROJ_HOST_DRIVER_BUS_GUARD_H
#define SELFPROJ_HOST_DRIVER_BUS_GUARD_H

#include <cstddef>

namespace selfproj::driver {

// Between guard_mapping and unguard_mapping, an access behind the end of the mapped file does not end the program
// (SIGBUS). Pages that no longer exist are replaced by private pages of zeros. Other bus errors act as usual. A few
// dozen mappings can be guarded at a time; further ones are not.
void guard_mapping(const void* begin, std::size_t bytes);
void unguard_mapping(const void* begin);

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_BUS_GUARD_H
