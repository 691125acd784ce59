// Weights of the pixels of a beat: what each of them adds to the sums of its column.
//
// A pixel is lit where it is greater than the threshold. A lit pixel weighs 1 (binary), its value
// (grey) or its value minus the threshold (grey_over), which is never 0. Any other pixel weighs 0.
//
// Latency: weights_o follows three clocks after the beat. Mode and threshold count beside it.
//
//   clock          0   1   2   3
//   beat_pixels_i  < A >---------
//   weights_o      ------------< A
`default_nettype none

module sp_pixel_weights #(
  parameter bit Grey = 1'b1,
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int WeightBits = Grey ? PixelBits : 1
) (
  input  wire logic                    clk_i,
  input  wire logic                    rst_i,
  input  wire logic [Lanes*PixelBits-1:0]  beat_pixels_i,  // leftmost pixel lowest
  input  wire logic [1:0]              mode_i,  // of the beat
  input  wire logic [PixelBits-1:0]    threshold_i,  // of the beat
  output logic      [Lanes*WeightBits-1:0] weights_o
);

  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end

  // The threshold comes from a comparison of rows, so nothing but a register takes it.
  logic [Lanes*PixelBits-1:0] s1_pixels_q;
  logic [PixelBits-1:0]   s1_room_q;  // the largest pixel minus the threshold
  always_ff @(posedge clk_i) begin
    s1_pixels_q <= beat_pixels_i;
    s1_room_q   <= ~threshold_i;
  end

  logic s1_binary_q, s1_grey_q, s2_binary_q, s2_grey_q;  // the modes
  always_ff @(posedge clk_i) begin
    s1_binary_q <= mode_i == sp_spec_pkg::ModeBinary;
    s1_grey_q   <= mode_i == sp_spec_pkg::ModeGrey;
    {s2_binary_q, s2_grey_q} <= {s1_binary_q, s1_grey_q};
  end

  for (genvar lane = 0; lane < Lanes; lane++) begin : gen_weight
    // A pixel is lit where pixel + (largest - threshold) exceeds the largest. The carry is taken as
    // a bit of the sum, so that it stays at the end of its chain. It does not matter in reset.
    logic                 lit, lit2_q;
    logic [PixelBits-1:0] pixel, unused_sum;
    assign pixel = s1_pixels_q[PixelBits*lane+:PixelBits];
    assign {lit, unused_sum} = {rst_i, pixel} + {1'b0, s1_room_q};
    always_ff @(posedge clk_i) lit2_q <= lit;

    if (Grey) begin : gen_grey
      logic [PixelBits-1:0] pixel2_q, over2_q;
      always_ff @(posedge clk_i) begin
        pixel2_q <= pixel;
        over2_q  <= pixel + s1_room_q + PixelBits'(1);  // less the threshold
        if (!lit2_q) weights_o[PixelBits*lane+:PixelBits] <= '0;
        else if (s2_binary_q) weights_o[PixelBits*lane+:PixelBits] <= PixelBits'(1);
        else weights_o[PixelBits*lane+:PixelBits] <= s2_grey_q ? pixel2_q : over2_q;
      end
    end else begin : gen_binary
      always_ff @(posedge clk_i) weights_o[lane] <= lit2_q;
    end
  end

  if (!Grey) begin : gen_no_mode
    logic unused;
    assign unused = s2_binary_q ^ s2_grey_q;
  end

endmodule

`default_nettype wire
