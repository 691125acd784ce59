#include "host/gentl/library.h"

#include <bit>

#include "host/gentl/system.h"

namespace selfproj::gentl {

Library& library() {
  static Library one;
  return one;
}

void* Library::next_handle() {
  last_ += 16;  // like addresses, for programs that print or compare them
  return std::bit_cast<void*>(last_);
}

void* Library::add(const std::shared_ptr<Module>& module) {
  void* const handle = next_handle();
  modules_.emplace(handle, module);
  module->handle = handle;
  return handle;
}

void* Library::add(const std::shared_ptr<EventQueue>& queue) {
  void* const handle = next_handle();
  events_.emplace(handle, queue);
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

void Library::close() {
  if (system != nullptr) {
    system->close();
    remove(system->handle);
    system.reset();
  }
}

}  // namespace selfproj::gentl
