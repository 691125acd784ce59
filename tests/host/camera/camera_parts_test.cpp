// Tests the parts of cameras: numbers that wrap, pixel formats, URIs.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <stdexcept>
#include <string>
#include <tuple>
#include <vector>

#include "host/camera/camera_device.h"
#include "host/camera/camera_uri.h"
#include "host/camera/frame_numbers.h"
#include "host/camera/pixel_format.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

// Images are lost, doubled and late at random; the camera's true count is known.
TEST(FrameNumbers, CountThroughTheWrap) {
  struct Kind {
    std::uint64_t first;
    std::uint64_t period;
    std::uint64_t start;
  };
  for (const Kind& kind : {Kind{1, 65535, 65400}, Kind{0, std::uint64_t{1} << 32U, 0xFFFF'FF80U}, Kind{0, 0, 17}}) {
    for (const std::uint64_t seed : seeds(20)) {
      SCOPED_TRACE(how_to_repeat(seed));
      Random random(seed);
      camera::FrameNumbers numbers(kind.first, kind.period);
      std::uint64_t truth = kind.start;  // without the wrap
      std::uint64_t begin = 0;
      std::uint64_t given = 0;
      std::uint64_t newest = 0;
      for (int i = 0; i < 5000; ++i) {
        truth += random.chance(3) ? static_cast<std::uint64_t>(random.between(2, 10'000)) : 1;
        const bool late = i > 0 && random.chance(2) && truth - newest < 10'000;
        const std::uint64_t shown = late ? newest - static_cast<std::uint64_t>(random.between(0, 40)) : truth;
        const std::uint64_t number = kind.period == 0 ? shown : kind.first + (shown - kind.first) % kind.period;
        const std::optional<std::uint64_t> count = numbers.accept(number);
        ASSERT_EQ(count.has_value(), !late);
        if (count) {
          begin = i == 0 ? truth : begin;
          ASSERT_EQ(*count, truth - begin);
          newest = truth;
          ++given;
        }
      }
      EXPECT_EQ(given + numbers.dropped(), newest - begin + 1) << "every number is given or dropped";
    }
  }
}

TEST(FrameNumbers, GigeLeavesOutZero) {
  camera::FrameNumbers numbers(1, 65535);
  EXPECT_EQ(numbers.accept(65534), 0U);
  EXPECT_EQ(numbers.accept(65535), 1U);
  EXPECT_EQ(numbers.accept(1), 2U);
  EXPECT_EQ(numbers.accept(1), std::nullopt);
  EXPECT_EQ(numbers.accept(65535), std::nullopt);
  EXPECT_EQ(numbers.dropped(), 0U);
}

// From each side of the half-wrap: a loss of any length, and a false number, cost at most two images more.
TEST(FrameNumbers, AStreamThatGoesOnIsFollowed) {
  for (const std::uint64_t loss : {1U, 32'700U, 32'766U, 32'767U, 32'768U, 40'000U, 65'400U}) {
    camera::FrameNumbers numbers(1, 65535);
    std::uint64_t given = 0;
    std::uint64_t last = 0;
    const auto send = [&](std::uint64_t image) {  // image 0 has number 1
      if (const std::optional<std::uint64_t> count = numbers.accept(1 + image % 65535)) {
        ++given;
        last = *count;
      }
    };
    for (std::uint64_t i = 0; i < 100; ++i) {
      send(i);
    }
    for (std::uint64_t i = 0; i < 100'000; ++i) {
      send(100 + loss + i);
    }
    EXPECT_EQ(last, 100 + loss + 99'999) << loss;
    EXPECT_EQ(given + numbers.dropped(), last + 1) << loss;
    EXPECT_GE(given, 100'098U) << loss;
  }
  for (const std::uint64_t period : {std::uint64_t{0}, std::uint64_t{65535}}) {
    camera::FrameNumbers numbers(1, period);
    EXPECT_TRUE(numbers.accept(1));
    EXPECT_TRUE(numbers.accept(30'000)) << "false";
    int refused = 0;
    for (std::uint64_t number = 2; number < 1000; ++number) {
      refused += numbers.accept(number) ? 0 : 1;
    }
    EXPECT_EQ(refused, 2);
  }
}

// Of incomplete images the number may be lost, too.
TEST(FrameNumbers, ImagesWithoutANumberAreTheNext) {
  camera::FrameNumbers numbers(1, 65535);
  EXPECT_EQ(numbers.guess(), 0U);
  EXPECT_EQ(numbers.accept(65533), 1U);
  EXPECT_EQ(numbers.guess(), 2U);
  EXPECT_EQ(numbers.accept(65535), 3U) << "it was 65534";
  EXPECT_EQ(numbers.dropped(), 0U);
  EXPECT_EQ(numbers.guess(), 4U);
  EXPECT_EQ(numbers.accept(4), 7U) << "of 1 to 3 it was one";
  EXPECT_EQ(numbers.dropped(), 2U);
  EXPECT_EQ(numbers.guess(), 8U);
  EXPECT_EQ(numbers.accept(5), 9U) << "it was none, and the image after it is not held back";
  EXPECT_EQ(numbers.dropped(), 2U);
}

// Packs values bit by bit, as the standards draw them.
Bytes packed(const camera::PixelFormat& format, const std::vector<unsigned>& values) {
  Bytes raw(camera::line_bytes(format, static_cast<int>(values.size())));
  const auto bits = static_cast<std::size_t>(format.bits);
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (format.layout == camera::Layout::packed_gige) {
      const auto step = static_cast<unsigned>(std::pow(2, format.bits - 8));
      const unsigned high = values[i] / step;
      const unsigned low = values[i] % step;
      raw[i / 2 * 3 + (i % 2) * 2] = static_cast<std::uint8_t>(high);
      raw[i / 2 * 3 + 1] |= static_cast<std::uint8_t>(low << (i % 2 * 4));
      continue;
    }
    const std::size_t place = format.layout == camera::Layout::words   ? 16 * i
                              : format.layout == camera::Layout::bytes ? 8 * i
                                                                       : bits * i;
    for (std::size_t bit = 0; bit < bits; ++bit) {
      raw[(place + bit) / 8] |= static_cast<std::uint8_t>((values[i] >> bit & 1U) << ((place + bit) % 8));
    }
  }
  return raw;
}

TEST(PixelFormat, ValuesBecomeTheirUpperEightBits) {
  for (const char* name :
       {"Mono8", "Mono10", "Mono12", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed"}) {
    SCOPED_TRACE(name);
    const camera::PixelFormat format = camera::pixel_format(name).value();
    Random random(3);
    std::vector<unsigned> values(64);
    for (unsigned& value : values) {
      value = static_cast<unsigned>(random.between(0, (1 << format.bits) - 1));
    }
    values[0] = (1U << static_cast<unsigned>(format.bits)) - 1;
    const Bytes raw = packed(format, values);
    const std::size_t half = values.size() / 2;
    Bytes out(values.size());
    camera::to_grey8(format, std::nullopt, raw, 2, static_cast<int>(half), raw.size() / 2, out.data());
    EXPECT_EQ(out[0], 255);
    for (std::size_t i = 0; i < values.size(); ++i) {
      ASSERT_EQ(out[i], values[i] / static_cast<unsigned>(std::pow(2, format.bits - 8))) << i;
    }
    EXPECT_THROW(camera::to_grey8(format, std::nullopt, {raw.data(), raw.size() - 1}, 2, static_cast<int>(half),
                                  raw.size() / 2, out.data()),
                 std::invalid_argument);
  }
}

TEST(PixelFormat, AllBitsOfValues) {
  for (const char* name : {"Mono10", "Mono12", "Mono16", "Mono10p", "Mono12p", "Mono10Packed", "Mono12Packed"}) {
    SCOPED_TRACE(name);
    const camera::PixelFormat format = camera::pixel_format(name).value();
    Random random(4);
    std::vector<unsigned> values(64);
    for (unsigned& value : values) {
      value = static_cast<unsigned>(random.between(0, (1 << format.bits) - 1));
    }
    const Bytes raw = packed(format, values);
    std::vector<std::uint16_t> out(values.size());
    camera::to_words(format, raw, 2, 32, raw.size() / 2, out.data());
    EXPECT_TRUE(std::ranges::equal(out, values));
    EXPECT_THROW(camera::to_words(format, {raw.data(), raw.size() - 1}, 2, 32, raw.size() / 2, out.data()),
                 std::invalid_argument);
  }
  for (const char* name : {"Mono8", "BayerRG12", "RGB8", "YUV422_8"}) {
    EXPECT_FALSE(camera::has_words(camera::pixel_format(name).value())) << name;
  }
}

TEST(PixelFormat, ColourFiltersByCell) {
  const Bytes raw = {10, 21, 11, 20,  //
                     30, 40, 33, 41};
  const auto plane = [&](const char* name, images::Channel channel) {
    Bytes out(2);
    camera::to_grey8(camera::pixel_format(name).value(), channel, raw, 2, 4, 4, out.data());
    return out;
  };
  EXPECT_EQ(plane("BayerRG8", images::Channel::red), (Bytes{10, 11}));
  EXPECT_EQ(plane("BayerRG8", images::Channel::blue), (Bytes{40, 41}));
  EXPECT_EQ(plane("BayerRG8", images::Channel::green), (Bytes{26, 27})) << "25.5 and 26.5, halves up";
  EXPECT_EQ(plane("BayerRG8", images::Channel::grey), (Bytes{25, 26})) << "25.25 and 26.25";
  EXPECT_EQ(plane("BayerBG8", images::Channel::red), (Bytes{40, 41}));
  EXPECT_EQ(plane("BayerGR8", images::Channel::red), (Bytes{21, 20}));
  EXPECT_EQ(plane("BayerGR8", images::Channel::green), (Bytes{25, 26}));
  EXPECT_EQ(plane("BayerGB8", images::Channel::red), (Bytes{30, 33}));
  EXPECT_EQ(plane("BayerGB8", images::Channel::blue), (Bytes{21, 20}));
  EXPECT_EQ(camera::rows_of(*camera::pixel_format("BayerRG8"), 96), 48);
}

TEST(PixelFormat, ColoursAndLuminance) {
  const Bytes raw = {200, 100, 50, 0, 255, 3};
  const auto plane = [&](const char* name, std::optional<images::Channel> channel, int columns) {
    Bytes out(static_cast<std::size_t>(columns));
    camera::to_grey8(camera::pixel_format(name).value(), channel, raw, 1, columns, raw.size(), out.data());
    return out;
  };
  EXPECT_EQ(plane("RGB8", images::Channel::red, 2), (Bytes{200, 0}));
  EXPECT_EQ(plane("BGR8", images::Channel::red, 2), (Bytes{50, 3}));
  EXPECT_EQ(plane("RGB8", images::Channel::grey, 2), (Bytes{124, 150})) << "0.299 R + 0.587 G + 0.114 B";
  EXPECT_EQ(plane("YUV422_8", std::nullopt, 3), (Bytes{200, 50, 255}));
  EXPECT_EQ(plane("YUV422_8_UYVY", std::nullopt, 3), (Bytes{100, 0, 3}));
  EXPECT_THROW(plane("RGB8", std::nullopt, 2), std::invalid_argument);
}

// Bits of the URI come before those of the rig, and ask for a format of as many.
TEST(CameraUri, BitsOfPixels) {
  const auto filled = [](const std::string& settings, std::optional<int> of_rig) {
    camera::CameraUri uri = camera::parse_camera_uri("camera:Maker-1" + settings);
    camera::fill_from(uri, {.board = {.bits = of_rig}});
    return std::tuple(uri.camera.format, uri.camera.bits, uri.board.bits.value_or(8));
  };
  EXPECT_EQ(filled("", {}), std::tuple("", 8, 8));
  EXPECT_EQ(filled("", 12), std::tuple("Mono12", 12, 12));
  EXPECT_EQ(filled("?bits=10", 12), std::tuple("Mono10", 10, 10));
  EXPECT_EQ(filled("?bits=8", 12), std::tuple("", 8, 8));
  EXPECT_EQ(filled("?bits=12&format=Mono12p", {}), std::tuple("Mono12p", 12, 12));
  EXPECT_EQ(error_of([&] { filled("?bits=12&format=Mono10", {}); }),
            "camera:Maker-1: format: Mono10 is given; bits of the URI are 12");
  EXPECT_EQ(error_of([&] { filled("?format=Mono10", 12); }),
            "camera:Maker-1: format: Mono10 is given; measure.pixel_bits of the rig is 12");
  EXPECT_EQ(error_of([&] { filled("?bits=9", {}); }),
            "camera:Maker-1: bits of the URI are 9; cameras have pixels of 8, 10 or 12");
}

TEST(CameraUri, EverySetting) {
  const camera::CameraUri uri = camera::parse_camera_uri(
      "camera:Maker-1?exposure-us=12.5&gain=-2&region=512x96+64+20&format=BayerRG12&channel=green&trigger=Line1&"
      "packet-bytes=9000&buffers=8&bits=12&mode=grey&threshold=60&select=strongest&gap=1&rows=10..80&codes=6&code-"
      "threshold=4&"
      "patterns=12&stream=3&pixel-clock-hz=1e6&median=yes&image=no");
  EXPECT_EQ(uri.uri, "camera:Maker-1");
  EXPECT_EQ(uri.name, "Maker-1");
  EXPECT_EQ(uri.camera.exposure_us, 12.5);
  EXPECT_EQ(uri.camera.gain, -2);
  EXPECT_EQ(uri.camera.region, (images::ImagePart{512, 96, 64, 20}));
  EXPECT_EQ(uri.camera.channel, images::Channel::green);
  EXPECT_EQ(uri.camera.trigger, "Line1");
  EXPECT_EQ(uri.camera.packet_bytes, 9000);
  EXPECT_EQ(uri.camera.buffers, 8);
  EXPECT_EQ(uri.board.bits, 12);
  EXPECT_EQ(uri.board.mode, model::Mode::grey);
  EXPECT_EQ(uri.board.select, model::Select::strongest);
  EXPECT_EQ(uri.board.window, (model::RowWindow{10, 80}));
  EXPECT_EQ(uri.board.code_bits, 6);
  EXPECT_EQ(uri.board.patterns, 12);
  EXPECT_TRUE(uri.board.median);
  EXPECT_FALSE(uri.board.image);
}

TEST(CameraUri, Refusals) {
  const auto refusal = [](const std::string& text) { return error_of([&] { camera::parse_camera_uri(text); }); };
  EXPECT_EQ(refusal("ring:a"), "ring:a: is not a camera; use camera:NAME, as `selfproj devices` lists them");
  EXPECT_EQ(refusal("camera:a?gain"), "camera:a?gain: gain has no value");
  EXPECT_EQ(refusal("camera:a?gain=1&gain=1"), "camera:a?gain=1&gain=1: gain is given twice");
  EXPECT_EQ(refusal("camera:a?threshold=4096"),
            "camera:a?threshold=4096: threshold: '4096' is not a whole number from 0 to 4095");
  EXPECT_EQ(refusal("camera:a?region=512x"),
            "camera:a?region=512x: region: '512x' is not a region such as 512x96 or 512x96+64+20");
  EXPECT_NE(refusal("camera:a?region=512x96+1"), "none");
  EXPECT_NE(refusal("camera:a?region=0x96"), "none");
  EXPECT_NE(refusal("camera:a?region=4x4+0+0+0"), "none");
  EXPECT_NE(refusal("camera:a?median=maybe"), "none");
  EXPECT_NE(refusal("camera:a?exposure-us=0"), "none");
  EXPECT_NE(refusal("camera:a?format=Mono9").find("is not one of Mono8, Mono10"), std::string::npos);
  EXPECT_NE(refusal("camera:a?format=BayerRG8").find("has colours; say which with channel"), std::string::npos);
  EXPECT_NE(refusal("camera:a?channel=red").find("format Mono8 has no colours"), std::string::npos);
  EXPECT_NE(refusal("camera:a?shutter=1").find("'shutter' is not a setting of a camera; the settings are exposure-us"),
            std::string::npos);
}

}  // namespace
}  // namespace selfproj::test
