#include "host/camera/camera_device.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include "host/camera/open_camera.h"
#include "host/camera/software_board.h"
#include "host/driver/clock.h"
#include "host/driver/device_kinds.h"
#include "selfproj/driver/counters.h"
#include "selfproj/driver/device.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::camera {
namespace {

model::BoardSettings board_settings(const Camera& camera, const CameraBoardSettings& given) {
  model::BoardSettings board;
  board.rows = camera.rows();
  board.columns = camera.columns();
  board.mode = given.mode.value_or(board.mode);
  board.threshold = given.threshold.value_or(board.threshold);
  board.select = given.select.value_or(board.select);
  board.gap = given.gap.value_or(board.gap);
  board.window = given.window.value_or(board.window);
  board.stream = given.stream.value_or(board.stream);
  board.region_row = given.region_row;
  board.region_column = given.region_column;
  board.compact = given.compact;
  board.codes = given.code_bits.has_value();
  board.code_bits = given.code_bits.value_or(board.code_bits);
  board.code_threshold = given.code_threshold.value_or(board.code_threshold);
  board.median = given.median;
  board.image = given.image;
  return board;
}

SoftwareBoard make_board(const Camera& camera, const CameraBoardSettings& given) {
  const int bits = given.bits.value_or(spec::kPixelBits);
  if (given.threshold.value_or(0) >= 1 << bits) {
    throw UserError(camera.uri(), fmt::format("the threshold is {}, and pixels have {} bits", *given.threshold, bits));
  }
  try {
    return SoftwareBoard(board_settings(camera, given), bits);
  } catch (const std::invalid_argument&) {
    throw UserError(camera.uri(),
                    fmt::format("its images have {} x {} pixels; a board takes 4 to {} columns, a multiple of 4, and 1 "
                                "to {} rows; choose a region",
                                camera.columns(), camera.rows(), spec::kColumnLimit, model::row_limit(bits)));
  }
}

class CameraDevice final : public driver::TalliedDevice {
 public:
  CameraDevice(std::unique_ptr<Camera> camera, const CameraBoardSettings& board, const driver::DeviceOptions& options)
      : driver::TalliedDevice(camera->uri(), options),
        camera_(std::move(camera)),
        board_(make_board(*camera_, board)),
        patterns_(static_cast<std::uint64_t>(board.patterns.value_or(board.code_bits ? 2 * *board.code_bits : 1))),
        clock_hz_(static_cast<std::uint64_t>(std::llround(board.pixel_clock_hz.value_or(model::kDefaultPixelClockHz)))),
        polls_(options.wait == driver::Wait::polling) {
    camera_->start();
  }

  driver::Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override {
    const std::int64_t started = driver::now_ns();
    for (;;) {
      while (board_.next(packet)) {
        if (tally_.deliver(packet)) {
          return driver::Next::packet;
        }
      }
      const std::chrono::nanoseconds rest(timeout.count() - (driver::now_ns() - started));
      CameraImage image;
      if (camera_->next(image, polls_ ? std::chrono::nanoseconds(0) : rest)) {
        submit(image);
      } else if (rest.count() <= 0 || !polls_) {
        return driver::Next::timeout;
      } else {
        driver::relax();
      }
    }
  }

 private:
  void submit(const CameraImage& image) {
    arrival_ns_ = image.arrival_ns;
    first_ns_ = first_ns_.value_or(image.time_ns);
    constexpr std::uint64_t kSecond = 1'000'000'000;
    const auto time = static_cast<std::uint64_t>(image.time_ns - *first_ns_);
    board_.process(image.view, image.complete, image.number,
                   {.clock = time / kSecond * clock_hz_ + time % kSecond * clock_hz_ / kSecond,
                    .encoder = 0,
                    .pattern = static_cast<std::uint16_t>(image.number % patterns_)},
                   image.wide);
  }

  std::unique_ptr<Camera> camera_;
  SoftwareBoard board_;
  std::uint64_t patterns_;
  std::uint64_t clock_hz_;
  bool polls_;
  std::optional<std::int64_t> first_ns_;
};

template <class T>
void fill(std::optional<T>& value, const std::optional<T>& by_default) {
  if (!value) {
    value = by_default;
  }
}

}  // namespace

std::unique_ptr<driver::Device> make_camera_device(std::unique_ptr<Camera> camera, const CameraBoardSettings& board,
                                                   const driver::DeviceOptions& options) {
  return std::make_unique<CameraDevice>(std::move(camera), board, options);
}

CameraDefaults camera_of_rig(const rig::Rig& rig, const model::Measure& measure) {
  const rig::RigRegion sent = rig.camera.sent();
  return {.region =
              images::ImagePart{
                  .columns = sent.columns, .rows = sent.rows, .left = sent.column_offset, .top = sent.row_offset},
          .board = {.mode = measure.mode,
                    .threshold = measure.threshold,
                    .select = measure.select,
                    .gap = measure.gap,
                    .window = measure.window,
                    .bits = measure.bits,
                    .region_row = rig.camera.region_row(),
                    .region_column = rig.camera.region_column(),
                    .compact = rig.measure.sends_compact(),
                    .pixel_clock_hz = rig.pixel_clock_hz()}};
}

void fill_from(CameraUri& camera, const CameraDefaults& defaults) {
  CameraBoardSettings& board = camera.board;
  if (!camera.camera.region) {
    camera.camera.region = defaults.region;
    board.region_row = defaults.board.region_row;
    board.region_column = defaults.board.region_column;
  }
  board.compact = defaults.board.compact;
  const char* const said_by = board.bits ? "bits of the URI are" : "measure.pixel_bits of the rig is";
  fill(board.bits, defaults.board.bits);
  if (const int bits = board.bits.value_or(spec::kPixelBits); bits > spec::kPixelBits) {
    std::string& format = camera.camera.format;
    if (format.empty()) {
      format = fmt::format("Mono{}", bits);
      if (!pixel_format(format)) {
        throw UserError(camera.uri, fmt::format("{} {}; cameras have pixels of 8, 10 or 12", said_by, bits));
      }
    }
    const std::optional<PixelFormat> known = pixel_format(format);
    if (!known || !has_words(*known) || known->bits != bits) {
      throw UserError(camera.uri, fmt::format("format: {} is given; {} {}", format, said_by, bits));
    }
    camera.camera.bits = bits;
  }
  fill(board.mode, defaults.board.mode);
  fill(board.threshold, defaults.board.threshold);
  fill(board.select, defaults.board.select);
  fill(board.gap, defaults.board.gap);
  fill(board.window, defaults.board.window);
  fill(board.pixel_clock_hz, defaults.board.pixel_clock_hz);
  fill(board.code_bits, defaults.board.code_bits);
  fill(board.code_threshold, defaults.board.code_threshold);
}

std::unique_ptr<driver::Device> open_any_device(const std::string& uri, const driver::DeviceOptions& options,
                                                const CameraDefaults& defaults) {
  if (!is_camera_uri(uri)) {
    return driver::open_device(uri, options);
  }
  CameraUri camera = parse_camera_uri(uri);
  const bool has_format = !camera.camera.format.empty();
  fill_from(camera, defaults);
  try {
    return make_camera_device(open_camera(camera), camera.board, options);
  } catch (const UserError& error) {
    const int bits = camera.camera.bits;
    if (bits == spec::kPixelBits || has_format ||
        std::string_view(error.what()).find(": format") == std::string_view::npos) {
      throw;
    }
    throw UserError(error.what(), fmt::format("pixels of {0} bits (measure.pixel_bits of the rig, or bits of the URI) "
                                              "ask for Mono{0}; format=Mono{0}p and format=Mono{0}Packed have as many",
                                              bits));
  }
}

}  // namespace selfproj::camera
