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

  logic        wanted;         // there is something to do
  logic [1:0]  wanted_q;       // there was, a clock and two clocks ago
  logic        awake;
  logic        running_q;
  logic [23:0] count_q;        // clocks since the period began
  logic        begins;         // a period begins
  logic        begun_q;
  logic        camera_now_q;   // the camera pulse begins
  logic [7:0]  shown_q;        // pattern on the projector
  logic [7:0]  pattern_q;
  logic [15:0] projector_on_q;
  logic [15:0] camera_on_q;

  // Two clocks after run_i and on_frame_i have gone low everything stands at 0: nothing moves then.
  assign wanted    = run_i || on_frame_i;
  assign awake     = wanted || wanted_q != '0;
  assign pattern_o = {8'd0, pattern_q};

  always_comb begin
    begins = 1'b0;
    if (run_i) begins = !running_q || count_q == period_i;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) wanted_q <= '1;
    else if (awake) wanted_q <= {wanted_q[0], wanted};
  end

  always_ff @(posedge clk_i) begin
    if (awake) begin
      if (rst_i || !run_i) begin
        running_q      <= 1'b0;
        begun_q        <= 1'b0;
        camera_now_q   <= 1'b0;
        projector_on_q <= '0;
        camera_on_q    <= '0;
      end else begin
        running_q    <= 1'b1;
        begun_q      <= begins;
        camera_now_q <= begins ? camera_i == 24'd0 : count_q == camera_i;

        if (begun_q) projector_on_q <= width_i;
        else if (projector_on_q != '0) projector_on_q <= projector_on_q - 16'd1;
        if (camera_now_q) camera_on_q <= width_i;
        else if (camera_on_q != '0) camera_on_q <= camera_on_q - 16'd1;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (run_i) begin
      count_q <= begins ? 24'd1 : count_q + 24'd1;
      if (begins) shown_q <= !running_q || shown_q == last_pattern_i ? 8'd0 : shown_q + 8'd1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (awake) begin
      projector_o <= projector_on_q != '0;
      camera_o    <= camera_on_q != '0;

      if (rst_i || !wanted) pattern_q <= '0;
      else if (run_i && camera_now_q) pattern_q <= shown_q;
      else if (!run_i && captured_i) pattern_q <= pattern_q == last_pattern_i ? 8'd0 : pattern_q + 8'd1;
    end
  end

endmodule

`default_nettype wire
