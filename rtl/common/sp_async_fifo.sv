// Dual-clock FIFO: Gray-coded pointers through two-flop synchronizers, block RAM, output register.
//
// Guarantees: 2^LogDepth words plus the one in the output register; one word in and one out a clock; order kept, for any
// two clocks. wr_free_o counts the free places; it never promises one that is not there (places freed by the reader
// show two to three write clocks later). A write with wr_free_o = 0 is not taken: the writer looks first.
// Reset: both sides together, each in its clock.
`default_nettype none

module sp_async_fifo #(
  parameter int Width = 32,
  parameter int LogDepth = 4
) (
  input  wire logic             wr_clk_i,
  input  wire logic             wr_rst_i,
  input  wire logic             wr_valid_i,
  input  wire logic [Width-1:0] wr_data_i,
  output logic      [LogDepth:0] wr_free_o,

  input  wire logic             rd_clk_i,
  input  wire logic             rd_rst_i,
  output logic                  rd_valid_o,
  input  wire logic             rd_ready_i,
  output logic      [Width-1:0] rd_data_o
);

  // write side
  logic [LogDepth:0] wr_ptr_q;
  logic [LogDepth:0] wr_next;
  logic [LogDepth:0] wr_gray_q;
  logic [LogDepth:0] rd_gray_seen;
  logic [LogDepth:0] rd_bin_seen;
  logic              write;

  // read side
  logic [LogDepth:0] rd_ptr_q;
  logic [LogDepth:0] rd_next;
  logic [LogDepth:0] rd_gray_q;
  logic [LogDepth:0] wr_gray_seen;
  logic              fetch;

  assign write   = wr_valid_i && wr_free_o != '0;
  assign wr_next = wr_ptr_q + 1'b1;

  always_ff @(posedge wr_clk_i) begin
    if (wr_rst_i) begin
      wr_ptr_q  <= '0;
      wr_gray_q <= '0;
    end else if (write) begin
      wr_ptr_q  <= wr_next;
      wr_gray_q <= wr_next ^ (wr_next >> 1);
    end
  end

  sp_sync #(
    .Width(LogDepth + 1)
  ) u_rd_to_wr (
    .clk_i(wr_clk_i),
    .rst_i(wr_rst_i),
    .d_i  (rd_gray_q),
    .q_o  (rd_gray_seen)
  );

  // Gray to binary: bit i is the exclusive or of all bits from i on, for up to 16 bits
  logic [LogDepth:0] fold1, fold2, fold4;
  assign fold1       = rd_gray_seen ^ (rd_gray_seen >> 1);
  assign fold2       = fold1 ^ (fold1 >> 2);
  assign fold4       = fold2 ^ (fold2 >> 4);
  assign rd_bin_seen = fold4 ^ (fold4 >> 8);

  // depth + read - written
  assign wr_free_o = {!rd_bin_seen[LogDepth], rd_bin_seen[LogDepth-1:0]} - wr_ptr_q;

  assign fetch   = rd_gray_q != wr_gray_seen && (!rd_valid_o || rd_ready_i);
  assign rd_next = rd_ptr_q + 1'b1;

  always_ff @(posedge rd_clk_i) begin
    if (rd_rst_i) begin
      rd_ptr_q   <= '0;
      rd_gray_q  <= '0;
      rd_valid_o <= 1'b0;
    end else begin
      if (fetch) begin
        rd_ptr_q  <= rd_next;
        rd_gray_q <= rd_next ^ (rd_next >> 1);
      end
      if (fetch) rd_valid_o <= 1'b1;
      else if (rd_ready_i) rd_valid_o <= 1'b0;
    end
  end

  sp_sync #(
    .Width(LogDepth + 1)
  ) u_wr_to_rd (
    .clk_i(rd_clk_i),
    .rst_i(rd_rst_i),
    .d_i  (wr_gray_q),
    .q_o  (wr_gray_seen)
  );

  // A word is read at the earliest two read clocks after its write, and overwritten only after its place was freed.
  sp_ram #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_ram (
    .wr_clk_i (wr_clk_i),
    .wr_en_i  (write),
    .wr_addr_i(wr_ptr_q[LogDepth-1:0]),
    .wr_data_i(wr_data_i),
    .rd_clk_i (rd_clk_i),
    .rd_en_i  (fetch),
    .rd_addr_i(rd_ptr_q[LogDepth-1:0]),
    .rd_data_o(rd_data_o)
  );

endmodule

`default_nettype wire
