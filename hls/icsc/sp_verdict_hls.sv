// The translated shell of the verdict together with its memories. It has the ports of sp_verdict for
// 2048 columns, 1023 rows, the grey modes and two sections a bank.
`default_nettype none

module sp_verdict_hls (
  input  wire logic         clk_i,
  input  wire logic         rst_i,
  input  wire logic         write_i,
  input  wire logic [4:0]   write_word_i,
  input  wire logic [31:0]  write_data_i,
  input  wire logic         hold_i,
  input  wire logic         by_encoder_i,
  input  wire logic         write_limits_i,
  input  wire logic         write_bank_i,
  input  wire logic [0:0]   write_section_i,
  input  wire logic [10:0]  write_column_i,
  input  wire logic [34:0]  write_limits_word_i,
  input  wire logic         frame_i,
  input  wire logic         restart_i,
  input  wire logic [23:0]  encoder_i,
  input  wire logic [9:0]   groups_i,
  input  wire logic         grey_i,
  output logic              start_o,
  output logic              ready_o,
  input  wire logic         beat_valid_i,
  input  wire logic [127:0] beat_data_i,
  input  wire logic         break_i,
  output logic              verdict_valid_o,
  output logic              in_part_o,
  output logic              defect_o,
  output logic              lacks_light_o,
  output logic      [11:0]  first_column_o,
  output logic      [11:0]  columns_o,
  output logic      [11:0]  unlit_o,
  output logic      [0:0]   section_o,
  output logic      [15:0]  part_o,
  output logic      [23:0]  count_o,
  output logic              bank_o,
  output logic              first_bad_o,
  output logic              passes_o,
  output logic      [31:0]  word_o
);

  logic        words_rd_en, past_wr_en;
  logic [4:0]  words_rd_addr;
  logic [31:0] words_rd_data;
  logic [12:0] table_rd_addr;
  logic [34:0] table_rd_data, limits_wr_data;
  logic [34:0] limits_rd_data[4];
  logic [3:0]  limits_wr_en;
  logic [8:0]  limits_rd_addr, limits_wr_addr, past_rd_addr, past_wr_addr;
  logic [27:0] past_rd_data, past_wr_data;

  hls_VerdictShell u_shell (
    .clk_i           (clk_i),
    .rst_i           (rst_i),
    .write_i         (write_i),
    .hold_i          (hold_i),
    .by_encoder_i    (by_encoder_i),
    .frame_i         (frame_i),
    .restart_i       (restart_i),
    .encoder_i       (encoder_i),
    .groups_i        (groups_i),
    .grey_i          (grey_i),
    .start_o         (start_o),
    .ready_o         (ready_o),
    .beat_valid_i    (beat_valid_i),
    .beat_data_i     (beat_data_i),
    .break_i         (break_i),
    .verdict_valid_o (verdict_valid_o),
    .in_part_o       (in_part_o),
    .defect_o        (defect_o),
    .lacks_light_o   (lacks_light_o),
    .first_column_o  (first_column_o),
    .columns_o       (columns_o),
    .unlit_o         (unlit_o),
    .section_o       (section_o),
    .part_o          (part_o),
    .count_o         (count_o),
    .bank_o          (bank_o),
    .first_bad_o     (first_bad_o),
    .passes_o        (passes_o),
    .word_o          (word_o),
    .words_rd_en_o   (words_rd_en),
    .words_rd_addr_o (words_rd_addr),
    .words_rd_data_i (words_rd_data),
    .table_rd_addr_o (table_rd_addr),
    .table_rd_data_i (table_rd_data),
    .limits_rd_addr_o(limits_rd_addr),
    .limits_rd0_i    (limits_rd_data[0]),
    .limits_rd1_i    (limits_rd_data[1]),
    .limits_rd2_i    (limits_rd_data[2]),
    .limits_rd3_i    (limits_rd_data[3]),
    .limits_wr_en_o  (limits_wr_en),
    .limits_wr_addr_o(limits_wr_addr),
    .limits_wr_data_o(limits_wr_data),
    .past_rd_addr_o  (past_rd_addr),
    .past_rd_data_i  (past_rd_data),
    .past_wr_en_o    (past_wr_en),
    .past_wr_addr_o  (past_wr_addr),
    .past_wr_data_o  (past_wr_data)
  );

  sp_ram #(.Width(32), .LogDepth(5)) u_words (
    .wr_clk_i(clk_i), .wr_en_i(write_i), .wr_addr_i(write_word_i), .wr_data_i(write_data_i),
    .rd_clk_i(clk_i), .rd_en_i(words_rd_en), .rd_addr_i(words_rd_addr), .rd_data_o(words_rd_data)
  );
  sp_ram #(.Width(35), .LogDepth(13)) u_table (
    .wr_clk_i(clk_i), .wr_en_i(write_limits_i),
    .wr_addr_i({write_bank_i, write_section_i, write_column_i}), .wr_data_i(write_limits_word_i),
    .rd_clk_i(clk_i), .rd_en_i(1'b1), .rd_addr_i(table_rd_addr), .rd_data_o(table_rd_data)
  );
  for (genvar lane = 0; lane < 4; lane++) begin : gen_lane
    sp_ram #(.Width(35), .LogDepth(9)) u_limits (
      .wr_clk_i(clk_i), .wr_en_i(limits_wr_en[lane]), .wr_addr_i(limits_wr_addr),
      .wr_data_i(limits_wr_data),
      .rd_clk_i(clk_i), .rd_en_i(1'b1), .rd_addr_i(limits_rd_addr),
      .rd_data_o(limits_rd_data[lane])
    );
  end
  sp_ram #(.Width(28), .LogDepth(9)) u_past (
    .wr_clk_i(clk_i), .wr_en_i(past_wr_en), .wr_addr_i(past_wr_addr), .wr_data_i(past_wr_data),
    .rd_clk_i(clk_i), .rd_en_i(1'b1), .rd_addr_i(past_rd_addr), .rd_data_o(past_rd_data)
  );

endmodule

`default_nettype wire
