// Grey builds: payload beats from the strongest runs, two columns per clock.
//
// A drain gives the four columns of a group in one clock, and the next group comes two clocks later
// at the earliest. Two columns are completed at once, the other two wait for a clock. In the grey
// modes each two columns are a payload beat of 128 bits; in mode binary the first two wait for the
// others.
//
//   clock                     0   1   2 ... 6   7   8
//   best_valid_i             _/A\_______ ... ___________
//   stage 1 of sp_run_finish ---------<01 ... ------------  then columns 2 and 3
//   moments_valid_o          _________ ... _/01\/23\____   grey modes; mode binary: clock 8, all
//
// grey_i and strongest_i are of the frame and do not change while its words are on their way.
`default_nettype none

module sp_run_output #(
  parameter int MaxRows = 1023,  // 2..1023
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int M0Bits = $clog2(255 * MaxRows + 1),
  parameter int ABits = $clog2(255 * MaxRows * (MaxRows + 1) / 2 + 1),
  parameter int BestBits = 2 + 2 * M0Bits + ABits + 2 * RowBits
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,
  input  wire logic                  grey_i,         // not mode binary
  input  wire logic                  strongest_i,
  input  wire logic                  best_valid_i,
  input  wire logic [4*BestBits-1:0] best_i,         // words of sp_run_best, lane 0 lowest
  input  wire logic                  drain_break_i,  // of sp_drain_order

  output logic                       moments_valid_o,
  output logic      [127:0]          moments_data_o,
  output logic                       moments_break_o
);

  localparam int BinaryM1Bits = $clog2(MaxRows * (MaxRows + 1) / 2 + 1);
  localparam int OutStage = 7;     // best_valid_i is of stage 0, the payload beat of this one
  localparam int DrainStages = 6;  // from a drain to best_valid_i

  logic [OutStage:1]                valid_q;   // the first two columns of a group
  logic [DrainStages+OutStage:1]   break_q;
  logic [2*BestBits-1:0]            wait_q;    // the other two
  logic [2*BestBits-1:0]            pair_q;    // stage 1
  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q <= '0;
      break_q <= '0;
    end else begin
      valid_q <= {valid_q[OutStage-1:1], best_valid_i};
      break_q <= {break_q[DrainStages+OutStage-1:1], drain_break_i};
    end
  end
  always_ff @(posedge clk_i) begin
    if (best_valid_i) wait_q <= best_i[2*BestBits+:2*BestBits];
    pair_q <= best_valid_i ? best_i[0+:2*BestBits] : wait_q;
  end

  logic [127:0] grey_words_q;    // of two columns, in a grey mode
  logic [63:0]  binary_words_q;  // in mode binary
  logic [63:0]  first_words_q;   // binary_words_q of one clock ago
  for (genvar c = 0; c < 2; c++) begin : gen_column
    logic [1:0]         runs1, runs6;
    logic [M0Bits-1:0]  second1, m0_1, m0_6;
    logic [RowBits-1:0] n1, row1, n6;
    logic [ABits-1:0]   a1, m1_6;
    logic [4:0]         second6;
    assign {runs1, second1, m0_1, n1, row1, a1} = pair_q[c*BestBits+:BestBits];
    sp_run_finish #(
      .MaxRows(MaxRows)
    ) u_finish (
      .clk_i   (clk_i),
      .runs_i  (runs1),
      .second_i(second1),
      .m0_i    (m0_1),
      .n_i     (n1),
      .row_i   (row1),
      .a_i     (a1),
      .runs_o  (runs6),
      .second_o(second6),
      .m0_o    (m0_6),
      .n_o     (n6),
      .m1_o    (m1_6)
    );
    logic [1:0]         runs;
    logic [4:0]         second;
    assign {runs, second} = strongest_i ? {runs6, second6} : 7'd0;
    always_ff @(posedge clk_i) begin
      grey_words_q[64*c+:64] <=
          64'(m1_6) << sp_spec_pkg::GreyRunM1Lsb | 64'(m0_6) << sp_spec_pkg::GreyRunM0Lsb |
          64'(n6) << sp_spec_pkg::GreyRunNLsb | 64'(runs) << sp_spec_pkg::GreyRunRunsLsb |
          64'(second) << sp_spec_pkg::GreyRunSecondLsb;
      // In mode binary M0 is N, M1 needs no more bits than its word has, and half of M0 is 8 / 16.
      binary_words_q[32*c+:32] <=
          32'(m1_6[BinaryM1Bits-1:0]) << sp_spec_pkg::BinaryRunM1Lsb |
          32'(n6) << sp_spec_pkg::BinaryRunM0Lsb | 32'(runs) << sp_spec_pkg::BinaryRunRunsLsb |
          32'(second >= 5'd8) << sp_spec_pkg::BinaryRunSecondLsb;
    end
  end
  always_ff @(posedge clk_i) first_words_q <= binary_words_q;

  // In mode binary a beat leaves with its last two columns.
  logic second_q;  // stage 8: the last two columns of a group
  always_ff @(posedge clk_i) second_q <= !rst_i && valid_q[OutStage];
  assign moments_valid_o = second_q || valid_q[OutStage] && grey_i;
  assign moments_data_o  = grey_i ? grey_words_q : {binary_words_q, first_words_q};
  assign moments_break_o = break_q[DrainStages+OutStage];

endmodule

`default_nettype wire
