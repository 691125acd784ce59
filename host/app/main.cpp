// selfproj: the program for the production PC.

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/cli/completion.h"
#include "host/cli/program_main.h"

int main(int argc, char** argv) {
  return selfproj::cli::program_main(
      {.name = "selfproj",
       .purpose = "Measures 3-D shapes on the production PC: patterns, calibration, light section, structured light.",
       .details = "The exit status is 0 for success, 1 for a failed check and 2 for bad usage or input. An error is "
                  "one line on "
                  "standard error that names the file or option and the reason.\n\n"
                  "Output files and folders are written whole or not at all. Missing parent folders are made.\n\n"
                  "Numbered files are taken by number, img2 before img10: all files of a folder, and lists in "
                  "alphabetical order, as a shell expands img*.png. Lists in any other order are taken as given.",
       .examples = R"(
# List the built-in rigs, and print one of them.
selfproj rig
selfproj rig light-section
)"},
      [](CLI::App& app) {
        selfproj::app::add_rig_command(app);
        selfproj::app::add_rows_command(app);
        selfproj::app::add_pattern_command(app);
        selfproj::app::add_calibrate_command(app);
        selfproj::app::add_accuracy_command(app);
        selfproj::cli::set_heading(app, "Set up: rigs, patterns, calibration",
                                   {"rig", "rows", "pattern", "calibrate", "accuracy"});
        selfproj::app::add_project_command(app);
        selfproj::app::add_capture_command(app);
        selfproj::app::add_scan_command(app);
        selfproj::app::add_measure_command(app);
        selfproj::cli::set_heading(app, "Capture with camera and projector", {"project", "capture", "scan", "measure"});
        selfproj::app::add_inspect_command(app);
        selfproj::app::add_tolerance_command(app);
        selfproj::app::add_verdict_command(app);
        selfproj::app::add_lines_command(app);
        selfproj::cli::set_heading(app, "Light section and parts on a line",
                                   {"inspect", "tolerance", "verdict", "lines"});
        selfproj::app::add_depth_command(app);
        selfproj::app::add_match_command(app);
        selfproj::app::add_compare_command(app);
        selfproj::cli::set_heading(app, "Structured light, maps and clouds", {"depth", "match", "compare"});
        selfproj::app::add_board_command(app);
        selfproj::app::add_devices_command(app);
        selfproj::app::add_record_command(app);
        selfproj::app::add_images_command(app);
        selfproj::cli::set_heading(app, "Boards and their packets", {"board", "devices", "record", "images"});
        selfproj::cli::add_completion_command(app);
      },
      argc, argv);
}
