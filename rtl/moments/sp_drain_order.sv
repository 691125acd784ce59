// When the column groups of a last row are drained: every second clock, while they come in at one
// group per clock.
//
// In the grey modes a column takes 64 bits, so the four columns of a group need two clocks to
// leave. The weights of the last row therefore wait in a line buffer (push_*), and drain_* takes
// them out again, one group every second clock.
//
// Guarantees: groups are drained in order, each two clocks after its push or later, never two in
// neighbouring clocks. active_o is high from the clock after the first push until the last drain,
// but not in its clock. break_o comes after the last drain where break_i ended the row early. The
// line buffer has room for one row, and that row is drained before the next wanted one comes;
// sp_packetizer refuses a row that comes sooner.
//
//   clock        0   1   2   3   4   5
//   push_i      _/A\_/B\________________   push_end_i with B
//   waiting_q   _____/11111111111\_______
//   drain_o     _________/A\_____/B\_____
//   weights_o   -------------< A >---< B   of the last row
//   active_o    _____/11111111111\_______
`default_nettype none

module sp_drain_order #(
  parameter int GroupBits = 9,  // 1..24
  parameter int Width = 32  // of what waits for each group, its weights: 1 or more
) (
  input  wire logic                 clk_i,
  input  wire logic                 rst_i,

  // Last row of a frame whose packet was accepted
  input  wire logic                 push_i,
  input  wire logic                 push_end_i,  // the last group of the row
  input  wire logic [GroupBits-1:0] push_group_i,
  input  wire logic [Width-1:0]     push_weights_i,
  // the frame ends here, after push_i of the same clock
  input  wire logic                 break_i,

  output logic                      drain_o,
  output logic      [GroupBits-1:0] drain_group_o,
  output logic      [Width-1:0]     weights_o,
  output logic                      active_o,
  output logic                      break_o
);

  logic                 waiting_q;      // groups wait: from group_q to last_group_q
  // only one group waits; valid from the second clock after a read
  logic                 one_waits_q;
  logic [GroupBits-1:0] group_q;        // the next group to read
  logic [GroupBits-1:0] last_group_q;   // the last group that was pushed
  logic                 row_ended_q;    // this row gets no further push
  logic                 break_asked_q;  // the row ended by a break that break_o has not told yet
  // nothing is left before the break, which enters the stages now
  logic                 break_now;
  logic                 read_now;       // a drain read follows in the next clock
  logic                 last_read;      // that read is the last of the row
  logic                 drained_q;      // the last read, or the break, was decided one clock ago

  assign read_now  = waiting_q && !drain_o;
  assign last_read = read_now && row_ended_q && one_waits_q;
  assign break_now = break_asked_q && !waiting_q && !drain_o;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      waiting_q     <= 1'b0;
      row_ended_q   <= 1'b0;
      break_asked_q <= 1'b0;
      drain_o       <= 1'b0;
      drained_q     <= 1'b0;
      active_o      <= 1'b0;
      group_q       <= '0;
      break_o       <= 1'b0;
    end else begin
      drain_o   <= read_now;
      waiting_q <= push_i || waiting_q && !(read_now && one_waits_q);
      break_o   <= break_now;

      if (push_i && push_end_i || break_i) row_ended_q <= 1'b1;
      else if (last_read || break_now) row_ended_q <= 1'b0;

      if (break_i) break_asked_q <= 1'b1;
      else if (break_now) break_asked_q <= 1'b0;

      if (push_i) active_o <= 1'b1;
      else if (last_read || break_now) active_o <= 1'b0;

      drained_q <= last_read || break_now;
      if (drained_q) group_q <= '0;
      else if (read_now) group_q <= group_q + 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    drain_group_o <= group_q;
    // A group that is pushed while none waits becomes group_q.
    one_waits_q   <= push_i ? !waiting_q : group_q == last_group_q;
    if (push_i) last_group_q <= push_group_i;
  end

  sp_ram #(
    .Width   (Width),
    .LogDepth(GroupBits)
  ) u_line (
    .wr_clk_i (clk_i),
    .wr_en_i  (push_i),
    .wr_addr_i(push_group_i),
    .wr_data_i(push_weights_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (drain_o),
    .rd_addr_i(drain_group_o),
    .rd_data_o(weights_o)
  );

endmodule

`default_nettype wire
