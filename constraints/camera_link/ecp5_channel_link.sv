// Deserializer of a Channel Link by cells of the ECP5: five LVDS lanes into seven samples a clock.
//
//   lane ─▶ DELAYG ─▶ IDDR71B ─▶ seven samples, in sclk_o
//   eclk_i ─▶ ECLKSYNCB ─▶ CLKDIVF, by 3.5 ─▶ sclk_o
//
// eclk_i comes from a PLL that multiplies the camera's clock by 3.5, for one sample of each bit, or
// by 7, for two. Each of its edges takes a sample. The PLL's phase and the delays are fixed by
// parameters: for one sample a bit in the middle of the clock lane's bits; for two, a quarter of a
// bit before and behind it. Each rise of align_i lengthens one period of sclk_o by a period of
// eclk_i, so that the words of all lanes move by two samples.
//
// Lane 4 is the clock. Its pair of pins cannot also feed the PLL (nextpnr refuses it), so a board
// needs the clock on two pairs of pins.
`default_nettype none

module ecp5_channel_link #(
  parameter logic [34:0] Delays = '0  // lane n in 7n+6..7n: DEL_VALUE, in steps of about 25 ps
) (
  input  wire logic [4:0]  lanes_i,
  input  wire logic        eclk_i,
  input  wire logic        stop_i,   // both from ecp5_gearing_start
  input  wire logic        rst_i,    // active high, asynchronous: while the PLL is not locked
  input  wire logic        align_i,
  output logic             sclk_o,
  output logic      [34:0] samples_o  // lane n in 7n+6..7n, the first sample in 7n
);

  logic eclk;

  ECLKSYNCB u_sync (
    .ECLKI(eclk_i),
    .STOP (stop_i),
    .ECLKO(eclk)
  );

  CLKDIVF #(
    .DIV("3.5")
  ) u_divider (
    .CLKI   (eclk),
    .RST    (rst_i),
    .ALIGNWD(align_i),
    .CDIVX  (sclk_o)
  );

  for (genvar n = 0; n < 5; n++) begin : gen_lane
    logic delayed;

    DELAYG #(
      .DEL_MODE ("USER_DEFINED"),
      .DEL_VALUE(Delays[7*n+:7])
    ) u_delay (
      .A(lanes_i[n]),
      .Z(delayed)
    );

    IDDR71B u_samples (
      .D      (delayed),
      .ECLK   (eclk),
      .SCLK   (sclk_o),
      .RST    (rst_i),
      .ALIGNWD(align_i),
      .Q0     (samples_o[7*n]),
      .Q1     (samples_o[7*n+1]),
      .Q2     (samples_o[7*n+2]),
      .Q3     (samples_o[7*n+3]),
      .Q4     (samples_o[7*n+4]),
      .Q5     (samples_o[7*n+5]),
      .Q6     (samples_o[7*n+6])
    );
  end

endmodule

`default_nettype wire
