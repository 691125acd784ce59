// Position of the beats of a frame: the group of pixels, one beat, in the line, the row, and whether
// either is the last one.
//
// beat_i marks a beat, start_i with it the first beat of a frame; the signals beside start_i
// describe that frame. The outputs describe the next beat of the frame, as if it did not start
// another. They have no meaning between frames.
//
// Guarantees: the outputs are right while every line ends where it should; the caller ends a frame
// with the first line that does not. Latency: one clock. Rows count from 1, groups from 0; neither
// overflows within a frame.
//
//   beat_i           _/1\_/2\_/3\_/4\_____/5\_/6\_____   2 groups per line, 3 rows
//   start_i          _/1\____________________________
//   group_o          -----< 1 < 0 < 1 < 0     < 1 <---   one clock after the beat before
//   row_o            -----< 1 < 2     < 3         <---
//   group_is_last_o  _____/111\___/111\_______/111\___   compared one beat ahead
//   row_is_last_o    _________________/11111111111\___   compared one row ahead
`default_nettype none

module sp_frame_position #(
  parameter int GroupBits = 9,  // 2 or more
  parameter int RowBits = 10  // 2 or more
) (
  input  wire logic                 clk_i,

  input  wire logic                 beat_i,

  // With beat_i
  input  wire logic                 start_i,
  input  wire logic                 start_one_group_i,
  input  wire logic                 start_next_ends_line_i,     // its second beat ends a line
  input  wire logic                 start_three_groups_i,
  input  wire logic                 start_next_in_last_row_i,   // its second beat
  input  wire logic                 start_row_after_is_last_i,  // the row after that beat's

  // Of the open frame
  input  wire logic                 one_group_i,
  input  wire logic                 two_groups_i,
  input  wire logic [GroupBits-1:0] groups_less_3_i,
  input  wire logic [RowBits-1:0]   rows_less_2_i,

  // Of its next beat
  output logic      [GroupBits-1:0] group_o,
  output logic                      group_is_last_o,
  output logic      [RowBits-1:0]   row_o,
  output logic                      row_is_first_o,
  output logic                      row_is_last_o
`ifdef FORMAL
  ,
  input  wire logic                 f_open_i,  // a frame is open, of this size:
  input  wire logic [GroupBits+2:0] f_columns_i,  // four times its groups
  input  wire logic [RowBits-1:0]   f_rows_i
`endif
);

  if (GroupBits < 2) begin : gen_group_bits
    group_bits_is_less_than_2 u_error ();
  end
  if (RowBits < 2) begin : gen_row_bits
    row_bits_is_less_than_2 u_error ();
  end

  // Whether the group (the row) after the next beat's is the last one. It is compared, or, after
  // the first beat of a frame and the last beat of a line, known from the size alone.
  typedef struct packed {
    logic compared;
    logic is_known;  // use known, not compared
    logic known;
  } after_t;

  after_t group_after_q, row_after_q;

  always_ff @(posedge clk_i) begin
    if (beat_i) begin
      if (start_i) begin
        group_o              <= GroupBits'(!start_one_group_i);
        group_is_last_o      <= start_next_ends_line_i;
        row_o                <= start_one_group_i ? RowBits'(2) : RowBits'(1);
        row_is_first_o       <= !start_one_group_i;
        row_is_last_o        <= start_next_in_last_row_i;
        row_after_q.is_known <= 1'b1;
        row_after_q.known    <= start_row_after_is_last_i;
      end else if (group_is_last_o) begin
        group_o              <= '0;
        group_is_last_o      <= one_group_i;
        row_o                <= row_o + RowBits'(1);
        row_is_first_o       <= 1'b0;
        row_is_last_o        <= row_after_q.is_known ? row_after_q.known : row_after_q.compared;
        row_after_q.is_known <= 1'b0;
        row_after_q.compared <= row_o == rows_less_2_i;
      end else begin
        group_o              <= group_o + GroupBits'(1);
        group_is_last_o      <= group_after_q.is_known ? group_after_q.known :
                                group_after_q.compared;
      end
      group_after_q.compared <= group_o == groups_less_3_i;
      group_after_q.is_known <= start_i || group_is_last_o;
      group_after_q.known    <= start_i ? start_three_groups_i : two_groups_i;
    end
  end

`ifdef FORMAL
  // Rule: the position lies inside the frame, and first and last mean what they say.
  localparam int FBits = GroupBits + 3;
  always_comb if (f_open_i) begin
    assert (row_o >= RowBits'(1) && row_o <= f_rows_i);
    assert (row_is_first_o == (row_o == RowBits'(1)));
    assert (row_is_last_o == (row_o == f_rows_i));
    assert (FBits'(group_o) < f_columns_i >> 2);
    assert (group_is_last_o == (FBits'(group_o) == (f_columns_i >> 2) - FBits'(1)));
    if (!group_is_last_o) begin
      assert ((group_after_q.is_known ? group_after_q.known : group_after_q.compared) ==
              (FBits'(group_o) + FBits'(2) == f_columns_i >> 2));
    end
    if (!row_is_last_o) begin
      assert ((row_after_q.is_known ? row_after_q.known : row_after_q.compared) ==
              (row_o + RowBits'(1) == f_rows_i));
    end
  end
`endif

endmodule

`default_nettype wire
