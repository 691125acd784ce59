// The upper modules of the standard: the system, its one interface, and the devices that are open.
#ifndef SELFPROJ_HOST_GENTL_SYSTEM_H
#define SELFPROJ_HOST_GENTL_SYSTEM_H

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "host/gentl/answer.h"
#include "host/gentl/camera.h"
#include "host/gentl/device_list.h"
#include "host/gentl/module.h"
#include "host/gentl/stream.h"

namespace selfproj::gentl {

inline constexpr const char* kInterfaceId = "selfproj";

class Interface;

// A device that is open: the local side of a camera.
class LocalDevice final : public Module {
 public:
  // Throws as Camera does.
  LocalDevice(const DeviceEntry& entry, DEVICE_ACCESS_FLAGS access, void* parent);

  [[nodiscard]] const DeviceEntry& entry() const { return entry_; }
  [[nodiscard]] const std::shared_ptr<Camera>& camera() const { return camera_; }
  [[nodiscard]] std::int32_t access_status() const;

  // Throws GC_ERR_INVALID_ID or GC_ERR_RESOURCE_IN_USE.
  std::shared_ptr<Stream> open_stream(const std::string& id);
  void close_stream() { close_module(stream_); }

  void close() override;

 private:
  void describe(FeatureSet& features) override;

  DeviceEntry entry_;
  DEVICE_ACCESS_FLAGS access_;
  std::shared_ptr<Camera> camera_;
  std::shared_ptr<Stream> stream_;  // null: closed
};

class Interface final : public Module {
 public:
  explicit Interface(void* parent) : Module("TLInterface", kInterfaceId, parent) {}

  [[nodiscard]] const std::vector<DeviceEntry>& devices() const { return devices_; }

  // Looks for devices. Returns whether the list has changed.
  bool update();

  // Throw GC_ERR_INVALID_ID for a device that the last update() did not find.
  [[nodiscard]] const DeviceEntry& entry(const char* id) const;
  std::shared_ptr<LocalDevice> open(const char* id, DEVICE_ACCESS_FLAGS access);
  [[nodiscard]] std::shared_ptr<LocalDevice> opened(const std::string& id) const;  // null: not open
  void close_device(const std::string& id);

  void close() override;

 private:
  void describe(FeatureSet& features) override;

  std::vector<DeviceEntry> devices_;
  std::map<std::string, std::shared_ptr<LocalDevice>> open_;
};

class System final : public Module {
 public:
  System() : Module("TLSystem", kVendor) {}

  // Throws GC_ERR_INVALID_ID or GC_ERR_RESOURCE_IN_USE.
  std::shared_ptr<Interface> open(const char* id);
  [[nodiscard]] const std::shared_ptr<Interface>& interface() const { return interface_; }
  void close_interface() { close_module(interface_); }

  void close() override;

 private:
  void describe(FeatureSet& features) override;

  std::shared_ptr<Interface> interface_;  // null: closed
};

// Return information about the producer, the interface, and a device. `opened` is null if the device is closed.
void give_producer_info(TL_INFO_CMD command, const Answer& to);
void give_interface_info(INTERFACE_INFO_CMD command, const Answer& to);
void give_device_info(const DeviceEntry& entry, const LocalDevice* opened, DEVICE_INFO_CMD command, const Answer& to);

// The version of the project.
std::string producer_version();

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_SYSTEM_H
