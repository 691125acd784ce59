// Defocus: a lens blurs what is nearer or farther than its focus.
#ifndef SELFPROJ_SIM_SCENE_DEFOCUS_H
#define SELFPROJ_SIM_SCENE_DEFOCUS_H

#include <span>
#include <vector>

namespace selfproj {

struct Defocus {
  double f_number = 4;
  double focus_above_plane_mm = 0;  // the lens is focused on what is this high in the middle of its view
};

// A thin lens. Lengths in mm.
class FocusedLens {
 public:
  // `pitch` is that of the image's pixels, and `focus` the distance from the lens that is sharp (> focal length).
  FocusedLens(double focal_length, double f_number, double pitch, double focus);

  // The standard deviation in pixels of the blur at a depth: that of an even disc whose diameter is the circle of
  // confusion, f² / N · |d − focus| / (d (focus − f)), and so a quarter of it.
  [[nodiscard]] double sigma_px(double depth) const;

 private:
  double scale_;  // f² / (N (focus - f)) / 4 / pitch
  double focus_;
};

// Spreads each pixel of an image over its neighbours with its own standard deviation in pixels, along rows and along
// columns. The weights have exactly this variance below 0.6 px, where a sampled Gaussian has not. Light that leaves the
// image is lost, and comes in as its border has it.
void spread(int rows, int columns, std::span<const float> sigma, std::span<float> pixels);

// The weights at -reach..reach of a blur of this standard deviation, of sum 1.
std::vector<float> spread_weights(double sigma);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_DEFOCUS_H
