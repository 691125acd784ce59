#include <arv.h>
#include <fmt/format.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/camera/frame_numbers.h"
#include "host/camera/open_camera.h"
#include "host/camera/pixel_format.h"
#include "host/driver/clock.h"
#include "selfproj/files/user_error.h"

namespace selfproj::camera {
namespace {

struct Unref {
  void operator()(gpointer object) const { g_object_unref(object); }
};
template <class T>
using Owned = std::unique_ptr<T, Unref>;

// The error argument of a call: `call(..., error)`, then `error.check("exposure")`.
class GlibError {
 public:
  explicit GlibError(std::string uri) : uri_(std::move(uri)) {}
  GlibError(const GlibError&) = delete;
  GlibError& operator=(const GlibError&) = delete;
  ~GlibError() { g_clear_error(&error_); }

  // NOLINTNEXTLINE(google-explicit-constructor): so that it stands where Aravis wants a GError**
  operator GError**() {
    g_clear_error(&error_);
    return &error_;
  }

  [[nodiscard]] bool set() const { return error_ != nullptr; }

  // Whether the device did not answer, several times.
  [[nodiscard]] bool no_answer() const {
    return g_error_matches(error_, arv_device_error_quark(), ARV_DEVICE_ERROR_TIMEOUT) != FALSE;
  }

  void check(const std::string& what) const {
    if (set()) {
      throw UserError(uri_, what + ": " + error_->message);
    }
  }

 private:
  std::string uri_;
  GError* error_ = nullptr;
};

std::string text_of(const char* text) { return text == nullptr ? "" : text; }

// Enumerations of the camera that are changed while it is open, and their values before.
class Remembered {
 public:
  explicit Remembered(ArvCamera* camera) : camera_(camera) {}
  Remembered(const Remembered&) = delete;
  Remembered& operator=(const Remembered&) = delete;

  ~Remembered() {
    for (auto one = values_.rbegin(); one != values_.rend(); ++one) {
      GError* ignored = nullptr;
      arv_camera_set_string(camera_, one->first.c_str(), one->second.c_str(), &ignored);
      g_clear_error(&ignored);
    }
  }

  // A camera that has gone cannot be set back, and each try would wait for an answer.
  void forget() { values_.clear(); }

  void note(const char* feature) {
    GError* ignored = nullptr;
    if (arv_camera_is_feature_available(camera_, feature, &ignored) != FALSE) {
      const char* const value = arv_camera_get_string(camera_, feature, &ignored);
      if (ignored == nullptr && value != nullptr) {
        values_.emplace_back(feature, value);
      }
    }
    g_clear_error(&ignored);
  }

 private:
  ArvCamera* camera_;
  std::vector<std::pair<std::string, std::string>> values_;
};

Owned<ArvCamera> open_by_name(const CameraUri& uri) {
  if (uri.name.starts_with("Fake_")) {
    arv_enable_interface("Fake");
  }
  GlibError error(uri.uri);
  Owned<ArvCamera> camera(arv_camera_new(uri.name.c_str(), error));
  if (error.set() || !camera) {
    error.check("cannot be opened");
    throw UserError(uri.uri, "there is no such camera; `selfproj devices` lists them");
  }
  return camera;
}

class AravisCamera final : public FormattedCamera {
 public:
  explicit AravisCamera(const CameraUri& uri)
      : FormattedCamera(uri, with_defaults(uri.camera)), camera_(open_by_name(uri)), before_(camera_.get()) {
    format_ = *pixel_format(settings_.format);
    gone_handler_ = g_signal_connect_data(arv_camera_get_device(camera_.get()), "control-lost",
                                          reinterpret_cast<GCallback>(note_gone), &gone_, nullptr, G_CONNECT_DEFAULT);
    try {
      apply_settings();
      make_stream();
    } catch (...) {
      disconnect();
      throw;
    }
  }

  ~AravisCamera() override {
    AravisCamera::stop();
    stream_.reset();
    disconnect();
    if (gone_) {
      before_.forget();
    }
  }

  void start() override {
    stop();
    counters_ = {};
    numbers_ = fresh_numbers();
    last_time_ = 0;
    pending_ = false;
    GlibError error(uri_);
    arv_camera_start_acquisition(camera_.get(), error);
    error.check("cannot be started");
    running_ = true;
  }

  void stop() override {
    give_back();
    if (!running_) {
      return;
    }
    running_ = false;
    if (!gone_) {
      GlibError error(uri_);
      arv_camera_stop_acquisition(camera_.get(), error);
    }
    // What still came belongs to no run.
    while (ArvBuffer* const buffer = arv_stream_try_pop_buffer(stream_.get())) {
      arv_stream_push_buffer(stream_.get(), buffer);
    }
  }

  void trigger() override {
    if (pending_) {
      throw std::logic_error("camera: a trigger is under way");
    }
    check_gone();
    GlibError error(uri_);
    arv_camera_software_trigger(camera_.get(), error);
    if (error.no_answer()) {
      gone_ = true;
      check_gone();
    }
    error.check("the software trigger failed");
    pending_ = true;
  }

  void forget_trigger() override { pending_ = false; }

  bool next(CameraImage& image, std::chrono::nanoseconds timeout) override {
    give_back();
    const std::int64_t started = driver::now_ns();
    for (;;) {
      const std::int64_t rest = std::max<std::int64_t>(timeout.count() - (driver::now_ns() - started), 0);
      held_ = rest < 1000 ? arv_stream_try_pop_buffer(stream_.get())
                          : arv_stream_timeout_pop_buffer(stream_.get(), static_cast<guint64>(rest / 1000));
      if (held_ == nullptr) {
        check_gone();
        return false;
      }
      if (describe_held(image)) {
        pending_ = false;
        return true;
      }
      give_back();
    }
  }

 private:
  static CameraParameters with_defaults(CameraParameters settings) {
    settings.format = settings.format.empty() ? "Mono8" : settings.format;
    settings.trigger = settings.trigger.empty() ? "free" : settings.trigger;
    return settings;
  }

  static void note_gone(ArvDevice* /*device*/, gpointer gone) { static_cast<std::atomic<bool>*>(gone)->store(true); }

  void disconnect() { g_signal_handler_disconnect(arv_camera_get_device(camera_.get()), gone_handler_); }

  void check_gone() const {
    if (gone_) {
      throw UserError(uri_, "the camera has gone: it no longer answers");
    }
  }

  // GigE Vision counts blocks from 1 to 65,535 unless it uses its extended numbers; USB3 Vision has 64 bits.
  [[nodiscard]] FrameNumbers fresh_numbers() const {
    GlibError error(uri_);
    const bool usb = arv_camera_is_uv_device(camera_.get()) != FALSE;
    bool extended = false;
    if (!usb && arv_camera_is_feature_available(camera_.get(), "GevGVSPExtendedIDMode", error) != FALSE) {
      extended = text_of(arv_camera_get_string(camera_.get(), "GevGVSPExtendedIDMode", error)) == "On";
    }
    return usb || extended ? FrameNumbers(0, 0) : FrameNumbers(1, UINT16_MAX);
  }

  void apply_settings() {
    ArvCamera* const camera = camera_.get();
    GlibError error(uri_);
    for (const char* feature :
         {"AcquisitionMode", "ExposureAuto", "GainAuto", "TriggerSelector", "TriggerSource", "TriggerMode"}) {
      before_.note(feature);
    }
    arv_camera_set_acquisition_mode(camera, ARV_ACQUISITION_MODE_CONTINUOUS, error);
    error.check("acquisition mode");
    if (arv_camera_is_exposure_auto_available(camera, error) != FALSE) {
      arv_camera_set_exposure_time_auto(camera, ARV_AUTO_OFF, error);
      error.check("automatic exposure");
    }
    if (arv_camera_is_gain_auto_available(camera, error) != FALSE) {
      arv_camera_set_gain_auto(camera, ARV_AUTO_OFF, error);
      error.check("automatic gain");
    }
    arv_camera_set_pixel_format_from_string(camera, settings_.format.c_str(), error);
    error.check("format " + settings_.format);
    set_region();
    set_within("exposure-us", settings_.exposure_us, arv_camera_get_exposure_time_bounds, arv_camera_set_exposure_time);
    set_within("gain", settings_.gain, arv_camera_get_gain_bounds, arv_camera_set_gain);
    set_trigger();
    if (settings_.packet_bytes) {
      if (arv_camera_is_gv_device(camera) == FALSE) {
        throw UserError(uri_, "packet-bytes: this is not a GigE camera");
      }
      arv_camera_gv_set_packet_size(camera, *settings_.packet_bytes, error);
      error.check("packet-bytes");
    }
  }

  void set_region() {
    ArvCamera* const camera = camera_.get();
    GlibError error(uri_);
    if (const auto& region = settings_.region) {
      int width = 0;
      int height = 0;
      arv_camera_get_sensor_size(camera, &width, &height, error);
      if (!error.set() && (region->left + region->columns > width || region->top + region->rows > height)) {
        throw UserError(uri_, fmt::format("region: is beyond the sensor, which has {} x {} pixels", width, height));
      }
      arv_camera_set_region(camera, region->left, region->top, region->columns, region->rows, error);
      error.check("region");
    }
    int left = 0;
    int top = 0;
    arv_camera_get_region(camera, &left, &top, &raw_columns_, &raw_rows_, error);
    error.check("region");
    check_region();
    const bool packed = format_.layout == Layout::packed_lsb || format_.layout == Layout::packed_gige;
    if (packed && raw_columns_ % 4 != 0) {
      throw UserError(uri_, "format " + settings_.format + ": needs a multiple of 4 columns");
    }
  }

  template <class Bounds, class Set>
  void set_within(const char* what, const std::optional<double>& value, Bounds bounds, Set set) {
    if (!value) {
      return;
    }
    GlibError error(uri_);
    double min = 0;
    double max = 0;
    bounds(camera_.get(), &min, &max, error);
    error.check(what);
    if (*value < min || *value > max) {
      throw UserError(uri_, fmt::format("{}: the camera takes {:g} to {:g}", what, min, max));
    }
    set(camera_.get(), *value, error);
    error.check(what);
  }

  void set_trigger() {
    GlibError error(uri_);
    if (settings_.trigger == "free") {
      arv_camera_clear_triggers(camera_.get(), error);
      error.check("trigger");
      if (settings_.rate) {
        set_within("rate", settings_.rate, arv_camera_get_frame_rate_bounds, arv_camera_set_frame_rate);
      }
      return;
    }
    if (settings_.rate) {
      throw UserError(uri_, "rate: the trigger determines it");
    }
    arv_camera_set_trigger(camera_.get(), settings_.trigger == "software" ? "Software" : settings_.trigger.c_str(),
                           error);
    error.check("trigger " + settings_.trigger);
  }

  void make_stream() {
    GlibError error(uri_);
    const unsigned payload = arv_camera_get_payload(camera_.get(), error);
    error.check("size of an image");
    stream_.reset(arv_camera_create_stream(camera_.get(), nullptr, nullptr, error));
    error.check("images");
    if (!stream_) {
      throw UserError(uri_, "it provides no stream of images");
    }
    for (int i = 0; i < settings_.buffers; ++i) {
      arv_stream_push_buffer(stream_.get(), arv_buffer_new_allocate(payload));
    }
  }

  // Describes the held buffer. Returns false if it is none that should be given out.
  bool describe_held(CameraImage& image) {
    const ArvBufferStatus status = arv_buffer_get_status(held_);
    if (status == ARV_BUFFER_STATUS_CLEARED || status == ARV_BUFFER_STATUS_ABORTED) {
      return false;
    }
    // Of an image whose first packet was lost the buffer has the number of an earlier one, or none.
    const std::optional<std::uint64_t> number = status == ARV_BUFFER_STATUS_SUCCESS
                                                    ? numbers_.accept(arv_buffer_get_frame_id(held_))
                                                    : std::optional(numbers_.guess());
    counters_.dropped = numbers_.dropped();
    if (!number) {
      ++counters_.late;
      return false;
    }
    std::size_t size = 0;
    const auto* const raw = static_cast<const std::uint8_t*>(arv_buffer_get_data(held_, &size));
    const std::size_t line = line_bytes(format_, raw_columns_);
    image.number = *number;
    describe(image, {raw, size}, line,
             status == ARV_BUFFER_STATUS_SUCCESS && raw != nullptr &&
                 arv_buffer_get_image_width(held_) == raw_columns_ && arv_buffer_get_image_height(held_) == raw_rows_ &&
                 size >= line * static_cast<std::size_t>(raw_rows_));
    const auto system = static_cast<std::int64_t>(arv_buffer_get_system_timestamp(held_));
    const auto camera = static_cast<std::int64_t>(arv_buffer_get_timestamp(held_));
    if (status == ARV_BUFFER_STATUS_SUCCESS) {  // otherwise its times may be old, too
      last_time_ = std::max(last_time_, camera != 0 ? camera : system);
    }
    image.time_ns = last_time_;
    const std::int64_t age = image.complete ? std::max<std::int64_t>(g_get_real_time() * 1000 - system, 0) : 0;
    image.arrival_ns = driver::now_ns() - age;
    return true;
  }

  void give_back() {
    if (held_ != nullptr) {
      arv_stream_push_buffer(stream_.get(), std::exchange(held_, nullptr));
    }
  }

  Owned<ArvCamera> camera_;
  Remembered before_;
  Owned<ArvStream> stream_;
  std::atomic<bool> gone_ = false;
  gulong gone_handler_ = 0;
  ArvBuffer* held_ = nullptr;  // the image given out
  bool running_ = false;
  bool pending_ = false;  // a trigger is under way
};

}  // namespace

bool has_aravis() { return true; }

std::vector<CameraEntry> list_aravis_cameras() {
  arv_update_device_list();
  std::vector<CameraEntry> cameras;
  for (unsigned i = 0; i < arv_get_n_devices(); ++i) {
    const std::string protocol = text_of(arv_get_device_protocol(i));
    cameras.push_back({.uri = "camera:" + text_of(arv_get_device_id(i)),
                       .kind = protocol == "GigEVision"   ? "GigE Vision"
                               : protocol == "USB3Vision" ? "USB3 Vision"
                                                          : protocol,
                       .model = text_of(arv_get_device_vendor(i)) + " " + text_of(arv_get_device_model(i)),
                       .address = text_of(arv_get_device_address(i)),
                       .problem = ""});
  }
  return cameras;
}

std::unique_ptr<Camera> open_aravis_camera(const CameraUri& uri) { return std::make_unique<AravisCamera>(uri); }

}  // namespace selfproj::camera
