// Defect pixels: hot ones that are bright without light, and dead ones that stay dark.
#ifndef SELFPROJ_SIM_SCENE_DEFECT_PIXELS_H
#define SELFPROJ_SIM_SCENE_DEFECT_PIXELS_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace selfproj {

struct DefectPixels {
  double hot = 0;             // share of the pixels
  double dead = 0;            // share of the pixels
  double least_hot_grey = 0;  // a hot pixel's offset is drawn evenly from here to 255
};

// Each pixel is drawn by itself, so the number of defects is that of a binomial distribution.
class DefectMap {
 public:
  DefectMap(const DefectPixels& defects, std::size_t pixels, std::uint64_t seed);

  // Hot pixels get their offset on top, dead ones are `dark`.
  void apply(double dark, std::span<float> pixels) const;

  [[nodiscard]] std::size_t hot() const { return hot_.size(); }
  [[nodiscard]] std::size_t dead() const { return dead_.size(); }

 private:
  struct Hot {
    std::size_t pixel;
    float offset;
  };
  std::vector<Hot> hot_;
  std::vector<std::size_t> dead_;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_DEFECT_PIXELS_H
