// Stands in for rtl/gray/sp_median3x3.sv in a simulated board: the same ports, behind which the
// SystemC shell computes (sim/platform/shell_slot.h). All outputs of the RTL come from registers,
// and so do these: what the shell computes at a clock edge is seen after it. For Verilator only.
`default_nettype none

module sp_median3x3 #(
  parameter int MaxColumns = sp_spec_pkg::MaxColumns,
  parameter int Lanes = sp_spec_pkg::PixelsPerBeat
) (
  input  wire logic        clk_i,
  input  wire logic        rst_i,
  input  wire logic        s_valid_i,
  input  wire logic [63:0] s_codes_i,
  input  wire logic        s_start_i,
  input  wire logic        s_line_start_i,
  input  wire logic        s_line_end_i,
  input  wire logic        s_last_row_i,
  input  wire logic        s_break_i,
  input  wire logic [sp_spec_pkg::StatusBits-1:0] s_status_i,
  input  wire logic        s_median_i,
  output logic             busy_o,
  output logic             m_valid_o,
  output logic      [63:0] m_codes_o,
  output logic             m_start_o,
  output logic             m_line_start_o,
  output logic             m_line_end_o,
  output logic             m_break_o,
  output logic [sp_spec_pkg::StatusBits-1:0] m_status_o
);

  localparam int StatusBits = sp_spec_pkg::StatusBits;

  // One clock. `flags`, from bit 0: reset, valid, start, line start, line end, last row, break,
  // median, then the status of the break. `answer`, from bit 0: busy, valid, start, line start,
  // line end, break, then the status.
  import "DPI-C" function void selfproj_shell_median3x3(
    input int unsigned flags, input bit [63:0] codes, output int unsigned answer,
    output bit [63:0] codes_out
  );

  if (MaxColumns > sp_spec_pkg::MaxColumns || Lanes != 4) begin : gen_error
    $fatal(1, "the shell has line buffers for the default maxima, four codes in a beat");
  end

  int unsigned answer;
  bit [63:0]   codes_out;

  // verilator lint_off BLKSEQ
  always_ff @(posedge clk_i) begin
    selfproj_shell_median3x3(
      32'({s_status_i, s_median_i, s_break_i, s_last_row_i, s_line_end_i, s_line_start_i,
           s_start_i, s_valid_i, rst_i}), s_codes_i,
      answer, codes_out);
    {m_break_o, m_line_end_o, m_line_start_o, m_start_o, m_valid_o, busy_o} <= answer[5:0];
    m_status_o <= answer[6+:StatusBits];
    m_codes_o  <= codes_out;
  end
  // verilator lint_on BLKSEQ

  logic unused;
  assign unused = ^answer[31:6+StatusBits];

endmodule

`default_nettype wire
