// The largest packet a board sends: what buffers and ring slots are made for.
#ifndef SELFPROJ_HOST_DRIVER_PACKET_LIMITS_H
#define SELFPROJ_HOST_DRIVER_PACKET_LIMITS_H

#include <algorithm>
#include <cstddef>

#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {

// Moments of the widest image in a grey mode; images and codes, of which a packet holds one line, are smaller. The
// format could also say many lines: such a packet is refused, so that a damaged length is noticed within this many
// bytes.
inline constexpr std::size_t kLargestPacketBytes = spec::kHeaderBytes +
                                                   std::max(std::size_t{spec::kMaxColumns} * spec::kGreyWordBits,
                                                            std::size_t{spec::kMaxColumns} * spec::kCodeWordBits) /
                                                       8 +
                                                   spec::kTrailerBytes;
static_assert((kLargestPacketBytes - spec::kHeaderBytes - spec::kTrailerBytes) % spec::kPacketBeatBytes == 0);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_PACKET_LIMITS_H
