// What a front end for serial sensors must make of the words of a sensor with flags (CMV), damaged or not, from a gap
// between frames on, with all lanes aligned. Written from the description of sp_lvds_flags and sp_lvds_sensor.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_LVDS_REFERENCE_H
#define SELFPROJ_TESTS_RTL_BLOCKS_LVDS_REFERENCE_H

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "tests/rtl/blocks/camera_beats.h"
#include "tests/rtl/blocks/lvds_bench.h"

namespace selfproj::test {

struct LvdsExpected {
  std::vector<Frame> frames;    // as far as they are whole lines
  std::vector<bool> may_break;  // those that are cut off
  unsigned damaged = 0;         // words
  int cuts = 0;
};

class LvdsFlagsReference {
 public:
  explicit LvdsFlagsReference(const LvdsFormat& format) : format_(format) {}

  LvdsExpected of(const std::vector<LvdsWord>& words) {
    for (const LvdsWord& word : words) {
      ++now_;
      take(word);
    }
    return expected_;
  }

 private:
  void take(const LvdsWord& word) {
    const bool data = (word.control & 1U) != 0;
    const bool line = (word.control & 2U) != 0;
    const bool frame = (word.control & 4U) != 0;
    const bool legal = (word.control & 0x300U) == 0x200U && (line || !data) && (frame || !line);
    bool damage = !legal;
    if (legal && !data) {
      for (int lane = 0; lane < format_.lanes; ++lane) {
        damage = damage || word.data[static_cast<std::size_t>(lane)] != format_.training();
      }
    }
    if (legal && frame && !inside_) {
      inside_ = true;
      lows_ = 0;
      begin();
    }
    const bool ends = legal && !frame && inside_ && lows_ == 1;
    if (taken_ && (!legal || out_of_order(data, frame, ends))) {
      damage = true;
      taken_ = false;
      expected_.may_break.back() = true;
      // The last line of the frame before may still be on its way.
      if (expected_.frames.size() > 1 && now_ - last_line_ < format_.columns + 10) {
        expected_.may_break[expected_.frames.size() - 2] = true;
      }
      ++expected_.cuts;
    }
    expected_.damaged += damage ? 1U : 0U;
    if (!legal) {
      return;
    }
    if (taken_ && data) {
      collect(word);
    }
    burst_ = taken_ && data ? burst_ + 1 : 0;
    lows_ = inside_ && !frame ? lows_ + 1 : 0;
    if (ends) {
      inside_ = false;
      taken_ = false;
    }
  }

  void begin() {
    taken_ = true;
    burst_ = 0;
    lines_ = 0;
    line_.clear();
    expected_.frames.emplace_back();
    expected_.may_break.push_back(false);
  }

  [[nodiscard]] bool out_of_order(bool data, bool frame, bool ends) const {
    if (data ? burst_ == format_.burst : burst_ != 0 && burst_ != format_.burst) {
      return true;  // a burst of another length
    }
    if (frame ? lows_ == 1 : !line_.empty()) {
      return true;  // one word without frame valid; the frame ends within a line
    }
    return ends && lines_ == 0;
  }

  void collect(const LvdsWord& word) {
    line_.push_back(word);
    if (static_cast<int>(line_.size()) != format_.columns) {
      return;
    }
    Frame& frame = expected_.frames.back();
    std::uint32_t beat = 0;
    for (int column = 0; column < format_.columns * format_.lanes; ++column) {
      const unsigned pixel = line_[static_cast<std::size_t>(column % format_.columns)]
                                 .data[static_cast<std::size_t>(column / format_.columns)];
      beat = beat >> 8U | pixel >> static_cast<unsigned>(format_.bits - 8) << 24U;
      if (column % 4 == 3) {
        frame.push_back({beat, frame.empty(), column + 1 == format_.columns * format_.lanes});
      }
    }
    line_.clear();
    ++lines_;
    last_line_ = now_;
  }

  LvdsFormat format_;
  LvdsExpected expected_;
  std::int64_t now_ = 0;
  std::int64_t last_line_ = -1'000'000;
  bool inside_ = false;  // since frame valid rose
  int lows_ = 0;         // words without frame valid since then
  bool taken_ = false;
  int burst_ = 0;
  int lines_ = 0;
  std::vector<LvdsWord> line_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_LVDS_REFERENCE_H
