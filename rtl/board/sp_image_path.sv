// From beats to raw-image packets, one per line: the packer, the packets, and the packet FIFO into
// the bus clock.
//
// Guarantees: every line that began gives a packet or is counted in lost_o; packets come out whole.
// Lines may follow each other without a gap from 60 columns on, with 8 lanes from 176 on; with 16
// lanes they need a gap of 11 clocks. This module only connects sp_image_packer and
// sp_packet_output, which have the latency, the formats and the overflow rule.
`default_nettype none

module sp_image_path #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 1 or more
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Region = 1'b1,  // headers say where on the sensor frames begin
  parameter bit Wide = 1'b0,  // headers have the byte pixel
  parameter int LogDepth = 9,  // log2 of the depth of the packet FIFO, in beats of 16 bytes: 3..15
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  // Video clock domain
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // Beats, settings in force and breaks of sp_frame_tracker
  input  wire logic                  image_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic                  beat_valid_i,
  input  wire logic [8*Lanes-1:0]    beat_pixels_i,
  input  wire logic [1:0]            beat_group_i,  // low bits of the group
  input  wire logic [RowBits-1:0]    beat_row_i,
  input  wire logic                  beat_line_start_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0]    break_status_i,

  input  wire logic [sp_spec_pkg::HeaderBits-1:0] info_i,  // of sp_frame_info

  output logic      [31:0]           lost_o,

  // Bus clock domain: packets
  input  wire logic                  bus_clk_i,
  input  wire logic                  bus_rst_i,
  output logic                       m_valid_o,
  input  wire logic                  m_ready_i,
  output logic                       m_last_o,
  output logic      [127:0]          m_data_o
);

  localparam int StatusBits = sp_spec_pkg::StatusBits;
  localparam int PayloadBits = $clog2(MaxColumns / 16 + 2);

  logic                   line_done, accept, words_valid, words_break;
  logic [127:0]           words_data;
  logic [PayloadBits-1:0] line_words;
  logic [RowBits-1:0]     line_row;
  logic [StatusBits-1:0]  line_status;

  sp_image_packer #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .Lanes     (Lanes)
  ) u_packer (
    .clk_i            (clk_i),
    .rst_i            (rst_i),
    .image_i          (image_i),
    .columns_i        (columns_i),
    .beat_valid_i     (beat_valid_i),
    .beat_pixels_i    (beat_pixels_i),
    .beat_group_i     (beat_group_i),
    .beat_row_i       (beat_row_i),
    .beat_line_start_i(beat_line_start_i),
    .beat_line_end_i  (beat_line_end_i),
    .break_i          (break_i),
    .break_status_i   (break_status_i),
    .line_done_o      (line_done),
    .line_words_o     (line_words),
    .line_row_o       (line_row),
    .line_status_o    (line_status),
    .accept_i         (accept),
    .words_valid_o    (words_valid),
    .words_data_o     (words_data),
    .words_break_o    (words_break)
  );

  sp_packet_output #(
    .Kind       (sp_spec_pkg::KindImage),
    .ColumnBits (ColumnBits),
    .RowBits    (RowBits),
    .Region     (Region),
    .Wide       (Wide),
    .PayloadBits(PayloadBits),
    .LogDepth   (LogDepth)
  ) u_packets (
    .clk_i          (clk_i),
    .rst_i          (rst_i),
    .start_i        (line_done),
    .payload_beats_i(line_words),
    .line_i         (line_row),
    .spoiled_i      (1'b0),
    .break_i        (1'b0),
    .break_later_i  (1'b0),
    .start_status_i (line_status),
    .break_status_i ({StatusBits{1'b0}}),
    .accept_o       (accept),
    .payload_valid_i(words_valid),
    .payload_data_i (words_data),
    .payload_break_i(words_break),
    .tail_valid_i   (1'b0),
    .tail_i         (128'd0),
    .info_i         (info_i),
    .lost_o         (lost_o),
    .bus_clk_i      (bus_clk_i),
    .bus_rst_i      (bus_rst_i),
    .m_valid_o      (m_valid_o),
    .m_ready_i      (m_ready_i),
    .m_last_o       (m_last_o),
    .m_data_o       (m_data_o)
  );

endmodule

`default_nettype wire
