// Front end for Camera Link cameras, Base and Medium. It turns the 28-bit words of the Channel Link
// receiver chips, or of a deserializer, into video.
//
//   Base    X's clock: words ─▶ sp_camera_link_channel ─▶ video, in the board's clock
//   Medium  X's clock: words ─▶ sp_camera_link_channel ─┐
//           Y's clock: words ─▶ sp_camera_link_channel ─┴▶ sp_beat_pairs ─▶ video
//
// Guarantees: with Taps = 1, 2 or 3 (Base) each word of X brings that many pixels, the leftmost in
// tap 1. With Taps = 4 (Medium) each word of X brings three pixels, in ports A, B and C. The
// matching word of Y brings the fourth pixel, in port D. The four pixels make one beat. The upper 8
// bits of each pixel go to the board.
//
// A pixel counts while frame valid, line valid and data valid are high. A line ends when line valid
// or frame valid falls. It may have any length; the board compares the length with the size that
// was set. Pixels at the end of a line that do not fill a beat are dropped. A gap of one word
// between two lines or frames is enough. After a reset, output starts with the next frame that
// begins.
//
// Loss of lock: a link that is not locked brings no words. The current frame is cut off and never
// continues, so that the frame tracker of sp_board counts it and marks it as broken. lost_o is high
// for one clock. Output continues with the first frame that begins after the link has locked again.
//
// Medium: the delays of X and Y may differ by up to 15 clocks of the board, and by no more than the
// FIFOs hold. The phases of their clocks may differ. If only one of the two links brings a line or
// a frame, the frame is cut off, and apart_o is high for one clock. If only one of them has data
// valid in a word, this is noticed at the end of the line. Frames must begin at least 16 clocks of
// the board apart, because frames of X and Y are matched by the time at which they begin.
//
// Overflow: as in sp_parallel_sensor, the FIFO fills only if the camera brings more than one beat
// in each clock of the board. Then the rest of the frame is dropped, and overrun_o is high for one
// clock.
//
// Reset: rst_i alone. The clocks of the links may stop and start at any time.
//
// Latency: a beat leaves after the word that completes the next beat, or after the word that ends
// the line. From that word it takes 2 clocks of the link and 3 to 4 of the board, and with Medium
// one more of the board.
//
//   word      0   1   2   3   4   5      Taps = 2
//   frame    /11111111111111111111111
//   line     /111111111111111\_______
//   data     /1111111\___/111\_______
//   A, B     <01><23>----<45>--------   pixels 0 to 3 make a beat; 4 and 5 are dropped
`default_nettype none

module sp_camera_link #(
  parameter int Taps = 2,  // pixels in a word: 1, 2, 3 (Base) or 4 (Medium)
  parameter int Bits = 8,  // bits of a pixel: 8; with 1 or 2 taps also 10 or 12
  parameter bit DataValid = 1'b1,  // 0: ignore data valid, as if it were always high
  parameter int LogDepth = Taps == 4 ? 5 : 4  // log2 of the beats in each FIFO: 1..15
) (
  // Channel Link X
  input  wire logic        x_clk_i,     // clock of the words
  input  wire logic        x_locked_i,  // low: the link brings no words
  input  wire logic        x_valid_i,   // a word; only while x_locked_i is high
  input  wire logic [27:0] x_word_i,    // bit i is output i of the receiver chip

  // Channel Link Y, only for Medium; Base ignores it
  input  wire logic        y_clk_i,
  input  wire logic        y_locked_i,
  input  wire logic        y_valid_i,
  input  wire logic [27:0] y_word_i,

  // Video, to the board's s_axis ports
  input  wire logic        clk_i,
  input  wire logic        rst_i,       // active high, synchronous to clk_i
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,    // leftmost pixel in 7..0
  output logic             m_start_o,   // first beat of a frame
  output logic             m_end_o,     // last beat of a line
  output logic             overrun_o,   // pulse: a frame was cut off because the FIFO was full
  output logic             lost_o,      // pulse: a link has lost its lock
  output logic             apart_o      // pulse: X and Y did not agree
);

  if (Taps < 1 || Taps > 4) begin : gen_taps
    taps_is_not_in_1_to_4 u_error ();
  end

  localparam bit Medium = Taps == 4;
  localparam int XBits = Medium ? 24 : 32;

  logic             x_valid, x_ready, x_start, x_end, x_overrun, x_lost;
  logic [XBits-1:0] x_data;

  sp_camera_link_channel #(
    .Taps     (Medium ? 3 : Taps),
    .Bits     (Bits),
    .Part     (Medium),
    .DataValid(DataValid),
    .LogDepth (LogDepth)
  ) u_x (
    .link_clk_i(x_clk_i),
    .locked_i  (x_locked_i),
    .valid_i   (x_valid_i),
    .word_i    (x_word_i),
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .m_valid_o (x_valid),
    .m_ready_i (x_ready),
    .m_data_o  (x_data),
    .m_start_o (x_start),
    .m_end_o   (x_end),
    .overrun_o (x_overrun),
    .cut_o     (x_lost)
  );

  if (Medium) begin : gen_medium
    logic       y_valid, y_ready, y_start, y_end, y_overrun, y_lost;
    logic [7:0] y_data;

    sp_camera_link_channel #(
      .Taps     (1),
      .Bits     (Bits),
      .Part     (1'b1),
      .DataValid(DataValid),
      .LogDepth (LogDepth)
    ) u_y (
      .link_clk_i(y_clk_i),
      .locked_i  (y_locked_i),
      .valid_i   (y_valid_i),
      .word_i    (y_word_i),
      .clk_i     (clk_i),
      .rst_i     (rst_i),
      .m_valid_o (y_valid),
      .m_ready_i (y_ready),
      .m_data_o  (y_data),
      .m_start_o (y_start),
      .m_end_o   (y_end),
      .overrun_o (y_overrun),
      .cut_o     (y_lost)
    );

    sp_beat_pairs u_pairs (
      .clk_i    (clk_i),
      .rst_i    (rst_i),
      .x_valid_i(x_valid),
      .x_ready_o(x_ready),
      .x_data_i (x_data),
      .x_start_i(x_start),
      .x_end_i  (x_end),
      .y_valid_i(y_valid),
      .y_ready_o(y_ready),
      .y_data_i (y_data),
      .y_start_i(y_start),
      .y_end_i  (y_end),
      .m_valid_o(m_valid_o),
      .m_data_o (m_data_o),
      .m_start_o(m_start_o),
      .m_end_o  (m_end_o),
      .apart_o  (apart_o)
    );

    assign overrun_o = x_overrun || y_overrun;
    assign lost_o    = x_lost || y_lost;
  end else begin : gen_base
    logic unused;
    assign unused    = ^{y_clk_i, y_locked_i, y_valid_i, y_word_i};
    assign x_ready   = 1'b1;
    assign m_valid_o = x_valid;
    assign m_data_o  = x_data;
    assign m_start_o = x_start;
    assign m_end_o   = x_end;
    assign overrun_o = x_overrun;
    assign lost_o    = x_lost;
    assign apart_o   = 1'b0;
  end

endmodule

`default_nettype wire
