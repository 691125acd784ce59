// Top of the ECPIX-5 with the LFE5UM5G-85F: pins, clocks, resets and LEDs around ecpix5_system.
//
// Clocks, by the PLL from the board's 100 MHz: pixel clock 125 MHz, bus clock 50 MHz; with Fast
// 133.3 MHz and 53.3 MHz. The PHY chip gives the third, of RGMII. Reset: while the PLL is not locked or the button is held, and 256
// clocks more.
//
// LEDs show events by changes, so that it does not matter which level lights them. LED 0, green,
// blinks three times a second while the bus clock runs. LED 1, green, changes after every 1024
// frames of the camera; LED 2, green, after every 1024 datagrams; LED 3, red, with every frame of
// the sensor that is cut off.
`default_nettype none

module ecpix5 #(
  parameter logic [31:0] Address = 32'hC0A8_0132,  // IP address: 192.168.1.50
  parameter int MaxColumns = 512,
  parameter int MaxRows = 127,
  parameter bit Grey = 1'b1,
  parameter bit Image = 1'b1,
  parameter bit Region = 1'b0,
  parameter bit Compact = 1'b0,
  parameter bit Codes = 1'b0,
  parameter int CodeBits = 8,
  parameter bit Sensor = 1'b0,       // 1: the parallel sensor; 0: the test camera
  parameter bit Fast = 1'b0,         // pixel clock 133.3 MHz
  parameter int CameraRows = 96,     // of the test camera's image
  parameter int FrameClocks = 12_500,  // of the test camera: 10,000 frames a second
  parameter int DatagramBytes = 1472  // longest datagram with packets; 8972 in jumbo frames
) (
  input  wire logic       clk100_i,
  input  wire logic       rst_n_i,      // button

  input  wire logic       eth_rx_clk_i,
  input  wire logic       eth_rx_ctl_i,
  input  wire logic [3:0] eth_rx_data_i,
  output logic            eth_tx_clk_o,
  output logic            eth_tx_ctl_o,
  output logic      [3:0] eth_tx_data_o,
  output logic            eth_rst_n_o,
  output logic            eth_mdc_o,
  inout  wire logic       eth_mdio_io,

  input  wire logic       encoder_a_i,
  input  wire logic       encoder_b_i,
  output logic            projector_trigger_o,
  output logic            camera_trigger_o,

  input  wire logic       sensor_clk_i,
  input  wire logic       sensor_frame_i,
  input  wire logic       sensor_line_i,
  input  wire logic [9:0] sensor_data_i,

  output logic            led_clock_o,
  output logic            led_frames_o,
  output logic            led_datagrams_o,
  output logic            led_overrun_o
);

  // --- Clocks ---
  logic clk, bus_clk, locked, unused_secondary2, unused_secondary3, unused_intlock, unused_refclk;
  logic unused_clkintfb;

  // The detector runs at 25 MHz, the oscillator at 500 MHz; with Fast at 33.3 MHz and 533.3 MHz.
  (* ICP_CURRENT = "12", LPF_RESISTOR = "8" *)
  EHXPLLL #(
    .PLLRST_ENA      ("DISABLED"),
    .INTFB_WAKE      ("DISABLED"),
    .STDBY_ENABLE    ("DISABLED"),
    .DPHASE_SOURCE   ("DISABLED"),
    .OUTDIVIDER_MUXA ("DIVA"),
    .OUTDIVIDER_MUXB ("DIVB"),
    .OUTDIVIDER_MUXC ("DIVC"),
    .OUTDIVIDER_MUXD ("DIVD"),
    .CLKI_DIV        (Fast ? 3 : 4),
    .CLKFB_DIV       (Fast ? 4 : 5),
    .FEEDBK_PATH     ("CLKOP"),
    .CLKOP_ENABLE    ("ENABLED"),
    .CLKOP_DIV       (4),
    .CLKOP_CPHASE    (3),
    .CLKOP_FPHASE    (0),
    .CLKOS_ENABLE    ("ENABLED"),
    .CLKOS_DIV       (10),
    .CLKOS_CPHASE    (9),
    .CLKOS_FPHASE    (0)
  ) u_pll (
    .CLKI        (clk100_i),
    .CLKFB       (clk),
    .RST         (1'b0),
    .STDBY       (1'b0),
    .PHASESEL0   (1'b0),
    .PHASESEL1   (1'b0),
    .PHASEDIR    (1'b1),
    .PHASESTEP   (1'b1),
    .PHASELOADREG(1'b1),
    .PLLWAKESYNC (1'b0),
    .ENCLKOP     (1'b0),
    .ENCLKOS     (1'b0),
    .ENCLKOS2    (1'b0),
    .ENCLKOS3    (1'b0),
    .CLKOP       (clk),
    .CLKOS       (bus_clk),
    .CLKOS2      (unused_secondary2),
    .CLKOS3      (unused_secondary3),
    .LOCK        (locked),
    .INTLOCK     (unused_intlock),
    .REFCLK      (unused_refclk),
    .CLKINTFB    (unused_clkintfb)
  );

  // --- Resets ---
  logic       good, good_bus;
  logic [8:0] wait_q, wait_bus_q;
  logic       rst_q, bus_rst_q;

  sp_sync u_good (
    .clk_i(clk),
    .rst_i(1'b0),
    .d_i  (locked && rst_n_i),
    .q_o  (good)
  );

  sp_sync u_good_bus (
    .clk_i(bus_clk),
    .rst_i(1'b0),
    .d_i  (locked && rst_n_i),
    .q_o  (good_bus)
  );

  always_ff @(posedge clk) begin
    wait_q <= !good ? '0 : wait_q[8] ? wait_q : wait_q + 1'b1;
    rst_q  <= !wait_q[8];
  end
  always_ff @(posedge bus_clk) begin
    wait_bus_q <= !good_bus ? '0 : wait_bus_q[8] ? wait_bus_q : wait_bus_q + 1'b1;
    bus_rst_q  <= !wait_bus_q[8];
  end

  // The PHY chip rests for 20 ms or almost after the board's reset.
  logic [20:0] phy_q;
  always_ff @(posedge bus_clk) begin
    if (bus_rst_q) phy_q <= '0;
    else if (!phy_q[20]) phy_q <= phy_q + 1'b1;
    eth_rst_n_o <= phy_q[20];
  end

  // --- The rest ---
  logic frame, datagram, overrun;

  ecpix5_system #(
    .Address      (Address),
    .MaxColumns   (MaxColumns),
    .MaxRows      (MaxRows),
    .Grey         (Grey),
    .Image        (Image),
    .Region       (Region),
    .Compact      (Compact),
    .Codes        (Codes),
    .CodeBits     (CodeBits),
    .Sensor       (Sensor),
    .CameraRows   (CameraRows),
    .FrameClocks  (FrameClocks),
    .DatagramBytes(DatagramBytes)
  ) u_system (
    .clk_i              (clk),
    .rst_i              (rst_q),
    .bus_clk_i          (bus_clk),
    .bus_rst_i          (bus_rst_q),
    .eth_rx_clk_i       (eth_rx_clk_i),
    .eth_rx_ctl_i       (eth_rx_ctl_i),
    .eth_rx_data_i      (eth_rx_data_i),
    .eth_tx_clk_o       (eth_tx_clk_o),
    .eth_tx_ctl_o       (eth_tx_ctl_o),
    .eth_tx_data_o      (eth_tx_data_o),
    .eth_mdc_o          (eth_mdc_o),
    .eth_mdio_io        (eth_mdio_io),
    .sensor_clk_i       (sensor_clk_i),
    .sensor_frame_i     (sensor_frame_i),
    .sensor_line_i      (sensor_line_i),
    .sensor_data_i      (sensor_data_i),
    .encoder_a_i        (encoder_a_i),
    .encoder_b_i        (encoder_b_i),
    .projector_trigger_o(projector_trigger_o),
    .camera_trigger_o   (camera_trigger_o),
    .frame_o            (frame),
    .datagram_o         (datagram),
    .overrun_o          (overrun)
  );

  // --- LEDs ---
  logic [23:0] clocks_q;
  logic [10:0] frames_q, datagrams_q;
  always_ff @(posedge bus_clk) begin
    clocks_q <= clocks_q + 1'b1;
    if (bus_rst_q) datagrams_q <= '0;
    else if (datagram) datagrams_q <= datagrams_q + 1'b1;
  end
  always_ff @(posedge clk) begin
    if (rst_q) frames_q <= '0;
    else if (frame) frames_q <= frames_q + 1'b1;
    if (rst_q) led_overrun_o <= 1'b0;
    else if (overrun) led_overrun_o <= !led_overrun_o;
  end
  assign led_clock_o     = clocks_q[23];
  assign led_frames_o    = frames_q[10];
  assign led_datagrams_o = datagrams_q[10];

endmodule

`default_nettype wire
