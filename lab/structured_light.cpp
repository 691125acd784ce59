#include "lab/structured_light.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/images/float_image.h"
#include "host/images/image_files.h"
#include "host/rig/rig.h"
#include "host/structured_light/code_borders.h"
#include "host/structured_light/depth_geometry.h"
#include "model/column_moments.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj {

std::string figure_text(double value, int digits) {
  return std::isnan(value) ? "–" : fmt::format("{:.{}f}", value, digits);
}

FloatImage minus(const FloatImage& a, const FloatImage& b) {
  FloatImage result = a;
  std::transform(a.values.begin(), a.values.end(), b.values.begin(), result.values.begin(), std::minus<>());
  return result;
}

namespace {

// All lines of a coarse rig.
int coded_lines(const Rig& rig) { return std::min(kCodedLines, rig.projector.lines); }

}  // namespace

SelfProjectedStream::SelfProjectedStream(const Rig& rig, const SelfReference& reference, const MatchTable& table)
    : reference_(reference), scanner_(rig, reference, table, rig.measure.code_threshold) {}

GrayStream::GrayStream(const Rig& rig, std::unique_ptr<Triangulation> triangulation, int bits, int lines)
    : rig_(rig),
      triangulation_(std::move(triangulation)),
      bits_(bits),
      lines_(lines),
      scanner_(*triangulation_, {.threshold = rig.measure.code_threshold}) {}

FloatImage GrayStream::difference() const { return minus(reference_, scanner_.depth()); }

FloatImage GrayStream::pattern(int index) const { return gray_pattern(rig_, bits_, lines_, index); }

ConventionalStream::ConventionalStream(const Rig& rig, int bits)
    : GrayStream(rig, std::make_unique<PlaneTriangulation>(rig, bits, DepthLimits{}, coded_lines(rig)), bits,
                 coded_lines(rig)) {}

void play(const PatternRenderer& renderer, DepthStream& stream, int first, int count,
          const std::function<void(int frame)>& see, const std::function<void()>& done) {
  std::vector<Image> patterns;
  for (int i = 0; i < 2 * stream.bits(); ++i) {
    patterns.push_back(pattern_image(stream.pattern(i)));
  }
  const Rig& rig = renderer.rig();
  const PatternSet lights(rig, patterns, renderer.options());
  std::array<std::vector<std::uint8_t>, 2> pair;
  for (int i = 0; i < count; i += 2) {
    parallel_for(2, 0, [&](int half) {
      auto& image = pair.at(static_cast<std::size_t>(half));
      image.resize(rig.camera.pixels());
      renderer.render(first + i + half, lights.of_frame(i + half), std::span(image));
    });
    for (int half = 0; half < 2; ++half) {
      const ImageView view{pair.at(static_cast<std::size_t>(half)).data(), rig.camera.rows, rig.camera.columns,
                           rig.camera.columns};
      if (stream.take(view, (i + half) % lights.size())) {
        see(first + i + half);
      }
      done();
    }
  }
}

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
