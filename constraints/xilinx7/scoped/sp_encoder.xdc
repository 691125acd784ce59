# sp_encoder: its two lines belong to no clock.
set_false_path -to [get_cells {u_sync/meta_q_reg[*]}]
