// Gray-code decoder with its state in on-chip memory for MaxColumns x MaxRows pixels and, with
// Median, the 3 x 3 median behind it. This module only connects sp_gray_decoder, sp_gray_memory and
// sp_median3x3.
`default_nettype none

module sp_gray_core #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,  // a multiple of 4; of Lanes
  parameter int MaxRows = sp_spec_pkg::MaxRows,  // 1 or more
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,  // 1..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  parameter bit Median = 1'b1,
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,

  // As the ports of sp_gray_decoder
  input  wire logic                  take_i,
  input  wire logic                  decode_i,
  input  wire logic [3:0]            bits_i,
  input  wire logic [7:0]            threshold_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic                  median_i,  // with take_i: send the median

  input  wire logic                  beat_valid_i,
  input  wire logic [8*Lanes-1:0]    beat_pixels_i,
  input  wire logic                  beat_line_start_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  beat_last_row_i,
  input  wire logic                  frame_start_i,
  input  wire logic                  break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,
  input  wire logic [15:0]           pattern_i,

  // first beat of codes of a frame, before the median
  output logic                       raw_start_o,
  output logic                       codes_valid_o,
  output logic      [16*Lanes-1:0]   codes_o,
  output logic                       codes_start_o,
  output logic                       codes_line_start_o,
  output logic                       codes_line_end_o,
  output logic                       codes_break_o,
  output logic [sp_spec_pkg::StatusBits-1:0] codes_status_o,

  output logic      [31:0]           abandoned_o
);

  localparam int WordBits = Lanes * (sp_spec_pkg::PixelBits + 2 * MaxBits);

  logic                read, read_first, write, write_first, frame_end_unused;
  logic [WordBits-1:0] read_data, write_data;

  logic                raw_valid, raw_start, raw_line_start, raw_line_end, raw_last_row, raw_break,
      busy;
  logic [16*Lanes-1:0] raw;
  logic [sp_spec_pkg::StatusBits-1:0] raw_status;

  sp_gray_decoder #(
    .MaxColumns(MaxColumns),
    .MaxRows   (MaxRows),
    .MaxBits   (MaxBits),
    .Lanes     (Lanes)
  ) u_decoder (
    .clk_i             (clk_i),
    .rst_i             (rst_i),
    .take_i            (take_i),
    .decode_i          (decode_i),
    .bits_i            (bits_i),
    .threshold_i       (threshold_i),
    .columns_i         (columns_i),
    .rows_i            (rows_i),
    .beat_valid_i      (beat_valid_i),
    .beat_pixels_i     (beat_pixels_i),
    .beat_line_start_i (beat_line_start_i),
    .beat_line_end_i   (beat_line_end_i),
    .beat_last_row_i   (beat_last_row_i),
    .frame_start_i     (frame_start_i),
    .break_i           (break_i),
    .break_status_i    (break_status_i),
    .pattern_i         (pattern_i),
    .mem_read_o        (read),
    .mem_read_first_o  (read_first),
    .mem_data_i        (read_data),
    .mem_late_i        (1'b0),
    .mem_write_o       (write),
    .mem_write_first_o (write_first),
    .mem_data_o        (write_data),
    .mem_end_o         (frame_end_unused),
    .busy_i            (busy),
    .codes_valid_o     (raw_valid),
    .codes_o           (raw),
    .codes_start_o     (raw_start),
    .codes_line_start_o(raw_line_start),
    .codes_line_end_o  (raw_line_end),
    .codes_last_row_o  (raw_last_row),
    .codes_break_o     (raw_break),
    .codes_status_o    (raw_status),
    .abandoned_o       (abandoned_o)
  );

  sp_gray_memory #(
    .Width(WordBits),
    .Words(MaxColumns / Lanes * MaxRows)
  ) u_memory (
    .clk_i     (clk_i),
    .rd_en_i   (read),
    .rd_first_i(read_first),
    .rd_data_o (read_data),
    .wr_en_i   (write),
    .wr_first_i(write_first),
    .wr_data_i (write_data)
  );

  assign raw_start_o = raw_start;

  if (Median) begin : gen_median
    // The setting for the frame whose first codes leave seven clocks after its start. If a later
    // frame has taken over another by then, the packets of the frame are dropped (sp_codes_path).
    logic median_q;

    always_ff @(posedge clk_i) if (take_i) median_q <= median_i;

    sp_median3x3 #(
      .MaxColumns(MaxColumns),
      .Lanes     (Lanes)
    ) u_median (
      .clk_i         (clk_i),
      .rst_i         (rst_i),
      .s_valid_i     (raw_valid),
      .s_codes_i     (raw),
      .s_start_i     (raw_start),
      .s_line_start_i(raw_line_start),
      .s_line_end_i  (raw_line_end),
      .s_last_row_i  (raw_last_row),
      .s_break_i     (raw_break),
      .s_status_i    (raw_status),
      .s_median_i    (median_q),
      .busy_o        (busy),
      .m_valid_o     (codes_valid_o),
      .m_codes_o     (codes_o),
      .m_start_o     (codes_start_o),
      .m_line_start_o(codes_line_start_o),
      .m_line_end_o  (codes_line_end_o),
      .m_break_o     (codes_break_o),
      .m_status_o    (codes_status_o)
    );
  end else begin : gen_raw
    logic unused;

    assign busy               = 1'b0;
    assign codes_valid_o      = raw_valid;
    assign codes_o            = raw;
    assign codes_start_o      = raw_start;
    assign codes_line_start_o = raw_line_start;
    assign codes_line_end_o   = raw_line_end;
    assign codes_break_o      = raw_break;
    assign codes_status_o     = raw_status;
    assign unused             = raw_last_row ^ median_i;
  end

endmodule

`default_nettype wire
