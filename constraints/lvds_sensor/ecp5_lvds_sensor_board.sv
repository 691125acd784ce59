// A serial LVDS sensor and the board in one chip: from the lanes to packets. What a design of your own
// begins with; it is also placed and routed as it stands.
//
//   lanes_i, eclk_i ─▶ ecp5_lvds_sensor ─▶ sp_board ─▶ packets
`default_nettype none

module ecp5_lvds_sensor_board #(
  parameter int Lanes = 16,  // as in ecp5_lvds_sensor, as those below
  parameter int Bits = 10,
  parameter bit Codes = 1'b0,
  parameter int Columns = 32,
  parameter int Burst = 32,
  parameter int LogPatience = 14,
  parameter int LogDepth = 10,
  parameter int MaxColumns = 512,  // these as in sp_board
  parameter int MaxRows = 127,
  parameter bit Grey = 1'b0,
  parameter bit Verdict = 1'b0
) (
  input  wire logic [Lanes:0] lanes_i,  // the last one is the control lane
  input  wire logic           eclk_i,
  input  wire logic           good_i,   // eclk_i is good

  input  wire logic           clk_i,
  input  wire logic           rst_i,
  input  wire logic           encoder_a_i,
  input  wire logic           encoder_b_i,
  output logic                projector_trigger_o,
  output logic                camera_trigger_o,
  output logic                ejector_o,
  output logic                overrun_o,
  output logic                cut_o,
  output logic                lost_o,
  output logic                aligned_o,
  output logic      [Lanes:0] failed_o,
  output logic      [15:0]    damaged_o,

  input  wire logic           bus_clk_i,
  input  wire logic           bus_i,
  output logic                bus_o
);

  logic        valid, start, last;
  logic [31:0] data;

  ecp5_lvds_sensor #(
    .Lanes      (Lanes),
    .Bits       (Bits),
    .Codes      (Codes),
    .Columns    (Columns),
    .Burst      (Burst),
    .LogPatience(LogPatience),
    .LogDepth   (LogDepth)
  ) u_sensor (
    .lanes_i  (lanes_i),
    .eclk_i   (eclk_i),
    .good_i   (good_i),
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .m_valid_o(valid),
    .m_data_o (data),
    .m_start_o(start),
    .m_end_o  (last),
    .overrun_o(overrun_o),
    .cut_o    (cut_o),
    .lost_o   (lost_o),
    .aligned_o(aligned_o),
    .failed_o (failed_o),
    .damaged_o(damaged_o)
  );

  sp_board_bus_pins #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .Grey      (Grey),
    .Verdict   (Verdict)
  ) u_board (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .valid_i            (valid),
    .data_i             (data),
    .start_i            (start),
    .end_i              (last),
    .encoder_a_i        (encoder_a_i),
    .encoder_b_i        (encoder_b_i),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .ejector_o          (ejector_o),
    .bus_clk_i          (bus_clk_i),
    .bus_i              (bus_i),
    .bus_o              (bus_o)
  );

endmodule

`default_nettype wire
