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

#include "host/images/image_files.h"
#include "host/structured_light/code_borders.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {

std::string figure_text(double value, int digits) {
  return std::isnan(value) ? "–" : fmt::format("{:.{}f}", value, digits);
}

images::FloatImage minus(const images::FloatImage& a, const images::FloatImage& b) {
  images::FloatImage result = a;
  std::transform(a.values.begin(), a.values.end(), b.values.begin(), result.values.begin(), std::minus<>());
  return result;
}

namespace {

// All lines of a coarse rig.
int coded_lines(const rig::Rig& rig) { return std::min(kCodedLines, rig.projector.lines); }

}  // namespace

SelfProjectedStream::SelfProjectedStream(const rig::Rig& rig, const structured_light::SelfReference& reference,
                                         const structured_light::MatchTable& table)
    : reference_(reference), scanner_(rig, reference, table, rig.measure.code_threshold) {}

GrayStream::GrayStream(const rig::Rig& rig, std::unique_ptr<structured_light::Triangulation> triangulation, int bits,
                       int lines)
    : rig_(rig),
      triangulation_(std::move(triangulation)),
      bits_(bits),
      lines_(lines),
      scanner_(*triangulation_, {.threshold = rig.measure.code_threshold}) {}

images::FloatImage GrayStream::difference() const { return minus(reference_, scanner_.depth()); }

images::FloatImage GrayStream::pattern(int index) const {
  return structured_light::gray_pattern(rig_, bits_, lines_, index);
}

ConventionalStream::ConventionalStream(const rig::Rig& rig, int bits)
    : GrayStream(rig,
                 std::make_unique<structured_light::PlaneTriangulation>(
                     rig, bits, structured_light::DepthLimits{}, rig::central_lines(rig, coded_lines(rig), bits)),
                 bits, coded_lines(rig)) {}

void play(const sim::PatternRenderer& renderer, DepthStream& stream, int first, int count,
          const std::function<void(int frame)>& see, const std::function<void()>& done) {
  std::vector<images::Image> patterns;
  for (int i = 0; i < 2 * stream.bits(); ++i) {
    patterns.push_back(sim::pattern_image(stream.pattern(i)));
  }
  const rig::Rig& rig = renderer.rig();
  const sim::PatternSet lights(rig, patterns, renderer.options());
  std::array<std::vector<std::uint8_t>, 2> pair;
  for (int i = 0; i < count; i += 2) {
    sim::parallel_for(2, 0, [&](int half) {
      auto& image = pair.at(static_cast<std::size_t>(half));
      image.resize(rig.camera.pixels());
      renderer.render(first + i + half, lights.of_frame(i + half), std::span(image));
    });
    for (int half = 0; half < 2; ++half) {
      const model::ImageView view{pair.at(static_cast<std::size_t>(half)).data(), rig.camera.rows, rig.camera.columns,
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
  explicit WholeStream(const rig::Rig& rig)
      : GrayStream(rig, structured_light::triangulation_of_rig(rig, kGrayBits, {0, rig.plane_z_mm + kBelowPlane}),
                   kGrayBits, rig.projector.lines),
        borders_(triangulation(), rig.measure.code_threshold),
        border_depth_(rig.camera.rows, rig.camera.columns) {}

  bool take(const model::ImageView& image, int pattern) override {
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
  [[nodiscard]] const images::FloatImage* borders() const { return has_borders_ ? &border_depth_ : nullptr; }

 private:
  structured_light::CodeBorders borders_;
  model::ImageView positive_;
  images::FloatImage border_depth_;
  bool has_borders_ = false;
};

}  // namespace

void observe(const GrayMotionOptions& options, const GrayShot& shot, const std::function<void()>& done,
             const std::function<void(const Seen&)>& see) {
  rig::Rig rig = options.rig;
  rig.imaging.seed = shot.noise_seed;
  rig::Rig still_rig = rig;
  ++still_rig.imaging.seed;
  WholeStream stream(rig);
  images::FloatImage background;
  images::FloatImage background_borders;
  images::FloatImage true_background(rig.camera.rows, rig.camera.columns);
  const auto least = static_cast<float>(rig.measure.code_threshold);
  {
    const sim::PatternRenderer still(still_rig, shot.background, options.render);
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
  const sim::PatternRenderer renderer(rig, shot.scene, options.render);
  images::FloatImage truth(rig.camera.rows, rig.camera.columns, std::numeric_limits<float>::quiet_NaN());
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

}  // namespace selfproj::lab
