// Splits beats that are several times as wide as those of the board.
//
// Guarantees: a beat at the input gives Parts beats of Width bits, the lowest bits first, in successive
// clocks. m_start_o is high with the first of them if s_start_i is, m_end_o with the last if s_end_i
// is. The output cannot be stalled.
//
// Latency: one clock from an offered beat to its first part. Parts = 2:
//
//   clock      0   1   2   3   4   5
//   s_valid_i /111111111111111\______   offered until it is taken
//   s_data_i  <A     ><B     >-------
//   s_ready_o ____/111\___/111\______
//   m_valid_o ____/111111111111111\__
//   m_data_o  ----<A0><A1><B0><B1>---
`default_nettype none

module sp_beat_split #(
  parameter int Width = 32,  // 1 or more
  parameter int Parts = 4  // 1, 2 or 4
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,      // active high, synchronous
  input  wire logic                   s_valid_i,
  output logic                        s_ready_o,
  input  wire logic [Width*Parts-1:0] s_data_i,
  input  wire logic                   s_start_i,  // first beat of a frame
  input  wire logic                   s_end_i,    // last beat of a line
  output logic                        m_valid_o,
  output logic      [Width-1:0]       m_data_o,
  output logic                        m_start_o,
  output logic                        m_end_o
);

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end
  if (Parts != 1 && Parts != 2 && Parts != 4) begin : gen_parts
    parts_is_not_1_2_or_4 u_error ();
  end

  localparam logic [1:0] Last = 2'(Parts - 1);

  logic [1:0]       part_q;
  logic [Width-1:0] part;

  always_comb begin
    part = s_data_i[Width-1:0];
    for (int i = 1; i < Parts; i++) if (part_q == 2'(i)) part = s_data_i[Width*i+:Width];
  end

  assign s_ready_o = part_q == Last;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      part_q    <= '0;
      m_valid_o <= 1'b0;
    end else begin
      if (s_valid_i) part_q <= part_q == Last ? '0 : part_q + 1'b1;
      m_valid_o <= s_valid_i;
    end
    m_data_o  <= part;
    m_start_o <= s_start_i && part_q == '0;
    m_end_o   <= s_end_i && part_q == Last;
  end

endmodule

`default_nettype wire
