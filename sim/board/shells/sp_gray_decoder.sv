// Stands in for rtl/gray/sp_gray_decoder.sv in a simulated board: the same ports, behind which the
// SystemC shell computes (sim/platform/shell_slot.h). All outputs of the RTL come from registers,
// and so do these: what the shell computes at a clock edge is seen after it. For Verilator only.
`default_nettype none

module sp_gray_decoder #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int MaxRows = sp_spec_pkg::MaxRows,
  parameter int MaxBits = sp_spec_pkg::CodeCodeBits,
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat,
  // derived, do not set
  parameter int ColumnBits = $clog2(MaxColumns + 1),
  parameter int RowBits = $clog2(MaxRows + 1),
  parameter int WordBits = 4 * (sp_spec_pkg::PixelBits + 2 * MaxBits)
) (
  input  wire logic                  clk_i,
  input  wire logic                  rst_i,
  input  wire logic                  take_i,
  input  wire logic                  decode_i,
  input  wire logic [3:0]            bits_i,
  input  wire logic [7:0]            threshold_i,
  input  wire logic [ColumnBits-1:0] columns_i,
  input  wire logic [RowBits-1:0]    rows_i,
  input  wire logic                  beat_valid_i,
  input  wire logic [31:0]           beat_pixels_i,
  input  wire logic                  beat_line_start_i,
  input  wire logic                  beat_line_end_i,
  input  wire logic                  beat_last_row_i,
  input  wire logic                  frame_start_i,
  input  wire logic                  break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] break_status_i,
  input  wire logic [15:0]           pattern_i,
  output logic                       mem_read_o,
  output logic                       mem_read_first_o,
  input  wire logic [WordBits-1:0]   mem_data_i,
  input  wire logic                  mem_late_i,
  output logic                       mem_write_o,
  output logic                       mem_write_first_o,
  output logic      [WordBits-1:0]   mem_data_o,
  output logic                       mem_end_o,
  input  wire logic                  busy_i,
  output logic                       codes_valid_o,
  output logic      [63:0]           codes_o,
  output logic                       codes_start_o,
  output logic                       codes_line_start_o,
  output logic                       codes_line_end_o,
  output logic                       codes_last_row_o,
  output logic                       codes_break_o,
  output logic [sp_spec_pkg::StatusBits-1:0] codes_status_o,
  output logic      [31:0]           abandoned_o
);

  localparam int StatusBits = sp_spec_pkg::StatusBits;

  // One clock. `flags`, from bit 0: reset, take, decode, beat, line start, line end, last row,
  // frame start, break, late, busy, then the status of the break. `settings`, from bit 0: bits,
  // threshold. `size`: columns from bit 0, rows from bit 16. `answer`, from bit 0: of the memory
  // port read, first, write, first, end; of the codes valid, start, line start, line end, last row,
  // break; then the status.
  import "DPI-C" function void selfproj_shell_gray_decoder(
    input int unsigned flags, input int unsigned settings, input int unsigned size,
    input int unsigned pixels, input int unsigned pattern, input bit [127:0] mem,
    output int unsigned answer, output bit [127:0] mem_out, output bit [63:0] codes,
    output int unsigned abandoned
  );

  if (WordBits != 128 || Lanes != 4) begin : gen_error
    $fatal(1, "the shell is built for codes of 12 bits, four in a beat");
  end

  int unsigned answer, abandoned;
  bit [127:0]  mem_out;
  bit [63:0]   codes;

  // verilator lint_off BLKSEQ
  always_ff @(posedge clk_i) begin
    selfproj_shell_gray_decoder(
      32'({break_status_i, busy_i, mem_late_i, break_i, frame_start_i, beat_last_row_i,
           beat_line_end_i, beat_line_start_i, beat_valid_i, decode_i, take_i, rst_i}),
      32'({threshold_i, bits_i}), {16'(rows_i), 16'(columns_i)}, beat_pixels_i, 32'(pattern_i),
      mem_data_i, answer, mem_out, codes, abandoned);
    {codes_break_o, codes_last_row_o, codes_line_end_o, codes_line_start_o, codes_start_o,
     codes_valid_o, mem_end_o, mem_write_first_o, mem_write_o, mem_read_first_o,
     mem_read_o} <= answer[10:0];
    codes_status_o <= answer[11+:StatusBits];
    mem_data_o     <= mem_out;
    codes_o        <= codes;
    abandoned_o    <= abandoned;
  end
  // verilator lint_on BLKSEQ

  logic unused;
  assign unused = ^answer[31:11+StatusBits];

endmodule

`default_nettype wire
