#include "host/app/image_source.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/notes.h"
#include "host/files/stop_signal.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/fast_moments.h"

namespace selfproj::app {
namespace {

std::variant<images::PreparedImages, images::WidePreparedImages> prepared(const ImageSourceOptions& options, int bits) {
  std::vector<std::string> files = images::files_of_patterns("--images", options.images);
  images::Preparation preparation = options.preparation;
  preparation.background = images::files_of_patterns("--background", preparation.background);
  preparation.bits = bits;
  if (bits > spec::kPixelBits) {
    return images::WidePreparedImages(std::move(files), preparation);
  }
  return images::PreparedImages(std::move(files), preparation);
}

// The number at the end of a file's name without its suffix, and what stands before it.
struct Numbered {
  std::string before;
  std::uint64_t number = 0;
};

std::optional<Numbered> numbered(const std::string& file) {
  constexpr std::size_t kMaxDigits = 18;
  const std::string name = std::filesystem::path(file).replace_extension().string();
  const std::size_t end = name.find_last_not_of("0123456789") + 1;
  if (end == name.size() || name.size() - end > kMaxDigits) {
    return std::nullopt;
  }
  return Numbered{name.substr(0, end), std::stoull(name.substr(end))};
}

// Says the first place where numbers of files leave out more than elsewhere: the belt went on there.
std::string gap_in(const std::vector<std::string>& files) {
  std::uint64_t least = std::numeric_limits<std::uint64_t>::max();
  std::vector<std::uint64_t> steps;
  std::optional<Numbered> last;
  for (const std::string& file : files) {
    std::optional<Numbered> next = numbered(file);
    if (!next || (last && (next->before != last->before || next->number <= last->number))) {
      return "";
    }
    if (last) {
      steps.push_back(next->number - last->number);
      least = std::min(least, steps.back());
    }
    last = std::move(next);
  }
  const auto gap = std::find_if(steps.begin(), steps.end(), [&](std::uint64_t step) { return step != least; });
  if (gap == steps.end()) {
    return "";
  }
  const auto at = static_cast<std::size_t>(gap - steps.begin());
  return fmt::format(
      "numbers are missing between {} and {}, but the belt is taken to move as far as between any other two images",
      files[at], files[at + 1]);
}

void measure(const model::ImageView& image, const model::Measure& how, const model::RunsView& out) {
  if (image.rows > spec::kRowLimit) {
    model::measure_tall_columns(image, how, out);
  } else {
    light_section::fast_measure_columns(image, how, out);
  }
}
void measure(const model::WideImageView& image, const model::Measure& how, const model::RunsView& out) {
  light_section::fast_measure_columns(image, how, out);
}

}  // namespace

void add_image_source_options(CLI::App& command, ImageSourceOptions& options, CLI::Option* device) {
  cli::begin_group(command, "Recorded images");
  CLI::Option* const images =
      cli::add_files(command, "--images", options.images,
                     "Instead of a device, images of the line: files, a folder, a quoted pattern, or TIFFs of several "
                     "pages. This program measures them as the rig says. They may have more rows than a board takes.");
  images->excludes(device);
  const std::size_t first = command.get_options().size();
  cli::add_preparation_options(command, options.preparation);
  cli::add_files(command, "--background", options.preparation.background,
                 "The same view without the line: one image for all, or one for each. It is subtracted.");
  command.add_option("--mm-per-image", options.spacing_mm, "How far the belt moves from image to image.")
      ->transform(cli::real_number(0, 1e6))
      ->type_name("MM")
      ->default_str("by the rig's speed and frame rate");
  const std::vector<CLI::Option*> all = command.get_options();
  std::for_each(all.begin() + static_cast<std::ptrdiff_t>(first), all.end(),
                [&](CLI::Option* option) { option->needs(images); });
}

ImageSource::ImageSource(const ImageSourceOptions& options, const rig::Rig& rig, const model::Measure& measure)
    : images_(prepared(options, measure.bits)),
      rig_(rig),
      measure_(measure),
      sent_(rig.camera.sent()),
      spacing_mm_(options.spacing_mm.value_or(rig.conveyor.speed_mm_per_s / sent_.frame_rate_hz)),
      doubt_(std::visit([](const auto& images) { return images.count() > 1 ? gap_in(images.files()) : ""; }, images_)) {
  const rig::RigCamera& camera = rig.camera;
  const images::FrameSize size = std::visit(
      [](const auto& images) {
        return images::FrameSize{images.rows(), images.columns()};
      },
      images_);
  const auto has_size = [&](int rows, int columns) { return size.rows == rows && size.columns == columns; };
  if (!has_size(sent_.rows, sent_.columns) && !has_size(camera.rows, camera.columns)) {
    throw UserError(
        first(), fmt::format("is {}, but the camera of the rig {}{}; --roi takes a part, and --transpose exchanges "
                             "rows and columns",
                             images::size_text(size.rows, size.columns), images::size_text(camera.rows, camera.columns),
                             camera.region ? ", and its region " + images::size_text(sent_.rows, sent_.columns) : ""));
  }
  if (sent_.rows > model::kMaxSoftwareRows) {
    throw UserError(first(), fmt::format("has {} rows; at most {} are possible", sent_.rows, model::kMaxSoftwareRows));
  }
  if (rig.sources && rig.sources->speed != rig::ValueSource::assumed && !options.spacing_mm && count() > 1) {
    throw UserError(
        "--images",
        "nothing says how far the belt moves from one to the next, as the frame rate of a calibrated rig is "
        "the drawing's: say it with --mm-per-image");
  }
  if (sent_.rows > spec::kRowLimit) {
    files::note(fmt::format("{}: has {} rows and a board takes at most {}: this program alone measures them", first(),
                            sent_.rows, spec::kRowLimit));
  }
}

model::PacketHeader ImageSource::header_of(std::uint64_t image) const {
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  model::describe_frame(header, sent_.rows, sent_.columns, measure_);
  header.region_row = static_cast<std::uint16_t>(rig_.camera.region_row());
  header.region_column = static_cast<std::uint16_t>(rig_.camera.region_column());
  header.sequence = image;
  const double belt_mm = static_cast<double>(image) * spacing_mm_;
  const double speed = rig_.conveyor.speed_mm_per_s;
  const double seconds = speed > 0 ? belt_mm / speed : static_cast<double>(image) / sent_.frame_rate_hz;
  header.time_stamp = static_cast<std::uint64_t>(std::llround(seconds * rig_.pixel_clock_hz()));
  // Time stamps are finer than the counts of an encoder, which are rounded.
  if (!(speed > 0) || (rig_.parts && rig_.parts->by_encoder)) {
    header.encoder = static_cast<std::uint32_t>(std::llround(belt_mm / rig_.conveyor.encoder_mm_per_count));
  }
  return header;
}

void ImageSource::run(std::uint64_t most,
                      const std::function<void(const model::PacketHeader&, const model::RunsView&)>& take) {
  std::visit([&](auto& images) { run_of(images, most, take); }, images_);
}

template <typename Images>
void ImageSource::run_of(Images& images, std::uint64_t most,
                         const std::function<void(const model::PacketHeader&, const model::RunsView&)>& take) {
  const std::size_t count =
      most == 0 ? images.count() : static_cast<std::size_t>(std::min<std::uint64_t>(most, images.count()));
  const bool whole = images.rows() != sent_.rows || images.columns() != sent_.columns;  // of the sensor
  const files::StopSignal stop;
  model::Runs runs;
  runs.resize(measure_.select, sent_.columns);
  cli::Progress progress("image", count);
  for (std::size_t i = 0; i < count && !files::StopSignal::came(); ++i) {
    const auto image = images.frame(i);
    auto view = image.view();
    if (whole) {
      view = {view.pixels + static_cast<std::ptrdiff_t>(sent_.row_offset) * view.stride + sent_.column_offset,
              sent_.rows, sent_.columns, view.stride};
    }
    measure(view, measure_, runs.view());
    take(header_of(i), runs.view());
    progress.update(i + 1);
  }
}

}  // namespace selfproj::app
