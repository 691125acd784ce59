// Compact payload beats, four columns in 16 bytes, from those of a grey mode, two columns each.
//
// Words come in as sp_column_moments or sp_column_runs gives them. While compact_i is high each
// column is divided (sp_compact_column), and a beat leaves with its last two columns. Else beats
// pass as they are. compact_i and strongest_i change only while nothing is on its way.
//
// Guarantees: beats leave in order. break_o comes after the last beat, or with it. Latency: none
// for a beat that passes; RowBits + 12 clocks from the last two columns of a compact beat and from
// words_break_i. Nothing overflows.
//
//   clock            0   1   2 ... RowBits + 13
//   words_valid_i   _/01\/23\_ ... _______________   columns 0 and 1, then 2 and 3
//   valid_o         __________ ... ______/0123\___
`default_nettype none

module sp_compact_words #(
  parameter int MaxRows = 1023  // 2..1023
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,
  input  wire logic         compact_i,
  input  wire logic         strongest_i,  // words of the strongest run

  input  wire logic         words_valid_i,
  input  wire logic [127:0] words_data_i,
  input  wire logic         words_break_i,

  output logic              valid_o,
  output logic      [127:0] data_o,
  output logic              break_o
);

  localparam int RowBits = $clog2(MaxRows + 1);
  localparam int M0Bits = $clog2(255 * MaxRows + 1);
  localparam int M1Bits = $clog2(255 * MaxRows * (MaxRows + 1) / 2 + 1);
  localparam int Latency = RowBits + 12;  // of sp_compact_column

  logic [Latency:1] valid_q, break_q;
  logic             others_q;  // the two columns that leave next are the last two of their beat
  logic [63:0]      pair;      // two words
  logic [63:0]      first_q;   // the pair before

  for (genvar c = 0; c < 2; c++) begin : gen_column
    logic [63:0] word;
    assign word = words_data_i[64*c+:64];
    sp_compact_column #(
      .MaxRows(MaxRows)
    ) u_column (
      .clk_i      (clk_i),
      .strongest_i(strongest_i),
      .m0_i       (word[sp_spec_pkg::GreyRunM0Lsb+:M0Bits]),
      .m1_i       (word[sp_spec_pkg::GreyRunM1Lsb+:M1Bits]),
      .n_i        (word[sp_spec_pkg::GreyRunNLsb+:RowBits]),
      .runs_i     (word[sp_spec_pkg::GreyRunRunsLsb+:2]),
      .second_i   (word[sp_spec_pkg::GreyRunSecondLsb+:5]),
      .word_o     (pair[32*c+:32])
    );
    logic unused;
    assign unused = ^word;
  end

  always_ff @(posedge clk_i) begin
    if (rst_i) begin
      valid_q  <= '0;
      break_q  <= '0;
      others_q <= 1'b0;
    end else begin
      valid_q <= {valid_q[Latency-1:1], words_valid_i && compact_i};
      break_q <= {break_q[Latency-1:1], words_break_i && compact_i};
      if (valid_q[Latency]) others_q <= !others_q;
    end
  end
  always_ff @(posedge clk_i) if (valid_q[Latency]) first_q <= pair;

  assign valid_o = compact_i ? valid_q[Latency] && others_q : words_valid_i;
  assign data_o  = compact_i ? {pair, first_q} : words_data_i;
  assign break_o = compact_i ? break_q[Latency] : words_break_i;

endmodule

`default_nettype wire
