# vitis_hls -f hls/vitis/gray_decoder.tcl [PART]: the Gray-code decoder at the camera's 151.2 MHz. The state of
# 640 x 480 pixels needs a part with 9.4 Mbit of memory. The results are in build/vitis/. It has not been run yet.
source [file join [file dirname [info script]] run.tcl]
run_kernel gray_decoder [expr {[llength $argv] > 2 ? [lindex $argv 2] : "xc7k325tffg900-2"}] 6.6
exit
