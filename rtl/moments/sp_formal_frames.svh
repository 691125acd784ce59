// For proofs of sp_column_moments and sp_column_runs, within them: the frames that go in, any one
// column of any one frame that is wanted, and its word where it comes out.
//
// Assumptions: one reset at the beginning; frames of one size, and of one mode, or with Changes of
// two: that of the frame with the column, and that of the others; beats in order, with any gaps; no
// frame breaks. A packet whose frame does not go through the drain is always wanted. Else at least
// FWait + 1 clocks lie between the end of a last row and the next last row that is wanted
// (sp_packetizer keeps more than 16); any unwanted frames may come between. With Changes
// FChangeWait + 1 clocks lie before every frame that is wanted. (sp_packetizer takes none until
// seven clocks after the last payload beat of the one before.)
//
// The module says PixelBits, FWait, FChangeWait, and FBinaryDrains: whether mode binary of a grey
// build goes through the drain.
  parameter bit [PixelBits-1:0] ValueBits = {PixelBits{1'b1}};  // bits that pixels and threshold have
  parameter bit Changes = 1'b0;  // the other frames have another mode and threshold
  localparam int FLaneBits = $clog2(Lanes);
  localparam int FSumBits = 16;  // hold every sum of the sizes that are proved
  logic f_ran_q = 1'b0, f_run;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  assign f_run = f_ran_q && !rst_i;

  // The frames
  (* anyconst *) logic [RowBits-1:0]   f_rows;
  (* anyconst *) logic [GroupBits-1:0] f_last_group;
  (* anyconst *) logic [1:0]           f_mode, f_other_mode;
  (* anyconst *) logic [PixelBits-1:0] f_threshold, f_other_threshold;
  (* anyconst *) logic [4:0]           f_frame;
  (* anyseq *) logic                   f_choice;
  logic [GroupBits-1:0] f_group_q;
  logic [RowBits-1:0]   f_row_q;
  logic                 f_line_end, f_last_row, f_grey;
  logic                 f_this;      // the frame that goes in has the column
  logic                 f_grey_now;  // of the frame that goes in
  logic [4:0]           f_wait_q;
  logic                 f_decides, f_wanted, f_wanted_q;  // a last row begins; its packet is wanted
  logic [4:1]           f_accept_q;
  // Wide enough for a bounded trace: frames that ended; frames wanted, in all and before this one;
  // frames that came out.
  logic [5:0]           f_ended_q, f_wants_q, f_before_q, f_out_q;
  assign f_grey     = f_mode != sp_spec_pkg::ModeBinary;
  assign f_this     = f_ended_q == 6'(f_frame);
  assign f_grey_now = (f_this ? f_mode : f_other_mode) != sp_spec_pkg::ModeBinary;
  assign f_line_end = f_group_q == f_last_group;
  assign f_last_row = f_row_q == f_rows;
  assign f_decides  = beat_valid_i && f_last_row && f_group_q == '0;
  assign f_wanted   = f_decides ? !Grey || !FBinaryDrains && !f_grey_now && !Changes ||
                                  f_choice && f_wait_q == '0 :
                      f_wanted_q;
  always_ff @(posedge clk_i) begin
    f_wanted_q <= f_wanted;
    f_accept_q <= {f_accept_q[3:1], f_wanted};
    if (rst_i) f_wait_q <= '0;
    else if (beat_valid_i && f_last_row && f_wanted) begin
      f_wait_q <= Changes ? 5'(FChangeWait) : 5'(FWait);
    end
    else if (f_wait_q != '0) f_wait_q <= f_wait_q - 5'd1;
    if (rst_i) {f_group_q, f_row_q} <= {GroupBits'(0), RowBits'(1)};
    else if (beat_valid_i) begin
      f_group_q <= f_line_end ? '0 : f_group_q + GroupBits'(1);
      if (f_line_end) f_row_q <= f_last_row ? RowBits'(1) : f_row_q + RowBits'(1);
    end
    if (rst_i) {f_ended_q, f_wants_q, f_before_q} <= '0;
    else begin
      if (f_decides && f_wanted) begin
        f_wants_q <= f_wants_q + 6'd1;
        if (f_ended_q < 6'(f_frame)) f_before_q <= f_before_q + 6'd1;
      end
      if (beat_valid_i && f_line_end && f_last_row) f_ended_q <= f_ended_q + 6'd1;
    end
  end
  always_comb begin
    assume (rst_i == !f_ran_q);
    assume (f_rows != '0 && f_rows <= RowBits'(MaxRows) &&
            f_last_group < (GroupBits + 1)'(MaxColumns / Lanes));
    assume (beat_group_i == f_group_q && beat_row_i == f_row_q &&
            beat_first_row_i == (f_row_q == RowBits'(1)));
    assume (beat_last_row_i == f_last_row && beat_line_end_i == f_line_end);
    if (!Changes) assume (f_other_mode == f_mode && f_other_threshold == f_threshold);
    assume (mode_i == (f_this ? f_mode : f_other_mode) &&
            mode_i <= (Grey ? sp_spec_pkg::ModeGreyOver : sp_spec_pkg::ModeBinary));
    assume (f_mode <= (Grey ? sp_spec_pkg::ModeGreyOver : sp_spec_pkg::ModeBinary));
    assume ((beat_pixels_i & ~{Lanes{ValueBits}}) == '0 &&
            ((f_threshold | f_other_threshold) & ~ValueBits) == '0);
    if (f_decides && f_this) assume (f_wanted);
    assume (threshold_i == (f_this ? f_threshold : f_other_threshold) && !break_i &&
            accept_i == f_accept_q[4]);
  end

  // The column
  (* anyconst *) logic [FLaneBits-1:0] f_lane;
  (* anyconst *) logic [GroupBits-1:0] f_group;
  logic [PixelBits-1:0] f_pixel;
  logic                f_mine, f_lit;  // a beat that has the column; its pixel is lit
  logic [FSumBits-1:0] f_weight, f_row_weight;  // of the pixel; times the row
  assign f_pixel  = beat_pixels_i[PixelBits*f_lane+:PixelBits];
  assign f_lit    = f_pixel > f_threshold;
  assign f_weight = !f_lit ? '0 : !f_grey ? FSumBits'(1) :
                    f_mode == sp_spec_pkg::ModeGrey ? FSumBits'(f_pixel) :
                        FSumBits'(f_pixel) - FSumBits'(f_threshold);
  assign f_mine   = beat_valid_i && f_group_q == f_group && f_this;
  always_comb begin
    f_row_weight = '0;
    for (int r = 1; r <= MaxRows; r++) begin
      if (f_row_q >= RowBits'(r)) f_row_weight = f_row_weight + f_weight;
    end
  end

  // The output: groups of columns, or halves of them, in order.
  logic [GroupBits:0] f_beat_q;
  logic               f_here;  // the word of the column comes out
  logic               f_grey_out;  // of the frame that comes out
  logic [63:0]        f_word;
  assign f_grey_out = (f_out_q == f_before_q ? f_mode : f_other_mode) != sp_spec_pkg::ModeBinary;
  assign f_here = moments_valid_o && f_out_q == f_before_q && f_ended_q >= 6'(f_frame) &&
                  f_beat_q == (f_grey ? {f_group, f_lane[FLaneBits-1]} : {1'b0, f_group});
  assign f_word = f_grey ? moments_data_o[64*f_lane[FLaneBits-2:0]+:64] : 64'(moments_data_o[32*f_lane+:32]);
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_beat_q, f_out_q} <= '0;
    else if (moments_valid_o) begin
      if (f_beat_q == (f_grey_out ? {f_last_group, 1'b1} : {1'b0, f_last_group})) begin
        f_beat_q <= '0;
        f_out_q  <= f_out_q + 6'd1;
      end else begin
        f_beat_q <= f_beat_q + (GroupBits + 1)'(1);
      end
    end
  end

  // Rule: nothing comes out that has not gone in completely or is not wanted; no frame is spoiled.
  always_comb if (f_run) begin
    if (f_here) assert (f_ended_q > 6'(f_frame) || f_last_row && f_group_q > f_group);
    if (moments_valid_o) assert (f_out_q < f_wants_q);
    assert (!spoiled_o);
  end
