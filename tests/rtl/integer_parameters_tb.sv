// One-bit parameters of sp_board may be given as integers. A board built with 0 and 1 must have the
// same capability register as a board built with 1'b0 and 1'b1.
`default_nettype none

module integer_parameters_tb;

  sp_board #(
    .MaxColumns (16),
    .MaxRows    (4),
    .Grey       (1),
    .Runs       (1),
    .Image      (0),
    .Compact    (1),
    .Codes      (1),
    .CodesMedian(1)
  ) u_integers ();

  sp_board #(
    .MaxColumns (16),
    .MaxRows    (4),
    .Grey       (1'b1),
    .Runs       (1'b1),
    .Image      (1'b0),
    .Compact    (1'b1),
    .Codes      (1'b1),
    .CodesMedian(1'b1)
  ) u_bits ();

  sp_board #(
    .MaxColumns (16),
    .MaxRows    (4),
    .Grey       (0),
    .Runs       (0),
    .Image      (1),
    .Compact    (0),
    .Codes      (1),
    .CodesMedian(0)
  ) u_others ();

  localparam logic [31:0] Size = 32'd16 << sp_spec_pkg::RegCapabilityMaxColumnsLsb |
                                 32'd4 << sp_spec_pkg::RegCapabilityMaxRowsLsb |
                                 32'd12 << sp_spec_pkg::RegCapabilityCodeBitsLsb |
                                 32'd1 << sp_spec_pkg::RegCapabilityCodesLsb;

  task automatic check(input logic [31:0] is, input logic [31:0] must_be);
    if (is !== must_be) $fatal(1, "the capability is %h, not %h", is, must_be);
  endtask

  initial begin
    check(u_bits.u_registers.Capability, Size | 32'd1 << sp_spec_pkg::RegCapabilityGreyLsb |
                                         32'd1 << sp_spec_pkg::RegCapabilityRunsLsb |
                                         32'd1 << sp_spec_pkg::RegCapabilityMedianLsb);
    check(u_integers.u_registers.Capability, u_bits.u_registers.Capability);
    check(u_others.u_registers.Capability, Size | 32'd1 << sp_spec_pkg::RegCapabilityImageLsb);
    $display("integers count as bits");
    $finish;
  end

endmodule

`default_nettype wire
