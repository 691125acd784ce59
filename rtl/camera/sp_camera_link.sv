// Front end for Camera Link cameras, Base, Medium, Full and 80 bit. It turns the 28-bit words of the
// Channel Link receiver chips, or of a deserializer, into video.
//
//   Base    X's clock: words ─▶ sp_camera_link_channel ─▶ video, in the board's clock
//   Medium  X's clock: words ─▶ sp_camera_link_channel ─┐
//           Y's clock: words ─▶ sp_camera_link_channel ─┴▶ sp_beat_pairs ─▶ video
//   Full    as Medium, with Z as the third, and behind sp_beat_pairs: ─▶ sp_wide_beats ─▶ video
//
// Guarantees: with Taps = 1, 2 or 3 (Base) each word of X brings that many pixels, the leftmost in
// tap 1. With Taps = 4 (Medium) each word of X brings three pixels, in ports A, B and C. The
// matching word of Y brings the fourth pixel, in port D. The four pixels make one beat. With
// Taps = 8 (Full) X, Y and Z bring eight pixels, in ports A to H. With Taps = 10 (80 bit, ten taps
// of 8 bits) they bring ten, and with Taps = 8 and Bits = 10 (80 bit, eight taps of 10 bits) eight,
// see sp_camera_link_channel. The upper 8 bits of each pixel go to the board.
//
// A pixel counts while frame valid, line valid and data valid are high. A line ends when line valid
// or frame valid falls. It may have any length; the board compares the length with the size that
// was set. Pixels at the end of a line that do not fill a beat are dropped. With 8 or 10 taps,
// Columns leaves out what fills the last word of a line. A gap of one word between two lines or
// frames is enough. After a reset, output starts with the next frame that begins.
//
// Loss of lock: a link that is not locked brings no words. The current frame is cut off and never
// continues, so that the frame tracker of sp_board counts it and marks it as broken. lost_o is high
// for one clock. Output continues with the first frame that begins after the link has locked again.
// If a link's clock stood still, a beat from before may wait behind its last word. The first frame
// after that may then begin with this beat beside newer ones of the other links; it is cut off, and
// apart_o tells it.
//
// Medium, Full, 80 bit: the delays of the links may differ by up to 15 clocks of the board, and by
// no more than the FIFOs hold. The phases of their clocks may differ. If not all of the links bring
// a line or a frame, the frame is cut off, and apart_o is high for one clock. If not all of them
// have data valid in a word, Medium notices it at the end of the line, and Full at the next pixel,
// by the words' numbers in their line. Frames must begin at least 16 clocks of the board apart,
// because frames of the links are matched by the time at which they begin. With 80 bit only X has
// frame valid, so lines must begin at least 32 clocks apart; and from where a frame was cut off, 64
// clocks may pass before the next one can be taken.
//
// Overflow: as in sp_parallel_sensor, the FIFO of Base and Medium fills only if the camera brings
// more than one beat in each clock of the board. Then the rest of the frame is dropped, and
// overrun_o is high for one clock. Full and 80 bit bring more than that in a line: a line of N
// words needs 2 N or 2.5 N clocks of the board. What is too much waits in a FIFO of 2^LogWords
// words, up to a gap between lines or frames. If this FIFO is full, the rest of the frame is
// dropped, and overrun_o is high for one clock. The board's clock must be faster than the links':
// otherwise their own FIFOs fill, overrun_o tells it, and frames may follow whose links do not
// belong together.
//
// Reset: rst_i alone. The clocks of the links may stop and start at any time.
//
// Latency: a beat leaves after the word that completes the next beat, or after the word that ends
// the line. From that word it takes 2 clocks of the link and 3 to 4 of the board, with Medium one
// more of the board, and with Full and 80 bit five more, if no other words wait.
//
//   word      0   1   2   3   4   5      Taps = 2
//   frame    /11111111111111111111111
//   line     /111111111111111\_______
//   data     /1111111\___/111\_______
//   A, B     <01><23>----<45>--------   pixels 0 to 3 make a beat; 4 and 5 are dropped
`default_nettype none

module sp_camera_link #(
  parameter int Taps = 2,  // pixels in a word: 1..3 (Base), 4 (Medium), 8 (Full) or 10 (80 bit)
  parameter int Bits = 8,  // bits of a pixel: 8; with 1 or 2 taps also 10 or 12, with 8 taps also 10
  parameter bit DataValid = 1'b1,  // 0: ignore data valid, as if it were always high
  parameter int Columns = 0,  // of a line, a multiple of 4, with 8 or 10 taps; 0: all of its words
  parameter int LogWords = 9,  // log2 of the words of 8 or 10 pixels that can wait: 1..24
  parameter int LogDepth = Taps >= 4 ? 5 : 4  // log2 of the beats in each link's FIFO: 1..15
) (
  // Channel Link X
  input  wire logic        x_clk_i,     // clock of the words
  input  wire logic        x_locked_i,  // low: the link brings no words
  input  wire logic        x_valid_i,   // a word; only while x_locked_i is high
  input  wire logic [27:0] x_word_i,    // bit i is output i of the receiver chip

  // Channel Link Y; Base ignores it
  input  wire logic        y_clk_i,
  input  wire logic        y_locked_i,
  input  wire logic        y_valid_i,
  input  wire logic [27:0] y_word_i,

  // Channel Link Z, only for Full and 80 bit; the others ignore it
  input  wire logic        z_clk_i,
  input  wire logic        z_locked_i,
  input  wire logic        z_valid_i,
  input  wire logic [27:0] z_word_i,

  // Video, to the board's s_axis ports
  input  wire logic        clk_i,
  input  wire logic        rst_i,       // active high, synchronous to clk_i
  output logic             m_valid_o,
  output logic      [31:0] m_data_o,    // leftmost pixel in 7..0
  output logic             m_start_o,   // first beat of a frame
  output logic             m_end_o,     // last beat of a line
  output logic             overrun_o,   // pulse: a frame was cut off because a FIFO was full
  output logic             lost_o,      // pulse: a link has lost its lock
  output logic             apart_o      // pulse: the links did not agree
);

  if (Taps < 1 || Taps > 4 && Taps != 8 && Taps != 10) begin : gen_taps
    taps_is_not_in_1_to_4_or_8_or_10 u_error ();
  end
  if (Taps == 10 && Bits != 8) begin : gen_bits
    ten_taps_have_8_bits u_error ();
  end
  if (Taps <= 4 && Columns != 0) begin : gen_columns
    columns_needs_8_or_10_taps u_error ();
  end

  localparam bit Eighty = Taps == 10 || Taps == 8 && Bits == 10;
  localparam int Ten = Taps == 10 ? 1 : 3;  // of an 80-bit X
  localparam int Links = Taps <= 3 ? 1 : Taps == 4 ? 2 : 3;
  localparam int PortBits = Eighty ? 8 : Bits;  // of a pixel where its ports hold it
  localparam int PlaceBits = Taps == 8 && !Eighty ? 4 : 0;
  localparam int XPixels = Taps == 10 ? 26 : Links == 1 ? 32 : 24;  // bits
  localparam int YPixels = Taps == 10 ? 27 : Links == 3 ? 24 : 8;
  localparam int ZPixels = Taps == 10 ? 27 : 16;

  logic [Links-1:0]             valid, ready, start, line_end, overrun, lost;
  logic [XPixels+PlaceBits-1:0] x_data;
  logic                         wide_overrun;

  sp_camera_link_channel #(
    .Taps     (Links == 1 ? Taps : 3),
    .Bits     (PortBits),
    .Part     (Links > 1),
    .Eighty   (Eighty ? Ten : 0),
    .PlaceBits(PlaceBits),
    .DataValid(DataValid),
    .LogDepth (LogDepth)
  ) u_x (
    .link_clk_i(x_clk_i),
    .locked_i  (x_locked_i),
    .valid_i   (x_valid_i),
    .word_i    (x_word_i),
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .m_valid_o (valid[0]),
    .m_ready_i (ready[0]),
    .m_data_o  (x_data),
    .m_start_o (start[0]),
    .m_end_o   (line_end[0]),
    .overrun_o (overrun[0]),
    .cut_o     (lost[0])
  );

  assign overrun_o = overrun != '0 || wide_overrun;
  assign lost_o    = lost != '0;

  if (Links == 1) begin : gen_base
    logic unused;
    assign unused       = ^{y_clk_i, y_locked_i, y_valid_i, y_word_i};
    assign ready        = 1'b1;
    assign m_valid_o    = valid;
    assign m_data_o     = x_data;
    assign m_start_o    = start;
    assign m_end_o      = line_end;
    assign apart_o      = 1'b0;
    assign wide_overrun = 1'b0;
  end else begin : gen_more
    localparam int Pixels = 8 * Taps;  // bits
    localparam int Places = PlaceBits > 0 ? PlaceBits : 1;
    logic [YPixels+PlaceBits-1:0] y_data;
    logic [Pixels-1:0]            pixels, joined;
    logic [Links*Places-1:0]      places;
    logic                         joined_valid, joined_start, joined_end;

    sp_camera_link_channel #(
      .Taps     (Links == 2 ? 1 : 3),
      .Bits     (PortBits),
      .Part     (1'b1),
      .Eighty   (Eighty ? Ten + 1 : 0),
      .PlaceBits(PlaceBits),
      .DataValid(DataValid),
      .LogDepth (LogDepth)
    ) u_y (
      .link_clk_i(y_clk_i),
      .locked_i  (y_locked_i),
      .valid_i   (y_valid_i),
      .word_i    (y_word_i),
      .clk_i     (clk_i),
      .rst_i     (rst_i),
      .m_valid_o (valid[1]),
      .m_ready_i (ready[1]),
      .m_data_o  (y_data),
      .m_start_o (start[1]),
      .m_end_o   (line_end[1]),
      .overrun_o (overrun[1]),
      .cut_o     (lost[1])
    );

    if (Links == 3) begin : gen_z
      logic [ZPixels+PlaceBits-1:0] z_data;

      sp_camera_link_channel #(
        .Taps     (2),
        .Bits     (PortBits),
        .Part     (1'b1),
        .Eighty   (Eighty ? Ten + 1 : 0),
        .PlaceBits(PlaceBits),
        .DataValid(DataValid),
        .LogDepth (LogDepth)
      ) u_z (
        .link_clk_i(z_clk_i),
        .locked_i  (z_locked_i),
        .valid_i   (z_valid_i),
        .word_i    (z_word_i),
        .clk_i     (clk_i),
        .rst_i     (rst_i),
        .m_valid_o (valid[2]),
        .m_ready_i (ready[2]),
        .m_data_o  (z_data),
        .m_start_o (start[2]),
        .m_end_o   (line_end[2]),
        .overrun_o (overrun[2]),
        .cut_o     (lost[2])
      );

      assign pixels = {z_data[ZPixels-1:0], y_data[YPixels-1:0], x_data[XPixels-1:0]};
      if (PlaceBits > 0) begin : gen_places
        assign places = {z_data[ZPixels+:Places], y_data[YPixels+:Places],
                         x_data[XPixels+:Places]};
      end else begin : gen_no_places
        assign places = '0;
      end
    end else begin : gen_no_z
      assign pixels = {y_data, x_data};
      assign places = '0;
    end

    sp_beat_pairs #(
      .Channels  (Links),
      .Bits      (Pixels),
      .PlaceBits (Places),
      .LineStarts(Eighty)
    ) u_pairs (
      .clk_i    (clk_i),
      .rst_i    (rst_i),
      .valid_i  (valid),
      .ready_o  (ready),
      .data_i   (pixels),
      .start_i  (start),
      .end_i    (line_end),
      .place_i  (places),
      .m_valid_o(joined_valid),
      .m_data_o (joined),
      .m_start_o(joined_start),
      .m_end_o  (joined_end),
      .apart_o  (apart_o)
    );

    if (Links == 3) begin : gen_wide
      sp_wide_beats #(
        .Taps    (Taps),
        .Columns (Columns),
        .LogWords(LogWords)
      ) u_beats (
        .clk_i    (clk_i),
        .rst_i    (rst_i),
        .valid_i  (joined_valid),
        .data_i   (joined),
        .start_i  (joined_start),
        .end_i    (joined_end),
        .m_valid_o(m_valid_o),
        .m_data_o (m_data_o),
        .m_start_o(m_start_o),
        .m_end_o  (m_end_o),
        .overrun_o(wide_overrun)
      );
    end else begin : gen_medium
      assign m_valid_o    = joined_valid;
      assign m_data_o     = joined;
      assign m_start_o    = joined_start;
      assign m_end_o      = joined_end;
      assign wide_overrun = 1'b0;
    end
  end

  if (Links < 3) begin : gen_without_z
    logic unused_z;
    assign unused_z = ^{z_clk_i, z_locked_i, z_valid_i, z_word_i};
  end

endmodule

`default_nettype wire
