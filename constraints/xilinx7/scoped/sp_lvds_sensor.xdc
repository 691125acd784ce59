# sp_lvds_sensor: states, each bit by itself, a toggle, and a Gray-coded count, of which one bit changes in a clock.
set clock [get_clocks -of_objects [get_ports clk_i]]
set_max_delay -datapath_only \
  -from [get_cells {u_training/failed_o_reg[*] ready_q_reg lost_any_q_reg gray_q_reg[*]}] \
  -to [get_cells {u_states/meta_q_reg[*]}] [get_property -min PERIOD $clock]
