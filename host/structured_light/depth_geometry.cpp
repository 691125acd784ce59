#include "selfproj/structured_light/depth_geometry.h"

#include <fmt/format.h>

#include <bit>
#include <cmath>
#include <memory>
#include <stdexcept>
#include <string>
#include <tuple>

#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/calibration_file.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/lens_triangulation.h"

namespace selfproj::structured_light {
namespace {

// For images of the rig's camera, with its limit of z for a line.
LensSettings settings_of(const rig::Rig& rig, const DepthLimits& limits) {
  LensSettings settings{.rows = rig.camera.rows, .columns = rig.camera.columns, .limits = limits, .rows_are_x = true};
  settings.limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
  return settings;
}

std::unique_ptr<LensTriangulation> with_lens(const std::string& name, const rig::Calibration& calibration,
                                             const LensSettings& settings) {
  try {
    return std::make_unique<LensTriangulation>(calibration, settings);
  } catch (const std::invalid_argument& error) {
    throw UserError(name, error.what());
  }
}

rig::Rig rig_for(const DepthGeometry& geometry, const ImageSource& source) {
  rig::Rig rig = rig::load_rig(geometry.rig);
  check_size("--rig " + geometry.rig, rig.camera.rows, rig.camera.columns, source);
  if (std::isfinite(geometry.limits.max_z_per_line_mm)) {
    rig.measure.max_z_per_line_mm = geometry.limits.max_z_per_line_mm;
  }
  return rig;
}

// Throws UserError about lines that the projector does not have and that are not those of the shortest code in which
// each of them has a code of its own.
void check_projector(const char* option, double lines, int there, const std::string& rig) {
  const double all = std::bit_ceil(static_cast<unsigned>(there));
  if (lines > there && lines != all) {
    throw UserError(option, fmt::format("is {}, but the projector of {} has {}; up to {} are possible, or {} for the "
                                        "first pairs of a code in which each line has a code of its own",
                                        lines, rig, there, there, all));
  }
}

// The first code is that of the projector's lines, the second that of its columns: those of the images exchanged.
std::unique_ptr<LensTriangulation> rig_triangulation_of_both(const DepthGeometry& geometry, const ImageSource& source) {
  const rig::Rig rig = rig_for(geometry, source);
  check_projector("--lines", geometry.lines, rig.projector.columns, geometry.rig);
  check_projector("--row-lines", geometry.row_lines, rig.projector.lines, geometry.rig);
  LensSettings settings = settings_of(rig, geometry.limits);
  settings.bits = geometry.row_bits;
  settings.row_bits = geometry.bits;
  settings.lines = geometry.row_lines;
  settings.row_lines = geometry.lines;
  settings.max_residual_px = geometry.max_residual_px;
  return with_lens(geometry.rig, rig::calibration_of(rig), settings);
}

// Throws UserError about lines that are fewer than the codes that share them.
void check_lines(const DepthGeometry& geometry) {
  for (const auto& [option, lines, bits] : {std::tuple{"--lines", geometry.lines, geometry.bits},
                                            std::tuple{"--row-lines", geometry.row_lines, geometry.row_bits}}) {
    if (lines > 0 && lines < std::ldexp(1.0, bits)) {
      throw UserError(option,
                      fmt::format("is {}, but no code of the 2^{} can be narrower than a line; leave it out where "
                                  "each line has a code of its own",
                                  lines, bits));
    }
  }
}

}  // namespace

void check_size(const std::string& geometry, int rows, int columns, const ImageSource& source) {
  if (source.rows != rows || source.columns != columns) {
    throw UserError(geometry, fmt::format("is for images of {}, but {} is {}", images::size_text(rows, columns),
                                          source.name, images::size_text(source.rows, source.columns)));
  }
}

std::unique_ptr<LensTriangulation> make_lens_triangulation(const DepthGeometry& geometry, const ImageSource& source) {
  check_lines(geometry);
  if (!geometry.rig.empty()) {
    return rig_triangulation_of_both(geometry, source);
  }
  const rig::Calibration calibration = rig::read_calibration(geometry.calibration);
  if (calibration.camera_rows > 0) {
    check_size(geometry.calibration, calibration.camera_rows, calibration.camera_columns, source);
  }
  return with_lens(geometry.calibration, calibration,
                   {.rows = source.rows,
                    .columns = source.columns,
                    .bits = geometry.bits,
                    .row_bits = geometry.row_bits,
                    .lines = geometry.lines,
                    .row_lines = geometry.row_lines,
                    .max_residual_px = geometry.max_residual_px,
                    .limits = geometry.limits});
}

std::unique_ptr<Triangulation> make_triangulation(const DepthGeometry& geometry, const ImageSource& source) {
  if (geometry.rig.empty()) {
    return make_lens_triangulation(geometry, source);
  }
  check_lines(geometry);
  const rig::Rig rig = rig_for(geometry, source);
  check_projector("--lines", geometry.lines, rig.projector.lines, geometry.rig);
  if (!rig.calibration) {
    return std::make_unique<PlaneTriangulation>(rig, geometry.bits, geometry.limits,
                                                rig::CodedLines{0, geometry.lines});
  }
  try {
    return triangulation_of_rig(rig, geometry.bits, geometry.limits, geometry.lines);
  } catch (const std::invalid_argument& error) {
    throw UserError(geometry.rig, error.what());
  }
}

std::unique_ptr<Triangulation> triangulation_of_rig(const rig::Rig& rig, int bits, const DepthLimits& limits,
                                                    double lines) {
  if (rig.is_pinholes()) {
    return std::make_unique<PlaneTriangulation>(rig, bits, limits, rig::CodedLines{0, lines});
  }
  LensSettings settings = settings_of(rig, limits);
  settings.bits = bits;
  settings.lines = lines > 0 ? lines : rig::coded_height(rig.projector.lines, bits);
  return std::make_unique<LensTriangulation>(rig::calibration_of(rig), settings);
}

}  // namespace selfproj::structured_light
