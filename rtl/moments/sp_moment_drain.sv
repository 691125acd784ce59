// Grey modes: finishes the sums of the last row, two columns a clock.
//
// In the grey modes a column is 64 bits, so four columns of a beat leave in two clocks while the last row comes in one beat
// a clock. The last row is therefore not added up: its weights wait in a line buffer of one row (push_*), and this module
// reads group after group every second clock from the sums of the rows before (drain_*), adds the last row and
// finishes M1:
//
//   M0 = M0' + v,  N = N' + [v > 0],  M1 = R*M0 - (A + M0')       (M0', N', A: after row R-1; v: the last row's weight)
//
// M0' and A come in halves, as sp_moment_sums keeps them, and are put together here.
//
// Guarantees: words leave in column order; break_o comes after the last word where break_i ended the frame early. A pushed group is
// read two clocks later at the earliest. Beats that are added a clock after they would be pushed never meet a drain read, between
// frames of equal settings: the second row of the next begins one clock after the last drain read. active_o tells the others (after
// a change of settings) to keep away; it goes back with the last drain read. Nothing overflows: M1 fits (sp_spec_pkg), and the
// line buffer has room for a row, which is drained before the next one wanted comes (sp_packetizer refuses it sooner).
// Latency: a group's first two columns leave ten clocks after its drain read, the other two a clock later. Two groups:
//
//   clock        0   1   2   3   4   5   6  ... 11  12  13  14  15  16
//   push_i      _/A\_/B\____________________ ... ________________________   push_end_i with B
//   waiting_q   _____/11111111111\___________ ... ________________________
//   drain_o     _________/A\_____/B\_________ ... ________________________
//   active_o    _____/11111111111\___________ ... ________________________
//   raw_m_i     -------------< A >---< B >--- ... ------------------------
//   raw_a_i     -----------------< A >---< B  ... ------------------------
//   valid_o     ____________________________ ... ____/A01/A23/B01/B23\____
`default_nettype none

module sp_moment_drain #(
  parameter int MaxRows = 1023,
  parameter int GroupBits = 9,
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int M0Bits = $clog2(255 * MaxRows + 1),
  parameter int ABits = $clog2(255 * MaxRows * (MaxRows + 1) / 2 + 1),
  parameter int LaneMBits = M0Bits + 1 + RowBits,
  parameter int LaneABits = ABits + 1
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

  // Reads of the sums: address now, M one clock later, A two clocks later; in halves
  output logic                        drain_o,
  output logic [GroupBits-1:0]        drain_group_o,
  output logic                        active_o,
  input  wire logic [4*LaneMBits-1:0] raw_m_i,
  input  wire logic [4*LaneABits-1:0] raw_a_i,
  input  wire logic [4*LaneMBits-1:0] sum_m_i,
  input  wire logic [4*LaneABits-1:0] sum_a_i,
  input  wire logic                   sum_m_comes_i,  // sum_m_i will be of the beat two clocks before the read: not in the memory yet
  input  wire logic                   sum_a_comes_i,

  output logic                        valid_o,
  output logic [127:0]                data_o,  // 0 where not valid
  output logic                        break_o
);

  localparam int Latency = 8;  // from stage 2 to stage 10, the words
  localparam int MLow = sp_spec_pkg::PixelBits;
  localparam int MHigh = M0Bits - MLow;
  localparam int ALow = (ABits + 1) / 2;
  localparam int AHigh = ABits - ALow;

  // Line buffer and what is left in it
  logic                 waiting_q;      // groups wait: from group_q to last_group_q
  logic                 one_waits_q;    // in the second clock after a read, and later: only one waits
  logic [GroupBits-1:0] group_q;        // the next to be read
  logic [GroupBits-1:0] last_group_q;   // the last that was pushed
  logic                 row_ended_q;    // no further push of this row will come
  logic                 break_asked_q;  // and it ended by a break, which break_o has not told yet
  logic                 break_now;      // nothing is left before the break: it enters the stages
  logic                 read_now;       // a drain read in the next clock
  logic                 last_read;      // and that is the row's last
  logic                 drained_q;      // the last read, or the break, was decided a clock ago
  logic                 s1_read_q;      // a drain read was in the clock before
  logic [RowBits-1:0]   row_number_q;   // of the last row: R
  logic                 first_row_q;    // it is the first, too: there are no sums of rows before it
  logic                 one_group_q;    // the image has 4 columns
  logic [31:0]          raw_weights;    // of the last row, from the line buffer

  assign read_now  = waiting_q && !drain_o;
  assign last_read = read_now && row_ended_q && one_waits_q;
  assign break_now = break_asked_q && !waiting_q && !drain_o;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      waiting_q     <= 1'b0;
      row_ended_q   <= 1'b0;
      break_asked_q <= 1'b0;
      drain_o       <= 1'b0;
      s1_read_q     <= 1'b0;
      drained_q     <= 1'b0;
      active_o      <= 1'b0;
      group_q       <= '0;
    end else begin
      drain_o   <= read_now;
      s1_read_q <= drain_o;
      waiting_q <= push_i || waiting_q && !(read_now && one_waits_q);

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
    // a group pushed where none waits is group_q
    one_waits_q   <= push_i ? !waiting_q : group_q == last_group_q;
    if (push_i) last_group_q <= push_group_i;
  end

  always_ff @(posedge clk_i) begin
    if (push_i) begin
      row_number_q <= push_row_i;
      first_row_q  <= push_first_row_i;
      one_group_q  <= push_one_group_i;
    end
  end

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
  logic                   s2_first_q, s3_first_q;  // the stage has a group's first two columns
  logic                   s1_from_sum_q, s2_from_sum_q;  // the sums that the memories do not have yet are at sum_m_i, sum_a_i
  logic                   s2_valid_q;      // the stage has columns, the first two or the others
  logic [4*LaneMBits-1:0] s2_m_q;
  logic [4*LaneABits-1:0] s3_a_q;
  logic [31:0]            s2_weights_q;
  logic                   s0_break_q, s1_break_q, s2_break_q;  // the break in the stages, behind the last word

  logic [Latency-1:0]     valid_q;  // from stage 3 on
  logic [Latency-1:0]     break_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      s2_first_q <= 1'b0;
      s2_valid_q <= 1'b0;
      s0_break_q <= 1'b0;
      s1_break_q <= 1'b0;
      s2_break_q <= 1'b0;
      valid_q    <= '0;
      break_q    <= '0;
    end else begin
      s2_first_q <= s1_read_q;
      s2_valid_q <= s1_read_q || s2_first_q;  // two clocks, for two columns each
      s0_break_q <= break_now;
      s1_break_q <= s0_break_q;
      s2_break_q <= s1_break_q;
      valid_q    <= {valid_q[Latency-2:0], s2_valid_q};
      break_q    <= {break_q[Latency-2:0], s2_break_q};
    end
  end

  // Something is in the stages from 2 on: all of them move, or none, which is one enable for a synthesizer.
  logic moving_q;
  logic s9_empty_q;  // no columns are in stage 9: !valid_q[6]
  always_ff @(posedge clk_i) s9_empty_q <= rst_i || !valid_q[5];
  always_ff @(posedge clk_i) moving_q <= drain_o || s1_read_q || s2_valid_q || valid_q[Latency-3:0] != '0;

  always_ff @(posedge clk_i) begin
    s3_first_q    <= s2_first_q;
    s1_from_sum_q <= one_group_q && sum_m_comes_i;
    s2_from_sum_q <= one_group_q && sum_a_comes_i;
    if (s1_read_q) begin
      s2_m_q       <= first_row_q ? '0 : s1_from_sum_q ? sum_m_i : raw_m_i;
      s2_weights_q <= raw_weights;
    end
    if (s2_first_q) s3_a_q <= first_row_q ? '0 : s2_from_sum_q ? sum_a_i : raw_a_i;
  end

  for (genvar c = 0; c < 2; c++) begin : gen_column
    // stage 3: one of the two columns
    logic [7:0]           s3_weight_q;
    logic [RowBits-1:0]   s3_n_q;
    logic [MHigh-1:0]     s3_m_high_q;
    logic [MLow-1:0]      s3_m_low_q;
    logic                 s3_m_carry_q;
    always_ff @(posedge clk_i) if (moving_q) begin
      {s3_n_q, s3_m_high_q, s3_m_carry_q, s3_m_low_q} <= s2_first_q ? s2_m_q[c*LaneMBits+:LaneMBits] :
                                                                      s2_m_q[(c+2)*LaneMBits+:LaneMBits];
      s3_weight_q <= s2_first_q ? s2_weights_q[c*8+:8] : s2_weights_q[(c+2)*8+:8];
    end

    // stage 4: M0' in one piece; the low half of M0; N; A of the column
    logic [MHigh-1:0]     s4_m_high_q;
    logic [MLow-1:0]      s4_old_low_q, s4_m_low_q;
    logic                 s4_m_carry_q, s4_lit_q;
    logic [RowBits-1:0]   s4_n_q;
    logic [AHigh-1:0]     s4_a_high_q;
    logic [ALow-1:0]      s4_a_low_q;
    logic                 s4_a_carry_q;
    always_ff @(posedge clk_i) if (moving_q) begin
      s4_m_high_q                             <= s3_m_high_q + MHigh'(s3_m_carry_q);
      s4_old_low_q                            <= s3_m_low_q;
      {s4_m_carry_q, s4_m_low_q}              <= {1'b0, s3_m_low_q} + {1'b0, s3_weight_q};
      s4_lit_q                                <= s3_weight_q != '0;
      s4_n_q                                  <= s3_n_q;
      {s4_a_high_q, s4_a_carry_q, s4_a_low_q} <= s3_first_q ? s3_a_q[c*LaneABits+:LaneABits] : s3_a_q[(c+2)*LaneABits+:LaneABits];
    end

    // stage 5: M0; what R*M0 counts too much, in halves
    logic [M0Bits-1:0]    s5_m0_q;
    logic [RowBits-1:0]   s5_n_q;
    logic [AHigh-1:0]     s5_excess_high_q, old_high;
    logic [ALow-1:0]      s5_excess_low_q, old_low;
    logic                 s5_excess_carry_q, s5_unused_foot_q;
    assign {old_high, old_low} = ABits'({s4_m_high_q, s4_old_low_q});
    always_ff @(posedge clk_i) if (moving_q) begin
      s5_m0_q <= {s4_m_high_q + MHigh'(s4_m_carry_q), s4_m_low_q};
      s5_n_q  <= s4_n_q + RowBits'(s4_lit_q);
      // the carry goes in at the foot of the chain
      {s5_excess_high_q, s5_unused_foot_q} <= {s4_a_high_q, 1'b1} + {old_high, s4_a_carry_q};
      {s5_excess_carry_q, s5_excess_low_q} <= {1'b0, s4_a_low_q} + {1'b0, old_low};
    end

    // stages 6 to 9: R*M0, and the rest beside it
    // R*M0 can have a bit more than M1 needs: it falls out of the difference
    logic [M0Bits+RowBits-1:0] product9;
    logic                      unused_product;
    assign unused_product = ^product9;
    sp_scale #(
      .XBits(M0Bits),
      .KBits(RowBits)
    ) u_scale (
      .clk_i    (clk_i),
      .move_i   (moving_q),
      .x_i      (s5_m0_q),
      .k_i      (row_number_q),
      .product_o(product9)
    );

    logic [M0Bits-1:0]  s6_m0_q, s7_m0_q, s8_m0_q, s9_m0_q, s10_m0_q;
    logic [RowBits-1:0] s6_n_q, s7_n_q, s8_n_q, s9_n_q, s10_n_q;
    logic [ABits-1:0]   s6_excess_q, s7_excess_q, s8_excess_q, s9_not_excess_q, s10_m1_q;
    logic               s10_unused_foot_q;
    always_ff @(posedge clk_i) begin
      if (moving_q) begin
        {s6_m0_q, s6_n_q}                  <= {s5_m0_q, s5_n_q};
        s6_excess_q                        <= {s5_excess_high_q + AHigh'(s5_excess_carry_q), s5_excess_low_q};
        {s7_m0_q, s7_n_q, s7_excess_q}     <= {s6_m0_q, s6_n_q, s6_excess_q};
        {s8_m0_q, s8_n_q, s8_excess_q}     <= {s7_m0_q, s7_n_q, s7_excess_q};
        {s9_m0_q, s9_n_q, s9_not_excess_q} <= {s8_m0_q, s8_n_q, ~s8_excess_q};
      end
      // the difference fits: it is M1
      if (s9_empty_q) {s10_m0_q, s10_n_q, s10_m1_q, s10_unused_foot_q} <= '0;
      else {s10_m0_q, s10_n_q, s10_m1_q, s10_unused_foot_q} <= {s9_m0_q, s9_n_q,
                                                                 {product9[ABits-1:0], 1'b1} + {s9_not_excess_q, 1'b1}};
    end
    // stage 10: the word
    logic [63:0] word;
    assign word = 64'(s10_m1_q) << sp_spec_pkg::GreyM1Lsb | 64'(s10_m0_q) << sp_spec_pkg::GreyM0Lsb |
                  64'(s10_n_q) << sp_spec_pkg::GreyNLsb;
    assign data_o[64*c+:64] = word;
  end

  // s2_valid_q is stage 2 of the first two columns; the words are in stage 10
  assign valid_o = valid_q[Latency-1];
  assign break_o = break_q[Latency-1];

endmodule

`default_nettype wire
