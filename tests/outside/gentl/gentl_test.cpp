// The GenTL producer as a consumer walks through it: system, interface, device, stream, buffers, events.
#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/ring_memory.h"
#include "host/driver/ring_writer.h"
#include "selfproj/driver/device.h"
#include "tests/outside/gentl/consumer.h"
#include "tests/outside/gentl/producer.h"

namespace selfproj::test {
namespace {

// Checks a buffer of parts range and intensity whose first line is frame `first`. Returns its lines.
std::uint64_t check_parts(const OpenCamera& camera, BUFFER_HANDLE buffer, std::uint64_t first, Expected& expected) {
  std::uint32_t parts = 0;
  EXPECT_EQ(GC(DSGetNumBufferParts)(camera.stream, buffer, &parts), GC_ERR_SUCCESS);
  EXPECT_EQ(parts, 2U);
  EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_PAYLOADTYPE), PAYLOAD_TYPE_MULTI_PART);
  EXPECT_EQ(camera.part_info<std::uint64_t>(buffer, 0, BUFFER_PART_INFO_DATA_FORMAT), 0x026000C0U);
  EXPECT_EQ(camera.part_info<std::uint64_t>(buffer, 1, BUFFER_PART_INFO_DATA_FORMAT), 0x01100007U);
  const auto lines = camera.part_info<std::size_t>(buffer, 0, BUFFER_PART_INFO_HEIGHT);
  const auto* range = camera.part_info<const float*>(buffer, 0, BUFFER_PART_INFO_BASE);
  const auto* lit = camera.part_info<const std::uint16_t*>(buffer, 1, BUFFER_PART_INFO_BASE);
  int invalid = 0;
  for (std::size_t line = 0; line < lines; ++line) {
    const light_section::Profile& profile = expected.of(first + line);
    for (int column = 0; column < kColumns; ++column, range += 3, ++lit) {
      const auto at = static_cast<std::size_t>(column);
      const bool same = same_bits(range[0], profile.x[at]) && same_bits(range[1], profile.y[at]) &&
                        same_bits(range[2], profile.z[at]);
      if (!same || *lit != expected.lit(column)) {
        ADD_FAILURE() << "line " << line << ", column " << column;
        return lines;
      }
      invalid += std::isnan(range[2]) ? 1 : 0;
    }
  }
  EXPECT_GT(invalid, 0);
  EXPECT_LT(invalid, static_cast<int>(lines) * kColumns / 2);
  return lines;
}

TEST(GenTL, LinesOfAFile) {
  const PacketFile file("gentl_lines", 25);
  const OpenSystem system(file.uri() + "?name=belt");
  OpenCamera camera(system, file.uri());
  EXPECT_EQ(camera.get("Height"), 64);
  EXPECT_EQ(camera.set("Height", 10), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ComponentSelector", 1), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ComponentEnable", 1), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("ChunkModeActive", 1), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.get("Threshold"), 60);
  EXPECT_EQ(camera.get("MomentsMode"), 2);
  EXPECT_EQ(camera.get("PayloadSize"),
            static_cast<std::int64_t>(camera.stream_info<std::size_t>(STREAM_INFO_PAYLOAD_SIZE)));
  camera.announce(2);
  camera.start();
  Expected expected;
  std::uint64_t line = 0;
  std::uint64_t frame_id = 0;
  BUFFER_HANDLE buffer = nullptr;
  for (; camera.next(buffer) == GC_ERR_SUCCESS; ++frame_id) {
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_FRAMEID), frame_id);
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_TIMESTAMP), 15120 * line);
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_TIMESTAMP_NS), 100000 * line);
    EXPECT_EQ(camera.info<void*>(buffer, BUFFER_INFO_USER_PTR), &camera);
    std::size_t chunks = 0;
    EXPECT_EQ(GC(DSGetBufferChunkData)(camera.stream, buffer, nullptr, &chunks), GC_ERR_SUCCESS);
    std::vector<SINGLE_CHUNK_DATA> places(chunks);
    ASSERT_EQ(GC(DSGetBufferChunkData)(camera.stream, buffer, places.data(), &chunks), GC_ERR_SUCCESS);
    ASSERT_EQ(chunks, 3U);
    std::uint64_t first = 0;
    std::memcpy(&first, camera.info<const std::uint8_t*>(buffer, BUFFER_INFO_BASE) + places[2].ChunkOffset, 8);
    EXPECT_EQ(first, line);
    line += check_parts(camera, buffer, line, expected);
    EXPECT_EQ(GC(DSQueueBuffer)(camera.stream, buffer), GC_ERR_SUCCESS);
  }
  EXPECT_EQ(line, 25U);  // the last buffer has 5
  EXPECT_EQ(frame_id, 3U);
  EXPECT_EQ(camera.get("CountDelivered"), 25);
  expect_failure(camera.next(buffer), GC_ERR_IO, "gentl_lines.slfp: the recording has ended");
  EXPECT_FALSE(camera.stream_info<bool8_t>(STREAM_INFO_IS_GRABBING));
  EXPECT_EQ(GC(DSStopAcquisition)(camera.stream, ACQ_STOP_FLAGS_DEFAULT), GC_ERR_SUCCESS);
}

// Pixels of 12 bits. A rig of other bits is refused.
TEST(GenTL, LinesOfTwelveBits) {
  const std::filesystem::path rig = std::filesystem::temp_directory_path() / "gentl_twelve.yaml";
  std::ofstream(rig) << rig::to_yaml(rig_of_bits(12));
  const PacketFile file("gentl_twelve", 10, kColumns, 12);
  {
    const OpenSystem system(file.uri() + "?rig=" + rig.string());
    OpenCamera camera(system, file.uri());
    EXPECT_EQ(camera.get("Threshold"), 960);
    EXPECT_EQ(camera.set("Height", 10), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.set("ComponentSelector", 1), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.set("ComponentEnable", 1), GC_ERR_SUCCESS);
    camera.announce(2);
    camera.start();
    Expected expected(kCountsOfFrame, 12);
    BUFFER_HANDLE buffer = nullptr;
    ASSERT_EQ(camera.next(buffer), GC_ERR_SUCCESS);
    EXPECT_EQ(check_parts(camera, buffer, 0, expected), 10U);
  }
  const OpenSystem system(file.uri());
  DEV_HANDLE device = nullptr;
  expect_failure(system.open(file.uri(), device), GC_ERR_IO,
                 "its pixels have 12 bits; measure.pixel_bits of the rig is 8");
  std::filesystem::remove(rig);
}

TEST(GenTL, DepthAloneIsAnImage) {
  const PacketFile file("gentl_depth", 8);
  const OpenSystem system(file.uri());
  OpenCamera camera(system, file.uri());
  EXPECT_EQ(camera.set("Height", 4), GC_ERR_SUCCESS);
  EXPECT_EQ(camera.set("PixelFormat", 0x012000BF), GC_ERR_SUCCESS);
  camera.announce(3);
  camera.start();
  BUFFER_HANDLE buffer = nullptr;
  Expected expected;
  for (std::uint64_t line = 0; line < 8; line += 4) {
    ASSERT_EQ(camera.next(buffer), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_PAYLOADTYPE), PAYLOAD_TYPE_IMAGE);
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_PIXELFORMAT), 0x012000BFU);
    EXPECT_EQ(camera.info<std::size_t>(buffer, BUFFER_INFO_SIZE_FILLED), 4U * kColumns * sizeof(float));
    EXPECT_EQ(camera.info<std::size_t>(buffer, BUFFER_INFO_HEIGHT), 4U);
    const auto* z = camera.info<const float*>(buffer, BUFFER_INFO_BASE);
    for (std::uint64_t i = 0; i < 4; ++i) {
      const std::vector<float>& wanted = expected.of(line + i).z;
      EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), z + i * kColumns, same_bits));
    }
  }
  // Features that change the size of buffers are locked where the consumer says so; some cannot be written at all.
  EXPECT_EQ(camera.set("TLParamsLocked", 1), GC_ERR_SUCCESS);
  expect_failure(camera.set("Height", 5), GC_ERR_ACCESS_DENIED, "Height cannot be written while TLParamsLocked is 1");
  expect_failure(camera.set("Width", 5), GC_ERR_ACCESS_DENIED, "Width can only be read");
  expect_failure(camera.set("Threshold", 5), GC_ERR_ACCESS_DENIED, "Threshold cannot be written");
  EXPECT_EQ(camera.set("TLParamsLocked", 0), GC_ERR_SUCCESS);
  expect_failure(camera.set("Height", 0), GC_ERR_INVALID_VALUE, "Height cannot be 0");
  expect_failure(camera.set("PixelFormat", 0x01100007), GC_ERR_INVALID_VALUE, "PixelFormat cannot be");
  expect_failure(camera.set("ComponentEnable", 0), GC_ERR_INVALID_VALUE, "at least one component");
}

TEST(GenTL, WrongCallsSayWhatIsWrong) {
  TL_HANDLE none = nullptr;
  expect_failure(GC(TLOpen)(&none), GC_ERR_NOT_INITIALIZED, "GCInitLib was not called");
  const PacketFile file("gentl_wrong", 2);
  const PacketFile narrow("gentl_narrow", 2, 64);
  const OpenSystem system("file:/no/such/line.slfp;fil:x;camera:x?control=bar:y;camera:y?exposure=5;" + narrow.uri() +
                          ";" + file.uri() + ";ring:none?rig=no-such-rig;ring:gone;file:x?gap=1;file:y?rig=scanner");
  expect_failure(GC(GCInitLib)(), GC_ERR_RESOURCE_IN_USE, "already");
  expect_failure(GC(TLOpen)(&none), GC_ERR_RESOURCE_IN_USE, "already");
  std::uint32_t devices = 0;
  EXPECT_EQ(GC(IFGetNumDevices)(system.interface, &devices), GC_ERR_SUCCESS);
  EXPECT_GE(devices, 9U);
  const std::map<std::string, std::string> wrong{
      {"file:/no/such/line.slfp", "/no/such/line.slfp: No such file"},
      {"fil:x", "fil:x: is not a device"},
      {"camera:x", "camera:x: SELFPROJ_GENTL_DEVICES has 'control=bar:y', but a camera"},
      {"camera:y", "'exposure' is not a setting of a camera"},
      {narrow.uri(), "its frames are 64 x 96 pixels, those of the rig 512"},
      {"ring:none", "no-such-rig"},
      {"ring:gone", "ring:gone: there is no such ring"},
      {"file:x", "has 'gap=1' behind '?'; use rig=RIG"},
      {"file:y", "scanner: is not a rig of kind light-section"}};
  DEV_HANDLE device = nullptr;
  for (const auto& [id, text] : wrong) {
    expect_failure(system.open(id, device), GC_ERR_IO, text);
  }
  expect_failure(system.open("file:unlisted", device), GC_ERR_INVALID_ID, "SELFPROJ_GENTL_DEVICES");

  ASSERT_EQ(system.open(file.uri(), device), GC_ERR_SUCCESS);
  DEV_HANDLE second = nullptr;
  expect_failure(system.open(file.uri(), second), GC_ERR_RESOURCE_IN_USE, "has it open already");
  DS_HANDLE stream = nullptr;
  expect_failure(GC(DevOpenDataStream)(device, "points", &stream), GC_ERR_INVALID_ID, "no such data stream");
  ASSERT_EQ(GC(DevOpenDataStream)(device, "lines", &stream), GC_ERR_SUCCESS);
  BUFFER_HANDLE buffer = nullptr;
  ASSERT_EQ(GC(DSAllocAndAnnounceBuffer)(stream, 100, nullptr, &buffer), GC_ERR_SUCCESS);
  ASSERT_EQ(GC(DSQueueBuffer)(stream, buffer), GC_ERR_SUCCESS);
  expect_failure(GC(DSStartAcquisition)(stream, 0, GENTL_INFINITE), GC_ERR_BUFFER_TOO_SMALL, "PayloadSize");
  expect_failure(GC(DSRevokeBuffer)(stream, buffer, nullptr, nullptr), GC_ERR_BUSY, "queued");
  expect_failure(GC(GCReadPort)(device, 1, &devices, nullptr), GC_ERR_INVALID_PARAMETER, "null");
  std::size_t size = 4;
  expect_failure(GC(GCReadPort)(device, 1, &devices, &size), GC_ERR_INVALID_ADDRESS, "no register");
  EXPECT_EQ(GC(DevClose)(device), GC_ERR_SUCCESS);  // closes what is below it
  expect_failure(GC(DSQueueBuffer)(stream, buffer), GC_ERR_INVALID_HANDLE, "not that of an open module");
  expect_failure(GC(DevClose)(system.interface), GC_ERR_INVALID_HANDLE, "another kind of module");
  ASSERT_EQ(system.open(file.uri(), device), GC_ERR_SUCCESS);
}

TEST(GenTL, WaitsEnd) {
  const PacketFile file("gentl_waits", 2);
  const OpenSystem system(file.uri());
  const OpenCamera camera(system, file.uri());
  EVENT_HANDLE again = nullptr;
  expect_failure(GC(GCRegisterEvent)(camera.stream, EVENT_NEW_BUFFER, &again), GC_ERR_RESOURCE_IN_USE, "already");
  expect_failure(GC(GCRegisterEvent)(camera.device, EVENT_NEW_BUFFER, &again), GC_ERR_NOT_IMPLEMENTED, "no event");
  BUFFER_HANDLE buffer = nullptr;
  expect_failure(camera.next(buffer, 1), GC_ERR_TIMEOUT, "in time");
  GC_ERROR killed = GC_ERR_SUCCESS;
  std::thread waiter([&] {
    BUFFER_HANDLE none = nullptr;
    killed = camera.next(none, GENTL_INFINITE);
  });
  EXPECT_EQ(GC(EventKill)(camera.event), GC_ERR_SUCCESS);  // the wait that began, or the next one
  waiter.join();
  EXPECT_EQ(killed, GC_ERR_ABORT);
  std::thread other([&] {
    BUFFER_HANDLE none = nullptr;
    killed = camera.next(none, GENTL_INFINITE);
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
  EXPECT_EQ(GC(GCUnregisterEvent)(camera.stream, EVENT_NEW_BUFFER), GC_ERR_SUCCESS);
  other.join();
  EXPECT_TRUE(killed == GC_ERR_ABORT || killed == GC_ERR_INVALID_HANDLE);  // the second if it had not begun to wait
  EXPECT_EQ(GC(GCRegisterEvent)(camera.stream, EVENT_NEW_BUFFER, &again), GC_ERR_SUCCESS);
}

TEST(GenTL, ARingOfThisMachine) {
  const std::string name = "gentl-test-" + std::to_string(getpid());
  auto board = std::make_unique<driver::RingWriter>(name, 64);
  {
    const OpenSystem system("");
    {
      const auto reader = driver::open_device("ring:" + name);
      DEV_HANDLE device = nullptr;
      expect_failure(system.open("ring:" + name, device), GC_ERR_RESOURCE_IN_USE, "another reader has it open");
    }
    OpenCamera camera(system, "ring:" + name);
    EVENT_HANDLE errors = nullptr;
    EXPECT_EQ(GC(GCRegisterEvent)(camera.stream, EVENT_ERROR, &errors), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.set("Height", 5), GC_ERR_SUCCESS);
    camera.announce(2);
    camera.start();
    BUFFER_HANDLE buffer = nullptr;
    for (std::uint64_t frame = 0; frame < 12; ++frame) {
      EXPECT_TRUE(board->write(packet_of_frame(frame)));
    }
    EXPECT_EQ(camera.next(buffer), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.next(buffer), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.info<std::uint64_t>(buffer, BUFFER_INFO_TIMESTAMP), 5U * 15120);
    // Without a queued buffer the lines wait in the ring; the board goes away, and what it left comes all the same.
    EXPECT_EQ(GC(DSQueueBuffer)(camera.stream, buffer), GC_ERR_SUCCESS);
    board.reset();
    EXPECT_EQ(camera.next(buffer), GC_ERR_SUCCESS);
    EXPECT_EQ(camera.info<std::size_t>(buffer, BUFFER_INFO_HEIGHT), 2U);
    expect_failure(camera.next(buffer), GC_ERR_IO, name + ": the board has gone");
    std::vector<char> error(1024);
    std::size_t size = error.size();
    EXPECT_EQ(GC(EventGetData)(errors, error.data(), &size, 0), GC_ERR_SUCCESS);
    const std::string text = text_of([&](INFO_DATATYPE* type, void* to, std::size_t* bytes) {
      return GC(EventGetDataInfo)(errors, error.data(), size, EVENT_DATA_VALUE, type, to, bytes);
    });
    EXPECT_NE(text.find("the board has gone"), std::string::npos) << text;
  }
  driver::remove_ring(name);
}

}  // namespace
}  // namespace selfproj::test
