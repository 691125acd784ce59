// The translated shell of the column moments together with its memories. It has the ports of
// sp_column_moments for the default maxima.
`default_nettype none

module sp_column_moments_hls (
  input  wire logic         clk_i,
  input  wire logic         rst_i,
  input  wire logic         beat_valid_i,
  input  wire logic [31:0]  beat_pixels_i,
  input  wire logic [8:0]   beat_group_i,
  input  wire logic [9:0]   beat_row_i,
  input  wire logic         beat_first_row_i,
  input  wire logic         beat_last_row_i,
  input  wire logic         beat_line_end_i,
  input  wire logic         one_group_i,
  input  wire logic         two_groups_i,
  input  wire logic [1:0]   mode_i,
  input  wire logic [7:0]   threshold_i,
  input  wire logic         break_i,
  input  wire logic         accept_i,
  output logic              moments_valid_o,
  output logic      [127:0] moments_data_o,
  output logic              moments_break_o,
  output logic              spoiled_o
);

  logic        m_rd_en, m_wr_en, a_rd_en, a_wr_en, line_rd_en, line_wr_en;
  logic [8:0]  m_rd_addr, m_wr_addr, a_rd_addr, a_wr_addr, line_rd_addr, line_wr_addr;
  logic [55:0] m_rd_low, m_rd_high, m_wr_low, m_wr_high;
  logic [53:0] a_rd_low, a_rd_high, a_wr_low, a_wr_high;
  logic [31:0] line_rd_data, line_wr_data;

  hls_ColumnMomentsShell u_shell (
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .beat_valid_i    (beat_valid_i),
    .beat_pixels_i   (beat_pixels_i),
    .beat_group_i    (beat_group_i),
    .beat_row_i      (beat_row_i),
    .beat_first_row_i(beat_first_row_i),
    .beat_last_row_i (beat_last_row_i),
    .beat_line_end_i (beat_line_end_i),
    .one_group_i     (one_group_i),
    .two_groups_i    (two_groups_i),
    .mode_i          (mode_i),
    .threshold_i     (threshold_i),
    .break_i         (break_i),
    .accept_i        (accept_i),
    .moments_valid_o (moments_valid_o),
    .moments_data_o  (moments_data_o),
    .moments_break_o (moments_break_o),
    .spoiled_o       (spoiled_o),
    .m_rd_en_o       (m_rd_en),
    .m_rd_addr_o     (m_rd_addr),
    .m_rd_low_i      (m_rd_low),
    .m_rd_high_i     (m_rd_high),
    .m_wr_en_o       (m_wr_en),
    .m_wr_addr_o     (m_wr_addr),
    .m_wr_low_o      (m_wr_low),
    .m_wr_high_o     (m_wr_high),
    .a_rd_en_o       (a_rd_en),
    .a_rd_addr_o     (a_rd_addr),
    .a_rd_low_i      (a_rd_low),
    .a_rd_high_i     (a_rd_high),
    .a_wr_en_o       (a_wr_en),
    .a_wr_addr_o     (a_wr_addr),
    .a_wr_low_o      (a_wr_low),
    .a_wr_high_o     (a_wr_high),
    .line_rd_en_o    (line_rd_en),
    .line_rd_addr_o  (line_rd_addr),
    .line_rd_data_i  (line_rd_data),
    .line_wr_en_o    (line_wr_en),
    .line_wr_addr_o  (line_wr_addr),
    .line_wr_data_o  (line_wr_data)
  );

  sp_ram #(.Width(56), .LogDepth(9)) u_m_low (
    .wr_clk_i(clk_i), .wr_en_i(m_wr_en), .wr_addr_i(m_wr_addr), .wr_data_i(m_wr_low),
    .rd_clk_i(clk_i), .rd_en_i(m_rd_en), .rd_addr_i(m_rd_addr), .rd_data_o(m_rd_low)
  );
  sp_ram #(.Width(56), .LogDepth(9)) u_m_high (
    .wr_clk_i(clk_i), .wr_en_i(m_wr_en), .wr_addr_i(m_wr_addr), .wr_data_i(m_wr_high),
    .rd_clk_i(clk_i), .rd_en_i(m_rd_en), .rd_addr_i(m_rd_addr), .rd_data_o(m_rd_high)
  );
  sp_ram #(.Width(54), .LogDepth(9)) u_a_low (
    .wr_clk_i(clk_i), .wr_en_i(a_wr_en), .wr_addr_i(a_wr_addr), .wr_data_i(a_wr_low),
    .rd_clk_i(clk_i), .rd_en_i(a_rd_en), .rd_addr_i(a_rd_addr), .rd_data_o(a_rd_low)
  );
  sp_ram #(.Width(54), .LogDepth(9)) u_a_high (
    .wr_clk_i(clk_i), .wr_en_i(a_wr_en), .wr_addr_i(a_wr_addr), .wr_data_i(a_wr_high),
    .rd_clk_i(clk_i), .rd_en_i(a_rd_en), .rd_addr_i(a_rd_addr), .rd_data_o(a_rd_high)
  );
  sp_ram #(.Width(32), .LogDepth(9)) u_line (
    .wr_clk_i(clk_i), .wr_en_i(line_wr_en), .wr_addr_i(line_wr_addr), .wr_data_i(line_wr_data),
    .rd_clk_i(clk_i), .rd_en_i(line_rd_en), .rd_addr_i(line_rd_addr), .rd_data_o(line_rd_data)
  );

endmodule

`default_nettype wire
