// What is in the FPGA of an ECPIX-5 apart from clocks and resets: camera, board, link, Ethernet.
//
//   sp_test_camera ─────┐
//   sp_parallel_sensor ─┼▶ sp_video_switch ─▶ sp_board ─▶ sp_link ─▶ LiteEth ─▶ RGMII
//   sp_replay ──────────┘       ▲                ▲          │ │        │
//      ▲                        │                └ registers┘ │        │
//      │                        └───────── register source ───┘        │
//      └────────────────── frames from the host ───────────────────────┘
//
// selfproj_liteeth is generated from liteeth.yml: MAC, ARP, IP, UDP, ICMP. The PHY chip brings the
// clock of RGMII. Both resets together, four clocks or more.
`default_nettype none

module ecpix5_system #(
  parameter logic [31:0] Address = 32'hC0A8_0132,  // IP address: 192.168.1.50
  parameter int MaxColumns = 512,
  parameter int MaxRows = 127,
  parameter bit Grey = 1'b1,
  parameter bit Image = 1'b1,
  parameter bit Region = 1'b0,
  parameter bit Compact = 1'b0,
  parameter bit Codes = 1'b0,
  parameter int CodeBits = 8,
  parameter bit Sensor = 1'b0,       // 1: the parallel sensor is the camera; 0: the test camera
  parameter bit Replay = 1'b1,       // frames from the host, with a memory for one of the largest
  parameter int CameraRows = 96,     // of the test camera's image
  parameter int FrameClocks = 12_500,  // of the test camera: 10,000 frames a second at 125 MHz
  parameter int DatagramBytes = 1472,  // longest datagram with packets; 8972 in jumbo frames
  parameter int LinkLogDepth = 12,   // 64 KiB: 1 ms of packets while the network looks for a host
  parameter int IdleClocks = 2_500_000  // 50 ms
) (
  input  wire logic       clk_i,        // pixel clock
  input  wire logic       rst_i,
  input  wire logic       bus_clk_i,    // 31.25 MHz or more
  input  wire logic       bus_rst_i,

  // RGMII
  input  wire logic       eth_rx_clk_i,  // 125 MHz
  input  wire logic       eth_rx_ctl_i,
  input  wire logic [3:0] eth_rx_data_i,
  output logic            eth_tx_clk_o,
  output logic            eth_tx_ctl_o,
  output logic      [3:0] eth_tx_data_o,
  output logic            eth_mdc_o,    // management of the PHY chip, which nothing here uses
  inout  wire logic       eth_mdio_io,

  // Parallel sensor
  input  wire logic       sensor_clk_i,
  input  wire logic       sensor_frame_i,
  input  wire logic       sensor_line_i,
  input  wire logic [9:0] sensor_data_i,

  input  wire logic       encoder_a_i,
  input  wire logic       encoder_b_i,
  output logic            projector_trigger_o,
  output logic            camera_trigger_o,

  // For LEDs
  output logic            frame_o,      // a beat that begins a frame
  output logic            datagram_o,   // the last word of a datagram
  output logic            overrun_o     // a frame of the sensor is cut off
);

  // UDP ports, as host/driver has them; that of replay is sp_spec_pkg::ReplayPort
  localparam logic [15:0] ControlPort = 16'd1234;
  localparam logic [15:0] PacketPort = 16'd1235;

  // --- Camera, test camera, replay ---
  // Sources of the switch; source i of the register source is the switch's source i, but without a
  // sensor the test camera is the camera, and it shows the patterns, too.
  localparam int Sources = 3;
  localparam logic [3:0] Built = {1'b1, Replay, 2'b11};

  logic [Sources-1:0]    source_valid, source_start, source_end, select_q;
  logic [Sources*32-1:0] source_data;
  logic [1:0]            source;
  logic                  patterns_q;
  logic                  video_valid, video_start, video_end;
  logic [31:0]           video_data;

  if (Sensor) begin : gen_sensor
    sp_parallel_sensor #(
      .Bits          (10),
      .PixelsPerClock(1)
    ) u_camera (
      .sensor_clk_i(sensor_clk_i),
      .frame_i     (sensor_frame_i),
      .line_i      (sensor_line_i),
      .data_i      (sensor_data_i),
      .clk_i       (clk_i),
      .rst_i       (rst_i),
      .m_valid_o   (source_valid[sp_spec_pkg::SourceCamera]),
      .m_data_o    (source_data[32*sp_spec_pkg::SourceCamera+:32]),
      .m_start_o   (source_start[sp_spec_pkg::SourceCamera]),
      .m_end_o     (source_end[sp_spec_pkg::SourceCamera]),
      .overrun_o   (overrun_o)
    );
  end else begin : gen_no_sensor
    logic unused;
    assign unused = ^{sensor_clk_i, sensor_frame_i, sensor_line_i, sensor_data_i};
    assign overrun_o       = 1'b0;
    assign source_valid[0] = source_valid[1];
    assign source_data[0+:32] = source_data[32+:32];
    assign source_start[0] = source_start[1];
    assign source_end[0]   = source_end[1];
  end

  logic patterns;
  sp_sync u_patterns (
    .clk_i(clk_i),
    .rst_i(rst_i),
    .d_i  (patterns_q),
    .q_o  (patterns)
  );

  sp_test_camera #(
    .Columns    (MaxColumns),
    .Rows       (CameraRows),
    .FrameClocks(FrameClocks),
    .CodeBits   (CodeBits)
  ) u_test_camera (
    .clk_i     (clk_i),
    .rst_i     (rst_i),
    .run_i     (1'b1),
    .trigger_i (camera_trigger_o),
    .patterns_i(patterns),
    .m_valid_o(source_valid[sp_spec_pkg::SourceTestCamera]),
    .m_data_o (source_data[32*sp_spec_pkg::SourceTestCamera+:32]),
    .m_start_o(source_start[sp_spec_pkg::SourceTestCamera]),
    .m_end_o  (source_end[sp_spec_pkg::SourceTestCamera])
  );

  logic        replay_valid, replay_last, replay_error, replay_enable, replay_begin;
  logic [15:0] replay_bytes, replay_session;
  logic [31:0] replay_data, replay_from;
  logic [31:0] replay_frame, replay_offset, replay_frames, replay_dropped, replay_ignored;
  logic [31:0] datagram_to;

  if (Replay) begin : gen_replay
    sp_replay #(
      .MaxColumns(MaxColumns),
      .MaxRows   (MaxRows)
    ) u_replay (
      .bus_clk_i(bus_clk_i),
      .bus_rst_i(bus_rst_i),
      .s_valid_i(replay_valid),
      .s_last_i (replay_last),
      .s_error_i(replay_error),
      .s_data_i (replay_data),
      .s_bytes_i(replay_bytes),
      .s_from_i (replay_from),
      .enable_i (replay_enable),
      .host_i   (datagram_to),
      .begin_i  (replay_begin),
      .session_i(replay_session),
      .frame_o  (replay_frame),
      .offset_o (replay_offset),
      .frames_o (replay_frames),
      .dropped_o(replay_dropped),
      .ignored_o(replay_ignored),
      .clk_i    (clk_i),
      .rst_i    (rst_i),
      .m_valid_o(source_valid[sp_spec_pkg::SourceReplay]),
      .m_data_o (source_data[32*sp_spec_pkg::SourceReplay+:32]),
      .m_start_o(source_start[sp_spec_pkg::SourceReplay]),
      .m_end_o  (source_end[sp_spec_pkg::SourceReplay])
    );
  end else begin : gen_no_replay
    logic unused;
    assign unused = ^{replay_valid, replay_last, replay_error, replay_data, replay_bytes,
                      replay_from, replay_enable, replay_begin, replay_session};
    assign {replay_frame, replay_offset, replay_frames, replay_dropped, replay_ignored} = '0;
    assign source_valid[2]     = 1'b0;
    assign source_data[64+:32] = '0;
    assign source_start[2]     = 1'b0;
    assign source_end[2]       = 1'b0;
  end

  always_ff @(posedge bus_clk_i) begin
    patterns_q <= source == sp_spec_pkg::SourcePatterns;
    select_q   <= Sources'(1) << (source == sp_spec_pkg::SourcePatterns ?
                                  sp_spec_pkg::SourceTestCamera : source);
  end

  sp_video_switch #(
    .Sources(Sources)
  ) u_switch (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .select_i (select_q),
    .s_valid_i(source_valid),
    .s_data_i (source_data),
    .s_start_i(source_start),
    .s_end_i  (source_end),
    .m_valid_o(video_valid),
    .m_data_o (video_data),
    .m_start_o(video_start),
    .m_end_o  (video_end)
  );
  assign frame_o = video_valid && video_start;

  // --- Board ---
  logic         packet_valid, packet_ready, packet_last, unused_ready;
  logic [127:0] packet_data;
  logic         awvalid, awready, wvalid, wready, bvalid, bready, arvalid, arready, rvalid, rready;
  logic [7:0]   awaddr, araddr;
  logic [31:0]  wdata, rdata;
  logic [3:0]   wstrb;
  logic [1:0]   bresp, rresp;

  logic unused_ejector;
  sp_board #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .Grey      (Grey),
    .Image     (Image),
    .Region    (Region),
    .Compact   (Compact),
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
    .s_axil_awvalid     (awvalid),
    .s_axil_awready     (awready),
    .s_axil_awaddr      (awaddr),
    .s_axil_wvalid      (wvalid),
    .s_axil_wready      (wready),
    .s_axil_wdata       (wdata),
    .s_axil_wstrb       (wstrb),
    .s_axil_bvalid      (bvalid),
    .s_axil_bready      (bready),
    .s_axil_bresp       (bresp),
    .s_axil_arvalid     (arvalid),
    .s_axil_arready     (arready),
    .s_axil_araddr      (araddr),
    .s_axil_rvalid      (rvalid),
    .s_axil_rready      (rready),
    .s_axil_rdata       (rdata),
    .s_axil_rresp       (rresp)
  );

  // --- Link ---
  logic        ask_valid, ask_last, ask_error, answer_valid, answer_ready, answer_last;
  logic        datagram_valid, datagram_ready, datagram_last;
  logic [31:0] ask_data, ask_from, answer_data, answer_to, datagram_data;
  logic [15:0] ask_bytes, answer_bytes, datagram_bytes;

  sp_link #(
    .DatagramBytes(DatagramBytes),
    .LogDepth     (LinkLogDepth),
    .IdleClocks   (IdleClocks),
    .Sources      (Built),
    .ReplayColumns(Replay ? MaxColumns : 0),
    .ReplayRows   (Replay ? MaxRows : 0)
  ) u_link (
    .clk_i           (bus_clk_i),
    .rst_i           (bus_rst_i),
    .ask_valid_i     (ask_valid),
    .ask_last_i      (ask_last),
    .ask_error_i     (ask_error),
    .ask_data_i      (ask_data),
    .ask_bytes_i     (ask_bytes),
    .ask_from_i      (ask_from),
    .answer_valid_o  (answer_valid),
    .answer_ready_i  (answer_ready),
    .answer_last_o   (answer_last),
    .answer_data_o   (answer_data),
    .answer_bytes_o  (answer_bytes),
    .answer_to_o     (answer_to),
    .datagram_valid_o(datagram_valid),
    .datagram_ready_i(datagram_ready),
    .datagram_last_o (datagram_last),
    .datagram_data_o (datagram_data),
    .datagram_bytes_o(datagram_bytes),
    .datagram_to_o   (datagram_to),
    .source_o        (source),
    .replay_enable_o (replay_enable),
    .replay_begin_o  (replay_begin),
    .replay_session_o(replay_session),
    .replay_frame_i  (replay_frame),
    .replay_offset_i (replay_offset),
    .replay_frames_i (replay_frames),
    .replay_dropped_i(replay_dropped),
    .replay_ignored_i(replay_ignored),
    .s_axis_tvalid   (packet_valid),
    .s_axis_tready   (packet_ready),
    .s_axis_tdata    (packet_data),
    .s_axis_tlast    (packet_last),
    .m_axil_awvalid  (awvalid),
    .m_axil_awready  (awready),
    .m_axil_awaddr   (awaddr),
    .m_axil_wvalid   (wvalid),
    .m_axil_wready   (wready),
    .m_axil_wdata    (wdata),
    .m_axil_wstrb    (wstrb),
    .m_axil_bvalid   (bvalid),
    .m_axil_bready   (bready),
    .m_axil_bresp    (bresp),
    .m_axil_arvalid  (arvalid),
    .m_axil_arready  (arready),
    .m_axil_araddr   (araddr),
    .m_axil_rvalid   (rvalid),
    .m_axil_rready   (rready),
    .m_axil_rdata    (rdata),
    .m_axil_rresp    (rresp)
  );
  assign datagram_o = datagram_valid && datagram_ready && datagram_last;

  // LiteEth fills short frames up in whole words of 32 bits. A datagram of 16 bytes makes a frame
  // of 62, two less than Ethernet allows, which LiteEth takes for long enough. A word is added.
  localparam logic [15:0] TooShort = 16'd16;
  logic        fill_q;  // the word more is at the output
  logic        short_frame, packets_valid, packets_ready, packets_last;
  logic [15:0] packets_bytes;
  logic [31:0] packets_data;
  assign short_frame    = datagram_bytes == TooShort;
  assign packets_valid  = fill_q || datagram_valid;
  assign packets_last   = fill_q || datagram_last && !short_frame;
  assign packets_data   = fill_q ? '0 : datagram_data;
  assign packets_bytes  = fill_q || short_frame ? TooShort + 16'd4 : datagram_bytes;
  assign datagram_ready = packets_ready && !fill_q;
  always_ff @(posedge bus_clk_i) begin
    if (bus_rst_i || packets_ready && fill_q) fill_q <= 1'b0;
    else if (datagram_valid && datagram_ready && datagram_last && short_frame) fill_q <= 1'b1;
  end

  // --- Ethernet ---
  // Words are whole; LiteEth marks the last byte of the last word.
  localparam logic [3:0] WholeWord = 4'b1000;

  logic        unused_rst_n, unused_packets_error, unused_packets_last;
  logic        unused_packets_valid, unused_replay_ready;
  logic [3:0]  unused_replay_last_be;
  logic [15:0] unused_replay_dst, unused_replay_src;
  logic [3:0]  unused_control_last_be, unused_packets_last_be;
  logic [15:0] unused_control_dst, unused_control_src, unused_packets_dst, unused_packets_length;
  logic [15:0] unused_packets_src;
  logic [31:0] unused_packets_data, unused_packets_from;

  selfproj_liteeth u_ethernet (
    .sys_clock                (bus_clk_i),
    .sys_reset                (bus_rst_i),
    .ip_address               (Address),
    .rgmii_clocks_rx          (eth_rx_clk_i),
    .rgmii_clocks_tx          (eth_tx_clk_o),
    .rgmii_int_n              (1'b1),
    .rgmii_mdc                (eth_mdc_o),
    .rgmii_mdio               (eth_mdio_io),
    .rgmii_rst_n              (unused_rst_n),
    .rgmii_rx_ctl             (eth_rx_ctl_i),
    .rgmii_rx_data            (eth_rx_data_i),
    .rgmii_tx_ctl             (eth_tx_ctl_o),
    .rgmii_tx_data            (eth_tx_data_o),
    .control_source_valid     (ask_valid),
    .control_source_ready     (1'b1),
    .control_source_last      (ask_last),
    .control_source_last_be   (unused_control_last_be),
    .control_source_data      (ask_data),
    .control_source_length    (ask_bytes),
    .control_source_ip_address(ask_from),
    .control_source_dst_port  (unused_control_dst),
    .control_source_src_port  (unused_control_src),
    .control_source_error     (ask_error),
    .control_sink_valid       (answer_valid),
    .control_sink_ready       (answer_ready),
    .control_sink_last        (answer_last),
    .control_sink_last_be     (answer_last ? WholeWord : 4'b0000),
    .control_sink_data        (answer_data),
    .control_sink_length      (answer_bytes),
    .control_sink_ip_address  (answer_to),
    .control_sink_dst_port    (ControlPort),
    .control_sink_src_port    (ControlPort),
    .packets_source_valid     (unused_packets_valid),
    .packets_source_ready     (1'b1),
    .packets_source_last      (unused_packets_last),
    .packets_source_last_be   (unused_packets_last_be),
    .packets_source_data      (unused_packets_data),
    .packets_source_length    (unused_packets_length),
    .packets_source_ip_address(unused_packets_from),
    .packets_source_dst_port  (unused_packets_dst),
    .packets_source_src_port  (unused_packets_src),
    .packets_source_error     (unused_packets_error),
    .packets_sink_valid       (packets_valid),
    .packets_sink_ready       (packets_ready),
    .packets_sink_last        (packets_last),
    .packets_sink_last_be     (packets_last ? WholeWord : 4'b0000),
    .packets_sink_data        (packets_data),
    .packets_sink_length      (packets_bytes),
    .packets_sink_ip_address  (datagram_to),
    .packets_sink_dst_port    (PacketPort),
    .packets_sink_src_port    (PacketPort),
    .replay_source_valid      (replay_valid),
    .replay_source_ready      (1'b1),
    .replay_source_last       (replay_last),
    .replay_source_last_be    (unused_replay_last_be),
    .replay_source_data       (replay_data),
    .replay_source_length     (replay_bytes),
    .replay_source_ip_address (replay_from),
    .replay_source_dst_port   (unused_replay_dst),
    .replay_source_src_port   (unused_replay_src),
    .replay_source_error      (replay_error),
    .replay_sink_valid        (1'b0),
    .replay_sink_ready        (unused_replay_ready),
    .replay_sink_last         (1'b0),
    .replay_sink_last_be      (4'b0000),
    .replay_sink_data         (32'd0),
    .replay_sink_length       (16'd0),
    .replay_sink_ip_address   (32'd0),
    .replay_sink_dst_port     (sp_spec_pkg::ReplayPort),
    .replay_sink_src_port     (sp_spec_pkg::ReplayPort)
  );

endmodule

`default_nettype wire
