// sp_board behind a front end for cameras, its buses behind few pins, to place and route both together.
//
// As in sp_board_pins, a shift register feeds every input of the buses, and another one collects every
// output. In a design of your own the buses' ports go to what brings packets to the PC.
`default_nettype none

module sp_board_bus_pins #(
  parameter int MaxColumns = 512,  // all as in sp_board
  parameter int MaxRows = 127,
  parameter bit Grey = 1'b0,
  parameter bit Verdict = 1'b0
) (
  // The front end's video, and pins of the board
  input  wire logic        clk_i,
  input  wire logic        rst_i,
  input  wire logic        valid_i,
  input  wire logic [31:0] data_i,
  input  wire logic        start_i,
  input  wire logic        end_i,
  input  wire logic        encoder_a_i,
  input  wire logic        encoder_b_i,
  output logic             projector_trigger_o,
  output logic             camera_trigger_o,
  output logic             ejector_o,

  input  wire logic        bus_clk_i,
  input  wire logic        bus_i,
  output logic             bus_o
);

  // Reset, packet ready, AXI4-Lite; packets, AXI4-Lite
  localparam int BusIn = 1 + 1 + 1 + 8 + 1 + 32 + 4 + 1 + 1 + 8 + 1;
  localparam int BusOut = 1 + 128 + 1 + 1 + 1 + 1 + 2 + 1 + 1 + 32 + 2;

  logic [BusIn-1:0]  bus_in;
  logic [BusOut-1:0] bus_out, bus_out_q;
  logic              unused_ready;

  sp_pins_in #(
    .Width(BusIn)
  ) u_in (
    .clk_i(bus_clk_i),
    .d_i  (bus_i),
    .q_o  (bus_in)
  );

  always_ff @(posedge bus_clk_i) bus_out_q <= bus_out ^ {bus_out_q[BusOut-2:0], bus_out_q[BusOut-1]};
  assign bus_o = bus_out_q[BusOut-1];

  sp_board #(
    .MaxColumns        (MaxColumns),
    .MaxRows           (MaxRows),
    .Grey              (Grey),
    .Image             (1'b0),
    .Verdict           (Verdict),
    .VerdictLogSections(0)
  ) u_board (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .s_axis_tvalid      (valid_i),
    .s_axis_tready      (unused_ready),
    .s_axis_tdata       (data_i),
    .s_axis_tuser       (start_i),
    .s_axis_tlast       (end_i),
    .encoder_a_i        (encoder_a_i),
    .encoder_b_i        (encoder_b_i),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .ejector_o          (ejector_o),
    .bus_clk_i          (bus_clk_i),
    .bus_rst_i          (bus_in[0]),
    .m_axis_tvalid      (bus_out[0]),
    .m_axis_tready      (bus_in[1]),
    .m_axis_tdata       (bus_out[1+:128]),
    .m_axis_tlast       (bus_out[129]),
    .s_axil_awvalid     (bus_in[2]),
    .s_axil_awready     (bus_out[130]),
    .s_axil_awaddr      (bus_in[3+:8]),
    .s_axil_wvalid      (bus_in[11]),
    .s_axil_wready      (bus_out[131]),
    .s_axil_wdata       (bus_in[12+:32]),
    .s_axil_wstrb       (bus_in[44+:4]),
    .s_axil_bvalid      (bus_out[132]),
    .s_axil_bready      (bus_in[48]),
    .s_axil_bresp       (bus_out[133+:2]),
    .s_axil_arvalid     (bus_in[49]),
    .s_axil_arready     (bus_out[135]),
    .s_axil_araddr      (bus_in[50+:8]),
    .s_axil_rvalid      (bus_out[136]),
    .s_axil_rready      (bus_in[58]),
    .s_axil_rdata       (bus_out[137+:32]),
    .s_axil_rresp       (bus_out[169+:2])
  );

endmodule

`default_nettype wire
