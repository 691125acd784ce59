// Finds defects in the judged columns of frames: w or more neighbouring columns that were out in at
// least m of the last h frames.
//
// Input: the groups of sp_verdict_columns, in order, with done_i behind or with the last group of a
// frame.
// Two groups of one place, of two frames, are eight clocks apart or more. The settings stand still
// from the first group of a frame until found_valid_o. A column is out if it is above and above_i,
// or below and below_i. fresh_i: no frame of the part came before, so columns have no hits yet.
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
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 8..2048
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int ColumnBits = $clog2(MaxColumns + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Settings
  input  wire logic [7:0]            width_i,    // w, 1..255
  input  wire logic [2:0]            history_i,  // h - 1
  input  wire logic [3:0]            hits_i,     // m, 1..h
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

  if (MaxColumns < 8 || MaxColumns > sp_spec_pkg::MaxColumns || MaxColumns % 4 != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_4_in_8_to_2048 u_error ();
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
    .f_addr_i ('0),
    .f_word_o (),
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

endmodule

`default_nettype wire
