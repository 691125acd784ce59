// Running sums of the column lanes.
//
// One memory keeps M0 of each column (and N, the number of lit pixels, in a grey build). A second
// memory keeps the first-moment sum A and runs one clock later, so that A can take up the old M0.
// In mode binary A is M1 itself: every lit pixel adds its row. In the grey modes A adds up the M0
// before each row (A = sum over r < R of S_r', where S are the prefix sums). This needs no
// multiplier here; sp_moment_drain completes it: M1 = R*M0 - A.
//
// A grey build keeps M0 and A in two halves, so that no carry chain has more than half the bits.
// The carry between the halves is kept as well, and the next addition takes it up: {high, carry,
// low} stands for ((high + carry) << width of low) | low.
//
// Guarantees: the sums are right at every distance between two beats of one column, down to the
// very next clock. (An image of one group has all its beats at one address.) A sum that the memory
// does not have yet bypasses it. The sums never wrap: their widths follow from MaxRows. Latency, in
// clocks after a beat is taken (stage 0):
//
//   stage            0   1   2   3   4
//   add_i           _/1\_______________   the word of M is read
//   raw_m_o         -----< M >---------   the word of A is read
//   sum_m_comes_o   _________/1\_______   M is added up and written
//   raw_a_o         ---------< A >-----
//   sum_m_o         -------------< M >-
//   sum_a_comes_o   _____________/1\___   A is added up and written
//   sum_a_o         -----------------< A
`default_nettype none

module sp_moment_sums #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int GroupBits = 9,  // 1..24
  parameter bit Grey = 1'b1,
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WeightBits = Grey ? PixelBits : 1,
  parameter int MaxWeight = 2 ** WeightBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1),
  parameter int LaneMBits = Grey ? M0Bits + 1 + RowBits : M0Bits,
  parameter int LaneABits = Grey ? ABits + 1 : ABits
) (
  input  wire logic                     clk_i,
  input  wire logic                     rst_i,

  // Stage 0: a group to read only. It may coincide with a beat of a first row, which needs no read,
  // but with no other beat.
  input  wire logic                     drain_i,
  input  wire logic [GroupBits-1:0]     drain_group_i,
  // Stage 0: a beat to add up
  input  wire logic                     add_i,
  input  wire logic [GroupBits-1:0]     group_i,
  input  wire logic [Lanes*WeightBits-1:0]  weights_i,
  input  wire logic [RowBits-1:0]       row_i,
  input  wire logic                     first_row_i,   // the sums begin at zero
  input  wire logic                     one_group_i,   // the image has one group; with add_i
  input  wire logic                     two_groups_i,  // the image has two; with add_i
  input  wire logic                     grey_i,  // with add_i

  output logic [Lanes*LaneMBits-1:0]        raw_m_o,  // each lane {N, M0 in halves}, or M0
  output logic [Lanes*LaneABits-1:0]        raw_a_o,
  output logic [Lanes*LaneMBits-1:0]        sum_m_o,
  output logic [Lanes*LaneABits-1:0]        sum_a_o,
  // for one clock: the next sum_m_o is of stage 3
  output logic                          sum_m_comes_o,
  output logic                          sum_a_comes_o   // the next sum_a_o is of a beat in stage 4
);

  if (MaxRows < 2 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_2047 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end

  // Stage 1: the word of M is read, and the read of A begins
  logic                    s1_add_q, s1_drain_q, s1_first_q, s1_grey_q;
  logic                    s1_onto_new_q;   // add to the sum in the making, of one clock before
  logic                    s1_onto_last_q;  // add to the last sum made, of two clocks before
  logic [GroupBits-1:0]    s1_group_q, s1_drain_group_q;
  logic [Lanes*WeightBits-1:0] s1_weights_q;
  logic [RowBits-1:0]      s1_row_q;
  // Stage 2: M is summed and written
  logic                    s2_add_q, s2_first_q, s2_onto_new_q, s2_onto_last_q, s2_grey_q;
  logic [GroupBits-1:0]    s2_group_q;
  logic [RowBits-1:0]      s2_row_q;
  // Stage 3: A is summed and written
  logic                    s3_add_q;
  logic [GroupBits-1:0]    s3_group_q;
  logic [Lanes*LaneMBits-1:0]  sum_m;
  logic [Lanes*LaneABits-1:0]  sum_a;

  // Where the memory does not have the old sum yet, the stages have it. s1_onto_new_q: an image of
  // one group, with a beat one clock before. s1_onto_last_q: an image of one group, with a gap of
  // one clock before the beat; or an image of two groups without a gap, since the groups alternate.
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s1_add_q   <= 1'b0;
      s1_drain_q <= 1'b0;
      s2_add_q   <= 1'b0;
      s3_add_q   <= 1'b0;
    end else begin
      s1_add_q   <= add_i;
      s1_drain_q <= drain_i;
      s2_add_q   <= s1_add_q;
      s3_add_q   <= s2_add_q;
    end
  end
  assign sum_m_comes_o = s2_add_q;
  assign sum_a_comes_o = s3_add_q;

  always_ff @(posedge clk_i) begin
    s1_drain_group_q <= drain_group_i;
    s1_group_q       <= group_i;
    s1_first_q       <= first_row_i;
    s1_onto_new_q    <= one_group_i && s1_add_q;
    s1_onto_last_q   <= s2_add_q && (s1_add_q ? two_groups_i : one_group_i);
    s1_grey_q        <= grey_i;
    s1_weights_q     <= weights_i;
    s1_row_q         <= row_i;
    s2_group_q       <= s1_group_q;
    s2_first_q       <= s1_first_q;
    s2_onto_new_q    <= s1_onto_new_q;
    s2_onto_last_q   <= s1_onto_last_q;
    s2_grey_q        <= s1_grey_q;
    s2_row_q         <= s1_row_q;
    s3_group_q       <= s2_group_q;
  end

  for (genvar lane = 0; lane < Lanes; lane++) begin : gen_lane
    logic [LaneMBits-1:0] s2_old_m_q, next_m, sum_m_q;
    logic [LaneABits-1:0] s3_old_a_q, next_a, sum_a_q;

    always_ff @(posedge clk_i) begin
      s2_old_m_q <= s1_first_q ? '0 : s1_onto_new_q ? next_m : s1_onto_last_q ? sum_m_q :
                    raw_m_o[lane*LaneMBits+:LaneMBits];
      s3_old_a_q <= s2_first_q ? '0 : s2_onto_new_q ? next_a : s2_onto_last_q ? sum_a_q :
                    raw_a_o[lane*LaneABits+:LaneABits];
      sum_m_q    <= next_m;
      sum_a_q    <= next_a;
    end

    assign sum_m[lane*LaneMBits+:LaneMBits]   = next_m;
    assign sum_a[lane*LaneABits+:LaneABits]   = next_a;
    assign sum_m_o[lane*LaneMBits+:LaneMBits] = sum_m_q;
    assign sum_a_o[lane*LaneABits+:LaneABits] = sum_a_q;

    if (Grey) begin : gen_grey
      localparam int MLow = WeightBits;
      localparam int MHigh = M0Bits - MLow;
      localparam int ALow = (ABits + 1) / 2;
      localparam int AHigh = ABits - ALow;
      logic [WeightBits-1:0] s1_weight, s2_weight_q;
      logic                  s2_lit_q;
      logic [RowBits-1:0]    old_n, next_n;
      logic [MHigh-1:0]      old_m_high, next_m_high;
      logic [AHigh-1:0]      old_a_high, next_a_high, addend_high;
      logic [MLow-1:0]       old_m_low, next_m_low;
      logic [ALow-1:0]       old_a_low, next_a_low, addend_low;
      logic                  old_m_carry, old_a_carry, next_m_carry, next_a_carry;
      logic [M0Bits-1:0]     old_m0;
      logic                  unused_foot;

      assign s1_weight = s1_weights_q[lane*WeightBits+:WeightBits];
      assign {old_n, old_m_high, old_m_carry, old_m_low} = s2_old_m_q;
      assign {old_a_high, old_a_carry, old_a_low}        = s3_old_a_q;
      assign old_m0 = {old_m_high + MHigh'(old_m_carry), old_m_low};

      logic [ABits-1:0] s3_addend_q;
      assign {addend_high, addend_low} = s3_addend_q;
      always_ff @(posedge clk_i) begin
        s2_weight_q <= s1_weight;
        s2_lit_q    <= s1_weight != '0;  // a lit pixel weighs at least 1 in every mode
        s3_addend_q <= s2_grey_q ? ABits'(old_m0) : (s2_lit_q ? ABits'(s2_row_q) : {ABits{1'b0}});
      end

      assign next_n                     = old_n + RowBits'(s2_lit_q);
      assign next_m_high                = old_m_high + MHigh'(old_m_carry);
      assign {next_m_carry, next_m_low} = {1'b0, old_m_low} + {1'b0, s2_weight_q};
      // The carry goes in at the foot of the chain.
      assign {next_a_high, unused_foot} = {old_a_high, 1'b1} + {addend_high, old_a_carry};
      assign {next_a_carry, next_a_low} = {1'b0, old_a_low} + {1'b0, addend_low};
      assign next_m                     = {next_n, next_m_high, next_m_carry, next_m_low};
      assign next_a                     = {next_a_high, next_a_carry, next_a_low};
    end else begin : gen_binary
      logic             s2_lit_q;
      logic [ABits-1:0] s3_addend_q;
      assign next_m = s2_old_m_q + M0Bits'(s2_lit_q);
      assign next_a = s3_old_a_q + s3_addend_q;
      always_ff @(posedge clk_i) begin
        s2_lit_q    <= s1_weights_q[lane];
        s3_addend_q <= s2_lit_q ? ABits'(s2_row_q) : {ABits{1'b0}};
      end
      logic unused;
      assign unused = s2_grey_q;
    end
  end

  // A word holds two lanes. Reads and writes of one word meet in a clock only where the word read
  // is not used: in the first row, in images of one group, and in images of two groups without a
  // gap (s1_onto_last_q).
  for (genvar pair = 0; pair < Lanes / 2; pair++) begin : gen_pair
    sp_ram #(
      .Width   (2 * LaneMBits),
      .LogDepth(GroupBits)
    ) u_m (
      .wr_clk_i (clk_i),
      .wr_en_i  (s2_add_q),
      .wr_addr_i(s2_group_q),
      .wr_data_i(sum_m[pair*2*LaneMBits+:2*LaneMBits]),
      .rd_clk_i (clk_i),
      .rd_en_i  (add_i || drain_i),
      .rd_addr_i(drain_i ? drain_group_i : group_i),
      .rd_data_o(raw_m_o[pair*2*LaneMBits+:2*LaneMBits])
    );

    sp_ram #(
      .Width   (2 * LaneABits),
      .LogDepth(GroupBits)
    ) u_a (
      .wr_clk_i (clk_i),
      .wr_en_i  (s3_add_q),
      .wr_addr_i(s3_group_q),
      .wr_data_i(sum_a[pair*2*LaneABits+:2*LaneABits]),
      .rd_clk_i (clk_i),
      .rd_en_i  (s1_add_q || s1_drain_q),
      .rd_addr_i(s1_drain_q ? s1_drain_group_q : s1_group_q),
      .rd_data_o(raw_a_o[pair*2*LaneABits+:2*LaneABits])
    );
  end

endmodule

`default_nettype wire
