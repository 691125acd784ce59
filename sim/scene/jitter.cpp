#include "sim/scene/jitter.h"

#include <cstdint>

#include "sim/scene/noise.h"

namespace selfproj {

double lateness(const Jitter& jitter, std::uint64_t seed, int frame, double speed) {
  constexpr std::uint64_t kApart = 0x6a6974;  // from the noise of pixels
  constexpr double kMicro = 1e-6;
  NormalNoise random(seed + kApart, static_cast<std::uint64_t>(frame));
  const auto [trigger, encoder] = random.two();
  return kMicro * jitter.trigger_us * static_cast<double>(trigger) +
         (speed > 0 ? jitter.encoder_mm / speed * static_cast<double>(encoder) : 0);
}

}  // namespace selfproj
