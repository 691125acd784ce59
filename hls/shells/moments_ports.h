// What ColumnMomentsShell and ColumnRunsShell have in common: the ports of beats, payload and line buffer, and the
// registers of breaks and of spoiled frames.
#ifndef SELFPROJ_HLS_SHELLS_MOMENTS_PORTS_H
#define SELFPROJ_HLS_SHELLS_MOMENTS_PORTS_H

#include <systemc>

#include "hls/moments_arithmetic.h"

namespace selfproj {
namespace hls {

template <typename F>
class MomentsPorts : public sc_core::sc_module {
 public:
  using Pixel = typename F::Pixel;
  using Pixels = typename F::Pixels;
  using Group = typename F::Group;
  using Payload = typename F::Payload;

  sc_core::sc_in<bool> clk_i{"clk_i"};
  sc_core::sc_in<bool> rst_i{"rst_i"};

  // A beat and its place, as in the RTL
  sc_core::sc_in<bool> beat_valid_i{"beat_valid_i"};
  sc_core::sc_in<Pixels> beat_pixels_i{"beat_pixels_i"};
  sc_core::sc_in<Group> beat_group_i{"beat_group_i"};
  sc_core::sc_in<Row> beat_row_i{"beat_row_i"};
  sc_core::sc_in<bool> beat_first_row_i{"beat_first_row_i"};
  sc_core::sc_in<bool> beat_last_row_i{"beat_last_row_i"};
  sc_core::sc_in<bool> beat_line_end_i{"beat_line_end_i"};
  sc_core::sc_in<ModeBits> mode_i{"mode_i"};
  sc_core::sc_in<Pixel> threshold_i{"threshold_i"};
  sc_core::sc_in<bool> break_i{"break_i"};
  sc_core::sc_in<bool> accept_i{"accept_i"};

  // Payload
  sc_core::sc_out<bool> moments_valid_o{"moments_valid_o"};
  sc_core::sc_out<Payload> moments_data_o{"moments_data_o"};
  sc_core::sc_out<bool> moments_break_o{"moments_break_o"};
  sc_core::sc_out<bool> spoiled_o{"spoiled_o"};

  // Line buffer: the weights of a last row
  sc_core::sc_out<bool> line_rd_en_o{"line_rd_en_o"};
  sc_core::sc_out<Group> line_rd_addr_o{"line_rd_addr_o"};
  sc_core::sc_in<Pixels> line_rd_data_i{"line_rd_data_i"};
  sc_core::sc_out<bool> line_wr_en_o{"line_wr_en_o"};
  sc_core::sc_out<Group> line_wr_addr_o{"line_wr_addr_o"};
  sc_core::sc_out<Pixels> line_wr_data_o{"line_wr_data_o"};

  SC_HAS_PROCESS(MomentsPorts);
  explicit MomentsPorts(const sc_core::sc_module_name& name) : sc_module(name) {
    SC_METHOD(write_line);
    this->sensitive << s4_drain_row_ << accept_i;
  }

 protected:
  // The weights of a last row are kept if its packet was accepted, which is known in the same clock.
  sc_core::sc_signal<bool> s4_drain_row_{"s4_drain_row"};

  void write_line() { line_wr_en_o.write(s4_drain_row_.read() && accept_i.read()); }

  bool break_[3];  // stages 1 to 3
  // The request to the memories in this clock
  bool add_;
  bool drain_;
  bool spoiled_;

  void reset_common() {
    for (int i = 0; i < 3; ++i) {
      break_[i] = false;
    }
    add_ = false;
    drain_ = false;
    spoiled_ = false;
  }

  // The end of a clock with this beat in stage 4; `drained`: a drain was under way in the clock before.
  template <typename Beat>
  void spoil(const Beat& beat, bool drained) {
    if (beat.valid && beat.first_row) {
      spoiled_ = false;
    } else if (beat.valid && !beat.drains() && drained) {
      spoiled_ = true;
    }
  }

  // Stages 3 to 1 of breaks, and stage 1 of the beat.
  template <typename Beat>
  void enter_beat(Beat& beat) {
    break_[2] = break_[1];
    break_[1] = break_[0];
    break_[0] = break_i.read();
    beat.valid = beat_valid_i.read();
    beat.group = beat_group_i.read();
    beat.row = beat_row_i.read();
    beat.first_row = beat_first_row_i.read();
    beat.last_row = beat_last_row_i.read();
    beat.line_end = beat_line_end_i.read();
    beat.grey = mode_i.read() != spec::kModeBinary;
    Pixels pixels = beat_pixels_i.read();
    Pixel threshold = threshold_i.read();
    ModeBits mode = mode_i.read();
    beat.weights = weights_of<F>(pixels, threshold, mode);
  }

  // The outputs of a reset: what show() would give, as constants, because ICSC lets it see the registers as they were
  // before the reset.
  void show_reset_common() {
    moments_valid_o.write(false);
    moments_data_o.write(0);
    moments_break_o.write(false);
    spoiled_o.write(false);
    s4_drain_row_.write(false);
    line_wr_addr_o.write(0);
    line_wr_data_o.write(0);
    line_rd_en_o.write(false);
    line_rd_addr_o.write(0);
  }

  // The requests of the clock that begins, with this beat in stage 4 and this order of the drain. A first row needs no
  // read and may pass a drain. Any other row meets a drain only after a change of size: see spoiled_o.
  template <typename Beat, typename Order>
  void show_requests(const Beat& beat, const Order& order) {
    bool drains = beat.drains();
    add_ = beat.valid && !drains && (beat.first_row || !order.active);
    drain_ = order.drains();
    s4_drain_row_.write(drains);
    line_wr_addr_o.write(beat.group);
    line_wr_data_o.write(beat.weights);
    line_rd_en_o.write(drain_);
    line_rd_addr_o.write(order.group);
  }

  void show_payload(bool valid, const Payload& data, bool broke) {
    moments_valid_o.write(valid);
    moments_data_o.write(data);
    moments_break_o.write(broke);
    spoiled_o.write(spoiled_);
  }
};

}  // namespace hls
}  // namespace selfproj

#endif  // SELFPROJ_HLS_SHELLS_MOMENTS_PORTS_H
