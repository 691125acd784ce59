# vivado -mode batch -source constraints/xilinx7/xilinx7.tcl -tclargs PART [NAME=VALUE...]
# From the sources to reports of timing and utilization of sp_board in build/vivado/. It has not been run yet, because
# the vendor's tools were not at hand. PART is for example xc7a200tfbg676-2 or xc7k325tffg900-2; NAME=VALUE are
# parameters of sp_board. Synthesis is out of context, because the board's buses go on to other blocks of the FPGA.
if {$argc < 1} { error "usage: vivado -mode batch -source constraints/xilinx7/xilinx7.tcl -tclargs PART ?NAME=VALUE ...?" }
set here [file dirname [file normalize [info script]]]
set root [file dirname [file dirname $here]]
set out [file join $root build vivado]
file mkdir $out
read_verilog -sv [file join $root rtl common sp_spec_pkg.sv]
foreach source [glob [file join $root rtl * sp_*.sv]] {
  if {![string match *_pkg.sv $source]} { read_verilog -sv $source }
}
read_xdc [file join $here xilinx7.xdc]
source [file join $here scoped.tcl]
set generics {}
foreach assignment [lrange $argv 1 end] { lappend generics -generic $assignment }
synth_design -top sp_board -part [lindex $argv 0] -mode out_of_context {*}$generics
opt_design
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file [file join $out utilization.txt]
report_timing_summary -file [file join $out timing.txt]
report_cdc -details -file [file join $out crossings.txt]
write_checkpoint -force [file join $out sp_board.dcp]
