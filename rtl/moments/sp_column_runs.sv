// The strongest run of every column of a stream of frames, 4, 8 or 16 pixels in every clock; the moments
// of all lit pixels where select is `all`.
//
// A run is a sequence of lit rows with at most gap_i dark rows between two of them. The strongest
// run has the largest M0, of equals the one with the smaller rows. Weights, rows, M0, M1 and N are
// those of sp_column_moments. The words also tell how many runs there are, up to 3, and how strong
// the second one is; both are 0 where select is `all`, and the words those of sp_column_moments.
// With pixels of more than 8 bits, or MaxRows above 1,023, words of the grey modes are wide_grey_run
// or wide_grey, and the former tell no number of runs; tall_binary, which mode binary has with so
// many rows, tells of one run only.
//
// Input, accept_i, break_i and spoiled_o are those of sp_column_moments. Latency: in a binary build
// a group of columns leaves 12 clocks after its pixels. In a grey build half a group is completed
// per clock, in every mode. The first words leave 19 clocks after their pixels, the last of G groups
// G + 19 clocks after its pixels; in mode binary, where a whole group leaves at once, the first
// after 20.
//
// Distance: no gap is needed between frames. In a grey build the last row takes 2 G clocks to
// leave, in mode binary too. sp_packetizer counts a packet that comes sooner as lost.
`default_nettype none

module sp_column_runs #(
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
  input  wire logic [1:0]           mode_i,  // 0 binary, 1 grey, 2 grey_over
  input  wire logic                 strongest_i,  // select: 1 strongest, 0 all
  input  wire logic [1:0]           gap_i,  // dark rows that a run may have inside

  // Payload of the packet
  output logic                      moments_valid_o,   // a payload beat
  output logic [32*Lanes-1:0]       moments_data_o,    // a group or half of it, leftmost lowest
  output logic                      moments_break_o,   // no more payload of this frame comes
  output logic                      spoiled_o          // the sums of the frame are void
);

  if (MaxColumns < 2 * Lanes || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % Lanes != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes_in_2_lanes_to_4096 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  localparam int WeightBits = Grey ? PixelBits : 1;
  localparam int MaxWeight = 2 ** WeightBits - 1;
  localparam int M0Bits = $clog2(MaxWeight * MaxRows + 1);
  localparam int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1);
  localparam int BestBits = 2 + 2 * M0Bits + ABits + (Grey ? 2 * RowBits : 0);

  // --- Stages 1 to 4: weights; the rest waits for the decision of the packetizer ---
  localparam int FlagBits = 7;
  logic [4:1]                valid_q;
  logic [3:1]                break_q;
  logic [4*GroupBits-1:0]    group_q;   // of stages 1 to 4, stage 1 lowest
  logic [4*RowBits-1:0]      row_q;     // likewise
  logic [4*FlagBits-1:0]     flags_q;   // likewise
  logic [Lanes*WeightBits-1:0]   s3_weights, s4_weights_q;
  logic [GroupBits-1:0]      s4_group;
  logic [RowBits-1:0]        s4_row;
  logic                      s4_first_row, s4_last_row, s4_line_end, s4_grey, s4_strongest;
  logic [1:0]                s4_gap;

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
    group_q <= {group_q[3*GroupBits-1:0], beat_group_i};
    row_q   <= {row_q[3*RowBits-1:0], beat_row_i};
    flags_q <= {flags_q[3*FlagBits-1:0], beat_first_row_i, beat_last_row_i, beat_line_end_i,
                Grey && mode_i != sp_spec_pkg::ModeBinary, strongest_i, gap_i};
    s4_weights_q <= s3_weights;
  end
  assign s4_group = group_q[3*GroupBits+:GroupBits];
  assign s4_row   = row_q[3*RowBits+:RowBits];
  assign {s4_first_row, s4_last_row, s4_line_end, s4_grey, s4_strongest, s4_gap} =
      flags_q[3*FlagBits+:FlagBits];

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

  // --- Every row but the last is added up, the last row goes to the drain ---
  logic                    s4_add, s4_push, s4_break;
  logic                    add, add_first, add_strongest, drain, draining;
  logic [1:0]              add_gap;
  logic [GroupBits-1:0]    add_group, drain_group;
  logic [RowBits-1:0]      add_row, drain_row;
  logic [Lanes*WeightBits-1:0] add_weights, drain1_weights;
  logic [Lanes-1:0]        drain1_lit;
  logic                    best_valid;
  logic [Lanes*BestBits-1:0]   best;

  // A first row needs no read, so it may pass a drain. Another row meets a drain only after a
  // change of size: see spoiled_o.
  assign s4_add   = valid_q[4] && !s4_last_row && (s4_first_row || !draining);
  assign s4_push  = valid_q[4] && s4_last_row && accept_i;
  assign s4_break = break_q[3] && accept_i;

  sp_run_sums #(
    .MaxRows  (MaxRows),
    .GroupBits(GroupBits),
    .Grey     (Grey),
    .PixelBits(PixelBits),
    .Lanes    (Lanes)
  ) u_sums (
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .add_i           (add),
    .add_first_i     (add_first),
    .add_group_i     (add_group),
    .add_row_i       (add_row),
    .add_weights_i   (add_weights),
    .strongest_i     (add_strongest),
    .gap_i           (add_gap),
    .drain_i         (drain),
    .drain_group_i   (drain_group),
    .drain_row_i     (drain_row),
    .drain1_weights_i(drain1_weights),
    .drain1_lit_i    (drain1_lit),
    .best_valid_o    (best_valid),
    .best_o          (best)
  );

  if (Grey) begin : gen_grey
    // The sums run one clock behind the drain.
    logic                    s5_add_q, s5_first_row_q, s5_strongest_q;
    logic [1:0]              s5_gap_q;
    logic [GroupBits-1:0]    s5_group_q;
    logic [RowBits-1:0]      s5_row_q, row_number_q;
    logic [Lanes*WeightBits-1:0] s5_weights_q;
    logic [Lanes-1:0]        s4_lit;
    logic                    drain_break;
    logic                    out_grey_q, out_strongest_q;  // of the row that is drained
    always_ff @(posedge clk_i) begin
      if (rst_i) s5_add_q <= 1'b0;
      else s5_add_q <= s4_add;
    end
    always_ff @(posedge clk_i) begin
      {s5_first_row_q, s5_strongest_q, s5_gap_q} <= {s4_first_row, s4_strongest, s4_gap};
      {s5_group_q, s5_row_q, s5_weights_q}       <= {s4_group, s4_row, s4_weights_q};
      if (s4_push) {row_number_q, out_grey_q, out_strongest_q} <= {s4_row, s4_grey, s4_strongest};
    end
    assign {add, add_first, add_strongest, add_gap} =
        {s5_add_q, s5_first_row_q, s5_strongest_q, s5_gap_q};
    assign {add_group, add_row, add_weights}        = {s5_group_q, s5_row_q, s5_weights_q};
    assign drain_row                                = row_number_q;

    // Which weights are not 0 waits beside them: nothing comes late out of a block RAM and is still
    // compared with 0.
    for (genvar lane = 0; lane < Lanes; lane++) begin : gen_lit
      assign s4_lit[lane] = s4_weights_q[lane*WeightBits+:WeightBits] != '0;
    end

    sp_drain_order #(
      .GroupBits(GroupBits),
      .Width    (Lanes + Lanes * WeightBits)
    ) u_order (
      .clk_i         (clk_i),
      .rst_i         (rst_i),
      .push_i        (s4_push),
      .push_end_i    (s4_line_end),
      .push_group_i  (s4_group),
      .push_weights_i({s4_lit, s4_weights_q}),
      .break_i       (s4_break),
      .drain_o       (drain),
      .drain_group_o (drain_group),
      .weights_o     ({drain1_lit, drain1_weights}),
      .active_o      (draining),
      .break_o       (drain_break)
    );

    sp_run_output #(
      .MaxRows  (MaxRows),
      .PixelBits(PixelBits),
      .Lanes    (Lanes)
    ) u_output (
      .clk_i          (clk_i),
      .rst_i          (rst_i),
      .grey_i         (out_grey_q),
      .strongest_i    (out_strongest_q),
      .best_valid_i   (best_valid),
      .best_i         (best),
      .drain_break_i  (drain_break),
      .moments_valid_o(moments_valid_o),
      .moments_data_o (moments_data_o),
      .moments_break_o(moments_break_o)
    );

    // A frame is spoiled from its first lost beat until the first row of the next frame.
    always_ff @(posedge clk_i) begin
      if (rst_i) spoiled_o <= 1'b0;
      else if (valid_q[4] && s4_first_row) spoiled_o <= 1'b0;
      else if (valid_q[4] && !s4_last_row && draining) spoiled_o <= 1'b1;
    end
  end else begin : gen_binary
    // The last row follows one clock later than the others. So at least two clocks lie between a
    // drain and the row before it, and the first row of the next frame, which may come beside it,
    // needs no read.
    localparam int OutStage = 12;  // s4_push and s4_break are of stage 4
    logic [OutStage:5]       push_q, end_q, strongest_q;
    logic [GroupBits-1:0]    s5_group_q;
    logic [RowBits-1:0]      s5_row_q;
    logic [Lanes*WeightBits-1:0] s5_weights_q, s6_weights_q;
    always_ff @(posedge clk_i) begin
      if (rst_i) begin
        push_q <= '0;
        end_q  <= '0;
      end else begin
        push_q <= {push_q[OutStage-1:5], s4_push};
        end_q  <= {end_q[OutStage-1:5], s4_break};
      end
    end
    always_ff @(posedge clk_i) begin
      {s5_group_q, s5_row_q, s5_weights_q} <= {s4_group, s4_row, s4_weights_q};
      s6_weights_q                         <= s5_weights_q;
      strongest_q                          <= {strongest_q[OutStage-1:5], s4_strongest};
    end
    assign {add, add_first, add_strongest, add_gap} = {s4_add, s4_first_row, s4_strongest, s4_gap};
    assign {add_group, add_row, add_weights}        = {s4_group, s4_row, s4_weights_q};
    assign {drain, drain_group, drain_row}          = {push_q[5], s5_group_q, s5_row_q};
    assign {drain1_lit, drain1_weights}             = {s6_weights_q, s6_weights_q};
    assign draining                                 = 1'b0;
    assign spoiled_o                                = 1'b0;

    for (genvar lane = 0; lane < Lanes; lane++) begin : gen_word
      logic [1:0]        runs;
      logic [M0Bits-1:0] second, m0;
      logic [ABits-1:0]  m1;
      logic [31:0]       word_q;
      logic [2:0]        told;
      assign {runs, second, m0, m1} = best[lane*BestBits+:BestBits];
      logic              half;  // the second run has half the M0 of the strongest, or more
      assign half = runs[1] && {second, 1'b0} >= {1'b0, m0};
      assign told = strongest_q[OutStage-1] ? {half, runs} : 3'd0;
      if (MaxRows > sp_spec_pkg::MaxRows) begin : gen_tall
        always_ff @(posedge clk_i) word_q <=
            32'(m1) << sp_spec_pkg::TallBinaryM1Lsb | 32'(m0) << sp_spec_pkg::TallBinaryM0Lsb;
        logic unused_told;
        assign unused_told = ^told;
      end else begin : gen_run
        always_ff @(posedge clk_i) word_q <=
            32'(m1) << sp_spec_pkg::BinaryRunM1Lsb | 32'(m0) << sp_spec_pkg::BinaryRunM0Lsb |
            32'(told[2]) << sp_spec_pkg::BinaryRunSecondLsb |
            32'(told[1:0]) << sp_spec_pkg::BinaryRunRunsLsb;
      end
      assign moments_data_o[32*lane+:32] = word_q;
    end
    assign moments_valid_o = push_q[OutStage];
    assign moments_break_o = end_q[OutStage];
    logic unused;
    assign unused = ^{s4_line_end, s4_grey, best_valid};
  end

`ifdef FORMAL
  localparam int FWait = 11, FChangeWait = 23;
  localparam bit FBinaryDrains = 1'b1;
`include "sp_formal_frames.svh"

  // Of the frame with the column, and of the others
  (* anyconst *) logic       f_strongest, f_other_strongest;
  (* anyconst *) logic [1:0] f_gap, f_other_gap;
  always_comb begin
    if (!Changes) assume (f_other_strongest == f_strongest && f_other_gap == f_gap);
    assume (strongest_i == (f_this ? f_strongest : f_other_strongest));
    assume (gap_i == (f_this ? f_gap : f_other_gap));
  end

  // The runs of the column, as model/column_runs defines them, one row after the other.
  // The run that is open: its sums, and dark rows since its last lit one
  logic [FSumBits-1:0] f_m0_q, f_m1_q, f_n_q, f_m0, f_m1, f_n;
  logic [1:0]          f_dark_q;
  // The strongest run that has ended, M0 of the second, the number of them
  logic [FSumBits-1:0] f_best_m0_q, f_best_m1_q, f_best_n_q, f_second_q;
  logic [1:0]          f_runs_q;
  logic                f_over;
  always_comb begin
    {f_m0, f_m1, f_n} = {f_m0_q + f_weight, f_m1_q + f_row_weight, f_n_q + FSumBits'(f_lit)};
    // The row ends the run, by too many dark rows or as the last one.
    f_over = f_n != '0 && (f_last_row || f_strongest && !f_lit && f_dark_q == f_gap);
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      {f_m0_q, f_m1_q, f_n_q, f_dark_q}                            <= '0;
      {f_best_m0_q, f_best_m1_q, f_best_n_q, f_second_q, f_runs_q} <= '0;
    end else if (f_mine) begin
      f_dark_q                <= f_lit ? 2'd0 : f_dark_q + 2'd1;
      {f_m0_q, f_m1_q, f_n_q} <= f_over ? '0 : {f_m0, f_m1, f_n};
      if (f_over) begin
        if (f_runs_q != 2'd3) f_runs_q <= f_runs_q + 2'd1;
        if (f_m0 > f_best_m0_q) begin
          f_second_q                             <= f_best_m0_q;
          {f_best_m0_q, f_best_m1_q, f_best_n_q} <= {f_m0, f_m1, f_n};
        end else if (f_m0 > f_second_q) begin
          f_second_q <= f_m0;
        end
      end
    end
  end

  // What the word tells of the second run: q = floor(16 M0_2 / M0).
  logic [4:0]          f_told;
  logic [FSumBits+4:0] f_sixteen, f_told_m0;
  always_comb begin
    f_told    = PixelBits == 8 ? f_word[61:57] : f_strongest ? f_word[63:59] : 5'd0;
    f_sixteen = (FSumBits + 5)'(f_second_q) << 4;
    f_told_m0 = '0;
    for (int bit_of = 0; bit_of < 5; bit_of++) begin
      if (f_told[bit_of]) f_told_m0 = f_told_m0 + ((FSumBits + 5)'(f_best_m0_q) << bit_of);
    end
  end

  // Rule 1: the word of every column holds the sums of its strongest run, in the format of the
  // packet; of equals it is the earlier one. With select `all` they are those of all lit pixels.
  // Rule 2: it tells the number of runs, up to 3, and the strength of the second; 0 with `all`.
  always_comb if (f_run) begin
    if (f_here) begin
      if (f_grey) begin
        if (PixelBits > 8) begin
          assert (f_word[30:0] == 31'(f_best_m1_q) && f_word[52:31] == 22'(f_best_m0_q) &&
                  f_word[58:53] == f_best_n_q[5:0] && (f_strongest || f_word[63:59] == '0));
        end else begin
          assert (f_word[26:0] == 27'(f_best_m1_q) && f_word[44:27] == 18'(f_best_m0_q) &&
                  f_word[54:45] == f_best_n_q[9:0] && f_word[63:62] == '0);
          assert (f_word[56:55] == (f_strongest ? f_runs_q : 2'd0));
        end
        if (f_best_m0_q != '0 && f_strongest) begin
          assert (f_told_m0 <= f_sixteen &&
                  f_sixteen < f_told_m0 + (FSumBits + 5)'(f_best_m0_q));
        end else begin
          assert (f_told == '0);
        end
      end else begin
        assert (f_word[18:0] == 19'(f_best_m1_q) && f_word[29:20] == f_best_m0_q[9:0]);
        assert (f_word[31:30] == (f_strongest ? f_runs_q : 2'd0));
        assert (f_word[19] == (f_strongest && f_runs_q > 2'd1 &&
                               {f_second_q, 1'b0} >= {1'b0, f_best_m0_q}));
      end
    end
    cover (f_here && f_runs_q == 2'd2 && f_rows == RowBits'(MaxRows) && f_strongest);
    if (MaxRows >= 5) begin
      cover (f_here && f_runs_q == 2'd3);
      // lit, three dark rows, lit: one run
      cover (f_here && f_gap == 2'd3 && f_runs_q == 2'd1 && f_best_n_q == FSumBits'(2) &&
             f_best_m1_q == FSumBits'(6) && !f_grey && f_rows == RowBits'(5) && f_strongest);
    end else begin
      // behind another frame
      cover (f_here && f_strongest && f_runs_q == 2'd2 && f_frame == 5'd1);
    end
    // a frame of another mode just before
    if (Changes) cover (f_here && f_strongest && !f_other_strongest && f_frame == 5'd1);
    // one not wanted
    if (Grey && !Changes) begin
      cover (f_here && f_runs_q == 2'd2 && f_before_q == 6'd1 && f_frame == 5'd2);
    end
  end
`endif

endmodule

`default_nettype wire
