// Runs of the columns, a group of them in every clock: sums of the open run, and the strongest of the
// ended runs.
//
// Beats come in two streams. add_*: every row of a frame but the last. drain_*: the last row, which
// may come later, beside the first row of the next frame. A drain ends every open run; the
// strongest run of each column leaves six clocks after it, and nothing is written. The first row of
// a frame needs no read, so it passes through beside a drain.
//
// Guarantees: everything is right at every distance between two beats of one column, down to the
// very next clock, if a drain comes two clocks after the add of the row before it, or later. (An
// image of one group has all its beats in it.) What a memory does not have yet is
// taken from the stage that has it, which the group numbers tell. No sum wraps.
//
// Memories, each with one read and one write per clock; D, M and A are those of sp_run_lane:
//
//   stage         0   1   2   3   4   5   6
//   add_i, drain_i /1\_________________________
//   D             rd      wr
//   M                 rd      wr
//   A                     rd      wr
//   best (each)           rd          wr
//   best_o        -------------------------< B   word of sp_run_best, lane 0 lowest
//   best_valid_o  _________________________/1\   after a drain
`default_nettype none

module sp_run_sums #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int GroupBits = 9,  // 1..24
  parameter bit Grey = 1'b1,
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WeightBits = Grey ? PixelBits : 1,
  parameter int MaxWeight = 2 ** WeightBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1),
  parameter int BestBits = 2 + 2 * M0Bits + ABits + (Grey ? 2 * RowBits : 0)
) (
  input  wire logic                    clk_i,
  input  wire logic                    rst_i,

  input  wire logic                    add_i,
  input  wire logic                    add_first_i,   // of the first row
  input  wire logic [GroupBits-1:0]    add_group_i,
  input  wire logic [RowBits-1:0]      add_row_i,
  input  wire logic [Lanes*WeightBits-1:0] add_weights_i,
  // The same with every add_i of a frame
  input  wire logic                    strongest_i,  // a run ends; else never
  input  wire logic [1:0]              gap_i,  // dark rows that a run may have inside


  // Not in a clock with add_i, unless add_first_i is high
  input  wire logic                    drain_i,
  input  wire logic [GroupBits-1:0]    drain_group_i,
  input  wire logic [RowBits-1:0]      drain_row_i,
  input  wire logic [Lanes*WeightBits-1:0] drain1_weights_i,  // one clock later
  input  wire logic [Lanes-1:0]        drain1_lit_i,      // likewise: the weight is not 0

  output logic                         best_valid_o,
  output logic      [Lanes*BestBits-1:0]   best_o
);

  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  localparam int MBits = Grey ? M0Bits + RowBits : M0Bits;
  localparam int RestBits = ABits + (Grey ? 2 * RowBits : 0);

  // --- Stage 0: the main beat, and whether a value of its column is still on its way ---
  logic                    main;
  logic [GroupBits-1:0]    main_group;
  logic [RowBits-1:0]      main_row;
  assign main       = drain_i || add_i && !add_first_i;
  assign main_group = drain_i ? drain_group_i : add_group_i;
  assign main_row   = drain_i ? drain_row_i : add_row_i;

  logic [6:1]              drain_q;       // the main beat is a drain
  logic [2:1]              main_q;        // there is a main beat
  logic [5:1]              keep_q;        // a main beat that is no drain: best may change
  logic [4:1]              write_q;       // an add, first or not: D, M and A are written
  logic [3:1]              first_q;       // an add of the first row
  logic [GroupBits-1:0]    s1_group_q, s2_group_q;                          // of the main beat
  // of the add
  logic [GroupBits-1:0]    w1_group_q, w2_group_q, w3_group_q, w4_group_q, w5_group_q;
  logic [3:1]              onto_new_q, onto_last_q;  // the adds one and two clocks before are ...
  logic [Lanes*WeightBits-1:0] s1_weights, w1_weights_q;
  logic [Lanes-1:0]        w1_lit_q;      // these weights are not 0
  logic [RowBits-1:0]      s1_row_q, s2_row_q, s3_row_q, s4_row_q, s5_row_q;
  logic                    s1_strongest_q, s2_strongest_q;
  logic [1:0]              s1_gap_q, s2_gap_q;
  logic                    s1_alone_q;
  logic                    s2_none_q, s3_none_q;     // no run of the column has ended before
  logic                    s2_second_row_q, s3_second_row_q, s4_second_row_q;
  logic                    s3_after_new_q, s3_after_last_q;

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      drain_q <= '0;
      main_q  <= '0;
      keep_q  <= '0;
      write_q <= '0;
      first_q <= '0;
    end else begin
      drain_q <= {drain_q[5:1], drain_i};
      main_q  <= {main_q[1], main};
      keep_q  <= {keep_q[4:1], add_i && !add_first_i};
      write_q <= {write_q[3:1], add_i};
      first_q <= {first_q[2:1], add_i && add_first_i};
    end
  end

  always_ff @(posedge clk_i) begin
    s1_group_q     <= main_group;
    s2_group_q     <= s1_group_q;
    w1_group_q     <= add_group_i;
    {w2_group_q, w3_group_q, w4_group_q, w5_group_q} <=
        {w1_group_q, w2_group_q, w3_group_q, w4_group_q};
    onto_new_q     <= {onto_new_q[2:1], write_q[1] && w1_group_q == main_group};
    onto_last_q    <= {onto_last_q[2:1], write_q[2] && w2_group_q == main_group};
    w1_weights_q   <= add_weights_i;
    s1_row_q       <= main_row;
    {s2_row_q, s3_row_q, s4_row_q, s5_row_q} <= {s1_row_q, s2_row_q, s3_row_q, s4_row_q};
    s1_strongest_q <= strongest_i && !drain_i;
    s2_strongest_q <= s1_strongest_q;
    s1_gap_q       <= gap_i;
    s2_gap_q       <= s1_gap_q;
    s1_alone_q     <= main_row == RowBits'(1);
    // The first run that can end does so in the second row, and the next one in the fourth, or with
    // the frame. The second row writes best whatever it has.
    s2_none_q      <= s1_row_q <= RowBits'(2) || s1_row_q == RowBits'(3) && !drain_q[1];
    s3_none_q      <= s2_none_q;
    s2_second_row_q    <= s1_row_q == RowBits'(2);
    {s3_second_row_q, s4_second_row_q} <= {s2_second_row_q, s3_second_row_q};
    s3_after_new_q  <= keep_q[4] && w4_group_q == s2_group_q;
    s3_after_last_q <= keep_q[5] && w5_group_q == s2_group_q;
  end

  assign s1_weights = drain_q[1] ? drain1_weights_i : w1_weights_q;

  // --- Memories of all lanes ---
  logic [Lanes*3-1:0]     raw_d, wr_d;
  logic [Lanes*MBits-1:0] raw_m, wr_m;
  logic [Lanes*ABits-1:0] raw_a, wr_a;

  sp_ram #(
    .Width   (Lanes * 3),
    .LogDepth(GroupBits)
  ) u_d (
    .wr_clk_i (clk_i),
    .wr_en_i  (write_q[2]),
    .wr_addr_i(w2_group_q),
    .wr_data_i(wr_d),
    .rd_clk_i (clk_i),
    .rd_en_i  (main),
    .rd_addr_i(main_group),
    .rd_data_o(raw_d)
  );

  sp_ram #(
    .Width   (Lanes * MBits),
    .LogDepth(GroupBits)
  ) u_m (
    .wr_clk_i (clk_i),
    .wr_en_i  (write_q[3]),
    .wr_addr_i(w3_group_q),
    .wr_data_i(wr_m),
    .rd_clk_i (clk_i),
    .rd_en_i  (main_q[1]),
    .rd_addr_i(s1_group_q),
    .rd_data_o(raw_m)
  );

  sp_ram #(
    .Width   (Lanes * ABits),
    .LogDepth(GroupBits)
  ) u_a (
    .wr_clk_i (clk_i),
    .wr_en_i  (write_q[4]),
    .wr_addr_i(w4_group_q),
    .wr_data_i(wr_a),
    .rd_clk_i (clk_i),
    .rd_en_i  (main_q[2]),
    .rd_addr_i(s2_group_q),
    .rd_data_o(raw_a)
  );

  for (genvar lane = 0; lane < Lanes; lane++) begin : gen_lane
    logic                s3_ends, s3_has_run, s4_ends_q, s4_run_q, s5_keep_q;
    logic [MBits-1:0]    s4_m;
    logic [ABits-1:0]    s5_a;
    logic [RestBits-1:0] s5_rest;

    sp_run_lane #(
      .MaxRows  (MaxRows),
      .Grey     (Grey),
      .PixelBits(PixelBits)
    ) u_lane (
      .clk_i          (clk_i),
      .s1_weight_i    (s1_weights[lane*WeightBits+:WeightBits]),
      .s1_lit_i       (drain_q[1] ? drain1_lit_i[lane] : w1_lit_q[lane]),
      .s1_alone_i     (s1_alone_q),
      .s1_onto_new_i  (onto_new_q[1]),
      .s1_onto_last_i (onto_last_q[1]),
      .s2_onto_new_i  (onto_new_q[2]),
      .s2_onto_last_i (onto_last_q[2]),
      .s3_onto_new_i  (onto_new_q[3]),
      .s3_onto_last_i (onto_last_q[3]),
      .s2_gap_i       (s2_gap_q),
      .s2_strongest_i (s2_strongest_q),
      .s3_row_i       (s3_row_q),
      .s3_second_row_i(s3_second_row_q),
      .w1_weight_i    (w1_weights_q[lane*WeightBits+:WeightBits]),
      .w1_lit_i       (w1_lit_q[lane]),
      .w2_first_i     (first_q[2]),
      .w3_first_i     (first_q[3]),
      .raw_d_i        (raw_d[lane*3+:3]),
      .raw_m_i        (raw_m[lane*MBits+:MBits]),
      .raw_a_i        (raw_a[lane*ABits+:ABits]),
      .wr_d_o         (wr_d[lane*3+:3]),
      .wr_m_o         (wr_m[lane*MBits+:MBits]),
      .wr_a_o         (wr_a[lane*ABits+:ABits]),
      .s3_ends_o      (s3_ends),
      .s3_has_run_o   (s3_has_run),
      .s4_m_o         (s4_m),
      .s5_a_o         (s5_a)
    );

    always_ff @(posedge clk_i) begin
      w1_lit_q[lane] <= add_weights_i[lane*WeightBits+:WeightBits] != '0;
      s4_ends_q <= s3_ends;
      s5_keep_q <= keep_q[4] && (s4_ends_q || s4_second_row_q);
      s4_run_q  <= s3_ends || s3_has_run && drain_q[3];
    end
    if (Grey) begin : gen_grey
      logic [RowBits-1:0] s5_n_q;
      always_ff @(posedge clk_i) s5_n_q <= s4_m[M0Bits+:RowBits];
      assign s5_rest = {s5_n_q, s5_row_q, s5_a};
    end else begin : gen_binary
      assign s5_rest = s5_a;
    end

    sp_run_best #(
      .GroupBits(GroupBits),
      .M0Bits   (M0Bits),
      .RestBits (RestBits)
    ) u_best (
      .clk_i          (clk_i),
      .read_i         (main_q[2]),
      .read_group_i   (s2_group_q),
      .s3_none_i      (s3_none_q),
      .s3_after_new_i (s3_after_new_q),
      .s3_after_last_i(s3_after_last_q),
      .s4_run_i       (s4_run_q),
      .s4_m0_i        (s4_m[M0Bits-1:0]),
      .s5_keep_i      (s5_keep_q),
      .s5_group_i     (w5_group_q),
      .s5_rest_i      (s5_rest),
      .best_o         (best_o[lane*BestBits+:BestBits])
    );
  end

  assign best_valid_o = drain_q[6];

  if (!Grey) begin : gen_no_row
    logic unused;
    assign unused = ^s5_row_q;
  end

endmodule

`default_nettype wire
