# sp_board on Artix-7 and Kintex-7 (Vivado): clocks and the paths between them. Not run here: the vendor's tools are not at
# hand. xilinx7.tcl reads it.
create_clock -name video -period 6.613 [get_ports clk_i]
create_clock -name bus   -period 16.000 [get_ports bus_clk_i]

# Between the clocks: Gray-coded pointers and toggles may spread over no more than a period of the clock that takes them;
# words that cross stand still for more than two (rtl/crossings.txt).
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
