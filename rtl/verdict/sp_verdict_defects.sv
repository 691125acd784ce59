// Finds defects in the judged columns of frames: w or more neighbouring columns that were out in at
// least m of the last h frames.
//
// Input: the groups of sp_verdict_columns, in order, with done_i behind or with the last group of a
// frame.
// Two groups of one place, of two frames, are eight clocks apart or more. The settings stand still
// from the first group of a frame until found_valid_o. A column is out if it is above and above_i,
// or below and below_i. fresh_i: no whole frame of the part came before, so columns have no hits yet.
//
// Output: found_valid_o comes ten clocks after done_i, with the leftmost defect of the frame. It
// stays until the next one. unlit_o counts the columns that are judged and unlit, lit_o the lit
// ones. The memory keeps what columns were in the last seven frames in which they came.
//
//   group_valid_i _/1\_______________________
//   done_i        _/1\_______________________
//   found_valid_o ___________ … ________/1\__
`default_nettype none

module sp_verdict_defects #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..4096
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int ColumnBits = $clog2(MaxColumns + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Settings
  input  wire logic [7:0]            width_i,    // w, 1..255
  input  wire logic [2:0]            history_i,  // h - 1
  input  wire logic [3:0]            hits_i,     // m, 1..15
  input  wire logic                  above_i,
  input  wire logic                  below_i,
  input  wire logic                  fresh_i,

  // A frame
  input  wire logic                  start_i,    // before its first group
  input  wire logic                  group_valid_i,
  input  wire logic [3:0]            group_above_i,
  input  wire logic [3:0]            group_below_i,
  input  wire logic [3:0]            group_unlit_i,
  input  wire logic [3:0]            group_lit_i,
  input  wire logic                  done_i,

  output logic                       found_valid_o,
  output logic                       defect_o,
  output logic      [ColumnBits-1:0] first_column_o,  // of the leftmost defect, from 1
  output logic      [ColumnBits-1:0] columns_o,       // of it
  output logic      [ColumnBits-1:0] unlit_o,
  output logic      [ColumnBits-1:0] lit_o
);

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_4096 u_error ();
  end

  // --- Stages 1 to 5: hits of the last frames, and which columns have enough ---
  logic [5:1]           valid_q, done_q;
  logic [3:0]           s1_out_q, s2_out_q, s5_marked_q;
  logic [27:0]          past, s2_past_q;  // seven frames for each lane, the newest lowest
  logic [GroupBits-1:0] group_q, s1_group_q, s2_group_q;
  logic [6:0]           counts_q;         // the frames before, of those that count for hits

  // Ones among four bits
  function automatic logic [2:0] ones(input logic [3:0] bits);
    ones = {&bits, (bits[0] && bits[1]) ^ (bits[2] && bits[3]) ^
            ((bits[0] ^ bits[1]) && (bits[2] ^ bits[3])), ^bits};
  endfunction

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      done_q  <= '0;
    end else begin
      valid_q <= {valid_q[4:1], group_valid_i};
      done_q  <= {done_q[4:1], done_i};
    end
  end
  always_ff @(posedge clk_i) begin
    s1_out_q  <= group_above_i & {4{above_i}} | group_below_i & {4{below_i}};
    s2_out_q  <= s1_out_q;
    for (int frame = 0; frame < 7; frame++) begin
      counts_q[frame] <= !fresh_i && history_i > 3'(frame);
    end
    if (start_i) group_q <= '0;
    else if (group_valid_i) group_q <= group_q + GroupBits'(1);
    {s2_group_q, s1_group_q} <= {s1_group_q, group_q};
  end
  for (genvar frame = 0; frame < 7; frame++) begin : gen_frame
    always_ff @(posedge clk_i) begin
      for (int lane = 0; lane < 4; lane++) begin
        if (!counts_q[frame]) s2_past_q[7*lane+frame] <= 1'b0;
        else s2_past_q[7*lane+frame] <= past[7*lane+frame];
      end
    end
  end

  logic [27:0] kept;  // for the next frame
`ifdef FORMAL
  (* anyconst *) logic [GroupBits+1:0] f_column;  // any column, from 0
  logic [27:0] f_word;  // of its group, in the memory
`endif
  for (genvar lane = 0; lane < 4; lane++) begin : gen_lane
    // Hits of the newest four frames, and of the four before, as sums of ones and twos
    logic [3:0] new_hits, old_hits;
    logic [2:0] s3_new_q, s3_old_q;
    logic [3:0] s4_hits_q;
    assign {old_hits, new_hits}  = {s2_past_q[7*lane+:7], s2_out_q[lane]};
    assign kept[7*lane+:7]       = {s2_past_q[7*lane+:6], s2_out_q[lane]};
    always_ff @(posedge clk_i) begin
      s3_new_q  <= ones(new_hits);
      s3_old_q  <= ones(old_hits);
      s4_hits_q <= {1'b0, s3_new_q} + {1'b0, s3_old_q};
      s5_marked_q[lane] <= s4_hits_q >= hits_i;
    end
  end

  sp_ram #(
    .Width   (28),
    .LogDepth(GroupBits)
  ) u_past (
    .wr_clk_i (clk_i),
    .wr_en_i  (valid_q[2]),
    .wr_addr_i(s2_group_q),
    .wr_data_i(kept),
    .rd_clk_i (clk_i),
    .rd_en_i  (1'b1),
    .rd_addr_i(group_q),
    .rd_data_o(past)
`ifdef FORMAL
    ,
    .f_addr_i (f_column[GroupBits+1:2]),
    .f_word_o (f_word),
    .f_first_o()
`endif
  );

  // --- Stage 6: a group of columns with enough hits, and where runs of them lie in it ---
  logic       s6_valid_q, s6_done_q, s6_all_q;
  logic [2:0] s6_lead_q, s6_trail_q;
  logic [1:0] s6_inner_q;        // a run that touches neither side: its length
  logic       s6_inner_third_q;  // it begins with the third column, not the second
  logic [GroupBits:0] s6_group_q;  // behind the last group, that of the item that ends
  logic       s5_end_q;          // the item after the last group: what is open ends
  logic [3:0] marks;
  assign marks = s5_marked_q & {4{!s5_end_q}};

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s5_end_q   <= 1'b0;
      s6_valid_q <= 1'b0;
      s6_done_q  <= 1'b0;
    end else begin
      s5_end_q   <= done_q[5];
      s6_valid_q <= valid_q[5] || s5_end_q;
      s6_done_q  <= s5_end_q;
    end
  end
  always_ff @(posedge clk_i) begin
    if (start_i) s6_group_q <= '0;
    else if (s6_valid_q) s6_group_q <= s6_group_q + (GroupBits + 1)'(1);
    s6_all_q <= &marks;
    casez (marks)
      4'b???0: s6_lead_q <= 3'd0;
      4'b??01: s6_lead_q <= 3'd1;
      4'b?011: s6_lead_q <= 3'd2;
      4'b0111: s6_lead_q <= 3'd3;
      default: s6_lead_q <= 3'd4;
    endcase
    casez (marks)
      4'b0???: s6_trail_q <= 3'd0;
      4'b10??: s6_trail_q <= 3'd1;
      4'b110?: s6_trail_q <= 3'd2;
      4'b1110: s6_trail_q <= 3'd3;
      default: s6_trail_q <= 3'd4;
    endcase
    casez (marks)
      4'b010?, 4'b?010: s6_inner_q <= 2'd1;
      4'b0110: s6_inner_q <= 2'd2;
      default: s6_inner_q <= 2'd0;
    endcase
    s6_inner_third_q <= !marks[1];
  end

  // --- Stage 7: the run that comes from the left ---
  logic [ColumnBits-1:0] run_q;  // columns with enough hits directly before this group
  logic [ColumnBits-1:0] s7_run_q, s7_first_q;  // a run that ends here, and its first column
  logic                  s7_ends_q, s7_done_q, s7_inner_third_q;
  logic [1:0]            s7_inner_q;
  logic [GroupBits:0]    s7_group_q;

  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) run_q <= '0;
    else if (s6_valid_q) begin
      run_q <= s6_all_q ? run_q + ColumnBits'(4) : ColumnBits'(s6_trail_q);
    end
  end
  always_ff @(posedge clk_i) begin
    s7_run_q         <= run_q + ColumnBits'(s6_lead_q);
    s7_first_q       <= ColumnBits'({s6_group_q, 2'b01}) - run_q;
    s7_inner_q       <= s6_inner_q;
    s7_inner_third_q <= s6_inner_third_q;
    s7_group_q       <= s6_group_q;
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) {s7_ends_q, s7_done_q} <= '0;
    else {s7_ends_q, s7_done_q} <= {s6_valid_q && !s6_all_q, s6_done_q};
  end

  // --- Stages 8 and 9: is it long enough, and is it the first ---
  logic                  s8_long_q, s8_inner_long_q, s8_inner_third_q, s8_done_q;
  logic [ColumnBits-1:0] s8_run_q, s8_first_q;
  logic [1:0]            s8_inner_q;
  logic [GroupBits:0]    s8_group_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) {s8_long_q, s8_inner_long_q, s8_done_q} <= '0;
    else begin
      s8_long_q       <= s7_ends_q && 12'(s7_run_q) >= 12'(width_i);
      s8_inner_long_q <= s7_ends_q && 8'(s7_inner_q) >= width_i;
      s8_done_q       <= s7_done_q;
    end
  end
  always_ff @(posedge clk_i) begin
    {s8_run_q, s8_first_q} <= {s7_run_q, s7_first_q};
    {s8_inner_q, s8_inner_third_q, s8_group_q} <= {s7_inner_q, s7_inner_third_q, s7_group_q};
  end

  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) begin
      defect_o       <= 1'b0;
      first_column_o <= '0;
      columns_o      <= '0;
    end else if (!defect_o) begin
      defect_o <= s8_long_q || s8_inner_long_q;
      if (s8_long_q) begin
        first_column_o <= s8_first_q;
        columns_o      <= s8_run_q;
      end else if (s8_inner_long_q) begin
        first_column_o <= ColumnBits'({s8_group_q, 1'b1, s8_inner_third_q});
        columns_o      <= ColumnBits'(s8_inner_q);
      end
    end
  end
  always_ff @(posedge clk_i) found_valid_o <= !rst_i && s8_done_q;

  // --- Light ---
  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) begin
      unlit_o <= '0;
      lit_o   <= '0;
    end else if (group_valid_i) begin
      unlit_o <= unlit_o + ColumnBits'(ones(group_unlit_i));
      lit_o   <= lit_o + ColumnBits'(ones(group_lit_i));
    end
  end

`ifdef FORMAL
  // Assumptions: one reset at the beginning. start_i begins a frame, behind the verdict of the
  // frame before or if that one had no groups. Its groups and its done_i follow; no more groups
  // than there are. The settings stand still from the first of these to the verdict.
  localparam int FColumns = MaxColumns < 16 ? MaxColumns : 16;  // no proof has more
  localparam int FGroups = FColumns / 4;
  logic               f_ran_q = 1'b0;
  logic               f_open_q;    // between start_i and done_i
  logic               f_busy_q;    // between done_i and the verdict
  logic [GroupBits:0] f_groups_q;  // groups of the frame that came
  logic               f_fixed_q;   // settings stand still
  logic [18:0]        f_settings, f_settings_q;
  assign f_settings = {width_i, history_i, hits_i, above_i, below_i, fresh_i, 1'b0};
  always_ff @(posedge clk_i) begin
    f_ran_q      <= 1'b1;
    f_settings_q <= f_settings;
    if (rst_i) {f_open_q, f_busy_q, f_fixed_q} <= '0;
    else begin
      f_open_q  <= start_i || f_open_q && !done_i;
      f_busy_q  <= done_i || f_busy_q && !found_valid_o;
      f_fixed_q <= (f_fixed_q || group_valid_i || done_i) && !found_valid_o;
    end
    if (rst_i || start_i) f_groups_q <= '0;
    else if (group_valid_i) f_groups_q <= f_groups_q + (GroupBits + 1)'(1);
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (rst_i || start_i) assume (!group_valid_i && !done_i);
    if (start_i) assume (!f_busy_q && (!f_open_q || f_groups_q == '0));
    if (group_valid_i) assume (f_open_q && f_groups_q < (GroupBits + 1)'(FGroups));
    if (done_i) assume (f_open_q);
    assume (width_i != '0 && hits_i != '0);
    if (f_fixed_q) assume (f_settings == f_settings_q);
  end

  // Any column: in which frames of its part it was out, of those in which it came. A part has one
  // history_i, and all columns come with fresh_i before one comes without.
  logic [GroupBits:0] f_places_q;  // groups of the frame that have been marked
  logic [1:0] f_lane;
  logic       f_here, f_out, f_mark;
  logic [5:1] f_here_q, f_mark_q;
  logic [6:0] f_past_q, f_past, f_counts, f_kept_counts;
  logic       f_came_q;
  logic [2:0] f_history_q;
  logic [3:0] f_hits;
  assign f_lane = f_column[1:0];
  assign f_here = group_valid_i && f_groups_q == {1'b0, f_column[GroupBits+1:2]};
  assign f_out  = group_above_i[f_lane] && above_i || group_below_i[f_lane] && below_i;
  assign f_past = fresh_i ? '0 : f_past_q;
  assign f_mark = f_hits >= hits_i;
  always_comb begin
    f_hits = 4'(f_out);
    for (int frame = 0; frame < 7; frame++) begin
      f_counts[frame]      = frame < 32'(history_i);
      f_kept_counts[frame] = frame < 32'(f_history_q);
      f_hits               = f_hits + 4'(f_past[frame] && f_counts[frame]);
    end
    assume (32'(f_column) < FColumns);
    if (f_here && !fresh_i) assume (f_came_q && history_i == f_history_q);
  end
  always_ff @(posedge clk_i) begin
    f_mark_q <= {f_mark_q[4:1], f_mark};
    if (rst_i) {f_came_q, f_here_q} <= '0;
    else begin
      f_here_q <= {f_here_q[4:1], f_here};
      if (f_here) f_came_q <= 1'b1;
    end
    if (f_here) {f_history_q, f_past_q} <= {history_i, f_past[5:0], f_out};
  end

  // Rule 1: each column is marked exactly if it was out in hits_i or more of the last frames that
  // count, this one included. (Marks of other columns are right too, because the column is any.)
  always_comb if (f_ran_q) begin
    if (f_here_q[5]) begin
      assert (valid_q[5] && f_places_q == {1'b0, f_column[GroupBits+1:2]});
      assert (s5_marked_q[f_lane] == f_mark_q[5]);
    end
    if (f_came_q && f_here_q[2:1] == '0) begin
      assert (((f_word[7*f_lane+:7] ^ f_past_q) & f_kept_counts) == '0);
    end
  end

  // The marks of the frame, one and three clocks later too, and how many groups of it have come
  logic [FColumns-1:0] f_marks_q, f_marks1_q, f_marks2_q, f_marks3_q;
  logic [GroupBits:0]  f_places1_q, f_places2_q, f_places3_q;
  logic [10:1]           f_done_q;
  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) begin
      {f_marks_q, f_marks1_q, f_marks2_q, f_marks3_q}     <= '0;
      {f_places_q, f_places1_q, f_places2_q, f_places3_q} <= '0;
    end else begin
      {f_marks3_q, f_marks2_q, f_marks1_q}    <= {f_marks2_q, f_marks1_q, f_marks_q};
      {f_places3_q, f_places2_q, f_places1_q} <= {f_places2_q, f_places1_q, f_places_q};
      if (valid_q[5]) begin
        f_places_q <= f_places_q + (GroupBits + 1)'(1);
        for (int group = 0; group < FGroups; group++) begin
          if (32'(f_places_q) == group) f_marks_q[4*group+:4] <= s5_marked_q;
        end
      end
    end
    f_done_q <= rst_i ? '0 : {f_done_q[9:1], done_i};
  end

  // Neighbouring marks from each column on to the right, without those that may go on with the next
  // group of the frame; and the leftmost column with width_i of them
  logic                  f_ended7_q, f_ended9_q;  // the frame has ended, as seen in stages 7 and 9
  logic                  f_defect;
  logic [ColumnBits-1:0] f_first, f_columns;
  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) {f_ended7_q, f_ended9_q} <= '0;
    else begin
      if (f_done_q[7]) f_ended7_q <= 1'b1;
      if (f_done_q[9]) f_ended9_q <= 1'b1;
    end
  end
  for (genvar c = 0; c <= FColumns; c++) begin : gen_f_column
    logic                  may_go_on, defect;
    logic [ColumnBits-1:0] length, first, columns;
    if (c == FColumns) begin : gen_none
      assign may_go_on                            = !f_ended9_q;
      assign {length, defect, first, columns} = '0;
    end else begin : gen_column
      assign may_go_on = gen_f_column[c+1].may_go_on &&
                         (f_marks3_q[c] || f_places3_q <= (GroupBits + 1)'(c / 4));
      assign length    = f_marks3_q[c] && !may_go_on ?
                         gen_f_column[c+1].length + ColumnBits'(1) : '0;
      assign {defect, first, columns} = 12'(length) >= 12'(width_i) ?
          {1'b1, ColumnBits'(c + 1), length} :
          {gen_f_column[c+1].defect, gen_f_column[c+1].first, gen_f_column[c+1].columns};
    end
  end
  assign {f_defect, f_first, f_columns} =
      {gen_f_column[0].defect, gen_f_column[0].first, gen_f_column[0].columns};

  // Light, counted one by one
  logic [ColumnBits-1:0] f_unlit_q, f_lit_q;
  always_ff @(posedge clk_i) begin
    if (rst_i || start_i) {f_unlit_q, f_lit_q} <= '0;
    else if (group_valid_i) begin
      f_unlit_q <= f_unlit_q + ColumnBits'(group_unlit_i[0]) + ColumnBits'(group_unlit_i[1]) +
                   ColumnBits'(group_unlit_i[2]) + ColumnBits'(group_unlit_i[3]);
      f_lit_q   <= f_lit_q + ColumnBits'(group_lit_i[0]) + ColumnBits'(group_lit_i[1]) +
                   ColumnBits'(group_lit_i[2]) + ColumnBits'(group_lit_i[3]);
    end
  end

  always_comb if (f_ran_q) begin
    // Rule 2: the verdict comes ten clocks after done_i.
    assert (found_valid_o == f_done_q[10]);
    // Rule 3: it tells the leftmost width_i or more neighbouring columns that are marked, and how
    // many they are: none is missed, none is told that is not there.
    if (f_open_q || f_fixed_q || found_valid_o) begin
      assert (defect_o == f_defect && first_column_o == f_first && columns_o == f_columns);
    end
    if (found_valid_o) assert (f_places3_q == f_groups_q && f_ended9_q);
    // Rule 4: unlit_o and lit_o are the numbers of such columns in the frame.
    assert (unlit_o == f_unlit_q && lit_o == f_lit_q);
    // The registers agree with that.
    if (f_open_q || f_busy_q) assert (group_q == f_groups_q[GroupBits-1:0]);
    if (valid_q[1]) assert (s1_group_q == group_q - GroupBits'(1));
    if (valid_q[2]) assert (s2_group_q == group_q - GroupBits'(1) - GroupBits'(valid_q[1]));
    for (int c = 0; c < FColumns; c++) begin
      // the run that comes from the left
      if (c < 4 * 32'(f_places1_q)) begin
        if (c >= 4 * 32'(f_places1_q) - 32'(run_q)) assert (f_marks1_q[c]);
        if (c + 1 == 4 * 32'(f_places1_q) - 32'(run_q)) assert (f_ended7_q || !f_marks1_q[c]);
      end else begin
        assert (!f_marks1_q[c]);
      end
    end
    assert (32'(run_q) <= 4 * 32'(f_places1_q));
    if (f_ended7_q) assert (run_q == '0);
    else if (f_open_q || f_busy_q) assert (s6_group_q == f_places1_q);
    assert (f_places_q <= f_groups_q && f_groups_q <= (GroupBits + 1)'(FGroups));
    if (!f_open_q && !f_busy_q) assert (!f_fixed_q);
    if (f_open_q) assert (!f_busy_q && !f_ended7_q && !f_ended9_q);
    if (f_ended9_q) assert (f_ended7_q);
    assert ({s8_done_q, s7_done_q, s6_done_q, s5_end_q, done_q} == f_done_q[9:1]);
    if (f_open_q || f_busy_q) begin
      assert (f_groups_q == f_places_q + (GroupBits + 1)'($countones(valid_q)));
    end else begin
      assert (valid_q == '0 && f_here_q == '0);
    end
    if (f_busy_q) assert (f_fixed_q && f_done_q != '0);
    if (f_done_q != '0) assert (f_busy_q);
    assert ((f_done_q & (f_done_q - 10'd1)) == '0);
    for (int stage = 1; stage <= 5; stage++) begin
      if (valid_q[stage]) assert (f_done_q >> stage == '0);
    end
    if (f_busy_q) assert (f_ended7_q == (f_done_q[10:8] != '0));
    if (f_open_q && !f_fixed_q) assert (f_groups_q == '0);
  end

  always_ff @(posedge clk_i) if (f_ran_q) begin
    // a defect over all groups; one inside of a group; a mark by hits of frames before; a frame
    // that breaks with a defect of its first group
    cover (found_valid_o && 32'(columns_o) == FColumns);
    cover (found_valid_o && first_column_o == ColumnBits'(6) && columns_o == ColumnBits'(2));
    cover (f_here_q[5] && f_mark_q[5] && f_past_q[3:0] == 4'b1010 && hits_i == 4'd2);
    cover (found_valid_o && defect_o && f_groups_q == (GroupBits + 1)'(1));
    cover (found_valid_o && !defect_o && f_marks3_q != '0 && 32'(unlit_o) == 2);
  end
`endif

endmodule

`default_nettype wire
