// The device sim: for simulations. The sink of the bus puts beats in, and the host's code takes packets out.
#ifndef SELFPROJ_HOST_DRIVER_SIM_DEVICE_H
#define SELFPROJ_HOST_DRIVER_SIM_DEVICE_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "host/driver/packet_reader.h"
#include "host/driver/packet_tally.h"

namespace selfproj {

// One thread does both sides in turn, so next() never waits. If no whole packet has come, it returns Next::timeout at
// once, and Next::end after finish(). (For two threads or processes use RingWriter and ring:.)
class SimDevice final : public Device {
 public:
  explicit SimDevice(std::size_t buffer_bytes = PacketStreamReader::kDefaultCapacity);

  // Takes a beat of the bus, of spec::kPacketBeatBytes, or any other piece of the stream. `last` is tlast: a packet
  // ends with it. Returns false and takes nothing if the buffer is full; the bus must then stall until packets have
  // been taken out.
  bool push(std::span<const std::uint8_t> bytes, bool last);

  // Call when no more beats will come.
  void finish();

  // Packets whose end on the bus (tlast) is not where their header says. A real DMA would cut the stream there.
  [[nodiscard]] std::uint64_t misframed() const { return misframed_; }

  Next next(PacketView& packet, std::chrono::nanoseconds timeout) override;
  void release() override { held_ = false; }
  [[nodiscard]] std::int64_t arrival_ns() const override { return arrival_ns_; }
  [[nodiscard]] Counters counters() const override { return counters_; }
  [[nodiscard]] const std::string& uri() const override { return uri_; }

 private:
  std::string uri_ = "sim:";
  Counters counters_;
  PacketStreamReader reader_;
  PacketTally tally_;
  std::size_t since_last_ = 0;  // bytes pushed since the last tlast
  std::uint64_t misframed_ = 0;
  bool held_ = false;
  bool finished_ = false;
  std::int64_t arrival_ns_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_SIM_DEVICE_H
