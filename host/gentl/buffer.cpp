#include "host/gentl/buffer.h"

#include "host/gentl/answer.h"

namespace selfproj::gentl {
namespace {

// What is asked of the only part of a buffer.
const FramePart& only_part(const std::vector<FramePart>& parts) {
  require(parts.size() == 1, GC_ERR_NOT_AVAILABLE, "the buffer has parts; ask DSGetBufferPartInfo");
  return parts.front();
}

void give_of_data(const BufferContents& contents, BUFFER_INFO_CMD command, const Answer& to) {
  const FrameLayout& layout = contents.layout;
  const std::vector<FramePart> parts = layout.parts();
  switch (command) {
    case BUFFER_INFO_TIMESTAMP:
      return give(contents.time_stamp, to);
    case BUFFER_INFO_TIMESTAMP_NS:
      return give(contents.time_stamp_ns, to);
    case BUFFER_INFO_SIZE_FILLED:
    case BUFFER_INFO_DATA_SIZE:
      return give_size(contents.lines > 0 ? layout.payload_bytes() : 0, to);
    case BUFFER_INFO_WIDTH:
      return give_size((only_part(parts), static_cast<std::size_t>(layout.columns)), to);
    case BUFFER_INFO_HEIGHT:
    case BUFFER_INFO_DELIVERED_IMAGEHEIGHT:
      return give_size((only_part(parts), static_cast<std::size_t>(contents.lines)), to);
    case BUFFER_INFO_XOFFSET:
    case BUFFER_INFO_YOFFSET:
    case BUFFER_INFO_XPADDING:
    case BUFFER_INFO_YPADDING:
    case BUFFER_INFO_IMAGEOFFSET:
      return give_size((only_part(parts), std::size_t{0}), to);
    case BUFFER_INFO_FRAMEID:
      return give(contents.frame_id, to);
    case BUFFER_INFO_IMAGEPRESENT:
      return give(contents.lines > 0, to);
    case BUFFER_INFO_PAYLOADTYPE:
      return give(parts.size() == 1 ? std::uint64_t{PAYLOAD_TYPE_IMAGE} : std::uint64_t{PAYLOAD_TYPE_MULTI_PART}, to);
    case BUFFER_INFO_PIXELFORMAT:
      return give(only_part(parts).format, to);
    case BUFFER_INFO_PIXELFORMAT_NAMESPACE:
      return give((only_part(parts), std::uint64_t{PIXELFORMAT_NAMESPACE_PFNC_32BIT}), to);
    case BUFFER_INFO_PIXEL_ENDIANNESS:
      return give(std::int32_t{PIXELENDIANNESS_LITTLE}, to);
    case BUFFER_INFO_DELIVERED_CHUNKPAYLOADSIZE:
      return give_size(layout.chunk_bytes(), to);
    case BUFFER_INFO_CHUNKLAYOUTID:
      return give(std::uint64_t{0}, to);
    case BUFFER_INFO_CONTAINS_CHUNKDATA:
      return give(layout.chunks && contents.lines > 0, to);
    case BUFFER_INFO_DATA_LARGER_THAN_BUFFER:
      return give(false, to);
    default:
      no_answer(command);
  }
}

}  // namespace

void Buffer::describe(FeatureSet& features) {
  features.add(text_feature("BufferInformation", "BufferID", "The number of the buffer in its stream.",
                            [this] { return id(); }));
}

void give_buffer_info(const Buffer& buffer, const BufferContents& contents, BUFFER_INFO_CMD command, const Answer& to) {
  const BufferState state = buffer.state;
  switch (command) {
    case BUFFER_INFO_BASE:
      return give(static_cast<void*>(buffer.memory()), to);
    case BUFFER_INFO_SIZE:
      return give_size(buffer.bytes(), to);
    case BUFFER_INFO_USER_PTR:
      return give(buffer.user(), to);
    case BUFFER_INFO_NEW_DATA:
      return give(contents.new_data, to);
    case BUFFER_INFO_IS_QUEUED:
      return give(state != BufferState::unqueued, to);
    case BUFFER_INFO_IS_ACQUIRING:
      return give(state == BufferState::filling, to);
    case BUFFER_INFO_IS_INCOMPLETE:
      return give(false, to);
    case BUFFER_INFO_TLTYPE:
      return give(kTransport, to);
    default:
      require(contents.lines > 0, GC_ERR_NO_DATA, "the buffer has no data yet");
      give_of_data(contents, command, to);
  }
}

void give_part_info(const Buffer& buffer, const BufferContents& contents, std::uint32_t index,
                    BUFFER_PART_INFO_CMD command, const Answer& to) {
  require(contents.lines > 0, GC_ERR_NO_DATA, "the buffer has no data yet");
  const std::vector<FramePart> parts = contents.layout.parts();
  require(index < parts.size(), GC_ERR_INVALID_INDEX, "the buffer has fewer parts");
  const FramePart& part = parts[index];
  switch (command) {
    case BUFFER_PART_INFO_BASE:
      return give(static_cast<void*>(buffer.memory() + part.offset), to);
    case BUFFER_PART_INFO_DATA_SIZE:
      return give_size(contents.part_bytes(part), to);
    case BUFFER_PART_INFO_DATA_TYPE:
      return give(
          part.component == kRangeId ? std::uint64_t{PART_DATATYPE_3D_IMAGE} : std::uint64_t{PART_DATATYPE_2D_IMAGE},
          to);
    case BUFFER_PART_INFO_DATA_FORMAT:
      return give(part.format, to);
    case BUFFER_PART_INFO_DATA_FORMAT_NAMESPACE:
      return give(std::uint64_t{PIXELFORMAT_NAMESPACE_PFNC_32BIT}, to);
    case BUFFER_PART_INFO_WIDTH:
      return give_size(static_cast<std::size_t>(contents.layout.columns), to);
    case BUFFER_PART_INFO_HEIGHT:
    case BUFFER_PART_INFO_DELIVERED_IMAGEHEIGHT:
      return give_size(static_cast<std::size_t>(contents.lines), to);
    case BUFFER_PART_INFO_XOFFSET:
    case BUFFER_PART_INFO_YOFFSET:
    case BUFFER_PART_INFO_XPADDING:
      return give_size(0, to);
    case BUFFER_PART_INFO_SOURCE_ID:
      return give(std::uint64_t{0}, to);
    default:
      no_answer(command);
  }
}

}  // namespace selfproj::gentl
