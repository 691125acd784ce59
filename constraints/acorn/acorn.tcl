# vivado -mode batch -source constraints/acorn/acorn.tcl -tclargs PART [NAME=VALUE...]
# From the sources to a bitstream, an image of the flash, and reports, in build/acorn/vivado. It has not been run yet,
# because the vendor's tools were not at hand. PART is xc7a200tfbg484-3 for an Acorn CLE-215+, xc7a200tfbg484-2 for a
# CLE-215 or NiteFury, xc7a100tfgg484-2 for a CLE-101 or LiteFury; NAME=VALUE are parameters of the module acorn.
# constraints/acorn/litepcie_core.py makes the core and the commands for the vendor's block before.
if {$argc < 1} { error "usage: vivado -mode batch -source constraints/acorn/acorn.tcl -tclargs PART ?NAME=VALUE ...?" }
set here [file dirname [file normalize [info script]]]
set root [file dirname [file dirname $here]]
set made [file join $root build acorn]
set out [file join $made vivado]
if {![file exists [file join $made pcie_s7.tcl]]} { error "run constraints/acorn/litepcie_core.py first" }
file mkdir $out
create_project -force -part [lindex $argv 0] acorn $out
source [file join $made pcie_s7.tcl]
read_verilog -sv [file join $root rtl common sp_spec_pkg.sv]
foreach source [glob [file join $root rtl * sp_*.sv]] {
  if {![string match *_pkg.sv $source]} { read_verilog -sv $source }
}
read_verilog -sv [glob [file join $here *.sv]]
read_verilog [file join $made litepcie_core.v]
read_xdc [file join $here acorn.xdc]
set generics {}
foreach assignment [lrange $argv 1 end] { lappend generics -generic $assignment }
synth_design -top acorn -part [lindex $argv 0] {*}$generics
opt_design
# As LitePCIe's own flow does: of the block's constraints only those of timing stay. The pins place its transceivers.
reset_property LOC [get_cells -hierarchical -filter {NAME=~*pcie_s7/*gtp_common.gtpe2_common_i}]
reset_property LOC [get_cells -hierarchical -filter {NAME=~*pcie_s7/*genblk*.bram36_tdp_bl.bram36_tdp_bl}]
place_design
phys_opt_design
route_design
report_utilization -hierarchical -file [file join $out utilization.txt]
report_timing_summary -file [file join $out timing.txt]
report_cdc -details -file [file join $out crossings.txt]
write_checkpoint -force [file join $out acorn.dcp]
write_bitstream -force [file join $out acorn.bit]
write_cfgmem -force -format bin -interface spix4 -size 16 -loadbit "up 0x0 [file join $out acorn.bit]" \
  -file [file join $out acorn.bin]
