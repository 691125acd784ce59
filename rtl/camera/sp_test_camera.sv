// A camera inside the FPGA: frames whose moments are known, to try a board without a camera.
// model/test_camera.h is its model.
//
// Guarantees: while run_i is high, a frame of Columns x Rows pixels begins every FrameClocks
// clocks. Its beats of four pixels follow each other without a gap. When run_i falls, the frame
// that has begun comes to its end. The first frame after run_i rises is frame 0.
//
// The picture: a line that is four rows high. It begins in row f modulo (Rows - 3) in the leftmost
// eight pixels of frame f. With every further eight pixels it begins one row lower; behind the last
// row that has room for it, it begins again in row 0. A pixel of column x is, in the line's first
// row, 128 + (x + f) modulo 64; in its second and third row 255; in its fourth row 191 - (x + f)
// modulo 64; and everywhere else (x exclusive or row) modulo 32. So M0, M1 and N change from column
// to column and from frame to frame, and every column of a frame has one line.
//
// Latency: the first beat comes two clocks after run_i rises. Nothing is lost: nobody can stall a
// camera. 8 x 5 pixels, so that a frame has two beats a row, with FrameClocks = 12:
//
//   clock       0   1   2   3   4   5   6   7   8   9  10  11  12  13  14
//   run_i      /111111111111111111111111111111111111111111111111111111111
//   m_valid_o  ________/111111111111111111111111111111111111111\_______/1
//   m_data_o   --------<0 ><0'><1 ><1'><2 ><2'><3 ><3'><4 ><4'>--------<0
//   m_start_o  ________/111\___________________________________________/1
//   m_end_o    ____________/111\___/111\___/111\___/111\___/111\_________
`default_nettype none

module sp_test_camera #(
  parameter int Columns = 512,  // a multiple of 8, up to 2048
  parameter int Rows = 96,  // 5..1023
  parameter int FrameClocks = 12_500  // at least Columns / 4 * Rows; 10,000 a second at 125 MHz
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,      // active high, synchronous
  input  wire logic         run_i,      // frames are wanted

  // Video, to the board's s_axis ports
  output logic              m_valid_o,
  output logic      [31:0]  m_data_o,   // leftmost pixel in 7..0
  output logic              m_start_o,  // first beat of a frame
  output logic              m_end_o     // last beat of a line
);

  localparam int Beats = Columns / 4;
  localparam int BeatBits = $clog2(Beats);
  localparam int RowBits = $clog2(Rows);
  localparam int ClockBits = $clog2(FrameClocks);
  localparam logic [RowBits-1:0] LastPlace = RowBits'(Rows - 4);  // lowest row that it begins in

`ifndef SYNTHESIS
  initial begin
    if (Columns < 8 || Columns > 2048 || Columns % 8 != 0)
      $fatal(1, "sp_test_camera: Columns is %0d, not a multiple of 8 in 8..2048", Columns);
    if (Rows < 5 || Rows > 1023)
      $fatal(1, "sp_test_camera: Rows is %0d, not in 5..1023", Rows);
    if (FrameClocks < Beats * Rows)
      $fatal(1, "sp_test_camera: a frame has %0d beats, FrameClocks is %0d", Beats * Rows,
             FrameClocks);
  end
`endif

  // --- Where the next beat is ---
  logic                 on_q;     // frames follow each other
  logic                 beat_q;   // there is a beat
  logic [ClockBits-1:0] clock_q;  // of the frame
  logic [BeatBits-1:0]  column_q;  // beat of the row
  logic [RowBits-1:0]   row_q;
  logic [RowBits-1:0]   place_q;  // row in which the line begins at the beat
  logic [RowBits-1:0]   base_q;   // and at the first beat of a row
  logic [5:0]           frame_q;  // number of the frame, as far as pixels depend on it
  logic                 frame_end, row_end, last_beat;

  assign frame_end = clock_q == ClockBits'(FrameClocks - 1);
  assign row_end   = column_q == BeatBits'(Beats - 1);
  assign last_beat = row_end && row_q == RowBits'(Rows - 1);

  always_ff @(posedge clk_i) begin
    if (rst_i || !on_q) begin
      on_q     <= !rst_i && run_i;
      beat_q   <= !rst_i && run_i;
      clock_q  <= '0;
      column_q <= '0;
      row_q    <= '0;
      place_q  <= '0;
      base_q   <= '0;
      frame_q  <= '0;
    end else begin
      clock_q <= frame_end ? '0 : clock_q + 1'b1;
      if (beat_q) begin
        column_q <= row_end ? '0 : column_q + 1'b1;
        if (row_end) row_q <= last_beat ? '0 : row_q + 1'b1;
        if (row_end) place_q <= base_q;
        else if (column_q[0]) place_q <= place_q == LastPlace ? '0 : place_q + 1'b1;
        if (last_beat) beat_q <= 1'b0;
      end
      if (frame_end) begin
        on_q    <= run_i;
        beat_q  <= run_i;
        place_q <= base_q == LastPlace ? '0 : base_q + 1'b1;
        base_q  <= base_q == LastPlace ? '0 : base_q + 1'b1;
        frame_q <= frame_q + 1'b1;
      end
    end
  end

  // --- Its pixels ---
  logic [RowBits-1:0] below;  // rows below the line's first
  logic [31:0]        pixels;

  assign below = row_q - place_q;

  for (genvar i = 0; i < 4; i++) begin : gen_pixel
    logic [5:0] column, weight;
    logic [7:0] pixel;
    assign column = 6'({column_q, 2'(i)});
    assign weight = column + frame_q;
    always_comb begin
      if (row_q < place_q || below > RowBits'(3)) pixel = {3'd0, column[4:0] ^ 5'(row_q)};
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
