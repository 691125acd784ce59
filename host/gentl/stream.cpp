// The consumer's side: buffers and queues.
#include "host/gentl/stream.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "host/gentl/gentl_errors.h"
#include "host/gentl/library.h"

namespace selfproj::gentl {

Stream::Stream(std::shared_ptr<Camera> camera, void* parent)
    : Module("TLDataStream", kStreamId),
      camera_(std::move(camera)),
      parent_(parent),
      gate_(camera_->gate()),
      output_(std::make_shared<EventQueue>(EVENT_NEW_BUFFER, sizeof(EVENT_NEW_BUFFER_DATA))) {}

std::shared_ptr<EventQueue> Stream::make_event(EVENT_TYPE type) {
  const std::lock_guard lock(gate_.mutex);
  if (type == EVENT_NEW_BUFFER) {
    output_->reopen();
    return output_;
  }
  errors_ = Module::make_event(type);
  return errors_;
}

void Stream::describe(FeatureSet& features) {
  features.add(text_feature("StreamInformation", "StreamID", "The name of the stream.", [this] { return id(); }));
  features.add(text_feature("StreamInformation", "StreamType", "The transport.", [] { return kTransport; }));
  features.add(number_feature("StreamInformation", "StreamAnnouncedBufferCount", "Buffers that are announced.",
                              [this] { return static_cast<std::int64_t>(buffers_.size()); }));
  features.add(number_feature("StreamInformation", "StreamBufferHandlingModeDefault",
                              "1: the oldest lines come first, and none is left out.", [] { return 1; }));
}

std::shared_ptr<Buffer> Stream::announce(void* memory, std::size_t bytes, void* user) {
  require(bytes > 0, GC_ERR_INVALID_PARAMETER, "a buffer needs at least one byte");
  const bool known = std::any_of(buffers_.begin(), buffers_.end(), [&](const std::shared_ptr<Buffer>& buffer) {
    return memory != nullptr && buffer->memory() == memory;
  });
  require(!known, GC_ERR_RESOURCE_IN_USE, "the buffer is announced already");
  auto buffer = std::make_shared<Buffer>(std::to_string(announced_++), memory, bytes, user);
  buffers_.push_back(buffer);
  give_handle(buffer);
  return buffer;
}

void Stream::require_own(const std::shared_ptr<Buffer>& buffer) const {
  require(std::find(buffers_.begin(), buffers_.end(), buffer) != buffers_.end(), GC_ERR_INVALID_HANDLE,
          "the buffer is one of another stream");
}

void Stream::revoke(const std::shared_ptr<Buffer>& buffer) {
  require_own(buffer);
  require(buffer->state == BufferState::unqueued, GC_ERR_BUSY, "the buffer is queued");
  buffer->close();
  library().remove(buffer->handle);
  buffers_.erase(std::find(buffers_.begin(), buffers_.end(), buffer));
}

void Stream::queue(const std::shared_ptr<Buffer>& buffer) {
  require_own(buffer);
  {
    const std::lock_guard lock(gate_.mutex);
    require(buffer->state == BufferState::unqueued, GC_ERR_BUSY, "the buffer is queued already");
    require(!grabbing_ || buffer->bytes() >= payload_, GC_ERR_BUFFER_TOO_SMALL,
            "the buffer is smaller than PayloadSize");
    buffer->state = BufferState::input;
    input_.push_back(buffer);
  }
  gate_.changed.notify_all();
}

void Stream::put_out(const std::shared_ptr<Buffer>& buffer) {
  buffer->state = BufferState::output;
  const EVENT_NEW_BUFFER_DATA data{buffer->handle, buffer->user()};
  std::vector<std::uint8_t> bytes(sizeof data);
  std::memcpy(bytes.data(), &data, sizeof data);
  output_->push({.data = std::move(bytes), .taken = [buffer] { buffer->state = BufferState::unqueued; }});
}

void Stream::flush(ACQ_QUEUE_TYPE operation) {
  require(operation >= ACQ_QUEUE_INPUT_TO_OUTPUT && operation <= ACQ_QUEUE_ALL_DISCARD, GC_ERR_INVALID_PARAMETER,
          "the operation is none of ACQ_QUEUE_TYPE");
  {
    const std::lock_guard lock(gate_.mutex);
    if (operation == ACQ_QUEUE_INPUT_TO_OUTPUT) {
      for (const std::shared_ptr<Buffer>& buffer : std::exchange(input_, {})) {
        buffer->contents = {};
        put_out(buffer);
      }
    }
    if (operation == ACQ_QUEUE_ALL_DISCARD) {
      for (const std::shared_ptr<Buffer>& buffer : std::exchange(input_, {})) {
        buffer->state = BufferState::unqueued;
      }
    }
    if (operation == ACQ_QUEUE_OUTPUT_DISCARD || operation == ACQ_QUEUE_ALL_DISCARD ||
        operation == ACQ_QUEUE_ALL_TO_INPUT) {
      output_->flush();
    }
    if (operation == ACQ_QUEUE_ALL_TO_INPUT || operation == ACQ_QUEUE_UNQUEUED_TO_INPUT) {
      for (const std::shared_ptr<Buffer>& buffer : buffers_) {
        if (buffer->state == BufferState::unqueued && (!grabbing_ || buffer->bytes() >= payload_)) {
          buffer->state = BufferState::input;
          input_.push_back(buffer);
        }
      }
    }
  }
  gate_.changed.notify_all();
}

void Stream::start(std::uint64_t count) {
  require(!is_acquiring(), GC_ERR_RESOURCE_IN_USE, "the stream is acquiring already");
  require(count > 0, GC_ERR_INVALID_PARAMETER, "the number of buffers to acquire is 0");
  const FrameLayout layout = camera_->layout();
  {
    const std::lock_guard lock(gate_.mutex);
    for (const std::shared_ptr<Buffer>& buffer : input_) {
      require(buffer->bytes() >= layout.payload_bytes(), GC_ERR_BUFFER_TOO_SMALL,
              "a buffer in the input queue is smaller than PayloadSize");
    }
    payload_ = layout.payload_bytes();
    stopping_ = false;
    grabbing_ = true;
    started_ = 0;
    delivered_ = 0;
  }
  output_->begin();
  camera_->source().begin(camera_->belt_carried());
  thread_ = std::thread([this, layout, count] { work(layout, count); });
}

void Stream::stop(ACQ_STOP_FLAGS flags) {
  if (!is_acquiring()) {
    return;
  }
  {
    const std::lock_guard lock(gate_.mutex);
    stopping_ = true;
    discarding_ = flags == ACQ_STOP_FLAGS_KILL;
  }
  gate_.changed.notify_all();
  thread_.join();
  output_->begin();
}

void Stream::give_info(STREAM_INFO_CMD command, const Answer& to) const {
  const std::lock_guard lock(gate_.mutex);
  switch (command) {
    case STREAM_INFO_ID:
      return give(id(), to);
    case STREAM_INFO_NUM_DELIVERED:
      return give(delivered_, to);
    case STREAM_INFO_NUM_UNDERRUN:
      return give(std::uint64_t{0}, to);
    case STREAM_INFO_NUM_ANNOUNCED:
      return give_size(buffers_.size(), to);
    case STREAM_INFO_NUM_QUEUED:
      return give_size(input_.size(), to);
    case STREAM_INFO_NUM_AWAIT_DELIVERY:
      return give_size(output_->size(), to);
    case STREAM_INFO_NUM_STARTED:
      return give(started_, to);
    case STREAM_INFO_PAYLOAD_SIZE:
      return give_size(camera_->layout().payload_bytes(), to);
    case STREAM_INFO_IS_GRABBING:
      return give(grabbing_, to);
    case STREAM_INFO_DEFINES_PAYLOADSIZE:
      return give(true, to);
    case STREAM_INFO_TLTYPE:
      return give(kTransport, to);
    case STREAM_INFO_NUM_CHUNKS_MAX:
      return give_size(camera_->layout().chunk_places(1).size(), to);
    case STREAM_INFO_BUF_ANNOUNCE_MIN:
    case STREAM_INFO_BUF_ALIGNMENT:
      return give_size(1, to);
    default:
      no_answer(command);
  }
}

std::shared_ptr<Buffer> Stream::buffer_at(std::size_t index) const {
  require(index < buffers_.size(), GC_ERR_INVALID_INDEX, "fewer buffers are announced");
  return buffers_[index];
}

BufferContents Stream::contents_of(const Buffer& buffer) const {
  const std::lock_guard lock(gate_.mutex);
  return buffer.contents;
}

void Stream::close() {
  stop(ACQ_STOP_FLAGS_KILL);
  flush(ACQ_QUEUE_ALL_DISCARD);
  while (!buffers_.empty()) {
    revoke(buffers_.back());
  }
  Module::close();
  const std::lock_guard lock(gate_.mutex);
  errors_.reset();
}

}  // namespace selfproj::gentl
