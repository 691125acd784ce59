// The end of every packet path: sp_packetizer, and behind it the sp_packet_fifo into the bus clock.
//
// Guarantees: each request gives a packet or is counted in lost_o; packets come out whole. This
// module only connects the two, which have the latency and the overflow rule.
`default_nettype none

module sp_packet_output #(
  parameter logic [7:0] Kind = sp_spec_pkg::KindMoments,
  parameter bit         KindOfFrame = 1'b0,  // the kind is that of info_i, one packet per frame
  parameter int         ColumnBits = 12,  // 1..16
  parameter int         RowBits = 10,  // 1..16
  parameter bit         Region = 1'b1,  // headers say where on the sensor frames begin
  parameter bit         Wide = 1'b0,  // headers have the byte pixel
  parameter bit         Tail = 1'b0,  // there is tail_i
  parameter int         PayloadBits = 11,  // of the number of payload beats: 1..28
  parameter int         LogDepth = 11  // log2 of the depth of the FIFO, in beats of 16 bytes: 3..15
) (
  // Video clock domain: the ports of sp_packetizer
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  input  wire logic                   start_i,
  input  wire logic [PayloadBits-1:0] payload_beats_i,
  input  wire logic [RowBits-1:0]     line_i,
  input  wire logic                   spoiled_i,
  input  wire logic                   break_i,
  input  wire logic                   break_later_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] start_status_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,
  output logic                        accept_o,

  input  wire logic                   payload_valid_i,
  input  wire logic [127:0]           payload_data_i,
  input  wire logic                   payload_break_i,
  input  wire logic                   tail_valid_i,
  input  wire logic [127:0]           tail_i,

  input  wire logic [sp_spec_pkg::HeaderBits-1:0] info_i,

  output logic      [31:0]            lost_o,

  // Bus clock domain: packets
  input  wire logic                   bus_clk_i,
  input  wire logic                   bus_rst_i,
  output logic                        m_valid_o,
  input  wire logic                   m_ready_i,
  output logic                        m_last_o,
  output logic      [127:0]           m_data_o
);

  // Beats of a packet without payload
  localparam int Overhead =
    (sp_spec_pkg::HeaderBytes + sp_spec_pkg::TrailerBytes) / sp_spec_pkg::PacketBeatBytes;

  logic [LogDepth:0] free;
  logic              put, put_last;
  logic [127:0]      put_data;

  sp_packetizer #(
    .Kind       (Kind),
    .KindOfFrame(KindOfFrame),
    .ColumnBits (ColumnBits),
    .RowBits    (RowBits),
    .Region     (Region),
    .Wide       (Wide),
    .Tail       (Tail),
    .PayloadBits(PayloadBits),
    .LogDepth   (LogDepth)
  ) u_packetizer (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .start_i        (start_i),
    .payload_beats_i(payload_beats_i),
    .line_i         (line_i),
    .spoiled_i      (spoiled_i),
    .break_i        (break_i),
    .break_later_i  (break_later_i),
    .start_status_i (start_status_i),
    .break_status_i (break_status_i),
    .accept_o       (accept_o),
    .payload_valid_i(payload_valid_i),
    .payload_data_i (payload_data_i),
    .payload_break_i(payload_break_i),
    .tail_valid_i   (tail_valid_i),
    .tail_i         (tail_i),
    .info_i         (info_i),
    .fifo_free_i    (free),
    .fifo_valid_o   (put),
    .fifo_last_o    (put_last),
    .fifo_data_o    (put_data),
    .lost_o         (lost_o)
  );

  sp_packet_fifo #(
    .Width      (128),
    .LogDepth   (LogDepth),
    .PacketWords(Overhead)
  ) u_fifo (
    .wr_clk_i  (clk_i),
    .wr_rst_i  (rst_i),
    .wr_valid_i(put),
    .wr_last_i (put_last),
    .wr_data_i (put_data),
    .wr_free_o (free),
    .rd_clk_i  (bus_clk_i),
    .rd_rst_i  (bus_rst_i),
    .rd_valid_o(m_valid_o),
    .rd_ready_i(m_ready_i),
    .rd_last_o (m_last_o),
    .rd_data_o (m_data_o)
  );

endmodule

`default_nettype wire
