// 64-bit counter whose carry into the upper word is known a clock ahead: two chains of 32 bits instead of one of 64.
//
// Guarantees: count_o = ResetValue plus the number of clocks with inc_i since reset, modulo 2^64; always coherent.
`default_nettype none

module sp_counter64 #(
  parameter logic [63:0] ResetValue = 64'd0
) (
  input  wire logic clk_i,
  input  wire logic rst_i,
  input  wire logic inc_i,
  output logic [63:0] count_o
);

  logic [31:0] low_q;
  logic [31:0] high_q;
  logic        low_full_q;  // low_q is all ones

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      low_q      <= ResetValue[31:0];
      high_q     <= ResetValue[63:32];
      low_full_q <= ResetValue[31:0] == 32'hFFFF_FFFF;
    end else if (inc_i) begin
      low_q      <= low_q + 32'd1;
      low_full_q <= low_q == 32'hFFFF_FFFE;
      if (low_full_q) high_q <= high_q + 32'd1;
    end
  end

  assign count_o = {high_q, low_q};

endmodule

`default_nettype wire
