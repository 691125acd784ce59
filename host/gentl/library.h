// The library: its handles, and the lock under which modules are used.
#ifndef SELFPROJ_HOST_GENTL_LIBRARY_H
#define SELFPROJ_HOST_GENTL_LIBRARY_H

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>

#include "host/gentl/event_queue.h"
#include "host/gentl/gentl_errors.h"
#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

class Module;
class System;

// Handles are numbers that are never used twice, so that the handle of a closed module is known to be invalid.
class Library {
 public:
  std::mutex mutex;
  bool initialized = false;
  std::shared_ptr<System> system;  // null: closed

  // Return a new handle.
  void* add(std::shared_ptr<Module> module);
  void* add(std::shared_ptr<EventQueue> queue);
  void remove(void* handle) { modules_.erase(handle); }
  void remove_event(void* handle) { events_.erase(handle); }

  // Throw GC_ERR_INVALID_HANDLE.
  [[nodiscard]] std::shared_ptr<Module> module(void* handle) const;
  [[nodiscard]] std::shared_ptr<EventQueue> event(void* handle) const;

 private:
  void* next_handle();

  std::uintptr_t last_ = 0;
  std::map<void*, std::shared_ptr<Module>> modules_;
  std::map<void*, std::shared_ptr<EventQueue>> events_;
};

Library& library();

// The module of this kind; throws GC_ERR_INVALID_HANDLE.
template <typename Kind>
std::shared_ptr<Kind> find(void* handle) {
  auto found = std::dynamic_pointer_cast<Kind>(library().module(handle));
  require(found != nullptr, GC_ERR_INVALID_HANDLE, "the handle is one of another kind of module");
  return found;
}

// Throws GC_ERR_NOT_INITIALIZED before GCInitLib.
inline void require_initialized() {
  require(library().initialized, GC_ERR_NOT_INITIALIZED, "GCInitLib was not called");
}

// Runs the work of a function of the interface: under the lock, only after GCInitLib, and without letting an exception
// out.
template <typename Work>
GC_ERROR call(const Work& work) noexcept {
  return guarded([&] {
    const std::lock_guard lock(library().mutex);
    require_initialized();
    work();
  });
}

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_LIBRARY_H
