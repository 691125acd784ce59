// Skid buffer: a register stage on a valid/ready stream that cuts every combinational path between
// its two sides.
//
// Guarantees: one word per clock, with a latency of one clock; nothing is lost or doubled.
// s_ready_o, m_valid_o and m_data_o are registers. m_data_o is stable while m_valid_o is high and
// m_ready_i low.
`default_nettype none

module sp_skid_buffer #(
  parameter int Width = 32  // 1 or more
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

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end

  logic             spare_valid_q;  // a word waits behind the output register
  logic [Width-1:0] spare_q;

  assign s_ready_o = !spare_valid_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      m_valid_o     <= 1'b0;
      spare_valid_q <= 1'b0;
    end else if (m_ready_i || !m_valid_o) begin
      m_valid_o     <= spare_valid_q || s_valid_i;
      spare_valid_q <= 1'b0;
    end else if (s_valid_i) begin
      spare_valid_q <= 1'b1;
    end
  end

  // A word that is not valid may hold anything, so it needs no reset and no other condition.
  always_ff @(posedge clk_i) begin
    if (m_ready_i || !m_valid_o) m_data_o <= spare_valid_q ? spare_q : s_data_i;
    if (!spare_valid_q) spare_q <= s_data_i;
  end

`ifdef FORMAL
  // One reset at the beginning
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q);

  // Rule 1: words that came in = words that went out + words inside.
  // Rule 2: word number f_mark, for any f_mark, comes out as it went in.
  (* anyconst *) logic [3:0] f_mark;
  logic [3:0] f_in_q, f_out_q;  // modulo 16: more than fit
  logic [Width-1:0] f_word_q;
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      f_in_q  <= '0;
      f_out_q <= '0;
    end else begin
      if (s_valid_i && s_ready_o) f_in_q <= f_in_q + 4'd1;
      if (m_valid_o && m_ready_i) f_out_q <= f_out_q + 4'd1;
    end
    if (s_valid_i && s_ready_o && f_in_q == f_mark) f_word_q <= s_data_i;
  end
  always_comb if (f_ran_q && !rst_i) begin
    assert (f_in_q - f_out_q == 4'(m_valid_o) + 4'(spare_valid_q));
    if (m_valid_o && f_out_q == f_mark) assert (m_data_o == f_word_q);
    if (spare_valid_q && f_out_q + 4'd1 == f_mark) assert (spare_q == f_word_q);
    if (spare_valid_q) assert (m_valid_o);
  end

  // Rule 3: a word that waits does not change.
  // Rule 4: one word per clock: a word that came in is at the output one clock later if nothing
  // waits.
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past(m_valid_o && !m_ready_i)) assert (m_valid_o && $stable(m_data_o));
    if ($past(s_valid_i && s_ready_o && m_ready_i)) assert (m_valid_o);
    cover (m_valid_o && $past(m_valid_o && m_ready_i, 1) && $past(m_valid_o && m_ready_i, 2));
    cover (m_valid_o && $past(spare_valid_q) && $past(m_ready_i));
  end
`endif

endmodule

`default_nettype wire
