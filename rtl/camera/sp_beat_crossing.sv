// Beats of video from the clock of a camera into that of the board: the end of every camera's front
// end.
//
//   camera's clock: beats ─▶ sp_beat_hold ─▶ sp_async_fifo ─▶ video, in the board's clock
//
// Guarantees: a beat with m_start_o is the first of a frame, and one with m_end_o is the last of
// its line. After a reset, output starts with the next frame that begins.
//
// A frame is left out from the beat on for which the FIFO has no room, or from cut_i on. It ends in
// the middle and never continues with beats of another one, so that the frame tracker of sp_board
// counts and marks it as broken. overrun_o and cut_o are high for one clock for each such frame and
// for each rise of cut_i, if these are four clocks of the board apart or more.
//
// Reset: rst_i alone, high for two clocks or more, so that what it clears has settled when it
// ends. The camera's clock may stop and start at any time. After rst_i the module
// waits until this clock has run for eight clocks, whatever its registers held before.
//
// Latency: one clock of the camera from the next beat, or the end of the line, and 3 to 4 of the
// board.
`default_nettype none

module sp_beat_crossing #(
  parameter int Width = 32,   // bits of a beat: 1 or more
  parameter int LogDepth = 4  // log2 of the beats in the FIFO: 1..15
) (
  // Camera
  input  wire logic             camera_clk_i,
  output logic                  camera_rst_o,  // the camera's side is in reset
  input  wire logic             begins_i,      // a frame begins, with its first beat or before it
  input  wire logic             full_i,        // a beat is complete
  input  wire logic [Width-1:0] beat_i,        // leftmost pixel in 7..0
  input  wire logic             ending_i,      // the line has ended; not together with full_i
  input  wire logic             cut_i,         // the rest of the frame is lost

  // Video
  input  wire logic             clk_i,
  input  wire logic             rst_i,         // active high, synchronous to clk_i
  output logic                  m_valid_o,
  input  wire logic             m_ready_i,
  output logic      [Width-1:0] m_data_o,
  output logic                  m_start_o,     // first beat of a frame
  output logic                  m_end_o,       // last beat of a line
  output logic                  overrun_o,     // pulse: a frame was cut off for want of room
  output logic                  cut_o          // pulse: cut_i has risen
);

  // --- Reset of both sides: the board's side asks, the camera's side resets and confirms ---
  (* keep = "true" *) logic restart_q;  // rst_i, one clock ago: clears without the camera's clock
  logic       ask_q;        // the camera's side must be in reset
  logic       asked;        // ask_q in the camera's clock
  logic [7:0] resting_q;    // asked in the last clocks of the camera
  logic       rested_q;     // the camera's side was in reset for long enough
  logic       rested;       // rested_q in the board's clock
  logic       camera_rst_q;

  always_ff @(posedge clk_i) begin
    restart_q <= rst_i;
    if (rst_i) ask_q <= 1'b1;
    else if (rested) ask_q <= 1'b0;
  end

  sp_sync u_asked (
    .clk_i(camera_clk_i),
    .rst_i(1'b0),
    .d_i  (ask_q),
    .q_o  (asked)
  );

  always_ff @(posedge camera_clk_i or posedge restart_q) begin
    if (restart_q) begin
      resting_q <= '0;
      rested_q  <= 1'b0;
    end else begin
      resting_q <= asked ? {resting_q[6:0], 1'b1} : '0;
      rested_q  <= asked && resting_q == '1;
    end
  end
  always_ff @(posedge camera_clk_i) camera_rst_q <= asked;

  sp_sync u_rested (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (rested_q),
    .q_o  (rested)
  );

  assign camera_rst_o = camera_rst_q;

  // --- A beat waits for the next one, in the camera's clock ---
  logic              write, start, line_end, lost;
  logic [Width-1:0]  beat;
  logic [LogDepth:0] free;
  logic              cutting_q;
  logic              overrun_q, cut_q;  // change with every frame that is cut off

  sp_beat_hold #(
    .Width(Width)
  ) u_hold (
    .clk_i    (camera_clk_i),
    .rst_i    (camera_rst_q),
    .begins_i (begins_i),
    .full_i   (full_i),
    .beat_i   (beat_i),
    .ending_i (ending_i),
    .cut_i    (cut_i),
    .room_i   (free != '0),
    .m_valid_o(write),
    .m_data_o (beat),
    .m_start_o(start),
    .m_end_o  (line_end),
    .lost_o   (lost)
  );

  always_ff @(posedge camera_clk_i) begin
    cutting_q <= cut_i;
    if (camera_rst_q) begin
      overrun_q <= 1'b0;
      cut_q     <= 1'b0;
    end else begin
      if (lost) overrun_q <= !overrun_q;
      if (cut_i && !cutting_q) cut_q <= !cut_q;
    end
  end

  // --- Into the board's clock ---
  logic [1:0] changes, changes_q;

  sp_async_fifo #(
    .Width   (Width + 2),
    .LogDepth(LogDepth)
  ) u_fifo (
    .wr_clk_i  (camera_clk_i),
    .wr_rst_i  (camera_rst_q),
    .wr_valid_i(write),
    .wr_data_i ({start, line_end, beat}),
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
