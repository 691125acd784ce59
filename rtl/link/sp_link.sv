// The board on a network: its packets leave in datagrams, and hosts read and write its registers by
// Etherbone. This module sits between sp_board and any UDP core.
//
//   requests ──▶ sp_etherbone ─▶ sp_link_registers ─▶ AXI4-Lite, to the board
//   answers ◀─┘                    │ start, owner
//                               sp_link_session
//                                  │ session, receiver
//   packets of the board ─▶ sp_datagram_cutter ─▶ datagrams
//
// Guarantees: those of the blocks. Packets go only to the address from which the board was started.
// Before the first start the link sends only answers, and none is longer than its request. While
// the board runs, no other address can write its registers. Reset: together with the board.
//
// source_o says where the video of the board comes from. A build with sp_replay wires its ports to
// the ports replay_*, and says by Sources, ReplayColumns and ReplayRows what it has.
// replay_enable_o is high while replay is the source and a session of packets is open; only the
// host datagram_to_o may replay then.
`default_nettype none

module sp_link #(
  parameter int DatagramBytes = 1472,  // longest datagram: 32..65535; 8972 in jumbo frames
  // log2 of the beats of 16 bytes that wait for the network: a whole datagram or more, up to 24
  parameter int LogDepth = DatagramBytes > 8192 ? $clog2(DatagramBytes / 16 + 1) : 9,
  parameter int IdleClocks = 5_000_000,  // silence after which the receiver is told: 2 or more
  parameter logic [3:0] Sources = 4'b0001,  // bit i: the build has source i of the register source
  parameter int ReplayColumns = 0,  // of the largest frame of replay: 0..2048; 0 without replay
  parameter int ReplayRows = 0  // of the largest frame of replay: 0..1023; 0 without replay
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,              // active high, synchronous

  // Requests: payloads that came to the UDP port of Etherbone, 1234
  input  wire logic         ask_valid_i,        // a word, which is taken at once
  input  wire logic         ask_last_i,         // last word of a datagram
  input  wire logic         ask_error_i,        // with the last word: the datagram is damaged
  input  wire logic [31:0]  ask_data_i,         // first byte of a word in 7..0
  input  wire logic [15:0]  ask_bytes_i,        // bytes of the datagram, with every word
  input  wire logic [31:0]  ask_from_i,         // address of the sender, with every word

  // Answers, to the same port of the sender
  output logic              answer_valid_o,     // from the first word of a datagram to its last
  input  wire logic         answer_ready_i,
  output logic              answer_last_o,
  output logic      [31:0]  answer_data_o,
  output logic      [15:0]  answer_bytes_o,
  output logic      [31:0]  answer_to_o,        // address of the receiver

  // Packets in datagrams, to the UDP port for packets, 1235
  output logic              datagram_valid_o,   // from the first word of a datagram to its last
  input  wire logic         datagram_ready_i,
  output logic              datagram_last_o,
  output logic      [31:0]  datagram_data_o,
  output logic      [15:0]  datagram_bytes_o,
  output logic      [31:0]  datagram_to_o,      // address of the receiver

  // Source of the video, and replay
  output logic      [1:0]   source_o,           // value of the register source
  output logic              replay_enable_o,
  output logic              replay_begin_o,     // one clock: a session of replay begins
  output logic      [15:0]  replay_session_o,   // its number, from then on
  input  wire logic [31:0]  replay_frame_i,     // what the registers of these names show
  input  wire logic [31:0]  replay_offset_i,
  input  wire logic [31:0]  replay_frames_i,
  input  wire logic [31:0]  replay_dropped_i,
  input  wire logic [31:0]  replay_ignored_i,

  // The board
  input  wire logic         s_axis_tvalid,      // packets
  output logic              s_axis_tready,
  input  wire logic [127:0] s_axis_tdata,
  input  wire logic         s_axis_tlast,
  output logic              m_axil_awvalid,     // registers
  input  wire logic         m_axil_awready,
  output logic      [7:0]   m_axil_awaddr,
  output logic              m_axil_wvalid,
  input  wire logic         m_axil_wready,
  output logic      [31:0]  m_axil_wdata,
  output logic      [3:0]   m_axil_wstrb,
  input  wire logic         m_axil_bvalid,
  output logic              m_axil_bready,
  input  wire logic [1:0]   m_axil_bresp,
  output logic              m_axil_arvalid,
  input  wire logic         m_axil_arready,
  output logic      [7:0]   m_axil_araddr,
  input  wire logic         m_axil_rvalid,
  output logic              m_axil_rready,
  input  wire logic [31:0]  m_axil_rdata,
  input  wire logic [1:0]   m_axil_rresp
);

  logic        request, write, answer, start, enable;
  logic [31:0] address, data, from, answer_data, owner;
  logic [15:0] session;

  sp_etherbone u_etherbone (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(ask_valid_i),
    .s_last_i (ask_last_i),
    .s_error_i(ask_error_i),
    .s_data_i (ask_data_i),
    .s_bytes_i(ask_bytes_i),
    .s_from_i (ask_from_i),
    .m_valid_o(answer_valid_o),
    .m_ready_i(answer_ready_i),
    .m_last_o (answer_last_o),
    .m_data_o (answer_data_o),
    .m_bytes_o(answer_bytes_o),
    .m_to_o   (answer_to_o),
    .request_o(request),
    .write_o  (write),
    .address_o(address),
    .data_o   (data),
    .from_o   (from),
    .answer_i (answer),
    .data_i   (answer_data)
  );

  assign replay_enable_o = enable && source_o == sp_spec_pkg::SourceReplay;

  sp_link_registers #(
    .Sources      (Sources),
    .ReplayColumns(ReplayColumns),
    .ReplayRows   (ReplayRows)
  ) u_registers (
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .request_i       (request),
    .write_i         (write),
    .address_i       (address),
    .data_i          (data),
    .from_i          (from),
    .answer_o        (answer),
    .data_o          (answer_data),
    .start_o         (start),
    .owner_o         (owner),
    .source_o        (source_o),
    .replay_begin_o  (replay_begin_o),
    .replay_session_o(replay_session_o),
    .replay_frame_i  (replay_frame_i),
    .replay_offset_i (replay_offset_i),
    .replay_frames_i (replay_frames_i),
    .replay_dropped_i(replay_dropped_i),
    .replay_ignored_i(replay_ignored_i),
    .m_axil_awvalid_o(m_axil_awvalid),
    .m_axil_awready_i(m_axil_awready),
    .m_axil_awaddr_o (m_axil_awaddr),
    .m_axil_wvalid_o (m_axil_wvalid),
    .m_axil_wready_i (m_axil_wready),
    .m_axil_wdata_o  (m_axil_wdata),
    .m_axil_wstrb_o  (m_axil_wstrb),
    .m_axil_bvalid_i (m_axil_bvalid),
    .m_axil_bready_o (m_axil_bready),
    .m_axil_bresp_i  (m_axil_bresp),
    .m_axil_arvalid_o(m_axil_arvalid),
    .m_axil_arready_i(m_axil_arready),
    .m_axil_araddr_o (m_axil_araddr),
    .m_axil_rvalid_i (m_axil_rvalid),
    .m_axil_rready_o (m_axil_rready),
    .m_axil_rdata_i  (m_axil_rdata),
    .m_axil_rresp_i  (m_axil_rresp)
  );

  sp_link_session u_session (
    .clk_i      (clk_i),
    .rst_i      (rst_i),
    .start_i    (start),
    .owner_i    (owner),
    .enable_o   (enable),
    .session_o  (session),
    .beat_i     (s_axis_tvalid && s_axis_tready),
    .beat_last_i(s_axis_tlast),
    .sending_i  (datagram_valid_o),
    .to_o       (datagram_to_o)
  );

  sp_datagram_cutter #(
    .DatagramBytes(DatagramBytes),
    .LogDepth     (LogDepth),
    .IdleClocks   (IdleClocks)
  ) u_cutter (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .enable_i (enable),
    .session_i(session),
    .s_valid_i(s_axis_tvalid),
    .s_ready_o(s_axis_tready),
    .s_last_i (s_axis_tlast),
    .s_data_i (s_axis_tdata),
    .m_valid_o(datagram_valid_o),
    .m_ready_i(datagram_ready_i),
    .m_last_o (datagram_last_o),
    .m_data_o (datagram_data_o),
    .m_bytes_o(datagram_bytes_o)
  );

endmodule

`default_nettype wire
