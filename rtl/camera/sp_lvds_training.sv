// Trains the lanes of a serial sensor: for each lane the tap of its delay, and where its words begin.
//
// A lane is measured like this: its deserializer's words must be the same 2^LogWindow times in a row,
// and be the training word, turned by some bits (the slip). Of the control lane every word counts.
// Of a data lane, only those words count that arrive while the control lane says that the sensor
// sends training words. A lane for which this does not come within 2^LogPatience words gives no
// result.
//
// Bits: after a reset, a lane is measured at each of the Taps taps. Of the longest run of taps with
// the same slip, the middle one is set. Where the lane gives its word for the first time, the taps
// begin again with the first one: before, the cable may have been out. Meanwhile the sensor sends
// training words, and the control lane ControlIdle; a data lane's taps can also be found in the gaps
// between frames. Words: one more measurement gives the slip. Then aligned_o rises. Lanes are trained
// one after the other, the control lane first.
//
// Loss: lost_i takes a lane's aligned_o back. The loss of the control lane takes back those of all
// lanes. Such a lane is measured again at the tap that it has: the usual reason is that the cable or
// the sensor's clock was away. This works in the gaps of a running sensor, too. There, flags may stand
// in the control lane's words, so only the bits under IdleMask must be those of ControlIdle. If more
// than one slip fits, the next try begins behind the one that was lost; that the first one was wrong
// shows as soon as the words of a frame are not legal. Taps are searched again only after a reset.
//
// Failure: failed_o of a lane rises when a try ends without a result, and falls when it is aligned.
// Trying goes on for ever.
//
// Delays: tap_load_o sets a lane's delay to tap 0. tap_move_o changes it by one tap, up or down by
// tap_up_o. Both are low for four clocks or more and then high for four. tap_up_o stands still from
// four clocks before a pulse until after it. Settle words after that, the words must show the new tap.
//
// Deskew: newer_o with the slips aligns the words of all lanes to those of the control lane if a lane
// is early or late by less than half a word. Nothing in the training words tells whole words apart.
//
// Time: a tap takes Settle + 2^LogWindow + Bits + 20 words and 8 clocks if the lane is right, with
// valid words in every clock; 16 lanes with 128 taps about 0.2 million words. In a running sensor,
// a tap takes up to 2^LogPatience words.
//
//   state      pick  load  settle measure turn  move  settle measure ... turn  move  settle measure
//   tap        ----- 0     0      0       0     1     1      1           127   (to the middle)
//   aligned_o  ___________________________________________________________________________________/1
`default_nettype none

module sp_lvds_training #(
  parameter int Lanes = 16,  // data lanes: 1..16
  parameter int Bits = 10,  // of a word: 8, 10 or 12
  parameter logic [11:0] Training = 12'h055,  // of data lanes, in the order of arrival: bit 0 first
  parameter logic [11:0] ControlIdle = 12'h200,  // of the control lane, likewise
  parameter logic [11:0] IdleMask = 12'hFFF,  // bits of ControlIdle that always stand, likewise
  parameter int Taps = 128,  // of a lane's delay: 1..128; 1: there is none
  parameter int Settle = 16,  // words until a new tap shows: 1..255
  parameter int LogWindow = 5,  // log2 of the words of a measurement: 2..10
  parameter int LogPatience = 13  // log2 of the words until it is given up: 6..20
) (
  input  wire logic                      clk_i,
  input  wire logic                      rst_i,       // active high, synchronous

  // Words; lane Lanes is the control lane
  input  wire logic                      en_i,
  input  wire logic [(Lanes+1)*Bits-1:0] lanes_i,     // bit 0 of a word arrived first
  input  wire logic                      decoded_i,   // pulse: a control word has been decoded
  input  wire logic                      idle_i,      // with it: data lanes carry training words
  input  wire logic [Lanes:0]            lost_i,      // pulses: a lane has lost its alignment
  output logic      [4*(Lanes+1)-1:0]    slips_o,
  output logic      [Lanes:0]            newer_o,
  output logic      [Lanes:0]            aligned_o,
  output logic      [Lanes:0]            failed_o,

  // Delays
  output logic      [Lanes:0]            tap_load_o,
  output logic      [Lanes:0]            tap_move_o,
  output logic                           tap_up_o
);

  if (Lanes < 1 || Lanes > 16) begin : gen_lanes
    lanes_is_not_in_1_to_16 u_error ();
  end
  if (Bits != 8 && Bits != 10 && Bits != 12) begin : gen_bits
    bits_is_not_8_10_or_12 u_error ();
  end
  if (Taps < 1 || Taps > 128) begin : gen_taps
    taps_is_not_in_1_to_128 u_error ();
  end
  if (Settle < 1 || Settle > 255) begin : gen_settle
    settle_is_not_in_1_to_255 u_error ();
  end
  if (LogWindow < 2 || LogWindow > 10) begin : gen_log_window
    log_window_is_not_in_2_to_10 u_error ();
  end
  if (LogPatience < 6 || LogPatience > 20) begin : gen_log_patience
    log_patience_is_not_in_6_to_20 u_error ();
  end

  localparam int LaneBits = $clog2(Lanes + 1);
  localparam logic [LaneBits-1:0] Control = LaneBits'(Lanes);
  localparam int SettleBits = Settle < 1 ? 1 : $clog2(Settle + 1);
  localparam logic [6:0] LastTap = 7'(Taps - 1);
  localparam logic [3:0] Half = 4'(Bits / 2);

  localparam logic [2:0] Pick = 3'd0;     // a lane that is not aligned
  localparam logic [2:0] Act = 3'd1;      // the delay's pulse
  localparam logic [2:0] Wait = 3'd2;     // Settle words
  localparam logic [2:0] Measure = 3'd3;
  localparam logic [2:0] Turn = 3'd4;     // is it the training word, and turned by how much?
  localparam logic [2:0] Note = 3'd5;     // the result at a tap
  localparam logic [2:0] Compare = 3'd6;  // is its run of taps the longest?
  localparam logic [2:0] Choose = 3'd7;   // the best tap

  logic [2:0]             state_q;
  logic [LaneBits-1:0]    lane_q;
  logic [Lanes:0]         swept_q;      // the delay stands at a tap that was found
  logic                   alive_q;      // the lane has given its word, at some tap, since it was picked
  logic                   final_q;      // at the best tap
  logic                   load_q;       // the pulse loads
  logic [2:0]             pulse_q;      // its clocks
  logic [SettleBits-1:0]  settle_q;
  logic [LogPatience-1:0] patience_q;
  logic [LogWindow-1:0]   same_q;       // words in a row that were equal
  logic [Bits-1:0]        word_q;       // these words; turned
  logic [Bits-1:0]        turned_q;
  logic [3:0]             turn_q;
  logic                   again_q;      // all turns have been seen once
  logic [3:0]             first_q;      // of the control lane: the turn with which to begin
  logic                   good_q;
  logic [6:0]             tap_q, target_q;
  logic                   run_good_q;   // the last tap was good
  logic [3:0]             run_turn_q;
  logic [6:0]             run_first_q, best_first_q;
  logic [7:0]             run_q, best_q;  // taps
  logic [3:0]             idle_q;       // control words in a row that said training, at most 15

  // --- The words of the lane, some words ago, so that the control lane is decoded before and behind ---
  logic            en_q;
  logic [Bits-1:0] raw;
  logic [Bits-1:0] raw_q, raw_q2, raw_q3, raw_q4, raw_q5;
  logic            of_control, counts;
  logic            control_q;  // of_control a clock ago: the same but in Pick
  logic            reached_q;  // the turn with which to begin is reached, or there is none
  logic            control_aligned, lane_aligned;
  logic [Bits-1:0] wanted, mask;
  logic            is_wanted;

  always_comb begin
    raw          = '0;
    lane_aligned = 1'b0;
    for (int i = 0; i <= Lanes; i++) begin
      if (lane_q == LaneBits'(i)) begin
        raw |= lanes_i[Bits*i+:Bits];
        lane_aligned |= aligned_o[i];
      end
    end
  end

  assign of_control      = lane_q == Control;
  assign control_aligned = aligned_o[Lanes];
  assign wanted          = control_q ? ControlIdle[Bits-1:0] : Training[Bits-1:0];
  assign mask            = control_q && final_q ? IdleMask[Bits-1:0] : '1;
  assign is_wanted       = (turned_q & mask) == (wanted & mask) && reached_q;
  assign counts          = en_q && (control_q || idle_q >= 4'd9);

  always_ff @(posedge clk_i) begin
    en_q      <= en_i;
    control_q <= of_control;
    if (en_i) begin
      raw_q  <= raw;
      raw_q2 <= raw_q;
      raw_q3 <= raw_q2;
      raw_q4 <= raw_q3;
      raw_q5 <= raw_q4;
    end
    if (rst_i || !control_aligned || decoded_i && !idle_i) idle_q <= '0;
    else if (decoded_i && idle_q != '1) idle_q <= idle_q + 1'b1;
  end

  // --- One lane after the other ---
  logic [3:0] control_slip;
  logic       abandon;  // a data lane cannot be measured without the control lane
  logic [7:0] run;
  logic [6:0] run_first;
  logic       joins;    // the tap belongs to the run of the one before

  assign control_slip = slips_o[4*Lanes+:4];

  assign abandon   = !control_q && !control_aligned;
  assign joins     = good_q && run_good_q && turn_q == run_turn_q;
  assign run       = !good_q ? 8'd0 : joins ? run_q + 8'd1 : 8'd1;
  assign run_first = joins ? run_first_q : tap_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      state_q   <= Pick;
      lane_q    <= Control;
      alive_q   <= 1'b0;
      swept_q   <= '0;
      first_q   <= '0;
      aligned_o <= '0;
      failed_o  <= '0;
    end else begin
      case (state_q)
        Pick: begin
          final_q    <= Taps == 1;
          load_q     <= 1'b1;
          pulse_q    <= '0;
          settle_q   <= '0;
          tap_q      <= '0;
          target_q   <= '0;
          tap_up_o   <= 1'b1;
          best_q     <= '0;
          run_good_q <= 1'b0;
          if (!control_aligned && !of_control) begin
            lane_q  <= Control;
            alive_q <= 1'b0;
          end else if (lane_aligned) lane_q <= of_control ? '0 : lane_q + 1'b1;
          else begin
            state_q <= Taps == 1 ? Wait : Act;
            for (int i = 0; i <= Lanes; i++) begin
              if (lane_q == LaneBits'(i) && swept_q[i]) begin
                final_q <= 1'b1;
                state_q <= Wait;
              end
            end
          end
        end
        Act: if (Taps > 1) begin
          pulse_q  <= pulse_q + 1'b1;
          settle_q <= '0;
          if (pulse_q == '1) begin
            load_q <= 1'b0;
            if (!load_q) tap_q <= tap_up_o ? tap_q + 1'b1 : tap_q - 1'b1;
            // On the way to the best tap, nothing is measured.
            if (!(final_q && !load_q && tap_q != target_q + 7'd1)) state_q <= Wait;
          end
        end
        Wait: begin
          patience_q <= '0;
          same_q     <= '0;
          word_q     <= raw_q5;
          if (en_i) settle_q <= settle_q + 1'b1;
          if (settle_q == SettleBits'(Settle)) state_q <= Measure;
        end
        Measure: begin
          turned_q  <= word_q;
          turn_q    <= '0;
          reached_q <= !control_q || first_q == '0;
          again_q   <= 1'b0;
          good_q    <= 1'b0;
          if (counts) begin
            word_q <= raw_q5;
            same_q <= raw_q5 == word_q ? same_q + 1'b1 : '0;
          end
          if (same_q == '1) state_q <= Turn;
          else if (patience_q == '1) state_q <= Note;
        end
        Turn: begin
          same_q <= '0;
          turned_q <= {turned_q[0], turned_q[Bits-1:1]};
          if (is_wanted) begin
            good_q  <= 1'b1;
            state_q <= Note;
          end else if (turn_q == 4'(Bits - 1)) begin
            turn_q    <= '0;
            again_q   <= 1'b1;
            reached_q <= 1'b1;
            if (again_q || !control_q) state_q <= Measure;
          end else begin
            turn_q <= turn_q + 1'b1;
            if (turn_q + 1'b1 == first_q) reached_q <= 1'b1;
          end
        end
        Note: begin
          run_good_q  <= good_q;
          run_turn_q  <= turn_q;
          run_q       <= run;
          run_first_q <= run_first;
          state_q     <= Compare;
        end
        Compare: begin
          if (run_q > best_q) begin
            best_q       <= run_q;
            best_first_q <= run_first_q;
          end
          if (final_q || Taps == 1) begin
            state_q <= Pick;
            alive_q <= 1'b0;
            lane_q  <= control_q ? '0 : lane_q + 1'b1;
            for (int i = 0; i <= Lanes; i++) begin
              if (lane_q == LaneBits'(i)) begin
                aligned_o[i] <= good_q && !abandon;
                failed_o[i]  <= !good_q;
                if (good_q) swept_q[i] <= 1'b1;
                if (good_q) slips_o[4*i+:4] <= turn_q;
              end
            end
          end else if (good_q && !alive_q) begin
            alive_q <= 1'b1;
            state_q <= Pick;
          end else state_q <= tap_q == LastTap ? Choose : Act;
        end
        default: if (Taps > 1) begin  // Choose
          final_q  <= 1'b1;
          tap_up_o <= 1'b0;
          target_q <= best_first_q + best_q[7:1];
          if (best_q == '0) begin
            state_q <= Pick;
            alive_q <= 1'b0;
            lane_q  <= control_q ? '0 : lane_q + 1'b1;
            for (int i = 0; i <= Lanes; i++) if (lane_q == LaneBits'(i)) failed_o[i] <= 1'b1;
          end else state_q <= best_first_q + best_q[7:1] == LastTap ? Wait : Act;
        end
      endcase
      if ((state_q == Measure || state_q == Turn) && en_i && patience_q != '1)
        patience_q <= patience_q + 1'b1;
      if (state_q != Pick && (state_q != Act || pulse_q == '1) && abandon) state_q <= Pick;
      for (int i = 0; i <= Lanes; i++) if (lost_i[i] || lost_i[Lanes]) aligned_o[i] <= 1'b0;
      if (lost_i[Lanes]) first_q <= control_slip == 4'(Bits - 1) ? '0 : control_slip + 1'b1;
    end
    tap_load_o <= '0;
    tap_move_o <= '0;
    for (int i = 0; i <= Lanes; i++) begin
      if (Taps > 1 && state_q == Act && pulse_q[2] && lane_q == LaneBits'(i) && !rst_i) begin
        tap_load_o[i] <= load_q;
        tap_move_o[i] <= !load_q;
      end
    end
  end

  // --- Deskew: the control lane's words begin between half a word and one and a half words behind the
  // deserializer's, those of the other lanes half a word before to half a word behind them ---
  logic [3:0] edge_q;

  always_ff @(posedge clk_i) begin
    edge_q <= control_slip < Half ? control_slip + Half : control_slip - Half;
    for (int i = 0; i <= Lanes; i++) newer_o[i] <= slips_o[4*i+:4] < edge_q;
  end

`ifdef FORMAL
  // Assumption: one reset at the beginning.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q);

  function automatic logic [Bits-1:0] turned(input logic [Bits-1:0] word, input logic [3:0] slip);
    turned = Bits'({word, word} >> slip);
  endfunction

  // What is measured: the last word of the lane that counted, and how many came like it
  logic [Bits-1:0]      f_last_q;
  logic [LogWindow-1:0] f_times_q;
  logic [Bits-1:0]      f_base_q;   // the word of the measurement that is over
  logic                 f_full_q;   // it came 2^LogWindow times in a row
  logic                 f_kept_q;   // first_q is what it was then
  // One clock ago
  logic [Lanes:0]         f_aligned_q, f_lost_q;
  logic [4*(Lanes+1)-1:0] f_slips_q;
  logic                   f_right_q;  // the word, turned by the slip, is what it must be
  logic [LaneBits-1:0]    f_lane_q;
  logic [Bits-1:0]        f_word_q;
  always_ff @(posedge clk_i) begin
    if (state_q != Measure) f_times_q <= '0;
    else if (counts) f_times_q <= raw_q5 != f_last_q ? '0 : f_times_q == '1 ? '1 : f_times_q + 1'b1;
    if (state_q == Wait || state_q == Measure && counts) f_last_q <= raw_q5;
    if (state_q == Measure) {f_full_q, f_base_q} <= {f_times_q == '1, f_last_q};
    f_kept_q <= (state_q == Measure || f_kept_q) && !lost_i[Lanes];
    f_aligned_q <= rst_i ? '0 : aligned_o;
    f_lost_q    <= rst_i ? '1 : lost_i;
    f_slips_q   <= slips_o;
    f_right_q   <= f_full_q && ((turned(f_base_q, turn_q) ^ wanted) & mask) == '0;
    f_lane_q    <= lane_q;
    f_word_q    <= f_base_q;
  end

  always_comb if (f_ran_q) begin
    for (int i = 0; i <= Lanes; i++) begin
      // Rule 1: a lane locks only if its word came 2^LogWindow times in a row and is the training
      // word, turned by its slip. A data lane's is turned by no other.
      if (aligned_o[i] && !f_aligned_q[i]) assert (f_right_q && f_lane_q == LaneBits'(i));
      for (int k = 0; k < Bits; k++) begin
        if (i < Lanes && aligned_o[i] && !f_aligned_q[i]) begin
          assert ((turned(f_word_q, 4'(k)) == Training[Bits-1:0]) == (slips_o[4*i+:4] == 4'(k)));
        end
      end
      // Rule 2: a lane that is locked stays so, with its slip and its delay, until it is lost.
      if (f_aligned_q[i] && !f_lost_q[i] && !f_lost_q[Lanes]) begin
        assert (aligned_o[i] && slips_o[4*i+:4] == f_slips_q[4*i+:4]);
      end
      if (aligned_o[i]) assert (!tap_load_o[i] && !tap_move_o[i]);
      // Rule 3: lost is lost; data lanes lock only while the control lane is locked.
      if (f_lost_q[i] || f_lost_q[Lanes]) assert (!aligned_o[i]);
      if (aligned_o[i]) assert (i == Lanes || aligned_o[Lanes]);
    end
    // The registers agree with that.
    assert (lane_q <= Control);
    if (state_q == Turn || state_q == Note || state_q == Compare) assert (turn_q < 4'(Bits));
    if (state_q != Pick) assert (!lane_aligned && control_q == of_control);
    if (state_q == Turn && f_kept_q) assert (reached_q == (again_q || !of_control || turn_q >= first_q));
    if (state_q == Measure || state_q == Turn) assert (f_last_q == word_q);
    if (state_q == Measure) assert (f_times_q == same_q);
    if (state_q == Turn) assert (f_full_q && turned_q == turned(f_base_q, turn_q));
    if ((state_q == Note || state_q == Compare) && good_q) begin
      assert (f_full_q && ((turned(f_base_q, turn_q) ^ wanted) & mask) == '0);
    end
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (aligned_o == '1);
    cover (f_aligned_q[Lanes] && !aligned_o[Lanes]);
  end
`endif

endmodule

`default_nettype wire
