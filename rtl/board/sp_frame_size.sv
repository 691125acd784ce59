// Facts that follow from the size of frames: from the size as written, the size in force, and the
// size of a frame that starts.
//
// Guarantees: facts of a written size are right from the clock after it on. hold_i is high in the
// first clock of a new size and in the two clocks before it, so nothing is taken over until then.
// Facts in force are right from the clock after take_i on. Facts of a frame that starts are right
// in the clock after its first beat was at the input. sp_registers keeps sizes within the maxima of
// the build and columns a multiple of Lanes, so nothing overflows. groups_less_3_o has no meaning with
// fewer than three groups, rows_less_2_o none with one row.
//
//   clock              0   1   2   3   4   5
//   columns_i, rows_i < new size
//   hold_i            1111\__________________   high in the two clocks before, too
//   facts as written  -----< right
//   tuser_i, new_i    _________/1\___________   a frame starts with the size as written
//   start_*_o         -------------< right >-
//   take_i            _____________/1\_______
//   facts in force    -----------------< right
`default_nettype none

module sp_frame_size #(
  parameter int GroupBits = 9,  // 2 or more
  parameter int ColumnBits = 12,  // GroupBits + $clog2(Lanes) or more
  parameter int RowBits = 10,  // 2 or more
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat  // pixels in a beat: 4, 8 or 16
) (
  input  wire logic                  clk_i,

  // As written
  input  wire logic                  hold_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,

  // In force: as written when take_i was high
  input  wire logic                  take_i,
  output logic      [ColumnBits-1:0] columns_o,
  output logic      [RowBits-1:0]    rows_o,
  output logic                       one_group_o,      // a line has Lanes columns
  output logic                       two_groups_o,
  output logic      [GroupBits-1:0]  groups_less_3_o,  // groups of a line, minus 3
  output logic      [RowBits-1:0]    rows_less_2_o,

  // The beat at the input. With tuser_i it may start a frame, of the size as written (new_i) or of
  // the size in force.
  input  wire logic                  tuser_i,
  input  wire logic                  tlast_i,
  input  wire logic                  new_i,
  // One clock later, if it did: facts of the frame,
  output logic                       start_one_group_o,
  output logic                       start_three_groups_o,
  output logic                       start_one_row_o,
  output logic                       start_next_ends_line_o,     // its second beat ends a line
  // its second beat is in its last row
  output logic                       start_next_in_last_row_o,
  // the row after that beat's is the last
  output logic                       start_row_after_is_last_o,
  // and of its first line
  output logic                       start_wrong_length_o,  // it ends early or late with this beat
  output logic                       start_goes_on_o  // neither the line nor the frame ends
`ifdef FORMAL
  ,
  input  wire logic                  f_start_i,     // the beat one clock ago had tuser
  input  wire logic                  f_in_force_i   // a size has been taken over
`endif
);

  if (GroupBits < 2) begin : gen_group_bits
    group_bits_is_less_than_2 u_error ();
  end
  if (RowBits < 2) begin : gen_row_bits
    row_bits_is_less_than_2 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  localparam int LaneBits = $clog2(Lanes);
  localparam int CountBits = ColumnBits - LaneBits;  // of groups
  if (CountBits < GroupBits) begin : gen_column_bits
    column_bits_is_less_than_group_bits_plus_those_of_lanes u_error ();
  end

  logic [CountBits-1:0] groups;
  // Of the size as written
  logic                 new_one_group_q, new_two_groups_q, new_three_groups_q, new_one_row_q,
      new_two_rows_q, new_three_rows_q;
  logic [GroupBits-1:0] new_groups_less_3_q;
  logic [RowBits-1:0]   new_rows_less_2_q;
  // Of the size in force, as for a frame that starts
  logic                 three_groups_q, one_row_q, next_in_last_row_q, row_after_is_last_q;
  logic                 one_group, one_row;  // of a frame that starts now

  assign groups = columns_i[ColumnBits-1:LaneBits];

  always_ff @(posedge clk_i) if (hold_i) begin
    new_one_group_q     <= groups == CountBits'(1);
    new_two_groups_q    <= groups == CountBits'(2);
    new_one_row_q       <= rows_i == RowBits'(1);
    new_two_rows_q      <= rows_i == RowBits'(2);
    new_three_rows_q    <= rows_i == RowBits'(3);
    new_three_groups_q  <= groups == CountBits'(3);
    new_groups_less_3_q <= GroupBits'(groups - CountBits'(3));
    new_rows_less_2_q   <= rows_i - RowBits'(2);
  end

  always_ff @(posedge clk_i) if (take_i) begin
    columns_o           <= columns_i;
    rows_o              <= rows_i;
    one_group_o         <= new_one_group_q;
    two_groups_o        <= new_two_groups_q;
    groups_less_3_o     <= new_groups_less_3_q;
    rows_less_2_o       <= new_rows_less_2_q;
    three_groups_q      <= new_three_groups_q;
    one_row_q           <= new_one_row_q;
    next_in_last_row_q  <= new_one_group_q ? new_two_rows_q : new_one_row_q;
    row_after_is_last_q <= new_one_group_q ? new_three_rows_q : new_two_rows_q;
  end

  assign one_group = new_i ? new_one_group_q : one_group_o;
  assign one_row   = new_i ? new_one_row_q : one_row_q;

  always_ff @(posedge clk_i) if (tuser_i) begin
    start_one_group_o         <= one_group;
    start_next_ends_line_o    <= new_i ? new_one_group_q || new_two_groups_q :
                                 one_group_o || two_groups_o;
    start_one_row_o           <= one_row;
    start_next_in_last_row_o  <= new_i ? (new_one_group_q ? new_two_rows_q : new_one_row_q) :
                                 next_in_last_row_q;
    start_row_after_is_last_o <= new_i ? (new_one_group_q ? new_three_rows_q : new_two_rows_q) :
                                 row_after_is_last_q;
    start_three_groups_o      <= new_i ? new_three_groups_q : three_groups_q;
    start_wrong_length_o      <= tlast_i != one_group;
    start_goes_on_o           <= one_group ? tlast_i && !one_row : !tlast_i;
  end

`ifdef FORMAL
  // Rule: facts as written are right once hold_i has been low within three clocks. Facts in force
  // belong to the size in force, facts of a frame that starts to its own size.
  logic [2:1] f_hold_q = 2'b11;  // so many clocks ago
  logic       f_ran_q = 1'b0;
  logic       f_last_q;          // tlast_i a clock ago
  logic [ColumnBits-1:0] f_columns;
  logic [RowBits-1:0]    f_rows;
  always_ff @(posedge clk_i) {f_hold_q, f_ran_q, f_last_q} <= {f_hold_q[1], hold_i, 1'b1, tlast_i};
  assign f_columns = take_i ? columns_i : columns_o;
  assign f_rows    = take_i ? rows_i : rows_o;
  always_comb if (f_ran_q) begin
    if (!(hold_i && f_hold_q == 2'b11)) begin
      assert (new_one_group_q == (columns_i == ColumnBits'(Lanes)) &&
              new_two_groups_q == (columns_i == ColumnBits'(2 * Lanes)));
      assert (new_three_groups_q == (columns_i == ColumnBits'(3 * Lanes)) &&
              new_one_row_q == (rows_i == RowBits'(1)));
      assert (new_two_rows_q == (rows_i == RowBits'(2)) &&
              new_three_rows_q == (rows_i == RowBits'(3)));
      assert (new_groups_less_3_q == GroupBits'((columns_i >> LaneBits) - ColumnBits'(3)));
      assert (new_rows_less_2_q == rows_i - RowBits'(2));
    end
    if (f_in_force_i) begin
      assert (one_group_o == (columns_o == ColumnBits'(Lanes)) &&
              two_groups_o == (columns_o == ColumnBits'(2 * Lanes)));
      assert (three_groups_q == (columns_o == ColumnBits'(3 * Lanes)) &&
              one_row_q == (rows_o == RowBits'(1)));
      assert (next_in_last_row_q == (rows_o == (columns_o == ColumnBits'(Lanes) ? RowBits'(2) :
                                                RowBits'(1))));
      assert (row_after_is_last_q == (rows_o == (columns_o == ColumnBits'(Lanes) ? RowBits'(3) :
                                                 RowBits'(2))));
      assert (groups_less_3_o == GroupBits'((columns_o >> LaneBits) - ColumnBits'(3)));
      assert (rows_less_2_o == rows_o - RowBits'(2));
    end
    if (f_start_i && (take_i || f_in_force_i)) begin
      assert (start_one_group_o == (f_columns == ColumnBits'(Lanes)) &&
              start_one_row_o == (f_rows == RowBits'(1)));
      assert (start_next_ends_line_o == (f_columns == ColumnBits'(Lanes) ||
                                         f_columns == ColumnBits'(2 * Lanes)));
      assert (start_three_groups_o == (f_columns == ColumnBits'(3 * Lanes)));
      assert (start_next_in_last_row_o == (f_rows == (start_one_group_o ? RowBits'(2) :
                                                      RowBits'(1))));
      assert (start_row_after_is_last_o == (f_rows == (start_one_group_o ? RowBits'(3) :
                                                       RowBits'(2))));
      assert (start_wrong_length_o == (f_last_q != start_one_group_o));
      assert (start_goes_on_o == (start_one_group_o ? f_last_q && !start_one_row_o : !f_last_q));
    end
  end
`endif

endmodule

`default_nettype wire
