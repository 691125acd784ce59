// The data stream of a camera: queues of buffers, and the thread that fills them with lines.
#ifndef SELFPROJ_HOST_GENTL_STREAM_H
#define SELFPROJ_HOST_GENTL_STREAM_H

#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/gentl/buffer.h"
#include "host/gentl/camera.h"
#include "host/gentl/event_queue.h"
#include "host/gentl/module.h"

namespace selfproj::gentl {

inline constexpr const char* kStreamId = "lines";

// While no buffer is queued, no line is taken from the device. A recording waits; a ring or a socket keeps lines as
// long as it has room, and counts what it loses.
class Stream final : public Module {
 public:
  Stream(std::shared_ptr<Camera> camera, void* parent);
  ~Stream() override { stop(ACQ_STOP_FLAGS_KILL); }

  // These functions throw the errors of the GenTL standard.
  std::shared_ptr<Buffer> announce(void* memory, std::size_t bytes, void* user);
  void revoke(const std::shared_ptr<Buffer>& buffer);
  void queue(const std::shared_ptr<Buffer>& buffer);
  void flush(ACQ_QUEUE_TYPE operation);
  void start(std::uint64_t count);
  void stop(ACQ_STOP_FLAGS flags);

  [[nodiscard]] bool is_acquiring() const { return thread_.joinable(); }
  void give_info(STREAM_INFO_CMD command, const Answer& to) const;
  [[nodiscard]] std::shared_ptr<Buffer> buffer_at(std::size_t index) const;
  [[nodiscard]] BufferContents contents_of(const Buffer& buffer) const;
  // Throws GC_ERR_INVALID_HANDLE if the buffer belongs to another stream.
  void require_own(const std::shared_ptr<Buffer>& buffer) const;

  void close() override;

 private:
  // The buffer that is being filled; only the thread uses this.
  struct Filling {
    std::shared_ptr<Buffer> buffer;
    BufferContents contents;
  };

  void describe(FeatureSet& features) override;
  std::shared_ptr<EventQueue> make_event(EVENT_TYPE type) override;

  void work(const FrameLayout& layout, std::uint64_t count);
  void fill(const FrameLayout& layout, std::uint64_t count);
  bool wait_for_buffer(const FrameLayout& layout, Filling& filling);
  void write_line(Filling& filling);
  void write_chunks(const Filling& filling);
  void deliver(Filling& filling);
  void end(const std::string& reason);
  void put_out(const std::shared_ptr<Buffer>& buffer);
  [[nodiscard]] std::uint64_t nanoseconds(std::uint64_t clocks) const;

  std::shared_ptr<Camera> camera_;
  AcquisitionGate& gate_;  // its mutex is the stream's lock
  std::vector<std::shared_ptr<Buffer>> buffers_;
  std::deque<std::shared_ptr<Buffer>> input_;
  std::shared_ptr<EventQueue> output_;
  std::shared_ptr<EventQueue> errors_;  // null unless EVENT_ERROR was registered
  std::thread thread_;
  bool stopping_ = false;
  bool discarding_ = false;  // at the stop, a buffer that is not full is not delivered
  bool grabbing_ = false;
  std::uint64_t payload_ = 0;  // bytes of a buffer in the present acquisition
  std::uint64_t announced_ = 0;
  std::uint64_t delivered_ = 0;
  std::uint64_t started_ = 0;
};

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_STREAM_H
