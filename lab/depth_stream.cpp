#include "lab/depth_stream.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "lab/structured_light.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_set.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj {
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

}  // namespace selfproj
