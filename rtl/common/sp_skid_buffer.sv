// Skid buffer: a register stage on a valid/ready stream that cuts every combinational path between its two sides.
//
// Guarantees: one word a clock; s_ready_o, m_valid_o and m_data_o are registers; nothing is lost or doubled;
// latency one clock. m_data_o is stable while m_valid_o is high and m_ready_i low.
`default_nettype none

module sp_skid_buffer #(
  parameter int Width = 32
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

  // A word that is not valid may hold anything: no reset, no further condition.
  always_ff @(posedge clk_i) begin
    if (m_ready_i || !m_valid_o) m_data_o <= spare_valid_q ? spare_q : s_data_i;
    if (!spare_valid_q) spare_q <= s_data_i;
  end

endmodule

`default_nettype wire
