# sp_board on Artix-7 and Kintex-7 (Vivado): the clocks. xilinx7.tcl reads this file, and scoped.tcl for
# the paths between them. It has not been run yet, because the vendor's tools were not at hand.
create_clock -name video -period 6.613 [get_ports clk_i]
create_clock -name bus   -period 16.000 [get_ports bus_clk_i]

# Pins: a template. Put those of your board.
#set_property -dict {PACKAGE_PIN ... IOSTANDARD LVCMOS33} [get_ports clk_i]
