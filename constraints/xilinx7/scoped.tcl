# source constraints/xilinx7/scoped.tcl, in a project or in a script of Vivado, before synthesis
# Adds the constraints of every crossing between clocks in rtl/, one file in scoped/ for each module that has crossings.
# They are scoped to the module (SCOPED_TO_REF), so they hold wherever an instance stands in a design, under any name,
# with any clocks. They take the periods from the clocks that reach the module, so they are processed after all others.
# It has not been run yet, because the vendor's tools were not at hand.
foreach file [lsort [glob [file join [file dirname [file normalize [info script]]] scoped sp_*.xdc]]] {
  add_files -norecurse $file
  set_property SCOPED_TO_REF [file rootname [file tail $file]] [get_files $file]
  set_property PROCESSING_ORDER LATE [get_files $file]
  set_property USED_IN_SYNTHESIS false [get_files $file]
}
