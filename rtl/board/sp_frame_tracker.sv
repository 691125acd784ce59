// Turns AXI4-Stream video into beats with their position, and checks the shape of every frame.
//
// The camera cannot be stalled: s_axis_tready_o is always high. A frame begins with a beat that
// carries tuser while run_i is high. Only such a beat takes settings over, and not while hold_i is
// high or within six clocks of the last take-over (headers still being written keep theirs). No
// frame begins before the first take-over. A frame ends well with the tlast of its last line. It
// breaks, and its later beats do not count, when a line ends early or late (that beat still
// counts), when the next frame starts, or after timeout_i clocks without a beat (0: never). Beats
// outside any frame are discarded and counted. run_i and hold_i count as they were one clock before
// a beat; timeout_i counts as it is beside the beat that a pause follows.
//
// Guarantees: each frame that begins either ends well or is reported once by break_o. Beats lie
// inside their frame. Both counters wrap. Latency: outputs are registers, two clocks after the beat
// at the input. A break by a line or a pause comes one clock later, a break by the next start in
// the clock of that start. So break_o comes after the beats of earlier clocks and before the beat
// of its own clock. Two rows of two groups, then a frame whose first line ends late in beat 6, and
// beat 7 outside any frame:
//
//   clock              0   1   2   3   4   5   6   7   8   9
//   s_axis_tvalid_i   _/1\_/2\_/3\_/4\_/5\_/6\_/7\____________
//   s_axis_tuser_i    _/1\_____________/5\____________________
//   s_axis_tlast_i    _____/2\_____/4\_________/7\____________
//   stage 1           ----< 1 < 2 < 3 < 4 < 5 < 6 < 7 >-------
//   open_q            _________/11111111111\___/111\____________   between first and last beat
//   frame_start_o     _________/1\_____________/5\____________
//   take_o            _________/1\____________________________   5 comes too soon for new settings
//   beat_valid_o      _________/1\_/2\_/3\_/4\_/5\_/6\________
//   last_row_start_o  _________________/3\____________________
//   break_o           _________________________________/6\____   long line
`default_nettype none

module sp_frame_tracker #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4, 12..4096; with more lanes of Lanes, from 3 Lanes on
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Region = 1'b1,  // hand region_i on; else region_o is 0
  parameter bit Compact = 1'b0,  // hand compact_i on; else compact_o is 0
  parameter bit Verdict = 1'b0,  // hand verdict_i on; else verdict_o is 0
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / Lanes),
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // AXI4-Stream video: Lanes pixels per beat, leftmost lowest; tuser starts a frame, tlast ends a line
  input  wire logic                  s_axis_tvalid_i,
  output logic                       s_axis_tready_o,
  input  wire logic [Lanes*PixelBits-1:0] s_axis_tdata_i,
  input  wire logic                  s_axis_tuser_i,
  input  wire logic                  s_axis_tlast_i,

  // Settings as written, read in the clock of taking_o; run_i and timeout_i in every clock. hold_i
  // is high in the first clock of a new size and in the two before.
  input  wire logic                  run_i,
  input  wire logic                  hold_i,
  input  wire logic                  image_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic [1:0]            mode_i,
  input  wire logic [PixelBits-1:0]  threshold_i,
  input  wire logic [7:0]            stream_i,
  input  wire logic [2*RowBits+2:0]  select_i,  // as in sp_registers
  input  wire logic [31:0]           region_i,  // as in sp_registers
  input  wire logic                  compact_i,
  input  wire logic [2:0]            verdict_i,  // {on, packets} of the register verdict_control
  input  wire logic [23:0]           timeout_i,

  output logic                       taking_o,  // one clock before take_o: the settings are taken
  // Settings in force, for the beat beside them
  output logic                       take_o,    // first clock of a take-over
  output logic                       image_o,
  output logic      [ColumnBits-1:0] columns_o,
  output logic      [RowBits-1:0]    rows_o,
  output logic      [1:0]            mode_o,
  output logic      [PixelBits-1:0]  threshold_o,
  output logic      [7:0]            stream_o,
  output logic      [2*RowBits+2:0]  select_o,
  output logic      [31:0]           region_o,
  output logic                       compact_o,
  output logic      [2:0]            verdict_o,
  output logic                       one_group_o,
  output logic                       two_groups_o,

  // Beats
  output logic                       beat_valid_o,
  output logic      [Lanes*PixelBits-1:0] beat_pixels_o,
  output logic      [GroupBits-1:0]  beat_group_o,
  output logic      [RowBits-1:0]    beat_row_o,
  output logic                       beat_first_row_o,
  output logic                       beat_last_row_o,
  output logic                       beat_line_start_o,
  output logic                       beat_line_end_o,
  output logic                       frame_start_o,     // first beat of a frame
  output logic                       stray_before_o,    // beats were discarded before this frame
  output logic                       last_row_start_o,  // first beat of the last row of a frame

  // Breaks
  output logic                       break_o,
  output logic                       break_in_last_row_o,  // the last row of the frame had begun
  output logic [sp_spec_pkg::StatusBits-1:0] break_status_o,

  output logic                       frame_open_o,
  output logic      [31:0]           broken_o,  // frames that broke
  output logic      [31:0]           stray_o    // beats discarded while running
);

  if (MaxColumns < 3 * Lanes || MaxColumns > sp_spec_pkg::ColumnLimit || MaxColumns % Lanes != 0)
  begin : gen_max_columns
    max_columns_is_not_a_multiple_of_lanes_in_3_lanes_to_4096 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (MaxRows < 2 || MaxRows > sp_spec_pkg::RowLimit) begin : gen_max_rows
    max_rows_is_not_in_2_to_2047 u_error ();
  end

  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  assign s_axis_tready_o = 1'b1;

  // --- Stage 0: what a beat may do now, from run_i and hold_i one clock ago ---
  logic       may_start_q;
  logic       may_take_q;  // but not in the clock after a take-over
  logic       new_q;       // a frame that starts now has the settings as written
  logic [3:0] took_q;      // a take-over one to four clocks ago, the latest lowest
  logic       in_force_q;  // there was a take-over: frames may start without another
  logic       take;        // this beat takes the settings over
  logic       s1_take_q;   // the beat in stage 1 has taken them over

  assign taking_o = s1_take_q;
  assign take_o   = took_q[0];
  assign take     = s_axis_tvalid_i && s_axis_tuser_i && may_take_q && !s1_take_q;

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

  // --- Stage 1: registers of the beat ---
  logic        s1_valid_q, s1_last_q;     // a beat; its tlast
  logic        s1_start_q, s1_further_q;  // a beat with tuser, without tuser
  logic        s1_begin_q;                // a beat that starts a frame
  logic [Lanes*PixelBits-1:0] s1_pixels_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s1_valid_q   <= 1'b0;
      s1_start_q   <= 1'b0;
      s1_further_q <= 1'b0;
      s1_begin_q   <= 1'b0;
      s1_take_q    <= 1'b0;
    end else begin
      s1_valid_q   <= s_axis_tvalid_i;
      s1_start_q   <= s_axis_tvalid_i && s_axis_tuser_i;
      s1_further_q <= s_axis_tvalid_i && !s_axis_tuser_i;
      s1_begin_q   <= s_axis_tvalid_i && s_axis_tuser_i && may_start_q;
      s1_take_q    <= take;
    end
    s1_pixels_q <= s_axis_tdata_i;
    s1_last_q   <= s_axis_tlast_i;
  end

  always_ff @(posedge clk_i) begin
    if (s1_take_q) begin
      image_o     <= image_i;
      mode_o      <= mode_i;
      threshold_o <= threshold_i;
      stream_o    <= stream_i;
      select_o    <= select_i;
    end
  end

  if (Region) begin : gen_region
    always_ff @(posedge clk_i) if (s1_take_q) region_o <= region_i;
  end else begin : gen_no_region
    logic unused;

    assign region_o = 32'd0;
    assign unused   = ^region_i;
  end
  if (Compact) begin : gen_compact
    always_ff @(posedge clk_i) if (s1_take_q) compact_o <= compact_i;
  end else begin : gen_no_compact
    logic unused;

    assign compact_o = 1'b0;
    assign unused    = compact_i;
  end

  if (Verdict) begin : gen_verdict
    always_ff @(posedge clk_i) if (s1_take_q) verdict_o <= verdict_i;
  end else begin : gen_no_verdict
    logic unused;

    assign verdict_o = 3'd0;
    assign unused    = ^verdict_i;
  end

  // --- Size: facts in force, and facts of a frame that starts with the beat in stage 1 (s1_) ---
  logic s1_one_group, s1_three_groups, s1_one_row, s1_next_ends_line, s1_next_in_last_row;
  logic s1_row_after_is_last, s1_wrong_length, s1_goes_on;
  logic [GroupBits-1:0] groups_less_3;
  logic [RowBits-1:0]   rows_less_2;

  sp_frame_size #(
    .GroupBits (GroupBits),
    .ColumnBits(ColumnBits),
    .RowBits   (RowBits),
    .Lanes     (Lanes)
  ) u_size (
    .clk_i                    (clk_i),
    .hold_i                   (hold_i),
    .columns_i                (columns_i),
    .rows_i                   (rows_i),
    .take_i                   (s1_take_q),
    .columns_o                (columns_o),
    .rows_o                   (rows_o),
    .one_group_o              (one_group_o),
    .two_groups_o             (two_groups_o),
    .groups_less_3_o          (groups_less_3),
    .rows_less_2_o            (rows_less_2),
    .tuser_i                  (s_axis_tuser_i),
    .tlast_i                  (s_axis_tlast_i),
    .new_i                    (new_q),
    .start_one_group_o        (s1_one_group),
    .start_three_groups_o     (s1_three_groups),
    .start_one_row_o          (s1_one_row),
    .start_next_ends_line_o   (s1_next_ends_line),
    .start_next_in_last_row_o (s1_next_in_last_row),
    .start_row_after_is_last_o(s1_row_after_is_last),
    .start_wrong_length_o     (s1_wrong_length),
    .start_goes_on_o          (s1_goes_on)
`ifdef FORMAL
    ,
    .f_start_i                (s1_start_q),
    .f_in_force_i             (in_force_q)
`endif
  );

  // --- Position of the beat in stage 1, unless it starts a frame ---
  logic [GroupBits-1:0] group;
  logic [RowBits-1:0]   row;
  logic                 group_is_last, row_is_first, row_is_last;
  logic                 open_q;  // a frame is open: beats without tuser belong to it
`ifdef FORMAL
  logic f_ran_q;
`endif

  sp_frame_position #(
    .GroupBits(GroupBits),
    .RowBits  (RowBits)
  ) u_position (
    .clk_i                    (clk_i),
    .beat_i                   (s1_valid_q),
    .start_i                  (s1_start_q),
    .start_one_group_i        (s1_one_group),
    .start_next_ends_line_i   (s1_next_ends_line),
    .start_three_groups_i     (s1_three_groups),
    .start_next_in_last_row_i (s1_next_in_last_row),
    .start_row_after_is_last_i(s1_row_after_is_last),
    .one_group_i              (one_group_o),
    .two_groups_i             (two_groups_o),
    .groups_less_3_i          (groups_less_3),
    .rows_less_2_i            (rows_less_2),
    .group_o                  (group),
    .group_is_last_o          (group_is_last),
    .row_o                    (row),
    .row_is_first_o           (row_is_first),
    .row_is_last_o            (row_is_last)
`ifdef FORMAL
    ,
    .f_open_i                 (open_q && f_ran_q && !rst_i),
    .f_columns_i              ((GroupBits + 3)'(columns_o >> ($clog2(Lanes) - 2))),
    .f_rows_i                 (rows_o)
`endif
  );

  // --- State of the frame; for a beat with tuser that is not accepted, none of it counts ---
  logic in_line_q;      // its line has begun
  logic in_last_row_q;  // its last row has begun
  logic belongs;        // the beat belongs to a frame
  logic in_last_row, line_end;
  logic wrong_length, goes_on;  // without tuser: the line ends early or late; the frame goes on
  logic pause_over, timed_out;  // no beat came for too long; this ends a frame

  assign in_last_row  = s1_start_q ? s1_one_row : row_is_last;
  assign belongs      = s1_begin_q || s1_further_q && open_q;
  assign line_end     = s1_last_q && (s1_start_q ? s1_one_group : group_is_last);
  assign wrong_length = s1_last_q ^ group_is_last;
  assign goes_on      = group_is_last ? s1_last_q && !row_is_last : !s1_last_q;
  assign timed_out    = pause_over && open_q && !s1_valid_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      open_q        <= 1'b0;
      in_line_q     <= 1'b0;
      in_last_row_q <= 1'b0;
    end else begin
      if (s1_valid_q || pause_over) open_q <= s1_begin_q ? s1_goes_on :
                                              s1_further_q && open_q && goes_on;
      if (s1_valid_q) begin
        in_line_q     <= !s1_last_q;
        in_last_row_q <= in_last_row;
      end
    end
  end

  sp_frame_timeout u_timeout (
    .clk_i    (clk_i),
    .beat_i   (s_axis_tvalid_i),
    .beat1_i  (s1_valid_q),
    .timeout_i(timeout_i),
    .expired_o(pause_over)
  );

  // --- Stage 2: outputs ---
  logic stray_q;              // a beat was discarded since the last frame start
  logic stray, stray_now_q;   // this beat is discarded while running; the last one was
  logic start_breaks;         // a start ends an open frame
  logic late_break, late_break_q;   // a line or a pause ends it; it did one clock ago
  logic late_valid_q, late_last_q;  // there was a beat one clock ago; it had tlast

  assign stray        = run_i && (s1_start_q && !s1_begin_q || s1_further_q && !open_q);
  assign start_breaks = s1_start_q && open_q;
  assign late_break   = s1_begin_q && s1_wrong_length || s1_further_q && open_q && wrong_length ||
                        timed_out;

  // These need no reset of their own: reset lasts long enough.
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
    beat_group_o      <= s1_start_q ? '0 : group;
    beat_row_o        <= s1_start_q ? RowBits'(1) : row;
    beat_first_row_o  <= s1_start_q || row_is_first;
    beat_last_row_o   <= in_last_row;
    beat_line_start_o <= s1_start_q || !in_line_q;
    beat_line_end_o   <= line_end;
    late_valid_q      <= s1_valid_q;
    late_last_q       <= s1_last_q;
    if (start_breaks || late_break_q) begin
      break_in_last_row_o <= in_last_row_q;
      break_status_o <= '0;
      break_status_o[sp_spec_pkg::StatusStartInFrameBit] <= !late_break_q;
      break_status_o[sp_spec_pkg::StatusShortLineBit] <=
          late_break_q && late_valid_q && late_last_q;
      break_status_o[sp_spec_pkg::StatusLongLineBit] <=
          late_break_q && late_valid_q && !late_last_q;
      break_status_o[sp_spec_pkg::StatusIncompleteBit] <= late_break_q && !late_valid_q;
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
  // One reset at the beginning, for four clocks.
  logic [3:0] f_reset_q = 4'd0;
  assign f_ran_q = f_reset_q[3];
  always_ff @(posedge clk_i) f_reset_q <= {f_reset_q[2:0], 1'b1};
  always_comb assume (rst_i == !f_ran_q);
  // Sizes are within the maxima; hold_i announces a new size two clocks before (sp_registers).
  always_comb begin
    assume (columns_i[$clog2(Lanes)-1:0] == '0 && columns_i != '0 && columns_i <= ColumnBits'(MaxColumns));
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
    else if (columns_i != f_columns_before_q || rows_i != f_rows_before_q)
      assume (hold_i && f_hold_q[2:1] == 2'b11);
  end

  logic                  f_known_q;  // the next two: a second copy of what was taken over
  logic [ColumnBits-1:0] f_columns_q;
  logic [RowBits-1:0]    f_rows_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_known_q <= 1'b0;
    else if (s1_take_q) {f_known_q, f_columns_q, f_rows_q} <= {1'b1, columns_i, rows_i};
  end

  // Clocks since a take-over, up to 7
  logic [2:0] f_since_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_since_q <= 3'd7;
    else if (take_o) f_since_q <= 3'd1;
    else if (f_since_q != 3'd7) f_since_q <= f_since_q + 3'd1;
  end

  // Rule 1: settings change only at a frame start, and not while they are held.
  // Rule 2: at least six clocks lie between two take-overs.
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if (!($stable(columns_o) && $stable(rows_o) && $stable(mode_o) && $stable(threshold_o) &&
          $stable(stream_o) && $stable(select_o) && $stable(image_o))) begin
      assert (frame_start_o && take_o && !f_hold_q[3]);
    end
    if (take_o) assert (f_since_q == 3'd7);
    cover (take_o && f_known_q && !$stable(columns_o));
  end

  // Rule 3: a frame that began has ended well, has broken, or is open.
  logic [3:0] f_started_q, f_good_q, f_broken_q;  // modulo 16
  logic       f_counting_q;                       // a break that the counter does not show yet
  logic       f_frame_end;
  assign f_frame_end = belongs && line_end && in_last_row;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_started_q, f_good_q, f_broken_q, f_counting_q} <= '0;
    else begin
      f_counting_q <= break_o;
      f_started_q  <= f_started_q + 4'(s1_begin_q);
      f_good_q     <= f_good_q + 4'(f_frame_end);
      f_broken_q   <= f_broken_q + 4'(break_o);
    end
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_started_q == f_good_q + f_broken_q + 4'(open_q) + 4'(break_o) + 4'(late_break_q));
    assert (f_broken_q == broken_o[3:0] + 4'(f_counting_q));
    assert (f_known_q == in_force_q);
    if (open_q || took_q != '0 || may_start_q && !may_take_q || s1_begin_q && !s1_take_q)
      assert (in_force_q);
    if (s1_take_q) assert (s1_begin_q);
    assert (take_o == took_q[0]);
    for (int k = 1; k < 4; k++) assert (took_q[k] == (f_since_q == 3'(k)));
    if (may_take_q || s1_take_q) assert (took_q == '0);
    assert (new_q == (may_take_q || s1_take_q));
    if (may_take_q) assert (f_since_q >= 3'd5);
    if (s1_take_q) assert (f_since_q >= 3'd6);
    assert (s1_valid_q == (s1_start_q || s1_further_q) && !(s1_start_q && s1_further_q));
    // A break belongs to one frame: a late break and a break by a start never meet.
    assert (!(late_break_q && start_breaks));
    if (late_break_q) assert (!open_q);
  end

  // Rule 4: beats lie inside their frame: rows 1 to rows_o, groups below columns_o / 4.
  always_comb if (f_ran_q && !rst_i) begin
    if (in_force_q) assert (f_columns_q == columns_o && f_rows_q == rows_o);
    if (in_force_q) begin
      assert (columns_o[$clog2(Lanes)-1:0] == '0 && columns_o != '0 && columns_o <= ColumnBits'(MaxColumns));
      assert (rows_o != '0 && rows_o <= RowBits'(MaxRows));
    end
    cover (f_frame_end && rows_o == RowBits'(2) && columns_o == ColumnBits'(8));
  end

  // Rule 5: a beat that comes while running and belongs to no frame is counted, and the next frame
  // that begins tells of it.
  logic       f_stray, f_stray_q, f_told_q;  // now; since the last start; before the last start
  logic [3:0] f_strays_q;                    // modulo 16
  logic       f_stray_counting_q;
  assign f_stray = s1_valid_q && run_i && !belongs;
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_stray_q, f_told_q, f_strays_q, f_stray_counting_q} <= '0;
    else begin
      f_stray_q          <= !s1_begin_q && (f_stray || f_stray_q);
      if (s1_begin_q) f_told_q <= f_stray_q;
      f_strays_q         <= f_strays_q + 4'(stray_now_q);
      f_stray_counting_q <= stray_now_q;
    end
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (stray_before_o == f_told_q);
    assert (f_stray_q == (stray_q || stray_now_q));
    assert (f_strays_q == stray_o[3:0] + 4'(f_stray_counting_q));
  end
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) assert (stray_now_q == $past(f_stray));
`endif

endmodule

`default_nettype wire
