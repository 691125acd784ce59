# Every sp_packet_fifo: the count of packets crosses in Gray code.
set wr_clock [get_clocks -of_objects [get_ports wr_clk_i]]
set_max_delay -datapath_only -from [get_cells {written_gray_q_reg[*]}] -to [get_cells {u_written_to_rd/meta_q_reg[*]}] \
  [get_property -min PERIOD $wr_clock]
set_bus_skew -from [get_cells {written_gray_q_reg[*]}] -to [get_cells {u_written_to_rd/meta_q_reg[*]}] \
  [get_property -min PERIOD $wr_clock]
