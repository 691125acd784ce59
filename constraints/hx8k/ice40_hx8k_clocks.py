# Defines the two clocks. nextpnr-ice40 runs this file with --pre-pack. It ignores the paths between the clocks;
# README.md says why these paths are safe.
ctx.addClock("clk_i", 151.2)
ctx.addClock("bus_clk_i", 62.5)
