// The translated shell of the strongest runs together with its memories. It has the ports of
// sp_column_runs for the default maxima.
`default_nettype none

module sp_column_runs_hls (
  input  wire logic         clk_i,
  input  wire logic         rst_i,
  input  wire logic         beat_valid_i,
  input  wire logic [31:0]  beat_pixels_i,
  input  wire logic [8:0]   beat_group_i,
  input  wire logic [9:0]   beat_row_i,
  input  wire logic         beat_first_row_i,
  input  wire logic         beat_last_row_i,
  input  wire logic         beat_line_end_i,
  input  wire logic [1:0]   mode_i,
  input  wire logic [7:0]   threshold_i,
  input  wire logic         strongest_i,
  input  wire logic [1:0]   gap_i,
  input  wire logic         break_i,
  input  wire logic         accept_i,
  output logic              moments_valid_o,
  output logic      [127:0] moments_data_o,
  output logic              moments_break_o,
  output logic              spoiled_o
);

  logic        rd_en, wr_en, line_rd_en, line_wr_en;
  logic [8:0]  rd_addr, wr_addr, line_rd_addr, line_wr_addr;
  logic [231:0] open_rd, open_wr;  // of four lanes
  logic [151:0] best_rd, best_wr;
  logic [187:0] rest_rd, rest_wr;
  logic [31:0] line_rd_data, line_wr_data;

  hls_ColumnRunsShell u_shell (
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .beat_valid_i    (beat_valid_i),
    .beat_pixels_i   (beat_pixels_i),
    .beat_group_i    (beat_group_i),
    .beat_row_i      (beat_row_i),
    .beat_first_row_i(beat_first_row_i),
    .beat_last_row_i (beat_last_row_i),
    .beat_line_end_i (beat_line_end_i),
    .mode_i          (mode_i),
    .threshold_i     (threshold_i),
    .strongest_i     (strongest_i),
    .gap_i           (gap_i),
    .break_i         (break_i),
    .accept_i        (accept_i),
    .moments_valid_o (moments_valid_o),
    .moments_data_o  (moments_data_o),
    .moments_break_o (moments_break_o),
    .spoiled_o       (spoiled_o),
    .rd_en_o         (rd_en),
    .rd_addr_o       (rd_addr),
    .wr_en_o         (wr_en),
    .wr_addr_o       (wr_addr),
    .open_rd_i       (open_rd),
    .open_wr_o       (open_wr),
    .best_rd_i       (best_rd),
    .best_wr_o       (best_wr),
    .rest_rd_i       (rest_rd),
    .rest_wr_o       (rest_wr),
    .line_rd_en_o    (line_rd_en),
    .line_rd_addr_o  (line_rd_addr),
    .line_rd_data_i  (line_rd_data),
    .line_wr_en_o    (line_wr_en),
    .line_wr_addr_o  (line_wr_addr),
    .line_wr_data_o  (line_wr_data)
  );

  sp_ram #(.Width(232), .LogDepth(9)) u_open (
    .wr_clk_i(clk_i), .wr_en_i(wr_en), .wr_addr_i(wr_addr), .wr_data_i(open_wr),
    .rd_clk_i(clk_i), .rd_en_i(rd_en), .rd_addr_i(rd_addr), .rd_data_o(open_rd)
  );
  sp_ram #(.Width(152), .LogDepth(9)) u_best (
    .wr_clk_i(clk_i), .wr_en_i(wr_en), .wr_addr_i(wr_addr), .wr_data_i(best_wr),
    .rd_clk_i(clk_i), .rd_en_i(rd_en), .rd_addr_i(rd_addr), .rd_data_o(best_rd)
  );
  sp_ram #(.Width(188), .LogDepth(9)) u_rest (
    .wr_clk_i(clk_i), .wr_en_i(wr_en), .wr_addr_i(wr_addr), .wr_data_i(rest_wr),
    .rd_clk_i(clk_i), .rd_en_i(rd_en), .rd_addr_i(rd_addr), .rd_data_o(rest_rd)
  );
  sp_ram #(.Width(32), .LogDepth(9)) u_line (
    .wr_clk_i(clk_i), .wr_en_i(line_wr_en), .wr_addr_i(line_wr_addr), .wr_data_i(line_wr_data),
    .rd_clk_i(clk_i), .rd_en_i(line_rd_en), .rd_addr_i(line_rd_addr), .rd_data_o(line_rd_data)
  );

endmodule

`default_nettype wire
