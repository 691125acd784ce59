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

  logic        wanted;    // there is something to do
  logic [1:0]  wanted_q;  // there was, a clock and two clocks ago
  logic        awake;
  logic        run_q;
  logic        begin_q;   // a period begins
  logic        camera;    // the camera pulse begins
  logic [7:0]  shown_q;   // pattern on the projector
  logic [7:0]  next_q;    // the one after it
  logic [7:0]  pattern_q;

  // Two clocks after run_i and on_frame_i have gone low everything stands at 0: nothing moves then.
  assign wanted    = run_i || on_frame_i;
  assign awake     = wanted || wanted_q != '0;
  assign pattern_o = {8'd0, pattern_q};

  always_ff @(posedge clk_i) begin
    if (rst_i) wanted_q <= '1;
    else if (awake) wanted_q <= {wanted_q[0], wanted};
  end

  // --- Period: clocks since it began, in two chains, two clocks ahead, one for each register of the comparisons ---
  logic [11:0] low_q, high_q;
  logic        low_full_q;
  logic        begun_q;      // it began a clock ago
  logic        camera_due_q;
  logic        period_low_q, period_high_q, camera_low_q, camera_high_q;            // a chain is that of the setting
  logic        period_one_q, period_two_q, camera_none_q, camera_one_q, camera_two_q;  // of the settings, which stand still

  always_ff @(posedge clk_i) begin
    if (run_i && !run_q) begin
      period_one_q  <= period_i == 24'd1;
      period_two_q  <= period_i == 24'd2;
      camera_none_q <= camera_i == 24'd0;
      camera_one_q  <= camera_i == 24'd1;
      camera_two_q  <= camera_i == 24'd2;
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      run_q   <= 1'b0;
      begin_q <= 1'b0;
    end else if (awake) begin
      run_q   <= run_i;
      begin_q <= run_i && (!run_q || (begin_q ? period_one_q : begun_q ? period_two_q : period_low_q && period_high_q));
    end
  end

  always_ff @(posedge clk_i) begin
    if (run_q) begin
      begun_q       <= begin_q;
      camera_due_q  <= begin_q ? camera_one_q : begun_q ? camera_two_q : camera_low_q && camera_high_q;
      period_low_q  <= low_q == period_i[11:0];
      period_high_q <= high_q == period_i[23:12];
      camera_low_q  <= low_q == camera_i[11:0];
      camera_high_q <= high_q == camera_i[23:12];
      if (begin_q) begin
        low_q      <= 12'd3;
        high_q     <= 12'd0;
        low_full_q <= 1'b0;
      end else begin
        low_q      <= low_q + 12'd1;
        if (low_full_q) high_q <= high_q + 12'd1;
        low_full_q <= low_q == 12'hFFE;
      end
    end
  end

  assign camera = run_q && (begin_q ? camera_none_q : camera_due_q);

  // --- Pulses ---
  logic clear;
  assign clear = rst_i || !run_i;

  sp_pulse #(
    .Width(16)
  ) u_projector (
    .clk_i  (clk_i),
    .awake_i(awake),
    .clear_i(clear),
    .start_i(begin_q),
    .width_i(width_i),
    .pulse_o(projector_o)
  );

  sp_pulse #(
    .Width(16)
  ) u_camera (
    .clk_i  (clk_i),
    .awake_i(awake),
    .clear_i(clear),
    .start_i(camera),
    .width_i(width_i),
    .pulse_o(camera_o)
  );

  // --- Pattern ---
  always_ff @(posedge clk_i) begin
    if (!run_q) begin
      if (run_i) next_q <= '0;
    end else if (begin_q) begin
      next_q  <= next_q == last_pattern_i ? 8'd0 : next_q + 8'd1;
      shown_q <= next_q;
    end
  end

  always_ff @(posedge clk_i) begin
    if (rst_i || !wanted) begin
      pattern_q <= '0;
    end else if (run_i) begin
      if (camera) pattern_q <= begin_q ? next_q : shown_q;
    end else if (captured_i) begin
      pattern_q <= pattern_q == last_pattern_i ? 8'd0 : pattern_q + 8'd1;
    end
  end

endmodule

`default_nettype wire
