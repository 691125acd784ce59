// The Gray-code decoder and its port to an external memory, both Verilated, in front of a model of the memory.
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_GRAY_AXI_BENCH_H
#define SELFPROJ_TESTS_RTL_BLOCKS_GRAY_AXI_BENCH_H

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <vector>

#include "Vsp_gray_axi_memory_ports.h"
#include "Vsp_gray_decoder_ports.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/little_endian.h"
#include "tests/rtl/blocks/axi_memory_model.h"
#include "tests/rtl/blocks/clocked.h"
#include "tests/rtl/blocks/gray_bench.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {

inline constexpr std::size_t kMemoryWords = 4096;

// Both circuits and the memory. The bench keeps the inputs, and compares the outputs at the end, when it knows which
// words came too late.
class GrayAxiBench {
 public:
  GrayAxiBench(Random& random, const model::GraySettings& settings)
      : random_(random), settings_(settings), memory_(random, kMemoryWords) {
    port_.valid_when({"rd_data_o", "rd_late_o"}, [this] { return asked_[0]; });
    port_.valid_when({"m_axi_araddr_o", "m_axi_arlen_o"}, [this] { return port_->m_axi_arvalid_o != 0; });
    port_.valid_when({"m_axi_awaddr_o", "m_axi_awlen_o"}, [this] { return port_->m_axi_awvalid_o != 0; });
    port_.valid_when({"m_axi_wdata_o", "m_axi_wlast_o"}, [this] { return port_->m_axi_wvalid_o != 0; });
    // any place where a burst may begin, except at the end of the address range, because the circuit reads ahead
    memory_.base = 0x100U * static_cast<std::uint64_t>(random.between(1, 0xFF'FE00));
    memory_.at_rest(port_.dut());
    decoder_->take_i = 0;
    decoder_->beat_valid_i = 0;
    decoder_->frame_start_i = 0;
    decoder_->break_i = 0;
    decoder_->busy_i = 0;
    decoder_->mem_late_i = 0;
    decoder_.reset();
    port_.reset();
    decoder_->decode_i = 1;
    decoder_->bits_i = static_cast<CData>(settings.bits);
    decoder_->threshold_i = static_cast<CData>(settings.threshold);
    decoder_->columns_i = static_cast<CData>(settings.columns);
    decoder_->rows_i = static_cast<CData>(settings.rows);
  }

  AxiMemory& memory() { return memory_; }

  // Plays one frame. `gaps` percent of the clocks have no beat. The frame breaks after `cut` beats if it has more.
  void frame(const std::vector<std::uint8_t>& image, int pattern, int gaps, int cut) {
    const int groups = settings_.columns / 4;
    for (int i = 0; i < settings_.rows * groups && i < cut; ++i) {
      while (random_.chance(gaps)) {
        clock();
      }
      Beat beat{.clock = decoder_.clock(), .pattern = pattern, .index = i};
      if (i == 0) {
        patterns_.start(beat.clock, pattern);
      }
      std::copy_n(image.begin() + 4 * i, 4, beat.pixels.begin());
      beats_.push_back(beat);
      decoder_->take_i = i == 0;
      decoder_->frame_start_i = i == 0;
      decoder_->beat_valid_i = 1;
      decoder_->beat_pixels_i = model::load_little_endian<std::uint32_t>(beat.pixels.data());
      decoder_->beat_line_start_i = i % groups == 0;
      decoder_->beat_line_end_i = i % groups == groups - 1 && i + 1 != cut;
      decoder_->beat_last_row_i = i / groups == settings_.rows - 1;
      clock();
    }
    if (cut <= settings_.rows * groups) {
      const std::array statuses{spec::kStatusShortLine, spec::kStatusLongLine, spec::kStatusStartInFrame,
                                spec::kStatusIncomplete};
      const std::uint32_t status = statuses.at(static_cast<std::size_t>(random_.between(0, 3)));
      beats_.push_back({.clock = decoder_.clock(), .index = -1, .status = status});
      decoder_->break_i = 1;
      decoder_->break_status_i = static_cast<CData>(status);
      clock();
    }
  }

  void idle(int clocks) {
    for (int i = 0; i < clocks && !::testing::Test::HasFatalFailure(); ++i) {
      clock();
    }
  }

  // Checks that all outputs are those of the model.
  void compare() {
    model::GrayDecoder model(settings_);
    const int groups = settings_.columns / 4;
    std::map<std::int64_t, std::uint64_t> codes;
    std::map<std::int64_t, std::uint32_t> breaks;
    std::size_t word = 0;
    bool due = false;
    bool lost = false;
    for (const Beat& beat : beats_) {
      if (beat.index < 0) {
        model.end(false);
        breaks.emplace(beat.clock + 7, beat.status);
        continue;
      }
      if (beat.index == 0) {
        due = model.begin(beat.pattern);
        lost = false;
        ++frames;
      }
      const bool late = late_.at(word++);
      if (!lost) {
        std::array<std::uint16_t, 4> out{};
        if (late) {
          lost = true;
          ++lates;
          model.end(false);
          if (due) {
            breaks[beat.clock + 8] = spec::kStatusLateMemory;
          }
        } else {
          model.pixels(beat.index / groups, beat.index % groups * 4, 4, beat.pixels.data(), out.data());
        }
        if (due) {
          codes[beat.clock + 7] = four_words(out.data());
          pixels += late ? 0 : 4;
        }
      } else {
        EXPECT_TRUE(late) << "a word of an abandoned frame";
      }
      if (beat.index == settings_.rows * groups - 1) {
        model.end(true);
      }
    }
    EXPECT_EQ(word, late_.size());
    EXPECT_EQ(codes, codes_);
    EXPECT_EQ(breaks, breaks_);
    EXPECT_EQ(decoder_->abandoned_o, lates);
  }

  std::uint64_t pixels = 0;  // whose codes were compared
  std::uint64_t frames = 0;
  std::uint64_t lates = 0;  // frames abandoned

 private:
  struct Beat {
    std::int64_t clock = 0;
    int pattern = 0;
    int index = 0;  // -1: a break
    std::array<std::uint8_t, 4> pixels{};
    std::uint32_t status = 0;  // of a break
  };

  void clock() {
    const std::int64_t now = decoder_.clock();
    patterns_.drive(decoder_.dut(), now);
    memory_.drive(port_.dut(), now);
    decoder_->mem_late_i = port_->rd_late_o;
    set128(decoder_->mem_data_i, word128(port_->rd_data_o));
    decoder_.settle();
    port_->rd_en_i = decoder_->mem_read_o;
    port_->rd_first_i = decoder_->mem_read_first_o;
    port_->wr_en_i = decoder_->mem_write_o;
    set128(port_->wr_data_i, word128(decoder_->mem_data_o));
    port_->end_i = decoder_->mem_end_o;
    port_.settle();
    if (asked_[0]) {
      late_.push_back(port_->rd_late_o != 0);
    }
    asked_ = {asked_[1], decoder_->mem_read_o != 0};
    if (decoder_->codes_valid_o != 0) {
      codes_[now] = decoder_->codes_o;
    }
    if (decoder_->codes_break_o != 0) {
      breaks_[now] = decoder_->codes_status_o;
    }
    memory_.edge(port_.dut(), now);
    decoder_.rise();
    port_.rise();
    decoder_->take_i = 0;
    decoder_->beat_valid_i = 0;
    decoder_->frame_start_i = 0;
    decoder_->break_i = 0;
  }

  Random& random_;
  model::GraySettings settings_;
  Clocked<Vsp_gray_axi_memory> port_;
  Clocked<Vsp_gray_decoder> decoder_;
  AxiMemory memory_;
  std::array<bool, 2> asked_{};  // two clocks ago, one clock ago
  std::vector<Beat> beats_;
  PatternIndex patterns_;
  std::vector<bool> late_;
  std::map<std::int64_t, std::uint64_t> codes_;
  std::map<std::int64_t, std::uint32_t> breaks_;
};

inline std::vector<std::uint8_t> random_pixels(Random& random, const model::GraySettings& settings) {
  return random.bytes(static_cast<std::size_t>(settings.rows) * static_cast<std::size_t>(settings.columns));
}

struct GrayAxiCounts {
  std::uint64_t pixels = 0;  // whose codes were compared
  std::uint64_t frames = 0;
  std::uint64_t lates = 0;  // frames abandoned
};

// A random sequence of frames on a memory of random latency and stalls.
inline void play_gray_axi_frames(std::uint64_t seed, GrayAxiCounts& counts) {
  Random random(seed);
  const model::GraySettings settings{.rows = random.between(1, 16),
                                     .columns = 4 * random.between(6, 16),
                                     .bits = random.between(1, random.chance(70) ? 4 : model::GrayDecoder::kMaxBits),
                                     .threshold = random.between(0, 60)};
  GrayAxiBench bench(random, settings);
  const int gaps = random.chance(30) ? 0 : random.between(1, 70);
  const int breaks = random.chance(50) ? 0 : 5;
  bench.memory().latency = random.chance(50) ? random.between(1, 20) : random.between(1, 200);
  bench.memory().stall_percent = random.chance(30) ? 0 : random.between(0, 60);
  const int longest_pause = random.between(1, 8) * (bench.memory().latency + 40);
  const int beats = settings.rows * settings.columns / 4;
  for (int frame = 0; frame < 60 && !::testing::Test::HasFatalFailure(); ++frame) {
    bench.idle(random.between(0, longest_pause));
    bench.frame(random_pixels(random, settings), frame % (2 * settings.bits), gaps,
                random.chance(breaks) ? random.between(1, beats) : beats + 1);
  }
  bench.idle(20);
  bench.compare();
  counts.pixels += bench.pixels;
  counts.frames += bench.frames;
  counts.lates += bench.lates;
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_GRAY_AXI_BENCH_H
