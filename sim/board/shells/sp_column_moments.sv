// Stands in for rtl/moments/sp_column_moments.sv in a simulated board: the same ports, behind which
// the SystemC shell computes (sim/platform/shell_slot.h). All outputs of the RTL come from
// registers, and so do these: what the shell computes at a clock edge is seen after it. This file
// is for Verilator only.
`default_nettype none

module sp_column_moments #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter int PixelBits = sp_spec_pkg::PixelBits,
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,
  parameter bit Grey = 1'b1,
  // derived, do not set
  parameter int GroupBits = $clog2(MaxColumns / 4),
  parameter int RowBits = $clog2(MaxRows + 1)
) (
  input  wire logic                 clk_i,
  input  wire logic                 rst_i,

  input  wire logic                 beat_valid_i,
  input  wire logic [31:0]          beat_pixels_i,
  input  wire logic [GroupBits-1:0] beat_group_i,
  input  wire logic [RowBits-1:0]   beat_row_i,
  input  wire logic                 beat_first_row_i,
  input  wire logic                 beat_last_row_i,
  input  wire logic                 beat_line_end_i,
  input  wire logic                 one_group_i,
  input  wire logic                 two_groups_i,
  input  wire logic [1:0]           mode_i,
  input  wire logic [7:0]           threshold_i,
  input  wire logic                 break_i,
  input  wire logic                 accept_i,

  output logic                      moments_valid_o,
  output logic [127:0]              moments_data_o,
  output logic                      moments_break_o,
  output logic                      spoiled_o
);

  // One clock. `flags`, from bit 0: reset, beat, first row, last row, line end, one group, two
  // groups, break, accept. `answer`, from bit 0: valid, break, spoiled.
  import "DPI-C" function void selfproj_shell_column_moments(
    input int unsigned flags, input int unsigned pixels, input int unsigned group,
    input int unsigned row, input int unsigned mode, input int unsigned threshold,
    output int unsigned answer, output bit [127:0] data
  );

  if (PixelBits != 8 || Lanes != 4 || !Grey || GroupBits != 9 || RowBits != 10) begin : gen_error
    $fatal(1, "the shell is built for the default maxima and pixels, with the grey modes");
  end

  int unsigned answer;
  bit [127:0]  data;

  // verilator lint_off BLKSEQ
  always_ff @(posedge clk_i) begin
    selfproj_shell_column_moments(
      {23'd0, accept_i, break_i, two_groups_i, one_group_i, beat_line_end_i, beat_last_row_i,
       beat_first_row_i, beat_valid_i, rst_i},
      beat_pixels_i, 32'(beat_group_i), 32'(beat_row_i), 32'(mode_i), 32'(threshold_i), answer,
      data);
    {spoiled_o, moments_break_o, moments_valid_o} <= answer[2:0];
    moments_data_o <= data;
  end
  // verilator lint_on BLKSEQ

  logic unused;
  assign unused = ^answer[31:3];

endmodule

`default_nettype wire
