// What is in the FPGA of an Acorn or LiteFury apart from clocks, resets and LitePCIe: camera, board
// and the way to LitePCIe's DMA.
//
//   sp_test_camera ─▶ sp_board ─▶ acorn_dma ─▶ DMA writer ┐
//                        ▲                                ├ LitePCIe
//                        └────── registers ◀── AXI4-Lite ─┘
//
// LitePCIe's clock is the board's bus clock, so the only crossings are those inside of sp_board.
// Both resets together, four clocks or more.
`default_nettype none

module acorn_system #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter bit Grey = 1'b1,
  parameter bit Runs = 1'b1,
  parameter bit Image = 1'b1,
  parameter bit Codes = 1'b0,
  parameter int CodeBits = 8,
  parameter int Columns = 512,        // of the test camera
  parameter int Rows = 96,
  parameter int FrameClocks = 12_500,  // of the test camera: 10,000 frames a second at 125 MHz
  parameter int IdleClocks = 12_500   // after the last packet of a burst: 0.1 ms at 125 MHz
) (
  input  wire logic         clk_i,      // pixel clock
  input  wire logic         rst_i,
  input  wire logic         bus_clk_i,  // LitePCIe's clock, 125 MHz
  input  wire logic         bus_rst_i,

  // LitePCIe's DMA writer
  input  wire logic         dma_enable_i,
  output logic              dma_valid_o,
  input  wire logic         dma_ready_i,
  output logic              dma_last_o,
  output logic      [127:0] dma_data_o,

  // Registers, from LitePCIe's AXI4-Lite
  input  wire logic         s_axil_awvalid,
  output logic              s_axil_awready,
  input  wire logic [7:0]   s_axil_awaddr,
  input  wire logic         s_axil_wvalid,
  output logic              s_axil_wready,
  input  wire logic [31:0]  s_axil_wdata,
  input  wire logic [3:0]   s_axil_wstrb,
  output logic              s_axil_bvalid,
  input  wire logic         s_axil_bready,
  output logic      [1:0]   s_axil_bresp,
  input  wire logic         s_axil_arvalid,
  output logic              s_axil_arready,
  input  wire logic [7:0]   s_axil_araddr,
  output logic              s_axil_rvalid,
  input  wire logic         s_axil_rready,
  output logic      [31:0]  s_axil_rdata,
  output logic      [1:0]   s_axil_rresp,

  input  wire logic         encoder_a_i,
  input  wire logic         encoder_b_i,
  output logic              projector_trigger_o,
  output logic              camera_trigger_o,

  // For LEDs
  output logic              frame_o,    // a beat that begins a frame
  output logic              packet_o    // the last beat of a packet, to the DMA
);

  // --- Camera ---
  logic        video_valid, video_start, video_end;
  logic [31:0] video_data;

  sp_test_camera #(
    .Columns    (Columns),
    .Rows       (Rows),
    .FrameClocks(FrameClocks)
  ) u_camera (
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .run_i     (1'b1),
    .trigger_i (camera_trigger_o),
    .patterns_i(1'b0),  // the line
    .m_valid_o (video_valid),
    .m_data_o  (video_data),
    .m_start_o (video_start),
    .m_end_o   (video_end)
  );
  assign frame_o = video_valid && video_start;

  // --- Board ---
  logic         packet_valid, packet_ready, packet_last, unused_ready;
  logic [127:0] packet_data;

  logic unused_ejector;
  sp_board #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .Grey      (Grey),
    .Runs      (Runs),
    .Image     (Image),
    .Codes     (Codes),
    .CodeBits  (CodeBits)
  ) u_board (
    .clk_i              (clk_i),
    .rst_i              (rst_i),
    .s_axis_tvalid      (video_valid),
    .s_axis_tready      (unused_ready),
    .s_axis_tdata       (video_data),
    .s_axis_tuser       (video_start),
    .s_axis_tlast       (video_end),
    .encoder_a_i        (encoder_a_i),
    .encoder_b_i        (encoder_b_i),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .ejector_o          (unused_ejector),
    .bus_clk_i          (bus_clk_i),
    .bus_rst_i          (bus_rst_i),
    .m_axis_tvalid      (packet_valid),
    .m_axis_tready      (packet_ready),
    .m_axis_tdata       (packet_data),
    .m_axis_tlast       (packet_last),
    .s_axil_awvalid     (s_axil_awvalid),
    .s_axil_awready     (s_axil_awready),
    .s_axil_awaddr      (s_axil_awaddr),
    .s_axil_wvalid      (s_axil_wvalid),
    .s_axil_wready      (s_axil_wready),
    .s_axil_wdata       (s_axil_wdata),
    .s_axil_wstrb       (s_axil_wstrb),
    .s_axil_bvalid      (s_axil_bvalid),
    .s_axil_bready      (s_axil_bready),
    .s_axil_bresp       (s_axil_bresp),
    .s_axil_arvalid     (s_axil_arvalid),
    .s_axil_arready     (s_axil_arready),
    .s_axil_araddr      (s_axil_araddr),
    .s_axil_rvalid      (s_axil_rvalid),
    .s_axil_rready      (s_axil_rready),
    .s_axil_rdata       (s_axil_rdata),
    .s_axil_rresp       (s_axil_rresp)
  );

  // --- To the DMA ---
  acorn_dma #(
    .IdleClocks(IdleClocks)
  ) u_dma (
    .clk_i    (bus_clk_i),
    .rst_i    (bus_rst_i),
    .enable_i (dma_enable_i),
    .s_valid_i(packet_valid),
    .s_ready_o(packet_ready),
    .s_last_i (packet_last),
    .s_data_i (packet_data),
    .m_valid_o(dma_valid_o),
    .m_ready_i(dma_ready_i),
    .m_last_o (dma_last_o),
    .m_data_o (dma_data_o)
  );
  assign packet_o = dma_valid_o && dma_ready_i && dma_last_o;

endmodule

`default_nettype wire
