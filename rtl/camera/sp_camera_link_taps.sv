// The ports, valids and pixels in the 28 bits of a Channel Link word, as Camera Link assigns them.
//
// Bit i of the word is output i of the receiver chip. Port A: bits 0 to 4, 6, 27, 5;
// port B: 7 to 9, 12 to 14, 10, 11; port C: 15, 18 to 22, 16, 17; each from its bit 0 to its bit 7.
// Spare: 23, line valid: 24, frame valid: 25, data valid: 26.
//
// Guarantees: of the pixels of Bits bits it gives the upper 8. Where the ports hold them:
//
//   Bits   tap 1             tap 2             tap 3
//   8      A                 B                 C
//   10     B[1:0], A         B[5:4], C         none
//   12     B[3:0], A         B[7:4], C         none
//
// Combinational.
`default_nettype none

module sp_camera_link_taps #(
  parameter int Taps = 3,  // 1, 2 or 3
  parameter int Bits = 8   // of a pixel: 8; with 1 or 2 taps also 10 or 12
) (
  input  wire logic [27:0]       word_i,
  output logic                   frame_o,  // frame valid
  output logic                   line_o,   // line valid
  output logic                   data_o,   // data valid
  output logic      [8*Taps-1:0] pixels_o  // of tap 1 in 7..0
);

  if (Taps < 1 || Taps > 3) begin : gen_taps
    taps_is_not_in_1_to_3 u_error ();
  end
  if (Bits != 8 && Bits != 10 && Bits != 12) begin : gen_bits
    bits_is_not_8_10_or_12 u_error ();
  end
  if (Bits > 8 && Taps > 2) begin : gen_bits_of_three
    three_taps_have_8_bits u_error ();
  end

  logic [7:0] a, b, c;
  logic       unused;
  assign a      = {word_i[5], word_i[27], word_i[6], word_i[4:0]};
  assign b      = {word_i[11:10], word_i[14:12], word_i[9:7]};
  assign c      = {word_i[17:16], word_i[22:18], word_i[15]};
  assign unused = ^{a, b, c, word_i[23]};

  assign line_o  = word_i[24];
  assign frame_o = word_i[25];
  assign data_o  = word_i[26];

  if (Bits == 8) begin : gen_8
    logic [23:0] pixels;
    assign pixels   = {c, b, a};
    assign pixels_o = pixels[8*Taps-1:0];
    if (Taps < 3) begin : gen_rest
      logic unused_rest;
      assign unused_rest = ^pixels[23:8*Taps];
    end
  end else begin : gen_more
    localparam int Above = Bits - 8;  // bits of a pixel in port B
    logic [15:0] pixels;
    assign pixels   = {b[4+:Above], c[7:Above], b[0+:Above], a[7:Above]};
    assign pixels_o = pixels[8*Taps-1:0];
    if (Taps < 2) begin : gen_rest
      logic unused_rest;
      assign unused_rest = ^pixels[15:8];
    end
  end

endmodule

`default_nettype wire
