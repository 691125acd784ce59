#include "host/gentl/module.h"

#include "host/gentl/gentl_errors.h"
#include "host/gentl/library.h"

namespace selfproj::gentl {

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

void give_handle(const std::shared_ptr<Module>& module) { module->handle = library().add(module); }

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
