// Tests that the board in software gives the packets of the board's model, bit for bit.
#include "host/camera/software_board.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
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

model::BoardSettings random_settings(Random& random, int pixel_bits) {
  model::BoardSettings settings;
  settings.columns = 4 * random.between(1, 20);
  settings.rows = random.between(1, 24);
  settings.mode = static_cast<model::Mode>(random.between(0, 2));
  settings.threshold = random.between(0, (1 << pixel_bits) - 1);
  settings.select = random.chance(50) ? model::Select::strongest : model::Select::all;
  settings.gap = settings.select == model::Select::strongest ? random.between(0, 3) : 0;
  if (random.chance(30)) {
    settings.window = {random.between(0, settings.rows), random.between(0, settings.rows + 3)};
  }
  settings.compact = random.chance(30);
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
void feed(model::BoardModel& model, const std::vector<std::uint16_t>& pixels, const model::BoardSettings& settings,
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
    const int bits = random.chance(50) ? 8 : 2 * random.between(5, 6);
    model::BoardSettings settings = random_settings(random, bits);
    if (bits <= model::kMaxTallBits && random.chance(5)) {
      settings.rows = random.between(spec::kMaxRows + 1, spec::kRowLimit);
      settings.columns = 4 * random.between(1, 4);
    }
    // Of a broken frame the model has a beat and the camera nothing, which makes no difference to these.
    const bool breaks = !settings.image && settings.rows > 1 && settings.columns > 4 && random.chance(50);
    PacketsOfKind expected;
    model::BoardModel model(
        [&](model::BoardPacket&& packet) {
          Bytes bytes;
          model::append_packet(packet.header, packet.payload, packet.status, bytes);
          expected[packet.header.kind].push_back(bytes);
        },
        true, bits, spec::kPixelsPerBeat, settings.rows > spec::kMaxRows);
    model.write(settings);
    camera::SoftwareBoard board(settings, bits);
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
      std::vector<std::uint16_t> all(pixels.size());  // bits; those of `pixels` are the upper 8
      std::ranges::transform(pixels, all.begin(), [&](std::uint8_t p) {
        return static_cast<std::uint16_t>(p << (bits - 8) | random.between(0, (1 << (bits - 8)) - 1));
      });
      feed(model, all, settings, inputs, whole);
      board.process({pixels.data(), settings.rows, settings.columns, settings.columns}, whole, frame, inputs,
                    {all.data(), settings.rows, settings.columns, settings.columns});
      model::PacketView packet;
      while (board.next(packet)) {
        model::PacketView parsed;
        ASSERT_EQ(model::parse_packet(packet.bytes(), parsed), model::PacketError::none);
        ASSERT_EQ(parsed.header, packet.header);
        ASSERT_EQ(parsed.status, packet.status);
        got[packet.header.kind].emplace_back(packet.bytes().begin(), packet.bytes().end());
      }
    }
    for (const int kind : {spec::kKindMoments, spec::kKindCompact, spec::kKindImage, spec::kKindCodes}) {
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
  EXPECT_THROW(camera::SoftwareBoard({.columns = 4100}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.rows = 2048}), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.threshold = 256}), std::invalid_argument);
  EXPECT_NO_THROW(camera::SoftwareBoard({.threshold = 256}, 10));
  EXPECT_THROW(camera::SoftwareBoard({.threshold = 1024}, 10), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({}, 13), std::invalid_argument);
  EXPECT_THROW(camera::SoftwareBoard({.codes = true, .code_bits = 13}), std::invalid_argument);
  camera::SoftwareBoard board({.columns = 8, .rows = 2});
  const Bytes pixels(16);
  EXPECT_THROW(board.process({pixels.data(), 2, 4, 4}, true, 0, {}), std::invalid_argument);
}

// Each setting on both sides of its limits.
TEST(SoftwareBoard, LimitsOfTheSettings) {
  const auto takes = [](const model::BoardSettings& settings) {
    try {
      const camera::SoftwareBoard board(settings);
      return true;
    } catch (const std::invalid_argument&) {
      return false;
    }
  };
  using Settings = model::BoardSettings;
  for (const Settings& good :
       {Settings{.columns = 4, .rows = 1}, Settings{.columns = 4096, .rows = 1}, Settings{.columns = 4, .rows = 1023},
        Settings{.threshold = 0}, Settings{.threshold = 255}, Settings{.select = model::Select::strongest, .gap = 3},
        Settings{.window = {0, 0}}, Settings{.window = {2047, 2047}}, Settings{.stream = 255},
        Settings{.region_row = 65535, .region_column = 65535}}) {
    EXPECT_TRUE(takes(good)) << good.columns << " x " << good.rows;
  }
  for (const Settings& bad :
       {Settings{.columns = 0}, Settings{.columns = 4100}, Settings{.columns = 6}, Settings{.rows = 0},
        Settings{.threshold = -1}, Settings{.select = model::Select::strongest, .gap = model::kMaxGap + 1},
        Settings{.select = model::Select::strongest, .gap = -1}, Settings{.window = {-1, 5}},
        Settings{.window = {0, 2048}}, Settings{.window = {2048, 2048}}, Settings{.stream = -1},
        Settings{.stream = 256}, Settings{.region_row = -1}, Settings{.region_row = 65536},
        Settings{.region_column = -1}, Settings{.region_column = 65536},
        Settings{.mode = static_cast<model::Mode>(3)}}) {
    EXPECT_FALSE(takes(bad)) << bad.columns << " x " << bad.rows;
  }
}

std::vector<Bytes> packets_of(camera::SoftwareBoard& board) {
  std::vector<Bytes> all;
  model::PacketView packet;
  while (board.next(packet)) {
    all.emplace_back(packet.bytes().begin(), packet.bytes().end());
  }
  return all;
}

// Lines may lie apart from each other: the packets are those of the image without gaps.
TEST(SoftwareBoard, ImagesWithGapsBetweenTheirLines) {
  constexpr int kRows = 6;
  constexpr int kColumns = 12;
  constexpr int kStride = 19;
  const model::BoardSettings settings{
      .image = true, .columns = kColumns, .rows = kRows, .threshold = 90, .codes = true, .code_bits = 2};
  camera::SoftwareBoard dense(settings);
  camera::SoftwareBoard apart(settings);
  Random random(5);
  std::size_t packets = 0;
  for (std::uint16_t frame = 0; frame < 8; ++frame) {
    const Bytes wide = random.bytes(std::size_t{kRows} * kStride);
    Bytes narrow;
    for (int row = 0; row < kRows; ++row) {
      narrow.insert(narrow.end(), wide.begin() + row * kStride, wide.begin() + row * kStride + kColumns);
    }
    const model::BoardInputs inputs{.clock = 1000U * frame, .pattern = static_cast<std::uint16_t>(frame % 4)};
    dense.process({narrow.data(), kRows, kColumns, kColumns}, true, frame, inputs);
    apart.process({wide.data(), kRows, kColumns, kStride}, true, frame, inputs);
    const std::vector<Bytes> want = packets_of(dense);
    EXPECT_EQ(packets_of(apart), want);
    packets += want.size();
  }
  EXPECT_GE(packets, 8U * (1 + kRows) + 2 * kRows) << "moments and images of eight frames, codes of two cycles";
}

// Of an image that did not come whole there is one empty packet, of the kind that its columns would have had.
TEST(SoftwareBoard, OfAnIncompleteImage) {
  for (const bool compact : {false, true}) {
    camera::SoftwareBoard board({.image = true,
                                 .columns = 8,
                                 .rows = 2,
                                 .mode = model::Mode::grey,
                                 .stream = 7,
                                 .region_row = 3,
                                 .region_column = 4,
                                 .compact = compact});
    const Bytes pixels(16, 9);
    board.process({pixels.data(), 2, 8, 8}, true, 1, {});
    EXPECT_EQ(packets_of(board).size(), 3U);
    board.process({nullptr, 2, 8, 8}, false, 2, {.clock = 5, .encoder = 6, .pattern = 8});
    model::PacketView packet;
    ASSERT_TRUE(board.next(packet));
    EXPECT_EQ(packet.header.kind, compact ? spec::kKindCompact : spec::kKindMoments);
    EXPECT_EQ(packet.header.sequence, 2U);
    EXPECT_EQ(packet.header.time_stamp, 5U);
    EXPECT_EQ(packet.header.encoder, 6U);
    EXPECT_EQ(packet.header.pattern, 8);
    EXPECT_EQ(packet.header.stream, 7);
    EXPECT_EQ(packet.header.region_row, 3);
    EXPECT_EQ(packet.header.region_column, 4);
    EXPECT_EQ(packet.status, spec::kStatusIncomplete);
    EXPECT_TRUE(packet.payload.empty());
    EXPECT_FALSE(board.next(packet));
    EXPECT_THROW(board.process({nullptr, 2, 8, 8}, true, 3, {}), std::invalid_argument);
    EXPECT_THROW(board.process({pixels.data(), 4, 4, 4}, true, 3, {}), std::invalid_argument);
    EXPECT_THROW(board.process({pixels.data(), 1, 8, 8}, true, 3, {}), std::invalid_argument);
  }
}

// After an image that did not come whole the decoder waits for plane 0, even if the camera shows its pattern again.
TEST(SoftwareBoard, CodesAfterAnIncompleteImage) {
  camera::SoftwareBoard board({.columns = 8, .rows = 2, .codes = true, .code_bits = 2});
  const Bytes pixels(16, 9);
  std::vector<std::size_t> packets;
  for (const int pattern : {0, 1, -2, 2, 3, 0, 1, 2, 3}) {  // negative: incomplete
    board.process({pixels.data(), 2, 8, 8}, pattern >= 0, packets.size(),
                  {.clock = 100 * packets.size(), .pattern = static_cast<std::uint16_t>(std::abs(pattern))});
    packets.push_back(packets_of(board).size());
  }
  EXPECT_EQ(packets, (std::vector<std::size_t>{1, 1, 1, 1, 1, 1, 1, 1, 3}));
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

// The time stamps of a day, at a clock with which the product of both has more than 64 bits.
TEST(CameraDevice, TimeStampsOfManyHours) {
  constexpr std::uint64_t kDay = 86'400 * 400;  // images
  const auto device = camera::make_camera_device(
      std::make_unique<ListedCamera>(2, 8,
                                     std::vector<ListedCamera::Listed>{{0, true}, {kDay, true}, {kDay + 1, true}}),
      {.mode = model::Mode::grey, .pixel_clock_hz = 400e6});
  model::PacketView packet;
  for (const std::uint64_t number : {std::uint64_t{0}, kDay, kDay + 1}) {
    ASSERT_EQ(device->next(packet, std::chrono::nanoseconds(0)), driver::Next::packet);
    EXPECT_EQ(packet.header.time_stamp, number * 1'000'000) << "2.5 ms at 400 MHz";
    EXPECT_EQ(device->arrival_ns(), 1'000'000 + static_cast<std::int64_t>(number) * 2'500'000);
  }
  EXPECT_EQ(device->counters(), (driver::Counters{.delivered = 3, .missing = kDay - 1}));
}

// Image k shows pattern k modulo their number: what is given, two for each bit of the codes, or one.
TEST(CameraDevice, PatternsByTheNumberOfTheImage) {
  struct Case {
    camera::CameraBoardSettings board;
    std::uint64_t patterns;
  };
  for (const Case& one :
       {Case{{}, 1}, Case{{.code_bits = 3}, 6}, Case{{.code_bits = 3, .patterns = 5}, 5}, Case{{.patterns = 4}, 4}}) {
    const auto device = camera::make_camera_device(
        std::make_unique<ListedCamera>(
            2, 8, std::vector<ListedCamera::Listed>{{0, true}, {1, true}, {4, true}, {70'001, true}}),
        one.board);
    model::PacketView packet;
    for (const std::uint64_t number : {0U, 1U, 4U, 70'001U}) {
      ASSERT_EQ(device->next(packet, std::chrono::nanoseconds(0)), driver::Next::packet);
      EXPECT_EQ(packet.header.sequence, number);
      EXPECT_EQ(packet.header.pattern, number % one.patterns);
      EXPECT_EQ(packet.header.encoder, 0U);
    }
  }
}

// Every setting reaches the headers, and the packets that it asks for come; what is not given is that of a board.
TEST(CameraDevice, SettingsReachTheBoard) {
  const std::vector<ListedCamera::Listed> images = {{0, true}, {1, true}};
  const auto device =
      camera::make_camera_device(std::make_unique<ListedCamera>(4, 8, images), {.mode = model::Mode::grey_over,
                                                                                .threshold = 77,
                                                                                .select = model::Select::strongest,
                                                                                .gap = 2,
                                                                                .window = model::RowWindow{2, 3},
                                                                                .region_row = 11,
                                                                                .region_column = 12,
                                                                                .compact = true,
                                                                                .code_bits = 1,
                                                                                .stream = 9,
                                                                                .image = true});
  model::PacketHeader want;
  model::describe_frame(want, 4, 8,
                        model::BoardSettings{.mode = model::Mode::grey_over,
                                             .threshold = 77,
                                             .select = model::Select::strongest,
                                             .gap = 2,
                                             .window = {2, 3}}
                            .measure());
  std::map<int, int> kinds;
  model::PacketView packet;
  while (device->next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
    ++kinds[packet.header.kind];
    EXPECT_EQ(packet.header.stream, 9);
    EXPECT_EQ(packet.header.region_row, 11);
    EXPECT_EQ(packet.header.region_column, 12);
    EXPECT_EQ(packet.header.rows, 4);
    EXPECT_EQ(packet.header.columns, 8);
    EXPECT_EQ(packet.header.mode, want.mode);
    EXPECT_EQ(packet.header.threshold, want.threshold);
  }
  EXPECT_EQ(kinds, (std::map<int, int>{{spec::kKindCompact, 2}, {spec::kKindImage, 8}, {spec::kKindCodes, 4}}));
  EXPECT_EQ(device->uri(), "camera:listed");
  const auto plain = camera::make_camera_device(std::make_unique<ListedCamera>(4, 8, images), {});
  ASSERT_EQ(plain->next(packet, std::chrono::nanoseconds(0)), driver::Next::packet);
  EXPECT_EQ(packet.header.threshold, model::BoardSettings().threshold);
  EXPECT_EQ(packet.header.stream, 0);
}

// With no time, or less, it looks once, however it waits.
TEST(CameraDevice, WithoutTimeItLooksOnce) {
  for (const driver::Wait wait : {driver::Wait::polling, driver::Wait::blocking}) {
    for (const int timeout : {0, -5}) {
      const auto device = camera::make_camera_device(
          std::make_unique<ListedCamera>(2, 8, std::vector<ListedCamera::Listed>{{0, true}}), {}, {.wait = wait});
      model::PacketView packet;
      EXPECT_EQ(device->next(packet, std::chrono::nanoseconds(timeout)), driver::Next::packet);
      EXPECT_EQ(device->next(packet, std::chrono::nanoseconds(timeout)), driver::Next::timeout);
    }
  }
}

TEST(CameraDevice, SizesThatNoBoardTakes) {
  EXPECT_THROW(
      camera::make_camera_device(std::make_unique<ListedCamera>(2, 10, std::vector<ListedCamera::Listed>{}), {}),
      UserError);
  EXPECT_THROW(
      camera::make_camera_device(std::make_unique<ListedCamera>(2160, 3840, std::vector<ListedCamera::Listed>{}), {}),
      UserError);
  EXPECT_NO_THROW(
      camera::make_camera_device(std::make_unique<ListedCamera>(1080, 1920, std::vector<ListedCamera::Listed>{}), {}));
}

}  // namespace
}  // namespace selfproj::test
