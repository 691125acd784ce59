# sp_replay: two toggles cross through synchronizers. The size of a frame and its words stand still while they do, and
# until the frame has left, so they may take a period of the receiving clock. (Words have a path only where the memory is
# made of LUTs.)
set clock [get_clocks -of_objects [get_ports clk_i]]
set bus_clock [get_clocks -of_objects [get_ports bus_clk_i]]
set_max_delay -datapath_only -from [get_cells {asked_q_reg}] -to [get_cells {u_asked/meta_q_reg[*]}] \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {u_receiver/beats_o_reg[*] u_receiver/rows_o_reg[*]}] -to $clock \
  [get_property -min PERIOD $clock]
set_max_delay -quiet -datapath_only -from $bus_clock -to [get_cells -quiet {u_memory/rd_data_o_reg[*]}] \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {back_q_reg}] -to [get_cells {u_back/meta_q_reg[*]}] \
  [get_property -min PERIOD $bus_clock]
