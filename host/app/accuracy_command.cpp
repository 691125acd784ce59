#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <array>
#include <cmath>
#include <memory>
#include <string>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/structured_light/accuracy.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct AccuracyOptions {
  std::string rig = "scanner";
  int bits = 4;
  int width = 2;
  int e = 0;
  double line_width = 3;
  std::string out;
};

// Heights over the plane, and the figures of the thesis for rig B: error in the middle (4.4.5), range at e = 8
// (4.5.1.2).
struct Published {
  double height;
  const char* error;
  const char* range;
};
constexpr std::array<Published, 3> kPublished{
    {{0, "1.79", "–"}, {25, "1.59", "0 .. 65.11"}, {109, "1.04", "67.20 .. 141.66"}}};

std::string heights(const rig::Rig& rig, const structured_light::DepthRange& range) {
  return fmt::format("{:.2f} .. {:.2f}", rig.plane_z_mm - range.high, rig.plane_z_mm - range.low);
}

// 16 x 16 points over the central 320 x 320 pixels of the image, at each of the heights (Fig. 4.10).
std::string error_map(const rig::Rig& rig) {
  constexpr int kPoints = 16;
  constexpr double kStep = 320.0 / kPoints;
  std::string text = "height_mm,row,column,projector_mm,camera_mm,sum_mm\n";
  for (const Published& what : kPublished) {
    for (int i = 0; i < kPoints; ++i) {
      for (int k = 0; k < kPoints; ++k) {
        const structured_light::CameraPoint point{0.5 * (rig.camera.rows - 1) + (i - 0.5 * (kPoints - 1)) * kStep,
                                                  0.5 * (rig.camera.columns - 1) + (k - 0.5 * (kPoints - 1)) * kStep,
                                                  rig.plane_z_mm - what.height};
        const structured_light::ErrorTerms terms = structured_light::error_terms(
            rig, point, 0.5 * rig.projector.line_pitch_mm, 0.5 * rig.camera.pixel_pitch_mm);
        text += fmt::format("{},{},{},{:.4f},{:.4f},{:.4f}\n", what.height, point.row, point.column,
                            std::abs(terms.projector.z), std::abs(terms.camera.z),
                            structured_light::half_pixel_error(rig, point));
      }
    }
  }
  return text;
}

void run_accuracy(const AccuracyOptions& options) {
  const rig::Rig rig = rig::load_rig(options.rig);
  if (rig.kind != rig::RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", options.rig));
  }
  const int codes = 1 << options.bits;
  if (options.e < 0 || options.e >= codes) {
    throw UserError("--e", fmt::format("is {}; {} bits allow 0 to {}", options.e, options.bits, codes - 1));
  }
  const double lines = options.line_width * codes;
  const double row = 0.5 * (rig.camera.rows - 1);
  const double column = 0.5 * (rig.camera.columns - 1);
  fmt::print("Half a pixel of projector and camera, |Δz| in mm in the middle of the image (4.23)\n");
  fmt::print("  height   projector   camera      sum   published for rig B\n");
  for (const Published& what : kPublished) {
    const structured_light::CameraPoint point{row, column, rig.plane_z_mm - what.height};
    const structured_light::ErrorTerms terms =
        structured_light::error_terms(rig, point, 0.5 * rig.projector.line_pitch_mm, 0.5 * rig.camera.pixel_pitch_mm);
    fmt::print("  {:6.0f}   {:9.2f}   {:6.2f}   {:6.2f}   {:>9}\n", what.height, std::abs(terms.projector.z),
               std::abs(terms.camera.z), structured_light::half_pixel_error(rig, point), what.error);
  }
  const structured_light::ErrorTerms approximate =
      structured_light::approximate_error(rig, 0.5 * rig.projector.line_pitch_mm, 0.5 * rig.camera.pixel_pitch_mm);
  fmt::print("  approximation for small angles{} (4.26): {:.2f} and {:.2f}\n\n",
             rig.is_pinholes() ? "" : ", of the nearest pinholes", std::abs(approximate.projector.z),
             std::abs(approximate.camera.z));
  fmt::print("Range in the middle of the image, heights in mm (4.33); e = {}, {} bits, a = {}, a' = {}\n", options.e,
             options.bits, options.width, options.line_width);
  fmt::print("  reference        in cells      window of {:.0f} lines   published for rig B, e = 8\n", lines);
  for (const Published& what : kPublished) {
    const structured_light::CameraPoint point{row, column, rig.plane_z_mm - what.height};
    const structured_light::DepthRange printed = structured_light::range_of_lines(
        rig, point, options.line_width * options.e, options.line_width * (codes - options.e));
    fmt::print("  {:9.0f}   {:>17}   {:>19}   {:>16}\n", what.height,
               heights(rig, structured_light::range_of_cells(rig, point, options.width, options.bits, options.e)),
               heights(rig, printed), what.range);
  }
  const structured_light::CameraPoint plane{row, column, rig.plane_z_mm};
  fmt::print("\nRange over the plane, z in mm, e = 0: published for rig B 457.88 .. 550\n");
  for (const double window : {lines, 2 * lines}) {
    const structured_light::DepthRange range = structured_light::range_of_lines(rig, plane, 0, window);
    fmt::print("  {:.0f} lines: {:.2f} .. {:.2f}\n", window, range.low, range.high);
  }
  const structured_light::DepthRange cells =
      structured_light::range_of_cells(rig, plane, options.width, options.bits, 0);
  fmt::print("  {} cells: {:.2f} .. {:.2f}\n", codes, cells.low, cells.high);
  if (!options.out.empty()) {
    files::OutputFolder folder(options.out);
    folder.append("error_map.csv", error_map(rig));
    folder.commit();
  }
}

}  // namespace

void add_accuracy_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "accuracy",
       .purpose = "Prints quantization error and depth range of a scanner, beside the published figures.",
       .details = "The error is what half a pixel of projector and camera means in z. Numbers in parentheses are those "
                  "of the equations in the thesis.",
       .examples = R"(
# Error and range of the built-in scanner.
selfproj accuracy

# The same with 8 codes below the reference, and a map of the error.
selfproj accuracy --e 8 --out accuracy
)"});
  const auto options = std::make_shared<AccuracyOptions>();
  command->add_option("--rig", options->rig, "Built-in rig or YAML file of kind scanner.")
      ->type_name("RIG")
      ->capture_default_str();
  command->add_option("--bits", options->bits, "Bits of the code, m.")
      ->transform(cli::whole_number(1, structured_light::Stripes::kMaxBits))
      ->type_name("M")
      ->capture_default_str();
  command->add_option("--rows-per-code", options->width, "Width of a code in camera rows, a.")
      ->transform(cli::whole_number(1, structured_light::Stripes::kMaxWidth))
      ->type_name("A")
      ->capture_default_str();
  command->add_option("--e", options->e, "Codes that are searched below the reference, less than 2^m.")
      ->transform(cli::whole_number(0, (1 << structured_light::Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->capture_default_str();
  command->add_option("--line-width", options->line_width, "Projector lines of a code in the printed window, a'.")
      ->transform(cli::real_number(0.1, 100))
      ->type_name("LINES")
      ->capture_default_str();
  command
      ->add_option("--out", options->out,
                   "Folder for error_map.csv: the error at 16 x 16 points of the central 320 x 320 pixels.")
      ->type_name("DIR");
  command->callback([options] { run_accuracy(*options); });
}

}  // namespace selfproj::app
