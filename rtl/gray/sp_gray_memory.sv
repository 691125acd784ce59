// On-chip memory for the state of the Gray-code decoder: Words words, never late.
//
// The memory port of sp_gray_decoder: both sides go through the words in the order of the frame, from its first on.
// Timing: rd_data_o stands two clocks after rd_en_i. A word is read at the earliest in the clock after it was written.
`default_nettype none

module sp_gray_memory #(
  parameter int Width = 128,
  parameter int Words = 16384
) (
  input  wire logic             clk_i,

  input  wire logic             rd_en_i,
  input  wire logic             rd_first_i,  // the word is the frame's first
  output logic      [Width-1:0] rd_data_o,

  input  wire logic             wr_en_i,
  input  wire logic             wr_first_i,
  input  wire logic [Width-1:0] wr_data_i
);

  localparam int LogDepth = $clog2(Words);

  logic [LogDepth-1:0] rd_next_q, wr_next_q, rd_addr, wr_addr;
  logic [Width-1:0]    word;

  assign rd_addr = rd_first_i ? '0 : rd_next_q;
  assign wr_addr = wr_first_i ? '0 : wr_next_q;

  always_ff @(posedge clk_i) begin
    if (rd_en_i) rd_next_q <= rd_addr + LogDepth'(1);
    if (wr_en_i) wr_next_q <= wr_addr + LogDepth'(1);
    rd_data_o <= word;
  end

  sp_ram #(
    .Width   (Width),
    .LogDepth(LogDepth),
    .Depth   (Words)
  ) u_ram (
    .wr_clk_i (clk_i),
    .wr_en_i  (wr_en_i),
    .wr_addr_i(wr_addr),
    .wr_data_i(wr_data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (rd_en_i),
    .rd_addr_i(rd_addr),
    .rd_data_o(word)
  );

endmodule

`default_nettype wire
