// A queue of events for consumers that wait for them. Any number of threads can use it at once.
#ifndef SELFPROJ_HOST_GENTL_EVENT_QUEUE_H
#define SELFPROJ_HOST_GENTL_EVENT_QUEUE_H

#include <condition_variable>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "host/gentl/answer.h"
#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

// The data of EVENT_ERROR, as EventGetData returns them.
struct ErrorEventData {
  GC_ERROR code = GC_ERR_SUCCESS;
  char text[508] = {};  // ends with 0
};

struct Event {
  std::vector<std::uint8_t> data;
  std::function<void()> on_removed = {};  // called under the queue's lock when the event leaves the queue
};

class EventQueue {
 public:
  EventQueue(EVENT_TYPE type, std::size_t event_bytes) : type_(type), event_bytes_(event_bytes) {}

  [[nodiscard]] EVENT_TYPE type() const { return type_; }
  [[nodiscard]] std::size_t event_bytes() const { return event_bytes_; }

  void push(Event event);

  // Copies the next event into the buffer, and waits for it up to timeout_ms (GENTL_INFINITE: for ever). If the buffer
  // is null, it returns only the size, and the event stays. Throws GC_ERR_TIMEOUT, GC_ERR_ABORT after kill() or
  // close(), or the error of end().
  void get(void* buffer, std::size_t* size, std::uint64_t timeout_ms);

  // Ends one get(): one that waits, or else the next.
  void kill();
  // Ends every get() that waits, and every later one until reopen(). Returns when no thread waits any more.
  void close();
  void reopen();
  // Says that no further event comes until begin(). Once the queue is empty, get() throws this code and reason.
  void end(GC_ERROR code, const std::string& reason);
  void begin();

  void flush();
  [[nodiscard]] std::size_t size() const;
  [[nodiscard]] std::uint64_t fired() const;

 private:
  struct End {
    GC_ERROR code;
    std::string reason;
  };

  // Counts a get() in waiting_ during its lifetime. Used under the lock.
  class Waiting {
   public:
    explicit Waiting(EventQueue& queue) : queue_(queue) { ++queue_.waiting_; }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;
    ~Waiting() {
      --queue_.waiting_;
      queue_.left_.notify_all();
    }

   private:
    EventQueue& queue_;
  };

  const EVENT_TYPE type_;
  const std::size_t event_bytes_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::condition_variable left_;
  std::size_t waiting_ = 0;
  std::deque<Event> events_;
  std::optional<End> end_;
  std::uint64_t fired_ = 0;
  std::size_t kills_ = 0;
  bool closed_ = false;
};

// Puts an error into a queue of EVENT_ERROR.
void push_error(EventQueue& queue, GC_ERROR code, const std::string& text);

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_EVENT_QUEUE_H
