// Dynamic phase alignment of a Channel Link whose deserializer runs by the clock of another link:
// finds the delay of its lanes and where its words begin, and outputs the words that are right.
//
//   lanes_i ─▶ turn ─▶ sp_channel_link_lock ─▶ word_o
//      │         ▲
//      └▶ search ┴─▶ tap_load_o, tap_move_o: a delay in front of each lane's deserializer
//
// The links of a camera have one frequency, but each its own phase. In every clock the deserializer
// brings seven samples of each lane, one of each bit. The clock lane reads 1100011 in every word, so
// it brings this pattern, turned by where the words begin.
//
// Search: all five lanes stand at the same tap. A tap is good if the clock lane brings the same
// seven samples 2^LogWindow times in a row, and they are the pattern, turned. All Taps taps are
// tried from the first one on. The eye of a bit reaches from the first to the last good tap that are
// turned alike; a tap between them that is not good, by a disturbance, does not matter. In the
// middle of the widest eye the tap is set, and its turn gives the words. So the clock lane is
// sampled in the middle of its bits, and the data lanes off the middle by what they are early or
// late against it. If the taps cover less than two bits, that may be less than the middle, but never
// nearer to an edge than a quarter of what they cover. They must cover less than seven.
//
// The search starts again at the first tap when a tap is good for the first time, because the cable
// may have come after the first taps, and when the clock lane has stood still for a word, because
// then the cable was out. A cable that is out must give a level that stands, as receivers with a
// fail-safe do. If noise comes instead and the cable goes and comes within one search, the tap may
// be nearer to an edge than it must be. A reset starts a search, too.
//
// Guarantees: the taps and the turn stay as they are while locked_o is high. A word is output only
// while locked_o is high, only if the clock lane reads 1100011 in it. Any other word ends the lock
// at once (error_o). Then the search begins if the clock lane has stood still for a word: the phase
// may be another one. Otherwise the lock may come again by itself; if it does not come within
// 2^LogPatience clocks, the search begins. A data lane that is off by more than the clock lane's tap
// is from an edge gives wrong bits, as in sp_channel_link_lock.
//
// Delays: tap_load_o sets tap 0, the least delay, and each fall of tap_move_o adds one tap; both are
// high for four clocks, and low for at least four before the next. From Settle clocks after its fall
// on, the samples must show the tap.
//
// Latency: a word leaves four clocks after its last samples were at the input, or five where it
// begins with a clock's samples. A search takes Taps * (Settle + 2^LogWindow + 13) clocks, at most
// as many before the first good tap, at most 8 * Taps to set the tap, and Settle + 2^LogGood + 20 to
// lock.
//
//   clock       0    1    2    3    4    5    6
//   lanes_i    <0  ><1  ><2  ><3  ><4  ><5     turned by two: word 1 begins with the last five
//   valid_o    _________________________/111   samples of clock 1
//   word_o     -------------------------<0  >
`default_nettype none

module sp_channel_link_align #(
  parameter int Taps = 128,  // of the delays: 2..128
  parameter int Settle = 16,  // clocks until a new tap shows: 1..255
  parameter int LogWindow = 8,  // log2 of the clocks for which a tap is looked at: 2..16
  parameter int LogGood = 8,  // log2 of the right words before it locks: 1..19
  parameter int LogPatience = 11  // log2 of the clocks without a lock until it searches: more than
                                  // LogGood, 6..20
) (
  input  wire logic        clk_i,     // clock of the deserializer's samples
  input  wire logic        rst_i,     // active high, synchronous; high while clk_i is not stable
  input  wire logic [34:0] lanes_i,   // lane n in 7n+6..7n, its first sample in 7n; 4: clock lane
  output logic             tap_load_o,
  output logic             tap_move_o,
  output logic             locked_o,
  output logic             valid_o,   // word_o holds a word
  output logic      [27:0] word_o,    // bit i is output i of a receiver chip
  output logic             error_o    // pulse: the lock was lost
);

  if (Taps < 2 || Taps > 128) begin : gen_taps
    taps_is_not_in_2_to_128 u_error ();
  end
  if (Settle < 1 || Settle > 255) begin : gen_settle
    settle_is_not_in_1_to_255 u_error ();
  end
  if (LogWindow < 2 || LogWindow > 16) begin : gen_log_window
    log_window_is_not_in_2_to_16 u_error ();
  end
  if (LogPatience < 6 || LogPatience > 20 || LogPatience <= LogGood) begin : gen_log_patience
    log_patience_is_not_in_6_to_20_and_above_log_good u_error ();
  end

  localparam logic [6:0] Pattern = 7'b1100011;
  localparam int TapBits = $clog2(Taps);
  localparam int RunBits = $clog2(Taps + 1);
  localparam logic [TapBits-1:0] LastTap = TapBits'(Taps - 1);
  localparam int SettleBits = Settle < 1 ? 1 : $clog2(Settle + 3);  // and two on the way

  localparam logic [2:0] Act = 3'd0;      // the delays' pulse
  localparam logic [2:0] Wait = 3'd1;     // Settle clocks
  localparam logic [2:0] Measure = 3'd2;
  localparam logic [2:0] Note = 3'd3;     // the result at a tap
  localparam logic [2:0] Compare = 3'd4;  // is its eye the widest?
  localparam logic [2:0] Choose = 3'd5;   // the middle of the widest eye
  localparam logic [2:0] Run = 3'd6;

  function automatic logic [6:0] turned(input logic [6:0] samples, input logic [2:0] by);
    turned = 7'({samples, samples} >> by);
  endfunction

  // --- The samples, and the words that begin in the clock before ---
  logic [34:0] now_q, before_q, words;
  logic [2:0]  turn_q;  // samples of before_q that belong to the word before

  always_ff @(posedge clk_i) begin
    now_q    <= lanes_i;
    before_q <= now_q;
  end
  for (genvar n = 0; n < 5; n++) begin : gen_lane
    assign words[7*n+:7] = 7'({now_q[7*n+:7], before_q[7*n+:7]} >> turn_q);
  end

  // --- Search ---
  logic [2:0]             state_q;
  logic                   alive_q;  // a tap was good, so the search has started again
  logic                   final_q;  // on the way to the best tap
  logic                   load_q;   // the pulse loads
  logic [2:0]             pulse_q;
  logic [SettleBits-1:0]  settle_q;
  logic [LogWindow-1:0]   window_q;
  logic [6:0]             clock_q;  // what the clock lane brought first
  logic                   steady_q;
  logic                   good_q;
  logic [TapBits-1:0]     tap_q, target_q;
  logic [2:0]             run_turn_q, best_turn_q;  // of the last eye, and of the widest one
  logic [TapBits-1:0]     run_first_q, best_first_q;
  logic [RunBits-1:0]     run_q, best_q;  // taps of it; 0: there is none
  logic [LogPatience-1:0] patience_q;
  logic                   gone_q;   // the clock lane has stood still since the search started
  logic                   is_turned;
  logic [2:0]             turn;     // of clock_q
  logic                   joins;    // the tap is turned as the last good one
  logic [TapBits-1:0]     next_tap;
  logic                   give_up;

  always_comb begin
    is_turned = 1'b0;
    turn      = '0;
    for (int by = 0; by < 7; by++) begin
      if (turned(clock_q, 3'(by)) == Pattern) begin
        is_turned = 1'b1;
        turn |= 3'(by);
      end
    end
  end

  assign joins    = run_q != '0 && turn == run_turn_q;
  assign next_tap = load_q ? '0 : tap_q + 1'b1;
  assign give_up  = !locked_o && (patience_q == '1 || gone_q);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      state_q <= Act;
      load_q  <= 1'b1;
      final_q <= 1'b0;
      alive_q <= 1'b0;
      tap_q   <= '0;
      pulse_q <= '0;
      run_q   <= '0;
      best_q  <= '0;
    end else begin
      case (state_q)
        Act: begin
          settle_q <= '0;
          pulse_q  <= pulse_q + 1'b1;
          if (pulse_q == '1) begin
            load_q <= 1'b0;
            tap_q  <= next_tap;
            if (!final_q || next_tap == target_q) state_q <= Wait;
          end
        end
        Wait: begin
          settle_q   <= settle_q + 1'b1;
          window_q   <= '0;
          steady_q   <= 1'b1;
          clock_q    <= now_q[34:28];
          patience_q <= '0;
          if (settle_q == SettleBits'(Settle + 2)) state_q <= final_q ? Run : Measure;
        end
        Measure: begin
          window_q <= window_q + 1'b1;
          if (now_q[34:28] != clock_q) steady_q <= 1'b0;
          if (window_q == '1) state_q <= Note;
        end
        Note: begin
          good_q  <= steady_q && is_turned;
          state_q <= Compare;
          if (steady_q && is_turned) begin
            run_q      <= joins ? RunBits'(tap_q - run_first_q) + 1'b1 : RunBits'(1);
            run_turn_q <= turn;
            if (!joins) run_first_q <= tap_q;
          end
        end
        Compare: begin
          if (run_q > best_q) begin
            best_q       <= run_q;
            best_first_q <= run_first_q;
            best_turn_q  <= run_turn_q;
          end
          state_q <= tap_q == LastTap ? Choose : Act;
          if (gone_q || good_q && !alive_q) begin
            alive_q <= good_q && !gone_q;
            load_q  <= 1'b1;
            run_q   <= '0;
            best_q  <= '0;
            state_q <= Act;
          end
        end
        Choose: begin
          target_q <= best_first_q + TapBits'(best_q >> 1);
          turn_q   <= best_turn_q;
          final_q  <= best_q != '0;
          alive_q  <= 1'b0;
          load_q   <= 1'b1;
          run_q    <= '0;
          best_q   <= '0;
          state_q  <= Act;
        end
        default: begin  // Run
          final_q    <= 1'b0;
          load_q     <= 1'b1;
          patience_q <= locked_o ? '0 : patience_q + 1'b1;
          if (give_up) state_q <= Act;
        end
      endcase
    end
    if (now_q[34:28] == '0 || now_q[34:28] == '1) gone_q <= 1'b1;
    else if (state_q == Act && load_q && !final_q) gone_q <= 1'b0;
    tap_load_o <= state_q == Act && pulse_q[2] && load_q && !rst_i;
    tap_move_o <= state_q == Act && pulse_q[2] && !load_q && !rst_i;
  end

  // --- The words ---
  logic unused;

  sp_channel_link_lock #(
    .LogGood(LogGood)
  ) u_lock (
    .clk_i   (clk_i),
    .rst_i   (rst_i || state_q != Run || give_up),
    .lanes_i (words),
    .align_o (unused),
    .locked_o(locked_o),
    .valid_o (valid_o),
    .word_o  (word_o),
    .error_o (error_o)
  );

`ifdef FORMAL
  // Assumption: one reset at the beginning.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q);

  // The delay, as its pulses move it, and what each tap has shown
  logic [TapBits-1:0]   f_tap_q;
  logic [TapBits-1:0]   f_first_tap_q, f_last_tap_q;  // of the eye that was chosen
  logic                 f_known_q;  // it has been loaded
  logic                 f_move_q, f_locked_q, f_search_q;
  logic [2:0]           f_turn_q, f_state_q;
  logic [6:0]           f_first_q;  // the first samples of the clock lane
  logic [LogWindow:0]   f_equal_q;  // samples that were equal to them, in a row from the first on
  logic [Taps-1:0]      f_good_q;
  logic [3*Taps-1:0]    f_turns_q;
  always_ff @(posedge clk_i) begin
    f_move_q   <= tap_move_o && !rst_i;
    f_locked_q <= locked_o && !rst_i;
    f_turn_q   <= turn_q;
    f_state_q  <= state_q;
    if (rst_i) f_known_q <= 1'b0;
    else if (tap_load_o) {f_known_q, f_tap_q} <= {1'b1, {TapBits{1'b0}}};
    else if (f_move_q && !tap_move_o) f_tap_q <= f_tap_q + 1'b1;
    if (state_q == Wait) {f_equal_q, f_first_q} <= {{LogWindow + 1{1'b0}}, now_q[34:28]};
    else if (state_q == Measure && now_q[34:28] == f_first_q &&
             f_equal_q == (LogWindow + 1)'(window_q)) f_equal_q <= f_equal_q + 1'b1;
    if (state_q == Choose) begin
      f_first_tap_q <= best_first_q;
      f_last_tap_q  <= best_first_q + TapBits'(best_q - 1'b1);
    end
    if (state_q == Note) begin
      for (int i = 0; i < Taps; i++) begin
        if (tap_q == TapBits'(i)) begin
          f_good_q[i]  <= f_equal_q[LogWindow] && turned(f_first_q, turn) == Pattern;
          f_turns_q[3*i+:3] <= turn;
        end
      end
    end
  end

  // The tap is the first or the last one of an eye.
  function automatic logic at_end(input logic [TapBits-1:0] first, input logic [RunBits-1:0] taps,
                                  input int tap);
    at_end = taps != '0 && (8'(tap) == 8'(first) || 8'(tap) + 8'd1 == 8'(first) + 8'(taps));
  endfunction

  always_comb if (f_ran_q) begin
    // Rule 1: the taps and the turn stay while the link is locked, and words come only then.
    if (locked_o) assert (state_q == Run && !tap_move_o && !tap_load_o);
    if (f_locked_q && locked_o) assert (turn_q == f_turn_q);
    if (valid_o) assert (locked_o);
    // Rule 2: the delay stands at tap_q while a tap is looked at and while words are given.
    if (state_q == Measure || state_q == Note || state_q == Run) begin
      assert (f_known_q && !tap_load_o);
      assert (!tap_move_o);
      assert (!f_move_q);
      assert (f_tap_q == tap_q);
    end
    // Rule 3: the tap of the words is one of an eye, whose first and last tap were good, and turned
    // as the words are.
    if (state_q == Run || final_q) assert (target_q >= f_first_tap_q && target_q <= f_last_tap_q);
    for (int i = 0; i < Taps; i++) begin
      if ((state_q == Run || final_q) && (f_first_tap_q == TapBits'(i) || f_last_tap_q == TapBits'(i)))
        assert (f_good_q[i] && f_turns_q[3*i+:3] == turn_q);
      if (at_end(best_first_q, best_q, i)) assert (f_good_q[i] && f_turns_q[3*i+:3] == best_turn_q);
      if (at_end(run_first_q, run_q, i)) assert (f_good_q[i] && f_turns_q[3*i+:3] == run_turn_q);
    end
    if (state_q == Run) assert (tap_q == target_q);
    // Rule 4: each eye is compared with the widest one.
    if (state_q == Choose) assert (tap_q == LastTap && run_q <= best_q);

    // The registers agree with that. Pulses and the delay:
    assert (state_q <= Run && tap_q <= LastTap);
    if (state_q == Act && !load_q && !final_q) assert (tap_q < LastTap);
    if (state_q != Act) assert (pulse_q == '0);
    if (state_q != Act && state_q != Run) assert (!load_q);
    if (state_q == Act && pulse_q >= 3'd5) assert (tap_load_o == load_q && tap_move_o == !load_q);
    else if (state_q == Act ? pulse_q != '0 : state_q == Wait ? settle_q != '0 : 1'b1)
      assert (!tap_load_o && !tap_move_o);
    if (state_q == Act ? pulse_q >= 3'd2 && pulse_q <= 3'd5 : state_q == Wait ? settle_q > 1 : 1'b1)
      assert (!f_move_q);
    if (state_q == Wait) assert (settle_q <= SettleBits'(Settle + 2));
    if (tap_load_o) assert (!tap_move_o && !f_move_q);
    if (!(state_q == Act && load_q)) assert (f_known_q || tap_load_o);
    if (state_q == Act && load_q && pulse_q >= 3'd6) assert (f_known_q && f_tap_q == '0);
    else if (tap_load_o) assert (tap_q == '0 || state_q == Act && load_q);
    else if (f_known_q) begin
      if (state_q == Act && pulse_q >= 3'd5 && !load_q) assert (f_tap_q == tap_q);
      else assert (f_tap_q + TapBits'(tap_move_o || f_move_q) == tap_q);
    end
    // Eyes:
    if (state_q == Act && load_q) assert (run_q == '0 && best_q == '0);
    if (final_q) begin
      assert (state_q == Act || state_q == Wait || state_q == Run);
      assert (run_q == '0 && best_q == '0 && target_q <= LastTap);
      if (state_q == Act && !load_q) assert (tap_q < target_q);
      if (state_q == Wait) assert (tap_q == target_q);
    end
    if (state_q == Run) assert (run_q == '0 && best_q == '0);
    if (state_q == Wait || state_q == Measure || state_q == Note) begin
      if (run_q != '0) assert (8'(run_first_q) + 8'(run_q) <= 8'(tap_q));
      if (best_q != '0) assert (8'(best_first_q) + 8'(best_q) <= 8'(tap_q));
    end else begin
      if (run_q != '0) assert (8'(run_first_q) + 8'(run_q) <= 8'(tap_q) + 8'd1);
      if (best_q != '0) assert (8'(best_first_q) + 8'(best_q) <= 8'(tap_q) + 8'd1);
    end
    assert (run_q <= RunBits'(Taps) && best_q <= RunBits'(Taps));
    if (state_q != Compare) assert (run_q <= best_q);
    // What a tap has shown:
    if (state_q == Measure || state_q == Note) begin
      assert (steady_q == (f_equal_q == {state_q == Note, window_q}));
      assert (f_equal_q <= {state_q == Note, window_q});
      assert (clock_q == f_first_q);
    end
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (locked_o && turn_q != '0);
    cover (f_locked_q && !locked_o && state_q == Run);
  end
`endif

endmodule

`default_nettype wire
