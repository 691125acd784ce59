// Grey modes: finishes the sums of the last row, two columns a clock.
//
// In the grey modes a column is 64 bits, so four columns of a beat leave in two clocks while the last row comes in one beat
// a clock. The last row is therefore not added up: its weights wait in a line buffer of one row (push_*), and this module
// reads group after group every second clock from the sums of the rows before (drain_*), adds the last row and
// finishes M1:
//
//   M0 = M0' + v,  N = N' + [v > 0],  M1 = R*M0 - (A + M0')       (M0', N', A: after row R-1; v: the last row's weight)
//
// Guarantees: words leave in column order, a group's first two columns eight clocks after its drain read, the other two
// one clock later; break_o after the last word where break_i ended the frame early. Between frames of equal settings drain reads never meet the
// reads of the next frame: its second row begins one clock after the last drain read. active_o tells the
// others (after a change of settings) to keep away.
`default_nettype none

module sp_moment_drain #(
  parameter int MaxRows = 1023,
  parameter int GroupBits = 9,
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int M0Bits = $clog2(255 * MaxRows + 1),
  parameter int LaneMBits = M0Bits + RowBits,
  parameter int LaneABits = $clog2(255 * MaxRows * (MaxRows + 1) / 2 + 1)
) (
  input  wire logic                   clk_i,
  input  wire logic                   rst_i,

  // Last row of a frame whose packet was accepted
  input  wire logic                   push_i,
  input  wire logic                   push_end_i,  // the row's last group
  input  wire logic [GroupBits-1:0]   push_group_i,
  input  wire logic [31:0]            push_weights_i,
  input  wire logic [RowBits-1:0]     push_row_i,
  input  wire logic                   push_first_row_i,
  input  wire logic                   push_one_group_i,
  input  wire logic                   break_i,     // the frame ends here, after push_i of the same clock

  // Reads of the sums: address now, M one clock later, A two clocks later
  output logic                        drain_o,
  output logic [GroupBits-1:0]        drain_group_o,
  output logic                        active_o,
  input  wire logic [4*LaneMBits-1:0] raw_m_i,
  input  wire logic [4*LaneABits-1:0] raw_a_i,
  input  wire logic [4*LaneMBits-1:0] sum_m_i,
  input  wire logic [4*LaneABits-1:0] sum_a_i,
  input  wire logic                   sum_m_new_i,  // sum_m_i is of the beat two clocks ahead of the read: too new for the memory
  input  wire logic                   sum_a_new_i,

  output logic                        valid_o,
  output logic [127:0]                data_o,
  output logic                        break_o
);

  localparam int Latency = 6;  // from stage 2 to stage 8, the words

  // Line buffer and what is left in it
  logic [GroupBits:0]   waiting_q;
  logic                 ended_q;       // no further push will come
  logic                 break_wait_q;  // and it ended by a break
  logic                 break_now;
  logic                 odd_q;         // a drain read was in the clock before
  logic                 last_read;
  logic [RowBits-1:0]   rows_q;
  logic                 first_row_q;
  logic                 one_group_q;
  logic [31:0]          raw_weights;

  assign drain_o   = waiting_q != '0 && !odd_q;
  assign last_read = drain_o && ended_q && waiting_q == {{GroupBits{1'b0}}, 1'b1};
  assign break_now = break_wait_q && waiting_q == '0 && !odd_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      waiting_q     <= '0;
      ended_q       <= 1'b0;
      break_wait_q  <= 1'b0;
      odd_q         <= 1'b0;
      active_o      <= 1'b0;
      drain_group_o <= '0;
    end else begin
      odd_q <= drain_o;
      if (push_i && !drain_o) waiting_q <= waiting_q + 1'b1;
      if (!push_i && drain_o) waiting_q <= waiting_q - 1'b1;

      if (push_i && push_end_i || break_i) ended_q <= 1'b1;
      else if (last_read || break_now) ended_q <= 1'b0;

      if (break_i) break_wait_q <= 1'b1;
      else if (break_now) break_wait_q <= 1'b0;

      if (push_i) active_o <= 1'b1;
      else if (last_read || break_now) active_o <= 1'b0;

      if (last_read || break_now) drain_group_o <= '0;
      else if (drain_o) drain_group_o <= drain_group_o + 1'b1;
    end
  end

  always_ff @(posedge clk_i) begin
    if (push_i) begin
      rows_q      <= push_row_i;
      first_row_q <= push_first_row_i;
      one_group_q <= push_one_group_i;
    end
  end

  // A group is read at the earliest one clock after its push.
  sp_ram #(
    .Width   (32),
    .LogDepth(GroupBits)
  ) u_line (
    .wr_clk_i (clk_i),
    .wr_en_i  (push_i),
    .wr_addr_i(push_group_i),
    .wr_data_i(push_weights_i),
    .rd_clk_i (clk_i),
    .rd_en_i  (drain_o),
    .rd_addr_i(drain_group_o),
    .rd_data_o(raw_weights)
  );

  // Stage 1: M words and weights are here; stage 2: kept for the two clocks of their group; A words are here.
  // Stage 3: the first two columns of the group, and A kept; one clock later the other two.
  logic                   s2_first_q, s3_pick_q;
  logic                   s2_valid_q;
  logic [4*LaneMBits-1:0] s2_m_q;
  logic [4*LaneABits-1:0] s3_a_q;
  logic [31:0]            s2_weights_q;
  logic                   s1_break_q, s2_break_q;

  logic [Latency-1:0]     valid_q;
  logic [Latency-1:0]     break_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s2_first_q <= 1'b0;
      s2_valid_q <= 1'b0;
      s1_break_q <= 1'b0;
      s2_break_q <= 1'b0;
      valid_q    <= '0;
      break_q    <= '0;
    end else begin
      s2_first_q <= odd_q;                // stage 1 of a drain read
      s2_valid_q <= odd_q || s2_first_q;  // two clocks, for two columns each
      s1_break_q <= break_now;
      s2_break_q <= s1_break_q;
      valid_q    <= {valid_q[Latency-2:0], s2_valid_q};
      break_q    <= {break_q[Latency-2:0], s2_break_q};
    end
  end

  always_ff @(posedge clk_i) begin
    s3_pick_q <= s2_first_q;
    if (odd_q) begin
      s2_m_q       <= first_row_q ? '0 : one_group_q && sum_m_new_i ? sum_m_i : raw_m_i;
      s2_weights_q <= raw_weights;
    end
    if (s2_first_q) s3_a_q <= first_row_q ? '0 : one_group_q && sum_a_new_i ? sum_a_i : raw_a_i;
  end

  for (genvar c = 0; c < 2; c++) begin : gen_column
    // stage 3: two of the four columns
    logic [LaneMBits-1:0] pick_m;
    logic [7:0]           pick_weight;
    logic [M0Bits-1:0]    s3_old_m0_q, s3_m0_q;
    logic [RowBits-1:0]   s3_n_q;
    assign pick_m      = s2_first_q ? s2_m_q[c*LaneMBits+:LaneMBits] : s2_m_q[(c+2)*LaneMBits+:LaneMBits];
    assign pick_weight = s2_first_q ? s2_weights_q[c*8+:8] : s2_weights_q[(c+2)*8+:8];
    always_ff @(posedge clk_i) if (s2_valid_q) begin
      s3_old_m0_q <= pick_m[M0Bits-1:0];
      s3_m0_q     <= pick_m[M0Bits-1:0] + {{(M0Bits - 8) {1'b0}}, pick_weight};
      s3_n_q      <= pick_m[M0Bits+:RowBits] + {{(RowBits - 1) {1'b0}}, |pick_weight};
    end

    // stage 4: what R*M0 counts too much
    logic [LaneABits-1:0] s4_over_q;
    logic [LaneABits-1:0] pick_a;
    assign pick_a = s3_pick_q ? s3_a_q[c*LaneABits+:LaneABits] : s3_a_q[(c+2)*LaneABits+:LaneABits];
    always_ff @(posedge clk_i) if (valid_q[0]) s4_over_q <= pick_a + {{(LaneABits - M0Bits) {1'b0}}, s3_old_m0_q};

    // stages 4 to 7: R*M0, and the rest beside it
    // R*M0 can have a bit more than M1 needs: it falls out of the difference
    logic [M0Bits+RowBits-1:0] product7;
    logic                      unused_product;
    assign unused_product = ^product7;
    sp_scale #(
      .XBits(M0Bits),
      .KBits(RowBits)
    ) u_scale (
      .clk_i    (clk_i),
      .valid_i  (valid_q[0]),
      .x_i      (s3_m0_q),
      .k_i      (rows_q),
      .product_o(product7)
    );

    logic [M0Bits-1:0]    s4_m0_q, s5_m0_q, s6_m0_q, s7_m0_q, s8_m0_q;
    logic [RowBits-1:0]   s4_n_q, s5_n_q, s6_n_q, s7_n_q, s8_n_q;
    logic [LaneABits-1:0] s5_over_q, s6_over_q, s7_over_q, s8_m1_q;
    always_ff @(posedge clk_i) begin
      if (valid_q[0]) {s4_m0_q, s4_n_q} <= {s3_m0_q, s3_n_q};
      if (valid_q[1]) {s5_m0_q, s5_n_q, s5_over_q} <= {s4_m0_q, s4_n_q, s4_over_q};
      if (valid_q[2]) {s6_m0_q, s6_n_q, s6_over_q} <= {s5_m0_q, s5_n_q, s5_over_q};
      if (valid_q[3]) {s7_m0_q, s7_n_q, s7_over_q} <= {s6_m0_q, s6_n_q, s6_over_q};
      // the difference fits: it is M1
      if (valid_q[4]) {s8_m0_q, s8_n_q, s8_m1_q} <= {s7_m0_q, s7_n_q, product7[LaneABits-1:0] - s7_over_q};
    end
    // stage 8: the word
    logic [63:0] word;
    assign word = 64'(s8_m1_q) << sp_spec_pkg::GreyM1Lsb | 64'(s8_m0_q) << sp_spec_pkg::GreyM0Lsb |
                  64'(s8_n_q) << sp_spec_pkg::GreyNLsb;
    assign data_o[64*c+:64] = word;
  end

  // s2_valid_q is stage 2 of the first two columns; the words are in stage 8
  assign valid_o = valid_q[Latency-1];
  assign break_o = break_q[Latency-1];

endmodule

`default_nettype wire
