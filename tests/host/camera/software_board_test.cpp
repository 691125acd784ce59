// Tests that the board in software gives the packets of the board's model, bit for bit.
#include "host/camera/software_board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/camera/camera_device.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/board.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;
using PacketsOfKind = std::map<int, std::vector<Bytes>>;

model::BoardSettings random_settings(Random& random) {
  model::BoardSettings settings;
  settings.columns = 4 * random.between(1, 20);
  settings.rows = random.between(1, 24);
  settings.mode = static_cast<model::Mode>(random.between(0, 2));
  settings.threshold = random.between(0, 255);
  settings.select = random.chance(50) ? model::Select::strongest : model::Select::all;
  settings.gap = settings.select == model::Select::strongest ? random.between(0, 3) : 0;
  if (random.chance(30)) {
    settings.window = {random.between(0, settings.rows), random.between(0, settings.rows + 3)};
  }
  settings.stream = random.between(0, 255);
  settings.codes = random.chance(60);
  settings.median = random.chance(50);
  settings.code_bits = random.between(1, random.chance(70) ? 3 : 12);
  settings.code_threshold = random.between(0, 40);
  settings.image = random.chance(30);
  settings.timeout = 50;
  return settings;
}

// Gives the frame to the model, beat by beat; a broken one stops after its first beat.
void feed(model::BoardModel& model, const Bytes& pixels, const model::BoardSettings& settings,
          model::BoardInputs inputs, bool whole) {
  const std::size_t beats = pixels.size() / 4;
  for (std::size_t beat = 0; beat < (whole ? beats : 1); ++beat) {
    model::VideoBeat video;
    std::copy_n(pixels.begin() + static_cast<std::ptrdiff_t>(4 * beat), 4, video.pixels.begin());
    video.start = beat == 0;
    video.line_end = (beat + 1) * 4 % static_cast<std::size_t>(settings.columns) == 0;
    model.beat(inputs, video);
    ++inputs.clock;
  }
  model.idle(inputs.clock + 100);
}

TEST(SoftwareBoard, GivesThePacketsOfTheModel) {
  for (const std::uint64_t seed : seeds(300)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    model::BoardSettings settings = random_settings(random);
    // Of a broken frame the model has a beat and the camera nothing, which makes no difference to these.
    const bool breaks = !settings.image && settings.rows > 1 && settings.columns > 4 && random.chance(50);
    PacketsOfKind expected;
    model::BoardModel model([&](model::BoardPacket&& packet) {
      Bytes bytes;
      model::append_packet(packet.header, packet.payload, packet.status, bytes);
      expected[packet.header.kind].push_back(bytes);
    });
    model.write(settings);
    camera::SoftwareBoard board(settings);
    PacketsOfKind got;
    model::BoardInputs inputs;
    for (std::uint64_t frame = 0; frame < 40; ++frame) {
      inputs.clock += 5000;
      inputs.encoder = static_cast<std::uint32_t>(random.bits());
      inputs.pattern = static_cast<std::uint16_t>((inputs.pattern + 1) % (2 * settings.code_bits));
      if (random.chance(3)) {
        inputs.pattern = static_cast<std::uint16_t>(random.between(0, 65535));
      }
      const bool whole = !breaks || !random.chance(5);
      const Bytes pixels =
          random.bytes(static_cast<std::size_t>(settings.columns) * static_cast<std::size_t>(settings.rows));
      feed(model, pixels, settings, inputs, whole);
      board.process({pixels.data(), settings.rows, settings.columns, settings.columns}, whole, frame, inputs);
      model::PacketView packet;
      while (board.next(packet)) {
        model::PacketView parsed;
        ASSERT_EQ(model::parse_packet(packet.bytes(), parsed), model::PacketError::none);
        ASSERT_EQ(parsed.header, packet.header);
        ASSERT_EQ(parsed.status, packet.status);
        got[packet.header.kind].emplace_back(packet.bytes().begin(), packet.bytes().end());
      }
    }
    for (const int kind : {spec::kKindMoments, spec::kKindImage, spec::kKindCodes}) {
      ASSERT_EQ(got[kind].size(), expected[kind].size()) << "packets of kind " << kind;
      for (std::size_t i = 0; i < got[kind].size(); ++i) {
        const auto differs =
            std::mismatch(got[kind][i].begin(), got[kind][i].end(), expected[kind][i].begin(), expected[kind][i].end());
        ASSERT_EQ(differs.first, got[kind][i].end())
            << "packet " << i << " of kind " << kind << " from byte " << differs.first - got[kind][i].begin();
      }
    }
  }
}

TEST(SoftwareBoard, RefusesWhatNoBoardHas) {
  EXPECT_THROW(camera::SoftwareBoard({.columns = 510}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.columns = 4096}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.rows = 1024}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.threshold = 256}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.codes = true, .code_bits = 13}), std::invalid_argument);
  camera::SoftwareBoard board({.columns = 8, .rows = 2});
  const Bytes pixels(16);
  EXPECT_THROW(board.process({pixels.data(), 2, 4, 4}, true, 0, {}), std::invalid_argument);
}

// A camera whose images are given beforehand.
class ListedCamera final : public camera::Camera {
 public:
  struct Listed {
    std::uint64_t number;
    bool complete;
  };
  ListedCamera(int rows, int columns, std::vector<Listed> images)
      : rows_(rows),
        columns_(columns),
        images_(std::move(images)),
        pixels_(static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns), 200) {}

  void start() override { next_ = 0; }
  void stop() override {}
  void trigger() override { throw std::logic_error("no trigger"); }
  void forget_trigger() override {}
  bool next(camera::CameraImage& image, std::chrono::nanoseconds /*timeout*/) override {
    if (next_ == images_.size()) {
      return false;
    }
    const Listed& listed = images_[next_++];
    image.view = {listed.complete ? pixels_.data() : nullptr, rows_, columns_, columns_};
    image.number = listed.number;
    image.time_ns = 1'000'000 + static_cast<std::int64_t>(listed.number) * 2'500'000;
    image.arrival_ns = image.time_ns;
    image.complete = listed.complete;
    return true;
  }
  [[nodiscard]] camera::CameraCounters counters() const override { return {}; }
  [[nodiscard]] int rows() const override { return rows_; }
  [[nodiscard]] int columns() const override { return columns_; }
  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  std::string uri_ = "camera:listed";
  int rows_;
  int columns_;
  std::vector<Listed> images_;
  Bytes pixels_;
  std::size_t next_ = 0;
};

TEST(CameraDevice, EveryImageIsAPacketOrCounted) {
  std::vector<ListedCamera::Listed> images;
  for (std::uint64_t number = 0; number < 100'000; ++number) {
    if (number % 1000 != 7) {
      images.push_back({number, number % 500 != 9});
    }
  }
  const auto device = camera::make_camera_device(std::make_unique<ListedCamera>(2, 8, images),
                                                 {.mode = model::Mode::grey, .threshold = 100, .pixel_clock_hz = 1e6});
  model::PacketView packet;
  std::uint64_t packets = 0;
  while (device->next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
    ASSERT_EQ(packet.header.time_stamp, packet.header.sequence * 2500) << "2.5 ms at 1 MHz";
    ASSERT_EQ(packet.payload.empty(), packet.header.sequence % 500 == 9);
    ++packets;
    device->release();
  }
  const driver::Counters counters = device->counters();
  EXPECT_EQ(packets, 99'900U);
  EXPECT_EQ(counters.delivered, 99'900U);
  EXPECT_EQ(counters.missing, 100U);
  EXPECT_EQ(counters.flagged, 200U);
  EXPECT_EQ(counters.lost_board + counters.bad + counters.repeated + counters.restarts, 0U);
}

TEST(CameraDevice, SizesThatNoBoardTakes) {
  EXPECT_THROW(
      camera::make_camera_device(std::make_unique<ListedCamera>(2, 10, std::vector<ListedCamera::Listed>{}), {}),
      UserError);
  EXPECT_THROW(
      camera::make_camera_device(std::make_unique<ListedCamera>(1080, 1920, std::vector<ListedCamera::Listed>{}), {}),
      UserError);
}

}  // namespace
}  // namespace selfproj::test
