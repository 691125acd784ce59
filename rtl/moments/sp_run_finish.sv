// Grey builds: completes the strongest run of one column: M1, and the strength of the second run.
//
//   M1 = R*M0 - A           A = sum over the rows before R of M0 up to there, from the run's first
//   second = floor(16*M0_2 / M0)    0..16; 0 where there is one run at most
//
// R is the row in which the run ended. The quotient takes a stage for each of its five bits: the
// rest, doubled from the second bit on, less M0, if it is not smaller. The second run is not
// stronger than the strongest, so the first bit tells that they are equal.
//
// Guarantees: one column in every clock; the outputs follow five clocks after the inputs, and are 0
// for a column without a run. Nothing overflows: the quotient is at most 16, and the difference
// is M1. (R*M0 can have one bit more than M1 needs; that bit drops out.)
`default_nettype none

module sp_run_finish #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int MaxWeight = 2 ** PixelBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1)
) (
  input  wire logic               clk_i,
  input  wire logic [1:0]         runs_i,
  input  wire logic [M0Bits-1:0]  second_i,
  input  wire logic [M0Bits-1:0]  m0_i,
  input  wire logic [RowBits-1:0] n_i,
  input  wire logic [RowBits-1:0] row_i,
  input  wire logic [ABits-1:0]   a_i,

  output logic      [1:0]         runs_o,
  output logic      [4:0]         second_o,
  output logic      [M0Bits-1:0]  m0_o,
  output logic      [RowBits-1:0] n_o,
  output logic      [ABits-1:0]   m1_o
);

  if (MaxRows < 2 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_2047 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  localparam int Stages = 5;
  localparam int CarryBits = 2 + M0Bits + RowBits;

  // What only waits, stage 1 lowest
  logic [Stages*CarryBits-1:0] carry_q;
  logic [(Stages-1)*ABits-1:0] a_q;
  always_ff @(posedge clk_i) begin
    carry_q <= {carry_q[(Stages-1)*CarryBits-1:0], runs_i, m0_i, n_i};
    a_q     <= {a_q[(Stages-2)*ABits-1:0], a_i};
  end
  assign {runs_o, m0_o, n_o} = carry_q[(Stages-1)*CarryBits+:CarryBits];

  // The quotient, the highest bit first. Step s (from 0) makes stage s + 1.
  logic [5*Stages-1:0]          quotient_q;
  logic [M0Bits*(Stages-1)-1:0] rest_q;
  logic                         unused_quotient;
  assign unused_quotient = ^quotient_q;
  for (genvar s = 0; s < Stages; s++) begin : gen_step
    logic [M0Bits:0]   rest;
    logic [M0Bits-1:0] divisor, less;
    logic              fits, unused;  // the divisor fits; the rest is below it
    if (s == 0) begin : gen_first
      assign rest    = {1'b0, second_i};
      assign divisor = m0_i;
      always_ff @(posedge clk_i) quotient_q[4:0] <= {4'd0, fits};
    end else begin : gen_next
      assign rest    = {rest_q[(s-1)*M0Bits+:M0Bits], 1'b0};
      assign divisor = carry_q[(s-1)*CarryBits+RowBits+:M0Bits];
      always_ff @(posedge clk_i) quotient_q[5*s+:5] <= {quotient_q[5*(s-1)+:4], fits};
    end
    assign {fits, unused, less} = {1'b0, rest} + {1'b0, ~{1'b0, divisor}} + (M0Bits + 2)'(1);
    if (s < Stages - 1) begin : gen_rest
      always_ff @(posedge clk_i) rest_q[s*M0Bits+:M0Bits] <= fits ? less : rest[M0Bits-1:0];
    end else begin : gen_no_rest
      logic unused_less;
      assign unused_less = ^less;
    end
  end
  // A column without a run divides by 0.
  assign second_o = runs_o[1] ? quotient_q[5*(Stages-1)+:5] : 5'd0;

  // M1
  logic [M0Bits+RowBits-1:0] product4;
  logic                      unused_product;
  logic [RowBits-1:0]        row1_q;
  always_ff @(posedge clk_i) row1_q <= row_i;
  assign unused_product = ^product4;
  sp_scale #(
    .XBits(M0Bits),
    .KBits(RowBits)
  ) u_scale (
    .clk_i    (clk_i),
    .move_i   (1'b1),
    .x_i      (m0_i),
    .k_i      (row1_q),
    .product_o(product4)
  );
  always_ff @(posedge clk_i) m1_o <= product4[ABits-1:0] - a_q[(Stages-2)*ABits+:ABits];

endmodule

`default_nettype wire
