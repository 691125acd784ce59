#include "host/app/depth_options.h"

#include <CLI/CLI.hpp>
#include <string>

#include "host/cli/command_line.h"

namespace selfproj {

void add_geometry_options(CLI::App& command, DepthGeometry& geometry) {
  command.add_option("--rig", geometry.rig, "Built-in rig or YAML file. This or --calibration is needed.")
      ->type_name("RIG");
  command
      .add_option("--calibration", geometry.calibration,
                  "Calibration as OpenCV YAML with cam_K, cam_kc, pro_K, pro_kc, R and T.")
      ->type_name("FILE.yaml");
}

void add_threshold_option(CLI::App& command, int& threshold, const std::string& by_default) {
  command
      .add_option("--threshold", threshold,
                  "A pair of images that differs by at most this many grey levels is ambiguous.")
      ->transform(whole_number(0, 255))
      ->type_name("T")
      ->default_str(by_default);
}

void add_strict_option(CLI::App& command, ScannerSettings& scanner) {
  command.add_flag(
      "--strict", scanner.strict,
      "Leave out pixels with one ambiguous pair. Without it, two or more ambiguous pairs leave a pixel out.");
}

void add_limit_options(CLI::App& command, DepthGeometry& geometry) {
  begin_group(command, "Limits");
  command.add_option("--min-z", geometry.limits.min_z_mm, "Smallest depth in mm.")
      ->transform(real_number(-1e6, 1e6))
      ->type_name("MM")
      ->capture_default_str();
  command.add_option("--max-z", geometry.limits.max_z_mm, "Largest depth in mm.")
      ->transform(real_number(-1e6, 1e6))
      ->type_name("MM")
      ->default_str("none");
  command
      .add_option("--max-z-per-line", geometry.limits.max_z_per_line_mm,
                  "Leave out pixels where one projector line is worth more than this many mm of z.")
      ->transform(number_above_zero())
      ->type_name("MM")
      ->default_str("the rig's; none for a calibration");
  command
      .add_option("--max-residual", geometry.max_residual_px,
                  "Where both axes are coded, leave out pixels whose ray passes the point of their codes at more than "
                  "this many projector pixels.")
      ->transform(number_above_zero())
      ->type_name("PX")
      ->capture_default_str();
}

}  // namespace selfproj
