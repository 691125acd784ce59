// Turns AXI4-Stream video into beats with their position, and watches that every frame has the shape the settings say.
//
// The camera cannot be stalled: s_axis_tready_o is always high. A frame begins with a beat that carries tuser while run_i is
// high; settings are taken over there and nowhere else (not while hold_i is high, and not within six clocks of the last
// take-over, so that headers still being written keep theirs); before the first take-over no frame begins. A frame ends well
// with its last line's tlast. It breaks, and no further beat of it counts, where a line ends early (the beat counts) or late
// (the beat counts), where the next frame starts, or when no beat came for more than timeout_i clocks (0: never). Beats
// outside any frame are discarded and counted. run_i and hold_i count for a beat at the input as they were a clock before it,
// timeout_i, for the pause behind the beat, as it is beside it.
//
// Timing: outputs are registers, two clocks after the beat at the input. break_o is reported after the beats of the
// clocks before it and before the beat of its own clock: a frame's start and the break of the frame before it may share a clock.
`default_nettype none

module sp_frame_tracker #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // AXI4-Stream video: 4 pixels a beat, leftmost in 7..0, tuser = start of frame, tlast = end of line
  input  wire logic                  s_axis_tvalid_i,
  output logic                       s_axis_tready_o,
  input  wire logic [31:0]           s_axis_tdata_i,
  input  wire logic                  s_axis_tuser_i,
  input  wire logic                  s_axis_tlast_i,

  // Settings as written; hold_i is high, besides when asked for, in the first clock of a new columns_i or rows_i and in the two
  // before it
  input  wire logic                  run_i,
  input  wire logic                  hold_i,
  input  wire logic                  image_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic [1:0]            mode_i,
  input  wire logic [7:0]            threshold_i,
  input  wire logic [7:0]            stream_i,
  input  wire logic [23:0]           timeout_i,

  // Settings in force, for the beat beside them
  output logic                       take_o,  // first clock of a take-over
  output logic                       image_o,
  output logic      [ColumnBits-1:0] columns_o,
  output logic      [RowBits-1:0]    rows_o,
  output logic      [1:0]            mode_o,
  output logic      [7:0]            threshold_o,
  output logic      [7:0]            stream_o,
  output logic                       one_group_o,
  output logic                       two_groups_o,

  // Beats
  output logic                       beat_valid_o,
  output logic      [31:0]           beat_pixels_o,
  output logic      [GroupBits-1:0]  beat_group_o,
  output logic      [RowBits-1:0]    beat_row_o,
  output logic                       beat_first_row_o,
  output logic                       beat_last_row_o,
  output logic                       beat_line_start_o,
  output logic                       beat_line_end_o,
  output logic                       frame_start_o,     // this beat is a frame's first
  output logic                       stray_before_o,    // beats were discarded before this frame
  output logic                       last_row_start_o,  // this beat is the first of a frame's last row

  // Breaks
  output logic                       break_o,
  output logic                       break_in_last_row_o,  // the frame's last row had begun
  output logic [sp_spec_pkg::StatusBits-1:0] break_status_o,

  output logic                       frame_open_o,
  output logic      [31:0]           broken_o,  // frames that broke
  output logic      [31:0]           stray_o    // beats discarded while running
);

  assign s_axis_tready_o = 1'b1;

  // --- Settings ---
  // What is asked of the settings as written, known a clock after the write.
  logic                 next_one_q, next_two_q, next_three_q, next_one_row_q, next_two_rows_q, next_three_rows_q;
  logic [GroupBits-1:0] next_groups_m3_q;
  logic [RowBits-1:0]   next_rows_m2_q;
  // and of those in force
  logic [GroupBits-1:0] groups_m3_q;  // groups of a line, less 3
  logic [RowBits-1:0]   rows_m2_q;
  logic                 three_q;   // three groups
  logic                 one_row_q;
  logic                 second_q;  // a frame's second beat is of its last row
  logic                 soon_q;    // the first beat of the row after that is

  always_ff @(posedge clk_i) if (hold_i) begin
    next_one_q        <= columns_i[ColumnBits-1:2] == (ColumnBits - 2)'(1);
    next_two_q        <= columns_i[ColumnBits-1:2] == (ColumnBits - 2)'(2);
    next_one_row_q    <= rows_i == RowBits'(1);
    next_two_rows_q   <= rows_i == RowBits'(2);
    next_three_rows_q <= rows_i == RowBits'(3);
    next_three_q      <= columns_i[ColumnBits-1:2] == (ColumnBits - 2)'(3);
    next_groups_m3_q  <= GroupBits'(columns_i[ColumnBits-1:2] - (ColumnBits - 2)'(3));
    next_rows_m2_q    <= rows_i - RowBits'(2);
  end

  // --- Stage 1: registers of the beat ---
  logic        s1_valid_q, s1_start_q, s1_more_q;  // a beat; one with tuser; one without
  logic        s1_begin_q, s1_take_q;   // one that starts a frame; and takes the settings over
  logic        s1_last_q;
  logic [31:0] s1_pixels_q;
  // Of a frame that starts with it: its line has one group, one or two, three; it has one row, its second beat is of its last, the
  // first beat of the row after that is; the line ends early or late; the frame goes on
  logic        s1_one_q, s1_few_q, s1_three_q, s1_one_row_q, s1_second_q, s1_soon_q, s1_odd_q, s1_stays_q;
  logic        take, one, one_row;  // of a beat with tuser that comes now

  // --- Stage 0: what a beat that comes now may do, from run_i and hold_i a clock ago ---
  logic       may_start_q;
  logic       may_take_q;  // but not in the clock after a take-over
  logic       new_q;       // may_take_q || s1_take_q: a frame that starts now is of the settings as written
  logic [3:0] took_q;      // a take-over so many clocks ago, and one
  logic       in_force_q;  // settings have been taken over: a frame may start without taking them over

  assign take_o = took_q[0];

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      may_start_q <= 1'b0;
      may_take_q  <= 1'b0;
      new_q       <= 1'b0;
      took_q      <= '0;
      in_force_q  <= 1'b0;
    end else begin
      took_q      <= {took_q[2:0], s1_take_q};
      may_take_q  <= run_i && !hold_i && !s1_take_q && took_q == '0;
      new_q       <= run_i && !hold_i && !s1_take_q && took_q == '0 || take;
      may_start_q <= run_i && (in_force_q || s1_take_q || !hold_i);
      if (s1_take_q) in_force_q <= 1'b1;
    end
  end

  // Into stage 1
  assign take    = s_axis_tvalid_i && s_axis_tuser_i && may_take_q && !s1_take_q;
  assign one     = new_q ? next_one_q : one_group_o;
  assign one_row = new_q ? next_one_row_q : one_row_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s1_valid_q <= 1'b0;
      s1_start_q <= 1'b0;
      s1_more_q  <= 1'b0;
      s1_begin_q <= 1'b0;
      s1_take_q  <= 1'b0;
    end else begin
      s1_valid_q <= s_axis_tvalid_i;
      s1_start_q <= s_axis_tvalid_i && s_axis_tuser_i;
      s1_more_q  <= s_axis_tvalid_i && !s_axis_tuser_i;
      s1_begin_q <= s_axis_tvalid_i && s_axis_tuser_i && may_start_q;
      s1_take_q  <= take;
    end
    s1_pixels_q  <= s_axis_tdata_i;
    s1_last_q    <= s_axis_tlast_i;
    if (s_axis_tuser_i) begin
      s1_one_q     <= one;
      s1_few_q     <= new_q ? next_one_q || next_two_q : one_group_o || two_groups_o;
      s1_one_row_q <= one_row;
      s1_second_q  <= new_q ? (next_one_q ? next_two_rows_q : next_one_row_q) : second_q;
      s1_soon_q    <= new_q ? (next_one_q ? next_three_rows_q : next_two_rows_q) : soon_q;
      s1_three_q   <= new_q ? next_three_q : three_q;
      s1_odd_q     <= s_axis_tlast_i != one;
      s1_stays_q   <= one ? s_axis_tlast_i && !one_row : !s_axis_tlast_i;
    end
  end

  always_ff @(posedge clk_i) begin
    if (s1_take_q) begin
      image_o      <= image_i;
      columns_o    <= columns_i;
      rows_o       <= rows_i;
      mode_o       <= mode_i;
      threshold_o  <= threshold_i;
      stream_o     <= stream_i;
      one_group_o  <= next_one_q;
      two_groups_o <= next_two_q;
      groups_m3_q  <= next_groups_m3_q;
      rows_m2_q    <= next_rows_m2_q;
      three_q      <= next_three_q;
      one_row_q    <= next_one_row_q;
      second_q     <= next_one_q ? next_two_rows_q : next_one_row_q;
      soon_q       <= next_one_q ? next_three_rows_q : next_two_rows_q;
    end
  end

  // --- Position of the beat in stage 1 ---
  typedef struct packed {
    logic               is_first;
    logic               is_last;
    logic [RowBits-1:0] number;
  } row_t;

  row_t                 row_q;
  logic                 open_q;           // a frame is being taken
  logic                 in_line_q;        // its line has begun
  logic                 in_last_row_q;    // its last row has begun
  logic [GroupBits-1:0] group_q;          // the next beat's
  logic                 group_is_last_q;
  logic                 timed_out;

  // Whether the group, the row after the next one is the last, known when the one before that came: compared, or, behind a
  // frame's first beat and a line's last, from the size alone.
  typedef struct packed {
    logic compared;
    logic is_known;
    logic known;
  } soon_t;

  soon_t group_soon_q, row_soon_q;

  // What a beat with tuser is judged by needs no word of whether it is taken: then nothing of this counts.
  logic belongs;  // the beat is part of a frame
  logic in_last_row, line_end;
  logic odd_more, more_stays;  // of a beat without tuser: its line ends early or late; the frame goes on

  assign in_last_row = s1_start_q ? s1_one_row_q : row_q.is_last;
  assign belongs     = s1_begin_q || s1_more_q && open_q;
  assign line_end    = s1_last_q && (s1_start_q ? s1_one_q : group_is_last_q);
  assign odd_more    = s1_last_q != group_is_last_q;
  assign more_stays  = group_is_last_q ? s1_last_q && !row_q.is_last : !s1_last_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q        <= 1'b0;
      in_line_q     <= 1'b0;
      in_last_row_q <= 1'b0;
    end else begin
      if (s1_valid_q || timed_out_q) open_q <= s1_begin_q && s1_stays_q || s1_more_q && open_q && more_stays;
      if (s1_valid_q) begin
        in_line_q     <= !s1_last_q;
        in_last_row_q <= in_last_row;
      end
    end
  end

  // Between frames nothing of this counts.
  always_ff @(posedge clk_i) begin
    if (s1_valid_q) begin
      if (s1_start_q) begin
        group_q             <= GroupBits'(!s1_one_q);
        group_is_last_q     <= s1_few_q;
        row_q.number        <= s1_one_q ? RowBits'(2) : RowBits'(1);
        row_q.is_first      <= !s1_one_q;
        row_q.is_last       <= s1_second_q;
        row_soon_q.is_known <= 1'b1;
        row_soon_q.known    <= s1_soon_q;
      end else if (group_is_last_q) begin
        group_q             <= '0;
        group_is_last_q     <= one_group_o;
        row_q.number        <= row_q.number + RowBits'(1);
        row_q.is_first      <= 1'b0;
        row_q.is_last       <= row_soon_q.is_known ? row_soon_q.known : row_soon_q.compared;
        row_soon_q.is_known <= 1'b0;
        row_soon_q.compared <= row_q.number == rows_m2_q;
      end else begin
        group_q             <= group_q + GroupBits'(1);
        group_is_last_q     <= group_soon_q.is_known ? group_soon_q.known : group_soon_q.compared;
      end
      group_soon_q.compared <= group_q == groups_m3_q;
      group_soon_q.is_known <= s1_start_q || group_is_last_q;
      group_soon_q.known    <= s1_start_q ? s1_three_q : two_groups_o;
    end
  end

  // --- Time-out: clocks since the last beat at the input, in two chains, two clocks ahead, one for each register of the
  // comparison ---
  typedef struct packed {
    logic        low_full;
    logic [3:0]  there;     // so many bits are those of limit_q, six by six
    logic [11:0] high;
    logic [11:0] low;
  } pause_t;

  pause_t      pause_q;
  logic [23:0] limit_q;       // timeout_i beside the last beat
  logic        limit_some_q;  // it is not 0, known a clock later
  logic [1:0]  some_q;        // timeout_i, a clock ago, was not 0, in its halves
  logic        timed_out_q;

  always_ff @(posedge clk_i) begin
    some_q <= {timeout_i[23:12] != '0, timeout_i[11:0] != '0};
    if (s1_valid_q) limit_some_q <= some_q != '0;
    timed_out_q <= !s1_valid_q && limit_some_q && pause_q.there == '1;
    if (s_axis_tvalid_i) begin
      limit_q          <= timeout_i;
      pause_q.low_full <= 1'b0;
      pause_q.there    <= '0;
      pause_q.high     <= '0;
      pause_q.low      <= 12'd1;
    end else begin
      pause_q.low_full <= pause_q.low == 12'hFFE;
      pause_q.low      <= pause_q.low + 12'd1;
      if (pause_q.low_full) pause_q.high <= pause_q.high + 12'd1;
      pause_q.there[0] <= pause_q.low[5:0] == limit_q[5:0];
      pause_q.there[1] <= pause_q.low[11:6] == limit_q[11:6];
      pause_q.there[2] <= pause_q.high[5:0] == limit_q[17:12];
      pause_q.there[3] <= pause_q.high[11:6] == limit_q[23:18];
    end
  end

  assign timed_out = timed_out_q && open_q && !s1_valid_q;

  // --- Stage 2: outputs ---
  logic stray_q;
  logic stray, stray_now_q;  // the beat is discarded while running
  logic start_breaks;  // a start ends an open frame
  logic late_break;    // a line or a pause ends it
  logic late_break_q;
  logic late_valid_q, late_last_q;  // there was a beat a clock ago, with tlast

  assign stray        = run_i && (s1_start_q && !s1_begin_q || s1_more_q && !open_q);
  assign start_breaks = s1_start_q && open_q;
  assign late_break   = s1_begin_q && s1_odd_q || s1_more_q && open_q && odd_more || timed_out;

  // Reset lasts long enough for these to follow.
  always_ff @(posedge clk_i) begin
    beat_valid_o     <= belongs;
    frame_start_o    <= s1_begin_q;
    last_row_start_o <= belongs && in_last_row && (s1_start_q || !in_line_q);
    late_break_q     <= late_break;
    break_o          <= start_breaks || late_break_q;
    stray_now_q      <= stray;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      stray_q        <= 1'b0;
      stray_before_o <= 1'b0;
    end else if (s1_begin_q) begin
      stray_before_o <= stray_q || stray_now_q;
      stray_q        <= 1'b0;
    end else if (stray_now_q) begin
      stray_q <= 1'b1;
    end
  end

  // Fields of a beat count with beat_valid_o, those of a break with late_break_q.
  always_ff @(posedge clk_i) begin
    beat_pixels_o     <= s1_pixels_q;
    beat_group_o      <= s1_start_q ? '0 : group_q;
    beat_row_o        <= s1_start_q ? RowBits'(1) : row_q.number;
    beat_first_row_o  <= s1_start_q || row_q.is_first;
    beat_last_row_o   <= in_last_row;
    beat_line_start_o <= s1_start_q || !in_line_q;
    beat_line_end_o   <= line_end;
    late_valid_q      <= s1_valid_q;
    late_last_q       <= s1_last_q;
    if (start_breaks || late_break_q) begin
      break_in_last_row_o <= in_last_row_q;
      break_status_o      <= '0;
      break_status_o[sp_spec_pkg::StatusStartInFrameBit] <= !late_break_q;
      break_status_o[sp_spec_pkg::StatusShortLineBit]    <= late_break_q && late_valid_q && late_last_q;
      break_status_o[sp_spec_pkg::StatusLongLineBit]     <= late_break_q && late_valid_q && !late_last_q;
      break_status_o[sp_spec_pkg::StatusIncompleteBit]   <= late_break_q && !late_valid_q;
    end
  end

  // --- Counters ---
  sp_counter u_broken (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (break_o),
    .count_o(broken_o)
  );

  sp_counter u_stray (
    .clk_i  (clk_i),
    .rst_i  (rst_i),
    .inc_i  (stray_now_q),
    .count_o(stray_o)
  );

  assign frame_open_o = open_q;

`ifdef FORMAL
  // Reset once, at the beginning, for four clocks.
  logic [3:0] f_reset_q = 4'd0;
  logic       f_ran_q;
  assign f_ran_q = f_reset_q[3];
  always_ff @(posedge clk_i) f_reset_q <= {f_reset_q[2:0], 1'b1};
  always_comb assume (rst_i == !f_ran_q);
  // Settings are sizes that the maxima allow; a new size is announced by hold_i two clocks before (sp_registers does both).
  always_comb begin
    assume (columns_i[1:0] == 2'd0 && columns_i != '0 && columns_i <= ColumnBits'(MaxColumns));
    assume (rows_i != '0 && rows_i <= RowBits'(MaxRows));
  end
  logic [ColumnBits-1:0] f_columns_before_q;
  logic [RowBits-1:0]    f_rows_before_q;
  logic                  f_after_reset_q;
  logic [3:1]            f_hold_q;  // so many clocks ago
  always_ff @(posedge clk_i) begin
    {f_columns_before_q, f_rows_before_q, f_after_reset_q} <= {columns_i, rows_i, rst_i};
    f_hold_q <= rst_i ? 3'b111 : {f_hold_q[2:1], hold_i};
  end
  always_comb begin
    if (f_after_reset_q || rst_i) assume (hold_i);
    else if (columns_i != f_columns_before_q || rows_i != f_rows_before_q) assume (hold_i && f_hold_q[2:1] == 2'b11);
  end

  // What was taken over, kept here a second time.
  logic                  f_known_q;
  logic [ColumnBits-1:0] f_columns_q;
  logic [RowBits-1:0]    f_rows_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_known_q <= 1'b0;
    else if (s1_take_q) {f_known_q, f_columns_q, f_rows_q} <= {1'b1, columns_i, rows_i};
  end

  // Clocks since a take-over, up to 7.
  logic [2:0] f_since_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_since_q <= 3'd7;
    else if (take_o) f_since_q <= 3'd1;
    else if (f_since_q != 3'd7) f_since_q <= f_since_q + 3'd1;
  end

  // Rule 1: settings change at a frame's start and nowhere else, and not while they are held.
  // Rule 2: six clocks at least lie between two take-overs.
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if (!($stable(columns_o) && $stable(rows_o) && $stable(mode_o) && $stable(threshold_o) && $stable(stream_o) &&
          $stable(image_o))) begin
      assert (frame_start_o && take_o && !f_hold_q[3]);
    end
    if (take_o) assert (f_since_q == 3'd7);
    cover (take_o && f_known_q && !$stable(columns_o));
  end

  // Rule 3: a frame that began has ended well, has broken, or is open: nothing else becomes of it.
  logic [3:0] f_started_q, f_good_q, f_broken_q;  // modulo 16
  logic       f_counting_q;                       // a break is in the counter, and it does not tell it yet
  logic       f_frame_end;
  assign f_frame_end = belongs && line_end && in_last_row;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_started_q, f_good_q, f_broken_q, f_counting_q} <= '0;
    else begin
      f_counting_q <= break_o;
      f_started_q <= f_started_q + 4'(s1_begin_q);
      f_good_q    <= f_good_q + 4'(f_frame_end);
      f_broken_q  <= f_broken_q + 4'(break_o);
    end
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_started_q == f_good_q + f_broken_q + 4'(open_q) + 4'(break_o) + 4'(late_break_q));
    assert (f_broken_q == broken_o[3:0] + 4'(f_counting_q));
    assert (f_known_q == in_force_q);
    if (open_q || took_q != '0 || may_start_q && !may_take_q || s1_begin_q && !s1_take_q) assert (in_force_q);
    if (s1_take_q) assert (s1_begin_q);
    assert (take_o == took_q[0]);
    for (int k = 1; k < 4; k++) assert (took_q[k] == (f_since_q == 3'(k)));
    if (may_take_q || s1_take_q) assert (took_q == '0);
    assert (new_q == (may_take_q || s1_take_q));
    if (may_take_q) assert (f_since_q >= 3'd5);
    if (s1_take_q) assert (f_since_q >= 3'd6);
    assert (s1_valid_q == (s1_start_q || s1_more_q) && !(s1_start_q && s1_more_q));
    // A break is of one frame: the late ones and that of a start never meet.
    assert (!(late_break_q && start_breaks));
    if (late_break_q) assert (!open_q);
  end

  // Rule 4: beats of a frame lie inside it: rows 1 to rows_o, groups below columns_o / 4.
  always_comb if (f_ran_q && !rst_i) begin
    if (in_force_q) assert (f_columns_q == columns_o && f_rows_q == rows_o);
    if (open_q) begin
      assert (row_q.number >= RowBits'(1) && row_q.number <= rows_o);
      assert (row_q.is_first == (row_q.number == RowBits'(1)));
      assert (row_q.is_last == (row_q.number == rows_o));
      assert ((ColumnBits)'(group_q) < columns_o >> 2);
      assert (group_is_last_q == ((ColumnBits)'(group_q) == (columns_o >> 2) - ColumnBits'(1)));
      if (!group_is_last_q) begin
        assert ((group_soon_q.is_known ? group_soon_q.known : group_soon_q.compared) ==
                ((ColumnBits)'(group_q) + ColumnBits'(2) == columns_o >> 2));
      end
      if (!row_q.is_last) begin
        assert ((row_soon_q.is_known ? row_soon_q.known : row_soon_q.compared) == (row_q.number + RowBits'(1) == rows_o));
      end
    end
    if (s1_start_q) begin
      assert (s1_one_q == (s1_take_q ? next_one_q : one_group_o) && s1_one_row_q == (s1_take_q ? next_one_row_q : one_row_q));
      assert (s1_few_q == (s1_take_q ? next_one_q || next_two_q : one_group_o || two_groups_o));
      assert (s1_second_q == (s1_take_q ? (next_one_q ? next_two_rows_q : next_one_row_q) : second_q));
      assert (s1_soon_q == (s1_take_q ? (next_one_q ? next_three_rows_q : next_two_rows_q) : soon_q));
      assert (s1_three_q == (s1_take_q ? next_three_q : three_q));
      assert (s1_odd_q == (s1_last_q != s1_one_q) && s1_stays_q == (s1_one_q ? s1_last_q && !s1_one_row_q : !s1_last_q));
    end
    if (!hold_i || !f_hold_q[1] || !f_hold_q[2]) begin
      assert (next_one_q == (columns_i == ColumnBits'(4)));
      assert (next_two_q == (columns_i == ColumnBits'(8)));
      assert (next_one_row_q == (rows_i == RowBits'(1)));
      assert (next_two_rows_q == (rows_i == RowBits'(2)));
      assert (next_three_q == (columns_i == ColumnBits'(12)));
      assert (next_three_rows_q == (rows_i == RowBits'(3)));
      assert (next_groups_m3_q == GroupBits'((columns_i >> 2) - ColumnBits'(3)));
      assert (next_rows_m2_q == rows_i - RowBits'(2));
    end
    if (in_force_q) begin
      assert (columns_o[1:0] == 2'd0 && columns_o != '0 && columns_o <= ColumnBits'(MaxColumns));
      assert (rows_o != '0 && rows_o <= RowBits'(MaxRows));
      assert (one_group_o == (columns_o == ColumnBits'(4)));
      assert (two_groups_o == (columns_o == ColumnBits'(8)));
      assert (one_row_q == (rows_o == RowBits'(1)));
      assert (second_q == (rows_o == (columns_o == ColumnBits'(4) ? RowBits'(2) : RowBits'(1))));
      assert (soon_q == (rows_o == (columns_o == ColumnBits'(4) ? RowBits'(3) : RowBits'(2))));
      assert (three_q == (columns_o == ColumnBits'(12)));
      assert (rows_m2_q == rows_o - RowBits'(2));
      assert (groups_m3_q == GroupBits'((columns_o >> 2) - ColumnBits'(3)));
    end
    cover (f_frame_end && rows_o == RowBits'(2) && columns_o == ColumnBits'(8));
  end
`endif

endmodule

`default_nettype wire
