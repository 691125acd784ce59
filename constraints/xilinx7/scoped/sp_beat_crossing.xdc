# Every sp_beat_crossing of a camera's front end: levels and toggles, each by itself, and a reset. (Its FIFO has
# constraints of its own.)
set clock [get_clocks -of_objects [get_ports clk_i]]
set camera_clock [get_clocks -of_objects [get_ports camera_clk_i]]
set_max_delay -datapath_only -from [get_cells {ask_q_reg}] -to [get_cells {u_asked/meta_q_reg[*]}] \
  [get_property -min PERIOD $camera_clock]
set_max_delay -datapath_only -from [get_cells {restart_q_reg}] -to [get_cells {resting_q_reg[*] rested_q_reg}] \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {rested_q_reg}] -to [get_cells {u_rested/meta_q_reg[*]}] \
  [get_property -min PERIOD $clock]
set_max_delay -datapath_only -from [get_cells {overrun_q_reg cut_q_reg}] -to [get_cells {u_changes/meta_q_reg[*]}] \
  [get_property -min PERIOD $clock]
