// The common part of the experiments with structured light: B4 (cuboids.h), B7 and B8 (moving_things.h).
#ifndef SELFPROJ_LAB_STRUCTURED_LIGHT_H
#define SELFPROJ_LAB_STRUCTURED_LIGHT_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "host/report/report.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::lab {

using ProgressOfImages = std::function<void(std::size_t done, std::size_t all)>;

// The number of central projector lines over which the conventional method has its codes.
constexpr int kCodedLines = 512;

// An experiment's tables and pictures, and the goals that it does not reach.
struct StructuredLightResult {
  std::vector<report::ReportTable> tables;
  std::vector<std::string> not_reached;
  report::ReportPage page;
  images::FloatImage depth, difference, truth;  // mm
  std::string series;                           // CSV of the measurements in every depth image; empty if nothing moves
};

// What half a pixel of projector and camera, rounded, does to z in the middle of the image, (4.23): the error that the
// thesis gives for the plane and for 109 mm above it, mm. The project's goals for the error of z of things as high.
inline constexpr double kHalfPixelOnPlane = 1.79;
inline constexpr double kHalfPixelAt109 = 1.04;

// A number for a table; a dash for NaN.
std::string figure_text(double value, int digits = 2);

// a - b, pixel by pixel; NaN if either is NaN. The images have one size.
images::FloatImage minus(const images::FloatImage& a, const images::FloatImage& b);

// Images of a scene under the patterns of a cycle, one after another into a scanner.

// Gives a scanner the images of a scene under the 2 bits patterns of a cycle, frames `first` and on. `see` gets each
// image before the scanner.
template <class AnyScanner>
void scan_cycle(const sim::PatternRenderer& renderer, int first, int bits,
                const std::function<images::FloatImage(int)>& pattern,
                const std::function<void(int, const model::ImageView&)>& see, AnyScanner& scanner) {
  std::vector<std::uint8_t> positive;  // the scanner reads it again when the negative comes
  sim::take_images(
      renderer, {.count = 2 * bits, .first = first, .pattern = [&](int i) { return sim::pattern_image(pattern(i)); }},
      [&](int i, const model::ImageView& image) {
        see(i, image);
        if (i % 2 == 0) {
          positive.assign(image.pixels, image.pixels + renderer.rig().camera.pixels());
          scanner.add_frame({positive.data(), image.rows, image.columns, image.columns}, i);
        } else {
          scanner.add_frame(image, i);
        }
      });
}

// Streams of depth images of a moving scene, by the self-projected and by the conventional method.

// One of the two methods. Its arguments must outlive it.
class DepthStream {
 public:
  virtual ~DepthStream() = default;
  DepthStream() = default;
  DepthStream(const DepthStream&) = delete;
  DepthStream& operator=(const DepthStream&) = delete;

  // Takes a frame under a pattern; returns true if there is a new depth image.
  [[nodiscard]] virtual bool take(const model::ImageView& image, int pattern) = 0;

  // The newest z in mm, and how much nearer it is than the reference; NaN if there is none.
  [[nodiscard]] virtual const images::FloatImage& depth() const = 0;
  [[nodiscard]] virtual images::FloatImage difference() const = 0;

  // m, and the 2 m patterns with light 0..1.
  [[nodiscard]] virtual int bits() const = 0;
  [[nodiscard]] virtual images::FloatImage pattern(int index) const = 0;
};

class SelfProjectedStream final : public DepthStream {
 public:
  SelfProjectedStream(const rig::Rig& rig, const structured_light::SelfReference& reference,
                      const structured_light::MatchTable& table);
  bool take(const model::ImageView& image, int pattern) override { return scanner_.add_frame(image, pattern); }
  [[nodiscard]] const images::FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] images::FloatImage difference() const override { return scanner_.difference(); }
  [[nodiscard]] int bits() const override { return reference_.stripes.bits; }
  [[nodiscard]] images::FloatImage pattern(int index) const override {
    return structured_light::self_projected_pattern(reference_, index);
  }

 private:
  const structured_light::SelfReference& reference_;
  structured_light::SelfScanner scanner_;
};

// Gray codes of `bits` bits over so many central lines, with the median.
class GrayStream : public DepthStream {
 public:
  GrayStream(const rig::Rig& rig, std::unique_ptr<structured_light::Triangulation> triangulation, int bits, int lines);
  bool take(const model::ImageView& image, int pattern) override { return scanner_.add_frame(image, pattern); }
  [[nodiscard]] const images::FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] images::FloatImage difference() const override;
  [[nodiscard]] int bits() const override { return bits_; }
  [[nodiscard]] images::FloatImage pattern(int index) const override;

  [[nodiscard]] const structured_light::Triangulation& triangulation() const { return *triangulation_; }
  // The code words of the newest depth image.
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return scanner_.codes(); }

  // Sets the depth from which `difference` is computed; must be called before that.
  void set_reference(const images::FloatImage& depth) { reference_ = depth; }

 private:
  const rig::Rig& rig_;
  std::unique_ptr<structured_light::Triangulation> triangulation_;
  int bits_, lines_;
  structured_light::Scanner scanner_;
  images::FloatImage reference_;
};

// Over kCodedLines lines, or all of a coarse rig.
class ConventionalStream final : public GrayStream {
 public:
  ConventionalStream(const rig::Rig& rig, int bits);
};

// Plays frames first .. first + count - 1 (`count` even) under the stream's patterns, the first one under pattern 0.
// Calls `see` with the frame after each depth image, and `done` after each frame.
void play(const sim::PatternRenderer& renderer, DepthStream& stream, int first, int count,
          const std::function<void(int frame)>& see, const std::function<void()>& done);

// Observes a moving scene with Gray codes of 8 bits, for B1 to B3. After every pair of images there is a depth image,
// together with the true depths.

inline constexpr int kGrayBits = 8;
inline constexpr int kGrayCycle = 2 * kGrayBits;  // frames

struct GrayMotionOptions {
  rig::Rig rig;
  sim::RenderOptions render;
  int paths = 10;  // B1: drawn paths of the fist, in addition to that of the thesis
  std::uint64_t path_seed =
      0;          // B1: if more than 0, they are drawn by this seed and the next ones, without the thesis's
  int pools = 6;  // B2: pools in addition to that of the thesis: first 20 and 40 mm deep, then drawn ones
  std::uint64_t pool_seed = 0;  // B2: if more than 0, all of these pools are drawn, by this seed and the next ones
  // Frames of each path, pool or set of taps, an even number. 0 means a turn of the slowest fist, until 0.55 s after
  // the impact, or five taps.
  int frames = 0;
};

// A depth image, and the true depths in the middle of its cycle.
struct Seen {
  double t;  // s
  const structured_light::Triangulation& triangulation;
  const images::FloatImage& depth;
  const images::FloatImage& background;
  const images::FloatImage& truth;
  const images::FloatImage& true_background;  // NaN where the background has no depth
  // Depths at the borders between codes (CodeBorders). Those of the scene exist only after the last pair of a cycle,
  // and are null otherwise.
  const images::FloatImage* borders;
  const images::FloatImage& background_borders;
};

// What is observed: a scene over its background.
struct GrayShot {
  const sim::Scene& scene;
  const sim::Scene& background;
  int first = 0;   // frame
  int frames = 0;  // even
  std::int64_t noise_seed = 1;
  bool truth = true;  // if false, the true depths of the scene are not computed, and are NaN
};

// Calls `see` with each depth image of the scene, and `done` after each frame of the scene and of its background.
void observe(const GrayMotionOptions& options, const GrayShot& shot, const std::function<void()>& done,
             const std::function<void(const Seen&)>& see);

// Returns how many frames so many shots have, of which each has `frames` frames and one cycle of the background.
inline std::size_t images_of(int shots, int frames) { return static_cast<std::size_t>(shots * (kGrayCycle + frames)); }

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_STRUCTURED_LIGHT_H
