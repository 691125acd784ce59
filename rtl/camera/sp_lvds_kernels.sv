// Puts the pixels of a line in order, where two words of all lanes together carry neighbouring
// columns, a kernel, and every second kernel comes backwards (PYTHON; 4 lanes: kernels of 8 columns).
//
// Source: data sheet NOIP1SN025KA of onsemi, figure 36, for as many lanes as the sensor's channels
// have; an open decoder (python_decode) has the same order for any number. A sensor that leaves some
// of its channels unused sends another order, which is not supported.
//
//   lane              0    1    2    3           Lanes = 4
//   kernel 0, word 0  0    2    4    6
//             word 1  1    3    5    7
//   kernel 1, word 0  15   13   11   9
//             word 1  14   12   10   8
//
// Guarantees: group_o holds Lanes neighbouring columns, the leftmost in 7..0. The groups of a line
// leave from left to right. A line begins with an even kernel and has an even number of words.
// Behind its last word comes one word or more without take_i.
//
// Latency: a kernel's groups leave 1 and 2 clocks after its second word, ending_o 3 clocks after the
// last word of a line.
//
//   take_i     /111111111111111\_______________
//   last_i     ____________/111\_______________
//   full_o     ________/111111111111111\_______   columns 0..3, 4..7, 8..11, 12..15
//   ending_o   ________________________/111\___
`default_nettype none

module sp_lvds_kernels #(
  parameter int Lanes = 4  // 2, 4, 8 or 16
) (
  input  wire logic               clk_i,
  input  wire logic               rst_i,     // active high, synchronous
  input  wire logic               begins_i,  // a frame begins, with its first word or before it
  input  wire logic               take_i,    // one pixel of each lane
  input  wire logic               last_i,    // with it: the last ones of their line
  input  wire logic               cut_i,     // the line is lost
  input  wire logic [8*Lanes-1:0] pixels_i,
  output logic                    begins_o,  // with the first group of a frame
  output logic                    full_o,
  output logic      [8*Lanes-1:0] group_o,
  output logic                    ending_o
);

  if (Lanes != 2 && Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_2_4_8_or_16 u_error ();
  end

  logic                second_q;    // the next word is the second of its kernel
  logic                odd_q;       // the kernel comes backwards
  logic                first_q;     // no group of the frame has left
  logic [8*Lanes-1:0]  before_q;    // the first word
  logic [16*Lanes-1:0] kernel;
  logic [8*Lanes-1:0]  upper_q;
  logic                lower_q, rest_q;  // the lower, the upper half leaves
  logic [1:0]          end_q;

  for (genvar i = 0; i < Lanes; i++) begin : gen_lane
    localparam int Back = Lanes - 1 - i;
    assign kernel[16*i+:8]   = odd_q ? pixels_i[8*Back+:8] : before_q[8*i+:8];
    assign kernel[16*i+8+:8] = odd_q ? before_q[8*Back+:8] : pixels_i[8*i+:8];
  end

  assign full_o   = lower_q || rest_q;
  assign begins_o = full_o && first_q;

  always_ff @(posedge clk_i) begin
    if (rst_i || cut_i) {second_q, odd_q, lower_q, rest_q, end_q, ending_o} <= '0;
    else begin
      if (take_i) begin
        second_q <= !last_i && !second_q;
        odd_q    <= !last_i && (odd_q ^ second_q);
      end
      lower_q  <= take_i && second_q;
      rest_q   <= lower_q;
      end_q    <= {end_q[0], take_i && last_i};
      ending_o <= end_q[1];
    end
    if (take_i && !second_q) before_q <= pixels_i;
    if (take_i && second_q) {upper_q, group_o} <= kernel;
    else if (lower_q) group_o <= upper_q;
    if (begins_i) first_q <= 1'b1;
    else if (full_o) first_q <= 1'b0;
  end

endmodule

`default_nettype wire
