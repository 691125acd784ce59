// A buffer that a consumer announced, and what lies where in it: the parts, then the chunks.
#ifndef SELFPROJ_HOST_GENTL_BUFFER_H
#define SELFPROJ_HOST_GENTL_BUFFER_H

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "host/gentl/gentl_types.h"
#include "host/gentl/module.h"
#include "selfproj/driver/counters.h"

namespace selfproj::gentl {

// Pixel formats of the GenICam Pixel Format Naming Convention, and the SFNC's numbers of components.
inline constexpr std::uint64_t kMono16 = 0x01100007;
inline constexpr std::uint64_t kCoord3dC32f = 0x012000BF;
inline constexpr std::uint64_t kCoord3dAbc32f = 0x026000C0;
inline constexpr std::int64_t kIntensityId = 1;
inline constexpr std::int64_t kRangeId = 4;

// IDs of the chunks, which hold 8-byte numbers, little endian.
inline constexpr std::uint32_t kFrameChunk = 0x5E1F0001;  // frame ID, time stamp in ns, lines
inline constexpr std::uint32_t kCountersChunk =
    0x5E1F0002;  // Counters in the order of kCounterNames, then two of the source
inline constexpr std::uint32_t kLinesChunk = 0x5E1F0003;  // for each line: frame number, time stamp in ns, encoder
inline constexpr std::size_t kFrameChunkBytes = 24;
inline constexpr std::size_t kCountersChunkBytes = 8 * (driver::kCounterNames.size() + 2);
inline constexpr std::size_t kLineBytes = 24;

inline constexpr int kMaxLines = 8192;  // in a buffer

struct FramePart {
  std::int64_t component = kRangeId;
  std::uint64_t format = kCoord3dAbc32f;
  std::size_t pixel_bytes = 12;
  std::size_t offset = 0;
};

struct FrameLayout {
  int columns = 0;
  int height = 0;     // lines of a full buffer
  bool range = true;  // at least one of range and intensity is true
  bool intensity = false;
  bool abc = true;  // Coord3D_ABC32f, else Coord3D_C32f
  bool chunks = false;

  [[nodiscard]] std::size_t pixels() const {
    return static_cast<std::size_t>(columns) * static_cast<std::size_t>(height);
  }

  [[nodiscard]] std::vector<FramePart> parts() const {
    std::vector<FramePart> found;
    std::size_t offset = 0;
    if (range) {
      found.push_back({kRangeId, abc ? kCoord3dAbc32f : kCoord3dC32f, abc ? std::size_t{12} : std::size_t{4}, 0});
      offset = aligned(pixels() * found.back().pixel_bytes);
    }
    if (intensity) {
      found.push_back({kIntensityId, kMono16, 2, offset});
    }
    return found;
  }

  [[nodiscard]] std::size_t chunk_offset() const {
    const FramePart last = parts().back();
    return aligned(last.offset + pixels() * last.pixel_bytes);
  }

  // The places of the chunks in a buffer with this number of lines.
  [[nodiscard]] std::vector<SINGLE_CHUNK_DATA> chunk_places(int lines) const {
    if (!chunks) {
      return {};
    }
    const auto at = static_cast<std::ptrdiff_t>(chunk_offset());
    const auto counters = at + static_cast<std::ptrdiff_t>(kFrameChunkBytes);
    const auto rest = counters + static_cast<std::ptrdiff_t>(kCountersChunkBytes);
    return {{kFrameChunk, at, kFrameChunkBytes},
            {kCountersChunk, counters, kCountersChunkBytes},
            {kLinesChunk, rest, static_cast<std::size_t>(lines) * kLineBytes}};
  }

  [[nodiscard]] std::size_t chunk_bytes() const {
    return chunks ? kFrameChunkBytes + kCountersChunkBytes + static_cast<std::size_t>(height) * kLineBytes : 0;
  }

  [[nodiscard]] std::size_t payload_bytes() const {
    const FramePart last = parts().back();
    return chunks ? chunk_offset() + chunk_bytes() : last.offset + pixels() * last.pixel_bytes;
  }

 private:
  static std::size_t aligned(std::size_t bytes) { return (bytes + 15) / 16 * 16; }
};

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
