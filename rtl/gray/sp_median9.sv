// Lower median of the measurable codes among nine.
//
// Each of the nine is {measurable, code}; the centre is number 4. A code that does not exist counts
// as not measurable. If more than half_i of them are measurable, the result is the lower median of
// their codes, measurable; else it is 0. Without median_i the result is the centre as it is. The
// rank of a code is the number of codes that are smaller, or equal and earlier: every pair is
// compared once.
//
// Timing: nine new codes in every clock, together with median_i and half_i; the result follows
// three clocks later.
`default_nettype none

module sp_median9 #(
  parameter int CodeBits = sp_spec_pkg::CodeCodeBits  // 1 or more
) (
  input  wire logic                          clk_i,
  input  wire logic [9*(CodeBits+1)-1:0]     codes_i,
  input  wire logic                          median_i,
  // half the number of existing codes, rounded down
  input  wire logic [3:0]                    half_i,
  output logic      [CodeBits:0]             code_o
);

  if (CodeBits < 1) begin : gen_code_bits
    code_bits_is_less_than_1 u_error ();
  end

  localparam int Width = CodeBits + 1;

  // --- Clock 1: compare every pair, in the order of {not measurable, code, place} ---
  logic [9*9-1:0]     earlier_q;  // bit 9 i + j: j is earlier than i
  logic [3:0]         count, count_q;
  logic [9*Width-1:0] codes_q, codes_q2;
  logic [3:0]         half_q;
  logic               median_q, median_q2;

  for (genvar i = 0; i < 9; i++) begin : gen_i
    for (genvar j = 0; j < 9; j++) begin : gen_j
      if (i == j) begin : gen_same
        assign earlier_q[9*i+j] = 1'b0;
      end else if (i < j) begin : gen_compare
        logic less;
        always_ff @(posedge clk_i) begin
          less <= {!codes_i[Width*j+CodeBits], codes_i[Width*j+:CodeBits]} <
                  {!codes_i[Width*i+CodeBits], codes_i[Width*i+:CodeBits]};
        end
        assign earlier_q[9*i+j] = less;
        assign earlier_q[9*j+i] = !less;
      end
    end
  end

  always_comb begin
    count = 4'd0;
    for (int i = 0; i < 9; i++) count = count + 4'(codes_i[Width*i+CodeBits]);
  end

  always_ff @(posedge clk_i) begin
    {count_q, half_q, median_q} <= {count, half_i, median_i};
    {codes_q, codes_q2}         <= {codes_i, codes_q};
  end

  // --- Clock 2: find the code whose rank is that of the lower median, (count - 1) / 2 ---
  logic [3:0] target;
  logic [8:0] chosen_q;
  logic       enough_q;

  assign target = (count_q - 4'd1) >> 1;

  for (genvar i = 0; i < 9; i++) begin : gen_rank
    logic [3:0] rank;
    always_comb begin
      rank = 4'd0;
      for (int j = 0; j < 9; j++) rank = rank + 4'(earlier_q[9*i+j]);
    end
    always_ff @(posedge clk_i) chosen_q[i] <= rank == target;
  end

  always_ff @(posedge clk_i) begin
    enough_q  <= count_q > half_q;
    median_q2 <= median_q;
  end

  // --- Clock 3 ---
  logic [CodeBits-1:0] code;

  always_comb begin
    code = '0;
    for (int i = 0; i < 9; i++) code = code |
                                       (chosen_q[i] ? codes_q2[Width*i+:CodeBits] : CodeBits'(0));
  end

  always_ff @(posedge clk_i) begin
    if (!median_q2) code_o <= codes_q2[Width*4+:Width];
    else if (enough_q) code_o <= {1'b1, code};
    else code_o <= '0;
  end

endmodule

`default_nettype wire
