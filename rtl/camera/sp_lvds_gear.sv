// Turns four bits of each lane in every clock, as deserializers of four bits give them, into words of
// 8, 10 or 12 bits.
//
// Guarantees: every bit becomes part of one word, in order; all lanes' words begin at the same time,
// somewhere. Four bits come in every clock, so words come in 1/2, 2/5 or 1/3 of the clocks.
//
// Latency: a word leaves one clock after its last bit. Bits = 10:
//
//   clock    0   1   2   3   4   5   6   7
//   bits_i  <A0><A1><A2><A3><A4><B0><B1><B2>   20 bits are two words
//   valid_o ____________/111\___/111\_______/1
//   words_o ------------<A  >---<A' >-------<B
`default_nettype none

module sp_lvds_gear #(
  parameter int Lanes = 17,  // all of them, with the control lane: 1..32
  parameter int Bits = 10  // of a word: 8, 10 or 12
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,   // active high, synchronous
  input  wire logic [4*Lanes-1:0]    bits_i,  // of lane n in 4n+3..4n, the first one in 4n
  output logic                       valid_o,
  output logic      [Bits*Lanes-1:0] words_o  // of lane n from bit Bits x n on, the first one there
);

  if (Lanes < 1 || Lanes > 32) begin : gen_lanes
    lanes_is_not_in_1_to_32 u_error ();
  end
  if (Bits != 8 && Bits != 10 && Bits != 12) begin : gen_bits
    bits_is_not_8_10_or_12 u_error ();
  end

  logic [3:0] wait_q;  // bits that wait for their word
  logic [3:0] fill;
  logic       two;     // two bits are behind the word

  assign fill = wait_q + 4'd4;
  assign two  = fill == 4'(Bits + 2);

  always_ff @(posedge clk_i) begin
    if (rst_i) wait_q <= '0;
    else if (fill < 4'(Bits)) wait_q <= fill;
    else wait_q <= two ? 4'd2 : '0;
    valid_o <= fill >= 4'(Bits) && !rst_i;
  end

  for (genvar n = 0; n < Lanes; n++) begin : gen_lane
    logic [Bits-3:0] before_q;  // the last bits, the newest at the top
    logic [Bits+1:0] all;
    assign all = {bits_i[4*n+:4], before_q};
    always_ff @(posedge clk_i) begin
      before_q <= all[Bits+1:4];
      words_o[Bits*n+:Bits] <= two ? all[Bits-1:0] : all[Bits+1:2];
    end
  end

endmodule

`default_nettype wire
