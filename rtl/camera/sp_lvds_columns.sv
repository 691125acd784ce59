// Puts the pixels of a line in order, where each lane carries neighbouring columns of its own: lane n
// those from n x Columns on (CMV2000: 16 lanes of 128 columns).
//
// A line is written into one half of a memory while the line before is read from the other. Each
// lane's word t goes to bank (lane + t) mod Lanes. So the words of one clock go to different banks,
// and so do Lanes neighbouring columns, which are read in one clock.
//
// Guarantees: group_o holds Lanes neighbouring columns, the leftmost in 7..0. The groups of a line
// leave from left to right, in successive clocks, and ending_o comes one clock behind the last one.
// A line must take Columns + 1 clocks or more from its last word to that of the next line.
//
// Latency: the first group leaves 2 clocks after the last word of its line. Lanes = Columns = 4:
//
//   take_i     /111111111111111\___________________________
//   last_i     ____________/111\___________________________
//   full_o     ____________________/111111111111111\_______   columns 0..3, 4..7, 8..11, 12..15
//   ending_o   ____________________________________/111\___
`default_nettype none

module sp_lvds_columns #(
  parameter int Lanes = 16,  // 1, 2, 4, 8 or 16
  parameter int Columns = 128  // of a lane: 1..4096, a multiple of Lanes
) (
  input  wire logic               clk_i,
  input  wire logic               rst_i,     // active high, synchronous
  input  wire logic               begins_i,  // a frame begins, with its first word or before it
  input  wire logic               take_i,    // one pixel of each lane
  input  wire logic               last_i,    // with it: the last ones of their line
  input  wire logic               cut_i,     // the line is lost
  input  wire logic [8*Lanes-1:0] pixels_i,
  output logic                    begins_o,  // with the first group of a frame
  output logic                    full_o,
  output logic      [8*Lanes-1:0] group_o,
  output logic                    ending_o
);

  if (Lanes != 1 && Lanes != 2 && Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_1_2_4_8_or_16 u_error ();
  end
  if (Columns < 1 || Columns > 4096 || Columns % Lanes != 0) begin : gen_columns
    columns_is_not_a_multiple_of_lanes_in_1_to_4096 u_error ();
  end

  localparam int Turns = Lanes < 2 ? 1 : $clog2(Lanes);  // bits of a lane's number
  localparam int Blocks = Lanes < 1 ? 1 : Columns / Lanes;  // groups of a lane
  localparam int BlockBits = Blocks < 2 ? 1 : $clog2(Blocks);
  localparam logic [Turns-1:0] LastLane = Turns'(Lanes - 1);
  localparam logic [BlockBits-1:0] LastBlock = BlockBits'(Blocks - 1);

  // --- Writing ---
  logic                 half_q;   // of the memory
  logic [Turns-1:0]     word_q;   // of the line, modulo Lanes
  logic [BlockBits-1:0] block_q;  // and divided by it
  logic                 first_q;  // the line is the first of its frame
  logic                 done;

  assign done = take_i && last_i && !rst_i && !cut_i;

  always_ff @(posedge clk_i) begin
    if (rst_i) half_q <= 1'b0;
    else if (done) half_q <= !half_q;
    if (rst_i || cut_i || take_i && last_i) begin
      word_q  <= '0;
      block_q <= '0;
    end else if (take_i) begin
      word_q <= word_q == LastLane ? '0 : word_q + 1'b1;
      if (word_q == LastLane) block_q <= block_q + 1'b1;
    end
    if (begins_i) first_q <= 1'b1;
    else if (done) first_q <= 1'b0;
  end

  // --- Reading ---
  logic                 reading_q, reading_q2;
  logic                 of_half_q, of_first_q, of_first_q2;
  logic [Turns-1:0]     lane_q, lane_q2;
  logic [BlockBits-1:0] of_block_q;
  logic                 last_group;

  assign last_group = of_block_q == LastBlock && lane_q == LastLane;
  assign full_o     = reading_q2;
  assign begins_o   = reading_q2 && of_first_q2;

  always_ff @(posedge clk_i) begin
    reading_q2  <= reading_q && !rst_i && !cut_i;
    of_first_q2 <= of_first_q;
    lane_q2     <= lane_q;
    ending_o    <= reading_q2 && !reading_q && !rst_i;
    if (rst_i || cut_i) reading_q <= 1'b0;
    else if (done) reading_q <= 1'b1;
    else if (last_group) reading_q <= 1'b0;
    if (done) begin
      of_half_q  <= half_q;
      of_first_q <= first_q || begins_i;
      lane_q     <= '0;
      of_block_q <= '0;
    end else if (reading_q) begin
      of_first_q <= 1'b0;
      of_block_q <= of_block_q == LastBlock ? '0 : of_block_q + 1'b1;
      if (of_block_q == LastBlock) lane_q <= lane_q == LastLane ? '0 : lane_q + 1'b1;
    end
  end

  // --- The banks, and the turning of what goes in and comes out ---
  logic [8*Lanes-1:0] in, in_last, out_last, read;

  always_comb begin
    in = pixels_i;
    for (int s = 0; s < Turns; s++) begin
      in_last = in;
      for (int n = 0; n < Lanes; n++) begin
        if (word_q[s]) in[8*n+:8] = in_last[8*((n+Lanes-(1<<s)%Lanes)%Lanes)+:8];
      end
    end
  end

  always_comb begin
    group_o = read;
    for (int s = 0; s < Turns; s++) begin
      out_last = group_o;
      for (int n = 0; n < Lanes; n++) begin
        if (lane_q2[s]) group_o[8*n+:8] = out_last[8*((n+(1<<s))%Lanes)+:8];
      end
    end
  end

  for (genvar n = 0; n < Lanes; n++) begin : gen_bank
    logic [Turns-1:0] lane;  // whose pixel comes to this bank
    assign lane = Lanes == 1 ? '0 : Turns'(n) - word_q;

    sp_ram #(
      .Width   (8),
      .LogDepth(1 + Turns + BlockBits)
    ) u_ram (
      .wr_clk_i (clk_i),
      .wr_en_i  (take_i),
      .wr_addr_i({half_q, lane, block_q}),
      .wr_data_i(in[8*n+:8]),
      .rd_clk_i (clk_i),
      .rd_en_i  (reading_q),
      .rd_addr_i({of_half_q, lane_q, of_block_q}),
      .rd_data_o(read[8*n+:8])
    );
  end

endmodule

`default_nettype wire
