# sp_axil_bridge: two toggles cross through synchronizers. The words of request and answer stand still while their
# toggle crosses, so they may take a period of the receiving clock.
set clock [get_clocks -of_objects [get_ports clk_i]]
set bus_clock [get_clocks -of_objects [get_ports bus_clk_i]]
set_max_delay -datapath_only -from [get_cells {toggle_q_reg}] -to [get_cells {u_there/meta_q_reg[*]}] \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {ask_write_q_reg ask_address_q_reg[*] ask_data_q_reg[*]}] -to $clock \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {back_q_reg}] -to [get_cells {u_back/meta_q_reg[*]}] \
  [get_property -min PERIOD $bus_clock]
set_max_delay -datapath_only -from [get_cells {back_error_q_reg back_data_q_reg[*]}] -to $bus_clock \
  [get_property -min PERIOD $bus_clock]
