// A consumer of the GenTL producer, and what it must be given.
#ifndef SELFPROJ_TESTS_OUTSIDE_GENTL_CONSUMER_H
#define SELFPROJ_TESTS_OUTSIDE_GENTL_CONSUMER_H

#include <gtest/gtest.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"
#include "tests/outside/gentl/producer.h"

namespace selfproj::test {

inline constexpr std::uint64_t kSecond = 1000;  // ms

inline void expect_failure(GC_ERROR result, GC_ERROR wanted, const std::string& text) {
  EXPECT_EQ(result, wanted);
  const GenTLFailure failure = last_failure();
  EXPECT_EQ(failure.code, wanted);
  EXPECT_NE(failure.text.find(text), std::string::npos) << failure.text;
}

// A system with its interface. `devices` is what SELFPROJ_GENTL_DEVICES says.
class OpenSystem {
 public:
  explicit OpenSystem(const std::string& devices) {
    setenv("SELFPROJ_GENTL_DEVICES", devices.c_str(), 1);
    EXPECT_EQ(GC(GCInitLib)(), GC_ERR_SUCCESS);
    EXPECT_EQ(GC(TLOpen)(&system), GC_ERR_SUCCESS);
    EXPECT_EQ(GC(TLUpdateInterfaceList)(system, nullptr, 0), GC_ERR_SUCCESS);
    const std::string id = text_of([&](INFO_DATATYPE*, void* to, std::size_t* size) {
      return GC(TLGetInterfaceID)(system, 0, static_cast<char*>(to), size);
    });
    EXPECT_EQ(GC(TLOpenInterface)(system, id.c_str(), &interface), GC_ERR_SUCCESS);
    bool8_t changed = 0;
    EXPECT_EQ(GC(IFUpdateDeviceList)(interface, &changed, 0), GC_ERR_SUCCESS);
  }
  OpenSystem(const OpenSystem&) = delete;
  OpenSystem& operator=(const OpenSystem&) = delete;
  ~OpenSystem() {
    EXPECT_EQ(GC(TLClose)(system), GC_ERR_SUCCESS);
    EXPECT_EQ(GC(GCCloseLib)(), GC_ERR_SUCCESS);
    unsetenv("SELFPROJ_GENTL_DEVICES");
  }

  [[nodiscard]] GC_ERROR open(const std::string& id, DEV_HANDLE& device) const {
    return GC(IFOpenDevice)(interface, id.c_str(), DEVICE_ACCESS_EXCLUSIVE, &device);
  }

  TL_HANDLE system = nullptr;
  IF_HANDLE interface = nullptr;
};

// A device with its port and stream; closed with its system.
struct OpenCamera {
  OpenCamera(const OpenSystem& system, const std::string& id) {
    EXPECT_EQ(system.open(id, device), GC_ERR_SUCCESS) << last_failure().text;
    EXPECT_EQ(GC(DevGetPort)(device, &port), GC_ERR_SUCCESS);
    EXPECT_EQ(GC(DevOpenDataStream)(device, "lines", &stream), GC_ERR_SUCCESS);
    EXPECT_EQ(GC(GCRegisterEvent)(stream, EVENT_NEW_BUFFER, &event), GC_ERR_SUCCESS);
    const std::string url = text_of([&](INFO_DATATYPE* type, void* to, std::size_t* size) {
      return GC(GCGetPortURLInfo)(port, 0, 0 /* URL_INFO_URL */, type, to, size);
    });
    const std::size_t address = url.find(';') + 1;
    const std::size_t length = url.find(';', address) + 1;
    std::size_t bytes = std::stoull(url.substr(length), nullptr, 16);
    xml.resize(bytes);
    EXPECT_EQ(GC(GCReadPort)(port, std::stoull(url.substr(address), nullptr, 16), xml.data(), &bytes), GC_ERR_SUCCESS);
  }

  // The address of the register of a feature, as the XML says.
  [[nodiscard]] std::uint64_t address_of(const std::string& feature) const {
    const std::size_t node = xml.find("Name=\"" + feature + "_Register\"");
    EXPECT_NE(node, std::string::npos) << feature;
    return std::stoull(xml.substr(xml.find("<Address>", node) + 9), nullptr, 16);
  }
  [[nodiscard]] std::int64_t get(const std::string& feature) const {
    std::int64_t value = 0;
    std::size_t size = sizeof value;
    EXPECT_EQ(GC(GCReadPort)(port, address_of(feature), &value, &size), GC_ERR_SUCCESS) << last_failure().text;
    return value;
  }
  [[nodiscard]] GC_ERROR set(const std::string& feature, std::int64_t value) const {
    std::size_t size = sizeof value;
    return GC(GCWritePort)(port, address_of(feature), &value, &size);
  }
  template <typename Value>
  [[nodiscard]] Value stream_info(STREAM_INFO_CMD command) const {
    return answer_of<Value>([&](INFO_DATATYPE* type, void* to, std::size_t* size) {
      return GC(DSGetInfo)(stream, command, type, to, size);
    });
  }

  // Announces and queues buffers.
  void announce(int count) {
    const auto bytes = stream_info<std::size_t>(STREAM_INFO_PAYLOAD_SIZE);
    for (int i = 0; i < count; ++i) {
      BUFFER_HANDLE buffer = nullptr;
      EXPECT_EQ(GC(DSAllocAndAnnounceBuffer)(stream, bytes, this, &buffer), GC_ERR_SUCCESS);
      EXPECT_EQ(GC(DSQueueBuffer)(stream, buffer), GC_ERR_SUCCESS);
    }
  }
  void start() const {
    EXPECT_EQ(GC(DSStartAcquisition)(stream, 0, GENTL_INFINITE), GC_ERR_SUCCESS) << last_failure().text;
    EXPECT_EQ(set("AcquisitionStart", 1), GC_ERR_SUCCESS);
  }
  GC_ERROR next(BUFFER_HANDLE& buffer, std::uint64_t timeout = 20 * kSecond) const {
    EVENT_NEW_BUFFER_DATA data{};
    std::size_t size = sizeof data;
    const GC_ERROR result = GC(EventGetData)(event, &data, &size, timeout);
    buffer = data.BufferHandle;
    return result;
  }
  template <typename Value>
  [[nodiscard]] Value info(BUFFER_HANDLE buffer, BUFFER_INFO_CMD command) const {
    return answer_of<Value>([&](INFO_DATATYPE* type, void* to, std::size_t* size) {
      return GC(DSGetBufferInfo)(stream, buffer, command, type, to, size);
    });
  }
  template <typename Value>
  [[nodiscard]] Value part_info(BUFFER_HANDLE buffer, std::uint32_t part, BUFFER_PART_INFO_CMD command) const {
    return answer_of<Value>([&](INFO_DATATYPE* type, void* to, std::size_t* size) {
      return GC(DSGetBufferPartInfo)(stream, buffer, part, command, type, to, size);
    });
  }

  DEV_HANDLE device = nullptr;
  PORT_HANDLE port = nullptr;
  DS_HANDLE stream = nullptr;
  EVENT_HANDLE event = nullptr;
  std::string xml;
};

// The rig of the packets.
inline rig::Rig rig_of_bits(int bits) {
  rig::Rig rig = rig::load_rig("light-section");
  if (bits > spec::kPixelBits) {
    rig.measure.pixel_bits = bits;
    rig.measure.threshold = measure_of_bits(bits).threshold;
  }
  return rig;
}

// What every frame must become, by the C++ library.
class Expected {
 public:
  // `counts`: how many counts of 0.01 mm each frame moves the encoder.
  // `bits`: of a pixel.
  explicit Expected(int counts = kCountsOfFrame, int bits = spec::kPixelBits)
      : counts_(counts), rig_(rig_of_bits(bits)), profiler_(rig_, light_section::reference_of_plane(rig_)) {
    profile_.resize(kColumns);
  }

  const light_section::Profile& of(std::uint64_t frame) {
    model::PacketView packet;
    bytes_ = packet_of_frame(frame, kColumns, rig_.measure.bits());
    EXPECT_EQ(model::parse_packet(bytes_, packet), model::PacketError::none);
    EXPECT_TRUE(profiler_.profile(packet, profile_.view()));
    // The belt carries x back.
    double travel = 0;
    for (std::uint64_t i = 0; i < frame; ++i) {
      travel += counts_ * rig_.conveyor.encoder_mm_per_count;
    }
    for (float& x : profile_.x) {
      x = static_cast<float>(static_cast<double>(x) - travel);
    }
    model::unpack_columns(packet.header, packet.payload.data(), {lit_.view(), nullptr, nullptr});
    return profile_;
  }
  [[nodiscard]] std::uint32_t lit(int column) const { return lit_.n[static_cast<std::size_t>(column)]; }

 private:
  int counts_;
  rig::Rig rig_;
  light_section::DifferentialProfiler profiler_;
  light_section::Profile profile_;
  model::Moments lit_ = [] {
    model::Moments moments;
    moments.resize(kColumns);
    return moments;
  }();
  std::vector<std::uint8_t> bytes_;
};

// Not a number is the same as itself here.
inline bool same_bits(float one, float other) {
  return std::bit_cast<std::uint32_t>(one) == std::bit_cast<std::uint32_t>(other);
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_OUTSIDE_GENTL_CONSUMER_H
