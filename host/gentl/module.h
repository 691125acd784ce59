// The library with its handles and its lock, and what the modules of the standard have in common: an identity, a port
// with features, events, modules below them.
#ifndef SELFPROJ_HOST_GENTL_MODULE_H
#define SELFPROJ_HOST_GENTL_MODULE_H

#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "host/gentl/answer.h"
#include "host/gentl/event_queue.h"
#include "host/gentl/feature_set.h"
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

inline constexpr const char* kVendor = "selfproj";
inline constexpr const char* kTransport = "Custom";  // the standard's name for a transport that it does not define

// A module that has a handle. Used under the library's lock.
class Module {
 public:
  // `parent` is the handle of the module above it.
  Module(const char* kind, std::string id, void* parent = nullptr) : kind_(kind), id_(std::move(id)), parent_(parent) {}
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;
  virtual ~Module() = default;

  // "TLSystem", "TLInterface", "TLDevice", "TLDataStream", "TLBuffer", or "Device" for the remote device.
  [[nodiscard]] const char* kind() const { return kind_; }
  [[nodiscard]] const std::string& id() const { return id_; }
  [[nodiscard]] void* parent() const { return parent_; }
  [[nodiscard]] virtual std::string model() const { return kind_; }

  // False if all of its registers can only be read.
  [[nodiscard]] virtual bool writable() const { return true; }

  FeatureSet& features();

  // Registers an event and returns its handle. Throws GC_ERR_RESOURCE_IN_USE if it is registered already, and
  // GC_ERR_NOT_IMPLEMENTED if the module has no such event.
  EVENT_HANDLE register_event(EVENT_TYPE type);
  void unregister_event(EVENT_TYPE type);

  // Closes the modules below this one, and unregisters its events. Their handles become invalid; its own stays valid.
  virtual void close();

  EVENTSRC_HANDLE handle = nullptr;

 protected:
  // Adds its features to an empty set.
  virtual void describe(FeatureSet& features) = 0;
  virtual std::shared_ptr<EventQueue> make_event(EVENT_TYPE type);

 private:
  struct Registered {
    EVENT_HANDLE handle;
    std::shared_ptr<EventQueue> queue;
  };

  const char* kind_;
  std::string id_;
  void* parent_;
  std::unique_ptr<FeatureSet> features_;
  std::map<EVENT_TYPE, Registered> events_;
};

// A new module with its handle, and the end of one: it is closed, and its handle becomes invalid.
template <typename Kind, typename... Arguments>
std::shared_ptr<Kind> make_module(Arguments&&... arguments) {
  auto made = std::make_shared<Kind>(std::forward<Arguments>(arguments)...);
  made->handle = library().add(std::shared_ptr<Module>(made));
  return made;
}
template <typename Kind>
void close_module(std::shared_ptr<Kind>& module) {
  if (module != nullptr) {
    module->close();
    library().remove(module->handle);
    module.reset();
  }
}

// Features that can only be read: a text, and a number.
Feature text_feature(std::string category, std::string name, std::string tip, std::function<std::string()> get);
Feature number_feature(std::string category, std::string name, std::string tip, std::function<std::int64_t()> get);

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_MODULE_H
