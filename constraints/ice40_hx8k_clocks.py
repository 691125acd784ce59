# Run by nextpnr-ice40 (--pre-pack): the two clocks. Paths between them are cut by the tool itself; see README.md for what
# makes them safe.
ctx.addClock("clk_i", 151.2)
ctx.addClock("bus_clk_i", 62.5)
