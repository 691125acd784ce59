// The device sim: for simulations. The sink of the bus puts beats in, and the host's code takes packets out.
#ifndef SELFPROJ_HOST_DRIVER_SIM_DEVICE_H
#define SELFPROJ_HOST_DRIVER_SIM_DEVICE_H

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "host/driver/device_kinds.h"
#include "selfproj/driver/packet_reader.h"

namespace selfproj::driver {

// One thread does both sides in turn, so next() never waits. If no whole packet has come, it returns Next::timeout at
// once, and Next::end after finish(). (For two threads or processes use RingWriter and ring:.)
class SimDevice final : public TalliedDevice {
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

  Next next(model::PacketView& packet, std::chrono::nanoseconds timeout) override;
  void release() override { held_ = false; }

 private:
  PacketStreamReader reader_;
  std::size_t since_last_ = 0;  // bytes pushed since the last tlast
  std::uint64_t misframed_ = 0;
  bool held_ = false;
  bool finished_ = false;
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_HOST_DRIVER_SIM_DEVICE_H
