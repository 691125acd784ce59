// Joins two packet streams at packet boundaries; the first stream goes before the second.
//
// Guarantees: a packet that has begun is finished before another begins. One beat per clock. The
// output is registered on both sides (sp_skid_buffer): tdata and tlast are stable while tvalid
// waits for tready.
`default_nettype none

module sp_packet_arbiter #(
  parameter int Width = 128  // 1 or more
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

  if (Width < 1) begin : gen_width
    width_is_less_than_1 u_error ();
  end

  logic busy_q;       // inside a packet
  logic of_second_q;  // the packet is of the second stream
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

`ifdef FORMAL
  // One reset at the beginning. Words that wait do not change.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  always_comb assume (rst_i == !f_ran_q);
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past(first_valid_i && !first_ready_o))
      assume (first_valid_i && $stable(first_data_i) && $stable(first_last_i));
    if ($past(second_valid_i && !second_ready_o))
      assume (second_valid_i && $stable(second_data_i) && $stable(second_last_i));
  end

  // The last word taken: its stream, and whether its packet goes on.
  logic f_first, f_second, f_inside_q, f_of_second_q;
  assign f_first  = first_valid_i && first_ready_o;
  assign f_second = second_valid_i && second_ready_o;
  always_ff @(posedge clk_i) begin
    if (rst_i) f_inside_q <= 1'b0;
    else if (f_first || f_second) begin
      f_inside_q    <= !(f_first ? first_last_i : second_last_i);
      f_of_second_q <= f_second;
    end
  end

  // Rule 1: never are two words taken at once.
  // Rule 2: a packet that has begun is finished before the other stream has its turn.
  // Rule 3: between packets the first stream goes before the second.
  always_comb if (f_ran_q && !rst_i) begin
    assert (!(f_first && f_second));
    if (f_inside_q && f_second) assert (f_of_second_q);
    if (f_inside_q && f_first) assert (!f_of_second_q);
    if (!f_inside_q && first_valid_i) assert (!f_second);
    assert (busy_q == f_inside_q);
    if (busy_q) assert (of_second_q == f_of_second_q);
  end

  // Rule 4: a word taken is at the output one clock later if nothing waits there. A word that waits
  // does not change (AXI4-Stream).
  always_ff @(posedge clk_i) if (f_ran_q && !$past(rst_i)) begin
    if ($past((f_first || f_second) && m_axis_tready_i)) assert (m_axis_tvalid_o);
    if ($past(m_axis_tvalid_o && !m_axis_tready_i)) begin
      assert (m_axis_tvalid_o && $stable(m_axis_tdata_o) && $stable(m_axis_tlast_o));
    end
    cover (f_first && $past(f_second && second_last_i) && $past(f_inside_q));
    cover (f_second && f_inside_q && first_valid_i);
  end
`endif

endmodule

`default_nettype wire
