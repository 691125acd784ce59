// One column divided: from the moments of a grey mode to centroid, lit pixels and quality.
//
//   centroid = floor(512 M1 / M0 + 1/2)     in 1/512 rows; 0 where no pixel is lit
//   n        = min(N, 63)
//   quality  = {runs, min(second, 15)}      strongest_i
//              floor(64 M0 / (2^PixelBits N))   else: the mean weight of a lit pixel, in 1/64 of
//                                           the largest and 1
//
// Both quotients take a stage for each bit, the highest first: the rest, doubled and with the next
// bit of the dividend, less the divisor, if it is not smaller. A stage more of the centroid tells
// whether the rest is half of M0 or more.
//
// Guarantees: one column in every clock; word_o follows RowBits + 12 clocks after the inputs, and
// is 0 where n_i is 0. The centroid is within half of 1/512 row of M1 / M0. Nothing overflows: M1
// is at most MaxRows M0, so the centroid is at most 512 MaxRows; M0 is below 2^PixelBits N, so the
// mean weight is below 64 / 64. Only n and second are limited.
//
//   clock        0   1   2 ... RowBits + 12
//   m0_i ...    -< A >< B >- ... -----------
//   word_o      ------------ ... -----< A >< B
`default_nettype none

module sp_compact_column #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int MaxWeight = 2 ** PixelBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int M1Bits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1)
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

  if (MaxRows < 2 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_2047 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  localparam int Fraction = 9;  // bits of the centroid behind the point
  localparam int Bits = RowBits + Fraction;
  localparam int NBits = sp_spec_pkg::CompactNBits;
  localparam int QualityBits = sp_spec_pkg::CompactQualityBits;
  localparam int Tail = PixelBits - QualityBits;  // bits of the mean weight that the quality has not

  // --- The centroid. rest[k], of M0Bits, and bits[k] are of stage k + 1: in bits the quotient
  // grows from below while M1 leaves above. Before the first step the rest is M1 / 2^RowBits, below
  // M0. ---
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
    mean_rest_q[0+:RowBits] <= RowBits'(m0_i >> PixelBits);
    mean_q[0+:QualityBits]  <= m0_i[PixelBits-1:Tail];
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

`ifdef FORMAL
  // The moments of any one column, which come in at any one clock
  localparam int FLatency = RowBits + 12;
  localparam int FBits = M0Bits + Bits + 2;
  (* anyconst *) logic [M0Bits-1:0]  f_m0;
  (* anyconst *) logic [M1Bits-1:0]  f_m1;
  (* anyconst *) logic [RowBits-1:0] f_n;
  (* anyconst *) logic [1:0]         f_runs;
  (* anyconst *) logic [4:0]         f_second;
  (* anyseq *) logic                 f_comes;
  logic [FLatency:1]                 f_came_q = '0;
  logic                              f_strongest_q;
  always_ff @(posedge clk_i) begin
    f_came_q      <= {f_came_q[FLatency-1:1], f_comes};
    f_strongest_q <= strongest_i;
  end
  // An image gives them: every lit pixel weighs 1 or more, and its row is 1..MaxRows. It weighs no
  // more than 7 here, because products of wide numbers take a proof too long.
  always_comb begin
    if (f_comes) assume ({m0_i, m1_i, n_i, runs_i, second_i} == {f_m0, f_m1, f_n, f_runs, f_second});
    if (f_came_q != '0) assume (strongest_i == f_strongest_q);
    assume (f_n <= RowBits'(MaxRows) && second_i <= 5'd16);
    assume (FBits'(f_m0) >= FBits'(f_n) && FBits'(f_m0) <= FBits'(7) * FBits'(f_n));
    assume (FBits'(f_m1) >= FBits'(f_m0) && FBits'(f_m1) <= FBits'(MaxRows) * FBits'(f_m0));
  end

  logic [FBits-1:0]       f_twice, f_centroid;  // 2 M0 centroid; the centroid of the word
  logic [QualityBits-1:0] f_quality;
  always_comb begin
    f_centroid = FBits'(word_o[sp_spec_pkg::CompactCentroidLsb+:sp_spec_pkg::CompactCentroidBits]);
    f_quality  = word_o[sp_spec_pkg::CompactQualityLsb+:QualityBits];
    f_twice    = '0;
    for (int bit_of = 0; bit_of < Bits; bit_of++) begin
      if (f_centroid[bit_of]) f_twice = f_twice + (FBits'(f_m0) << (bit_of + 1));
    end
  end
  always_comb if (f_came_q[FLatency]) begin
    // Rule 1: the word of a column without light is 0.
    if (f_n == '0) assert (word_o == '0);
    else begin
      // Rule 2: the centroid is the nearest multiple of 1/512, halves up.
      assert (f_twice + FBits'(f_m0) > (FBits'(f_m1) << (Fraction + 1)));
      assert (f_twice <= (FBits'(f_m1) << (Fraction + 1)) + FBits'(f_m0));
      assert (f_centroid >> Bits == '0);
      // Rule 3: n is the number of lit pixels, 63 at most; the quality is what the select says.
      assert (word_o[sp_spec_pkg::CompactNLsb+:NBits] == (f_n > 63 ? NBits'(63) : NBits'(f_n)));
      if (f_strongest_q) assert (f_quality == {f_runs, f_second[4] ? 4'd15 : f_second[3:0]});
      else begin
        assert (FBits'(f_quality) * (FBits'(f_n) << Tail) <= FBits'(f_m0));
        assert (FBits'(f_m0) < (FBits'(f_quality) + FBits'(1)) * (FBits'(f_n) << Tail));
      end
    end
    cover (f_n != '0 && f_m0 == M0Bits'(3) && f_centroid[0] && !f_strongest_q);
  end
`endif

endmodule

`default_nettype wire
