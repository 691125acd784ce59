# A kernel through Vitis HLS: C simulation, synthesis, co-simulation, export as an IP. column_moments.tcl,
# column_runs.tcl and gray_decoder.tcl call it.
#
# It has not been run yet, because the tool is not free. It is written for Vitis HLS 2022.2 and later. The tests compile
# and run the C++ that it names with the open headers of the tool's integers (tests/hls).

# run_kernel NAME PART PERIOD_NS: the top function NAME_top of hls/NAME.cpp with the bench hls/vitis/NAME_tb.cpp
proc run_kernel {name part period} {
  set root [file normalize [file join [file dirname [info script]] .. ..]]
  set flags "-std=c++14 -I$root -DSELFPROJ_HLS_VENDOR_TYPES -Wno-unknown-pragmas"
  file mkdir [file join $root build vitis]
  cd [file join $root build vitis]

  open_project -reset $name
  set_top ${name}_top
  add_files [file join $root hls $name.cpp] -cflags $flags
  add_files -tb [file join $root hls vitis ${name}_tb.cpp] -cflags $flags

  open_solution -reset solution -flow_target vivado
  set_part $part
  create_clock -period $period -name clk
  # One reset for all that is kept, as in the RTL.
  config_rtl -reset state

  csim_design
  csynth_design
  cosim_design
  export_design -format ip_catalog -ipname $name -vendor selfproj -version 1.0
}
