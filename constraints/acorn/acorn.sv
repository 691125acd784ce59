// Top of an Acorn or LiteFury: pins, clocks, resets and LEDs around LitePCIe and acorn_system.
//
// Clocks: pixel clock 125 MHz, by a PLL from the board's 200 MHz. LitePCIe gives the bus clock,
// 125 MHz, once the host's reference clock runs. Reset: while the PLL is not locked, while the host
// holds PERST#, and while LitePCIe is in reset; 256 clocks more, and the pixel clock's side leaves
// it after the bus clock's.
//
// LEDs show events by changes, so that it does not matter which level lights them. LED 0 changes
// every 67 ms while the pixel clock runs, LED 3 while LitePCIe's clock does. LED 1 changes after
// every 1024 frames of the camera, LED 2 after every 1024 packets to the DMA.
`default_nettype none

module acorn #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter bit Grey = 1'b1,
  parameter bit Runs = 1'b1,
  parameter bit Image = 1'b1,
  parameter bit Codes = 1'b0,
  parameter int CodeBits = 8,
  parameter int FrameClocks = 12_500,  // of the test camera: 10,000 frames a second
  parameter int IdleClocks = 12_500  // after the last packet of a burst: 0.1 ms
) (
  input  wire logic       clk200_p_i,
  input  wire logic       clk200_n_i,

  input  wire logic       pcie_rst_n_i,  // PERST#
  output logic            pcie_clkreq_n_o,
  input  wire logic       pcie_clk_p_i,
  input  wire logic       pcie_clk_n_i,
  input  wire logic [3:0] pcie_rx_p_i,
  input  wire logic [3:0] pcie_rx_n_i,
  output logic      [3:0] pcie_tx_p_o,
  output logic      [3:0] pcie_tx_n_o,

  input  wire logic       encoder_a_i,
  input  wire logic       encoder_b_i,
  output logic            projector_trigger_o,
  output logic            camera_trigger_o,

  output logic      [3:0] led_o
);

  // --- Clocks ---
  logic clk200, pll_clk, pll_feedback, clk, locked, bus_clk, pcie_rst;
  logic unused_clkout1, unused_clkout2, unused_clkout3, unused_clkout4, unused_clkout5;

  IBUFDS u_clk200 (
    .I (clk200_p_i),
    .IB(clk200_n_i),
    .O (clk200)
  );

  // The oscillator runs at 1 GHz.
  PLLE2_BASE #(
    .CLKIN1_PERIOD (5.0),
    .CLKFBOUT_MULT (5),
    .CLKOUT0_DIVIDE(8)
  ) u_pll (
    .CLKIN1  (clk200),
    .CLKFBIN (pll_feedback),
    .CLKFBOUT(pll_feedback),
    .CLKOUT0 (pll_clk),
    .CLKOUT1 (unused_clkout1),
    .CLKOUT2 (unused_clkout2),
    .CLKOUT3 (unused_clkout3),
    .CLKOUT4 (unused_clkout4),
    .CLKOUT5 (unused_clkout5),
    .LOCKED  (locked),
    .PWRDWN  (1'b0),
    .RST     (1'b0)
  );

  BUFG u_clk (
    .I(pll_clk),
    .O(clk)
  );

  assign pcie_clkreq_n_o = 1'b0;

  // --- Resets ---
  logic       good, good_bus;
  logic       locked_seen, pcie_rst_n_seen, bus_rst_seen;  // in the pixel clock
  logic [8:0] wait_q, wait_bus_q;
  logic       rst_q, bus_rst_q;

  sp_sync u_good_bus (
    .clk_i(bus_clk),
    .rst_i(1'b0),
    .d_i  (locked),
    .q_o  (good_bus)
  );

  always_ff @(posedge bus_clk) begin
    wait_bus_q <= !good_bus || pcie_rst ? '0 : wait_bus_q[8] ? wait_bus_q : wait_bus_q + 1'b1;
    bus_rst_q  <= !wait_bus_q[8];
  end

  // Where LitePCIe's clock stands still, bus_rst_q says nothing, but PERST# is low.
  sp_sync #(
    .Width(3)
  ) u_good (
    .clk_i(clk),
    .rst_i(1'b0),
    .d_i  ({locked, pcie_rst_n_i, bus_rst_q}),
    .q_o  ({locked_seen, pcie_rst_n_seen, bus_rst_seen})
  );
  assign good = locked_seen && pcie_rst_n_seen && !bus_rst_seen;

  always_ff @(posedge clk) begin
    wait_q <= !good ? '0 : wait_q[8] ? wait_q : wait_q + 1'b1;
    rst_q  <= !wait_q[8];
  end

  // --- LitePCIe ---
  logic         dma_enable, dma_valid, dma_ready, dma_last;
  logic [127:0] dma_data;
  logic         awvalid, awready, wvalid, wready, bvalid, bready, arvalid, arready, rvalid, rready;
  logic [31:0]  awaddr, araddr, wdata, rdata;
  logic [3:0]   wstrb;
  logic [1:0]   bresp, rresp;
  logic         unused_reader_enable, unused_reader_valid, unused_reader_last, unused_reader_user;
  logic [127:0] unused_reader_data;
  logic [2:0]   unused_awprot, unused_arprot;
  logic         unused_addresses;

  litepcie_core u_litepcie (
    .pcie_rst_n               (pcie_rst_n_i),
    .pcie_clk_p               (pcie_clk_p_i),
    .pcie_clk_n               (pcie_clk_n_i),
    .pcie_rx_p                (pcie_rx_p_i),
    .pcie_rx_n                (pcie_rx_n_i),
    .pcie_tx_p                (pcie_tx_p_o),
    .pcie_tx_n                (pcie_tx_n_o),
    .clk                      (bus_clk),
    .rst                      (pcie_rst),
    .msi_irqs                 (1'b0),
    .mmap_axi_lite_awvalid    (awvalid),
    .mmap_axi_lite_awready    (awready),
    .mmap_axi_lite_awaddr     (awaddr),
    .mmap_axi_lite_awprot     (unused_awprot),
    .mmap_axi_lite_wvalid     (wvalid),
    .mmap_axi_lite_wready     (wready),
    .mmap_axi_lite_wdata      (wdata),
    .mmap_axi_lite_wstrb      (wstrb),
    .mmap_axi_lite_bvalid     (bvalid),
    .mmap_axi_lite_bready     (bready),
    .mmap_axi_lite_bresp      (bresp),
    .mmap_axi_lite_arvalid    (arvalid),
    .mmap_axi_lite_arready    (arready),
    .mmap_axi_lite_araddr     (araddr),
    .mmap_axi_lite_arprot     (unused_arprot),
    .mmap_axi_lite_rvalid     (rvalid),
    .mmap_axi_lite_rready     (rready),
    .mmap_axi_lite_rresp      (rresp),
    .mmap_axi_lite_rdata      (rdata),
    .dma0_status_writer_enable(dma_enable),
    .dma0_status_reader_enable(unused_reader_enable),
    .dma0_writer_axi_tvalid   (dma_valid),
    .dma0_writer_axi_tready   (dma_ready),
    .dma0_writer_axi_tlast    (dma_last),
    .dma0_writer_axi_tdata    (dma_data),
    .dma0_writer_axi_tuser    (1'b0),
    .dma0_reader_axi_tvalid   (unused_reader_valid),
    .dma0_reader_axi_tready   (1'b1),
    .dma0_reader_axi_tlast    (unused_reader_last),
    .dma0_reader_axi_tdata    (unused_reader_data),
    .dma0_reader_axi_tuser    (unused_reader_user)
  );
  assign unused_addresses = ^{awaddr[31:8], araddr[31:8]};

  // --- The rest ---
  logic frame, packet;

  acorn_system #(
    .MaxColumns (MaxColumns),
    .MaxRows    (MaxRows),
    .Grey       (Grey),
    .Runs       (Runs),
    .Image      (Image),
    .Codes      (Codes),
    .CodeBits   (CodeBits),
    .FrameClocks(FrameClocks),
    .IdleClocks (IdleClocks)
  ) u_system (
    .clk_i              (clk),
    .rst_i              (rst_q),
    .bus_clk_i          (bus_clk),
    .bus_rst_i          (bus_rst_q),
    .dma_enable_i       (dma_enable),
    .dma_valid_o        (dma_valid),
    .dma_ready_i        (dma_ready),
    .dma_last_o         (dma_last),
    .dma_data_o         (dma_data),
    .s_axil_awvalid     (awvalid),
    .s_axil_awready     (awready),
    .s_axil_awaddr      (awaddr[7:0]),
    .s_axil_wvalid      (wvalid),
    .s_axil_wready      (wready),
    .s_axil_wdata       (wdata),
    .s_axil_wstrb       (wstrb),
    .s_axil_bvalid      (bvalid),
    .s_axil_bready      (bready),
    .s_axil_bresp       (bresp),
    .s_axil_arvalid     (arvalid),
    .s_axil_arready     (arready),
    .s_axil_araddr      (araddr[7:0]),
    .s_axil_rvalid      (rvalid),
    .s_axil_rready      (rready),
    .s_axil_rdata       (rdata),
    .s_axil_rresp       (rresp),
    .encoder_a_i        (encoder_a_i),
    .encoder_b_i        (encoder_b_i),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .frame_o            (frame),
    .packet_o           (packet)
  );

  // --- LEDs ---
  logic [23:0] clocks_q, bus_clocks_q;
  logic [10:0] frames_q, packets_q;
  always_ff @(posedge clk) begin
    clocks_q <= clocks_q + 1'b1;
    if (rst_q) frames_q <= '0;
    else if (frame) frames_q <= frames_q + 1'b1;
  end
  always_ff @(posedge bus_clk) begin
    bus_clocks_q <= bus_clocks_q + 1'b1;
    if (bus_rst_q) packets_q <= '0;
    else if (packet) packets_q <= packets_q + 1'b1;
  end
  assign led_o = {bus_clocks_q[23], packets_q[10], frames_q[10], clocks_q[23]};

endmodule

`default_nettype wire
