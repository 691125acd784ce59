#include "host/gentl/library.h"

#include <bit>
#include <utility>

namespace selfproj::gentl {

Library& library() {
  static Library one;
  return one;
}

void* Library::next_handle() {
  last_ += 16;  // like addresses, for programs that print or compare them
  return std::bit_cast<void*>(last_);
}

void* Library::add(std::shared_ptr<Module> module) {
  void* const handle = next_handle();
  modules_.emplace(handle, std::move(module));
  return handle;
}

void* Library::add(std::shared_ptr<EventQueue> queue) {
  void* const handle = next_handle();
  events_.emplace(handle, std::move(queue));
  return handle;
}

std::shared_ptr<Module> Library::module(void* handle) const {
  const auto at = modules_.find(handle);
  require(at != modules_.end(), GC_ERR_INVALID_HANDLE, "the handle is not that of an open module");
  return at->second;
}

std::shared_ptr<EventQueue> Library::event(void* handle) const {
  const auto at = events_.find(handle);
  require(at != events_.end(), GC_ERR_INVALID_HANDLE, "the handle is not that of a registered event");
  return at->second;
}

}  // namespace selfproj::gentl
