// Tests cameras and the board in software live: Aravis' fake GigE camera over sockets, at its highest rate and with
// packets lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/camera/camera_device.h"
#include "host/camera/open_camera.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"
#include "tests/host/camera/gige_camera.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

using std::chrono::milliseconds;
using std::chrono::seconds;

using LiveCamera = OnOwnNetwork;

// A line of light at a row that the picture's number says.
int row_of(std::uint64_t number) { return static_cast<int>(number * 7 % 90); }

void draw_line(const Picture& picture) {
  const auto columns = static_cast<std::size_t>(picture.columns);
  std::fill_n(picture.pixels, columns * static_cast<std::size_t>(picture.rows), std::uint8_t{5});
  const std::size_t row = static_cast<std::size_t>(row_of(picture.number));
  std::fill_n(picture.pixels + row * columns, 3 * columns, std::uint8_t{200});
}

constexpr const char* kHighestRate =
    "camera:127.0.0.1?region=512x96&rate=1000&exposure-us=100&packet-bytes=8000&buffers=200&mode=binary&threshold=100";

// Takes packets until `count` good ones came or ten seconds have passed, and checks their moments. Image numbers and
// pictures count from the same one, unless images before the first were lost, which `first` then says.
void take_packets(driver::Device& device, std::uint64_t count) {
  model::PacketView packet;
  std::optional<int> shift;
  std::uint64_t good = 0;
  std::uint64_t newest = 0;
  const auto end = std::chrono::steady_clock::now() + seconds(20);
  while (good < count && std::chrono::steady_clock::now() < end) {
    if (device.next(packet, milliseconds(100)) != driver::Next::packet) {
      continue;
    }
    newest = packet.header.sequence;
    if (packet.status != 0) {
      EXPECT_TRUE(packet.payload.empty());
      continue;
    }
    ++good;
    model::Moments moments;
    moments.resize(512);
    model::unpack_moments(model::Mode::binary, 512, packet.payload.data(), moments.view());
    const int row = static_cast<int>(moments.m1[300] / 3) - 2;  // rows count from 1; three are lit
    if (!shift) {                                               // the first picture whose line is there
      for (int i = 0; i < 90 && !shift; ++i) {
        shift = row_of(newest + static_cast<std::uint64_t>(i)) == row ? std::optional(i) : std::nullopt;
      }
    }
    ASSERT_TRUE(shift.has_value());
    for (const std::size_t column : {0, 300, 511}) {
      ASSERT_EQ(moments.m0[column], 3U);
      ASSERT_EQ(moments.m1[column],
                static_cast<std::uint32_t>(3 * (row_of(newest + static_cast<std::uint64_t>(*shift)) + 2)));
    }
  }
  const driver::Counters counters = device.counters();
  EXPECT_EQ(good, count);
  EXPECT_EQ(counters.delivered + counters.missing, newest + 1) << "every image is a packet or counted";
  EXPECT_EQ(counters.delivered - counters.flagged, good);
  EXPECT_EQ(counters.bad + counters.repeated + counters.restarts, 0U);
}

// Through the wrap of the 16-bit numbers: Aravis' camera begins with 65,400.
TEST_F(LiveCamera, EveryFrameOfTheHighestRateIsAPacketOrCounted) {
  const GigeCamera camera(draw_line);
  const std::unique_ptr<driver::Device> device = camera::open_any_device(kHighestRate);
  take_packets(*device, 600);
}

TEST_F(LiveCamera, LostPacketsAreIncompleteImages) {
  const GigeCamera camera(draw_line, 0.01);
  const std::unique_ptr<driver::Device> device = camera::open_any_device(kHighestRate);
  take_packets(*device, 300);
  EXPECT_GT(device->counters().flagged, 0U);
}

TEST_F(LiveCamera, SoftwareTriggerOneAtATime) {
  const GigeCamera gige(draw_line);
  const std::unique_ptr<camera::Camera> camera =
      camera::open_camera(camera::parse_camera_uri("camera:127.0.0.1?region=64x96&trigger=software"));
  camera->start();
  camera::CameraImage image;
  EXPECT_FALSE(camera->next(image, milliseconds(100))) << "without a trigger there is no image";
  for (std::uint64_t i = 0; i < 5; ++i) {
    camera->trigger();
    EXPECT_THROW(camera->trigger(), std::logic_error) << "never two under way";
    ASSERT_TRUE(camera->next(image, seconds(2)));
    EXPECT_EQ(image.number, i);
    EXPECT_EQ(image.view.pixels[image.view.stride * (row_of(i) + 1)], 200) << "the picture of this trigger";
  }
  EXPECT_EQ(gige.drawn(), 5U);
}

TEST_F(LiveCamera, SettingsThatTheCameraRefuses) {
  const GigeCamera gige(draw_line);
  const auto refusal = [](const std::string& settings) {
    return error_of([&] { camera::open_camera(camera::parse_camera_uri("camera:127.0.0.1?" + settings)); });
  };
  const std::string uri = "camera:127.0.0.1: ";
  EXPECT_EQ(refusal("exposure-us=1"), uri + "exposure-us: the camera takes 10 to 1e+07");
  EXPECT_EQ(refusal("region=4000x96"), uri + "region: is beyond the sensor, which has 2048 x 2048 pixels");
  EXPECT_NE(refusal("format=Mono12").find(uri + "format Mono12: "), std::string::npos);
  EXPECT_EQ(refusal("rate=10&trigger=software"), uri + "rate: the trigger determines it");
}

TEST_F(LiveCamera, ColourFilter) {
  const GigeCamera gige([](const Picture& picture) {
    for (int i = 0; i < picture.rows * picture.columns; ++i) {
      picture.pixels[i] = static_cast<std::uint8_t>(i / picture.columns % 2 * 100 + i % 2 * 10);
    }
  });
  const std::unique_ptr<camera::Camera> camera =
      camera::open_camera(camera::parse_camera_uri("camera:127.0.0.1?region=64x32&format=BayerRG8&channel=blue"));
  EXPECT_EQ(camera->rows(), 16);
  EXPECT_EQ(camera->columns(), 32);
  camera->start();
  camera::CameraImage image;
  ASSERT_TRUE(camera->next(image, seconds(2)));
  EXPECT_EQ(image.view.pixels[5 * image.view.stride + 31], 110);
}

TEST_F(LiveCamera, ACameraThatGoesIsOneLine) {
  auto gige = std::make_unique<GigeCamera>(draw_line);
  const std::unique_ptr<driver::Device> device = camera::open_any_device("camera:127.0.0.1?region=64x32");
  model::PacketView packet;
  ASSERT_EQ(device->next(packet, seconds(2)), driver::Next::packet);
  gige.reset();
  const auto end = std::chrono::steady_clock::now() + seconds(20);
  try {
    while (std::chrono::steady_clock::now() < end) {
      static_cast<void>(device->next(packet, milliseconds(100)));
    }
    FAIL() << "the camera has gone, and nothing said so";
  } catch (const UserError& error) {
    EXPECT_EQ(std::string(error.what()), "camera:127.0.0.1: the camera has gone: it no longer answers");
  }
}

TEST_F(LiveCamera, ListAndAbsence) {
  EXPECT_THROW(camera::open_camera(camera::parse_camera_uri("camera:127.0.0.1")), UserError);
  const GigeCamera gige(draw_line);
  const std::vector<camera::CameraEntry> cameras = camera::list_cameras();
  const auto found = std::find_if(cameras.begin(), cameras.end(), [](const camera::CameraEntry& camera) {
    return camera.address == "127.0.0.1" && camera.kind == "GigE Vision";
  });
  ASSERT_NE(found, cameras.end());
  EXPECT_NO_THROW(camera::open_camera(camera::parse_camera_uri(found->uri)));
}

}  // namespace
}  // namespace selfproj::test
