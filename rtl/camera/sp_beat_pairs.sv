// Joins the beats of two channels of one camera, each with its part of every beat.
//
// Guarantees: an output beat is made of one beat of each channel. Both are the first of a frame or
// neither is, and both are the last of a line or neither is. Every beat of both channels becomes
// part of an output beat, in order, as long as the channels agree. The channels may differ by any
// time that the FIFOs before this module hold, less than 2^LogWait clocks.
//
// Where they do not agree (one is at the beginning of a frame or at the end of a line and the other
// is not, or one has waited for the other for 2^LogWait clocks), the rest of the frame is left out
// on both. apart_o is high for one clock. The output goes on with a frame that begins on both. From
// one beginning of a frame to the next it must be 2^LogWait clocks or more.
//
// Latency: one clock from the later beat of a pair. The output cannot be stalled.
//
//   clock      0   1   2   3   4
//   x_valid_i /111111111111\_____
//   x_data_i  <X0     ><X1 >-----
//   y_valid_i ____/1111111\______
//   y_data_i  ----<Y0 ><Y1 >-----
//   x_ready_o ____/1111111\______   y_ready_o likewise
//   m_valid_o ________/1111111\__
//   m_data_o  --------<0  ><1  >-
`default_nettype none

module sp_beat_pairs #(
  parameter int XBits = 24,  // 1 or more
  parameter int YBits = 8,  // 1 or more
  parameter int LogWait = 4  // log2 of the clocks that one channel waits for the other: 1 or more
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,      // active high, synchronous

  // Channels; an offered beat stays until it is taken
  input  wire logic                   x_valid_i,
  output logic                        x_ready_o,
  input  wire logic [XBits-1:0]       x_data_i,
  input  wire logic                   x_start_i,  // first beat of a frame
  input  wire logic                   x_end_i,    // last beat of a line
  input  wire logic                   y_valid_i,
  output logic                        y_ready_o,
  input  wire logic [YBits-1:0]       y_data_i,
  input  wire logic                   y_start_i,
  input  wire logic                   y_end_i,

  // Video
  output logic                        m_valid_o,
  output logic      [XBits+YBits-1:0] m_data_o,   // x in the lower bits
  output logic                        m_start_o,
  output logic                        m_end_o,
  output logic                        apart_o     // pulse: the channels do not agree
);

  if (XBits < 1) begin : gen_xbits
    xbits_is_less_than_1 u_error ();
  end
  if (YBits < 1) begin : gen_ybits
    ybits_is_less_than_1 u_error ();
  end
  if (LogWait < 1) begin : gen_log_wait
    log_wait_is_less_than_1 u_error ();
  end

  logic               skip_q;   // leave out beats up to the beginning of a frame on both
  logic [LogWait-1:0] wait_q;   // clocks since a beat has been waiting for the other channel;
                                // anew from where they differ, while the rest of a frame goes
  logic               both, same, pair, differ, late, x_skips, y_skips;

  assign both    = x_valid_i && y_valid_i;
  assign same    = x_start_i == y_start_i && x_end_i == y_end_i;
  assign late    = wait_q == '1 && !both;
  assign pair    = both && same && (!skip_q || x_start_i);
  assign differ  = both && !same && (!skip_q || x_start_i && y_start_i);
  assign x_skips = x_valid_i && (late || differ || skip_q && !x_start_i);
  assign y_skips = y_valid_i && (late || differ || skip_q && !y_start_i);

  // A beat that differs from its partner is dropped, but not if a frame begins with it alone.
  assign x_ready_o = pair || x_skips && !(differ && x_start_i && !y_start_i);
  assign y_ready_o = pair || y_skips && !(differ && y_start_i && !x_start_i);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      skip_q    <= 1'b1;
      wait_q    <= '0;
      m_valid_o <= 1'b0;
      apart_o   <= 1'b0;
    end else begin
      if (late || differ) skip_q <= 1'b1;
      else if (pair) skip_q <= 1'b0;
      if (differ || !(x_valid_i && !x_ready_o || y_valid_i && !y_ready_o)) wait_q <= '0;
      else wait_q <= wait_q + 1'b1;
      m_valid_o <= pair;
      apart_o   <= late || differ;
    end
    m_data_o  <= {y_data_i, x_data_i};
    m_start_o <= x_start_i;
    m_end_o   <= x_end_i;
  end

`ifdef FORMAL
  logic f_past_q = 1'b0;
  always_ff @(posedge clk_i) f_past_q <= 1'b1;
  always_comb if (!f_past_q) assume (rst_i);

  logic             f_open_q;   // a pair of this frame has come, and the channels agree since
  logic             f_x_start_q, f_y_start_q, f_x_end_q, f_y_end_q;
  logic [XBits-1:0] f_x_q;
  logic [YBits-1:0] f_y_q;
  logic             f_x_taken_q, f_y_taken_q;
  logic             f_again_q;  // the channels did not agree once
  always_ff @(posedge clk_i) begin
    {f_x_start_q, f_y_start_q, f_x_end_q, f_y_end_q} <= {x_start_i, y_start_i, x_end_i, y_end_i};
    {f_x_q, f_y_q} <= {x_data_i, y_data_i};
    {f_x_taken_q, f_y_taken_q} <= {x_valid_i && x_ready_o, y_valid_i && y_ready_o} & {2{!rst_i}};
    f_again_q <= !rst_i && (f_again_q || differ && !skip_q);
    if (rst_i) f_open_q <= 1'b0;
    else f_open_q <= (f_open_q || pair) && !late && !differ;
  end

  always_comb if (f_past_q) begin
    // Rule 1: an output beat is one beat of each channel, at the same place of a frame and a line.
    if (m_valid_o) assert (f_x_taken_q && f_y_taken_q && m_data_o == {f_y_q, f_x_q});
    if (m_valid_o) assert (f_x_start_q == f_y_start_q && f_x_end_q == f_y_end_q);
    if (m_valid_o) assert (m_start_o == f_x_start_q && m_end_o == f_x_end_q);
    // Rule 2: after the channels did not agree, the output goes on with the beginning of a frame.
    assert (f_open_q == !skip_q);
    if (!f_open_q && pair) assert (x_start_i && y_start_i);
    // Rule 3: while the channels agree, every beat that is taken becomes part of an output beat.
    if (!apart_o && f_open_q && (f_x_taken_q || f_y_taken_q)) assert (m_valid_o);
    // Rule 4: the beginning of a frame is left out only where the channels do not agree: its
    // partner is late, or begins a frame with a line of another length.
    if (x_valid_i && x_ready_o && x_start_i && !pair) assert (late || both && y_start_i);
    if (y_valid_i && y_ready_o && y_start_i && !pair) assert (late || both && x_start_i);
  end
  // Rule 5: no beat waits for more than 2^LogWait clocks while the other channel has none.
  logic [LogWait:0] f_waits_q;
  always_ff @(posedge clk_i) begin
    if (rst_i || !x_valid_i || x_ready_o || y_valid_i) f_waits_q <= '0;
    else f_waits_q <= f_waits_q + 1'b1;
  end
  always_comb if (f_past_q) assert (f_waits_q <= {1'b0, wait_q});
  always_ff @(posedge clk_i) if (f_past_q) begin
    cover (apart_o && f_again_q);
    cover (m_valid_o && m_start_o && f_again_q);
    cover (late);
  end
`endif

endmodule

`default_nettype wire
