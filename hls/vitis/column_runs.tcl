# vitis_hls -f hls/vitis/column_runs.tcl [PART]: the strongest runs at the camera's 151.2 MHz. The results are in
# build/vitis/. It has not been run yet.
source [file join [file dirname [info script]] run.tcl]
run_kernel column_runs [expr {[llength $argv] > 2 ? [lindex $argv 2] : "xc7k325tffg900-2"}] 6.6
exit
