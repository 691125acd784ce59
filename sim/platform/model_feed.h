// The model of the board behind the platform's inputs, which are lines and encoder levels, not beats.
#ifndef SELFPROJ_SIM_PLATFORM_MODEL_FEED_H
#define SELFPROJ_SIM_PLATFORM_MODEL_FEED_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <utility>

#include "model/board.h"

namespace selfproj {

class ModelFeed {
 public:
  // Frame k has the pattern index k mod patterns.
  explicit ModelFeed(BoardModel::Sink sink, int patterns = 1)
      : model_(std::move(sink)), patterns_(static_cast<std::uint64_t>(patterns)) {}

  void write(const BoardSettings& settings) { model_.write(settings); }

  // A line of beats from `clock` on. Packets that it completes go to the sink.
  void line(std::uint64_t clock, std::span<const std::uint8_t> pixels, bool frame_start) {
    VideoBeat beat;
    beat.start = frame_start;
    for (std::size_t at = 0; at < pixels.size(); at += beat.pixels.size()) {
      std::memcpy(beat.pixels.data(), pixels.data() + at, beat.pixels.size());
      beat.line_end = at + beat.pixels.size() == pixels.size();
      clock_ = clock++;
      const auto pattern = static_cast<std::uint16_t>(model_.frames() % patterns_);
      model_.beat({.clock = clock_, .encoder = count_, .pattern = pattern}, beat);
      beat.start = false;
    }
  }

  // New levels of the encoder: one step forward if A leads, back if B does.
  void encoder(bool a, bool b) {
    constexpr std::array<unsigned, 4> kPhase{0, 1, 3, 2};  // phase of the levels b a
    const unsigned phase = kPhase[(a ? 1U : 0U) | (b ? 2U : 0U)];
    const unsigned step = (phase - phase_) & 3U;
    count_ += step == 1 ? 1U : step == 3 ? ~0U : 0U;
    phase_ = phase;
  }

  // The clock of the last beat.
  [[nodiscard]] std::uint64_t clock() const { return clock_; }
  [[nodiscard]] const BoardModel& model() const { return model_; }

 private:
  BoardModel model_;
  std::uint64_t patterns_;
  std::uint64_t clock_ = 0;
  unsigned phase_ = 0;
  std::uint32_t count_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_PLATFORM_MODEL_FEED_H
