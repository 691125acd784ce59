#include "host/camera/camera_uri.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "host/camera/pixel_format.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::camera {
namespace {

constexpr int kMaxSide = 1 << 15;
constexpr int kMaxBuffers = 4096;
constexpr int kMinPacket = 220;  // of GigE Vision's 576 less what its header may need
constexpr int kMaxPacket = 16'000;
constexpr int kMaxPatterns = 1 << 16;

// Why a value is refused.
struct Refusal {
  std::string reason;
};

template <class T>
T number_in(const std::string& text, T min, T max) {
  const std::optional<T> value = files::number_of_text<T>(text);
  if (!value || *value < min || *value > max) {
    throw Refusal{
        fmt::format("is not a {} from {} to {}", std::is_integral_v<T> ? "whole number" : "number", min, max)};
  }
  return *value;
}

double positive(const std::string& text) {
  const std::optional<double> value = files::number_of_text<double>(text);
  if (!value || *value <= 0 || *value > 1e9) {
    throw Refusal{"is not a number above 0, up to 1e9"};
  }
  return *value;
}

bool yes(const std::string& text) {
  if (text != "yes" && text != "no") {
    throw Refusal{"is neither yes nor no"};
  }
  return text == "yes";
}

std::string name_in(const std::string& text, const std::vector<std::string>& names) {
  if (std::find(names.begin(), names.end(), text) == names.end()) {
    throw Refusal{fmt::format("is not one of {}", fmt::join(names, ", "))};
  }
  return text;
}

// "512x96", or "512x96+LEFT+TOP".
images::ImagePart region_of_text(const std::string& text) {
  const bool whole = text.find('+') == std::string::npos;
  const std::optional<images::ImagePart> region = images::image_part(whole ? text + "+0+0" : text, kMaxSide);
  if (!region) {
    throw Refusal{"is not a region such as 512x96 or 512x96+64+20"};
  }
  return *region;
}

struct Key {
  const char* name;
  const char* value;
  const char* meaning;
  void (*set)(CameraUri&, const std::string&);
};

constexpr std::array<Key, 22> kKeys = {{
    {"exposure-us", "NUMBER", "exposure time in microseconds",
     [](CameraUri& uri, const std::string& text) { uri.camera.exposure_us = positive(text); }},
    {"gain", "NUMBER", "gain, in the camera's unit",
     [](CameraUri& uri, const std::string& text) { uri.camera.gain = number_in(text, -1e6, 1e6); }},
    {"rate", "NUMBER", "images a second where nothing triggers the camera",
     [](CameraUri& uri, const std::string& text) { uri.camera.rate = positive(text); }},
    {"region", "COLUMNSxROWS[+LEFT+TOP]", "part of the sensor",
     [](CameraUri& uri, const std::string& text) { uri.camera.region = region_of_text(text); }},
    {"format", "NAME",
     "pixel format in GenICam's words; values of more than 8 bits give their upper 8 bits, or all of them with bits",
     [](CameraUri& uri, const std::string& text) { uri.camera.format = name_in(text, pixel_format_names()); }},
    {"channel", "NAME", "red, green, blue or grey, of a colour format; a colour filter halves both sides",
     [](CameraUri& uri, const std::string& text) {
       uri.camera.channel = images::channel_of(name_in(text, {"red", "green", "blue", "grey"}));
     }},
    {"trigger", "NAME", "free, software, or an input of the camera such as Line1",
     [](CameraUri& uri, const std::string& text) { uri.camera.trigger = text; }},
    {"packet-bytes", "N",
     "size of the packets of a GigE camera; larger ones cost less work, if the network carries them",
     [](CameraUri& uri, const std::string& text) {
       uri.camera.packet_bytes = number_in(text, kMinPacket, kMaxPacket);
     }},
    {"buffers", "N", "images that wait in memory until they are taken",
     [](CameraUri& uri, const std::string& text) { uri.camera.buffers = number_in(text, 2, kMaxBuffers); }},
    {"bits", "N", "bits of the pixels that moments are of: 8, 10 or 12; of a rig measure.pixel_bits",
     [](CameraUri& uri, const std::string& text) {
       uri.board.bits = number_in(text, spec::kPixelBits, model::kMaxPixelBits);
     }},
    {"mode", "NAME", "binary, grey or grey-over",
     [](CameraUri& uri, const std::string& text) {
       uri.board.mode = images::mode_of(name_in(text, images::mode_names()));
     }},
    {"threshold", "N", "a pixel is lit if it is greater",
     [](CameraUri& uri, const std::string& text) {
       uri.board.threshold = number_in(text, 0, (1 << model::kMaxPixelBits) - 1);
     }},
    {"select", "NAME", "all, or strongest for the strongest run of each column",
     [](CameraUri& uri, const std::string& text) {
       uri.board.select = images::select_of(name_in(text, images::select_names()));
     }},
    {"gap", "N", "dark rows within a run",
     [](CameraUri& uri, const std::string& text) { uri.board.gap = number_in(text, 0, model::kMaxGap); }},
    {"rows", "A..B", "rows that count, from 1",
     [](CameraUri& uri, const std::string& text) { uri.board.window = images::rows_of_text("rows", text); }},
    {"codes", "BITS", "decode Gray codes of so many bits",
     [](CameraUri& uri, const std::string& text) {
       uri.board.code_bits = number_in(text, 1, model::GrayDecoder::kMaxBits);
     }},
    {"code-threshold", "N", "difference below which a pair is ambiguous",
     [](CameraUri& uri, const std::string& text) { uri.board.code_threshold = number_in(text, 0, UINT8_MAX); }},
    {"patterns", "N", "patterns that follow each other with the images",
     [](CameraUri& uri, const std::string& text) { uri.board.patterns = number_in(text, 1, kMaxPatterns); }},
    {"stream", "N", "number of the stream in the packets",
     [](CameraUri& uri, const std::string& text) { uri.board.stream = number_in(text, 0, UINT8_MAX); }},
    {"pixel-clock-hz", "NUMBER", "clock in which time stamps count",
     [](CameraUri& uri, const std::string& text) {
       uri.board.pixel_clock_hz = number_in(text, model::kMinPixelClockHz, model::kMaxPixelClockHz);
     }},
    {"median", "yes|no", "codes pass through the 3 x 3 median",
     [](CameraUri& uri, const std::string& text) { uri.board.median = yes(text); }},
    {"image", "yes|no", "send raw images, too",
     [](CameraUri& uri, const std::string& text) { uri.board.image = yes(text); }},
}};

}  // namespace

bool is_camera_uri(const std::string& text) { return text.starts_with("camera:"); }

CameraUri parse_camera_uri(const std::string& text) {
  if (!is_camera_uri(text)) {
    throw UserError(text, "is not a camera; use camera:NAME, as `selfproj devices` lists them");
  }
  const std::size_t question = text.find('?');
  CameraUri uri;
  uri.uri = text.substr(0, question);
  uri.name = uri.uri.substr(std::string_view("camera:").size());
  std::set<std::string> seen;
  std::size_t from = question == std::string::npos ? text.size() : question + 1;
  while (from < text.size()) {
    const std::size_t to = std::min(text.find('&', from), text.size());
    const std::string part = text.substr(from, to - from);
    const std::size_t equals = std::min(part.find('='), part.size());
    const std::string name = part.substr(0, equals);
    const std::string value = equals < part.size() ? part.substr(equals + 1) : "";
    const auto* const key = std::find_if(kKeys.begin(), kKeys.end(), [&](const Key& one) { return one.name == name; });
    if (key == kKeys.end()) {
      std::vector<std::string> names;
      std::transform(kKeys.begin(), kKeys.end(), std::back_inserter(names), [](const Key& one) { return one.name; });
      throw UserError(
          text, fmt::format("'{}' is not a setting of a camera; the settings are {}", name, fmt::join(names, ", ")));
    }
    if (value.empty() || !seen.insert(name).second) {
      throw UserError(text, fmt::format("{} {}", name, value.empty() ? "has no value" : "is given twice"));
    }
    try {
      key->set(uri, value);
    } catch (const Refusal& refusal) {
      throw UserError(text, fmt::format("{}: '{}' {}", name, value, refusal.reason));
    }
    from = to + 1;
  }
  const std::string format = uri.camera.format.empty() ? "Mono8" : uri.camera.format;
  if (needs_channel(*pixel_format(format)) != uri.camera.channel.has_value()) {
    throw UserError(text, fmt::format("format {} {}", format,
                                      uri.camera.channel ? "has no colours; leave out channel"
                                                         : "has colours; say which with channel"));
  }
  return uri;
}

std::vector<std::string> camera_uri_help() {
  std::vector<std::string> lines;
  std::transform(kKeys.begin(), kKeys.end(), std::back_inserter(lines),
                 [](const Key& key) { return fmt::format("{}={}: {}", key.name, key.value, key.meaning); });
  return lines;
}

}  // namespace selfproj::camera
