// Weights of four pixels: what each of them adds to the sums of its column.
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
  // derived, do not set
  parameter int WeightBits = Grey ? 8 : 1
) (
  input  wire logic                    clk_i,
  input  wire logic                    rst_i,
  input  wire logic [31:0]             beat_pixels_i,  // leftmost pixel in 7..0
  input  wire logic [1:0]              mode_i,  // of the beat
  input  wire logic [7:0]              threshold_i,  // of the beat
  output logic      [4*WeightBits-1:0] weights_o
);

  // The threshold comes from a comparison of rows, so nothing but a register takes it.
  logic [31:0] s1_pixels_q;
  logic [7:0]  s1_room_q;     // 255 minus the threshold
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

  for (genvar lane = 0; lane < 4; lane++) begin : gen_weight
    // A pixel is lit where pixel + (255 - threshold) exceeds 255. The carry is taken as a bit of
    // the sum, so that it stays at the end of its chain. It does not matter in reset.
    logic       lit, lit2_q;
    logic [7:0] unused_sum;
    assign {lit, unused_sum} = {rst_i, s1_pixels_q[8*lane+:8]} + {1'b0, s1_room_q};
    always_ff @(posedge clk_i) lit2_q <= lit;

    if (Grey) begin : gen_grey
      logic [7:0] pixel2_q, over2_q;
      always_ff @(posedge clk_i) begin
        pixel2_q <= s1_pixels_q[8*lane+:8];
        over2_q  <= s1_pixels_q[8*lane+:8] + s1_room_q + 8'd1;  // less the threshold
        if (!lit2_q) weights_o[8*lane+:8] <= 8'd0;
        else if (s2_binary_q) weights_o[8*lane+:8] <= 8'd1;
        else weights_o[8*lane+:8] <= s2_grey_q ? pixel2_q : over2_q;
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
