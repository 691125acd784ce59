// The Gray-code decoder as a SystemC module with the ports of rtl/gray/sp_gray_decoder.sv, for compilers that translate
// clocked threads.
//
// With the same inputs in every clock the outputs equal those of the RTL in every clock: one beat a clock, no bubble.
// The tests compare both clock by clock. The operations on a pixel are the pure functions of hls/gray_arithmetic.h.
// This file decides when they happen. The registers have the names of the RTL's. Unlike there, the new state is made in
// one clock, from a state two clocks delayed, so that a synthesizer can move the registers into it. The memory is
// outside, as in the RTL.
#ifndef SELFPROJ_HLS_SHELLS_GRAY_DECODER_SHELL_H
#define SELFPROJ_HLS_SHELLS_GRAY_DECODER_SHELL_H

#include <systemc>

#include "hls/gray_arithmetic.h"
#include "hls/moments_arithmetic.h"

namespace selfproj {
namespace hls {

constexpr int kStatusBits = 5;
static_assert((spec::kStatusIncomplete | spec::kStatusLateMemory) < 1U << kStatusBits, "all status bits");
using Status = Uint<kStatusBits>;
using StateWord = WideUint<kCodeLanes * kStateBits>;

class GrayDecoderShell : public sc_core::sc_module {
 public:
  sc_core::sc_in<bool> clk_i{"clk_i"};
  sc_core::sc_in<bool> rst_i{"rst_i"};

  // Settings
  sc_core::sc_in<bool> take_i{"take_i"};
  sc_core::sc_in<bool> decode_i{"decode_i"};
  sc_core::sc_in<PlaneCount> bits_i{"bits_i"};
  sc_core::sc_in<GrayPixel> threshold_i{"threshold_i"};
  sc_core::sc_in<Columns> columns_i{"columns_i"};
  sc_core::sc_in<Row> rows_i{"rows_i"};

  // Beats and breaks
  sc_core::sc_in<bool> beat_valid_i{"beat_valid_i"};
  sc_core::sc_in<Pixels> beat_pixels_i{"beat_pixels_i"};
  sc_core::sc_in<bool> beat_line_start_i{"beat_line_start_i"};
  sc_core::sc_in<bool> beat_line_end_i{"beat_line_end_i"};
  sc_core::sc_in<bool> beat_last_row_i{"beat_last_row_i"};
  sc_core::sc_in<bool> frame_start_i{"frame_start_i"};
  sc_core::sc_in<bool> break_i{"break_i"};
  sc_core::sc_in<Status> break_status_i{"break_status_i"};
  sc_core::sc_in<PatternIndex> pattern_i{"pattern_i"};

  // Memory port
  sc_core::sc_out<bool> mem_read_o{"mem_read_o"};
  sc_core::sc_out<bool> mem_read_first_o{"mem_read_first_o"};
  sc_core::sc_in<StateWord> mem_data_i{"mem_data_i"};
  sc_core::sc_in<bool> mem_late_i{"mem_late_i"};
  sc_core::sc_out<bool> mem_write_o{"mem_write_o"};
  sc_core::sc_out<bool> mem_write_first_o{"mem_write_first_o"};
  sc_core::sc_out<StateWord> mem_data_o{"mem_data_o"};
  sc_core::sc_out<bool> mem_end_o{"mem_end_o"};

  // Codes
  sc_core::sc_in<bool> busy_i{"busy_i"};
  sc_core::sc_out<bool> codes_valid_o{"codes_valid_o"};
  sc_core::sc_out<Uint<64>> codes_o{"codes_o"};
  sc_core::sc_out<bool> codes_start_o{"codes_start_o"};
  sc_core::sc_out<bool> codes_line_start_o{"codes_line_start_o"};
  sc_core::sc_out<bool> codes_line_end_o{"codes_line_end_o"};
  sc_core::sc_out<bool> codes_last_row_o{"codes_last_row_o"};
  sc_core::sc_out<bool> codes_break_o{"codes_break_o"};
  sc_core::sc_out<Status> codes_status_o{"codes_status_o"};

  sc_core::sc_out<Uint<32>> abandoned_o{"abandoned_o"};

  SC_HAS_PROCESS(GrayDecoderShell);
  explicit GrayDecoderShell(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_CTHREAD(clocked, clk_i.pos());
    reset_signal_is(rst_i, true);
  }

 private:
  static constexpr int kTooClose = 6;  // clocks from a beat to its write

  // --- Registers; index i is stage i + 1 ---
  bool valid_[7];
  bool start_[7];
  bool line_start_[7];
  bool line_end_[7];
  bool last_row_[7];
  bool break_[7];
  Status status_[7];
  bool close_[4];
  bool took_[4];
  Pixels pixels_[5];
  PixelState state_[2][kCodeLanes];  // of stages 4 and 5
  PixelState state6_[kCodeLanes];
  GrayPixel threshold5_;
  bool decode_;
  PlaneCount bits_;
  GrayPixel threshold_, threshold4_;
  Columns columns_;
  Row rows_;
  bool changed_;
  Uint<3> beats_;
  bool asked_[7];  // from stage 2 on
  bool lost4_, lost5_, lost6_, again4_, again5_, late_;
  bool show6_, end6_, late6_, late7_, late8_;
  // The frame in stage 5
  Uint<5> next_;
  Uint<4> pairs_;
  bool negative_, due_;
  Plane weight_, above_, mask_;
  // Outputs
  Uint<64> codes_;
  bool codes_valid_, codes_start_, codes_line_start_, codes_line_end_, codes_last_row_;
  Uint<32> abandoned_;

  void reset() {
    for (int i = 0; i < 7; ++i) {
      valid_[i] = false;
      start_[i] = false;
      line_start_[i] = false;
      line_end_[i] = false;
      last_row_[i] = false;
      break_[i] = false;
      status_[i] = 0;
      asked_[i] = false;
    }
    for (int i = 0; i < 5; ++i) {
      pixels_[i] = 0;
    }
    for (int i = 0; i < 4; ++i) {
      close_[i] = false;
      took_[i] = false;
      state_[0][i] = 0;
      state_[1][i] = 0;
      state6_[i] = 0;
    }
    threshold5_ = 0;
    decode_ = false;
    bits_ = 0;
    threshold_ = 0;
    threshold4_ = 0;
    columns_ = 0;
    rows_ = 0;
    changed_ = false;
    beats_ = kTooClose;
    lost4_ = false;
    lost5_ = false;
    lost6_ = false;
    again4_ = false;
    again5_ = false;
    late_ = false;
    show6_ = false;
    end6_ = false;
    late6_ = false;
    late7_ = false;
    late8_ = false;
    next_ = 0;
    pairs_ = 0;
    negative_ = false;
    due_ = false;
    weight_ = 0;
    above_ = 0;
    mask_ = 0;
    codes_ = 0;
    codes_valid_ = false;
    codes_start_ = false;
    codes_line_start_ = false;
    codes_line_end_ = false;
    codes_last_row_ = false;
    abandoned_ = 0;
  }

  void clocked() {
    reset();
    show_reset();
    wait();
    while (true) {
      // From the exit to the entry, so that each step sees the registers before it as they were in the clock that ends.
      codes_out();
      sequence();
      pixels();
      lateness();
      enter();
      show();
      wait();
    }
  }

  // Stages 8 to 6: the codes, and what accompanies them.
  void codes_out() {
    codes_ = 0;
    if (!lost6_) {
      for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
        CodeWord word = code_word(state6_[lane]);
        codes_ = (codes_ << spec::kCodeWordBits) | word;
      }
    }
    codes_valid_ = show6_;
    codes_start_ = show6_ && start_[5];
    codes_line_start_ = line_start_[5];
    codes_line_end_ = end6_;
    codes_last_row_ = last_row_[5];
    late8_ = late7_;
    late7_ = late6_;
    late6_ = asked_[4] && due_ && !again5_ && lost5_;
    show6_ = asked_[4] && due_ && !again5_;
    end6_ = line_end_[4] && !lost5_;
    lost6_ = lost5_;
    for (int lane = 0; lane < kCodeLanes; ++lane) {
      GrayPixel pixel = lane_of<FourOfEight>(pixels_[4], lane);
      state6_[lane] = next_state(pixel, state_[1][lane], threshold5_, negative_, weight_, above_, mask_);
    }
  }

  // Stage 4: the role of the frame, as in sp_gray_sequence.
  void sequence() {
    const bool start = start_[3];
    const bool decode = asked_[3];
    const bool restart = break_[3] || close_[3] || (took_[3] && changed_);
    const bool lost = asked_[3] && lost4_;
    const PatternIndex pattern = pattern_i.read();
    const Uint<5> index = pattern;
    const bool fresh = restart || pattern != next_;
    const bool follows = decode && (!fresh || pattern == 0);
    Uint<4> pairs_up = pairs_;
    if (pairs_ != bits_) {
      pairs_up = pairs_ + 1;
    }
    const bool enough = pairs_up == bits_;
    const bool odd = (index & 1) != 0;
    const bool refused = start && busy_i.read() && follows && odd && enough;
    const bool taken = follows && !refused;
    const bool negative = taken && odd;
    if (late_ || (close_[3] && asked_[3]) || refused) {
      abandoned_ = abandoned_ + 1;
    }
    if (start) {
      Uint<5> last = bits_;
      last = (last << 1) - 1;
      negative_ = negative;
      due_ = negative && enough;
      next_ = 0;
      if (taken && !lost && index != last) {
        next_ = index + 1;
      }
      if (!taken || lost || fresh) {
        pairs_ = 0;
      } else if (negative) {
        pairs_ = pairs_up;
      }
      mask_ = mask_of(bits_);
      weight_ = weight_of_plane(bits_, index >> 1);
      above_ = (weight_ << 1) & mask_;
    } else if (restart || lost) {
      next_ = 0;
      pairs_ = 0;
    }
  }

  // Stages 5 to 3: pixels and their states.
  void pixels() {
    threshold5_ = threshold4_;
    if (took_[2]) {
      threshold4_ = threshold_;
    }
    const StateWord word = mem_data_i.read();
    for (int lane = 0; lane < kCodeLanes; ++lane) {
      state_[1][lane] = state_[0][lane];
      state_[0][lane] = word.range(kStateBits * lane + kStateBits - 1, kStateBits * lane).to_uint();
    }
    for (int i = 4; i > 0; --i) {
      pixels_[i] = pixels_[i - 1];
    }
    pixels_[0] = beat_pixels_i.read();
  }

  // Frames whose state came too late.
  void lateness() {
    const bool lost_before = lost4_ && !start_[2];
    const bool late = asked_[2] && mem_late_i.read();
    again5_ = again4_;
    lost5_ = lost4_;
    again4_ = lost_before;
    late_ = late && !lost_before;
    if (asked_[2]) {
      lost4_ = lost_before || mem_late_i.read();
    }
    for (int i = 5; i > 1; --i) {
      asked_[i] = asked_[i - 1];
    }
    asked_[1] = valid_[0] && decode_;
  }

  // Entry: settings, beats, frames that are too close to each other.
  void enter() {
    bool under_way = false;
    for (int i = 0; i < kTooClose - 1; ++i) {
      under_way = under_way || valid_[i];
    }
    const bool start = frame_start_i.read();
    const bool valid = beat_valid_i.read();
    const bool close = start && under_way && beats_ != kTooClose;
    if (start) {
      beats_ = 1;
    } else if (valid && beats_ != kTooClose) {
      beats_ = beats_ + 1;
    }
    for (int i = 6; i > 0; --i) {
      valid_[i] = valid_[i - 1];
      start_[i] = start_[i - 1];
      line_start_[i] = line_start_[i - 1];
      line_end_[i] = line_end_[i - 1];
      last_row_[i] = last_row_[i - 1];
      break_[i] = break_[i - 1];
      status_[i] = status_[i - 1];
    }
    for (int i = 3; i > 0; --i) {
      close_[i] = close_[i - 1];
      took_[i] = took_[i - 1];
    }
    valid_[0] = valid;
    start_[0] = start;
    line_start_[0] = beat_line_start_i.read();
    line_end_[0] = beat_line_end_i.read();
    last_row_[0] = beat_last_row_i.read();
    break_[0] = break_i.read();
    status_[0] = break_status_i.read();
    close_[0] = close;
    took_[0] = take_i.read();
    if (take_i.read()) {
      const PlaneCount bits = bits_i.read();
      const GrayPixel threshold = threshold_i.read();
      const Columns columns = columns_i.read();
      const Row rows = rows_i.read();
      decode_ = decode_i.read();
      changed_ = bits != bits_ || threshold != threshold_ || columns != columns_ || rows != rows_;
      bits_ = bits;
      threshold_ = threshold;
      columns_ = columns;
      rows_ = rows;
    }
  }

  // The outputs of a reset: what show() would give, as constants, because ICSC lets it see the registers as they were
  // before the reset.
  void show_reset() {
    mem_read_o.write(false);
    mem_read_first_o.write(false);
    mem_write_o.write(false);
    mem_write_first_o.write(false);
    mem_data_o.write(0);
    mem_end_o.write(false);
    codes_valid_o.write(false);
    codes_o.write(0);
    codes_start_o.write(false);
    codes_line_start_o.write(false);
    codes_line_end_o.write(false);
    codes_last_row_o.write(false);
    codes_break_o.write(false);
    codes_status_o.write(0);
    abandoned_o.write(0);
  }

  // The outputs of the clock that begins.
  void show() {
    mem_read_o.write(valid_[0] && decode_);
    mem_read_first_o.write(start_[0]);
    mem_write_o.write(asked_[5]);
    mem_write_first_o.write(start_[5]);
    StateWord word = 0;
    for (int lane = kCodeLanes - 1; lane >= 0; --lane) {
      word = word << kStateBits;
      word = word | StateWord(state6_[lane]);
    }
    mem_data_o.write(word);
    mem_end_o.write(break_[6] || (valid_[6] && line_end_[6] && last_row_[6]));
    codes_valid_o.write(codes_valid_);
    codes_o.write(codes_);
    codes_start_o.write(codes_start_);
    codes_line_start_o.write(codes_line_start_);
    codes_line_end_o.write(codes_line_end_);
    codes_last_row_o.write(codes_last_row_);
    codes_break_o.write(break_[6] || late8_);
    Status status = status_[6];
    if (late8_) {
      status = spec::kStatusLateMemory;
    }
    codes_status_o.write(status);
    abandoned_o.write(abandoned_);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_GRAY_DECODER_SHELL_H
