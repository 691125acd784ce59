#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/capture_run.h"
#include "host/app/commands.h"
#include "host/app/scanner_run.h"
#include "host/capture/sequence_capture.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/report/depth_output.h"
#include "host/report/report.h"
#include "host/structured_light/depth_run.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/structured_light/gray_sequence.h"

namespace selfproj::app {
namespace {

struct ScanOptions {
  ScanOptions() { setup.scanner.median = false; }

  CaptureOptions capture;
  structured_light::DepthSetup setup;
  MatchOptions match;
  bool keep_images = false;
  std::string out;
};

void check_options(const ScanOptions& options) {
  const structured_light::DepthGeometry& geometry = options.setup.geometry;
  if (!options.match.reference.empty()) {
    if (geometry.rig.empty() || !geometry.calibration.empty()) {
      throw UserError("--self-projected", "needs the --rig of its reference; --calibration cannot be used with it");
    }
    if (options.setup.scanner.strict) {
      throw UserError("--strict", "cannot be used with --self-projected");
    }
  } else if (geometry.rig.empty() == geometry.calibration.empty()) {
    throw UserError("--rig, --calibration", "exactly one of them is needed");
  }
}

// Throws UserError if a rig's projector has not the size of the display.
void check_display(const ScanOptions& options, const rig::Rig& rig, const capture::CaptureSizes& sizes) {
  if (rig.projector.lines != sizes.projector_rows || rig.projector.columns != sizes.projector_columns) {
    throw UserError(
        "--rig " + options.setup.geometry.rig,
        fmt::format("its projector has {}, but display {} has {}",
                    images::size_text(rig.projector.lines, rig.projector.columns), options.capture.display.display,
                    images::size_text(sizes.projector_rows, sizes.projector_columns)));
  }
}

// What both kinds of scan show on the page.
report::ReportPage page_of(const ScanOptions& options, const capture::CaptureRecord& record) {
  report::ReportPage page;
  page.title = "Scan";
  page.subtitle = fmt::format("{}, display {}", record.camera, record.display);
  page.pictures.push_back(
      {"The camera under white light", images::encode_png(record.white), capture::exposure_text(record.exposure)});
  page.counters = {
      {"retaken_incomplete", "taken again: incomplete", static_cast<std::int64_t>(record.retaken.incomplete)},
      {"retaken_missing", "taken again: missing", static_cast<std::int64_t>(record.retaken.missing)},
      {"retaken_mixed", "taken again: not of one pattern alone", static_cast<std::int64_t>(record.retaken.mixed)}};
  page.settings = {{"images", "images", static_cast<std::int64_t>(record.shots.size())},
                   {"settle_ms", "settle time", record.settle.settle_ms, "ms"},
                   {"trigger", "trigger", std::string(record.triggered ? "software" : "free")}};
  if (!options.setup.geometry.rig.empty()) {
    page.settings.push_back({"rig", "rig", options.setup.geometry.rig});
  }
  return page;
}

void write_capture(const ScanOptions& options, const Captured& captured, files::OutputFolder& folder) {
  folder.append("capture.json", capture::capture_json(captured.record));
  if (options.keep_images) {
    for (std::size_t i = 0; i < captured.images.size(); ++i) {
      folder.append(captured.record.shots[i].image, images::encode_png(captured.images[i]));
    }
  }
}

std::string scan_by_gray_codes(const ScanOptions& options, files::OutputFolder& folder) {
  structured_light::DepthSetup setup = options.setup;
  if (options.match.threshold >= 0) {
    setup.scanner.threshold = options.match.threshold;
  }
  structured_light::DepthGeometry& geometry = setup.geometry;
  const std::optional<rig::Rig> rig = geometry.rig.empty() ? std::nullopt : std::optional(scanner_rig(geometry.rig));
  const Captured captured = capture_in_memory(options.capture, options.out, [&](const capture::CaptureSizes& sizes) {
    if (rig) {
      check_display(options, *rig, sizes);
    }
    constexpr int kMaxCodes = 1 << model::GrayDecoder::kMaxBits;
    if (sizes.projector_rows > kMaxCodes || sizes.projector_columns > kMaxCodes) {
      throw UserError("--display",
                      fmt::format("has {}; Gray codes have at most {} lines and columns",
                                  images::size_text(sizes.projector_rows, sizes.projector_columns), kMaxCodes));
    }
    const structured_light::GraySequence gray(sizes.projector_columns, sizes.projector_rows);
    geometry.bits = gray.column_bits();
    geometry.row_bits = gray.row_bits();
    // Refuses a geometry of another camera before anything is shown.
    structured_light::make_lens_triangulation(geometry,
                                              {options.capture.camera, sizes.camera_rows, sizes.camera_columns});
    return gray_patterns(gray, gray.white());
  });
  images::ImageSequence images = captured.sequence();
  const structured_light::DepthRun run = structured_light::depth_of_both_axes(setup, images);
  const std::string& doubt = run.contradiction.empty() ? run.doubt : run.contradiction;
  cli::note_doubt(options.capture.camera, doubt);
  const report::DepthReport report{.setup = setup,
                                   .device = {},
                                   .images = captured.images.size(),
                                   .cloud = {},
                                   .axes = {},
                                   .comparison = {},
                                   .plane = {},
                                   .doubts = doubt.empty() ? std::vector<std::string>{} : std::vector{doubt}};
  report::ReportPicture picture = report::write_depth(run, report, folder);
  picture.title = "Depth";
  picture.note = structured_light::share_text(run.shares, structured_light::PointState::valid);
  write_capture(options, captured, folder);
  report::ReportPage page = page_of(options, captured.record);
  page.highlights = {
      {"valid", "pixels with a depth", static_cast<std::int64_t>(run.shares.of(structured_light::PointState::valid))},
      {"median_residual_px", "median distance of the two codes' rays", run.median_residual_px, "px"}};
  page.pictures.insert(page.pictures.begin(), picture);
  report::ReportTable shares{.title = "Pixels", .header = {"state", "pixels"}, .rows = {}};
  for (int i = 0; i < structured_light::kPointStates; ++i) {
    const auto state = static_cast<structured_light::PointState>(i);
    shares.rows.push_back({structured_light::name_of(state), std::to_string(run.shares.of(state))});
  }
  page.tables.push_back(std::move(shares));
  folder.append("report.html", report::page_html(page));
  return report::depth_text(run, report, folder.name());
}

std::string scan_self_projected(const ScanOptions& options, files::OutputFolder& folder) {
  MatchOptions match = options.match;
  match.rig = options.setup.geometry.rig;
  const MatchRun run(match);
  std::vector<std::string> files;
  for (int i = 0; i < run.patterns(); ++i) {
    files.push_back(fmt::format("{}/pattern_{:02}.png", match.reference, i));
  }
  const images::ImageSequence patterns(std::move(files), std::nullopt);
  const Captured captured = capture_in_memory(options.capture, options.out, [&](const capture::CaptureSizes& sizes) {
    check_display(options, run.rig(), sizes);
    check_camera_size(run.rig(), options.capture.camera, {sizes.camera_rows, sizes.camera_columns, {}});
    return images::ImageSequence(patterns);
  });
  images::ImageSequence images = captured.sequence();
  const MatchResult result = run.measure(images, folder);
  cli::note_doubt(options.capture.camera, result.contradiction);
  write_capture(options, captured, folder);
  report::ReportPage page = page_of(options, captured.record);
  page.settings.push_back({"reference", "reference", match.reference});
  page.pictures.insert(page.pictures.begin(), {result.pictures.difference, result.pictures.depth});
  folder.append("report.html", report::page_html(page));
  return result.text;
}

void run_scan(const ScanOptions& options) {
  check_options(options);
  files::OutputFolder folder(options.out);
  const std::string text =
      options.match.reference.empty() ? scan_by_gray_codes(options, folder) : scan_self_projected(options, folder);
  folder.commit();
  fmt::print("{}", text);
}

}  // namespace

void add_scan_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "scan",
       .purpose = "Projects, captures and measures: from a camera and a projector to a depth image in one run.",
       .details =
           "Without --self-projected the patterns are the Gray codes of the display's columns and rows, each positive "
           "followed by its negative. With it they are those of a reference, 2m of them, and the result has the "
           "difference from the reference as well. Exposure, settle time and lost images are treated as by `selfproj "
           "capture`.\n\n"
           "The output folder gets what `selfproj depth` or `selfproj match` writes (depth.tiff, cloud.ply, pictures, "
           "shares.csv, summary.json), capture.json, and report.html. Esc and Ctrl-C end the scan; nothing is written "
           "then, and the exit status is 1.",
       .examples = R"(
# A scanner calibrated by `selfproj calibrate`, to a cloud (needs hardware)
selfproj scan --camera camera:192.168.1.20 --display 1 \
  --calibration calibration/calibration.yaml --out scan

# How a part differs from the reference, with a few patterns (needs hardware)
selfproj scan --camera camera:192.168.1.20 --display 1 --rig calibration/rig.yaml \
  --self-projected reference --out part
)"});
  const auto options = std::make_shared<ScanOptions>();
  cli::begin_group(*command, "Input");
  add_camera_option(*command, options->capture);
  cli::begin_group(*command, "Geometry");
  add_geometry_options(*command, options->setup.geometry);
  command
      ->add_option("--self-projected", options->match.reference,
                   "Folder that `selfproj pattern stripes` wrote. Its patterns are shown, and the result is compared "
                   "with it.")
      ->type_name("DIR");
  add_projector_options(*command, options->capture);
  cli::begin_group(*command, "Decoding");
  add_threshold_option(*command, options->match.threshold, "5; the rig's with --self-projected");
  add_strict_option(*command, options->setup.scanner);
  add_limit_options(*command, options->setup.geometry);
  add_search_options(*command, options->match);
  cli::begin_group(*command, "Output");
  command->add_flag("--images", options->keep_images, "Keep the camera's images as well, image_0001.png and so on.");
  command->add_option("--out", options->out, "Folder for the results.")->type_name("DIR")->required();
  command->callback([options] { run_scan(*options); });
}

}  // namespace selfproj::app
