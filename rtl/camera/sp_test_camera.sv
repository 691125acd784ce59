// A camera inside the FPGA: frames whose moments are known, to try a board without a camera.
// model/test_camera.h is its model.
//
// Guarantees: while run_i is high, a frame of Columns x Rows pixels begins every FrameClocks
// clocks. Its beats of four pixels follow each other without a gap. When run_i falls, the frame
// that has begun is completed. The first frame after run_i rises is frame 0.
//
// From the first rise of trigger_i on, frames begin only at its rises. As with a real camera, a
// trigger is missed if it comes less than FrameClocks after a frame has begun. 2^LogPause clocks
// after the last rise the camera runs free again.
//
// The picture is a line four rows high on a dark background; x and y count from 0. In frame f the
// line begins in row f modulo (Rows - 3) in the leftmost eight columns, and one row lower in each
// further eight columns. After row Rows - 4, the last with room for the line, it begins in row 0.
// The pixels of column x have these values:
//
//   line's first row              128 + (x + f) modulo 64
//   line's second and third row   255
//   line's fourth row             191 - (x + f) modulo 64
//   background, row y             (x exclusive or y) modulo 32
//
// So M0, M1 and N change from column to column and from frame to frame, and every column of a frame
// crosses one line.
//
// While patterns_i is high the camera sees the Gray-code patterns of a projector instead, so that a
// decoder has codes that are known. Frames begin at triggers only. Pattern 0 comes with the first
// trigger after patterns_i has risen, or after a pause of 2^LogPause clocks. Every trigger, also
// one that is missed, moves on to the next of 2 CodeBits patterns, as the index of sp_board does.
// So both agree from the start of the board's sequencer on. Pattern 2p is the positive of plane p,
// where plane 0 is the highest bit, and pattern 2p + 1 its negative. The code of a pixel is
// (x + y) modulo 2^CodeBits, and a pixel has these values:
//
//   positive, where the plane's bit of the Gray code is 1   255 - (x exclusive or y) modulo 32
//   positive, where it is 0                                 (x exclusive or y) modulo 32
//   negative                                                the other one of the two
//   last row                                                128 in every pattern, which is no code
//
// Latency: the first beat comes two clocks after run_i or trigger_i rises. Beats cannot be stalled,
// so none is lost here. Example: 8 x 5 pixels, which are two beats a row, with FrameClocks = 12:
//
//   clock       0   1   2   3   4   5   6   7   8   9  10  11  12  13  14
//   run_i      /111111111111111111111111111111111111111111111111111111111
//   m_valid_o  ________/111111111111111111111111111111111111111\_______/1
//   m_data_o   --------<0 ><0'><1 ><1'><2 ><2'><3 ><3'><4 ><4'>--------<0
//   m_start_o  ________/111\___________________________________________/1
//   m_end_o    ____________/111\___/111\___/111\___/111\___/111\_________
`default_nettype none

module sp_test_camera #(
  parameter int Columns = 512,  // a multiple of 8, 8..2048
  parameter int Rows = 96,  // 5..1023
  parameter int FrameClocks = 12_500,  // at least Columns / 4 * Rows; 10,000 a second at 125 MHz
  // log2 of the clocks from the last trigger until it runs free: 1 or more
  parameter int LogPause = 24,
  parameter int CodeBits = 8  // bits of the codes of the patterns: 1..12
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,      // active high, synchronous
  input  wire logic         run_i,      // make frames
  input  wire logic         trigger_i,  // each rise begins a frame
  input  wire logic         patterns_i,  // Gray-code patterns instead of the line

  // Video, to the board's s_axis ports
  output logic              m_valid_o,
  output logic      [31:0]  m_data_o,   // leftmost pixel in 7..0
  output logic              m_start_o,  // first beat of a frame
  output logic              m_end_o     // last beat of a line
);

  if (Columns < 8 || Columns > sp_spec_pkg::MaxColumns || Columns % 8 != 0) begin : gen_columns
    columns_is_not_a_multiple_of_8_in_8_to_2048 u_error ();
  end
  if (Rows < 5 || Rows > sp_spec_pkg::MaxRows) begin : gen_rows
    rows_is_not_in_5_to_1023 u_error ();
  end
  if (FrameClocks < Columns / 4 * Rows) begin : gen_frame_clocks
    frame_clocks_are_fewer_than_the_beats u_error ();
  end
  if (LogPause < 1) begin : gen_log_pause
    log_pause_is_less_than_1 u_error ();
  end
  if (CodeBits < 1 || CodeBits > sp_spec_pkg::CodeCodeBits) begin : gen_code_bits
    code_bits_is_not_in_1_to_12 u_error ();
  end

  localparam int Beats = Columns / 4;
  localparam int BeatBits = $clog2(Beats);
  localparam int RowBits = $clog2(Rows);
  localparam int ClockBits = $clog2(FrameClocks);
  // The lowest row in which the line begins
  localparam logic [RowBits-1:0] LastPlace = RowBits'(Rows - 4);

  // --- When a frame begins ---
  logic                 trigger_q;    // trigger_i, one clock ago
  logic                 rise;
  logic                 triggered_q;  // frames begin at triggers only
  logic [LogPause-1:0]  pause_q;      // clocks since the last trigger
  logic                 frame_end;    // last of the FrameClocks of a frame
  logic                 idle_q;       // no frame is under way, and one may begin
  logic                 begins;       // a frame begins in the next clock
  logic                 first_q;      // the next frame is frame 0

  assign rise   = trigger_i && !trigger_q;
  assign begins = (idle_q || frame_end) && run_i && (rise || !triggered_q && !patterns_i);

  always_ff @(posedge clk_i) begin
    trigger_q <= trigger_i;
    if (rst_i) begin
      idle_q      <= 1'b1;
      first_q     <= 1'b1;
      triggered_q <= 1'b0;
    end else begin
      idle_q  <= (idle_q || frame_end) && !begins;
      first_q <= !begins && (first_q || (idle_q || frame_end) && !run_i);
      if (rise) triggered_q <= 1'b1;
      else if (&pause_q) triggered_q <= 1'b0;
    end
    pause_q <= rise ? '0 : pause_q + 1'b1;
  end

  // --- Which pattern it shows ---
  logic [CodeBits-1:0] plane_q;     // one bit: the plane of the last trigger's pattern
  logic                negative_q;  // it is the negative
  logic                fresh_q;     // pattern 0 comes with the next trigger
  logic [CodeBits-1:0] plane;       // the same of a trigger in this clock
  logic                negative;

  localparam logic [CodeBits-1:0] HighestPlane = CodeBits'(1) << (CodeBits - 1);

  assign negative = !fresh_q && !negative_q;
  assign plane    = fresh_q || negative_q && plane_q[0] ? HighestPlane :
                    negative_q ? plane_q >> 1 : plane_q;

  always_ff @(posedge clk_i) begin
    if (rst_i || !patterns_i) fresh_q <= 1'b1;
    else if (rise) fresh_q <= 1'b0;
    else if (!triggered_q) fresh_q <= 1'b1;
    if (rise) begin
      plane_q    <= plane;
      negative_q <= negative;
    end
  end

  // --- Where the next beat is ---
  logic                 beat_q;   // there is a beat
  logic [ClockBits-1:0] clock_q;  // clocks since the frame began
  logic [BeatBits-1:0]  column_q;  // beat of the row
  logic [RowBits-1:0]   row_q;
  logic [RowBits-1:0]   place_q;  // row in which the line begins at the beat
  logic [RowBits-1:0]   base_q;   // row in which it begins at the first beat of a row
  logic [RowBits-1:0]   base;     // base_q of the next frame
  logic [5:0]           frame_q;  // number of the frame, as far as pixels depend on it
  logic                 coded_q;  // it shows a pattern: plane and negative
  logic [CodeBits-1:0]  frame_plane_q;
  logic                 frame_negative_q;
  logic                 row_end, last_beat;

  assign frame_end = !idle_q && clock_q == ClockBits'(FrameClocks - 1);
  assign row_end   = column_q == BeatBits'(Beats - 1);
  assign last_beat = row_end && row_q == RowBits'(Rows - 1);
  assign base      = first_q || base_q == LastPlace ? '0 : base_q + 1'b1;

  always_ff @(posedge clk_i) begin
    if (rst_i) beat_q <= 1'b0;
    else if (begins) beat_q <= 1'b1;
    else if (last_beat) beat_q <= 1'b0;
    if (begins) begin
      clock_q  <= '0;
      column_q <= '0;
      row_q    <= '0;
      place_q  <= base;
      base_q   <= base;
      frame_q  <= first_q ? '0 : frame_q + 1'b1;
      coded_q  <= patterns_i;
      frame_plane_q    <= plane;
      frame_negative_q <= negative;
    end else begin
      clock_q <= clock_q + 1'b1;
      if (beat_q) begin
        column_q <= row_end ? '0 : column_q + 1'b1;
        if (row_end) row_q <= row_q + 1'b1;
        if (row_end) place_q <= base_q;
        else if (column_q[0]) place_q <= place_q == LastPlace ? '0 : place_q + 1'b1;
      end
    end
  end

  // --- Its pixels ---
  logic [RowBits-1:0] below;  // rows below the line's first
  logic [31:0]        pixels;

  assign below = row_q - place_q;

  for (genvar i = 0; i < 4; i++) begin : gen_pixel
    logic [5:0]          column, weight;
    logic [4:0]          shade;
    logic [CodeBits-1:0] code;
    logic                bright;
    logic [7:0]          pixel;
    assign column = 6'({column_q, 2'(i)});
    assign weight = column + frame_q;
    assign shade  = column[4:0] ^ 5'(row_q);
    assign code   = CodeBits'({column_q, 2'(i)}) + CodeBits'(row_q);
    assign bright = (((code ^ code >> 1) & frame_plane_q) != '0) != frame_negative_q;
    always_comb begin
      if (coded_q) pixel = row_q == RowBits'(Rows - 1) ? 8'd128 : {3'd0, shade} ^ {8{bright}};
      else if (row_q < place_q || below > RowBits'(3)) pixel = {3'd0, shade};
      else if (below == '0) pixel = {2'b10, weight};
      else if (below == RowBits'(3)) pixel = {2'b10, ~weight};
      else pixel = 8'd255;
    end
    assign pixels[8*i+:8] = pixel;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) m_valid_o <= 1'b0;
    else m_valid_o <= beat_q;
    m_data_o  <= pixels;
    m_start_o <= row_q == '0 && column_q == '0;
    m_end_o   <= row_end;
  end

endmodule

`default_nettype wire
