// What the modules of the standard have in common: an identity, a port with features, events, modules below them.
#ifndef SELFPROJ_HOST_GENTL_MODULE_H
#define SELFPROJ_HOST_GENTL_MODULE_H

#include <map>
#include <memory>
#include <string>
#include <utility>

#include "host/gentl/event_queue.h"
#include "host/gentl/feature_set.h"
#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

inline constexpr const char* kVendor = "selfproj";
inline constexpr const char* kTransport = "Custom";  // the standard's name for a transport that it does not define

// A module that has a handle. Used under the library's lock.
class Module {
 public:
  Module(const char* kind, std::string id) : kind_(kind), id_(std::move(id)) {}
  Module(const Module&) = delete;
  Module& operator=(const Module&) = delete;
  virtual ~Module() = default;

  // "TLSystem", "TLInterface", "TLDevice", "TLDataStream", "TLBuffer", or "Device" for the remote device.
  [[nodiscard]] const char* kind() const { return kind_; }
  [[nodiscard]] const std::string& id() const { return id_; }
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
  std::unique_ptr<FeatureSet> features_;
  std::map<EVENT_TYPE, Registered> events_;
};

// Gives a new module its handle.
void give_handle(const std::shared_ptr<Module>& module);

// Features that can only be read: a text, and a number.
Feature text_feature(std::string category, std::string name, std::string tip, std::function<std::string()> get);
Feature number_feature(std::string category, std::string name, std::string tip, std::function<std::int64_t()> get);

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_MODULE_H
