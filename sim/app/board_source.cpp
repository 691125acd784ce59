#include "sim/app/board_source.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/notes.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "host/light_section/line_finder.h"
#include "selfproj/driver/counters.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::sim {
namespace {

// What the options say; the rest as `measure` has it.
model::Measure measure_of(const BoardSource& options, model::Measure measure) {
  if (!options.mode.empty()) {
    measure.mode = images::mode_of(options.mode);
  }
  measure.threshold = options.threshold.value_or(measure.threshold);
  if (measure.threshold >= 1 << measure.bits) {
    throw UserError(fmt::format("--threshold {}", measure.threshold),
                    fmt::format("pixels of {} bits are {} at most", measure.bits, (1 << measure.bits) - 1));
  }
  options.select.apply(measure);
  return measure;
}

constexpr model::Measure kWithoutRig{.mode = model::Mode::grey_over, .threshold = 60};

images::PreparedSensorImages images_of(const BoardSource& options) {
  return {images::files_of_patterns("--images", options.images),
          {.pixels = options.pixels, .bits = pixel_bits_of(options)}};
}

PacketRecording make_line(const BoardSource& options) {
  const auto [rows, columns] =
      images::size_of_text("--line", options.line, std::max(spec::kColumnLimit, spec::kRowLimit));
  if (columns > spec::kColumnLimit || columns % spec::kPixelsPerBeat != 0 || rows > spec::kRowLimit) {
    throw UserError("--line " + options.line,
                    fmt::format("is not an image size such as 512x96: columns a multiple of {} up to {}, rows up to {}",
                                spec::kPixelsPerBeat, spec::kColumnLimit, spec::kRowLimit));
  }
  return moving_line(rows, columns, options.line_frames, measure_of(options, kWithoutRig));
}

PacketRecording make_images(const BoardSource& options, std::uint64_t frames) {
  constexpr int kDefaultThreshold = 5;
  const bool codes = options.bits > 0;
  images::PreparedSensorImages images = images_of(options);
  const int patterns = codes ? 2 * options.bits : 1;
  if (codes && frames > images.count() && images.count() % static_cast<std::size_t>(patterns) != 0) {
    throw UserError("--images", fmt::format("{} images are no whole number of the {} patterns of --bits {}, and cannot "
                                            "be repeated",
                                            images.count(), patterns, options.bits));
  }
  const int rows = images.rows();
  const int columns = images.columns();
  const int bits = pixel_bits_of(options);
  const int most_rows = model::row_limit(bits);
  if (rows > most_rows || columns > spec::kColumnLimit || columns % spec::kPixelsPerBeat != 0) {
    throw UserError(images.files().front(), fmt::format("is {}; the board takes columns that are a multiple of {}, up "
                                                        "to {}, and up to {} rows with pixels of {} bits",
                                                        images::size_text(rows, columns), spec::kPixelsPerBeat,
                                                        spec::kColumnLimit, most_rows, bits));
  }
  rig::RigMeasure said;
  said.apply(kWithoutRig);
  if (!options.rig.empty() && !codes) {
    said = rig::load_rig(options.rig).measure;
  }
  const model::Measure measure = measure_of(options, said.of_board());
  const model::BoardSettings settings{.image = !codes,
                                      .columns = columns,
                                      .rows = rows,
                                      .mode = measure.mode,
                                      .threshold = measure.threshold,
                                      .select = measure.select,
                                      .gap = measure.gap,
                                      .window = measure.window,
                                      .compact = said.sends_compact(),
                                      .codes = codes,
                                      .code_bits = codes ? options.bits : 1,
                                      .code_threshold = options.code_threshold.value_or(kDefaultThreshold)};
  images::SensorImage image;
  cli::Progress progress("image", images.count());
  return recording_of_images(settings, measure.bits, images.count(), patterns, [&](std::size_t i) {
    image = images.frame(i);
    progress.update(i + 1);
    return light_section::view_of(image);
  });
}

}  // namespace

int pixel_bits_of(const BoardSource& options) {
  if (options.rig.empty()) {
    return spec::kPixelBits;
  }
  const rig::Rig rig = rig::load_any_rig(options.rig);
  if (options.bits > 0) {
    rig::need_eight_bits(rig, options.rig, "--bits");
  }
  return rig.measure.bits();
}

double counts_per_image(const BoardSource& options) {
  if (options.rig.empty()) {
    return 0;
  }
  const rig::Rig rig = rig::load_rig(options.rig);
  if (!(rig.conveyor.encoder_mm_per_count > 0)) {
    throw UserError("--rig " + options.rig, "the belt has no encoder (conveyor.encoder_mm_per_count)");
  }
  return rig.conveyor.speed_mm_per_s / rig.camera.sent().frame_rate_hz / rig.conveyor.encoder_mm_per_count;
}

std::vector<images::SensorImage> read_sensor_images(const BoardSource& options) {
  constexpr std::size_t kMost = 4'000'000'000;  // bytes; they are held in memory
  images::PreparedSensorImages images = images_of(options);
  const std::size_t bytes = pixel_bits_of(options) > spec::kPixelBits ? 2 : 1;
  if (bytes * static_cast<std::size_t>(images.rows()) * static_cast<std::size_t>(images.columns()) * images.count() >
      kMost) {
    throw UserError("--images", "are more than 4 GB; they are held in memory");
  }
  std::vector<images::SensorImage> all;
  cli::Progress progress("image", images.count());
  for (std::size_t i = 0; i < images.count(); ++i) {
    all.push_back(images.frame(i));
    progress.update(i + 1);
  }
  return all;
}

PacketRecording read_source(const BoardSource& options, std::uint64_t frames) {
  if ((options.replay.empty() ? 0 : 1) + (options.line.empty() ? 0 : 1) + (options.images.empty() ? 0 : 1) != 1) {
    throw UserError("--replay, --line, --images", "give one of them");
  }
  const std::string of_images = options.bits > 0         ? "--bits"
                                : options.code_threshold ? "--code-threshold"
                                : !options.rig.empty()   ? "--rig"
                                                         : options.pixels.given();
  if (options.images.empty() && !of_images.empty()) {
    throw UserError(of_images, "goes only with --images");
  }
  if (!options.images.empty()) {
    PacketRecording recording = make_images(options, frames);
    recording.count_encoder(counts_per_image(options));
    return recording;
  }
  if (!options.line.empty()) {
    return make_line(options);
  }
  driver::Counters counters;
  PacketRecording recording = read_recording(options.replay, counters);
  const std::string reference = light_section::reference_file_of(options.replay);
  std::error_code unused;
  if (std::filesystem::exists(reference, unused)) {
    files::note(fmt::format("{}: was taken under the reference {}; name it to `selfproj inspect --reference`",
                            options.replay, reference));
  }
  if (counters.bad + counters.missing + counters.bytes_discarded > 0) {
    fmt::print(stderr, "selfproj-sim: {}: {} bad packets and {} missing frames in the recording are left out\n",
               options.replay, counters.bad, counters.missing);
  }
  return recording;
}

void add_source_options(CLI::App& command, BoardSource& options) {
  cli::begin_group(command, "Source (one of --replay, --images and --line is required)");
  command
      .add_option("--replay", options.replay,
                  "Recorded packets, of --record or of `selfproj-sim cosim --packets`. Bad ones are left out.")
      ->type_name("FILE");
  cli::add_files(
      command, "--images", options.images,
      "Recorded images of one size, of 8 bits or of the rig's. The model of the board sends their moments and "
      "the images themselves, line by line; with --bits the codes that it decodes.");
  command.add_flag(
      "--sensor", options.sensor,
      "With --images and --control: they are images of the whole sensor, and the camera sends the part that "
      "the registers `region` and `size` say. It is measured as the registers say. The board begins when a "
      "host starts it and ends when one stops it.");
  command
      .add_option(
          "--rig", options.rig,
          "With --images: the rig that they are of. The encoder counts as its belt moves from image to image, "
          "at the rig's frame rate, whatever --rate says. They are measured as it says (measure) where no option "
          "says otherwise.")
      ->type_name("RIG")
      ->default_str("the encoder stands still");
  command
      .add_option("--bits", options.bits,
                  "With --images: bits M of their Gray code. Image k shows pattern k modulo 2M.")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->type_name("M")
      ->default_str("the images are not decoded");
  command
      .add_option("--code-threshold", options.code_threshold,
                  "With --bits: a pair of images that differs by at most this many grey levels is ambiguous.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->default_str("5");
  cli::add_pixel_options(command, options.pixels);
  command
      .add_option("--line", options.line,
                  "A line of light that moves in frames of this size, in pixels, sent through the model of the board.")
      ->type_name("WxH");
  command.add_option("--mode", options.mode, "With --line and --images: what a lit pixel weighs.")
      ->check(cli::one_of(images::mode_names()))
      ->type_name("MODE")
      ->default_str("the rig's, or grey-over");
  command
      .add_option("--threshold", options.threshold,
                  "With --line and --images: a pixel is lit where its grey value is greater.")
      ->transform(cli::whole_number(0, 4095))
      ->type_name("T")
      ->default_str("the rig's, or 60");
  cli::add_select_options(command, options.select);
  command.add_option("--line-frames", options.line_frames, "With --line: frames until the line is where it began.")
      ->transform(cli::whole_number(1, 100000))
      ->type_name("N")
      ->capture_default_str();
}

}  // namespace selfproj::sim
