// Trigger sequencer: pulses for projector and camera, and the index of the pattern shown.
//
// While run_i is high, a projector pulse comes every period_i clocks (at least 1), and a camera
// pulse camera_i clocks after it. Both last width_i clocks (0: no pulses); a pulse that lasts until
// the next one of its kind runs into it. If camera_i is not below period_i there is no camera
// pulse. The pattern index counts from 0 to last_pattern_i and begins again. pattern_o is the index
// at the last camera pulse, so a camera that misses a pulse does not shift the indices of later
// frames. A frame must start before the next camera pulse after its own.
//
// While run_i is low and on_frame_i is high there are no pulses, and every frame start advances
// pattern_o; the first frame has index 0. With both low, and whenever run_i changes, pattern_o
// returns to 0.
//
// Settings change while run_i is low. last_pattern_i changes no later than run_i or on_frame_i
// rises, and not while they are high. set_i is high one clock before settings change. After six
// clocks without any of these nothing moves.
//
// The reset takes effect a clock later, and run_i and on_frame_i are low in that clock.
//
// Latency: the first projector pulse begins four clocks after run_i. Two clocks after run_i falls,
// no pulse is left and pattern_o is 0. Frames count from the captured_i of the third clock after
// on_frame_i on. pattern_o is there with the first clock of the camera pulse, and in the second
// clock after captured_i.
`default_nettype none

module sp_trigger (
  input  wire logic        clk_i,
  input  wire logic        rst_i,

  input  wire logic        set_i,
  input  wire logic        run_i,
  input  wire logic        on_frame_i,
  input  wire logic [7:0]  last_pattern_i,
  input  wire logic [23:0] period_i,
  input  wire logic [23:0] camera_i,
  input  wire logic [15:0] width_i,
  input  wire logic        captured_i,  // a frame captures pattern_o after the next clock

  output logic             projector_o,
  output logic             camera_o,
  output logic      [15:0] pattern_o
);

  // --- Requests ---
  // The reset ends in a register that stands beside the sequencer, as in sp_encoder.
  (* keep *) logic reset_q;  // rst_i, one clock ago
  (* keep *) always_ff @(posedge clk_i) reset_q <= rst_i;

  logic [1:0] run_q;     // run_i for one clock, for two clocks
  logic       stop_q;    // run_i is low
  logic [2:0] frames_q;  // on_frame_i alone, for one to three clocks
  logic       rest_q;    // the index is 0: neither is on for two clocks
  logic [4:0] stirred_q;  // a request, one to five clocks ago
  logic       awake_q;   // a request now or up to six clocks ago

  always_ff @(posedge clk_i) begin
    if (reset_q) begin
      run_q    <= '0;
      frames_q <= '0;
    end else begin
      run_q    <= run_i ? {run_q[0], 1'b1} : 2'b00;
      frames_q <= on_frame_i && !run_i ? {frames_q[1:0], 1'b1} : 3'b000;
    end
    stop_q <= reset_q || !run_i;
    rest_q <= !(run_i ? run_q[1] : on_frame_i && frames_q[1]);
    // Soon enough: what follows looks at the registers above, and at settings two clocks later.
    stirred_q <= {stirred_q[3:0], reset_q || set_i || run_i || on_frame_i};
    awake_q   <= reset_q || set_i || run_i || on_frame_i || stirred_q != '0;
  end

  // --- Facts about the settings, which stand still. They are known two clocks later, the upper
  // bits one clock before. ---
  logic [1:0] period_zero_q, camera_zero_q;    // in two parts, without the lowest two bits
  logic       width_zero_q;                    // without the lowest bit
  logic [3:1] period_is_q;                     // the value is 1, 2, 3
  logic [3:0] camera_is_q;
  logic       some_q, one_q;                   // the width is not 0, is 1
  logic       one_pattern_q;
  logic [7:0] before_last_q;                   // index before the last one, if there is one

  always_ff @(posedge clk_i) if (awake_q) begin
    if (!run_q[1]) begin
      period_zero_q <= {period_i[23:13] == '0, period_i[12:2] == '0};
      camera_zero_q <= {camera_i[23:13] == '0, camera_i[12:2] == '0};
      width_zero_q  <= width_i[15:1] == '0;
      for (int k = 1; k < 4; k++) period_is_q[k] <= period_zero_q == '1 && period_i[1:0] == 2'(k);
      for (int k = 0; k < 4; k++) camera_is_q[k] <= camera_zero_q == '1 && camera_i[1:0] == 2'(k);
      some_q <= !width_zero_q || width_i[0];
      one_q  <= width_zero_q && width_i[0];
    end
    one_pattern_q <= last_pattern_i == '0;
    before_last_q <= one_pattern_q ? 8'd0 : last_pattern_i - 8'd1;
  end

  // --- Period. Two chains count its clocks, three ahead. Whether a setting is reached is known one
  // clock later in pieces, and two clocks later as a whole. Periods below 4, which would need it
  // earlier, are known from the facts above. ---
  localparam int Piece = 6, Pieces = 4;

  logic              begins_q;  // a period begins
  logic              started_q;  // a period began one clock ago
  logic              due_q;     // a period begins with the next clock
  logic              due_soon_q;
  logic [11:0]       low_q, high_q;
  logic              low_full_q;
  logic [Pieces-1:0] period_equal_q, camera_equal_q;

  always_ff @(posedge clk_i) if (awake_q) begin
    begins_q  <= run_q[0] && due_q;
    started_q <= begins_q;
    if (stop_q) begin
      due_q      <= 1'b1;
      due_soon_q <= 1'b0;
    end else begin
      due_q      <= period_is_q[1] ||
                    (begins_q ? period_is_q[2] : due_soon_q || period_equal_q == '1);
      due_soon_q <= begins_q && period_is_q[3];
    end
  end

  // Whatever belongs to a period is dropped when the next one begins.
  always_ff @(posedge clk_i) if (awake_q) begin
    if (stop_q || begins_q) begin
      period_equal_q <= '0;
      camera_equal_q <= '0;
    end else begin
      for (int k = 0; k < Pieces / 2; k++) begin
        period_equal_q[k]          <= low_q[Piece*k+:Piece] == period_i[Piece*k+:Piece];
        period_equal_q[k+Pieces/2] <= high_q[Piece*k+:Piece] == period_i[12+Piece*k+:Piece];
        camera_equal_q[k]          <= low_q[Piece*k+:Piece] == camera_i[Piece*k+:Piece];
        camera_equal_q[k+Pieces/2] <= high_q[Piece*k+:Piece] == camera_i[12+Piece*k+:Piece];
      end
    end
    if (run_q[0]) begin
      if (begins_q) begin
        low_q      <= 12'd4;
        high_q     <= 12'd0;
        low_full_q <= 1'b0;
      end else begin
        low_q      <= low_q + 12'd1;
        low_full_q <= low_q == 12'hFFE;
        if (low_full_q) high_q <= high_q + 12'd1;
      end
    end
  end

  // --- Camera pulse: one clock after camera_i clocks of the period, as the projector pulse. It
  // comes with the next clock, the second, or the third. ---
  logic camera_due_q, camera_due2_q, camera_due3_q, camera_reached_q;
  logic step_q;  // the index advances with the next clock: a camera pulse, or frames count

  always_ff @(posedge clk_i) if (awake_q) begin
    step_q <= run_q[0] && (begins_q ? camera_is_q[0] : camera_due_q) ||
              frames_q[1] && !frames_q[2];
    if (stop_q) begin
      camera_due_q     <= 1'b0;
      camera_due2_q    <= 1'b0;
      camera_due3_q    <= 1'b0;
      camera_reached_q <= 1'b0;
    end else if (begins_q) begin
      camera_due_q     <= camera_is_q[1];
      camera_due2_q    <= camera_is_q[2];
      camera_due3_q    <= camera_is_q[3];
      camera_reached_q <= 1'b0;
    end else begin
      camera_due_q     <= camera_due2_q || camera_reached_q;
      camera_due2_q    <= camera_due3_q;
      camera_due3_q    <= 1'b0;
      camera_reached_q <= camera_equal_q == '1;
    end
  end

  // --- Pattern index ---
  logic [7:0] pattern_q;
  logic [7:0] next_q;  // the index after it
  logic       wraps_q;  // pattern_q is the last index
  logic       captured_q;  // a frame that counts captures the index

  assign pattern_o = {8'd0, pattern_q};

  always_ff @(posedge clk_i) if (awake_q) begin
    captured_q <= frames_q[2] && captured_i;
    if (rest_q || step_q || captured_q) begin
      if (rest_q) begin
        pattern_q <= '0;
        next_q    <= '0;
      end else begin
        pattern_q <= next_q;
        next_q    <= wraps_q ? 8'd0 : next_q + 8'd1;
      end
      if (rest_q && !one_pattern_q) wraps_q <= 1'b0;
      else wraps_q <= next_q == before_last_q;
    end
  end

  // --- Pulses ---
  sp_pulse #(
    .Width(16)
  ) u_projector (
    .clk_i  (clk_i),
    .awake_i(awake_q),
    .clear_i(stop_q),
    .start_i(started_q),
    .width_i(width_i),
    .some_i (some_q),
    .one_i  (one_q),
    .pulse_o(projector_o)
  );

  sp_pulse #(
    .Width(16)
  ) u_camera (
    .clk_i  (clk_i),
    .awake_i(awake_q),
    .clear_i(stop_q),
    .start_i(step_q),
    .width_i(width_i),
    .some_i (some_q),
    .one_i  (one_q),
    .pulse_o(camera_o)
  );

endmodule

`default_nettype wire
