// Joins two packet streams at packet boundaries; the first goes before the second.
//
// Guarantees: a packet that has begun is finished before another begins; one beat a clock; the output is registered on
// both sides (sp_skid_buffer): tdata and tlast are stable while tvalid waits for tready.
`default_nettype none

module sp_packet_arbiter #(
  parameter int Width = 128
) (
  input  wire logic             clk_i,
  input  wire logic             rst_i,

  input  wire logic             first_valid_i,
  output logic                  first_ready_o,
  input  wire logic             first_last_i,
  input  wire logic [Width-1:0] first_data_i,

  input  wire logic             second_valid_i,
  output logic                  second_ready_o,
  input  wire logic             second_last_i,
  input  wire logic [Width-1:0] second_data_i,

  output logic                  m_axis_tvalid_o,
  input  wire logic             m_axis_tready_i,
  output logic                  m_axis_tlast_o,
  output logic      [Width-1:0] m_axis_tdata_o
);

  logic busy_q;       // inside a packet
  logic of_second_q;  // of the second stream
  logic second;       // the second stream is served now
  logic valid, ready, last;

  assign second         = busy_q ? of_second_q : !first_valid_i;
  assign valid          = second ? second_valid_i : first_valid_i;
  assign last           = second ? second_last_i : first_last_i;
  assign first_ready_o  = ready && !second;
  assign second_ready_o = ready && second;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      busy_q      <= 1'b0;
      of_second_q <= 1'b0;
    end else if (valid && ready) begin
      busy_q      <= !last;
      of_second_q <= second;
    end
  end

  sp_skid_buffer #(
    .Width(Width + 1)
  ) u_out (
    .clk_i    (clk_i),
    .rst_i    (rst_i),
    .s_valid_i(valid),
    .s_ready_o(ready),
    .s_data_i ({last, second ? second_data_i : first_data_i}),
    .m_valid_o(m_axis_tvalid_o),
    .m_ready_i(m_axis_tready_i),
    .m_data_o ({m_axis_tlast_o, m_axis_tdata_o})
  );

endmodule

`default_nettype wire
