// One Channel Link of a Camera Link camera: words of 28 bits into beats of video, in the board's
// clock.
//
//   link's clock: words ─▶ sp_camera_link_taps ─▶ sp_tap_gather ─▶ sp_beat_crossing ─▶ video
//
// Guarantees: a word brings pixels while frame valid, line valid and data valid are high. A line
// ends with the first word without line valid or frame valid, whatever its data valid; pixels at
// its end that do not fill a beat are left out. A frame begins with a word with frame valid after
// one without. Clocks without valid_i change nothing.
//
// While locked_i is low there are no words. The frame that is under way is cut off there, and
// cut_o is high for one clock. The next frame is the first whose beginning comes after locked_i has
// risen: a word without frame valid must have come before it.
//
// With Part = 1 each word is a part of a beat, with all its taps, and above them, with PlaceBits,
// the number of the word in its line, modulo 2^PlaceBits; words without data valid count.
//
// With Eighty the word is one of the 80-bit configuration, which has no data valid, and frame valid
// only in X: every line of Y and Z is taken for a frame. Ten taps of 8 bits: X (1) has bits 23..0,
// then 27 and 26 as the two upper ones; line valid: 24, frame valid: 25. Y and Z (2): bits 26..0;
// line valid: 27. The bits of X, Y and Z in a row are the taps 1 to 10. Eight taps of 10 bits: the
// upper 8 bits of each are where Full has them; X (3) has line valid in 24 and frame valid in 25, Y
// and Z (4) line valid in 24. (Camera Link 2.0, as ClinkFraming.vhd of github.com/slaclab/surf has it.)
//
// Overflow, reset: see sp_beat_crossing.
// Latency: a word is one clock of the link before its begins_i, full_i or ending_i there.
`default_nettype none

module sp_camera_link_channel #(
  parameter int Taps = 3,  // 1, 2 or 3
  parameter int Bits = 8,  // of a pixel: 8; with 1 or 2 taps also 10 or 12
  parameter bit Part = 1'b0,  // 1: a word is a part of a beat; 0: beats of four pixels
  parameter int Eighty = 0,  // 80 bit: ten taps 1: X, 2: Y or Z; eight taps 3: X, 4: Y or Z; 0: no
  parameter int PlaceBits = 0,  // of the number of a word in its line, with Part = 1: 0..8
  parameter bit DataValid = 1'b1,  // 0: data valid is taken for high
  parameter int LogDepth = 4,  // log2 of the beats in the FIFO: 1..15
  parameter int Pixels = Eighty == 1 || Eighty == 2 ? 25 + Eighty : 8 * Taps,  // derived, do not set
  parameter int Width = Part ? Pixels + PlaceBits : 32  // derived, do not set
) (
  // Link
  input  wire logic             link_clk_i,
  input  wire logic             locked_i,
  input  wire logic             valid_i,    // a word; only while locked_i is high
  input  wire logic [27:0]      word_i,

  // Video
  input  wire logic             clk_i,
  input  wire logic             rst_i,      // active high, synchronous to clk_i
  output logic                  m_valid_o,
  input  wire logic             m_ready_i,
  output logic      [Width-1:0] m_data_o,
  output logic                  m_start_o,
  output logic                  m_end_o,
  output logic                  overrun_o,  // pulse: a frame was cut off for want of room
  output logic                  cut_o       // pulse: locked_i has fallen
);

  if (Eighty < 0 || Eighty > 4) begin : gen_eighty_range
    eighty_is_not_in_0_to_4 u_error ();
  end
  if (Eighty != 0 && !Part) begin : gen_eighty_part
    eighty_needs_part u_error ();
  end
  if (PlaceBits < 0 || PlaceBits > 8 || PlaceBits > 0 && !Part) begin : gen_place_bits
    place_bits_is_not_in_0_to_8_or_needs_part u_error ();
  end

  logic              frame, line, data;
  logic [Pixels-1:0] pixels;
  logic              low_q;     // the last word was without frame valid
  logic              begins_q, take_q, ending_q, cut_q;
  logic [Pixels-1:0] pixels_q;
  logic              full, link_rst;
  logic [Width-1:0]  beat;

  if (Eighty == 1) begin : gen_eighty_x
    assign {pixels[25:24], frame, line, pixels[23:0]} = word_i;
    assign data = 1'b1;
  end else if (Eighty == 2) begin : gen_eighty_yz
    assign {line, pixels} = word_i;
    assign frame = line;
    assign data  = 1'b1;
  end else begin : gen_ports
    logic frame_bit, data_bit;
    sp_camera_link_taps #(
      .Taps(Taps),
      .Bits(Bits)
    ) u_taps (
      .word_i  (word_i),
      .frame_o (frame_bit),
      .line_o  (line),
      .data_o  (data_bit),
      .pixels_o(pixels)
    );
    assign frame = Eighty == 4 ? line : frame_bit;
    assign data  = Eighty != 0 || data_bit;
    if (Eighty != 0) begin : gen_without_data
      logic unused_bits;
      assign unused_bits = ^{frame_bit, data_bit};
    end
  end

  always_ff @(posedge link_clk_i) begin
    if (!locked_i) low_q <= 1'b0;
    else if (valid_i) low_q <= !frame;
    begins_q <= valid_i && frame && low_q;
    take_q   <= valid_i && frame && line && (data || !DataValid);
    ending_q <= valid_i && !(frame && line);
    cut_q    <= !locked_i;
    pixels_q <= pixels;
  end

  if (Part) begin : gen_part
    logic unused;
    assign unused = link_rst;
    assign full   = take_q;
    if (PlaceBits > 0) begin : gen_place
      logic [PlaceBits-1:0] next_q, place_q;  // of the next word in its line, and with pixels_q
      always_ff @(posedge link_clk_i) begin
        if (valid_i) next_q <= frame && line ? next_q + 1'b1 : '0;
        place_q <= next_q;
      end
      assign beat = {place_q, pixels_q};
    end else begin : gen_no_place
      assign beat = pixels_q;
    end
  end else begin : gen_whole
    sp_tap_gather #(
      .Taps(Taps)
    ) u_gather (
      .clk_i   (link_clk_i),
      .rst_i   (link_rst),
      .take_i  (take_q),
      .clear_i (ending_q || cut_q),
      .pixels_i(pixels_q),
      .full_o  (full),
      .beat_o  (beat)
    );
  end

  sp_beat_crossing #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_crossing (
    .camera_clk_i(link_clk_i),
    .camera_rst_o(link_rst),
    .begins_i    (begins_q),
    .full_i      (full),
    .beat_i      (beat),
    .ending_i    (ending_q),
    .cut_i       (cut_q),
    .clk_i       (clk_i),
    .rst_i       (rst_i),
    .m_valid_o   (m_valid_o),
    .m_ready_i   (m_ready_i),
    .m_data_o    (m_data_o),
    .m_start_o   (m_start_o),
    .m_end_o     (m_end_o),
    .overrun_o   (overrun_o),
    .cut_o       (cut_o)
  );

endmodule

`default_nettype wire
