// FIFO with one clock, block RAM and an output register (first word falls through).
//
// Guarantees: it holds 2^LogDepth words plus the one in the output register, takes and gives one
// word per clock, and keeps the order. A word that is written to an empty FIFO is at the output two
// clocks later. s_ready_o is low exactly while the memory is full; a word offered then is not
// taken.
`default_nettype none

module sp_fifo #(
  parameter int Width = 32,  // 1 or more
  parameter int LogDepth = 4  // 1..24
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,

  input  wire logic             s_valid_i,
  output logic                  s_ready_o,
  input  wire logic [Width-1:0] s_data_i,

  output logic                  m_valid_o,
  input  wire logic             m_ready_i,
  output logic      [Width-1:0] m_data_o
`ifdef FORMAL
  ,
  output logic     [LogDepth:0] f_written_o,  // words written since reset, modulo
  output logic     [LogDepth:0] f_read_o      // words that have left, modulo
`endif
);

  logic [LogDepth:0] wr_ptr_q;
  logic [LogDepth:0] rd_ptr_q;
  logic              write;
  logic              fetch;
`ifdef FORMAL
  (* anyconst *) logic [LogDepth:0] f_mark;  // any place in the round of the pointers
  logic [Width-1:0] f_there;
`endif

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

  // Write and read never meet: where both pointers have the same address, the memory is empty or
  // full.
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
`ifdef FORMAL
    ,
    .f_addr_i (f_mark[LogDepth-1:0]),
    .f_word_o (f_there)
`endif
  );

`ifdef FORMAL
  // Reset at the beginning, and then at any time
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb if (!f_ran_q) assume (rst_i);

  // The last word written at f_mark; whether it is at the output
  logic [Width-1:0] f_word_q;
  logic             f_at_output_q;
  logic             f_was_full_q = 1'b0;
  logic [LogDepth:0] f_held, f_before_mark;
  assign f_written_o   = wr_ptr_q;
  assign f_read_o      = rd_ptr_q - (LogDepth + 1)'(m_valid_o);
  assign f_held        = wr_ptr_q - rd_ptr_q;
  assign f_before_mark = f_mark - rd_ptr_q;
  always_ff @(posedge clk_i) begin
    if (write && wr_ptr_q == f_mark) f_word_q <= s_data_i;
    if (rst_i) f_at_output_q <= 1'b0;
    else if (fetch) f_at_output_q <= rd_ptr_q == f_mark;
  end

  // Rule 1: there are never more words than places; a word is refused exactly while the memory is
  // full.
  // Rule 2: the memory holds what was written, and the output shows it in the order of the
  // pointers.
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_held <= (LogDepth + 1)'(1 << LogDepth));
    assert (s_ready_o == (f_held != (LogDepth + 1)'(1 << LogDepth)));
    if (f_before_mark < f_held) assert (f_there == f_word_q);
    if (m_valid_o && f_at_output_q) assert (m_data_o == f_word_q);
    if (f_at_output_q) assert (rd_ptr_q == f_mark + (LogDepth + 1)'(1));
  end

  // Rule 3: a word that waits does not change.
  // Rule 4: a word in the memory is at the output one clock later if the output is free.
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past(m_valid_o && !m_ready_i)) assert (m_valid_o && $stable(m_data_o));
    if ($past(f_held != '0 && (m_ready_i || !m_valid_o))) assert (m_valid_o);
    cover (!s_ready_o);
    if ($past(!s_ready_o)) f_was_full_q <= 1'b1;
    cover (f_was_full_q && m_valid_o && f_at_output_q && f_held == '0);
  end
`endif

endmodule

`default_nettype wire
