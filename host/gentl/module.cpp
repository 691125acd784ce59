#include "host/gentl/module.h"

#include <bit>
#include <utility>

#include "host/gentl/answer.h"

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

FeatureSet& Module::features() {
  if (features_ == nullptr) {
    auto made = std::make_unique<FeatureSet>(
        FeatureSetName{.model = std::string("selfproj_") + kind_, .tip = model(), .standard = "None"});
    describe(*made);
    features_ = std::move(made);
  }
  return *features_;
}

std::shared_ptr<EventQueue> Module::make_event(EVENT_TYPE type) {
  if (type == EVENT_ERROR) {
    return std::make_shared<EventQueue>(type, sizeof(ErrorEventData));
  }
  throw GenTLError(GC_ERR_NOT_IMPLEMENTED, std::string(kind_) + " has no event of type " + std::to_string(type));
}

EVENT_HANDLE Module::register_event(EVENT_TYPE type) {
  require(events_.count(type) == 0, GC_ERR_RESOURCE_IN_USE, "the event is registered already");
  std::shared_ptr<EventQueue> queue = make_event(type);
  const EVENT_HANDLE made = library().add(queue);
  events_.emplace(type, Registered{made, std::move(queue)});
  return made;
}

void Module::unregister_event(EVENT_TYPE type) {
  const auto at = events_.find(type);
  require(at != events_.end(), GC_ERR_INVALID_PARAMETER, "the event is not registered");
  at->second.queue->close();
  library().remove_event(at->second.handle);
  events_.erase(at);
}

void Module::close() {
  while (!events_.empty()) {
    unregister_event(events_.begin()->first);
  }
}

Feature text_feature(std::string category, std::string name, std::string tip, std::function<std::string()> get) {
  return {.kind = FeatureKind::text,
          .name = std::move(name),
          .category = std::move(category),
          .tip = std::move(tip),
          .get_text = std::move(get)};
}

Feature number_feature(std::string category, std::string name, std::string tip, std::function<std::int64_t()> get) {
  return {.kind = FeatureKind::integer,
          .name = std::move(name),
          .category = std::move(category),
          .tip = std::move(tip),
          .get = std::move(get)};
}

}  // namespace selfproj::gentl
