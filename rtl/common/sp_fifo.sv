// FIFO with one clock, block RAM and an output register (first word falls through).
//
// Guarantees: 2^LogDepth words plus the one in the output register; one word in and one out a clock; order kept;
// a word written to an empty FIFO is at the output two clocks later. s_ready_o is low exactly while the memory is full:
// a word offered then is not taken.
`default_nettype none

module sp_fifo #(
  parameter int Width = 32,
  parameter int LogDepth = 4
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,

  input  wire logic             s_valid_i,
  output logic                  s_ready_o,
  input  wire logic [Width-1:0] s_data_i,

  output logic                  m_valid_o,
  input  wire logic             m_ready_i,
  output logic      [Width-1:0] m_data_o
);

  logic [LogDepth:0] wr_ptr_q;
  logic [LogDepth:0] rd_ptr_q;
  logic              write;
  logic              fetch;

  assign s_ready_o = wr_ptr_q != {!rd_ptr_q[LogDepth], rd_ptr_q[LogDepth-1:0]};
  assign write     = s_valid_i && s_ready_o;
  assign fetch     = wr_ptr_q != rd_ptr_q && (!m_valid_o || m_ready_i);

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      wr_ptr_q  <= '0;
      rd_ptr_q  <= '0;
      m_valid_o <= 1'b0;
    end else begin
      if (write) wr_ptr_q <= wr_ptr_q + 1'b1;
      if (fetch) rd_ptr_q <= rd_ptr_q + 1'b1;
      if (fetch) m_valid_o <= 1'b1;
      else if (m_ready_i) m_valid_o <= 1'b0;
    end
  end

  // Write and read never meet: where the pointers' addresses are equal the memory is empty or full.
  sp_ram #(
    .Width   (Width),
    .LogDepth(LogDepth)
  ) u_ram (
    .wr_clk_i (clk_i),
    .wr_en_i  (write),
    .wr_addr_i(wr_ptr_q[LogDepth-1:0]),
    .wr_data_i(s_data_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (fetch),
    .rd_addr_i(rd_ptr_q[LogDepth-1:0]),
    .rd_data_o(m_data_o)
  );

endmodule

`default_nettype wire
