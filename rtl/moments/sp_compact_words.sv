// Compact columns, a group at once, from the words of a grey mode, half a group at once.
//
// Words come in as sp_column_moments or sp_column_runs gives them. While compact_i is high each
// column is divided (sp_compact_column), and a group leaves with its second half. Else words pass
// as they are. compact_i and strongest_i change only while nothing is on its way. Words of pixels
// of more than 8 bits, and of MaxRows above 1,023, tell no number of runs: it counts as 2 where the
// second run is not 0, else 1.
//
// Guarantees: groups leave in order. break_o comes after the last one, or with it. Latency: none
// for words that pass; RowBits + 12 clocks from the second half of a group and from words_break_i.
// Nothing overflows. With groups of four columns:
//
//   clock            0   1   2 ... RowBits + 13
//   words_valid_i   _/01\/23\_ ... _______________   columns 0 and 1, then 2 and 3
//   valid_o         __________ ... ______/0123\___
`default_nettype none

module sp_compact_words #(
  parameter int MaxRows = 1023,  // 2..2047
  parameter int PixelBits = sp_spec_pkg::PixelBits,  // 8..12
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat  // pixels in a beat: 4, 8 or 16
) (
  input  wire logic         clk_i,
  input  wire logic         rst_i,
  input  wire logic         compact_i,
  input  wire logic         strongest_i,  // words of the strongest run

  input  wire logic         words_valid_i,
  input  wire logic [32*Lanes-1:0] words_data_i,
  input  wire logic         words_break_i,

  output logic              valid_o,
  output logic      [32*Lanes-1:0] data_o,
  output logic              break_o
);

  if (PixelBits < 8 || PixelBits > 12) begin : gen_pixel_bits
    pixel_bits_is_not_in_8_to_12 u_error ();
  end
  if (Lanes != 4 && Lanes != 8 && Lanes != 16) begin : gen_lanes
    lanes_is_not_4_or_8_or_16 u_error ();
  end

  localparam int RowBits = $clog2(MaxRows + 1);
  localparam int MaxWeight = 2 ** PixelBits - 1;
  localparam int M0Bits = $clog2(MaxWeight * MaxRows + 1);
  localparam int M1Bits = $clog2(MaxWeight * (MaxRows * (MaxRows + 1) / 2) + 1);
  localparam int Half = Lanes / 2;
  localparam int Latency = RowBits + 12;  // of sp_compact_column

  logic [Latency:1] valid_q, break_q;
  logic             others_q;  // the half of a group that leaves next is its second
  logic [32*Half-1:0] half;     // of a group
  logic [32*Half-1:0] first_q;  // the half before

  for (genvar c = 0; c < Half; c++) begin : gen_column
    logic [63:0]        word;
    logic [M0Bits-1:0]  m0;
    logic [M1Bits-1:0]  m1;
    logic [RowBits-1:0] n;
    logic [1:0]         runs;
    logic [4:0]         second;
    assign word = words_data_i[64*c+:64];
    if (PixelBits > 8 || MaxRows > sp_spec_pkg::MaxRows) begin : gen_wide
      assign m0     = word[sp_spec_pkg::WideGreyRunM0Lsb+:M0Bits];
      assign m1     = word[sp_spec_pkg::WideGreyRunM1Lsb+:M1Bits];
      assign n      = strongest_i ?
          RowBits'(word[sp_spec_pkg::WideGreyRunNLsb+:sp_spec_pkg::WideGreyRunNBits]) :
          word[sp_spec_pkg::WideGreyNLsb+:RowBits];
      assign second = word[sp_spec_pkg::WideGreyRunSecondLsb+:5];
      assign runs   = {second != '0, second == '0};
    end else begin : gen_eight
      assign m0     = word[sp_spec_pkg::GreyRunM0Lsb+:M0Bits];
      assign m1     = word[sp_spec_pkg::GreyRunM1Lsb+:M1Bits];
      assign n      = word[sp_spec_pkg::GreyRunNLsb+:RowBits];
      assign second = word[sp_spec_pkg::GreyRunSecondLsb+:5];
      assign runs   = word[sp_spec_pkg::GreyRunRunsLsb+:2];
    end
    sp_compact_column #(
      .MaxRows  (MaxRows),
      .PixelBits(PixelBits)
    ) u_column (
      .clk_i      (clk_i),
      .strongest_i(strongest_i),
      .m0_i       (m0),
      .m1_i       (m1),
      .n_i        (n),
      .runs_i     (runs),
      .second_i   (second),
      .word_o     (half[32*c+:32])
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
  always_ff @(posedge clk_i) if (valid_q[Latency]) first_q <= half;

  assign valid_o = compact_i ? valid_q[Latency] && others_q : words_valid_i;
  assign data_o  = compact_i ? {half, first_q} : words_data_i;
  assign break_o = compact_i ? break_q[Latency] : words_break_i;

endmodule

`default_nettype wire
