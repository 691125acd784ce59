// One column lane of the runs: whether a run is open, and the sums of the run.
//
// A column has three values, in three memories of sp_run_sums, each read and written one clock
// after the one before:
//
//   D  {open, dark rows since the last lit one}
//   M  {N, M0} of the run, in a binary build M0 alone
//   A  binary: M1 of the run; grey: the sum over its rows of M0 before each (see sp_run_finish)
//
// A run is open from its first lit row until more than `gap` dark rows in succession end it. The
// row that ends it still has its sums. A run begins with sums of 0. Where select is `all`, no run
// ends, so the sums are those of all lit pixels.
//
// Two beats go through at once: a main beat, which adds to what the memories have, and a first
// beat, of the first row of a frame, which only writes. Stage 0 is the clock in which sp_run_sums
// takes them:
//
//   stage               0   1   2   3   4   5
//   s1_weight_i        -----< w >---------------   main beat
//   w1_weight_i        -----< w >---------------   first beat
//   raw_d_i, raw_m_i,  -----< D >< M >< A >------
//   raw_a_i
//   wr_d_o, wr_m_o     ---------< D >< M >-------   from either beat
//   wr_a_o             -----------------< A >----   from a main beat
//   s3_ends_o          -------------< e >--------   the run ends in this row
//   s3_has_run_o       -------------< e >--------   with this row, the column has a run
//   s4_m_o, s5_a_o     -----------------< M >< A >  of the main beat
//
// The sums never wrap: their widths follow from MaxRows.
`default_nettype none

module sp_run_lane #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter bit Grey = 1'b1,
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WeightBits = Grey ? PixelBits : 1,
  parameter int MaxWeight = 2 ** WeightBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1),
  parameter int MBits = Grey ? M0Bits + RowBits : M0Bits
) (
  input  wire logic                  clk_i,
  input  wire logic [WeightBits-1:0] s1_weight_i,
  input  wire logic                  s1_lit_i,     // the weight is not 0
  input  wire logic                  s1_alone_i,   // there is no earlier row
  input  wire logic                  s1_onto_new_i,   // the value of one clock ago is of the column
  input  wire logic                  s1_onto_last_i,  // that of two clocks ago is
  input  wire logic                  s2_onto_new_i,
  input  wire logic                  s2_onto_last_i,
  input  wire logic                  s3_onto_new_i,
  input  wire logic                  s3_onto_last_i,
  input  wire logic [1:0]            s2_gap_i,
  input  wire logic                  s2_strongest_i,
  input  wire logic [RowBits-1:0]    s3_row_i,
  input  wire logic                  s3_second_row_i,
  input  wire logic [WeightBits-1:0] w1_weight_i,
  input  wire logic                  w1_lit_i,
  input  wire logic                  w2_first_i,   // the write of D is of a first beat
  input  wire logic                  w3_first_i,

  input  wire logic [2:0]            raw_d_i,
  input  wire logic [MBits-1:0]      raw_m_i,
  input  wire logic [ABits-1:0]      raw_a_i,
  output logic      [2:0]            wr_d_o,
  output logic      [MBits-1:0]      wr_m_o,
  output logic      [ABits-1:0]      wr_a_o,

  output logic                       s3_ends_o,
  output logic                       s3_has_run_o,
  output logic      [MBits-1:0]      s4_m_o,
  output logic      [ABits-1:0]      s5_a_o
);

  if (MaxRows < 2 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_2047 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  // The first beat
  logic [WeightBits-1:0] w2_weight_q, w3_weight_q;
  logic                  w2_lit_q, w3_lit_q;
  always_ff @(posedge clk_i) begin
    w2_weight_q <= w1_weight_i;
    w2_lit_q    <= w1_lit_i;
    w3_weight_q <= w2_weight_q;
    w3_lit_q    <= w2_lit_q;
  end

  // --- D ---
  logic                  s2_open_q, s2_lit_q, ends;
  logic [1:0]            s2_dark_q;
  logic [2:0]            wr_d_q;
  logic [WeightBits-1:0] s2_weight_q;
  assign ends   = s2_open_q && !s2_lit_q && s2_strongest_i && s2_dark_q == s2_gap_i;
  assign wr_d_o = w2_first_i ? {w2_lit_q, 2'd0} :
                  {s2_lit_q || s2_open_q && !ends, s2_lit_q ? 2'd0 : s2_dark_q + 2'd1};
  always_ff @(posedge clk_i) begin
    {s2_open_q, s2_dark_q} <= s1_alone_i ? '0 : s1_onto_new_i ? wr_d_o :
                              s1_onto_last_i ? wr_d_q : raw_d_i;
    s2_weight_q <= s1_weight_i;
    s2_lit_q    <= s1_lit_i;
    wr_d_q      <= wr_d_o;
  end

  // --- M ---
  logic                  s3_open_q, s3_lit_q;
  logic [WeightBits-1:0] s3_weight_q;
  logic [MBits-1:0]      s3_m_q, wr_m_q, next_m;
  logic [M0Bits-1:0]     s3_m0;
  assign s3_m0 = s3_m_q[M0Bits-1:0];
  always_ff @(posedge clk_i) begin
    s3_m_q       <= !s2_open_q ? '0 : s2_onto_new_i ? wr_m_o : s2_onto_last_i ? wr_m_q : raw_m_i;
    s3_open_q    <= s2_open_q;
    s3_lit_q     <= s2_lit_q;
    s3_weight_q  <= s2_weight_q;
    s3_ends_o    <= ends;
    s3_has_run_o <= s2_open_q || s2_lit_q;
    s4_m_o       <= next_m;
    wr_m_q       <= wr_m_o;
  end
  if (Grey) begin : gen_grey_m
    assign next_m = {s3_m_q[M0Bits+:RowBits] + RowBits'(s3_lit_q), s3_m0 + M0Bits'(s3_weight_q)};
    assign wr_m_o = w3_first_i ? {RowBits'(w3_lit_q), M0Bits'(w3_weight_q)} : next_m;
  end else begin : gen_binary_m
    assign next_m = s3_m0 + M0Bits'(s3_weight_q);
    assign wr_m_o = w3_first_i ? M0Bits'(w3_weight_q) : next_m;
    logic unused;
    assign unused = w3_lit_q;
  end

  // --- A ---
  // No first beat writes it, so that no multiplexer stands behind the adder: after the first row it
  // is M0 in a binary build, and 0 in a grey one.
  logic [ABits-1:0] s4_a_q, s4_addend_q, wr_a_q;
  logic             after_first;  // bit 0 of A after the first row
  assign wr_a_o = s4_a_q + s4_addend_q;
  assign s5_a_o = wr_a_q;
  always_ff @(posedge clk_i) begin
    s4_a_q <= !s3_open_q ? '0 : s3_second_row_i ? ABits'(after_first) :
              s3_onto_new_i ? wr_a_o : s3_onto_last_i ? wr_a_q : raw_a_i;
    wr_a_q <= wr_a_o;
  end
  if (Grey) begin : gen_grey_a
    always_ff @(posedge clk_i) s4_addend_q <= ABits'(s3_m0);
    assign after_first = 1'b0;
    logic unused;
    assign unused = ^s3_row_i;
  end else begin : gen_binary_a
    always_ff @(posedge clk_i) s4_addend_q <= s3_lit_q ? ABits'(s3_row_i) : {ABits{1'b0}};
    assign after_first = s3_m0[0];
  end

endmodule

`default_nettype wire
