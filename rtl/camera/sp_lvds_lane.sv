// One lane of a serial sensor: cuts words out of the deserializer's bits, at the place that training
// has found.
//
// Guarantees: word_o holds Bits successive bits of the lane. slip_i says where in the deserializer's
// words they begin. With newer_i they begin one word later, so that lanes with different slips give
// words that were sent at the same time. Bit 0 of lane_i is the bit that arrived first.
//
// Latency: 2 or 3 words, with and without newer_i. A word counts in the clock of en_i; without it,
// nothing changes. Bits = 10, slip_i = 3:
//
//   en_i     /1111111111111111\__
//   lane_i   <r0><r1><r2><r3>----
//   word_o   --------<w0><w1><w2>   newer_i; w0 = bits 9..3 of r0, then bits 2..0 of r1
`default_nettype none

module sp_lvds_lane #(
  parameter int Bits = 10,  // of a word: 8, 10 or 12
  parameter bit MsbFirst = 1'b0  // the bit that arrives first is the highest of a word
) (
  input  wire logic            clk_i,
  input  wire logic            en_i,     // the deserializer's next word
  input  wire logic [Bits-1:0] lane_i,
  input  wire logic [3:0]      slip_i,   // 0..Bits-1
  input  wire logic            newer_i,
  output logic      [Bits-1:0] word_o
);

  if (Bits != 8 && Bits != 10 && Bits != 12) begin : gen_bits
    bits_is_not_8_10_or_12 u_error ();
  end

  logic [Bits-1:0]   before_q, cut_q, word_q;
  logic [2*Bits-1:0] shifted;
  logic              unused;

  assign shifted = {lane_i, before_q} >> slip_i;
  assign unused  = ^shifted[2*Bits-1:Bits];

  always_ff @(posedge clk_i) begin
    if (en_i) begin
      before_q <= lane_i;
      cut_q    <= shifted[Bits-1:0];
      word_q   <= newer_i ? shifted[Bits-1:0] : cut_q;
    end
  end

  // word_q was written with the last word: word_o shows it now, and stays until the next one.
  for (genvar i = 0; i < Bits; i++) begin : gen_bit
    assign word_o[i] = MsbFirst ? word_q[Bits-1-i] : word_q[i];
  end

endmodule

`default_nettype wire
