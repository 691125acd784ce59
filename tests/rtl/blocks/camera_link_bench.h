// A Camera Link camera, and what the board must get from it.
//
// The tables of the bits have the standard's names: A0 is bit 0 of port A; L, F, D are line, frame and data valid, S is
// the spare bit. The 80-bit configurations have no ports here, but tables of the bits of their taps (Camera Link 2.0,
// as github.com/slaclab/surf has it in protocols/clink/rtl/ClinkFraming.vhd).
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <string_view>
#include <utility>
#include <vector>

#include "tests/rtl/blocks/camera_beats.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

// What one Channel Link carries in one clock.
struct LinkPins {
  bool frame = false;
  bool line = false;
  bool data = false;
  bool spare = false;
  std::array<std::uint8_t, 3> ports{};  // A, B, C of X; D, E, F of Y; G, H of Z
  // 80 bit: ten taps of 8 bits, or eight of 10 bits
  enum class Kind : std::uint8_t { ports, eighty_x, eighty_yz, eight_tens_x, eight_tens_yz } kind = Kind::ports;
  std::uint32_t flips = 0;   // outputs of the receiver chip that are damaged
  std::uint32_t eighty = 0;  // the outputs of the receiver chip in the 80-bit configuration, without L and F

  [[nodiscard]] bool bit(std::string_view name) const {
    switch (name[0]) {
      case 'L':
        return line;
      case 'F':
        return frame;
      case 'D':
        return data;
      case 'S':
        return spare;
      default:
        return (ports[static_cast<std::size_t>(name[0] - 'A')] >> static_cast<unsigned>(name[1] - '0') & 1U) != 0;
    }
  }
};

constexpr std::array<std::string_view, 28> kOutputs = {"A0", "A1", "A2", "A3", "A4", "A7", "A5", "B0", "B1", "B2",
                                                       "B6", "B7", "B3", "B4", "B5", "C0", "C6", "C7", "C1", "C2",
                                                       "C3", "C4", "C5", "S",  "L",  "F",  "D",  "A6"};

// Outputs 0 to 27 of a receiver chip.
inline std::uint32_t link_word(const LinkPins& pins) {
  const auto line = static_cast<std::uint32_t>(pins.line);
  switch (pins.kind) {
    case LinkPins::Kind::eighty_x:
    case LinkPins::Kind::eight_tens_x:
      return (pins.eighty | line << 24U | static_cast<std::uint32_t>(pins.frame) << 25U) ^ pins.flips;
    case LinkPins::Kind::eighty_yz:
      return (pins.eighty | line << 27U) ^ pins.flips;
    case LinkPins::Kind::eight_tens_yz:
      return (pins.eighty | line << 24U) ^ pins.flips;
    default:
      break;
  }
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < kOutputs.size(); ++i) {
    word |= static_cast<std::uint32_t>(pins.bit(kOutputs[i])) << i;
  }
  return word ^ pins.flips;
}

// A word with any levels.
inline std::uint32_t random_link_word(Random& random) {
  const std::uint64_t bits = random.bits();
  return link_word({.frame = (bits & 1U) != 0,
                    .line = (bits & 2U) != 0,
                    .data = (bits & 4U) != 0,
                    .spare = (bits & 8U) != 0,
                    .ports = {static_cast<std::uint8_t>(bits >> 8U), static_cast<std::uint8_t>(bits >> 16U),
                              static_cast<std::uint8_t>(bits >> 24U)}});
}

constexpr int kLinks = 3;

// Whether taps and bits are those of an 80-bit configuration, which has no data valid.
constexpr bool is_eighty(int taps, int bits) { return taps == 10 || (taps == 8 && bits == 10); }

// Where a bit of a pixel is: the link, and the output of its receiver chip.
struct LinkPlace {
  std::size_t link = 0;
  unsigned output = 0;
};

// Of ten taps of 8 bits: 26 bits in X, without outputs 24 and 25, then 27 in Y and in Z.
constexpr LinkPlace place_of_ten_taps(int tap, int bit) {
  const int at = 8 * tap + bit;
  return at < 26   ? LinkPlace{0, static_cast<unsigned>(at >= 24 ? at + 2 : at)}
         : at < 53 ? LinkPlace{1, static_cast<unsigned>(at - 26)}
                   : LinkPlace{2, static_cast<unsigned>(at - 53)};
}

// Of eight taps of 10 bits, from bit 0 to bit 9.
constexpr std::array<std::array<std::string_view, 10>, 8> kEightTens = {
    {{"X26", "X23", "X0", "X1", "X2", "X3", "X4", "X6", "X27", "X5"},
     {"Y25", "Y26", "X7", "X8", "X9", "X12", "X13", "X14", "X10", "X11"},
     {"Y23", "Z15", "X15", "X18", "X19", "X20", "X21", "X22", "X16", "X17"},
     {"Z18", "Z19", "Y0", "Y1", "Y2", "Y3", "Y4", "Y6", "Y27", "Y5"},
     {"Z20", "Z21", "Y7", "Y8", "Y9", "Y12", "Y13", "Y14", "Y10", "Y11"},
     {"Z22", "Z16", "Y15", "Y18", "Y19", "Y20", "Y21", "Y22", "Y16", "Y17"},
     {"Z17", "Z25", "Z0", "Z1", "Z2", "Z3", "Z4", "Z6", "Z27", "Z5"},
     {"Z26", "Z23", "Z7", "Z8", "Z9", "Z12", "Z13", "Z14", "Z10", "Z11"}}};

constexpr LinkPlace place_of_eight_tens(int tap, int bit) {
  const std::string_view name = kEightTens[static_cast<std::size_t>(tap)][static_cast<std::size_t>(bit)];
  LinkPlace place{static_cast<std::size_t>(name[0] - 'X'), 0};
  for (const char digit : name.substr(1)) {
    place.output = 10 * place.output + static_cast<unsigned>(digit - '0');
  }
  return place;
}

constexpr int kLanes = 5;  // four of data, and the clock
constexpr int kBitsOfLane = 7;
constexpr int kClockLane = 4;

// The bits of the lanes in the order of time.
inline constexpr std::array<std::array<std::string_view, kBitsOfLane>, kLanes - 1> kOrder = {
    {{"B0", "A5", "A4", "A3", "A2", "A1", "A0"},
     {"C1", "C0", "B5", "B4", "B3", "B2", "B1"},
     {"D", "F", "L", "C5", "C4", "C3", "C2"},
     {"S", "C7", "C6", "B7", "B6", "A7", "A6"}}};
// As outputs of the receiver chip.
inline constexpr auto kOutputOf = [] {
  std::array<std::array<unsigned, kBitsOfLane>, kLanes - 1> outputs{};
  for (std::size_t of = 0; of < outputs.size(); ++of) {
    for (std::size_t i = 0; i < kBitsOfLane; ++i) {
      while (kOutputs[outputs[of][i]] != kOrder[of][i]) {
        ++outputs[of][i];
      }
    }
  }
  return outputs;
}();

// Bit `at` (0 is the first in time) of a lane, of a word.
inline bool lane_bit(std::uint32_t word, int lane, int at) {
  if (lane == kClockLane) {
    return at < 2 || at > 4;
  }
  return (word >> kOutputOf[static_cast<std::size_t>(lane)][static_cast<std::size_t>(at)] & 1U) != 0;
}

// A camera with a queue of what it sends: X, Y and Z, clock by clock.
class LinkCamera {
 public:
  LinkCamera(Random& random, int taps, int bits) : random_(random), taps_(taps), bits_(bits) {}

  struct Sent {
    std::array<LinkPins, kLinks> links;
    std::size_t frame = 0;  // number of the frame to which it belongs, or behind which it lies
    bool pause = false;     // a clock without a word
  };

  struct Shape {
    int rows = 1;
    int columns = 4;  // where they are no multiple of the taps, others fill the last word of a line
    int min_gap = 1;  // of words between two lines
    int max_gap = 1;
    int without_data = 0;                  // percent of words of a line without data valid, before each group of pixels
    bool frame_ends_line = false;          // the last line ends with frame valid, while line valid stays
    int least_words = 0;                   // that the frame takes with what lies behind it
    const std::uint8_t* pixels = nullptr;  // rows x columns, line by line; random ones where there are none
  };

  // Queues a frame and at least one word without frame valid behind it. Returns it as the board is to get it.
  Frame send(const Shape& shape) {
    Frame due;
    const std::size_t before = queue_.size();
    for (int lead = random_.between(0, 3); lead > 0; --lead) {
      push(true, false, random_.chance(50));
    }
    for (int row = 0; row < shape.rows; ++row) {
      std::uint32_t beat = 0;
      for (int column = 0; column < shape.columns; column += taps_) {
        while (random_.chance(shape.without_data)) {
          push(true, true, false);
        }
        std::array<int, 10> given{};
        given.fill(-1);
        for (int i = 0; shape.pixels != nullptr && i < std::min(taps_, shape.columns - column); ++i) {
          given[static_cast<std::size_t>(i)] = shape.pixels[row * shape.columns + column + i];
        }
        const std::array<std::uint32_t, 10> pixels = push(true, true, true, given);
        for (int i = 0; i < std::min(taps_, shape.columns - column); ++i) {
          beat = beat >> 8U | pixels[static_cast<std::size_t>(i)] >> static_cast<unsigned>(bits_ - 8) << 24U;
          if ((column + i) % 4 == 3) {
            due.push_back({beat, due.empty(), column + i + 4 >= shape.columns});
          }
        }
      }
      const bool last = row + 1 == shape.rows;
      for (int gap = random_.between(shape.min_gap, shape.max_gap); gap > 0; --gap) {
        push(!last, last && (shape.frame_ends_line || random_.chance(50)), random_.chance(50));
      }
    }
    while (queue_.size() < before + static_cast<std::size_t>(shape.least_words)) {
      push(false, false, random_.chance(50));
    }
    ++frames_;
    return due;
  }

  std::deque<Sent>& queue() { return queue_; }
  [[nodiscard]] std::size_t frames() const { return frames_; }

 private:
  // One clock with these pixels, or random ones where they are negative, and random unused bits. Returns the pixels.
  std::array<std::uint32_t, 10> push(bool frame, bool line, bool data,
                                     const std::array<int, 10>& given = {-1, -1, -1, -1, -1, -1, -1, -1, -1, -1}) {
    Sent sent;
    sent.frame = frames_;
    line = line && (frame || !eighty());  // Y and Z of the 80-bit configurations have no frame valid
    for (std::size_t link = 0; link < (taps_ > 4 ? 3U : 2U); ++link) {
      LinkPins& pins = sent.links[link];
      pins.frame = frame;
      pins.line = line;
      pins.data = data;
      pins.spare = random_.chance(50);
      for (std::uint8_t& port : pins.ports) {
        port = static_cast<std::uint8_t>(random_.bits());
      }
      if (eighty()) {
        const LinkPins::Kind x = taps_ == 10 ? LinkPins::Kind::eighty_x : LinkPins::Kind::eight_tens_x;
        const LinkPins::Kind yz = taps_ == 10 ? LinkPins::Kind::eighty_yz : LinkPins::Kind::eight_tens_yz;
        pins.kind = link == 0 ? x : yz;
      }
    }
    std::array<std::uint32_t, 10> pixels{};
    for (int tap = 0; tap < taps_; ++tap) {
      const int wanted = given[static_cast<std::size_t>(tap)];
      const auto pixel = static_cast<std::uint32_t>(wanted >= 0 ? wanted : random_.between(0, (1 << bits_) - 1));
      pixels[static_cast<std::size_t>(tap)] = pixel;
      if (eighty()) {
        for (int bit = 0; bit < bits_; ++bit) {
          const LinkPlace place = taps_ == 10 ? place_of_ten_taps(tap, bit) : place_of_eight_tens(tap, bit);
          sent.links[place.link].eighty |= (pixel >> static_cast<unsigned>(bit) & 1U) << place.output;
        }
      } else if (bits_ == 8) {
        sent.links[static_cast<std::size_t>(tap / 3)].ports[static_cast<std::size_t>(tap % 3)] =
            static_cast<std::uint8_t>(pixel);
      } else {  // the lower 8 bits in port A or C, the others in one half of B
        std::array<std::uint8_t, 3>& ports = sent.links[0].ports;
        ports[tap == 0 ? 0 : 2] = static_cast<std::uint8_t>(pixel);
        const std::uint32_t above = pixel >> 8U;
        const std::uint32_t mask = (1U << static_cast<unsigned>(bits_ - 8)) - 1;
        const unsigned at = tap == 0 ? 0 : 4;
        ports[1] = static_cast<std::uint8_t>((ports[1] & ~(mask << at)) | above << at);
      }
    }
    queue_.push_back(sent);
    return pixels;
  }

  [[nodiscard]] bool eighty() const { return is_eighty(taps_, bits_); }

  Random& random_;
  int taps_;
  int bits_;
  std::size_t frames_ = 0;
  std::deque<Sent> queue_;
};

// What came out of the front end, beside the frames that were sent.
class LinkOutputs {
 public:
  [[nodiscard]] const std::vector<Beat>& beats() const { return beats_; }
  [[nodiscard]] int overruns() const { return overruns_; }
  [[nodiscard]] int lost() const { return lost_; }
  [[nodiscard]] int apart() const { return apart_; }
  void clear_beats() { beats_.clear(); }
  int expect_frames_sent() { return expect_frames(beats_, sent_, may_break_); }

 protected:
  // In a clock of the board. The counts do not count in a reset.
  template <typename Dut>
  void read_outputs(Dut& dut, bool counts) {
    if (dut->m_valid_o) {
      beats_.push_back(beat_of(dut));
    }
    if (counts) {
      overruns_ += dut->overrun_o;
      lost_ += dut->lost_o;
      apart_ += dut->apart_o;
    }
  }
  void note_sent(Frame frame) {
    sent_.push_back(std::move(frame));
    may_break_.push_back(false);
  }

  std::vector<Frame> sent_;
  std::vector<bool> may_break_;
  std::vector<Beat> beats_;

 private:
  int overruns_ = 0;
  int lost_ = 0;
  int apart_ = 0;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_CAMERA_LINK_BENCH_H
