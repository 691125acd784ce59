// Trigger sequencer: pulses for projector and camera, and the index of the pattern shown.
//
// While run_i is high: every period_i clocks (at least 1) a projector pulse, camera_i clocks after it a camera pulse, each
// width_i clocks long (0: none; a pulse that is not over when the next of its kind begins runs into it). The pattern index
// advances with every projector pulse: 0 to last_pattern_i, and again. pattern_o, for the frames that come in, is the index at
// the last camera pulse: a camera that misses a pulse does not shift the indices of the frames after it. A frame must
// start before the next camera pulse after its own; camera_i is below period_i, else there is no camera pulse.
// While run_i is low and on_frame_i is high there are no pulses, and every frame start advances pattern_o: the first frame
// has index 0. With both low pattern_o is 0. Settings change while run_i is low.
// Latency: the first projector pulse begins three clocks after run_i.
`default_nettype none

module sp_trigger (
  input  wire logic        clk_i,
  input  wire logic        rst_i,

  input  wire logic        run_i,
  input  wire logic        on_frame_i,
  input  wire logic [7:0]  last_pattern_i,
  input  wire logic [23:0] period_i,
  input  wire logic [23:0] camera_i,
  input  wire logic [15:0] width_i,
  input  wire logic        captured_i,  // a frame captures pattern_o at the end of this clock

  output logic             projector_o,
  output logic             camera_o,
  output logic      [15:0] pattern_o
);

  logic        running_q;
  logic [23:0] left_q;         // clocks left of the period
  logic        begins;         // a period begins
  logic        begun_q;
  logic [23:0] camera_left_q;  // clocks left to the camera pulse
  logic        camera_wait_q;
  logic        camera_now;
  logic [7:0]  shown_q;        // pattern on the projector
  logic [7:0]  pattern_q;
  logic [15:0] projector_on_q;
  logic [15:0] camera_on_q;

  assign begins     = run_i && (!running_q || left_q == 24'd1);
  assign camera_now = camera_wait_q && camera_left_q == 24'd0;
  assign pattern_o  = {8'd0, pattern_q};

  always_ff @(posedge clk_i) begin
    if (rst_i || !run_i) begin
      running_q      <= 1'b0;
      begun_q        <= 1'b0;
      camera_wait_q  <= 1'b0;
      projector_on_q <= '0;
      camera_on_q    <= '0;
    end else begin
      running_q <= 1'b1;
      begun_q   <= begins;
      if (begins) camera_wait_q <= 1'b1;
      else if (camera_now) camera_wait_q <= 1'b0;

      if (begun_q) projector_on_q <= width_i;
      else if (projector_on_q != '0) projector_on_q <= projector_on_q - 16'd1;
      if (camera_now) camera_on_q <= width_i;
      else if (camera_on_q != '0) camera_on_q <= camera_on_q - 16'd1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (run_i) begin
      left_q        <= begins ? period_i : left_q - 24'd1;
      camera_left_q <= begins ? camera_i : camera_left_q - 24'd1;
    end
    if (begins) shown_q <= !running_q || shown_q == last_pattern_i ? 8'd0 : shown_q + 8'd1;

    if (rst_i || !run_i && !on_frame_i) pattern_q <= '0;
    else if (run_i && camera_now) pattern_q <= shown_q;
    else if (!run_i && captured_i) pattern_q <= pattern_q == last_pattern_i ? 8'd0 : pattern_q + 8'd1;
  end

  always_ff @(posedge clk_i) begin
    projector_o <= projector_on_q != '0;
    camera_o    <= camera_on_q != '0;
  end

endmodule

`default_nettype wire
