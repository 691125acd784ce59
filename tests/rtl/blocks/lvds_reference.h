// What a front end for serial sensors must make of the words of a sensor with flags (CMV) or codes (PYTHON), damaged or
// not, from a gap between frames on, with all lanes aligned. Written from the descriptions of sp_lvds_flags,
// sp_lvds_codes and sp_lvds_sensor.
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
  std::vector<Frame> frames;    // as far as they are whole lines, or kernels
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

class LvdsCodesReference {
 public:
  LvdsCodesReference(const LvdsFormat& format, bool checked) : format_(format), checked_(checked) {}

  LvdsExpected of(const std::vector<LvdsWord>& words) {
    for (const LvdsWord& word : words) {
      ++now_;
      const bool damaged = take(word);
      // A wrong check word is noticed a clock later, and not counted once more if the word of that clock is damaged.
      expected_.damaged += (damaged ? 1U : 0U) + (unlike_ && !(word.at_once && damaged) ? 1U : 0U);
      unlike_ = unlike_next_;
    }
    expected_.damaged += unlike_ ? 1U : 0U;
    return expected_;
  }

 private:
  enum class Line { none, taken, left_out };

  // Returns whether damage is noticed in it.
  bool take(const LvdsWord& word) {
    const auto is = [&](unsigned of_ten_bits) { return word.control == format_.code(of_ten_bits); };
    const bool frame_start = is(0x2AA);
    const bool frame_end = is(0x32A);
    const bool start = frame_start || is(0x0AA) || is(0x22A);
    const bool finish = frame_end || is(0x12A);
    const bool pixels = is(0x035);
    const bool check = is(0x059);
    const bool training = is(0x3A6);
    const bool number = format_.bits == 10 ? word.control < 16 : (word.control & 0x83U) == 0;
    const bool code = start || finish || pixels || is(0x015) || check || training || (number && marked_);
    marked_ = start || finish;

    bool wrong = !(start || training || check);  // between lines
    if (numbered_) {
      wrong = !number || (line_ == Line::taken && closing_ && words_.size() % 2 == 0);  // an odd count with this one
    } else if (line_ != Line::none) {
      wrong = !(pixels || finish || (line_ == Line::left_out && is(0x015)));
    }
    const bool damaged = !code || (open_ && (wrong || frame_start)) || (training && !all_training(word));
    unlike_next_ = checked_ && check && line_ended_ && !are_check_words(word);
    line_ended_ = false;
    if (wrong) {
      cut();
      return damaged;
    }
    if (frame_start) {
      open_ = true;
      expected_.frames.emplace_back();
      expected_.may_break.push_back(false);
    }
    if (start) {
      line_ = open_ && !is(0x22A) ? Line::taken : Line::left_out;
      words_.clear();
    }
    if (line_ == Line::taken) {
      words_.push_back(word);
    }
    if (closing_) {
      if (line_ == Line::taken) {
        add_line(true);
        line_ended_ = true;
        last_line_ = now_;
      }
      line_ = Line::none;
      open_ = open_ && !ending_;
    }
    numbered_ = start || finish;
    closing_ = finish;
    ending_ = frame_end;
    return damaged;
  }

  void cut() {
    if (open_) {
      ++expected_.cuts;
      expected_.may_break.back() = true;
      if (line_ == Line::taken) {
        add_line(false);
      }
      // The last line of the frame before may still be on its way.
      if (expected_.frames.size() > 1 && now_ - last_line_ < 8) {
        expected_.may_break[expected_.frames.size() - 2] = true;
      }
    }
    open_ = numbered_ = closing_ = ending_ = false;
    line_ = Line::none;
  }

  [[nodiscard]] bool all_training(const LvdsWord& word) const {
    return std::all_of(word.data.begin(), word.data.begin() + format_.lanes,
                       [&](unsigned data) { return data == format_.training(); });
  }
  [[nodiscard]] bool are_check_words(const LvdsWord& word) const {
    for (std::size_t lane = 0; lane < static_cast<std::size_t>(format_.lanes); ++lane) {
      if (word.data[lane] != lvds_check_word(words_.size(), [&](std::size_t at) { return words_[at].data[lane]; })) {
        return false;
      }
    }
    return true;
  }

  // Of a line that is cut off, the kernels that are whole.
  void add_line(bool whole) {
    const auto lanes = static_cast<std::size_t>(format_.lanes);
    const std::size_t count = words_.size() / 2 * 2;
    std::vector<unsigned> pixels(count * lanes);
    for (std::size_t at = 0; at < count; ++at) {
      for (std::size_t lane = 0; lane < lanes; ++lane) {
        pixels[lvds_kernel_column(lanes, at, lane)] = words_[at].data[lane];
      }
    }
    add_lvds_beats(pixels, format_.bits, whole, expected_.frames.back());
  }

  LvdsFormat format_;
  bool checked_;
  LvdsExpected expected_;
  bool unlike_ = false;       // the word before was a wrong check word
  bool unlike_next_ = false;  // this one is
  std::int64_t now_ = 0;
  std::int64_t last_line_ = -1'000'000;
  bool open_ = false;  // a frame is taken
  Line line_ = Line::none;
  bool line_ended_ = false;  // with the word before, one that was taken
  bool marked_ = false;      // the word before was a start or an end
  bool numbered_ = false;    // the window's number must come
  bool closing_ = false;     // and ends the line
  bool ending_ = false;      // and the frame
  std::vector<LvdsWord> words_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_LVDS_REFERENCE_H
