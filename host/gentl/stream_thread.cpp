// The camera's side of a stream: the thread that writes lines into buffers.
#include <array>
#include <chrono>
#include <cstring>
#include <exception>

#include "host/gentl/gentl_errors.h"
#include "host/gentl/stream.h"

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
    Next next = Next::end;
    try {
      next = source.next(kPatience);
    } catch (const std::exception&) {
      deliver(filling);
      throw;
    }
    if (next == Next::packet) {
      write_line(filling);
      if (filling.contents.lines == layout.height) {
        deliver(filling);
      }
    } else if (next == Next::end) {
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
  const Profile& profile = source.profile();
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
  const PacketHeader& header = source.header();
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
  for (const CounterName& counter : kCounterNames) {
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
  output_->end(GC_ERR_IO, reason);
  if (errors_ != nullptr) {
    push_error(*errors_, GC_ERR_IO, reason);
  }
}

}  // namespace selfproj::gentl
