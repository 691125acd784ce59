#include "host/app/scanner_run.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/notes.h"
#include "host/images/frame_options.h"
#include "host/report/depth_output.h"
#include "host/report/facts.h"
#include "host/structured_light/cloud_axes.h"
#include "host/structured_light/depth_run.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::app {
namespace {

// Passes all images to the scanner, and returns the shares of each depth image. If there are several, depth and
// difference of each are written into the folder.
std::vector<structured_light::OfImage<structured_light::DepthShares>> match_images(
    const rig::Rig& rig, std::size_t patterns, images::ImageSequence& images, structured_light::SelfScanner& scanner,
    files::OutputFolder& folder, DepthList* list, std::string& contradiction) {
  std::array<images::Image, 2> pair;  // the scanner reads the positive when its negative comes
  std::vector<structured_light::PointState> states;
  std::vector<structured_light::OfImage<structured_light::DepthShares>> all_shares;
  structured_light::SequenceCheck check(rig.camera.rows, rig.camera.columns, static_cast<int>(patterns / 2), true);
  std::vector<std::string> names(patterns);
  cli::Progress progress("image", images.count());
  for (std::size_t i = 0; i < images.count(); ++i) {
    images::Image& image = pair.at(i % 2);
    image = images.read(i);
    check_camera_size(rig, images.files()[i], image);
    check.add(static_cast<int>(i % patterns), image.view());
    names[i % patterns] = images.files()[i];
    if (scanner.add_frame(image.view(), static_cast<int>(i % patterns))) {
      scanner.explain(states);
      if (contradiction.empty()) {
        contradiction = structured_light::contradiction_of(check, names, scanner);
      }
      all_shares.push_back({i / 2, structured_light::count_states(states)});
      if (images.count() > patterns) {
        append_maps(scanner, i / 2, folder);
      }
      if (list != nullptr) {
        list->add(i / 2, scanner);
      }
    }
    progress.update(i + 1);
  }
  const bool no_points = std::all_of(all_shares.begin(), all_shares.end(), [](const auto& shares) {
    return shares.value.of(structured_light::PointState::valid) == 0;
  });
  if (contradiction.empty() && no_points && !all_shares.empty()) {
    contradiction = structured_light::reason_without_points(all_shares.back().value);
  }
  return all_shares;
}

}  // namespace

void add_geometry_options(CLI::App& command, structured_light::DepthGeometry& geometry) {
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
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->default_str(by_default);
}

void add_strict_option(CLI::App& command, structured_light::ScannerSettings& scanner) {
  command.add_flag(
      "--strict", scanner.strict,
      "Leave out pixels with one ambiguous pair. Without it, two or more ambiguous pairs leave a pixel out.");
}

std::string doubt_about_axes(const structured_light::NearestPoint& nearest,
                             const std::vector<structured_light::Point3f>& cloud, const std::string& other,
                             const std::string& prefix) {
  const std::optional<structured_light::OtherAxes> found = structured_light::other_axes(nearest, cloud);
  if (!found) {
    return "";
  }
  std::string options;
  for (const auto& [needed, name] :
       {std::pair{found->axes.exchange_xy, "exchange-xy"}, {found->axes.opengl, "opengl"}}) {
    if (needed) {
      options += (options.empty() ? "" : " ") + prefix + name;
    }
  }
  return fmt::format(
      "its points are about {:.3f} mm from {} as they are, and about {:.3f} mm with {}: are the clouds in one frame?",
      found->as_they_are_mm, other, found->median_mm, options);
}

void add_limit_options(CLI::App& command, structured_light::DepthGeometry& geometry) {
  cli::begin_group(command, "Limits");
  command.add_option("--min-z", geometry.limits.min_z_mm, "Smallest depth in mm.")
      ->transform(cli::real_number(-1e6, 1e6))
      ->type_name("MM")
      ->capture_default_str();
  command.add_option("--max-z", geometry.limits.max_z_mm, "Largest depth in mm.")
      ->transform(cli::real_number(-1e6, 1e6))
      ->type_name("MM")
      ->default_str("none");
  command
      .add_option("--max-z-per-line", geometry.limits.max_z_per_line_mm,
                  "Leave out pixels where one projector line is worth more than this many mm of z.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->default_str("the rig's; none for a calibration");
  command
      .add_option("--max-residual", geometry.max_residual_px,
                  "Where both axes are coded, leave out pixels whose ray passes the point of their codes at more than "
                  "this many projector pixels.")
      ->transform(cli::number_above_zero())
      ->type_name("PX")
      ->capture_default_str();
}

void add_search_options(CLI::App& command, MatchOptions& options) {
  cli::begin_group(command, "Search");
  command
      .add_option("--e", options.e,
                  "Codes that are searched below the reference, less than 2^m. The other 2^m - e are searched above "
                  "it. What lies deeper than e codes is taken for what is high.")
      ->transform(cli::whole_number(0, (1 << structured_light::Stripes::kMaxBits) - 1))
      ->type_name("E")
      ->default_str("2^m / 2, as much below as above");
  command.add_flag("--printed-direction", options.settings.printed_direction,
                   "Search along Xp at constant Yp, as printed in (4.19), instead of along the epipolar line.");
  command.add_flag("--printed-window", options.settings.printed_window,
                   "Search a window of projector lines, as printed in (4.20), instead of one of codes.");
  command
      .add_option("--line-width", options.settings.line_width, "Projector lines of a code in the printed window, a'.")
      ->transform(cli::number_above_zero())
      ->type_name("LINES")
      ->capture_default_str();
}

void append_maps(const structured_light::SelfScanner& scanner, std::size_t pair, files::OutputFolder& folder) {
  for (const auto& [name, map] : {std::pair{"depth", &scanner.depth()}, {"difference", &scanner.difference()}}) {
    const std::string file = fmt::format("{}_{:04}.tiff", name, pair);
    folder.append(file, images::encode_float_tiff(file, *map));
  }
}

rig::Rig scanner_rig(const std::string& name) {
  rig::Rig rig = rig::load_rig(name);
  if (rig.kind != rig::RigKind::scanner) {
    throw UserError("--rig", fmt::format("{} is not a rig of kind scanner", name));
  }
  return rig;
}

void check_camera_size(const rig::Rig& rig, const std::string& name, const images::Image& image) {
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(name, fmt::format("is {}; the rig's camera has {}", images::size_text(image.rows, image.columns),
                                      images::size_text(rig.camera.rows, rig.camera.columns)));
  }
}

MatchRun::MatchRun(const MatchOptions& options)
    : options_(options),
      rig_(scanner_rig(options.rig)),
      reference_(structured_light::read_self_reference(rig_, options.reference)) {
  const int bits = reference_.stripes.bits;
  const int codes = 1 << bits;
  options_.settings.e = options.e.value_or(codes / 2);
  if (options_.settings.e < 0 || options_.settings.e >= codes) {
    throw UserError("--e",
                    fmt::format("is {}; a reference of {} bits allows 0 to {}", options_.settings.e, bits, codes - 1));
  }
  if (!(options.settings.line_width > 0) || options.settings.line_width > rig_.projector.lines) {
    throw UserError("--line-width", fmt::format("is {}; it must be above 0, and at most the {} lines of the projector",
                                                options.settings.line_width, rig_.projector.lines));
  }
}

DepthList::DepthList(const std::string& file) {
  if (!file.empty()) {
    file_.emplace(file);
    stream_.emplace(*file_);
    stream_->append("pair,pixels,depth,difference\n");
  }
}

void DepthList::add(std::uint64_t pair, const structured_light::SelfScanner& scanner) {
  if (stream_) {
    const std::vector<float>& depth = scanner.depth().values;
    const auto pixels = std::count_if(depth.begin(), depth.end(), [](float z) { return !std::isnan(z); });
    stream_->append(fmt::format("{},{},{:016x},{:016x}\n", pair, pixels, images::digest(scanner.depth()),
                                images::digest(scanner.difference())));
  }
}

void DepthList::commit() {
  if (stream_) {
    stream_->commit();
  }
}

report::MatchReport MatchRun::report() const {
  return {options_.rig, options_.reference, reference_.stripes.bits, options_.settings, threshold(), 0, {}};
}

MatchResult MatchRun::measure(images::ImageSequence& images, files::OutputFolder& folder, DepthList* list) const {
  const structured_light::MatchTable table(rig_, reference_, options_.settings);
  structured_light::SelfScanner scanner(rig_, reference_, table, threshold());
  report::MatchReport all = report();
  all.images = images.count();
  std::string contradiction;
  all.all_shares =
      match_images(rig_, static_cast<std::size_t>(patterns()), images, scanner, folder, list, contradiction);
  all.depth_images = all.all_shares.size();
  const std::string doubt = contradiction.empty() ? structured_light::doubt_of(scanner) : std::string();
  all.doubt = contradiction.empty() ? doubt : contradiction;
  report::MatchPictures pictures = report::write_match(table, scanner, all, folder);
  std::string page = report::match_page(all, table, scanner, pictures);
  return {.text = report::match_text(table, all, folder.name()),
          .page = std::move(page),
          .pictures = std::move(pictures),
          .contradiction = std::move(contradiction),
          .doubt = doubt};
}

MatchStream::MatchStream(const MatchRun& run, std::string uri)
    : run_(run),
      uri_(std::move(uri)),
      table_(run.rig(), run.reference(), run.options().settings),
      scanner_(run.rig(), run.reference(), table_, run.threshold()),
      check_(run.rig().camera.rows, run.rig().camera.columns, run.patterns() / 2, true) {}

bool MatchStream::add(const model::PacketView& packet) {
  const structured_light::ScanStream::Got got = stream_.add(packet);
  if (got == structured_light::ScanStream::Got::nothing) {
    return false;
  }
  const rig::RigCamera& camera = run_.rig().camera;
  structured_light::check_size("the rig's camera", camera.rows, camera.columns,
                               {"an image of " + uri_, stream_.header().rows, stream_.header().columns});
  if (got == structured_light::ScanStream::Got::codes) {
    scanner_.add_codes(stream_.codes().data());
    return true;
  }
  if (!stream_.follows()) {
    scanner_.restart();
  }
  const int pattern = stream_.pattern(run_.patterns());
  check_.add(pattern, stream_.image());
  return scanner_.add_frame(stream_.image(), pattern);
}

std::string MatchStream::contradiction() const {
  return structured_light::contradiction_of(check_, structured_light::names_of_patterns(uri_, run_.patterns()),
                                            scanner_);
}

}  // namespace selfproj::app
