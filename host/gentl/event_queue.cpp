#include "host/gentl/event_queue.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <utility>

namespace selfproj::gentl {

void EventQueue::push(Event event) {
  {
    const std::lock_guard lock(mutex_);
    events_.push_back(std::move(event));
    ++fired_;
  }
  changed_.notify_one();
}

void EventQueue::get(void* buffer, std::size_t* size, std::uint64_t timeout_ms) {
  require_pointer(size);
  std::unique_lock lock(mutex_);
  const Waiting waiting(*this);
  const auto ready = [this] { return closed_ || kills_ > 0 || !events_.empty() || end_; };
  if (timeout_ms == GENTL_INFINITE) {
    changed_.wait(lock, ready);
  } else {
    constexpr std::uint64_t kYear = std::uint64_t{365} * 24 * 3600 * 1000;  // more would not fit the clock
    changed_.wait_for(lock, std::chrono::milliseconds(std::min(timeout_ms, kYear)), ready);
  }
  if (closed_ || kills_ > 0) {
    kills_ -= closed_ ? 0 : 1;
    throw GenTLError(GC_ERR_ABORT, closed_ ? "the event was unregistered" : "EventKill ended the wait");
  }
  if (events_.empty()) {
    if (end_) {
      throw GenTLError(end_->code, end_->reason);
    }
    throw GenTLError(GC_ERR_TIMEOUT, "no event came in time");
  }
  Event& next = events_.front();
  give_bytes(INFO_DATATYPE_BUFFER, next.data.data(), next.data.size(), {nullptr, buffer, size});
  if (buffer != nullptr) {
    if (next.on_removed) {
      next.on_removed();
    }
    events_.pop_front();
  }
}

void EventQueue::kill() {
  {
    const std::lock_guard lock(mutex_);
    ++kills_;
  }
  changed_.notify_all();
}

void EventQueue::close() {
  std::unique_lock lock(mutex_);
  closed_ = true;
  changed_.notify_all();
  left_.wait(lock, [this] { return waiting_ == 0; });
}

void EventQueue::end(GC_ERROR code, const std::string& reason) {
  {
    const std::lock_guard lock(mutex_);
    end_ = End{code, reason};
  }
  changed_.notify_all();
}

void EventQueue::begin() {
  const std::lock_guard lock(mutex_);
  end_.reset();
}

void EventQueue::reopen() {
  const std::lock_guard lock(mutex_);
  closed_ = false;
  kills_ = 0;
}

void EventQueue::flush() {
  const std::lock_guard lock(mutex_);
  for (const Event& event : events_) {
    if (event.on_removed) {
      event.on_removed();
    }
  }
  events_.clear();
}

std::size_t EventQueue::size() const {
  const std::lock_guard lock(mutex_);
  return events_.size();
}

std::uint64_t EventQueue::fired() const {
  const std::lock_guard lock(mutex_);
  return fired_;
}

void push_error(EventQueue& queue, GC_ERROR code, const std::string& text) {
  ErrorEventData data;
  data.code = code;
  static_cast<void>(std::snprintf(data.text, sizeof data.text, "%s", text.c_str()));
  std::vector<std::uint8_t> bytes(sizeof data);
  std::memcpy(bytes.data(), &data, sizeof data);
  queue.push({.data = std::move(bytes)});
}

}  // namespace selfproj::gentl
