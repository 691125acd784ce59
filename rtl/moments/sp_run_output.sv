// Grey builds: words from the strongest runs, half a group of columns per clock.
//
// A drain gives the columns of a group in one clock, and the next group comes two clocks later at
// the earliest. Half of them are completed at once, the others wait for a clock. In the grey modes
// each half leaves as it comes; in mode binary the first half waits for the other. With groups of
// four columns:
//
//   clock                     0   1   2 ... 6   7   8
//   best_valid_i             _/A\_______ ... ___________
//   stage 1 of sp_run_finish ---------<01 ... ------------  then columns 2 and 3
//   moments_valid_o          _________ ... _/01\/23\____   grey modes; mode binary: clock 8, all
//
// grey_i and strongest_i are of the frame and do not change while its words are on their way.
`default_nettype none

module sp_run_output #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,  // pixels in a beat: 4, 8 or 16
  // derived, do not set
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int MaxWeight = 2 ** PixelBits - 1,
  parameter int M0Bits = $clog2(MaxWeight * MaxRows + 1),
  parameter int ABits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1),
  parameter int BestBits = 2 + 2 * M0Bits + ABits + 2 * RowBits
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,
  input  wire logic                  grey_i,         // not mode binary
  input  wire logic                  strongest_i,
  input  wire logic                  best_valid_i,
  input  wire logic [Lanes*BestBits-1:0] best_i,         // words of sp_run_best, lane 0 lowest
  input  wire logic                  drain_break_i,  // of sp_drain_order

  output logic                       moments_valid_o,
  output logic      [32*Lanes-1:0]   moments_data_o,
  output logic                       moments_break_o
);

  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end
  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end

  localparam int Half = Lanes / 2;  // columns that are completed per clock
  localparam bit Tall = MaxRows > sp_spec_pkg::MaxRows;
  localparam int BinaryM1Bits = $clog2(MaxRows * (MaxRows + 1) / 2 + 1);
  localparam int OutStage = 7;     // best_valid_i is of stage 0, the payload beat of this one
  localparam int DrainStages = 6;  // from a drain to best_valid_i

  logic [OutStage:1]                valid_q;   // the first half of a group
  logic [DrainStages+OutStage:1]   break_q;
  logic [Half*BestBits-1:0]            wait_q;    // the other half
  logic [Half*BestBits-1:0]            pair_q;    // stage 1
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
    if (best_valid_i) wait_q <= best_i[Half*BestBits+:Half*BestBits];
    pair_q <= best_valid_i ? best_i[0+:Half*BestBits] : wait_q;
  end

  logic [64*Half-1:0] grey_words_q;    // of half a group, in a grey mode
  logic [32*Half-1:0] binary_words_q;  // in mode binary
  logic [32*Half-1:0] first_words_q;   // binary_words_q of one clock ago
  for (genvar c = 0; c < Half; c++) begin : gen_column
    logic [1:0]         runs1, runs6;
    logic [M0Bits-1:0]  second1, m0_1, m0_6;
    logic [RowBits-1:0] n1, row1, n6;
    logic [ABits-1:0]   a1, m1_6;
    logic [4:0]         second6;
    assign {runs1, second1, m0_1, n1, row1, a1} = pair_q[c*BestBits+:BestBits];
    sp_run_finish #(
      .MaxRows  (MaxRows),
      .PixelBits(PixelBits)
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
    logic [63:0]        grey_word;
    if (PixelBits > 8 || Tall) begin : gen_wide
      localparam int NBits = sp_spec_pkg::WideGreyRunNBits;
      logic [NBits-1:0] n;
      logic [63:0]      rest;
      assign n    = 32'(n6) < 2 ** NBits ? NBits'(n6) : {NBits{1'b1}};
      assign rest = strongest_i ? 64'(n) << sp_spec_pkg::WideGreyRunNLsb |
                                  64'(second) << sp_spec_pkg::WideGreyRunSecondLsb :
                                  64'(n6) << sp_spec_pkg::WideGreyNLsb;
      assign grey_word = 64'(m1_6) << sp_spec_pkg::WideGreyRunM1Lsb |
                         64'(m0_6) << sp_spec_pkg::WideGreyRunM0Lsb | rest;
    end else begin : gen_eight
      assign grey_word =
          64'(m1_6) << sp_spec_pkg::GreyRunM1Lsb | 64'(m0_6) << sp_spec_pkg::GreyRunM0Lsb |
          64'(n6) << sp_spec_pkg::GreyRunNLsb | 64'(runs) << sp_spec_pkg::GreyRunRunsLsb |
          64'(second) << sp_spec_pkg::GreyRunSecondLsb;
    end
    // In mode binary M0 is N, M1 needs no more bits than its word has, and half of M0 is 8 / 16.
    logic [31:0] binary_m1, binary_word;
    assign binary_m1 = 32'(m1_6[BinaryM1Bits-1:0]);
    if (Tall) begin : gen_tall
      assign binary_word = binary_m1 << sp_spec_pkg::TallBinaryM1Lsb |
                           32'(n6) << sp_spec_pkg::TallBinaryM0Lsb;
      logic unused_runs;
      assign unused_runs = ^runs;
    end else begin : gen_run
      assign binary_word =
          binary_m1 << sp_spec_pkg::BinaryRunM1Lsb | 32'(n6) << sp_spec_pkg::BinaryRunM0Lsb |
          32'(runs) << sp_spec_pkg::BinaryRunRunsLsb |
          32'(second >= 5'd8) << sp_spec_pkg::BinaryRunSecondLsb;
    end
    always_ff @(posedge clk_i) begin
      grey_words_q[64*c+:64]   <= grey_word;
      binary_words_q[32*c+:32] <= binary_word;
    end
  end
  always_ff @(posedge clk_i) first_words_q <= binary_words_q;

  // In mode binary a group leaves with its other half.
  logic second_q;  // stage 8: the other half of a group
  always_ff @(posedge clk_i) second_q <= !rst_i && valid_q[OutStage];
  assign moments_valid_o = second_q || valid_q[OutStage] && grey_i;
  assign moments_data_o  = grey_i ? grey_words_q : {binary_words_q, first_words_q};
  assign moments_break_o = break_q[DrainStages+OutStage];

endmodule

`default_nettype wire
