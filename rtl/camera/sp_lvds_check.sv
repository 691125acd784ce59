// Compares the check word of a lane's line with the pixel words before it.
//
// The data sheet NOIP1SN025KA of onsemi names the polynomial x^10 + x^9 + x^6 + x^3 + x^2 + x + 1, a
// seed of all zeros or all ones, and that it is updated for every data word of a line. That the
// highest bit of a word comes first is taken from the order in which it is sent.
//
// Guarantees: wrong_o is high if the word with check_i is not the check word of the words with take_i
// since the last word without.
//
// Latency: wrong_o comes one clock behind check_i.
//
//   take_i   /1111111\_________   words 0 and 1
//   check_i  ________/111\_____
//   word_i   <0  ><1 ><C >-----
//   wrong_o  ____________/111\_   C is not their check word
`default_nettype none

module sp_lvds_check #(
  parameter bit Seed = 1'b0  // each bit of the seed
) (
  input  wire logic       clk_i,
  input  wire logic       decoded_i,  // a word
  input  wire logic       take_i,     // with it: it is a pixel word of the line
  input  wire logic       check_i,    // with it: it is the check word
  input  wire logic [9:0] word_i,
  output logic            wrong_o
);

  logic [9:0] sum_q, sum;

  always_comb begin
    sum = sum_q;
    for (int i = 9; i >= 0; i--) sum = {sum[8:0], 1'b0} ^ (sum[9] ^ word_i[i] ? 10'h24F : 10'h000);
  end

  always_ff @(posedge clk_i) begin
    if (decoded_i) sum_q <= take_i ? sum : {10{Seed}};
    wrong_o <= decoded_i && check_i && word_i != sum_q;
  end

endmodule

`default_nettype wire
