# nextpnr-ice40 runs this file (--pre-pack): the two clocks. The tool itself ignores the paths between them; README.md
# says what makes them safe.
ctx.addClock("clk_i", 151.2)
ctx.addClock("bus_clk_i", 62.5)
