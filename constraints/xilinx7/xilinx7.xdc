# sp_board on Artix-7 and Kintex-7 (Vivado): the clocks and the paths between them. xilinx7.tcl reads this file. It has
# not been run yet, because the vendor's tools were not at hand.
create_clock -name video -period 6.613 [get_ports clk_i]
create_clock -name bus   -period 16.000 [get_ports bus_clk_i]

# Between the clocks: the bits of a Gray-coded pointer or a toggle may arrive at most one period of the sending clock
# apart; words that cross are stable for more than two periods (rtl/crossings.txt).
set_max_delay -datapath_only -from [get_clocks video] -to [get_clocks bus] 6.613
set_max_delay -datapath_only -from [get_clocks bus] -to [get_clocks video] 6.613
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *wr_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_wr_to_rd/meta_q_reg*}] 6.613
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *rd_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_rd_to_wr/meta_q_reg*}] 6.613
set_bus_skew -from [get_cells -hierarchical -filter {NAME =~ *written_gray_q_reg*}] \
             -to [get_cells -hierarchical -filter {NAME =~ *u_written_to_rd/meta_q_reg*}] 6.613

# Inputs that belong to no clock; each goes to a synchronizer.
set_false_path -from [get_ports {encoder_a_i encoder_b_i}]

# Pins: a template. Put those of your board.
#set_property -dict {PACKAGE_PIN ... IOSTANDARD LVCMOS33} [get_ports clk_i]
