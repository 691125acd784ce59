// A queue of events with consumers that wait for them. For any number of threads at once.
#ifndef SELFPROJ_HOST_GENTL_EVENT_QUEUE_H
#define SELFPROJ_HOST_GENTL_EVENT_QUEUE_H

#include <chrono>
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

// The data of EVENT_ERROR, as EventGetData gives them.
struct ErrorEventData {
  GC_ERROR code = GC_ERR_SUCCESS;
  char text[508] = {};  // ends with 0
};

struct Event {
  std::vector<std::uint8_t> data;
  std::function<void()> taken = {};  // is called when it leaves the queue, under the queue's lock
};

class EventQueue {
 public:
  EventQueue(EVENT_TYPE type, std::size_t event_bytes) : type_(type), event_bytes_(event_bytes) {}

  [[nodiscard]] EVENT_TYPE type() const { return type_; }
  [[nodiscard]] std::size_t event_bytes() const { return event_bytes_; }

  void push(Event event);

  // Gives the next event, and waits for it up to timeout_ms; GENTL_INFINITE: for ever. Without a buffer it gives only
  // the size, and leaves the event. Throws GC_ERR_TIMEOUT, GC_ERR_ABORT after kill() or close(), or the error of end().
  void get(void* buffer, std::size_t* size, std::uint64_t timeout_ms);

  // Ends one get(): the one that waits, or else the next one.
  void kill();
  // Ends all that wait, and all later ones until reopen(). Returns when nobody waits any more.
  void close();
  void reopen();
  // No further event comes until begin(), for this reason: get() throws it once the queue is empty.
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

  // Counts a get() as long as it lives. Under the lock.
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
