#include "host/gentl/stream.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstring>
#include <exception>
#include <utility>

#include "host/gentl/answer.h"
#include "host/gentl/module.h"

namespace selfproj::gentl {
namespace {

constexpr auto kPatience = std::chrono::milliseconds(20);  // so that a stop is noticed

template <typename Number>
void store(std::uint8_t* to, Number value) {
  std::memcpy(to, &value, sizeof value);
}

// Why a device gives no further line.
std::string end_text(const std::string& uri) {
  return uri + (uri.starts_with("ring:") ? ": the board has gone; no further line comes"
                                         : ": the recording has ended; no further line comes");
}

}  // namespace

// The consumer's side: buffers and queues.

Stream::Stream(std::shared_ptr<Camera> camera, void* parent)
    : Module("TLDataStream", kStreamId, parent),
      camera_(std::move(camera)),
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
  buffers_.push_back(make_module<Buffer>(std::to_string(announced_++), memory, bytes, user));
  return buffers_.back();
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
  output_->push({.data = std::move(bytes), .on_removed = [buffer] { buffer->state = BufferState::unqueued; }});
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

// The camera's side: the thread that writes lines into buffers.

void Stream::work(const FrameLayout& layout, std::uint64_t count) {
  try {
    fill(layout, count);
  } catch (const std::exception& error) {
    end(error.what());
  }
  const std::lock_guard lock(gate_.mutex);
  grabbing_ = false;
}

void Stream::fill(const FrameLayout& layout, std::uint64_t count) {
  LineSource& source = camera_->source();
  Filling filling;
  while (delivered_ < count && wait_for_buffer(layout, filling)) {
    driver::Next next = driver::Next::end;
    try {
      next = source.next(kPatience);
    } catch (const std::exception&) {
      deliver(filling);
      throw;
    }
    if (next == driver::Next::packet) {
      write_line(filling);
      if (filling.contents.lines == layout.height) {
        deliver(filling);
      }
    } else if (next == driver::Next::end) {
      deliver(filling);
      end(end_text(source.uri()));
      return;
    }
  }
}

// Waits until lines are wanted and there is a buffer for them. Returns false if the acquisition is to end; a buffer
// that has lines is then delivered or dropped, as is one whose camera was stopped.
bool Stream::wait_for_buffer(const FrameLayout& layout, Filling& filling) {
  std::unique_lock lock(gate_.mutex);
  for (;;) {
    if (filling.buffer != nullptr && (stopping_ || !gate_.running)) {
      if (filling.contents.lines > 0 && !(stopping_ && discarding_)) {
        lock.unlock();
        deliver(filling);
        lock.lock();
      } else {
        filling.buffer->state = BufferState::input;
        input_.push_front(std::exchange(filling.buffer, nullptr));
      }
    }
    if (stopping_) {
      return false;
    }
    if (gate_.running && filling.buffer != nullptr) {
      return true;
    }
    if (gate_.running && !input_.empty()) {
      filling.buffer = input_.front();
      input_.pop_front();
      filling.buffer->state = BufferState::filling;
      filling.buffer->contents = {};
      filling.contents = {.new_data = true, .layout = layout, .frame_id = started_};
      ++started_;
      return true;
    }
    gate_.changed.wait(lock);
  }
}

std::uint64_t Stream::nanoseconds(std::uint64_t clocks) const {
  const auto hz = static_cast<long double>(camera_->source().rig().pixel_clock_hz());
  return static_cast<std::uint64_t>(static_cast<long double>(clocks) * 1e9L / hz);
}

void Stream::write_line(Filling& filling) {
  BufferContents& contents = filling.contents;
  const FrameLayout& layout = contents.layout;
  const LineSource& source = camera_->source();
  const light_section::Profile& profile = source.profile();
  const auto columns = static_cast<std::size_t>(layout.columns);
  const auto line = static_cast<std::size_t>(contents.lines);
  for (const FramePart& part : layout.parts()) {
    std::uint8_t* to = filling.buffer->memory() + part.offset + line * columns * part.pixel_bytes;
    if (part.format == kCoord3dC32f) {
      std::memcpy(to, profile.z.data(), columns * sizeof(float));
      continue;
    }
    for (std::size_t i = 0; i < columns; ++i, to += part.pixel_bytes) {
      if (part.format == kMono16) {
        store(to, static_cast<std::uint16_t>(source.lit()[i]));
      } else {
        const std::array<float, 3> point{profile.x[i], profile.y[i], profile.z[i]};
        store(to, point);
      }
    }
  }
  const model::PacketHeader& header = source.header();
  if (contents.lines == 0) {
    contents.time_stamp = header.time_stamp;
    contents.time_stamp_ns = nanoseconds(header.time_stamp);
  }
  if (layout.chunks) {
    std::uint8_t* const to = filling.buffer->memory() + layout.chunk_places(1).back().ChunkOffset + line * kLineBytes;
    store(to, header.sequence);
    store(to + 8, nanoseconds(header.time_stamp));
    store(to + 16, std::int64_t{static_cast<std::int32_t>(header.encoder)});
  }
  ++contents.lines;
}

void Stream::write_chunks(const Filling& filling) {
  const BufferContents& contents = filling.contents;
  const std::vector<SINGLE_CHUNK_DATA> places = contents.layout.chunk_places(contents.lines);
  if (places.empty()) {
    return;
  }
  std::uint8_t* to = filling.buffer->memory() + places[0].ChunkOffset;
  store(to, contents.frame_id);
  store(to + 8, contents.time_stamp_ns);
  store(to + 16, static_cast<std::uint64_t>(contents.lines));
  to = filling.buffer->memory() + places[1].ChunkOffset;
  const SourceCounts counts = camera_->source().counts();
  for (const driver::CounterName& counter : driver::kCounterNames) {
    store(to, counts.driver.*counter.field);
    to += sizeof(std::uint64_t);
  }
  store(to, counts.other_size);
  store(to + 8, counts.not_moments);
}

// Gives the buffer to the consumer if it has lines, and else back to the input queue.
void Stream::deliver(Filling& filling) {
  if (filling.buffer == nullptr) {
    return;
  }
  const std::shared_ptr<Buffer> buffer = filling.buffer;
  filling.buffer.reset();
  if (filling.contents.lines == 0) {
    const std::lock_guard lock(gate_.mutex);
    buffer->state = BufferState::input;
    input_.push_front(buffer);
    return;
  }
  write_chunks({buffer, filling.contents});
  const std::lock_guard lock(gate_.mutex);
  buffer->contents = filling.contents;
  ++delivered_;
  put_out(buffer);
}

void Stream::end(const std::string& reason) {
  const std::lock_guard lock(gate_.mutex);
  grabbing_ = false;
  if (errors_ != nullptr) {  // first: whom the end of the buffers wakes finds the error
    push_error(*errors_, GC_ERR_IO, reason);
  }
  output_->end(GC_ERR_IO, reason);
}

}  // namespace selfproj::gentl
