// When the column groups of a last row are drained: every second clock, while they come in at one
// group per clock.
//
// In the grey modes a column takes 64 bits, so a group of columns needs two clocks to
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

`ifdef FORMAL
  // Assumptions: one reset at the beginning. The groups of a row come in order, with any gaps. A
  // row ends with push_end_i or with break_i. The next row begins once the
  // last group has been read and a break is told, which may be in the same clock.
  logic f_ran_q = 1'b0;
  always_ff @(posedge clk_i) f_ran_q <= 1'b1;
  logic               f_open_q;    // a row has begun and may go on
  logic               f_broke_q;   // it ended by a break that break_o has not told yet
  logic [GroupBits:0] f_pushed_q, f_pushed1_q;  // groups of the row; one clock ago
  logic [GroupBits:0] f_reads_q;   // groups that were read
  logic               f_begins;    // the first push of a row
  assign f_begins = push_i && !f_open_q;
  always_comb begin
    assume (rst_i == !f_ran_q);
    if (push_i && !rst_i) begin
      assume (f_open_q || !active_o && !drain_o && (!f_broke_q || break_o));
      assume (push_group_i == (f_open_q ? f_pushed_q[GroupBits-1:0] : '0));
      if (f_open_q) assume (!f_pushed_q[GroupBits]);
    end
    if (break_i && !rst_i) assume ((f_open_q || push_i) && !(push_i && push_end_i));
  end
  always_ff @(posedge clk_i) begin
    if (rst_i) {f_open_q, f_broke_q, f_pushed_q, f_pushed1_q, f_reads_q} <= '0;
    else begin
      if (push_i) f_open_q <= !push_end_i;
      if (break_i) f_open_q <= 1'b0;
      if (break_i) f_broke_q <= 1'b1;
      else if (break_o) f_broke_q <= 1'b0;
      f_pushed1_q <= f_pushed_q;
      f_pushed_q  <= f_begins ? (GroupBits + 1)'(1) : f_pushed_q + (GroupBits + 1)'(push_i);
      f_reads_q   <= f_begins ? '0 : f_reads_q + (GroupBits + 1)'(drain_o);
    end
  end

  // The word of any one group
  (* anyconst *) logic [GroupBits-1:0] f_group;
  logic [Width-1:0] f_word_q;
  logic             f_read_q, f_drained_q;
  logic [1:0]       f_quiet_q;  // clocks without a push, a break or a read
  always_ff @(posedge clk_i) begin
    if (push_i && push_group_i == f_group) f_word_q <= push_weights_i;
    f_read_q    <= !rst_i && drain_o && drain_group_o == f_group;
    f_drained_q <= !rst_i && drain_o;
    if (rst_i || push_i || break_i || drain_o) f_quiet_q <= 2'd0;
    else if (f_quiet_q != 2'd3) f_quiet_q <= f_quiet_q + 2'd1;
  end
  always_comb if (f_ran_q) begin
    // Rule 1: groups are read in order, each two clocks after its push or later, never two in
    // neighbouring clocks; active_o is high but for the last read.
    if (drain_o) begin
      assert (drain_group_o == f_reads_q[GroupBits-1:0] && f_reads_q < f_pushed1_q);
      assert (!f_drained_q);
      assert (active_o || !f_open_q && f_reads_q + (GroupBits + 1)'(1) == f_pushed_q);
    end
    // Rule 2: the weights are those that were pushed with the group.
    if (f_read_q) assert (weights_o == f_word_q);
    // Rule 3: a break is told once, after the last read, and only if the row ended by one.
    if (break_o) assert (f_broke_q && !drain_o && !f_open_q && f_reads_q == f_pushed_q);
    // Rule 4: nothing stays behind.
    if (f_quiet_q == 2'd3 && !f_open_q) assert (!active_o && !f_broke_q && f_reads_q == f_pushed_q);
  end
  logic f_met_q;  // a row has begun in the clock in which the break of the one before was told
  always_ff @(posedge clk_i) begin
    if (rst_i) f_met_q <= 1'b0;
    else if (f_begins) f_met_q <= break_o;
  end
  always_ff @(posedge clk_i) if (f_ran_q) begin
    cover (f_met_q && drain_o && f_reads_q == (GroupBits + 1)'(1));
    cover (break_o && f_pushed_q == (GroupBits + 1)'(2));
  end
`endif

endmodule

`default_nettype wire
