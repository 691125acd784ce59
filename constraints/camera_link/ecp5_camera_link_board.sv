// A Camera Link camera and the board in one chip: from the cables' lanes to packets. What a design of
// your own begins with; it is also placed and routed as it stands.
//
//   lanes_i ─▶ ecp5_camera_link_bank ─▶ sp_board ─▶ packets
//   pll_clk_i ─▶ ecp5_pll ──▲
//
// The PLL's oscillator runs at Divider times the camera's clock, as in ecp5_camera_link_bank_pins.
`default_nettype none

module ecp5_camera_link_board #(
  parameter int Taps = 8,  // 1..4, 8 or 10
  parameter int Bits = 8,  // as in sp_camera_link, as those below but Divider
  parameter bit DataValid = 1'b1,
  parameter int Columns = 0,
  parameter int LogWords = 9,
  parameter int Divider = 7,  // 7 or 14
  parameter int MaxColumns = 512,  // these as in sp_board
  parameter int MaxRows = 127,
  parameter bit Grey = 1'b0,
  parameter bit Verdict = 1'b0
) (
  input  wire logic [14:0] lanes_i,    // X's data 0 to 3 and clock, Y's, Z's; those without a link are ignored
  input  wire logic        pll_clk_i,  // X's clock lane once more

  input  wire logic        clk_i,
  input  wire logic        rst_i,
  input  wire logic        encoder_a_i,
  input  wire logic        encoder_b_i,
  output logic             projector_trigger_o,
  output logic             camera_trigger_o,
  output logic             ejector_o,
  output logic             overrun_o,
  output logic             lost_o,
  output logic             apart_o,
  output logic      [2:0]  locked_o,

  input  wire logic        bus_clk_i,
  input  wire logic        bus_i,
  output logic             bus_o
);

  if (Divider != 7 && Divider != 14) begin : gen_divider
    divider_is_not_7_or_14 u_error ();
  end

  logic        eclk, good, unused_clk;
  logic        valid, start, last;
  logic [31:0] data;
  logic [2:0]  unused_load, unused_move;

  ecp5_pll #(
    .Divider      (Divider),
    .SecondDivider(2 * Divider / 7)
  ) u_pll (
    .clk_i   (pll_clk_i),
    .clk_o   (unused_clk),
    .second_o(eclk),
    .good_o  (good)
  );

  ecp5_camera_link_bank #(
    .Taps     (Taps),
    .Bits     (Bits),
    .DataValid(DataValid),
    .Columns  (Columns),
    .LogWords (LogWords)
  ) u_link (
    .lanes_i   (lanes_i),
    .eclk_i    (eclk),
    .good_i    (good),
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .m_valid_o (valid),
    .m_data_o  (data),
    .m_start_o (start),
    .m_end_o   (last),
    .overrun_o (overrun_o),
    .lost_o    (lost_o),
    .apart_o   (apart_o),
    .locked_o  (locked_o),
    .tap_load_o(unused_load),
    .tap_move_o(unused_move)
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
