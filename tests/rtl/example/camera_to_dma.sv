// sp_board between a camera and a DMA: binary and grey moments of images up to 512 x 127.
`default_nettype none

module camera_to_dma (
  input  wire logic         reset_i,      // active high, any clock; 16 clocks of the slower clock

  input  wire logic         pixel_clk_i,  // the camera's: four pixels per clock
  input  wire logic         camera_valid_i,
  input  wire logic [31:0]  camera_pixels_i,
  input  wire logic         camera_frame_start_i,
  input  wire logic         camera_line_end_i,
  input  wire logic [1:0]   encoder_i,    // {b, a}
  output logic              projector_trigger_o,
  output logic              camera_trigger_o,
  output logic              ejector_o,

  input  wire logic         bus_clk_i,    // the DMA's and the processor's
  output logic              dma_valid_o,
  input  wire logic         dma_ready_i,
  output logic      [127:0] dma_data_o,
  output logic              dma_last_o,
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
  output logic      [1:0]   s_axil_rresp
);

  // One reset, synchronized into each clock
  logic pixel_rst, bus_rst;

  sp_sync u_pixel_rst (
    .clk_i(pixel_clk_i),
    .rst_i(1'b0),
    .d_i  (reset_i),
    .q_o  (pixel_rst)
  );

  sp_sync u_bus_rst (
    .clk_i(bus_clk_i),
    .rst_i(1'b0),
    .d_i  (reset_i),
    .q_o  (bus_rst)
  );

  logic unused_ready;  // always 1: a camera cannot be stalled

  sp_board #(
    .MaxColumns(512),
    .MaxRows   (127),
    .Grey      (1'b1),
    .Image     (1'b0)
  ) u_board (
    .clk_i              (pixel_clk_i),
    .rst_i              (pixel_rst),
    .s_axis_tvalid      (camera_valid_i),
    .s_axis_tready      (unused_ready),
    .s_axis_tdata       (camera_pixels_i),
    .s_axis_tuser       (camera_frame_start_i),
    .s_axis_tlast       (camera_line_end_i),
    .encoder_a_i        (encoder_i[0]),
    .encoder_b_i        (encoder_i[1]),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .ejector_o          (ejector_o),
    .bus_clk_i          (bus_clk_i),
    .bus_rst_i          (bus_rst),
    .m_axis_tvalid      (dma_valid_o),
    .m_axis_tready      (dma_ready_i),
    .m_axis_tdata       (dma_data_o),
    .m_axis_tlast       (dma_last_o),
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

endmodule

`default_nettype wire
