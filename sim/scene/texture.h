// Texture: the albedo varies over the surface, as with grain, print or scratches.
#ifndef SELFPROJ_SIM_SCENE_TEXTURE_H
#define SELFPROJ_SIM_SCENE_TEXTURE_H

#include <array>
#include <cstdint>

namespace selfproj {

struct Texture {
  double contrast = 0;  // standard deviation of the albedo over its mean
  double scale_mm = 1;  // period of its waves
};

// A sum of waves of one period in even directions: of mean 1, variance contrast², and with the autocorrelation
// J0(2π r / scale) of an isotropic sum, but for the finite number of waves.
class TextureField {
 public:
  TextureField(const Texture& texture, std::uint64_t seed);

  // The factor of the albedo at a place of the surface, mm; at least 0.05.
  [[nodiscard]] double at(double x, double y) const;

 private:
  struct Wave {
    double along_x, along_y, phase;
  };
  static constexpr int kWaves = 12;
  double amplitude_;
  std::array<Wave, kWaves> waves_{};
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_TEXTURE_H
