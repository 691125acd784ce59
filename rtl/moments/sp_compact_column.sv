// One column divided: from the moments of a grey mode to centroid, lit pixels and quality.
//
//   centroid = floor(512 M1 / M0 + 1/2)     in 1/512 rows; 0 where no pixel is lit
//   n        = min(N, 63)
//   quality  = {runs, min(second, 15)}      strongest_i
//              floor(M0 / (4 N))            else: the mean weight of a lit pixel, in 1/64 of 256
//
// Both quotients take a stage for each bit, the highest first: the rest, doubled and with the next
// bit of the dividend, less the divisor, if it is not smaller. A stage more of the centroid tells
// whether the rest is half of M0 or more.
//
// Guarantees: one column in every clock; word_o follows RowBits + 12 clocks after the inputs, and
// is 0 where n_i is 0. The centroid is within half of 1/512 row of M1 / M0. Nothing overflows: M1
// is at most MaxRows M0, so the centroid is at most 512 MaxRows; M0 is at most 255 N, so the mean
// weight is below 256. Only n and second are limited.
//
//   clock        0   1   2 ... RowBits + 12
//   m0_i ...    -< A >< B >- ... -----------
//   word_o      ------------ ... -----< A >< B
`default_nettype none

module sp_compact_column #(
  parameter int MaxRows = 1023,  // 2..1023
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int M0Bits = $clog2(255 * MaxRows + 1),
  parameter int M1Bits = $clog2(255 * MaxRows * (MaxRows + 1) / 2 + 1)
) (
  input  wire logic               clk_i,
  input  wire logic               strongest_i,  // stands still while columns are on their way
  input  wire logic [M0Bits-1:0]  m0_i,
  input  wire logic [M1Bits-1:0]  m1_i,
  input  wire logic [RowBits-1:0] n_i,
  input  wire logic [1:0]         runs_i,
  input  wire logic [4:0]         second_i,

  output logic      [31:0]        word_o
);

  if (MaxRows < 2 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_max_rows
    max_rows_is_not_in_2_to_1023 u_error ();
  end

  localparam int Fraction = 9;  // bits of the centroid behind the point
  localparam int Bits = RowBits + Fraction;
  localparam int NBits = sp_spec_pkg::CompactNBits;
  localparam int QualityBits = sp_spec_pkg::CompactQualityBits;
  localparam int Tail = 8 - QualityBits;  // bits of the mean weight that the quality has not

  // --- The centroid. rest[k], of M0Bits, and bits[k] are of stage k + 1: in bits the quotient grows
  // from below while M1 leaves above. Before the first step the rest is M1 / 2^RowBits, below M0. ---
  logic [M0Bits*(Bits+2)-1:0] m0_q;
  logic [M0Bits*(Bits+1)-1:0] rest_q;
  logic [Bits*(Bits+2)-1:0]   bits_q;
  logic                       half_q;  // stage Bits + 2: the rest is half of M0 or more
  always_ff @(posedge clk_i) begin
    m0_q                <= {m0_q[M0Bits*(Bits+1)-1:0], m0_i};
    rest_q[0+:M0Bits]   <= M0Bits'(m1_i >> RowBits);
    bits_q[0+:Bits]     <= {m1_i[RowBits-1:0], {Fraction{1'b0}}};
  end
  for (genvar s = 0; s <= Bits; s++) begin : gen_step
    logic [M0Bits:0]   rest;
    logic [M0Bits-1:0] less;
    logic              fits, unused;
    assign rest = {rest_q[s*M0Bits+:M0Bits], s < Bits && bits_q[(s+1)*Bits-1]};
    assign {fits, unused, less} =
        {1'b0, rest} + {1'b0, ~{1'b0, m0_q[s*M0Bits+:M0Bits]}} + (M0Bits + 2)'(1);
    if (s < Bits) begin : gen_bit
      always_ff @(posedge clk_i) begin
        rest_q[(s+1)*M0Bits+:M0Bits] <= fits ? less : rest[M0Bits-1:0];
        bits_q[(s+1)*Bits+:Bits]     <= {bits_q[s*Bits+:Bits-1], fits};
      end
    end else begin : gen_half
      logic unused_less;
      assign unused_less = ^less;
      always_ff @(posedge clk_i) begin
        half_q                   <= fits;
        bits_q[(s+1)*Bits+:Bits] <= bits_q[s*Bits+:Bits];
      end
    end
  end

  // --- Lit pixels and quality; stage 1 lowest ---
  logic [RowBits*QualityBits-1:0]       n_q;
  logic [RowBits*(QualityBits+1)-1:0]   mean_rest_q;
  logic [QualityBits*(QualityBits+1)-1:0] mean_q;
  logic [6*(QualityBits+1)-1:0]         told_q;  // of runs and second
  always_ff @(posedge clk_i) begin
    n_q                     <= {n_q[RowBits*(QualityBits-1)-1:0], n_i};
    told_q                  <= {told_q[6*QualityBits-1:0], runs_i, second_i[3:0] | {4{second_i[4]}}};
    mean_rest_q[0+:RowBits] <= RowBits'(m0_i >> 8);
    mean_q[0+:QualityBits]  <= m0_i[7:Tail];
  end
  for (genvar s = 0; s < QualityBits; s++) begin : gen_mean
    logic [RowBits:0]   rest;
    logic [RowBits-1:0] less;
    logic               fits, unused;
    assign rest = {mean_rest_q[s*RowBits+:RowBits], mean_q[(s+1)*QualityBits-1]};
    assign {fits, unused, less} =
        {1'b0, rest} + {1'b0, ~{1'b0, n_q[s*RowBits+:RowBits]}} + (RowBits + 2)'(1);
    always_ff @(posedge clk_i) begin
      mean_rest_q[(s+1)*RowBits+:RowBits]       <= fits ? less : rest[RowBits-1:0];
      mean_q[(s+1)*QualityBits+:QualityBits]    <= {mean_q[s*QualityBits+:QualityBits-1], fits};
    end
  end

  // What waits for the centroid: whether a pixel is lit, how many, and the quality
  localparam int Early = QualityBits + 1;      // the stage in which the quality is there
  localparam int Waits = Bits + 2 - Early;
  localparam int WaitBits = 1 + NBits + QualityBits;
  logic [(1+NBits)*Early-1:0] lit_q;
  logic [WaitBits*Waits-1:0]  wait_q;
  logic                       many;
  assign many = (RowBits + NBits)'(n_i) > (RowBits + NBits)'(2 ** NBits - 1);
  always_ff @(posedge clk_i) begin
    lit_q  <= {lit_q[(1+NBits)*(Early-1)-1:0], n_i != '0, NBits'(n_i) | {NBits{many}}};
    wait_q <= {wait_q[WaitBits*(Waits-1)-1:0], lit_q[(1+NBits)*(Early-1)+:1+NBits],
               strongest_i ? told_q[6*QualityBits+:6] : mean_q[QualityBits*QualityBits+:QualityBits]};
  end

  logic                   lit;
  logic [NBits-1:0]       n;
  logic [QualityBits-1:0] quality;
  logic [Bits-1:0]        centroid;
  assign {lit, n, quality} = wait_q[WaitBits*(Waits-1)+:WaitBits];
  assign centroid          = bits_q[(Bits+1)*Bits+:Bits] + Bits'(half_q);
  always_ff @(posedge clk_i) begin
    word_o <= {32{lit}} & (32'(centroid) << sp_spec_pkg::CompactCentroidLsb |
                           32'(n) << sp_spec_pkg::CompactNLsb |
                           32'(quality) << sp_spec_pkg::CompactQualityLsb);
  end
  logic unused_ends;
  assign unused_ends = ^{m0_q[M0Bits*(Bits+1)+:M0Bits], mean_rest_q[RowBits*QualityBits+:RowBits]};

endmodule

`default_nettype wire
