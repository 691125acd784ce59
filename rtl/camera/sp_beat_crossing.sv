// Beats of video from the clock of a camera into that of the board: the end of every camera's front
// end.
//
//   camera's clock: beats ─▶ held back by one ─▶ sp_async_fifo ─▶ video, in the board's clock
//
// Guarantees: a beat with m_start_o is the first of a frame, and one with m_end_o is the last of
// its line. So that the last one can be marked, each beat waits for the next beat or for the end of
// its line. After a reset, output starts with the next frame that begins.
//
// A frame is left out from the beat on for which the FIFO has no room, or from cut_i on. It ends in
// the middle and never continues with beats of another one, so that the frame tracker of sp_board
// counts and marks it as broken. overrun_o and cut_o are high for one clock for each such frame and
// for each rise of cut_i, if these are four clocks of the board apart or more.
//
// Reset: rst_i alone. The camera's clock may stop and start at any time. After rst_i the module
// waits until this clock runs.
//
// Latency: one clock of the camera from the next beat, or the end of the line, and 3 to 4 of the
// board.
//
//   camera      0   1   2   3   4   5
//   begins_i   /111\___________________
//   full_i     ____/111\___/111\_______   beats 0 and 1
//   ending_i   ____________________/111
//   written    ____________<0 >----<1 >   beat 1 with m_end_o
`default_nettype none

module sp_beat_crossing #(
  parameter int LogDepth = 4  // log2 of the beats in the FIFO
) (
  // Camera
  input  wire logic        camera_clk_i,
  output logic             camera_rst_o,  // the camera's side is in reset
  input  wire logic        begins_i,      // a frame begins, with its first beat or before it
  input  wire logic        full_i,        // a beat is complete
  input  wire logic [31:0] beat_i,        // leftmost pixel in 7..0
  input  wire logic        ending_i,      // the line has ended; not together with full_i
  input  wire logic        cut_i,         // the rest of the frame is lost

  // Video
  input  wire logic        clk_i,
  input  wire logic        rst_i,         // active high, synchronous to clk_i
  output logic             m_valid_o,
  input  wire logic        m_ready_i,
  output logic      [31:0] m_data_o,
  output logic             m_start_o,     // first beat of a frame
  output logic             m_end_o,       // last beat of a line
  output logic             overrun_o,     // pulse: a frame was cut off for want of room
  output logic             cut_o          // pulse: cut_i has risen
);

  // --- Reset of both sides: the board's side asks, the camera's side resets and confirms ---
  logic       ask_q;        // the camera's side must be in reset
  logic       asked;        // ask_q in the camera's clock
  logic [7:0] resting_q;    // asked in the last clocks of the camera
  logic       rested_q;     // the camera's side was in reset for long enough
  logic       rested;       // rested_q in the board's clock
  logic       camera_rst_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) ask_q <= 1'b1;
    else if (rested) ask_q <= 1'b0;
  end

  sp_sync u_asked (
    .clk_i(camera_clk_i),
    .rst_i(1'b0),
    .d_i  (ask_q),
    .q_o  (asked)
  );

  always_ff @(posedge camera_clk_i) begin
    resting_q    <= asked ? {resting_q[6:0], 1'b1} : '0;
    rested_q     <= asked && resting_q == '1;
    camera_rst_q <= asked;
  end

  sp_sync u_rested (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (rested_q),
    .q_o  (rested)
  );

  assign camera_rst_o = camera_rst_q;

  // --- A beat waits for the next one, in the camera's clock ---
  logic              first_q;    // no beat of the frame is complete yet
  logic              open_q;     // the frame goes to the board
  logic              whole_q;    // a beat waits in held_q
  logic [31:0]       held_q;
  logic              held_first_q;
  logic              first, open;
  logic              write, lost;
  logic [LogDepth:0] free;
  logic              cutting_q;
  logic              overrun_q, cut_q;  // change with every frame that is cut off

  assign first = first_q || begins_i;
  assign open  = open_q || begins_i;
  assign write = whole_q && (full_i || ending_i) && !cut_i;
  assign lost  = write && free == '0;

  always_ff @(posedge camera_clk_i) begin
    cutting_q <= cut_i;
    if (camera_rst_q) begin
      open_q    <= 1'b0;
      whole_q   <= 1'b0;
      overrun_q <= 1'b0;
      cut_q     <= 1'b0;
    end else begin
      open_q <= open && !lost && !cut_i;
      if (lost || cut_i) whole_q <= 1'b0;
      else if (full_i) whole_q <= open;
      else if (ending_i) whole_q <= 1'b0;
      if (lost) overrun_q <= !overrun_q;
      if (cut_i && !cutting_q) cut_q <= !cut_q;
    end
    if (full_i) begin
      held_q       <= beat_i;
      held_first_q <= first;
    end
    first_q <= first && !full_i;
  end

  // --- Into the board's clock ---
  logic [1:0] changes, changes_q;

  sp_async_fifo #(
    .Width   (34),
    .LogDepth(LogDepth)
  ) u_fifo (
    .wr_clk_i  (camera_clk_i),
    .wr_rst_i  (camera_rst_q),
    .wr_valid_i(write && !lost && !camera_rst_q),
    .wr_data_i ({held_first_q, ending_i, held_q}),
    .wr_free_o (free),
    .rd_clk_i  (clk_i),
    .rd_rst_i  (ask_q),
    .rd_valid_o(m_valid_o),
    .rd_ready_i(m_ready_i),
    .rd_data_o ({m_start_o, m_end_o, m_data_o})
  );

  sp_sync #(
    .Width(2)
  ) u_changes (
    .clk_i(clk_i),
    .rst_i(ask_q),
    .d_i  ({cut_q, overrun_q}),
    .q_o  (changes)
  );

  always_ff @(posedge clk_i) changes_q <= ask_q ? '0 : changes;
  assign {cut_o, overrun_o} = changes ^ changes_q;

endmodule

`default_nettype wire
