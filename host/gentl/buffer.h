// A buffer that a consumer announced.
#ifndef SELFPROJ_HOST_GENTL_BUFFER_H
#define SELFPROJ_HOST_GENTL_BUFFER_H

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/gentl/frame_layout.h"
#include "host/gentl/module.h"

namespace selfproj::gentl {

enum class BufferState : std::uint8_t {
  unqueued,  // the consumer has it
  input,     // waits to be filled
  filling,
  output,  // filled, waits for the consumer
};

// What a delivered buffer holds.
struct BufferContents {
  bool new_data = false;
  FrameLayout layout;
  int lines = 0;
  std::uint64_t frame_id = 0;
  std::uint64_t time_stamp = 0;  // of the first line, in clocks of the board
  std::uint64_t time_stamp_ns = 0;

  // Bytes of the part for all lines that it holds.
  [[nodiscard]] std::size_t part_bytes(const FramePart& part) const {
    return static_cast<std::size_t>(layout.columns) * static_cast<std::size_t>(lines) * part.pixel_bytes;
  }
};

class Buffer final : public Module {
 public:
  // Uses the consumer's memory, or allocates its own if `memory` is null.
  Buffer(std::string id, void* memory, std::size_t bytes, void* user)
      : Module("TLBuffer", std::move(id)),
        own_(memory == nullptr ? bytes : 0),
        memory_(memory == nullptr ? own_.data() : static_cast<std::uint8_t*>(memory)),
        bytes_(bytes),
        user_(user) {}

  [[nodiscard]] std::uint8_t* memory() const { return memory_; }
  [[nodiscard]] std::size_t bytes() const { return bytes_; }
  [[nodiscard]] void* user() const { return user_; }
  [[nodiscard]] bool is_own() const { return !own_.empty(); }

  std::atomic<BufferState> state = BufferState::unqueued;
  BufferContents contents;  // under the stream's lock

 private:
  void describe(FeatureSet& features) override;

  std::vector<std::uint8_t> own_;
  std::uint8_t* memory_;
  std::size_t bytes_;
  void* user_;
};

// Answer DSGetBufferInfo and DSGetBufferPartInfo. Throw GC_ERR_NOT_IMPLEMENTED for a command that they do not know,
// GC_ERR_NO_DATA before there are data, GC_ERR_NOT_AVAILABLE for information that a buffer with parts does not have,
// and GC_ERR_INVALID_INDEX.
void give_buffer_info(const Buffer& buffer, const BufferContents& contents, BUFFER_INFO_CMD command, const Answer& to);
void give_part_info(const Buffer& buffer, const BufferContents& contents, std::uint32_t index,
                    BUFFER_PART_INFO_CMD command, const Answer& to);

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_BUFFER_H
