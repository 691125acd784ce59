#include <fmt/format.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>
#include <vector>

#include "host/camera/frame_numbers.h"
#include "host/camera/open_camera.h"
#include "host/camera/pixel_format.h"
#include "host/driver/clock.h"
#include "host/files/file_descriptor.h"
#include "host/images/natural_order.h"
#include "selfproj/files/user_error.h"

namespace selfproj::camera {
namespace {

struct FourCc {
  std::string_view name;
  std::uint32_t code;
};

constexpr std::array<FourCc, 12> kFourCcs = {{{"Mono8", V4L2_PIX_FMT_GREY},
                                              {"Mono10", V4L2_PIX_FMT_Y10},
                                              {"Mono12", V4L2_PIX_FMT_Y12},
                                              {"Mono16", V4L2_PIX_FMT_Y16},
                                              {"BayerRG8", V4L2_PIX_FMT_SRGGB8},
                                              {"BayerGR8", V4L2_PIX_FMT_SGRBG8},
                                              {"BayerGB8", V4L2_PIX_FMT_SGBRG8},
                                              {"BayerBG8", V4L2_PIX_FMT_SBGGR8},
                                              {"YUV422_8", V4L2_PIX_FMT_YUYV},
                                              {"YUV422_8_UYVY", V4L2_PIX_FMT_UYVY},
                                              {"RGB8", V4L2_PIX_FMT_RGB24},
                                              {"BGR8", V4L2_PIX_FMT_BGR24}}};

constexpr std::uint32_t kCapture = V4L2_BUF_TYPE_VIDEO_CAPTURE;

std::string text_of_array(const __u8* text, std::size_t size) {
  std::string out(reinterpret_cast<const char*>(text), size);
  return out.substr(0, out.find('\0'));
}

// What the device says of itself, if it gives images through mapped memory.
std::optional<v4l2_capability> capability_of(driver::DevicePort& port) {
  v4l2_capability capability{};
  if (port.control(VIDIOC_QUERYCAP, &capability) != 0) {
    return std::nullopt;
  }
  const std::uint32_t caps =
      (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0 ? capability.device_caps : capability.capabilities;
  constexpr std::uint32_t kNeeded = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
  return (caps & kNeeded) == kNeeded ? std::optional(capability) : std::nullopt;
}

class V4l2Camera final : public FormattedCamera {
 public:
  V4l2Camera(const CameraUri& uri, std::unique_ptr<driver::DevicePort> port)
      : FormattedCamera(uri, uri.camera), port_(std::move(port)) {
    if (!capability_of(*port_)) {
      throw UserError(uri_, "gives no images through the interface V4L2");
    }
    if (!settings_.trigger.empty() && settings_.trigger != "free") {
      throw UserError(uri_, "trigger: cameras of V4L2 run free");
    }
    if (settings_.packet_bytes) {
      throw UserError(uri_, "packet-bytes: this is not a GigE camera");
    }
    try {
      choose_format();
      set_size();
      set_rate();
      set_controls();
      map_buffers();
    } catch (...) {
      restore();
      throw;
    }
  }

  ~V4l2Camera() override {
    static_cast<void>(stream_off());
    restore();
  }

  void start() override {
    stop();
    counters_ = {};
    numbers_ = FrameNumbers(0, std::uint64_t{1} << 32U);
    last_time_ = 0;
    for (std::uint32_t i = 0; i < buffers_.size(); ++i) {
      give(i);
    }
    std::uint32_t type = kCapture;
    check(port_->control(VIDIOC_STREAMON, &type), "cannot be started");
    running_ = true;
  }

  void stop() override {
    held_.reset();
    check(stream_off(), "cannot be stopped");
  }

  void trigger() override { throw std::logic_error("camera: V4L2 has no software trigger"); }
  void forget_trigger() override {}

  bool next(CameraImage& image, std::chrono::nanoseconds timeout) override {
    if (held_) {
      give(*std::exchange(held_, std::nullopt));
    }
    const std::int64_t started = driver::now_ns();
    for (;;) {
      v4l2_buffer buffer{};
      buffer.type = kCapture;
      buffer.memory = V4L2_MEMORY_MMAP;
      const int error = port_->control(VIDIOC_DQBUF, &buffer);
      if (error == 0) {
        if (describe_buffer(buffer, image)) {
          return true;
        }
        continue;
      }
      if (error != EAGAIN) {
        check(error, error == ENODEV ? "the camera has gone" : "no further image");
      }
      const std::int64_t rest = timeout.count() - (driver::now_ns() - started);
      if (rest <= 0 || !port_->wait(std::chrono::nanoseconds(rest))) {
        return false;
      }
    }
  }

 private:
  void check(int error, const std::string& what) const {
    if (error != 0) {
      throw UserError(uri_, what + ": " + files::error_text(error));
    }
  }

  [[nodiscard]] bool offers(std::uint32_t code) {
    v4l2_fmtdesc description{};
    description.type = kCapture;
    for (; port_->control(VIDIOC_ENUM_FMT, &description) == 0; ++description.index) {
      if (description.pixelformat == code) {
        return true;
      }
    }
    return false;
  }

  void choose_format() {
    const std::vector<std::string> wanted = settings_.format.empty()
                                                ? std::vector<std::string>{"Mono8", "YUV422_8", "YUV422_8_UYVY"}
                                                : std::vector<std::string>{settings_.format};
    std::vector<std::string> there;
    for (const FourCc& one : kFourCcs) {
      if (offers(one.code)) {
        there.emplace_back(one.name);
      }
    }
    const auto found = std::find_if(wanted.begin(), wanted.end(), [&](const std::string& name) {
      return std::find(there.begin(), there.end(), name) != there.end();
    });
    if (found == wanted.end()) {
      throw UserError(
          uri_, fmt::format("format: it has not {}; it has {}", fmt::join(wanted, " or "),
                            there.empty() ? "none that is known here" : fmt::format("{}", fmt::join(there, ", "))));
    }
    format_ = *pixel_format(*found);
  }

  void set_size() {
    v4l2_format format{};
    format.type = kCapture;
    check(port_->control(VIDIOC_G_FMT, &format), "format");
    const auto* const code =
        std::find_if(kFourCcs.begin(), kFourCcs.end(), [&](const FourCc& one) { return one.name == format_.name; });
    format.fmt.pix.pixelformat = code->code;
    format.fmt.pix.field = V4L2_FIELD_NONE;
    format.fmt.pix.bytesperline = 0;
    if (const auto& region = settings_.region) {
      if (region->left != 0 || region->top != 0) {
        v4l2_selection selection{};
        selection.type = kCapture;
        selection.target = V4L2_SEL_TGT_CROP;
        selection.r = {region->left, region->top, static_cast<std::uint32_t>(region->columns),
                       static_cast<std::uint32_t>(region->rows)};
        check(port_->control(VIDIOC_S_SELECTION, &selection), "region: it takes no part of the sensor");
      }
      format.fmt.pix.width = static_cast<std::uint32_t>(region->columns);
      format.fmt.pix.height = static_cast<std::uint32_t>(region->rows);
    }
    check(port_->control(VIDIOC_S_FMT, &format), "format");
    raw_columns_ = static_cast<int>(format.fmt.pix.width);
    raw_rows_ = static_cast<int>(format.fmt.pix.height);
    check_region();
    stride_ = std::max<std::size_t>(format.fmt.pix.bytesperline, line_bytes(format_, raw_columns_));
    if (format.fmt.pix.pixelformat != code->code) {
      throw UserError(uri_, "format: the camera took another one");
    }
  }

  void set_rate() {
    if (!settings_.rate) {
      return;
    }
    v4l2_streamparm parameters{};
    parameters.type = kCapture;
    parameters.parm.capture.timeperframe = {1000, static_cast<std::uint32_t>(std::lround(*settings_.rate * 1000))};
    check(port_->control(VIDIOC_S_PARM, &parameters), "rate");
  }

  // Sets a control, and remembers what it was. Returns false if the camera does not have it.
  bool set_control(std::uint32_t id, std::int32_t value, const char* what) {
    v4l2_queryctrl range{};
    range.id = id;
    if (port_->control(VIDIOC_QUERYCTRL, &range) != 0 || (range.flags & V4L2_CTRL_FLAG_DISABLED) != 0) {
      return false;
    }
    if (value < range.minimum || value > range.maximum) {
      throw UserError(uri_, fmt::format("{}: the camera takes {} to {}{}", what, range.minimum, range.maximum,
                                        id == V4L2_CID_EXPOSURE_ABSOLUTE ? " times 100 microseconds" : ""));
    }
    v4l2_control control{id, 0};
    if (port_->control(VIDIOC_G_CTRL, &control) == 0) {
      before_.emplace_back(id, control.value);
    }
    control.value = value;
    check(port_->control(VIDIOC_S_CTRL, &control), what);
    return true;
  }

  void set_controls() {
    set_control(V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_MANUAL, "automatic exposure");
    set_control(V4L2_CID_AUTOGAIN, 0, "automatic gain");
    set_control(V4L2_CID_AUTO_WHITE_BALANCE, 0, "automatic white balance");
    if (settings_.exposure_us &&
        !set_control(V4L2_CID_EXPOSURE_ABSOLUTE, static_cast<std::int32_t>(std::lround(*settings_.exposure_us / 100)),
                     "exposure-us")) {
      throw UserError(uri_, "exposure-us: the camera has no such setting");
    }
    if (settings_.gain &&
        !set_control(V4L2_CID_GAIN, static_cast<std::int32_t>(std::lround(*settings_.gain)), "gain")) {
      throw UserError(uri_, "gain: the camera has no such setting");
    }
  }

  void restore() {
    for (auto one = before_.rbegin(); one != before_.rend(); ++one) {
      v4l2_control control{one->first, one->second};
      static_cast<void>(port_->control(VIDIOC_S_CTRL, &control));  // a camera that has gone cannot be set back
    }
  }

  void map_buffers() {
    v4l2_requestbuffers request{};
    request.count = static_cast<std::uint32_t>(std::min(settings_.buffers, static_cast<int>(VIDEO_MAX_FRAME)));
    request.type = kCapture;
    request.memory = V4L2_MEMORY_MMAP;
    check(port_->control(VIDIOC_REQBUFS, &request), "memory of images");
    for (std::uint32_t i = 0; i < request.count; ++i) {
      v4l2_buffer buffer{};
      buffer.index = i;
      buffer.type = kCapture;
      buffer.memory = V4L2_MEMORY_MMAP;
      check(port_->control(VIDIOC_QUERYBUF, &buffer), "memory of images");
      const std::uint8_t* const bytes = port_->map(buffer.length, buffer.m.offset);
      if (bytes == nullptr) {
        throw UserError(uri_, "memory of images: " + files::error_text(errno));
      }
      buffers_.emplace_back(bytes, buffer.length);
    }
    if (buffers_.empty()) {
      throw UserError(uri_, "memory of images: the driver has none");
    }
  }

  void give(std::uint32_t index) {
    v4l2_buffer buffer{};
    buffer.index = index;
    buffer.type = kCapture;
    buffer.memory = V4L2_MEMORY_MMAP;
    const int error = port_->control(VIDIOC_QBUF, &buffer);
    check(error, error == ENODEV ? "the camera has gone" : "memory of images");
  }

  int stream_off() {
    if (!std::exchange(running_, false)) {
      return 0;
    }
    std::uint32_t type = kCapture;
    const int error = port_->control(VIDIOC_STREAMOFF, &type);
    return error == ENODEV ? 0 : error;
  }

  // Describes the image of the buffer. Returns false, and gives the buffer back, if it should not be given out.
  bool describe_buffer(const v4l2_buffer& buffer, CameraImage& image) {
    const std::optional<std::uint64_t> number = numbers_.accept(buffer.sequence);
    counters_.dropped = numbers_.dropped();
    if (!number || buffer.index >= buffers_.size()) {
      ++counters_.late;
      give(buffer.index);
      return false;
    }
    held_ = buffer.index;
    const auto& raw = buffers_[buffer.index];
    const std::size_t size = std::min<std::size_t>(buffer.bytesused, raw.size());
    const std::size_t needed = (static_cast<std::size_t>(raw_rows_) - 1) * stride_ + line_bytes(format_, raw_columns_);
    image.number = *number;
    describe(image, raw.first(size), stride_, (buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && size >= needed);
    const std::int64_t now = driver::now_ns();
    const bool monotonic = (buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) == V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
    const std::int64_t taken =
        monotonic ? std::int64_t{buffer.timestamp.tv_sec} * 1'000'000'000 + buffer.timestamp.tv_usec * 1000 : now;
    last_time_ = std::max(last_time_, taken);
    image.time_ns = last_time_;
    image.arrival_ns = std::min(taken, now);
    return true;
  }

  std::unique_ptr<driver::DevicePort> port_;
  std::size_t stride_ = 0;
  std::vector<std::pair<std::uint32_t, std::int32_t>> before_;  // controls as they were found
  std::vector<std::span<const std::uint8_t>> buffers_;
  std::optional<std::uint32_t> held_;
  bool running_ = false;
};

}  // namespace

std::vector<CameraEntry> list_v4l2_cameras() {
  std::vector<std::string> paths;
  std::error_code error;
  for (const auto& entry : std::filesystem::directory_iterator("/dev", error)) {
    if (entry.path().filename().string().starts_with("video")) {
      paths.push_back(entry.path().string());
    }
  }
  std::sort(paths.begin(), paths.end(), images::natural_less);
  std::vector<CameraEntry> cameras;
  for (const std::string& path : paths) {
    CameraEntry place{.uri = "camera:" + path, .kind = "V4L2", .model = "", .address = path, .problem = ""};
    try {
      const std::unique_ptr<driver::DevicePort> port = driver::open_device_port(path, "camera:" + path);
      const std::optional<v4l2_capability> capability = capability_of(*port);
      if (!capability) {
        continue;
      }
      place.model = text_of_array(capability->card, sizeof capability->card);
    } catch (const UserError& problem) {
      place.problem = problem.what();
    }
    cameras.push_back(place);
  }
  return cameras;
}

std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri, std::unique_ptr<driver::DevicePort> port) {
  return std::make_unique<V4l2Camera>(uri, std::move(port));
}

std::unique_ptr<Camera> open_v4l2_camera(const CameraUri& uri) {
  return open_v4l2_camera(uri, driver::open_device_port(uri.name, "camera:" + uri.name));
}

}  // namespace selfproj::camera
