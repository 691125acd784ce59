# Every sp_async_fifo: the bits of a Gray-coded pointer may arrive at most one period of the sending clock apart. A word
# of the memory has stood for more than two periods when it is read (a path only where the memory is made of LUTs).
set wr_clock [get_clocks -of_objects [get_ports wr_clk_i]]
set rd_clock [get_clocks -of_objects [get_ports rd_clk_i]]
set_max_delay -datapath_only -from [get_cells {wr_gray_q_reg[*]}] -to [get_cells {u_wr_to_rd/meta_q_reg[*]}] \
  [get_property -min PERIOD $wr_clock]
set_bus_skew -from [get_cells {wr_gray_q_reg[*]}] -to [get_cells {u_wr_to_rd/meta_q_reg[*]}] \
  [get_property -min PERIOD $wr_clock]
set_max_delay -datapath_only -from [get_cells {rd_gray_q_reg[*]}] -to [get_cells {u_rd_to_wr/meta_q_reg[*]}] \
  [get_property -min PERIOD $rd_clock]
set_bus_skew -from [get_cells {rd_gray_q_reg[*]}] -to [get_cells {u_rd_to_wr/meta_q_reg[*]}] \
  [get_property -min PERIOD $rd_clock]
set_max_delay -quiet -datapath_only -from $wr_clock -to [get_cells -quiet {u_ram/rd_data_o_reg[*]}] \
  [get_property -min PERIOD $rd_clock]
