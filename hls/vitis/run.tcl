# vitis_hls -f hls/vitis/run.tcl KERNEL [PART]: a kernel through Vitis HLS, at the camera's 151.2 MHz: C simulation,
# synthesis, co-simulation, export as an IP. KERNEL is column_moments, column_runs or gray_decoder (whose state of
# 640 x 480 pixels needs a part with 9.4 Mbit of memory). The results are in build/vitis.
#
# It has not been run yet, because the tool is not free. It is written for Vitis HLS 2022.2 and later. The tests compile
# and run the C++ that it names with the open headers of the tool's integers (tests/hls).
set words [lrange $argv [expr {[lsearch -glob $argv *run.tcl] + 1}] end]
if {![llength $words]} { error "usage: vitis_hls -f hls/vitis/run.tcl KERNEL ?PART?" }
set name [lindex $words 0]
set part [expr {[llength $words] > 1 ? [lindex $words 1] : "xc7k325tffg900-2"}]
set root [file normalize [file join [file dirname [info script]] .. ..]]
set flags "-std=c++14 -I$root -I$root/include -DSELFPROJ_HLS_VENDOR_TYPES -Wno-unknown-pragmas"
file mkdir [file join $root build vitis]
cd [file join $root build vitis]

open_project -reset $name
set_top ${name}_top
add_files [file join $root hls $name.cpp] -cflags $flags
add_files -tb [file join $root hls vitis ${name}_tb.cpp] -cflags $flags

open_solution -reset solution -flow_target vivado
set_part $part
create_clock -period 6.6 -name clk
# One reset for all that is kept, as in the RTL.
config_rtl -reset state

csim_design
csynth_design
cosim_design
export_design -format ip_catalog -ipname $name -vendor selfproj -version 1.0
exit
