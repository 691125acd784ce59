// Starts deserializer cells of an ECP5 together: their reset ends while the edge clock stands still, as
// in the GDDR_SYNC of Lattice's technical note FPGA-TN-02035. Otherwise cells in different places of
// the chip may begin a period of the edge clock apart.
//
//   good_i   ____/1111111111111111111111111
//   rst_o    111111111111111111\___________    16 or 17 clocks
//   stop_o   1111111111111111111111111\____    24 or 25 clocks
`default_nettype none

module ecp5_gearing_start (
  input  wire logic clk_i,   // any clock that runs
  input  wire logic good_i,  // the edge clock is good; its fall resets the cells at once
  output logic      stop_o,  // to ECLKSYNCB
  output logic      rst_o    // active high, to CLKDIVF and the cells; falls while the edge clock stands
);

  logic [4:0] count_q;

  always_ff @(posedge clk_i or negedge good_i) begin
    if (!good_i) begin
      count_q <= '0;
      stop_o  <= 1'b1;
      rst_o   <= 1'b1;
    end else begin
      if (count_q != '1) count_q <= count_q + 1'b1;
      stop_o <= count_q < 5'd24;
      rst_o  <= count_q < 5'd16;
    end
  end

endmodule

`default_nettype wire
