// A packet in Python: its header, and arrays that lead to where its bytes are.
#ifndef SELFPROJ_PYTHON_BINDINGS_PACKET_VIEW_H
#define SELFPROJ_PYTHON_BINDINGS_PACKET_VIEW_H

#include <cstddef>
#include <cstdint>
#include <memory>
#include <utility>

#include "python/bindings/arrays.h"
#include "selfproj/model/packet.h"

namespace selfproj::python {

// The place of a packet in a device, or in the array from which it was parsed. A device frees it when the next packet
// is asked for; it must not while arrays lead to it.
struct Place {
  bool current = true;  // false once the device has freed it
  int uses = 0;         // arrays and kernels that read it; changed with the GIL
};

class PacketHandle {
 public:
  // `owner` is the array or device, which lives as long as the packet and the arrays that lead to it.
  PacketHandle(const model::PacketView& view, nb::object owner, std::shared_ptr<Place> place)
      : view_(view), owner_(std::move(owner)), place_(std::move(place)) {}

  [[nodiscard]] const model::PacketHeader& header() const { return view_.header; }
  [[nodiscard]] std::uint32_t status() const { return view_.status; }
  [[nodiscard]] std::size_t size() const { return view_.size; }

  // The packet in place. Throws ValueError if the device has moved on. A kernel that reads it without the GIL holds a
  // Use meanwhile.
  [[nodiscard]] const model::PacketView& view() const {
    require(place_->current, "the device has moved on from this packet; take a copy() before that");
    return view_;
  }

  class Use {
   public:
    explicit Use(const PacketHandle& packet) : place_(packet.place_) { ++place_->uses; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;
    ~Use() { --place_->uses; }

   private:
    std::shared_ptr<Place> place_;
  };

  // The whole packet, and its payload: read-only arrays in place.
  [[nodiscard]] Out<const std::uint8_t> bytes() const { return array_of_bytes(view().bytes().data(), view_.size); }
  [[nodiscard]] Out<const std::uint8_t> payload() const {
    return array_of_bytes(view().payload.data(), view_.payload.size());
  }

 private:
  [[nodiscard]] Out<const std::uint8_t> array_of_bytes(const std::uint8_t* data, std::size_t count) const {
    auto use = std::make_unique<PacketHandle>(*this);
    const nb::capsule owner(use.get(), [](void* memory) noexcept {
      const std::unique_ptr<PacketHandle> kept(static_cast<PacketHandle*>(memory));
      --kept->place_->uses;
    });
    static_cast<void>(use.release());
    ++place_->uses;
    return {data, 1, &count, owner};
  }

  model::PacketView view_;
  nb::object owner_;
  std::shared_ptr<Place> place_;
};

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_PACKET_VIEW_H
