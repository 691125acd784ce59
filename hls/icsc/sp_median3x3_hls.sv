// The translated shell of the median together with its line buffers. It has the ports of
// sp_median3x3 for 2048 columns.
`default_nettype none

module sp_median3x3_hls (
  input  wire logic        clk_i,
  input  wire logic        rst_i,
  input  wire logic        s_valid_i,
  input  wire logic [63:0] s_codes_i,
  input  wire logic        s_start_i,
  input  wire logic        s_line_start_i,
  input  wire logic        s_line_end_i,
  input  wire logic        s_last_row_i,
  input  wire logic        s_break_i,
  input  wire logic [4:0]  s_status_i,
  input  wire logic        s_median_i,
  output logic             busy_o,
  output logic             m_valid_o,
  output logic      [63:0] m_codes_o,
  output logic             m_start_o,
  output logic             m_line_start_o,
  output logic             m_line_end_o,
  output logic             m_break_o,
  output logic      [4:0]  m_status_o
);

  logic        rd_en, near_wr_en, far_wr_en;
  logic [8:0]  rd_addr, wr_addr;
  logic [51:0] near_rd_data, far_rd_data, near_wr_data, far_wr_data;

  hls_Median3x3Shell u_shell (
    .clk_i         (clk_i),
    .rst_i         (rst_i),
    .s_valid_i     (s_valid_i),
    .s_codes_i     (s_codes_i),
    .s_start_i     (s_start_i),
    .s_line_start_i(s_line_start_i),
    .s_line_end_i  (s_line_end_i),
    .s_last_row_i  (s_last_row_i),
    .s_break_i     (s_break_i),
    .s_status_i    (s_status_i),
    .s_median_i    (s_median_i),
    .busy_o        (busy_o),
    .m_valid_o     (m_valid_o),
    .m_codes_o     (m_codes_o),
    .m_start_o     (m_start_o),
    .m_line_start_o(m_line_start_o),
    .m_line_end_o  (m_line_end_o),
    .m_break_o     (m_break_o),
    .m_status_o    (m_status_o),
    .rd_en_o       (rd_en),
    .rd_addr_o     (rd_addr),
    .near_rd_data_i(near_rd_data),
    .far_rd_data_i (far_rd_data),
    .wr_addr_o     (wr_addr),
    .near_wr_en_o  (near_wr_en),
    .near_wr_data_o(near_wr_data),
    .far_wr_en_o   (far_wr_en),
    .far_wr_data_o (far_wr_data)
  );

  sp_ram #(.Width(52), .LogDepth(9)) u_near (
    .wr_clk_i(clk_i), .wr_en_i(near_wr_en), .wr_addr_i(wr_addr), .wr_data_i(near_wr_data),
    .rd_clk_i(clk_i), .rd_en_i(rd_en), .rd_addr_i(rd_addr), .rd_data_o(near_rd_data)
  );
  sp_ram #(.Width(52), .LogDepth(9)) u_far (
    .wr_clk_i(clk_i), .wr_en_i(far_wr_en), .wr_addr_i(wr_addr), .wr_data_i(far_wr_data),
    .rd_clk_i(clk_i), .rd_en_i(rd_en), .rd_addr_i(rd_addr), .rd_data_o(far_rd_data)
  );

endmodule

`default_nettype wire
