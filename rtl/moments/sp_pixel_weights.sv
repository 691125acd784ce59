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
  input  wire logic [1:0]              mode_i,
  input  wire logic [7:0]              threshold_i,
  output logic      [4*WeightBits-1:0] weights_o
);

  logic [31:0] s1_pixels_q;
  logic [7:0]  s1_room_q;     // 255 minus the threshold
  logic [1:0]  s1_mode_q;
  always_ff @(posedge clk_i) begin
    s1_pixels_q <= beat_pixels_i;
    s1_room_q   <= ~threshold_i;
    s1_mode_q   <= mode_i;
  end

  for (genvar lane = 0; lane < 4; lane++) begin : gen_weight
    // A pixel is lit where pixel + (255 - threshold) exceeds 255. The carry is taken as a bit of
    // the sum, so that it stays at the end of its chain. It does not matter in reset.
    logic       lit;
    logic [7:0] unused_sum;
    assign {lit, unused_sum} = {rst_i, s1_pixels_q[8*lane+:8]} + {1'b0, s1_room_q};
    if (Grey) begin : gen_grey
      logic [7:0] over1_q, value2_q;
      logic       lit2_q;
      always_ff @(posedge clk_i) begin
        over1_q <= beat_pixels_i[8*lane+:8] - threshold_i;
        case (s1_mode_q)
          sp_spec_pkg::ModeBinary: value2_q <= 8'd1;
          sp_spec_pkg::ModeGrey:   value2_q <= s1_pixels_q[8*lane+:8];
          default:                 value2_q <= over1_q;
        endcase
        lit2_q               <= lit;
        weights_o[8*lane+:8] <= lit2_q ? value2_q : 8'd0;
      end
    end else begin : gen_binary
      logic lit2_q;
      always_ff @(posedge clk_i) begin
        lit2_q          <= lit;
        weights_o[lane] <= lit2_q;
      end
    end
  end

  if (!Grey) begin : gen_no_mode
    logic unused;
    assign unused = ^s1_mode_q;
  end

endmodule

`default_nettype wire
