// Joins the beats of two or three channels of one camera, each with its part of every beat.
//
// Guarantees: an output beat is made of one beat of each channel. All are the first of a frame or
// none is, all are the last of a line or none is, and all have the same place_i. Every beat of all
// channels becomes part of an output beat, in order, as long as the channels agree. The channels
// may differ by any time that the FIFOs before this module hold, less than 2^LogWait clocks.
//
// Where they do not agree (one is at the beginning of a frame, at the end of a line or at another
// place than another one, or one has waited for another for 2^LogWait clocks), the rest of the
// frame is left out on all. apart_o is high for one clock. The output goes on with a frame that
// begins on all. From one beginning of a frame to the next it must be 2^LogWait clocks or more.
//
// With LineStarts = 1 only channel 0 knows where a frame begins; start_i of the others marks the
// first beat of every line. A frame then begins where a line of the others begins within
// 2^LogWait clocks of it. So from one line to the next it must be 2 * 2^LogWait clocks or more,
// from the end of a frame that is left out to the next one what the FIFOs need to become empty.
//
// Latency: one clock from the latest beat that is joined. The output cannot be stalled.
//
//   clock      0   1   2   3   4   5      Channels = 2
//   valid_i   /111111111111\_____         of channel 0
//   data_i    <X0     ><X1 >-----
//   valid_i   ____/1111111\______         of channel 1
//   data_i    ----<Y0 ><Y1 >-----
//   ready_o   ____/1111111\______         of both
//   m_valid_o ________/1111111\__
//   m_data_o  --------<0  ><1  >-
`default_nettype none

module sp_beat_pairs #(
  parameter int Channels = 2,  // 2 or 3
  parameter int Bits = 32,  // of the beats of all channels together: 1 or more
  parameter int PlaceBits = 1,  // of place_i of a channel: 1 or more
  parameter bit LineStarts = 1'b0,  // 1: start_i of all but channel 0 marks lines, not frames
  parameter int LogWait = 4  // log2 of the clocks that one channel waits for another: 1 or more
) (
  input  wire logic                          clk_i,
  input  wire logic                          rst_i,      // active high, synchronous

  // Channels, 0 in the lowest bits; an offered beat stays until it is taken
  input  wire logic [Channels-1:0]           valid_i,
  output logic      [Channels-1:0]           ready_o,
  input  wire logic [Bits-1:0]               data_i,
  input  wire logic [Channels-1:0]           start_i,    // first beat of a frame
  input  wire logic [Channels-1:0]           end_i,      // last beat of a line
  input  wire logic [Channels*PlaceBits-1:0] place_i,    // must agree; 0 where there is none

  // Video
  output logic                               m_valid_o,
  output logic      [Bits-1:0]               m_data_o,
  output logic                               m_start_o,
  output logic                               m_end_o,
  output logic                               apart_o     // pulse: the channels do not agree
);

  if (Channels != 2 && Channels != 3) begin : gen_channels
    channels_is_not_2_or_3 u_error ();
  end
  if (Bits < 1) begin : gen_bits
    bits_is_less_than_1 u_error ();
  end
  if (PlaceBits < 1) begin : gen_place_bits
    place_bits_is_less_than_1 u_error ();
  end
  if (LogWait < 1) begin : gen_log_wait
    log_wait_is_less_than_1 u_error ();
  end

  logic                skip_q;  // leave out beats up to the beginning of a frame on all
  logic [LogWait-1:0]  wait_q;  // clocks since a beat has been waiting for another channel;
                                // anew from where they differ, while the rest of a frame goes
  logic                first_q;  // with LineStarts: the next beat is the first of a line
  logic [Channels-1:0] stale_q;  // with LineStarts: the next beat may be older than 2^LogWait clocks
  logic                all, same, pair, differ, late;
  logic [Channels-1:0] skips;

  if (LineStarts) begin : gen_lines
    always_ff @(posedge clk_i) begin
      if (rst_i) stale_q <= '0;
      else stale_q <= late || differ ? {{Channels - 1{1'b1}}, 1'b0} : stale_q & valid_i;
      if (pair) first_q <= end_i[0];
    end
  end else begin : gen_frames
    assign first_q = 1'b0;
    assign stale_q = '0;
  end

  assign all    = valid_i == '1;
  assign same   = start_i[Channels-1:1] == {Channels - 1{start_i[0] || first_q}} &&
                  end_i[Channels-1:1] == {Channels - 1{end_i[0]}} &&
                  place_i == {Channels{place_i[PlaceBits-1:0]}};
  assign late   = wait_q == '1 && !all;
  assign pair   = all && same && stale_q == '0 && (!skip_q || start_i[0]);
  assign differ = all && !same && stale_q == '0 && (!skip_q || start_i == '1);
  assign skips  = valid_i & ({Channels{late || differ}} | {Channels{skip_q}} & (~start_i | stale_q));

  // A beat that differs from the others is dropped, but not if a frame begins with it alone.
  assign ready_o = {Channels{pair}} | skips & ~({Channels{differ && start_i != '1}} & start_i);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      skip_q    <= 1'b1;
      wait_q    <= '0;
      m_valid_o <= 1'b0;
      apart_o   <= 1'b0;
    end else begin
      if (late || differ) skip_q <= 1'b1;
      else if (pair) skip_q <= 1'b0;
      if (differ || (valid_i & ~ready_o) == '0) wait_q <= '0;
      else if (wait_q != '1 || Channels == 2 && !LineStarts) wait_q <= wait_q + 1'b1;
      m_valid_o <= pair;
      // While a frame is left out, lines of it that wait for the next one say nothing new.
      apart_o   <= late && !(LineStarts && skip_q && !valid_i[0]) || differ;
    end
    m_data_o  <= data_i;
    m_start_o <= start_i[0];
    m_end_o   <= end_i[0];
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);

  logic                f_open_q;   // a pair of this frame has come, and the channels agree since
  logic                f_first_q;  // the last output beat ended its line
  logic [Channels-1:0] f_start_q, f_end_q, f_taken_q;
  logic [Channels*PlaceBits-1:0] f_place_q;
  logic [Bits-1:0]     f_data_q;
  logic [Channels-1:0] f_empty_q;  // since the channels did not agree
  logic                f_again_q;  // the channels did not agree once
  always_ff @(posedge clk_i) begin
    {f_start_q, f_end_q, f_place_q, f_data_q} <= {start_i, end_i, place_i, data_i};
    f_empty_q <= {Channels{rst_i}} | {Channels{!late && !differ}} & (f_empty_q | ~valid_i);
    f_taken_q <= valid_i & ready_o & {Channels{!rst_i}};
    f_again_q <= !rst_i && (f_again_q || differ && !skip_q);
    if (m_valid_o) f_first_q <= m_end_o;
    if (rst_i) f_open_q <= 1'b0;
    else f_open_q <= (f_open_q || pair) && !late && !differ;
  end

  logic [LogWait:0] f_waits_q;  // clocks for which channel 0 has waited
  always_ff @(posedge clk_i) begin
    if (rst_i || !valid_i[0] || ready_o[0] || all) f_waits_q <= '0;
    else f_waits_q <= f_waits_q + 1'b1;
  end

  always_comb if (f_past_q) begin
    // Rule 1: an output beat is one beat of each channel, at the same place of a frame and a line.
    if (m_valid_o) assert (f_taken_q == '1 && m_data_o == f_data_q);
    if (m_valid_o) assert (f_end_q == {Channels{m_end_o}} && m_start_o == f_start_q[0]);
    if (m_valid_o) assert (f_place_q == {Channels{f_place_q[PlaceBits-1:0]}});
    if (m_valid_o && (m_start_o || !LineStarts)) assert (f_start_q == {Channels{m_start_o}});
    if (m_valid_o && !m_start_o) assert (f_start_q[Channels-1:1] == '0 || LineStarts && f_first_q);
    if (m_valid_o && LineStarts && f_first_q) assert (f_start_q[Channels-1:1] == '1);
    // Rule 2: after the channels did not agree, the output goes on with the beginning of a frame.
    assert (f_open_q == !skip_q);
    if (!f_open_q && pair) assert (start_i == '1);
    // Rule 3: while the channels agree, every beat that is taken becomes part of an output beat.
    if (!apart_o && f_open_q && f_taken_q != '0) assert (m_valid_o);
    // Rule 5: no beat waits for more than 2^LogWait clocks while another channel has none.
    assert (f_waits_q <= {1'b0, wait_q});
  end
  // Rule 4: the beginning of a frame is left out only where the channels do not agree: its
  // partner is late, or begins a frame with a line of another length.
  for (genvar i = 0; i < (LineStarts ? 1 : Channels); i++) begin : gen_rule_4
    always_comb if (f_past_q && valid_i[i] && ready_o[i] && start_i[i] && !pair) begin
      assert (late || all && start_i == '1);
    end
  end
  if (LineStarts) begin : gen_rules_of_lines
    always_comb if (f_past_q) begin
      if (f_open_q) assert (first_q == (m_valid_o ? m_end_o : f_first_q));
      // Rule 6: what a channel holds where a frame begins came within the last 2^LogWait clocks:
      // its FIFO was empty after the channels did not agree.
      for (int i = 1; i < Channels; i++) begin
        assert (f_empty_q[i] == !stale_q[i]);
        if (pair) assert (f_empty_q[i]);
      end
      assert (!stale_q[0]);
    end
  end
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (apart_o && f_again_q);
    cover (m_valid_o && m_start_o && f_again_q);
    cover (late);
  end
`endif

endmodule

`default_nettype wire
