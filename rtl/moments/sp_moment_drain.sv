// Grey modes: completes the sums with the last row, half a group of columns per clock.
//
// The last row is not added to the sums. sp_drain_order says when a column group is drained. This
// module reads the sums of the earlier rows (drain_*), adds the last row and computes M1:
//
//   M0 = M0' + v,  N = N' + [v > 0],  M1 = R*M0 - (A + M0')
//                               (M0', N', A: after row R-1; v: the weight in the last row)
//
// M0' and A come in halves, as sp_moment_sums keeps them; this module joins them.
//
// Guarantees:
// * Words leave in column order. break_o comes after the last word where break_i ended the frame
//   early.
// * Between frames of equal settings, beats that are added one clock after they would be pushed
//   never meet a drain read: the second row of the next frame begins one clock after the last drain
//   read. After a change of settings, active_o keeps others from reading; it falls with the last
//   drain read.
// * Nothing overflows. M1 fits (sp_spec_pkg).
// * Latency: the first half of a group leaves ten clocks after its drain read, the other half one
//   clock later.
//
// Two groups of four columns:
//
//   clock        0   1   2   3   4   5   6  ... 11  12  13  14  15  16
//   push_i      _/A\_/B\____________________ ... ________________________   push_end_i with B
//   drain_o     _________/A\_____/B\_________ ... ________________________
//   active_o    _____/11111111111\___________ ... ________________________
//   raw_m_i     -------------< A >---< B >--- ... ------------------------
//   raw_a_i     -----------------< A >---< B  ... ------------------------
//   valid_o     ____________________________ ... ____/A01/A23/B01/B23\____
`default_nettype none

module sp_moment_drain #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int GroupBits = 9,  // 1..24
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int M0Bits = $clog2((2 ** PixelBits - 1) * MaxRows + 1),
  parameter int ABits = $clog2((2 ** PixelBits - 1) * (MaxRows * (MaxRows + 1) / 2) + 1),
  parameter int LaneMBits = M0Bits + 1 + RowBits,
  parameter int LaneABits = ABits + 1
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Last row of a frame whose packet was accepted
  input  wire logic                   push_i,
  input  wire logic                   push_end_i,  // the last group of the row
  input  wire logic [GroupBits-1:0]   push_group_i,
  input  wire logic [Lanes*PixelBits-1:0] push_weights_i,
  input  wire logic [RowBits-1:0]     push_row_i,
  input  wire logic                   push_first_row_i,
  input  wire logic                   push_one_group_i,
  // the frame ends here, after push_i of the same clock
  input  wire logic                   break_i,

  // Reads of the sums, in halves: the address now, M one clock later, A two clocks later
  output logic                        drain_o,
  output logic [GroupBits-1:0]        drain_group_o,
  output logic                        active_o,
  input  wire logic [Lanes*LaneMBits-1:0] raw_m_i,
  input  wire logic [Lanes*LaneABits-1:0] raw_a_i,
  input  wire logic [Lanes*LaneMBits-1:0] sum_m_i,
  input  wire logic [Lanes*LaneABits-1:0] sum_a_i,
  // sum_m_i will be of the beat two clocks before the read
  input  wire logic                   sum_m_comes_i,
  input  wire logic                   sum_a_comes_i,

  output logic                        valid_o,
  output logic [32*Lanes-1:0]         data_o,  // 0 where not valid
  output logic                        break_o
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

  localparam int Half = Lanes / 2;  // columns that leave per clock
  // the words have more bits for the moments
  localparam bit Wide = PixelBits > 8 || MaxRows > sp_spec_pkg::MaxRows;
  localparam int Latency = 8;  // from stage 2 to stage 10, where the words are complete
  localparam int MLow = PixelBits;
  localparam int MHigh = M0Bits - MLow;
  localparam int ALow = (ABits + 1) / 2;
  localparam int AHigh = ABits - ALow;

  logic                 s1_read_q;      // there was a drain read one clock ago
  logic [RowBits-1:0]   row_number_q;   // number of the last row: R
  logic                 first_row_q;    // the last row is also the first: there are no earlier sums
  logic                 one_group_q;    // the image has one group
  logic [Lanes*PixelBits-1:0] raw_weights;  // weights of the last row, from the line buffer
  logic                 s0_break;       // the break in the stages, behind the last word

  sp_drain_order #(
    .GroupBits(GroupBits),
    .Width    (Lanes * PixelBits)
  ) u_order (
    .clk_i         (clk_i),
    .rst_i         (rst_i),
    .push_i        (push_i),
    .push_end_i    (push_end_i),
    .push_group_i  (push_group_i),
    .push_weights_i(push_weights_i),
    .break_i       (break_i),
    .drain_o       (drain_o),
    .drain_group_o (drain_group_o),
    .weights_o     (raw_weights),
    .active_o      (active_o),
    .break_o       (s0_break)
  );

  always_ff @(posedge clk_i) begin
    s1_read_q <= !rst_i && drain_o;
    if (push_i) begin
      row_number_q <= push_row_i;
      first_row_q  <= push_first_row_i;
      one_group_q  <= push_one_group_i;
    end
  end

  // Stage 1: the M words and the weights are here.
  // Stage 2: they are kept for the two clocks of their group; the A words are here.
  // Stage 3: the first half of the group, with A kept; one clock later the other half.
  // the stage holds the first half of a group
  logic                   s2_first_q, s3_first_q;
  // the memories do not have these sums yet: take sum_m_i, sum_a_i
  logic                   s1_from_sum_q, s2_from_sum_q;
  logic                   s2_valid_q;      // the stage holds half a group
  logic [Lanes*LaneMBits-1:0] s2_m_q;
  logic [Lanes*LaneABits-1:0] s3_a_q;
  logic [Lanes*PixelBits-1:0] s2_weights_q;
  logic                   s1_break_q, s2_break_q;

  logic [Latency-1:0]     valid_q;  // from stage 3 on
  logic [Latency-1:0]     break_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s2_first_q <= 1'b0;
      s2_valid_q <= 1'b0;
      s1_break_q <= 1'b0;
      s2_break_q <= 1'b0;
      valid_q    <= '0;
      break_q    <= '0;
    end else begin
      s2_first_q <= s1_read_q;
      s2_valid_q <= s1_read_q || s2_first_q;  // two clocks, half a group each
      s1_break_q <= s0_break;
      s2_break_q <= s1_break_q;
      valid_q    <= {valid_q[Latency-2:0], s2_valid_q};
      break_q    <= {break_q[Latency-2:0], s2_break_q};
    end
  end

  // The stages from 2 on move together or not at all. A synthesizer sees one enable.
  logic moving_q;
  logic s9_empty_q;  // stage 9 holds no columns: !valid_q[6]
  always_ff @(posedge clk_i) s9_empty_q <= rst_i || !valid_q[5];
  always_ff @(posedge clk_i) moving_q <= drain_o || s1_read_q || s2_valid_q ||
                                         valid_q[Latency-3:0] != '0;

  always_ff @(posedge clk_i) begin
    s3_first_q    <= s2_first_q;
    s1_from_sum_q <= one_group_q && sum_m_comes_i;
    s2_from_sum_q <= one_group_q && sum_a_comes_i;
    if (s1_read_q) begin
      s2_m_q       <= first_row_q ? '0 : s1_from_sum_q ? sum_m_i : raw_m_i;
      s2_weights_q <= raw_weights;
    end
    if (s2_first_q) s3_a_q <= first_row_q ? '0 : s2_from_sum_q ? sum_a_i : raw_a_i;
  end

  for (genvar c = 0; c < Half; c++) begin : gen_column
    // Stage 3: one of these columns
    logic [PixelBits-1:0] s3_weight_q;
    logic [RowBits-1:0]   s3_n_q;
    logic [MHigh-1:0]     s3_m_high_q;
    logic [MLow-1:0]      s3_m_low_q;
    logic                 s3_m_carry_q;
    always_ff @(posedge clk_i) if (moving_q) begin
      {s3_n_q, s3_m_high_q, s3_m_carry_q, s3_m_low_q} <=
          s2_first_q ? s2_m_q[c*LaneMBits+:LaneMBits] : s2_m_q[(c+Half)*LaneMBits+:LaneMBits];
      s3_weight_q <= s2_first_q ? s2_weights_q[c*PixelBits+:PixelBits] :
                                  s2_weights_q[(c+Half)*PixelBits+:PixelBits];
    end

    // Stage 4: M0' in one piece; the low half of M0; N; A of the column
    logic [MHigh-1:0]     s4_m_high_q;
    logic [MLow-1:0]      s4_old_low_q, s4_m_low_q;
    logic                 s4_m_carry_q, s4_lit_q;
    logic [RowBits-1:0]   s4_n_q;
    logic [AHigh-1:0]     s4_a_high_q;
    logic [ALow-1:0]      s4_a_low_q;
    logic                 s4_a_carry_q;
    always_ff @(posedge clk_i) if (moving_q) begin
      s4_m_high_q                             <= s3_m_high_q + MHigh'(s3_m_carry_q);
      s4_old_low_q                            <= s3_m_low_q;
      {s4_m_carry_q, s4_m_low_q}              <= {1'b0, s3_m_low_q} + {1'b0, s3_weight_q};
      s4_lit_q                                <= s3_weight_q != '0;
      s4_n_q                                  <= s3_n_q;
      {s4_a_high_q, s4_a_carry_q, s4_a_low_q} <= s3_first_q ? s3_a_q[c*LaneABits+:LaneABits] :
                                                 s3_a_q[(c+Half)*LaneABits+:LaneABits];
    end

    // Stage 5: M0, and the excess of R*M0 over M1, in halves
    logic [M0Bits-1:0]    s5_m0_q;
    logic [RowBits-1:0]   s5_n_q;
    logic [AHigh-1:0]     s5_excess_high_q, old_high;
    logic [ALow-1:0]      s5_excess_low_q, old_low;
    logic                 s5_excess_carry_q, s5_unused_foot_q;
    assign {old_high, old_low} = ABits'({s4_m_high_q, s4_old_low_q});
    always_ff @(posedge clk_i) if (moving_q) begin
      s5_m0_q <= {s4_m_high_q + MHigh'(s4_m_carry_q), s4_m_low_q};
      s5_n_q  <= s4_n_q + RowBits'(s4_lit_q);
      // The carry goes in at the foot of the chain.
      {s5_excess_high_q, s5_unused_foot_q} <= {s4_a_high_q, 1'b1} + {old_high, s4_a_carry_q};
      {s5_excess_carry_q, s5_excess_low_q} <= {1'b0, s4_a_low_q} + {1'b0, old_low};
    end

    // Stages 6 to 9: R*M0, with the rest beside it. R*M0 can have one bit more than M1 needs; that
    // bit drops out of the difference.
    logic [M0Bits+RowBits-1:0] product9;
    logic                      unused_product;
    assign unused_product = ^product9;
    sp_scale #(
      .XBits(M0Bits),
      .KBits(RowBits)
    ) u_scale (
      .clk_i    (clk_i),
      .move_i   (moving_q),
      .x_i      (s5_m0_q),
      .k_i      (row_number_q),
      .product_o(product9)
    );

    logic [M0Bits-1:0]  s6_m0_q, s7_m0_q, s8_m0_q, s9_m0_q, s10_m0_q;
    logic [RowBits-1:0] s6_n_q, s7_n_q, s8_n_q, s9_n_q, s10_n_q;
    logic [ABits-1:0]   s6_excess_q, s7_excess_q, s8_excess_q, s9_not_excess_q, s10_m1_q;
    logic               s10_unused_foot_q;
    always_ff @(posedge clk_i) begin
      if (moving_q) begin
        {s6_m0_q, s6_n_q}                  <= {s5_m0_q, s5_n_q};
        s6_excess_q                        <=
            {s5_excess_high_q + AHigh'(s5_excess_carry_q), s5_excess_low_q};
        {s7_m0_q, s7_n_q, s7_excess_q}     <= {s6_m0_q, s6_n_q, s6_excess_q};
        {s8_m0_q, s8_n_q, s8_excess_q}     <= {s7_m0_q, s7_n_q, s7_excess_q};
        {s9_m0_q, s9_n_q, s9_not_excess_q} <= {s8_m0_q, s8_n_q, ~s8_excess_q};
      end
      // The difference fits: it is M1.
      if (s9_empty_q) {s10_m0_q, s10_n_q, s10_m1_q, s10_unused_foot_q} <= '0;
      else {s10_m0_q, s10_n_q, s10_m1_q, s10_unused_foot_q} <=
          {s9_m0_q, s9_n_q, {product9[ABits-1:0], 1'b1} + {s9_not_excess_q, 1'b1}};
    end
    // Stage 10: the word
    logic [63:0] word;
    assign word = 64'(s10_m1_q) << sp_spec_pkg::GreyM1Lsb |
                  64'(s10_m0_q) << (Wide ? sp_spec_pkg::WideGreyM0Lsb : sp_spec_pkg::GreyM0Lsb) |
                  64'(s10_n_q) << (Wide ? sp_spec_pkg::WideGreyNLsb : sp_spec_pkg::GreyNLsb);
    assign data_o[64*c+:64] = word;
  end

  // s2_valid_q belongs to stage 2 of the first half; the words are in stage 10.
  assign valid_o = valid_q[Latency-1];
  assign break_o = break_q[Latency-1];

`ifdef FORMAL
  // Assumptions: one reset at the beginning. The groups of a row come in order, with any gaps. A
  // row ends with push_end_i or, if the frame breaks, with break_i. The next row begins when the
  // row before it is out: sp_packetizer refuses a row that comes sooner.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  logic               f_open_q;    // a row has begun and may go on
  logic               f_broke_q;   // it ended by a break
  logic               f_told_q;    // break_o has told so
  logic [GroupBits:0] f_pushed_q, f_pushed1_q;  // groups of the row; one clock ago
  logic [GroupBits:0] f_reads_q;   // groups that were read
  logic [GroupBits+1:0] f_words_q; // words that left
  logic               f_out;       // all words of the row have left, and its break
  assign f_out = !f_open_q && f_words_q == {f_pushed_q, 1'b0} && f_told_q == f_broke_q;
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (push_i && !rst_i) begin
      assume (f_open_q || f_out);
      assume (push_group_i == (f_open_q ? f_pushed_q[GroupBits-1:0] : '0));
      if (f_open_q) assume (!f_pushed_q[GroupBits]);
    end
    if (break_i && !rst_i) assume ((f_open_q || push_i) && !(push_i && push_end_i));
  end
  always_ff @(posedge clk_i) begin
    f_pushed1_q <= f_pushed_q;
    if (rst_i) {f_open_q, f_broke_q, f_told_q, f_pushed_q, f_pushed1_q, f_reads_q, f_words_q} <= '0;
    else begin
      if (push_i) f_open_q <= !push_end_i;
      if (break_i) f_open_q <= 1'b0;
      f_words_q <= f_words_q + (GroupBits + 2)'(valid_o);
      f_reads_q <= f_reads_q + (GroupBits + 1)'(drain_o);
      if (break_i) f_broke_q <= 1'b1;
      if (break_o) f_told_q <= 1'b1;
      if (push_i) f_pushed_q <= f_pushed_q + (GroupBits + 1)'(1);
      if (push_i && !f_open_q) begin
        {f_words_q, f_reads_q, f_told_q} <= '0;
        f_broke_q  <= break_i;
        f_pushed_q <= (GroupBits + 1)'(1);
      end
    end
  end

  logic [11:1] f_read_q;   // drain_o, so many clocks ago
  logic [4:0]  f_quiet_q;  // clocks without a push, a read, a word or a break
  always_ff @(posedge clk_i) begin
    f_read_q <= rst_i ? '0 : {f_read_q[10:1], drain_o};
    if (rst_i || push_i || break_i || drain_o || valid_o || break_o) f_quiet_q <= '0;
    else if (f_quiet_q != '1) f_quiet_q <= f_quiet_q + 5'd1;
  end

  always_comb if (f_ran_q) begin
    // Rule 1: groups are read in order, each one two clocks after its push or later, never two in
    // neighbouring clocks; active_o is high but for the last read.
    if (drain_o) begin
      assert (drain_group_o == f_reads_q[GroupBits-1:0] && f_reads_q < f_pushed1_q);
      assert (!f_read_q[1]);
      assert (active_o || !f_open_q && f_reads_q + (GroupBits + 1)'(1) == f_pushed_q);
    end
    // Rule 2: the words of a group leave ten and eleven clocks after its read.
    assert (valid_o == (f_read_q[10] || f_read_q[11]));
    // Rule 3: a break is told once, after the last word, and only if the row ended by one.
    if (break_o) begin
      assert (f_broke_q && !f_told_q && !valid_o && f_words_q == {f_pushed_q, 1'b0});
    end
    // Rule 4: nothing stays behind.
    if (f_quiet_q >= 5'd16 && !f_open_q) assert (f_out && !active_o);
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (break_o && f_pushed_q == (GroupBits + 1)'(2));
    cover (f_out && f_pushed_q == (GroupBits + 1)'(2) && !f_broke_q);
  end
`endif

endmodule

`default_nettype wire
