// Streams of depth images of a moving scene, by the self-projected and by the conventional method.
#ifndef SELFPROJ_LAB_DEPTH_STREAM_H
#define SELFPROJ_LAB_DEPTH_STREAM_H

#include <functional>
#include <memory>

#include "host/images/float_image.h"
#include "host/rig/rig.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/triangulation.h"
#include "model/column_moments.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/renderer.h"

namespace selfproj {

// One of the two methods. Its arguments must outlive it.
class DepthStream {
 public:
  virtual ~DepthStream() = default;
  DepthStream() = default;
  DepthStream(const DepthStream&) = delete;
  DepthStream& operator=(const DepthStream&) = delete;

  // Takes a frame under a pattern; returns true if there is a new depth image.
  [[nodiscard]] virtual bool take(const ImageView& image, int pattern) = 0;

  // The newest z in mm, and how much nearer it is than the reference; NaN if there is none.
  [[nodiscard]] virtual const FloatImage& depth() const = 0;
  [[nodiscard]] virtual FloatImage difference() const = 0;

  // m, and the 2 m patterns with light 0..1.
  [[nodiscard]] virtual int bits() const = 0;
  [[nodiscard]] virtual FloatImage pattern(int index) const = 0;
};

class SelfProjectedStream final : public DepthStream {
 public:
  SelfProjectedStream(const Rig& rig, const SelfReference& reference, const MatchTable& table);
  bool take(const ImageView& image, int pattern) override { return scanner_.add_frame(image, pattern); }
  [[nodiscard]] const FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] FloatImage difference() const override { return scanner_.difference(); }
  [[nodiscard]] int bits() const override { return reference_.stripes.bits; }
  [[nodiscard]] FloatImage pattern(int index) const override { return self_projected_pattern(reference_, index); }

 private:
  const SelfReference& reference_;
  SelfScanner scanner_;
};

// Gray codes of `bits` bits over so many central lines, with the median.
class GrayStream : public DepthStream {
 public:
  GrayStream(const Rig& rig, std::unique_ptr<Triangulation> triangulation, int bits, int lines);
  bool take(const ImageView& image, int pattern) override { return scanner_.add_frame(image, pattern); }
  [[nodiscard]] const FloatImage& depth() const override { return scanner_.depth(); }
  [[nodiscard]] FloatImage difference() const override;
  [[nodiscard]] int bits() const override { return bits_; }
  [[nodiscard]] FloatImage pattern(int index) const override;

  [[nodiscard]] const Triangulation& triangulation() const { return *triangulation_; }
  // The code words of the newest depth image.
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return scanner_.codes(); }

  // Sets the depth from which `difference` is computed; must be called before that.
  void set_reference(const FloatImage& depth) { reference_ = depth; }

 private:
  const Rig& rig_;
  std::unique_ptr<Triangulation> triangulation_;
  int bits_, lines_;
  Scanner scanner_;
  FloatImage reference_;
};

// Over kCodedLines lines, or all of a coarse rig.
class ConventionalStream final : public GrayStream {
 public:
  ConventionalStream(const Rig& rig, int bits);
};

// Plays frames first .. first + count - 1 (`count` even) under the stream's patterns, the first one under pattern 0.
// Calls `see` with the frame after each depth image, and `done` after each frame.
void play(const PatternRenderer& renderer, DepthStream& stream, int first, int count,
          const std::function<void(int frame)>& see, const std::function<void()>& done);

}  // namespace selfproj

#endif  // SELFPROJ_LAB_DEPTH_STREAM_H
