# tclsh vitis_scripts_test.tcl FOLDER: runs the script of hls/vitis with commands that only have the names of the
# tool's, for each kernel. It checks that it is Tcl, asks for all steps in their order, and names files that exist.
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
  set argv [list -f hls/vitis/run.tcl $name]
  source [file join $folder run.tcl]
  set steps {}
  foreach entry $::asked {
    lappend steps [lindex $entry 0]
    if {[lindex $entry 0] eq "add_files"} {
      foreach word [lindex $entry 1] {
        if {[string match *.cpp $word] && ![file exists $word]} {
          puts stderr "run.tcl $name: $word does not exist"
          tcl_exit 1
        }
      }
    }
  }
  set want {open_project set_top add_files add_files open_solution set_part create_clock config_rtl
            csim_design csynth_design cosim_design export_design}
  if {$steps ne [concat {*}$want]} {
    puts stderr "run.tcl $name: asks for $steps"
    tcl_exit 1
  }
}
puts "the script asks for [llength $steps] steps"
tcl_exit 0
