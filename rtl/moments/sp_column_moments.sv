// Column moments M0, M1 and N of a stream of frames, 4, 8 or 16 pixels in every clock.
//
//   M0(c) = sum over rows of w,   M1(c) = sum over rows of row*w,   N(c) = lit pixels   (3.1, 3.2)
//
// A pixel is lit where it is greater than the threshold. A lit pixel weighs w = 1 (binary), its
// value (grey) or its value minus the threshold (grey_over). Rows count from 1. No sum wraps: all
// widths follow from MaxRows and PixelBits. The last row of a frame completes the sums, so they
// leave while that row passes. There is no second bank of sums and no pass that clears them.
//
// Input: beats with their position, as sp_frame_tracker gives them. accept_i says, four clocks
// after each beat of a last row, whether the moments of this beat are wanted. break_i ends a frame
// early, within its last row, one clock after the last beat that counts or later; the columns that
// were complete still leave, followed by moments_break_o.
//
// Output: the payload of the packet format, 4 Lanes bytes at once, without back-pressure. In mode
// binary this is a group of columns, and leaves 8 clocks after its pixels (10 in a grey build). In
// the grey modes it is half a group, as words wide_grey if pixels have more than 8 bits or MaxRows
// is above 1,023, where mode binary has words tall_binary; the first leaves after 16 clocks, the
// last of G groups G + 16 clocks after its pixels.
//
// spoiled_o: a frame of three or more rows came while a larger frame before it was still draining,
// which only a change of size in a grey build can cause. Its sums are void; its packet counts as
// lost.
`default_nettype none

module sp_column_moments #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // image width: a multiple of 4, 8..4096; with more lanes of Lanes, from 2 Lanes on
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // image height: 2..2047
  parameter bit Grey = 1'b1,  // modes grey and grey_over
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / Lanes),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                 clk_i,             // pixel clock
  input  wire logic                 rst_i,             // active high, synchronous

  input  wire logic                 beat_valid_i,  // a beat of Lanes pixels
  input  wire logic [Lanes*PixelBits-1:0] beat_pixels_i,   // leftmost pixel lowest
  input  wire logic [GroupBits-1:0] beat_group_i,      // group of Lanes columns, from 0
  input  wire logic [RowBits-1:0]   beat_row_i,        // row, from 1
  input  wire logic                 beat_first_row_i,  // the row is the first of the frame
  input  wire logic                 beat_last_row_i,   // the row is the last of the frame
  input  wire logic                 beat_line_end_i,   // the group is the last of its line
  input  wire logic [PixelBits-1:0] threshold_i,  // a pixel of this beat is lit where it is greater
  input  wire logic                 break_i,           // the frame ends early, in its last row
  input  wire logic                 accept_i,          // the beat of four clocks ago is wanted

  // The same with every beat of a frame
  input  wire logic                 one_group_i,  // the frame has one group
  input  wire logic                 two_groups_i,  // the frame has two groups
  input  wire logic [1:0]           mode_i,  // 0 binary, 1 grey, 2 grey_over

  // Payload of the packet
  output logic                      moments_valid_o,   // a payload beat
  output logic [32*Lanes-1:0]       moments_data_o,  // a group or half of it, leftmost lowest
  output logic                      moments_break_o,  // no further payload beat of this frame comes
  output logic                      spoiled_o          // the sums of the frame are void: see above
);

  if (MaxColumns < 2 * Lanes || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % Lanes != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes_in_2_lanes_to_4096 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end

  localparam int WeightBits = Grey ? PixelBits : 1;
  localparam int MaxWeight = 2 ** WeightBits - 1;
  localparam int M0Bits = $clog2(MaxWeight * MaxRows + 1);
  localparam int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1);
  localparam int LaneMBits = Grey ? M0Bits + 1 + RowBits : M0Bits;
  localparam int LaneABits = Grey ? ABits + 1 : ABits;
  localparam int M1Bits = $clog2(MaxRows * (MaxRows + 1) / 2 + 1);  // in mode binary

  // --- Stages 1 to 4: weights; the rest waits for the decision of the packetizer ---
  logic [4:1]              valid_q;
  logic [3:1]              break_q;
  logic [GroupBits-1:0]    s1_group_q, s2_group_q, s3_group_q, s4_group_q;
  logic [RowBits-1:0]      s1_row_q, s2_row_q, s3_row_q, s4_row_q;
  logic [5:0]              s1_flags_q, s2_flags_q, s3_flags_q, s4_flags_q;
  logic [Lanes*WeightBits-1:0] s3_weights, s4_weights_q;
  logic                    s4_first_row, s4_last_row, s4_line_end, s4_one, s4_two, s4_grey;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      break_q <= '0;
    end else begin
      valid_q <= {valid_q[3:1], beat_valid_i};
      break_q <= {break_q[2:1], break_i};
    end
  end

  always_ff @(posedge clk_i) begin
    s1_group_q <= beat_group_i;
    s1_row_q   <= beat_row_i;
    s1_flags_q <= {beat_first_row_i, beat_last_row_i, beat_line_end_i, one_group_i, two_groups_i,
                   Grey && mode_i != sp_spec_pkg::ModeBinary};
    {s2_group_q, s2_row_q, s2_flags_q} <= {s1_group_q, s1_row_q, s1_flags_q};
    {s3_group_q, s3_row_q, s3_flags_q} <= {s2_group_q, s2_row_q, s2_flags_q};
    {s4_group_q, s4_row_q, s4_flags_q} <= {s3_group_q, s3_row_q, s3_flags_q};
    s4_weights_q <= s3_weights;
  end

  assign {s4_first_row, s4_last_row, s4_line_end, s4_one, s4_two, s4_grey} = s4_flags_q;

  sp_pixel_weights #(
    .Grey     (Grey),
    .PixelBits(PixelBits),
    .Lanes    (Lanes)
  ) u_weights (
    .clk_i        (clk_i),
    .rst_i        (rst_i),
    .beat_pixels_i(beat_pixels_i),
    .mode_i       (mode_i),
    .threshold_i  (threshold_i),
    .weights_o    (s3_weights)
  );

  // --- Stage 4: which beats are added up. Only mode binary adds up the last row. ---
  logic                   s4_drain_row;  // a last row that goes to the drain
  logic                   s4_add;
  logic                   drain;
  logic [GroupBits-1:0]   drain_group;
  logic                   draining;
  logic [Lanes*LaneMBits-1:0] raw_m, sum_m;
  logic [Lanes*LaneABits-1:0] raw_a, sum_a;
  logic                   sum_m_comes, sum_a_comes;

  assign s4_drain_row = s4_last_row && s4_grey;
  // A first row needs no read, so it may pass a drain. Another row meets a drain only after a
  // change of size: see spoiled_o.
  assign s4_add       = valid_q[4] && !s4_drain_row && (s4_first_row || !draining);

  // --- Stage 5, only in a grey build: the sums run one clock behind the drain. ---
  logic                    add, add_first_row, add_one, add_two, add_grey;
  logic [GroupBits-1:0]    add_group;
  logic [RowBits-1:0]      add_row;
  logic [Lanes*WeightBits-1:0] add_weights;
  if (Grey) begin : gen_stage5
    logic                    s5_add_q, s5_first_row_q, s5_one_q, s5_two_q, s5_grey_q;
    logic [GroupBits-1:0]    s5_group_q;
    logic [RowBits-1:0]      s5_row_q;
    logic [Lanes*WeightBits-1:0] s5_weights_q;
    always_ff @(posedge clk_i) begin
      if (rst_i) s5_add_q <= 1'b0;
      else s5_add_q <= s4_add;
    end
    always_ff @(posedge clk_i) begin
      {s5_first_row_q, s5_one_q, s5_two_q, s5_grey_q} <= {s4_first_row, s4_one, s4_two, s4_grey};
      {s5_group_q, s5_row_q, s5_weights_q}            <= {s4_group_q, s4_row_q, s4_weights_q};
    end
    assign {add, add_first_row, add_one, add_two, add_grey} =
        {s5_add_q, s5_first_row_q, s5_one_q, s5_two_q, s5_grey_q};
    assign {add_group, add_row, add_weights}                = {s5_group_q, s5_row_q, s5_weights_q};
  end else begin : gen_no_stage5
    assign {add, add_first_row, add_one, add_two, add_grey} =
        {s4_add, s4_first_row, s4_one, s4_two, s4_grey};
    assign {add_group, add_row, add_weights}                = {s4_group_q, s4_row_q, s4_weights_q};
  end

  sp_moment_sums #(
    .MaxRows  (MaxRows),
    .GroupBits(GroupBits),
    .Grey     (Grey),
    .PixelBits(PixelBits),
    .Lanes    (Lanes)
  ) u_sums (
    .clk_i        (clk_i),
    .rst_i        (rst_i),
    .drain_i      (drain),
    .drain_group_i(drain_group),
    .add_i        (add),
    .group_i      (add_group),
    .weights_i    (add_weights),
    .row_i        (add_row),
    .first_row_i  (add_first_row),
    .one_group_i  (add_one),
    .two_groups_i (add_two),
    .grey_i       (add_grey),
    .raw_m_o      (raw_m),
    .raw_a_o      (raw_a),
    .sum_m_o      (sum_m),
    .sum_a_o      (sum_a),
    .sum_m_comes_o (sum_m_comes),
    .sum_a_comes_o (sum_a_comes)
  );

  // --- Mode binary: the sums of the last row leave as they come; a grey build joins halves first.
  // ---
  localparam int DirectEnd = Grey ? 10 : 8;
  localparam int SumA = Grey ? 9 : 8;  // the stage that sum_a belongs to; sum_m is one ahead
  logic [DirectEnd:5]   direct_q;
  logic [DirectEnd:5]   direct_break_q;
  logic [Lanes*RowBits-1:0] m0_q;          // of stage SumA
  logic                 break_drains;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      direct_q       <= '0;
      direct_break_q <= '0;
    end else begin
      direct_q       <=
          {direct_q[DirectEnd-1:5], valid_q[4] && s4_last_row && !s4_grey && accept_i};
      direct_break_q <= {direct_break_q[DirectEnd-1:5], break_q[3] && accept_i && !break_drains};
    end
  end

  logic         no_direct_q;  // !direct_q[SumA]
  logic [32*Lanes-1:0] direct_data;
  always_ff @(posedge clk_i) no_direct_q <= rst_i || !direct_q[SumA-1];
  for (genvar lane = 0; lane < Lanes; lane++) begin : gen_word
    logic [RowBits-1:0] m0;
    logic [M1Bits-1:0]  m1;
    logic [31:0]        word;
    if (Grey) begin : gen_halves
      localparam int MLow = WeightBits;
      localparam int MHigh = M0Bits - MLow;
      localparam int ALow = (ABits + 1) / 2;
      localparam int AHigh = ABits - ALow;
      logic [RowBits-1:0] unused_n, m0_10_q;
      logic [MHigh-1:0]   m_high;
      logic [MLow-1:0]    m_low;
      logic [AHigh-1:0]   a_high;
      logic [ALow-1:0]    a_low;
      logic               m_carry, a_carry;
      logic [M1Bits-1:0]  m1_10_q;
      assign {unused_n, m_high, m_carry, m_low} = sum_m[lane*LaneMBits+:LaneMBits];
      assign {a_high, a_carry, a_low}           = sum_a[lane*LaneABits+:LaneABits];
      always_ff @(posedge clk_i) begin
        if (direct_q[SumA-1]) m0_q[lane*RowBits+:RowBits] <=
            RowBits'({m_high + MHigh'(m_carry), m_low});
        if (no_direct_q) {m0_10_q, m1_10_q} <= '0;
        else {m0_10_q, m1_10_q} <=
            {m0_q[lane*RowBits+:RowBits], M1Bits'({a_high + AHigh'(a_carry), a_low})};
      end
      assign {m0, m1} = {m0_10_q, m1_10_q};
    end else begin : gen_whole
      always_ff @(posedge clk_i) if (direct_q[SumA-1]) m0_q[lane*RowBits+:RowBits] <=
          sum_m[lane*LaneMBits+:RowBits];
      assign {m0, m1} = {m0_q[lane*RowBits+:RowBits], sum_a[lane*LaneABits+:M1Bits]};
    end
    assign word = 32'(m1) << sp_spec_pkg::BinaryM1Lsb |
                  32'(m0) << (MaxRows > sp_spec_pkg::MaxRows ? sp_spec_pkg::TallBinaryM0Lsb :
                                                               sp_spec_pkg::BinaryM0Lsb);
    assign direct_data[32*lane+:32] = word;
  end

  // --- Grey modes: the drain ---
  if (Grey) begin : gen_grey
    logic         drain_grey_q;  // this last row, or the one before, goes to the drain
    logic         drain_valid;
    logic [32*Lanes-1:0] drain_data;
    logic         drain_break;

    always_ff @(posedge clk_i) begin
      if (rst_i) drain_grey_q <= 1'b0;
      else if (valid_q[4] && s4_last_row) drain_grey_q <= s4_grey;
    end
    assign break_drains = valid_q[4] && s4_last_row ? s4_grey : drain_grey_q;

    sp_moment_drain #(
      .MaxRows  (MaxRows),
      .GroupBits(GroupBits),
      .PixelBits(PixelBits),
      .Lanes    (Lanes)
    ) u_drain (
      .clk_i           (clk_i),
      .rst_i           (rst_i),
      .push_i          (valid_q[4] && s4_drain_row && accept_i),
      .push_end_i      (s4_line_end),
      .push_group_i    (s4_group_q),
      .push_weights_i  (s4_weights_q),
      .push_row_i      (s4_row_q),
      .push_first_row_i(s4_first_row),
      .push_one_group_i(s4_one),
      .break_i         (break_q[3] && accept_i && break_drains),
      .drain_o         (drain),
      .drain_group_o   (drain_group),
      .active_o        (draining),
      .raw_m_i         (raw_m),
      .raw_a_i         (raw_a),
      .sum_m_i         (sum_m),
      .sum_a_i         (sum_a),
      .sum_m_comes_i    (sum_m_comes),
      .sum_a_comes_i    (sum_a_comes),
      .valid_o         (drain_valid),
      .data_o          (drain_data),
      .break_o         (drain_break)
    );

    // A frame is spoiled from its first lost beat until the first row of the next frame.
    always_ff @(posedge clk_i) begin
      if (rst_i) spoiled_o <= 1'b0;
      else if (valid_q[4] && s4_first_row) spoiled_o <= 1'b0;
      else if (valid_q[4] && !s4_drain_row && draining) spoiled_o <= 1'b1;
    end

    // A source that is not valid is 0.
    assign moments_valid_o = direct_q[DirectEnd] || drain_valid;
    assign moments_data_o  = direct_data | drain_data;
    assign moments_break_o = direct_break_q[DirectEnd] || drain_break;
  end else begin : gen_binary
    assign drain           = 1'b0;
    assign drain_group     = '0;
    assign draining        = 1'b0;
    assign break_drains    = 1'b0;
    assign spoiled_o       = 1'b0;
    assign moments_valid_o = direct_q[DirectEnd];
    assign moments_data_o  = direct_data;
    assign moments_break_o = direct_break_q[DirectEnd];
    logic unused;
    assign unused = ^{s4_line_end, no_direct_q, raw_m, raw_a, sum_m_comes, sum_a_comes};
  end

`ifdef FORMAL
  localparam int FWait = 7, FChangeWait = 15;
  localparam bit FBinaryDrains = 1'b0;
`include "sp_formal_frames.svh"

  always_comb begin
    assume (one_group_i == (f_last_group == '0) && two_groups_i == (f_last_group == GroupBits'(1)));
  end

  // The sums of the column (3.1, 3.2), written out from the beats as they come in.
  logic [FSumBits-1:0] f_m0_q, f_m1_q, f_n_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_m0_q, f_m1_q, f_n_q} <= '0;
    else if (f_mine) {f_m0_q, f_m1_q, f_n_q} <=
        {f_m0_q + f_weight, f_m1_q + f_row_weight, f_n_q + FSumBits'(f_lit)};
  end

  // Rule: the word of every column holds its sums, in the format of the packet.
  always_comb if (f_run) begin
    if (f_here) begin
      if (f_grey) begin
        if (PixelBits > 8) begin
          assert (f_word[30:0] == 31'(f_m1_q) && f_word[52:31] == 22'(f_m0_q) &&
                  f_word[63:53] == f_n_q[10:0]);
        end else begin
          assert (f_word[26:0] == 27'(f_m1_q) && f_word[44:27] == 18'(f_m0_q) &&
                  f_word[54:45] == f_n_q[9:0]);
        end
      end else begin
        assert (f_word[19:0] == 20'(f_m1_q) && f_word[31:20] == f_m0_q[11:0]);
      end
    end
    cover (f_here && f_m1_q != '0 && f_rows == RowBits'(MaxRows) && f_last_group == GroupBits'(1));
    // a frame of another mode just before
    if (Changes) begin
      cover (f_here && f_grey && f_other_mode == sp_spec_pkg::ModeBinary && f_frame == 5'd1);
    end
    // one not wanted
    if (Grey && !Changes) begin
      cover (f_here && f_grey && f_m1_q != '0 && f_before_q == 6'd1 && f_frame == 5'd2);
    end
  end
`endif

endmodule

`default_nettype wire
