// The commands of selfproj. Each adds a command with its options and help to the program, or to the command above it.
#ifndef SELFPROJ_HOST_APP_COMMANDS_H
#define SELFPROJ_HOST_APP_COMMANDS_H

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj::app {

// What is built and projected: rigs, patterns, calibrations.
void add_rig_command(CLI::App& app);
void add_rows_command(CLI::App& app);
void add_pattern_command(CLI::App& app);
CLI::App* add_chessboard_command(CLI::App& pattern);  // these two below `pattern`
CLI::App* add_stripes_command(CLI::App& pattern);
void add_calibrate_command(CLI::App& app);
CLI::App* add_belt_command(CLI::App& calibrate);  // these three below `calibrate`
CLI::App* add_camera_command(CLI::App& calibrate);
CLI::App* add_heights_command(CLI::App& calibrate);
void add_accuracy_command(CLI::App& app);

// Cameras and projectors in step.
void add_project_command(CLI::App& app);
void add_capture_command(CLI::App& app);
void add_scan_command(CLI::App& app);
void add_measure_command(CLI::App& app);

// Boards and their packets.
void add_board_command(CLI::App& app);
void add_devices_command(CLI::App& app);
void add_record_command(CLI::App& app);
void add_images_command(CLI::App& app);

// Measuring and inspection.
void add_depth_command(CLI::App& app);
void add_match_command(CLI::App& app);
void add_inspect_command(CLI::App& app);
void add_tolerance_command(CLI::App& app);
void add_verdict_command(CLI::App& app);
void add_lines_command(CLI::App& app);
void add_compare_command(CLI::App& app);

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_COMMANDS_H
