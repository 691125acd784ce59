// What `selfproj depth` and `selfproj scan` share: geometry, decoding, limits.
#ifndef SELFPROJ_HOST_APP_DEPTH_OPTIONS_H
#define SELFPROJ_HOST_APP_DEPTH_OPTIONS_H

#include <CLI/CLI.hpp>
#include <string>

#include "host/structured_light/depth_geometry.h"
#include "host/structured_light/scanner.h"

namespace selfproj {

// Add --rig and --calibration; --threshold, whose default the help calls `by_default`; --strict, to the group that is
// open.
void add_geometry_options(CLI::App& command, DepthGeometry& geometry);
void add_threshold_option(CLI::App& command, int& threshold, const std::string& by_default);
void add_strict_option(CLI::App& command, ScannerSettings& scanner);

// Adds the group of --min-z, --max-z, --max-z-per-line and --max-residual.
void add_limit_options(CLI::App& command, DepthGeometry& geometry);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_DEPTH_OPTIONS_H
