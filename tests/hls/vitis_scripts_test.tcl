# tclsh vitis_scripts_test.tcl FOLDER: runs the scripts of hls/vitis with commands that only have the names of the
# tool's. It checks that they are Tcl, ask for all steps in their order, and name files that exist.
set folder [lindex $argv 0]
set ::asked {}
foreach command {open_project set_top add_files open_solution set_part create_clock config_rtl
                 csim_design csynth_design cosim_design export_design} {
  proc $command {args} "lappend ::asked \[list $command \$args\]"
}
rename exit tcl_exit
proc exit {args} {}

foreach name {column_moments column_runs gray_decoder} {
  set ::asked {}
  set argv {}
  source [file join $folder $name.tcl]
  set steps {}
  foreach entry $::asked {
    lappend steps [lindex $entry 0]
    if {[lindex $entry 0] eq "add_files"} {
      foreach word [lindex $entry 1] {
        if {[string match *.cpp $word] && ![file exists $word]} {
          puts stderr "$name.tcl: $word does not exist"
          tcl_exit 1
        }
      }
    }
  }
  set want {open_project set_top add_files add_files open_solution set_part create_clock config_rtl
            csim_design csynth_design cosim_design export_design}
  if {$steps ne [concat {*}$want]} {
    puts stderr "$name.tcl: asks for $steps"
    tcl_exit 1
  }
}
puts "three scripts ask for [llength $steps] steps"
tcl_exit 0
