// A camera without a board in the GenTL producer: Aravis' GigE camera on a loopback of its own.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <vector>

#include "tests/host/camera/gige_camera.h"
#include "tests/outside/gentl/consumer.h"
#include "tests/outside/gentl/producer.h"

namespace selfproj::test {
namespace {

constexpr std::uint64_t kPictures = 40;  // the camera draws them again and again
constexpr const char* kCamera = "camera:127.0.0.1";
constexpr const char* kDevice =
    "camera:127.0.0.1?rate=100&mode=grey-over&threshold=60&name=without a board&buffers=500";

void draw(const Picture& picture) {
  const std::vector<std::uint8_t> pixels = pixels_of_frame(picture.number % kPictures, picture.columns);
  const std::size_t bytes = static_cast<std::size_t>(picture.rows) * static_cast<std::size_t>(picture.columns);
  std::fill_n(picture.pixels, bytes, std::uint8_t{0});
  std::copy_n(pixels.begin(), std::min(bytes, pixels.size()), picture.pixels);
}

using GenTLCamera = OnOwnNetwork;

bool is_picture(std::uint64_t picture, const float* range, const std::uint16_t* lit, Expected& expected) {
  const light_section::Profile& profile = expected.of(picture % kPictures);
  for (int column = 0; column < kColumns; ++column, range += 3, ++lit) {
    const auto at = static_cast<std::size_t>(column);
    if (!same_bits(range[0], profile.x[at]) || !same_bits(range[1], profile.y[at]) ||
        !same_bits(range[2], profile.z[at]) || *lit != expected.lit(column)) {
      return false;
    }
  }
  return true;
}

// The numbers of the frames in the chunks of a buffer.
std::vector<std::uint64_t> frame_numbers(const OpenCamera& camera, BUFFER_HANDLE buffer, std::size_t lines) {
  std::size_t chunks = 3;
  std::vector<SINGLE_CHUNK_DATA> places(chunks);
  EXPECT_EQ(GC(DSGetBufferChunkData)(camera.stream, buffer, places.data(), &chunks), GC_ERR_SUCCESS);
  std::vector<std::uint64_t> numbers(lines);
  const std::uint8_t* chunk = camera.info<const std::uint8_t*>(buffer, BUFFER_INFO_BASE) + places[2].ChunkOffset;
  for (std::uint64_t& number : numbers) {
    std::memcpy(&number, chunk, sizeof number);
    chunk += 24;
  }
  return numbers;
}

// Every line is that of the picture which its number says, to the last bit, and the driver counts no loss that the
// numbers do not show.
TEST_F(GenTLCamera, LinesAreThoseOfThePictures) {
  const GigeCamera gige(draw);
  const OpenSystem system(kDevice);
  OpenCamera camera(system, kCamera);
  EXPECT_EQ(camera.get("Threshold"), 60);
  EXPECT_EQ(camera.get("MomentsMode"), 2);
  expect_failure(camera.set("Threshold", 61), GC_ERR_ACCESS_DENIED, "Threshold cannot be written");
  EXPECT_EQ(camera.set("Height", 16), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ComponentSelector", 1), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ComponentEnable", 1), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ChunkModeActive", 1), GC_ERR_SUCCESS);
  camera.announce(4);
  camera.start();
  Expected expected(0);  // a camera without a board has no encoder
  std::optional<std::uint64_t> shift;
  std::uint64_t after = 0;
  for (int i = 0; i < 8; ++i) {
    BUFFER_HANDLE buffer = nullptr;
    ASSERT_EQ(camera.next(buffer), GC_ERR_SUCCESS) << last_failure().text;
    ASSERT_EQ(camera.part_info<std::size_t>(buffer, 0, BUFFER_PART_INFO_HEIGHT), 16U);
    const auto* range = camera.part_info<const float*>(buffer, 0, BUFFER_PART_INFO_BASE);
    const auto* lit = camera.part_info<const std::uint16_t*>(buffer, 1, BUFFER_PART_INFO_BASE);
    for (const std::uint64_t number : frame_numbers(camera, buffer, 16)) {
      for (std::uint64_t k = 0; k < kPictures && !shift; ++k) {  // images before the first one may have been lost
        shift = is_picture(number + k, range, lit, expected) ? std::optional(k) : std::nullopt;
      }
      ASSERT_TRUE(shift.has_value());
      ASSERT_TRUE(is_picture(number + *shift, range, lit, expected)) << number;
      EXPECT_GE(number, after);
      after = number + 1;
      range += std::size_t{3} * kColumns;
      lit += kColumns;
    }
    EXPECT_EQ(GC(DSQueueBuffer)(camera.stream, buffer), GC_ERR_SUCCESS);
  }
  EXPECT_GE(camera.get("CountDelivered") + camera.get("CountMissing"), static_cast<std::int64_t>(after));
}

TEST_F(GenTLCamera, ACameraThatIsUnplugged) {
  auto gige = std::make_unique<GigeCamera>(draw);
  const OpenSystem system(kDevice);
  OpenCamera camera(system, kCamera);
  EXPECT_EQ(camera.set("Height", 4), GC_ERR_SUCCESS);
  camera.announce(2);
  camera.start();
  BUFFER_HANDLE buffer = nullptr;
  ASSERT_EQ(camera.next(buffer), GC_ERR_SUCCESS) << last_failure().text;
  gige.reset();
  GC_ERROR result = GC_ERR_SUCCESS;
  while (result == GC_ERR_SUCCESS) {  // what it left
    result = camera.next(buffer);
    EXPECT_TRUE(result != GC_ERR_SUCCESS || GC(DSQueueBuffer)(camera.stream, buffer) == GC_ERR_SUCCESS);
  }
  EXPECT_EQ(result, GC_ERR_IO);
  EXPECT_NE(last_failure().text.find(kCamera), std::string::npos) << last_failure().text;
}

TEST_F(GenTLCamera, OpenedAndClosedAgainAndAgain) {
  const GigeCamera gige(draw);
  for (int i = 0; i < 5; ++i) {
    const OpenSystem system(kDevice);
    OpenCamera camera(system, kCamera);
    DEV_HANDLE second = nullptr;
    expect_failure(system.open(kCamera, second), GC_ERR_RESOURCE_IN_USE, "has it open already");
    EXPECT_EQ(camera.set("Height", 2), GC_ERR_SUCCESS);
    camera.announce(2);
    camera.start();
    BUFFER_HANDLE buffer = nullptr;
    ASSERT_EQ(camera.next(buffer), GC_ERR_SUCCESS) << last_failure().text;
  }
}

// A region that is not the rig's: the first line is refused, and the reason is said.
TEST_F(GenTLCamera, ARegionThatTheRigDoesNotHave) {
  const GigeCamera gige(draw);
  const OpenSystem system("camera:127.0.0.1?region=256x96&rate=100");
  DEV_HANDLE device = nullptr;
  if (system.open(kCamera, device) != GC_ERR_SUCCESS) {  // the first image has come already
    expect_failure(GC_ERR_IO, GC_ERR_IO, "its frames are 256 x 96 pixels, those of the rig 512 x 96");
    return;
  }
  EXPECT_EQ(GC(DevClose)(device), GC_ERR_SUCCESS);
  OpenCamera camera(system, kCamera);
  camera.announce(1);
  camera.start();
  BUFFER_HANDLE buffer = nullptr;
  expect_failure(camera.next(buffer), GC_ERR_IO, "its frames are 256 x 96 pixels, those of the rig 512 x 96");
}

}  // namespace
}  // namespace selfproj::test
