// Trigger sequencer: pulses for projector and camera, and the index of the pattern shown.
//
// While run_i is high: every period_i clocks (at least 1) a projector pulse, camera_i clocks after it a camera pulse, each
// width_i clocks long (0: none; a pulse that is not over when the next of its kind begins runs into it). The pattern index
// advances with every projector pulse: 0 to last_pattern_i, and again. pattern_o, for the frames that come in, is the index at
// the last camera pulse: a camera that misses a pulse does not shift the indices of the frames after it. A frame must
// start before the next camera pulse after its own; camera_i is below period_i, else there is no camera pulse.
// While run_i is low and on_frame_i is high there are no pulses, and every frame start advances pattern_o: the first frame
// has index 0. With both low pattern_o is 0. Settings change while run_i is low, but not in the last clock of that.
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

  // Clocks since the period began, in two chains, two clocks ahead, one for each register of the comparisons
  typedef struct packed {
    logic        low_full;
    logic        begun;        // it began a clock ago
    logic        camera_due;
    logic        period_low;   // a chain is that of the setting
    logic        period_high;
    logic        camera_low;
    logic        camera_high;
    logic [11:0] high;
    logic [11:0] low;
  } period_t;

  typedef struct packed {
    logic [1:0] wanted;   // there was something to do, a clock and two clocks ago
    logic       run;
    logic       begins;   // a period begins
    logic       started;  // one did a clock ago
    logic       camera;   // the camera pulse did
    logic [7:0] pattern;
    logic [7:0] shown;    // pattern on the projector
    logic [7:0] next;     // the one after it
  } state_t;

  state_t  state_q;
  period_t period_q;
  logic    awake;
  logic    camera;  // the camera pulse begins
  // Of the settings, which stand still: their upper bits are zero; all bits are that
  logic    period_low_q, camera_low_q;
  logic    period_one_q, period_two_q, camera_none_q, camera_one_q, camera_two_q, width_some_q, width_short_q;

  // Two clocks after run_i and on_frame_i have gone low everything stands at 0: nothing moves then.
  assign awake     = run_i || on_frame_i || state_q.wanted != '0;
  assign pattern_o = {8'd0, state_q.pattern};

  always_comb begin
    camera = 1'b0;
    if (state_q.run) camera = state_q.begins ? camera_none_q : period_q.camera_due;
  end

  always_ff @(posedge clk_i) begin
    period_low_q <= period_i[23:8] == '0;
    camera_low_q <= camera_i[23:8] == '0;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      state_q.wanted  <= '1;
      state_q.run     <= 1'b0;
      state_q.begins  <= 1'b0;
      state_q.started <= 1'b0;
      state_q.camera  <= 1'b0;
      state_q.pattern <= '0;
    end else if (awake) begin
      state_q.wanted  <= {state_q.wanted[0], run_i || on_frame_i};
      state_q.run     <= run_i;
      state_q.begins  <= run_i && (!state_q.run || (state_q.begins ? period_one_q : period_q.begun ? period_two_q :
                                                    period_q.period_low && period_q.period_high));
      state_q.started <= state_q.begins;
      state_q.camera  <= camera;
      if (run_i) begin
        if (camera) state_q.pattern <= state_q.begins ? state_q.next : state_q.shown;
      end else if (!on_frame_i) begin
        state_q.pattern <= '0;
      end else if (captured_i) begin
        state_q.pattern <= state_q.pattern == last_pattern_i ? 8'd0 : state_q.pattern + 8'd1;
      end
    end
    if (awake) begin
      if (state_q.run) begin
        if (state_q.begins) begin
          state_q.next  <= state_q.next == last_pattern_i ? 8'd0 : state_q.next + 8'd1;
          state_q.shown <= state_q.next;
        end
      end else begin
        state_q.next  <= '0;
        period_one_q  <= period_low_q && period_i[7:0] == 8'd1;
        period_two_q  <= period_low_q && period_i[7:0] == 8'd2;
        camera_none_q <= camera_low_q && camera_i[7:0] == 8'd0;
        camera_one_q  <= camera_low_q && camera_i[7:0] == 8'd1;
        camera_two_q  <= camera_low_q && camera_i[7:0] == 8'd2;
        width_some_q  <= width_i != '0;
        width_short_q <= width_i[15:8] == '0;
      end
    end
  end

  always_ff @(posedge clk_i) begin
    if (state_q.run) begin
      period_q.begun       <= state_q.begins;
      period_q.camera_due  <= state_q.begins ? camera_one_q : period_q.begun ? camera_two_q :
                              period_q.camera_low && period_q.camera_high;
      period_q.period_low  <= period_q.low == period_i[11:0];
      period_q.period_high <= period_q.high == period_i[23:12];
      period_q.camera_low  <= period_q.low == camera_i[11:0];
      period_q.camera_high <= period_q.high == camera_i[23:12];
      if (state_q.begins) begin
        period_q.low      <= 12'd3;
        period_q.high     <= 12'd0;
        period_q.low_full <= 1'b0;
      end else begin
        period_q.low      <= period_q.low + 12'd1;
        period_q.low_full <= period_q.low == 12'hFFE;
        if (period_q.low_full) period_q.high <= period_q.high + 12'd1;
      end
    end
  end

  // --- Pulses ---
  sp_pulse #(
    .Width(16)
  ) u_projector (
    .clk_i  (clk_i),
    .clear_i(!state_q.run),
    .start_i(state_q.started),
    .width_i(width_i),
    .some_i (width_some_q),
    .short_i(width_short_q),
    .pulse_o(projector_o)
  );

  sp_pulse #(
    .Width(16)
  ) u_camera (
    .clk_i  (clk_i),
    .clear_i(!state_q.run),
    .start_i(state_q.camera),
    .width_i(width_i),
    .some_i (width_some_q),
    .short_i(width_short_q),
    .pulse_o(camera_o)
  );

endmodule

`default_nettype wire
