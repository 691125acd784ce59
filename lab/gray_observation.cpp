#include "lab/gray_observation.h"

#include <cmath>
#include <cstddef>
#include <functional>
#include <limits>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/code_borders.h"
#include "host/structured_light/depth_geometry.h"
#include "lab/depth_stream.h"
#include "model/column_moments.h"
#include "sim/scene/pattern_renderer.h"

namespace selfproj {
namespace {

constexpr double kBelowPlane = 15;  // mm; a depth further below the plane comes from a wrong code

// Gray codes over all of the projector's lines, and the depths at their borders.
class WholeStream final : public GrayStream {
 public:
  explicit WholeStream(const Rig& rig)
      : GrayStream(rig, triangulation_of_rig(rig, kGrayBits, {0, rig.plane_z_mm + kBelowPlane}), kGrayBits,
                   rig.projector.lines),
        borders_(triangulation(), rig.measure.code_threshold),
        border_depth_(rig.camera.rows, rig.camera.columns) {}

  bool take(const ImageView& image, int pattern) override {
    if (pattern % 2 == 0) {
      positive_ = image;  // only a view; the scanner, too, reads these pixels again when the negative comes
    } else {
      borders_.add_plane(pattern / 2, positive_, image);
    }
    const bool due = GrayStream::take(image, pattern);
    has_borders_ = due && pattern + 1 == kGrayCycle;
    if (has_borders_) {
      borders_.depth(codes().data(), border_depth_.values.data());
    }
    return due;
  }
  [[nodiscard]] const FloatImage* borders() const { return has_borders_ ? &border_depth_ : nullptr; }

 private:
  CodeBorders borders_;
  ImageView positive_;
  FloatImage border_depth_;
  bool has_borders_ = false;
};

}  // namespace

void observe(const GrayMotionOptions& options, const GrayShot& shot, const std::function<void()>& done,
             const std::function<void(const Seen&)>& see) {
  Rig rig = options.rig;
  rig.imaging.seed = shot.noise_seed;
  Rig still_rig = rig;
  ++still_rig.imaging.seed;
  WholeStream stream(rig);
  FloatImage background;
  FloatImage background_borders;
  FloatImage true_background(rig.camera.rows, rig.camera.columns);
  const auto least = static_cast<float>(rig.measure.code_threshold);
  {
    const PatternRenderer still(still_rig, shot.background, options.render);
    WholeStream before(still_rig);
    play(
        still, before, 0, kGrayCycle, [](int /*frame*/) {}, done);
    background = before.depth();
    background_borders = *before.borders();
    still.lit_depth(0, true_background.values, least);
  }
  stream.set_reference(background);
  for (std::size_t i = 0; i < background.values.size(); ++i) {
    if (std::isnan(background.values[i])) {
      true_background.values[i] = background.values[i];
    }
  }
  const PatternRenderer renderer(rig, shot.scene, options.render);
  FloatImage truth(rig.camera.rows, rig.camera.columns, std::numeric_limits<float>::quiet_NaN());
  play(
      renderer, stream, shot.first, shot.frames,
      [&](int frame) {
        const int middle = frame - kGrayBits;
        if (shot.truth) {
          renderer.lit_depth(middle, truth.values, least);
        }
        see({middle / rig.camera.frame_rate_hz, stream.triangulation(), stream.depth(), background, truth,
             true_background, stream.borders(), background_borders});
      },
      done);
}

}  // namespace selfproj
