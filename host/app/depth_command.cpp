#include "host/app/depth_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/image_assembler.h"
#include "host/driver/open_device.h"
#include "host/io/float_image.h"
#include "host/io/frame_options.h"
#include "host/io/image_files.h"
#include "host/io/output_folder.h"
#include "host/io/progress.h"
#include "host/io/stop_signal.h"
#include "host/io/user_error.h"
#include "host/report/depth_output.h"
#include "host/rig/calibration_file.h"
#include "host/rig/rig.h"
#include "host/rig/rig_calibration.h"
#include "host/structured_light/fast_decoder.h"
#include "host/structured_light/lens_triangulation.h"
#include "host/structured_light/plane_fit.h"
#include "host/structured_light/point_cloud.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {
namespace {

using Json = nlohmann::ordered_json;

struct DepthOptions {
  std::string rig;
  std::string calibration;
  int bits = 0;
  int row_bits = 0;
  int threshold = ScannerSettings{}.threshold;
  bool median = false;
  bool strict = false;
  std::string channel;
  double lines = 0;
  double row_lines = 0;
  DepthLimits limits;
  double max_residual_px = LensSettings{}.max_residual_px;
  std::string background;
  double min_difference_mm = static_cast<double>(ScannerSettings{}.min_difference_mm);
  SteadySettings steady;
  std::string compare;
  bool compare_opengl = false;
  bool plane = false;
  std::string out;
  std::string device;
  std::size_t count = 0;
  std::vector<std::string> images;
};

void check_options(const DepthOptions& options) {
  if (options.rig.empty() == options.calibration.empty()) {
    throw UserError("--rig, --calibration", "one of them is needed, and not both");
  }
  if (!options.rig.empty() && (options.row_bits > 0 || options.lines > 0 || options.row_lines > 0)) {
    throw UserError("--row-bits, --lines, --row-lines", "go with --calibration; a rig has its own lines");
  }
  if (options.row_bits > 0 && (options.median || !options.background.empty())) {
    throw UserError("--row-bits", "is for a single measurement; --median and --background go with one axis");
  }
  if (options.strict && options.median) {
    throw UserError("--strict, --median", "exclude each other: the median fills what --strict leaves out");
  }
  if (options.images.empty() == options.device.empty()) {
    throw UserError("IMAGE, --device", "one of them is needed, and not both");
  }
  if (!options.device.empty()) {
    if (options.row_bits > 0 || options.strict || options.median || !options.channel.empty()) {
      throw UserError("--device",
                      "brings codes decoded on the board; --row-bits, --strict, --median, --channel are for images");
    }
    return;
  }
  if (options.count > 0) {
    throw UserError("--count", "goes with --device");
  }
  const std::size_t count = options.images.size();
  const auto need = 2 * static_cast<std::size_t>(options.bits + options.row_bits);
  if (count % 2 != 0) {
    throw UserError("IMAGE",
                    fmt::format("{} images are an odd number; each positive is followed by its negative", count));
  }
  if (count < need) {
    throw UserError("IMAGE", fmt::format("{} images are too few; {} are needed for {} bits", count, need,
                                         options.bits + options.row_bits));
  }
  if (options.row_bits > 0 && count != need) {
    throw UserError("IMAGE", fmt::format("{} images are too many; with --row-bits {} are taken", count, need));
  }
}

// Reads images of one size in turn.
class Images {
 public:
  Images(const std::vector<std::string>& files, std::optional<Channel> channel) : files_(files), channel_(channel) {
    for (const std::string& file : files) {
      check_image_file(file);
    }
  }

  [[nodiscard]] std::size_t count() const { return files_.size(); }

  // The first image, to see its size; read(0) gives it then.
  const Image& first() {
    first_ = read(0);
    return *first_;
  }

  Image read(std::size_t i) {
    if (i == 0 && first_) {
      Image image = std::move(*first_);
      first_.reset();
      return image;
    }
    Image image = read_image(files_[i], channel_);
    if (rows_ == 0) {
      rows_ = image.rows;
      columns_ = image.columns;
    } else {
      check_same_size(files_[i], image, files_.front(), rows_, columns_);
    }
    return image;
  }

 private:
  const std::vector<std::string>& files_;
  std::optional<Channel> channel_;
  std::optional<Image> first_;
  int rows_ = 0;
  int columns_ = 0;
};

// Where images come from, and their size.
struct Source {
  std::string name;
  int rows = 0;
  int columns = 0;
};

void check_size(const std::string& geometry, int rows, int columns, const Source& source) {
  if (source.rows != rows || source.columns != columns) {
    throw UserError(geometry, fmt::format("is for images of {}, but {} is {}", size_text(rows, columns), source.name,
                                          size_text(source.rows, source.columns)));
  }
}

std::unique_ptr<LensTriangulation> with_lens(const std::string& name, const Calibration& calibration,
                                             const LensSettings& settings) {
  try {
    return std::make_unique<LensTriangulation>(calibration, settings);
  } catch (const std::invalid_argument& error) {
    throw UserError(name, error.what());
  }
}

// The full model of a calibrated rig, the pinholes of any other.
std::unique_ptr<Triangulation> rig_triangulation(const DepthOptions& options, const Source& source) {
  Rig rig = load_rig(options.rig);
  check_size("--rig " + options.rig, rig.camera.rows, rig.camera.columns, source);
  if (std::isfinite(options.limits.max_z_per_line_mm)) {
    rig.measure.max_z_per_line_mm = options.limits.max_z_per_line_mm;
  }
  if (rig.calibration) {
    LensSettings settings;
    settings.rows = source.rows;
    settings.columns = source.columns;
    settings.bits = options.bits;
    settings.lines = rig.projector.lines;
    settings.limits = options.limits;
    settings.limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
    settings.rows_are_x = true;
    return with_lens(options.rig, calibration_of(rig), settings);
  }
  return std::make_unique<PlaneTriangulation>(rig, options.bits, options.limits);
}

std::unique_ptr<LensTriangulation> lens_triangulation(const DepthOptions& options, const Source& source) {
  const Calibration calibration = read_calibration(options.calibration);
  if (calibration.camera_rows > 0) {
    check_size(options.calibration, calibration.camera_rows, calibration.camera_columns, source);
  }
  const LensSettings settings{
      source.rows,       source.columns,          options.bits,  options.row_bits, options.lines,
      options.row_lines, options.max_residual_px, options.limits};
  return with_lens(options.calibration, calibration, settings);
}

std::unique_ptr<Triangulation> triangulation_for(const DepthOptions& options, const Source& source) {
  if (options.rig.empty()) {
    return lens_triangulation(options, source);
  }
  return rig_triangulation(options, source);
}

// What is written of all depth images, in their order.
struct Tables {
  std::string shares = "pair";
  std::string moved = "pair,pixels,x,y,z\n";

  Tables() {
    for (int state = 0; state < kPointStates; ++state) {
      shares += fmt::format(",{}", name_of(static_cast<PointState>(state)));
    }
    shares += '\n';
  }

  void add(std::size_t pair, const DepthShares& counts) {
    fmt::format_to(std::back_inserter(shares), "{},{}\n", pair, fmt::join(counts.count, ","));
  }

  // Nothing but the 0 where nothing moved.
  void add(std::size_t pair, const Moved& what) {
    if (what.pixels == 0) {
      fmt::format_to(std::back_inserter(moved), "{},0,,,\n", pair);
    } else {
      fmt::format_to(std::back_inserter(moved), "{},{},{:.4f},{:.4f},{:.4f}\n", pair, what.pixels, what.x, what.y,
                     what.z);
    }
  }
};

// The newest depth image and what is to be said of it.
struct Result {
  FloatImage depth;
  DepthShares shares;
  std::size_t depth_images = 0;
  std::optional<Moved> moved;
  double median_residual_px = std::numeric_limits<double>::quiet_NaN();
  std::optional<Counters> counters;  // of the device
  std::uint64_t incomplete = 0;      // code images of which lines are missing
};

std::string share_text(const DepthShares& shares, PointState state) {
  return fmt::format("{:.2f} % {}", 100.0 * static_cast<double>(shares.of(state)) / static_cast<double>(shares.total()),
                     name_of(state));
}

// The background of the options, where there is one.
void set_background(const DepthOptions& options, const Triangulation& triangulation, Scanner& scanner) {
  if (options.background.empty()) {
    return;
  }
  const FloatImage background = read_float_tiff(options.background);
  if (background.rows != triangulation.rows() || background.columns != triangulation.columns()) {
    throw UserError(options.background,
                    fmt::format("is {}, but the images are {}", size_text(background.rows, background.columns),
                                size_text(triangulation.rows(), triangulation.columns())));
  }
  scanner.set_background(background);
}

void write_moved(const Scanner& scanner, OutputFolder& folder) {
  FloatImage moved(scanner.depth().rows, scanner.depth().columns);
  scanner.difference(moved);
  folder.append("moved.tiff", encode_float_tiff("moved.tiff", moved));
}

// One axis: a depth image after every pair from the m-th on.
Result scan(const DepthOptions& options, Images& images, const Triangulation& triangulation, OutputFolder& folder,
            Tables& tables) {
  const ScannerSettings settings{options.threshold, options.median, options.strict,
                                 static_cast<float>(options.min_difference_mm), options.steady};
  Scanner scanner(triangulation, settings);
  set_background(options, triangulation, scanner);
  const int patterns = 2 * options.bits;
  const bool several = images.count() > static_cast<std::size_t>(patterns);
  std::vector<PointState> states(triangulation.pixels());
  Result result;
  Progress progress("image", images.count());
  std::array<Image, 2> pair;  // the scanner looks at the positive when its negative comes
  std::string note;
  for (std::size_t i = 0; i < images.count(); ++i) {
    Image& image = pair[i % 2];
    image = images.read(i);
    if (scanner.take(image.view(), static_cast<int>(i % static_cast<std::size_t>(patterns)))) {
      const std::size_t number = i / 2;
      triangulation.explain(scanner.codes().data(), scanner.depth().values.data(), states.data());
      result.shares = count_states(states);
      tables.add(number, result.shares);
      note = share_text(result.shares, PointState::valid);
      if (scanner.has_background()) {
        result.moved = scanner.moved();
        tables.add(number, scanner.moved());
        note += fmt::format(", {} pixels moved", scanner.moved().pixels);
      }
      if (several) {
        const std::string name = fmt::format("depth_{:04}.tiff", number);
        folder.append(name, encode_float_tiff(name, scanner.depth()));
      }
      ++result.depth_images;
    }
    progress.update(i + 1, note);
  }
  result.depth = scanner.depth();
  if (scanner.has_background()) {
    write_moved(scanner, folder);
  }
  return result;
}

std::string note_of(const Counters& counters, const ImageAssembler& assembler, const Scanner& scanner) {
  std::string note = fmt::format("lost on the board {}, in the ring {}, bad {}, incomplete {}", counters.lost_board,
                                 counters.lost_ring, counters.bad, assembler.incomplete());
  if (scanner.has_background()) {
    const Moved& moved = scanner.moved();
    note += fmt::format("; {} pixels moved, at {:.1f}, {:.1f}, {:.1f} mm", moved.pixels, moved.x, moved.y, moved.z);
  }
  return note;
}

// The board's code images, until the device ends, --count have come, or Ctrl-C.
Result scan_device(const DepthOptions& options, OutputFolder& folder, Tables& tables,
                   std::unique_ptr<Triangulation>& triangulation) {
  using namespace std::chrono_literals;
  const std::unique_ptr<Device> device = open_device(options.device);
  ImageAssembler assembler(spec::kKindCodes, 0);
  std::optional<Scanner> scanner;
  Result result;
  std::uint64_t sequence = 0;
  {
    const StopSignal stop;
    Progress progress("code image", options.count);
    PacketView packet;
    while (!StopSignal::came() && (options.count == 0 || result.depth_images < options.count)) {
      const Next next = device->next(packet, 100ms);
      if (next == Next::end) {
        break;
      }
      if (next == Next::packet && assembler.add(packet)) {
        const PacketHeader& header = assembler.header();
        const Source source{"a code image of " + options.device, header.rows, header.columns};
        if (!scanner) {
          triangulation = triangulation_for(options, source);
          scanner.emplace(*triangulation,
                          ScannerSettings{options.threshold, false, false,
                                          static_cast<float>(options.min_difference_mm), options.steady});
          set_background(options, *triangulation, *scanner);
        }
        check_size("an earlier code image", triangulation->rows(), triangulation->columns(), source);
        scanner->take_codes(assembler.codes().data());
        sequence = header.sequence;
        ++result.depth_images;
        if (scanner->has_background()) {
          tables.add(sequence, scanner->moved());
        }
      }
      if (scanner && progress.due()) {
        progress.update(result.depth_images, note_of(device->counters(), assembler, *scanner));
      }
    }
  }
  if (!scanner) {
    throw UserError(options.device, "brought no complete code image");
  }
  std::vector<PointState> states(triangulation->pixels());
  triangulation->explain(scanner->codes().data(), scanner->depth().values.data(), states.data());
  result.shares = count_states(states);
  tables.add(sequence, result.shares);
  result.depth = scanner->depth();
  result.counters = device->counters();
  result.incomplete = assembler.incomplete();
  if (scanner->has_background()) {
    result.moved = scanner->moved();
    write_moved(*scanner, folder);
  }
  return result;
}

// Both axes: one depth image of 2m column and 2n row images.
Result scan_both(const DepthOptions& options, Images& images, const LensTriangulation& triangulation, Tables& tables) {
  const int rows = triangulation.rows();
  const int columns = triangulation.columns();
  Result result;
  result.depth = FloatImage(rows, columns);
  result.depth_images = 1;
  Progress progress("image", images.count());
  std::array<Image, 2> pair;
  std::size_t next = 0;
  const auto decode = [&](int bits) {
    FastGrayDecoder decoder({rows, columns, bits, options.threshold});
    for (int pattern = 0; pattern < 2 * bits; ++pattern, ++next) {
      Image& image = pair[next % 2];
      image = images.read(next);
      decoder.take(image.view(), pattern, true);
      progress.update(next + 1);
    }
    std::vector<std::uint16_t> words(triangulation.pixels());
    if (options.strict) {
      unambiguous_code_words(decoder.codes(), words.data());
    } else {
      code_words(decoder.codes(), words.data());
    }
    return words;
  };
  const std::vector<std::uint16_t> column_codes = decode(options.bits);
  const std::vector<std::uint16_t> row_codes = decode(options.row_bits);
  std::vector<PointState> states(triangulation.pixels());
  std::vector<float> residuals(triangulation.pixels());
  triangulation.depth_of_both(column_codes.data(), row_codes.data(), result.depth.values.data(), states.data(),
                              residuals.data());
  result.shares = count_states(states);
  tables.add(images.count() / 2 - 1, result.shares);
  residuals.erase(std::remove_if(residuals.begin(), residuals.end(), [](float value) { return std::isnan(value); }),
                  residuals.end());
  if (!residuals.empty()) {
    const auto middle = residuals.begin() + static_cast<std::ptrdiff_t>(residuals.size() / 2);
    std::nth_element(residuals.begin(), middle, residuals.end());
    result.median_residual_px = static_cast<double>(*middle);
  }
  return result;
}

// Numbers that are not finite are null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(); }

Json depth_json(const FloatImage& depth) {
  std::vector<float> values;
  std::copy_if(depth.values.begin(), depth.values.end(), std::back_inserter(values),
               [](float value) { return !std::isnan(value); });
  if (values.empty()) {
    return nullptr;
  }
  std::sort(values.begin(), values.end());
  return {{"least", values.front()}, {"median", values[values.size() / 2]}, {"greatest", values.back()}};
}

// Angle between the plane's normal and z.
double tilt_deg(const PlaneFit& fit) { return std::atan(std::hypot(fit.a, fit.b)) * 180 / std::numbers::pi; }

std::string summary(const DepthOptions& options, const Result& result, const std::optional<CloudComparison>& comparison,
                    const std::optional<PlaneFit>& plane) {
  Json json;
  json["geometry"] = options.rig.empty() ? options.calibration : options.rig;
  if (result.counters) {
    const Counters& counters = *result.counters;
    json["device"] = {{"uri", options.device},           {"delivered", counters.delivered},
                      {"flagged", counters.flagged},     {"lost_board", counters.lost_board},
                      {"lost_ring", counters.lost_ring}, {"bad", counters.bad},
                      {"incomplete", result.incomplete}};
  } else {
    json["images"] = options.images.size();
    json["threshold"] = options.threshold;
    json["median"] = options.median;
    json["strict"] = options.strict;
  }
  json["rows"] = result.depth.rows;
  json["columns"] = result.depth.columns;
  json["bits"] = options.bits;
  json["row_bits"] = options.row_bits;
  json["depth_images"] = result.depth_images;
  json["depth_png_mm_per_unit"] = kDepthUnit;
  const std::size_t total = result.shares.total();
  Json pixels;
  Json shares;
  for (int i = 0; i < kPointStates; ++i) {
    const auto state = static_cast<PointState>(i);
    pixels[name_of(state)] = result.shares.of(state);
    shares[name_of(state)] = static_cast<double>(result.shares.of(state)) / static_cast<double>(total);
  }
  json["newest"]["pixels"] = total;
  json["newest"]["measurable"] = total - result.shares.of(PointState::not_measurable);
  json["newest"]["by_state"] = pixels;
  json["newest"]["share"] = shares;
  json["newest"]["z_mm"] = depth_json(result.depth);
  if (options.row_bits > 0) {
    json["newest"]["median_residual_px"] = number(result.median_residual_px);
  }
  if (result.moved) {
    json["newest"]["moved"] = {{"pixels", result.moved->pixels},
                               {"x", number(result.moved->x)},
                               {"y", number(result.moved->y)},
                               {"z", number(result.moved->z)}};
  }
  if (comparison) {
    json["compare"] = {{"file", options.compare},
                       {"points", comparison->ours},
                       {"points_of_file", comparison->theirs},
                       {"median_mm", number(comparison->median_mm)},
                       {"points_within_1_mm", number(comparison->ours_within)},
                       {"points_of_file_within_1_mm", number(comparison->theirs_within)}};
  }
  if (plane) {
    json["plane"] = {{"points", plane->points},
                     {"z_on_axis_mm", number(plane->z0)},
                     {"z_per_x", number(plane->a)},
                     {"z_per_y", number(plane->b)},
                     {"tilt_deg", number(tilt_deg(*plane))},
                     {"residual_rms_mm", number(plane->rms)},
                     {"residual_greatest_mm", number(plane->greatest)},
                     {"rounding_rms_mm", number(plane->rounding_rms)}};
  }
  return json.dump(2) + "\n";
}

std::optional<CloudComparison> compare(const DepthOptions& options, const std::vector<Point3f>& ours) {
  if (options.compare.empty()) {
    return std::nullopt;
  }
  std::vector<Point3f> theirs = read_ply(options.compare);
  if (options.compare_opengl) {
    for (Point3f& point : theirs) {
      point = {point.x, -point.y, -point.z};
    }
  }
  return compare_clouds(ours, theirs, 1.0);
}

void run_depth(const DepthOptions& options) {
  check_options(options);
  OutputFolder folder(options.out);
  Tables tables;
  Result result;
  std::unique_ptr<Triangulation> triangulation;
  if (!options.device.empty()) {
    result = scan_device(options, folder, tables, triangulation);
  } else {
    Images images(options.images, channel_of(options.channel));
    const Image& first = images.first();
    const Source source{options.images.front(), first.rows, first.columns};
    if (options.row_bits > 0) {
      auto lens = lens_triangulation(options, source);
      result = scan_both(options, images, *lens, tables);
      triangulation = std::move(lens);
    } else {
      triangulation = triangulation_for(options, source);
      result = scan(options, images, *triangulation, folder, tables);
    }
  }
  const std::optional<CloudComparison> comparison = compare(options, points_of(*triangulation, result.depth));

  std::optional<PlaneFit> plane;
  if (options.plane) {
    plane = fit_plane(*triangulation, result.depth);
  }

  const std::string title =
      fmt::format("depth z, {} of {} pixels", result.shares.of(PointState::valid), result.shares.total());
  folder.append("depth.tiff", encode_float_tiff("depth.tiff", result.depth));
  folder.append("depth.png", depth_png(result.depth));
  folder.append("depth_colour.png", depth_picture(*triangulation, result.depth, !options.rig.empty(), title));
  folder.append("cloud.ply", cloud_ply(*triangulation, result.depth));
  folder.append("shares.csv", tables.shares);
  if (result.moved) {
    folder.append("moved.csv", tables.moved);
  }
  folder.append("summary.json", summary(options, result, comparison, plane));
  folder.commit();

  std::string shares;
  for (int i = 0; i < kPointStates; ++i) {
    const auto state = static_cast<PointState>(i);
    if (state == PointState::valid || result.shares.of(state) > 0) {
      shares += (shares.empty() ? "" : ", ") + share_text(result.shares, state);
    }
  }
  const std::string how = options.device.empty() ? fmt::format("threshold {}", options.threshold) : options.device;
  fmt::print("{} {} of {}, {} bits, {}: {} → {}\n", result.depth_images,
             result.depth_images == 1 ? "depth image" : "depth images",
             size_text(result.depth.rows, result.depth.columns), options.bits, how, shares, folder.name());
  if (comparison) {
    fmt::print(
        "{}: median distance of our {} points to its {}: {:.3f} mm; within 1 mm: {:.1f} % of ours, {:.1f} % of its\n",
        options.compare, comparison->ours, comparison->theirs, comparison->median_mm, 100 * comparison->ours_within,
        100 * comparison->theirs_within);
  }
  if (plane && std::isnan(plane->rms)) {
    fmt::print("plane: {} points are too few, or on a line\n", plane->points);
  } else if (plane) {
    fmt::print(
        "plane through {} points: z {:.3f} mm on the axis, leaning by {:.3f}°; residuals {:.3f} mm RMS, {:.3f} mm at "
        "most; rounding to whole codes predicts {:.3f} mm RMS\n",
        plane->points, plane->z0, tilt_deg(*plane), plane->rms, plane->greatest, plane->rounding_rms);
  }
}

}  // namespace

void add_depth_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "depth", "Depth images of recorded Gray-code images, pos0 neg0 pos1 neg1 ..., or of a board that decodes");
  const auto options = std::make_shared<DepthOptions>();
  const CLI::Range positive(std::numeric_limits<double>::min(), 1e6, "a number greater than 0");
  command->add_option("--rig", options->rig, "Geometry: a built-in rig or a YAML file")->type_name("RIG");
  command
      ->add_option("--calibration", options->calibration,
                   "Geometry: OpenCV YAML with cam_K, cam_kc, pro_K, pro_kc, R, T")
      ->type_name("FILE.yaml");
  command->add_option("--bits", options->bits, "Pairs of patterns in a cycle; with --row-bits, of the column code")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("M")
      ->required();
  command
      ->add_option("--row-bits", options->row_bits,
                   "Both axes: so many pairs of the projector rows' code follow those of its columns")
      ->check(CLI::Range(1, GrayDecoder::kMaxBits))
      ->type_name("N");
  command->add_option("--threshold", options->threshold, "Differences of a pair up to this are ambiguous")
      ->check(CLI::Range(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command->add_flag("--median", options->median, "3 x 3 median of the code image");
  command->add_flag("--strict", options->strict, "No depth where even one pair is ambiguous (default: two)");
  command->add_option("--channel", options->channel, "What to take of colour images")
      ->check(CLI::IsMember(channel_names()));
  command
      ->add_option("--lines", options->lines,
                   "Calibration: projector columns that the 2^M codes cover (default: 2^M, a code a column)")
      ->check(positive)
      ->type_name("H");
  command->add_option("--row-lines", options->row_lines, "Likewise rows and 2^N")->check(positive)->type_name("H");
  command->add_option("--min-z", options->limits.min_z_mm, "Smallest depth in mm")
      ->type_name("MM")
      ->capture_default_str();
  command->add_option("--max-z", options->limits.max_z_mm, "Greatest depth in mm (default: none)")->type_name("MM");
  command
      ->add_option("--max-z-per-line", options->limits.max_z_per_line_mm,
                   "No depth where a projector line is worth more (default: the rig's; none for a calibration)")
      ->check(positive)
      ->type_name("MM");
  command
      ->add_option("--max-residual", options->max_residual_px,
                   "Both axes: no depth where ray and codes are further apart in the projector image")
      ->check(positive)
      ->type_name("PX")
      ->capture_default_str();
  command->add_option("--background", options->background, "Depth image of what does not move: moved.csv, moved.tiff")
      ->type_name("FILE.tiff");
  command->add_option("--min-difference", options->min_difference_mm, "From the background, for what counts as moved")
      ->check(CLI::NonNegativeNumber)
      ->type_name("MM")
      ->capture_default_str();
  command
      ->add_option("--max-change", options->steady.most_change_mm,
                   "Of depth from one depth image to the next, for what counts as moved [any]")
      ->check(CLI::NonNegativeNumber)
      ->type_name("MM");
  command
      ->add_option("--min-neighbours", options->steady.least_neighbours,
                   "Of the 8 pixels around, moved and no further off in z than --max-change, for what counts as moved")
      ->check(CLI::Range(0, 8))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--compare", options->compare, "Say how far the points lie from those of this cloud")
      ->type_name("FILE.ply");
  command->add_flag("--compare-opengl", options->compare_opengl, "The cloud's y and z have the other sign");
  command->add_flag("--plane", options->plane, "Fit a plane to the newest depth image and say how flat it is");
  command
      ->add_option("--device", options->device,
                   "In place of images, a board that decodes: ring:NAME, file:PATH; until it ends, --count or Ctrl-C")
      ->type_name("URI");
  command->add_option("--count", options->count, "Device: so many code images")->check(CLI::PositiveNumber);
  command->add_option("--out", options->out, "Folder for the results")->type_name("DIR")->required();
  command->add_option("IMAGE", options->images, "8-bit images of one size")->type_name("FILE");
  command->callback([options] { run_depth(*options); });
}

}  // namespace selfproj
