// Front end for image sensors with a parallel port: pixel clock, frame valid, line valid, data.
//
//   sensor's clock: pixels ─▶ sp_tap_gather ─▶ sp_beat_crossing ─▶ video, in the board's clock
//
// Guarantees: while frame valid and line valid are high, every clock of the sensor brings
// PixelsPerClock pixels. The upper 8 bits of each pixel go to the board, four pixels a beat. A beat
// with m_start_o is the first of a frame; one with m_end_o is the last of its line. Pixels at the
// end of a line that do not fill a beat are left out. One clock of the sensor between two lines or
// frames is enough. After a reset, output starts with the next frame that begins.
//
// Overflow: the board takes every beat, so the FIFO fills only if the sensor brings more than four
// pixels in each clock of the board. Then the rest of the frame is left out. The frame ends in the
// middle and never continues with beats of another one, so that the frame tracker of sp_board
// counts and marks it as broken. overrun_o is high for one clock for each such frame, if frames
// last four clocks of the board or more. The next frame is whole again if there is room.
//
// Reset: rst_i alone. The sensor's clock may stop and start at any time. After rst_i the front end
// waits until this clock runs.
//
// Latency: a beat goes into the FIFO one clock of the sensor after the last pixel of the next beat,
// or after the end of its line. sp_async_fifo takes another clock of the sensor and 3 to 4 of the
// board. The end of a line, with one pixel a clock:
//
//   sensor      0   1   2   3   4   5   6   7   8   9
//   frame_i    /1111111111111111111111111111111111111
//   line_i     /1111111111111111111111111111111\______
//   data_i     <0 ><1 ><2 ><3 ><4 ><5 ><6 ><7 >-------
//   written    --------------------------------<0 ><4 >  (a)
//
//   (a) into the FIFO: pixels 0 to 3, then pixels 4 to 7 with m_end_o
`default_nettype none

module sp_parallel_sensor #(
  parameter int Bits = 10,  // bits of a pixel: 8..12
  parameter int PixelsPerClock = 1,  // 1 or 2; the left pixel is in the lower bits
  parameter int LogDepth = 4  // log2 of the beats in the FIFO: 1..15
) (
  // Sensor
  input  wire logic                           sensor_clk_i,
  input  wire logic                           frame_i,    // frame valid
  input  wire logic                           line_i,     // line valid
  input  wire logic [Bits*PixelsPerClock-1:0] data_i,

  // Video, to the board's s_axis ports
  input  wire logic                           clk_i,
  input  wire logic                           rst_i,      // active high, synchronous to clk_i
  output logic                                m_valid_o,
  output logic      [31:0]                    m_data_o,   // leftmost pixel in 7..0
  output logic                                m_start_o,  // first beat of a frame
  output logic                                m_end_o,    // last beat of a line
  output logic                                overrun_o   // pulse: a frame was cut off
);

  if (Bits < 8 || Bits > 12) begin : gen_bits
    bits_is_not_in_8_to_12 u_error ();
  end
  if (PixelsPerClock != 1 && PixelsPerClock != 2) begin : gen_pixels_per_clock
    pixels_per_clock_is_not_1_or_2 u_error ();
  end

  // --- Pixels into beats, in the sensor's clock ---
  logic                        frame_q, frame_q2, line_q;
  logic [8*PixelsPerClock-1:0] pixels_q;
  logic                        full;        // this clock completes a beat
  logic [31:0]                 beat;
  logic                        sensor_rst;
  logic                        unused_cut;

  for (genvar i = 0; i < PixelsPerClock; i++) begin : gen_pixel
    always_ff @(posedge sensor_clk_i) pixels_q[8*i+:8] <= data_i[Bits*(i+1)-1-:8];
  end

  if (Bits > 8) begin : gen_lower
    logic unused_lower;
    always_comb begin
      unused_lower = 1'b0;
      for (int i = 0; i < PixelsPerClock; i++) unused_lower ^= ^data_i[Bits*i+:Bits-8];
    end
  end

  always_ff @(posedge sensor_clk_i) begin
    frame_q  <= frame_i;
    frame_q2 <= frame_q;
    line_q   <= line_i && frame_i;
  end

  sp_tap_gather #(
    .Taps(PixelsPerClock)
  ) u_gather (
    .clk_i   (sensor_clk_i),
    .rst_i   (sensor_rst),
    .take_i  (line_q),
    .clear_i (!line_q),
    .pixels_i(pixels_q),
    .full_o  (full),
    .beat_o  (beat)
  );

  // --- Into the board's clock ---
  sp_beat_crossing #(
    .LogDepth(LogDepth)
  ) u_crossing (
    .camera_clk_i(sensor_clk_i),
    .camera_rst_o(sensor_rst),
    .begins_i    (frame_q && !frame_q2),
    .full_i      (full),
    .beat_i      (beat),
    .ending_i    (!line_q),
    .cut_i       (1'b0),
    .clk_i       (clk_i),
    .rst_i       (rst_i),
    .m_valid_o   (m_valid_o),
    .m_ready_i   (1'b1),
    .m_data_o    (m_data_o),
    .m_start_o   (m_start_o),
    .m_end_o     (m_end_o),
    .overrun_o   (overrun_o),
    .cut_o       (unused_cut)
  );

endmodule

`default_nettype wire
