// Tests cameras of V4L2 through the seam: a player of recorded images in place of the kernel.
#include <gtest/gtest.h>
#include <linux/videodev2.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_device.h"
#include "host/camera/camera_uri.h"
#include "host/camera/open_camera.h"
#include "host/driver/device_port.h"
#include "selfproj/driver/device.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/packet.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A recorded image: what the driver would put into a buffer.
struct Recorded {
  std::uint32_t sequence = 0;
  std::uint32_t flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC;
  std::uint32_t bytes = 0;
  std::uint8_t grey = 0;
};

// What the player is, and what was done to it.
struct Player {
  std::vector<std::uint32_t> formats = {V4L2_PIX_FMT_MJPEG, V4L2_PIX_FMT_YUYV};
  std::map<std::uint32_t, std::int32_t> controls = {{V4L2_CID_EXPOSURE_AUTO, V4L2_EXPOSURE_APERTURE_PRIORITY},
                                                    {V4L2_CID_EXPOSURE_ABSOLUTE, 300},
                                                    {V4L2_CID_AUTOGAIN, 1}};
  std::uint32_t padding = 0;    // bytes of a line beyond its pixels
  std::deque<Recorded> images;  // those that are still to be played
  bool unplugged_at_end = false;
  std::uint32_t format = 0;
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  std::vector<std::map<std::uint32_t, std::int32_t>> written;  // the controls after each change
  bool streaming = false;
  std::size_t queued_most = 0;
};

class PlayerPort final : public driver::DevicePort {
 public:
  explicit PlayerPort(Player& player) : player_(player) {}

  int control(unsigned long request, void* argument) override {
    switch (request) {
      case VIDIOC_QUERYCAP: {
        auto* const capability = static_cast<v4l2_capability*>(argument);
        capability->capabilities = V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_STREAMING;
        return 0;
      }
      case VIDIOC_ENUM_FMT: {
        auto* const format = static_cast<v4l2_fmtdesc*>(argument);
        if (format->index >= player_.formats.size()) {
          return EINVAL;
        }
        format->pixelformat = player_.formats[format->index];
        return 0;
      }
      case VIDIOC_G_FMT: {
        auto* const format = static_cast<v4l2_format*>(argument);
        format->fmt.pix.width = 640;
        format->fmt.pix.height = 480;
        return 0;
      }
      case VIDIOC_S_FMT:
        return set_format(*static_cast<v4l2_format*>(argument));
      case VIDIOC_QUERYCTRL: {
        auto* const range = static_cast<v4l2_queryctrl*>(argument);
        range->minimum = 0;
        range->maximum = 10'000;
        return player_.controls.count(range->id) > 0 ? 0 : EINVAL;
      }
      case VIDIOC_G_CTRL: {
        auto* const control = static_cast<v4l2_control*>(argument);
        control->value = player_.controls.at(control->id);
        return 0;
      }
      case VIDIOC_S_CTRL: {
        const auto* const control = static_cast<v4l2_control*>(argument);
        player_.controls.at(control->id) = control->value;
        player_.written.push_back(player_.controls);
        return 0;
      }
      default:
        return control_buffers(request, argument);
    }
  }

  const std::uint8_t* map(std::size_t /*bytes*/, std::int64_t offset) override {
    return memory_.at(static_cast<std::size_t>(offset)).data();
  }

  bool wait(std::chrono::nanoseconds /*timeout*/) override { return !player_.images.empty(); }

 private:
  [[nodiscard]] std::uint32_t line() const {
    return player_.width * (player_.format == V4L2_PIX_FMT_GREY ? 1 : 2) + player_.padding;
  }

  int set_format(v4l2_format& format) {
    v4l2_pix_format& pix = format.fmt.pix;
    pix.width = std::min(pix.width, 640U);  // as drivers do: the nearest size they have
    player_.format = pix.pixelformat;
    player_.width = pix.width;
    player_.height = pix.height;
    pix.bytesperline = line();
    pix.sizeimage = line() * pix.height;
    return 0;
  }

  int control_buffers(unsigned long request, void* argument) {
    auto* const buffer = static_cast<v4l2_buffer*>(argument);
    switch (request) {
      case VIDIOC_REQBUFS: {
        auto* const wanted = static_cast<v4l2_requestbuffers*>(argument);
        wanted->count = std::min(wanted->count, 4U);
        memory_.assign(wanted->count, Bytes(line() * player_.height));
        return 0;
      }
      case VIDIOC_QUERYBUF:
        buffer->length = static_cast<std::uint32_t>(memory_.at(buffer->index).size());
        buffer->m.offset = buffer->index;
        return 0;
      case VIDIOC_QBUF:
        EXPECT_EQ(std::count(queue_.begin(), queue_.end(), buffer->index), 0) << "a buffer is queued twice";
        queue_.push_back(buffer->index);
        player_.queued_most = std::max(player_.queued_most, queue_.size());
        return 0;
      case VIDIOC_STREAMON:
        player_.streaming = true;
        return 0;
      case VIDIOC_STREAMOFF:
        player_.streaming = false;
        queue_.clear();
        return 0;
      case VIDIOC_DQBUF:
        return play(*buffer);
      default:
        return ENOTTY;
    }
  }

  int play(v4l2_buffer& buffer) {
    if (player_.images.empty()) {
      return player_.unplugged_at_end ? ENODEV : EAGAIN;
    }
    EXPECT_FALSE(queue_.empty()) << "no buffer is free";
    const Recorded image = player_.images.front();
    player_.images.pop_front();
    buffer.index = queue_.front();
    queue_.pop_front();
    Bytes& memory = memory_[buffer.index];
    std::fill(memory.begin(), memory.end(), image.grey);
    buffer.sequence = image.sequence;
    buffer.flags = image.flags;
    buffer.bytesused = image.bytes != 0 ? image.bytes : static_cast<std::uint32_t>(memory.size());
    buffer.timestamp = {static_cast<long>(image.sequence / 30), static_cast<long>(image.sequence % 30 * 33'333)};
    return 0;
  }

  Player& player_;
  std::vector<Bytes> memory_;
  std::deque<std::uint32_t> queue_;
};

std::unique_ptr<camera::Camera> open(Player& player, const std::string& settings = "") {
  return camera::open_v4l2_camera(camera::parse_camera_uri("camera:/dev/video9" + settings),
                                  std::make_unique<PlayerPort>(player));
}

std::string refusal(Player& player, const std::string& settings) {
  try {
    open(player, settings);
  } catch (const UserError& error) {
    return error.what();
  }
  return "";
}

TEST(V4l2Camera, PlaysARecordingWithDroppedAndDamagedImages) {
  Player player;
  player.padding = 16;
  for (std::uint32_t i = 0; i < 300; ++i) {
    if (i % 50 != 20 && i % 50 != 21) {  // 12 never come
      player.images.push_back({.sequence = i + 5,
                               .flags = V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC | (i % 60 == 3 ? V4L2_BUF_FLAG_ERROR : 0U),
                               .bytes = i % 70 == 6 ? 100U : 0U,
                               .grey = static_cast<std::uint8_t>(i)});
    }
  }
  player.images.insert(player.images.begin() + 100, {.sequence = 7});  // again, and late
  player.unplugged_at_end = true;
  const std::unique_ptr<camera::Camera> camera = open(player, "?region=320x8");
  EXPECT_EQ(player.format, V4L2_PIX_FMT_YUYV) << "the luminance of what it has";
  EXPECT_EQ(camera->columns(), 320);
  camera->start();
  camera::CameraImage image;
  std::int64_t last = -1;
  for (int given = 0; given < 288; ++given) {
    ASSERT_TRUE(camera->next(image, std::chrono::seconds(1)));
    const std::uint64_t i = image.number;
    ASSERT_EQ(image.complete, i % 60 != 3 && i % 70 != 6) << i;
    ASSERT_GE(image.time_ns, last);
    last = image.time_ns;
    if (image.complete) {
      ASSERT_EQ(image.view.pixels[7 * image.view.stride + 319], static_cast<std::uint8_t>(i));
    }
  }
  const camera::CameraCounters counters = camera->counters();
  EXPECT_EQ(counters.incomplete, 10U);
  EXPECT_EQ(counters.complete, 278U);
  EXPECT_EQ(counters.dropped, 12U);
  EXPECT_EQ(counters.late, 1U);
  try {
    camera->next(image, std::chrono::seconds(1));
    FAIL() << "an unplugged camera";
  } catch (const UserError& error) {
    EXPECT_EQ(std::string(error.what()), "camera:/dev/video9: the camera has gone: No such device");
  }
}

// Pixels of 12 bits: the moments are of all bits, and raw images of the upper eight.
TEST(V4l2Camera, MomentsOfTwelveBits) {
  Player player;
  player.formats = {V4L2_PIX_FMT_YUYV, V4L2_PIX_FMT_Y12};
  player.images = {{.sequence = 0, .grey = 0x0A}, {.sequence = 1, .grey = 0x03}};  // both bytes of a pixel
  camera::CameraUri uri = camera::parse_camera_uri("camera:/dev/video9?region=320x8&format=Mono12&bits=12");
  camera::fill_from(uri, {});
  uri.board.mode = model::Mode::grey;
  uri.board.threshold = 0x0303;
  uri.board.image = true;
  const std::unique_ptr<driver::Device> device =
      camera::make_camera_device(camera::open_v4l2_camera(uri, std::make_unique<PlayerPort>(player)), uri.board, {});
  for (const std::uint32_t pixel : {0x0A0AU, 0x0303U}) {
    model::PacketView packet;
    ASSERT_EQ(device->next(packet, std::chrono::seconds(1)), driver::Next::packet);
    ASSERT_EQ(packet.header.kind, spec::kKindMoments);
    EXPECT_EQ(packet.header.pixel_bits, 12);
    EXPECT_EQ(packet.header.threshold, 0x0303);
    model::Moments moments;
    moments.resize(320);
    model::unpack_columns(packet.header, packet.payload.data(), {.moments = moments.view()});
    const bool lit = pixel > 0x0303;
    EXPECT_EQ(moments.m0, std::vector<std::uint32_t>(320, lit ? 8 * pixel : 0));
    EXPECT_EQ(moments.m1, std::vector<std::uint32_t>(320, lit ? 36 * pixel : 0));
    EXPECT_EQ(moments.n, std::vector<std::uint32_t>(320, lit ? 8 : 0));
    for (int row = 0; row < 8; ++row) {
      ASSERT_EQ(device->next(packet, std::chrono::seconds(1)), driver::Next::packet);
      ASSERT_EQ(packet.header.kind, spec::kKindImage);
      EXPECT_EQ(packet.payload[319], pixel >> 4);
    }
  }
  uri.board.threshold = 4096;
  try {
    camera::make_camera_device(camera::open_v4l2_camera(uri, std::make_unique<PlayerPort>(player)), uri.board, {});
    FAIL() << "a threshold above all pixels";
  } catch (const UserError& error) {
    EXPECT_EQ(std::string(error.what()), "camera:/dev/video9: the threshold is 4096, and pixels have 12 bits");
  }
}

TEST(V4l2Camera, AutomaticsAreOffAndComeBack) {
  Player player;
  const auto before = player.controls;
  {
    const std::unique_ptr<camera::Camera> camera = open(player, "?exposure-us=5000");
    EXPECT_EQ(player.controls.at(V4L2_CID_EXPOSURE_AUTO), V4L2_EXPOSURE_MANUAL);
    EXPECT_EQ(player.controls.at(V4L2_CID_AUTOGAIN), 0);
    EXPECT_EQ(player.controls.at(V4L2_CID_EXPOSURE_ABSOLUTE), 50);
    camera->start();
    EXPECT_TRUE(player.streaming);
    EXPECT_EQ(player.queued_most, 4U);
  }
  EXPECT_FALSE(player.streaming);
  EXPECT_EQ(player.controls, before);
}

TEST(V4l2Camera, Refusals) {
  Player player;
  const std::string uri = "camera:/dev/video9: ";
  EXPECT_EQ(refusal(player, "?trigger=software"), uri + "trigger: cameras of V4L2 run free");
  EXPECT_EQ(refusal(player, "?format=Mono12"), uri + "format: it has not Mono12; it has YUV422_8");
  EXPECT_EQ(refusal(player, "?region=1280x720"), uri + "region: the camera takes 640 x 720 pixels instead");
  EXPECT_EQ(refusal(player, "?gain=3"), uri + "gain: the camera has no such setting");
  EXPECT_EQ(refusal(player, "?exposure-us=2e6"),
            uri + "exposure-us: the camera takes 0 to 10000 times 100 microseconds");
  player.formats = {V4L2_PIX_FMT_MJPEG};
  EXPECT_EQ(refusal(player, ""),
            uri + "format: it has not Mono8 or YUV422_8 or YUV422_8_UYVY; it has none that is known here");
  EXPECT_THROW(camera::open_v4l2_camera(camera::parse_camera_uri("camera:/dev/null")), UserError);
}

}  // namespace
}  // namespace selfproj::test
