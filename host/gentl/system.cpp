#include "host/gentl/system.h"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/gentl/answer.h"
#include "host/gentl/module.h"

namespace selfproj::gentl {
namespace {

std::filesystem::path producer_path() {
  Dl_info info{};
  static const char anchor = 0;  // lies in this library
  return dladdr(&anchor, &info) != 0 && info.dli_fname != nullptr ? info.dli_fname : "";
}

}  // namespace

std::string producer_version() { return SELFPROJ_VERSION; }

LocalDevice::LocalDevice(const DeviceEntry& entry, DEVICE_ACCESS_FLAGS access, void* parent)
    : Module("TLDevice", entry.id, parent),
      entry_(entry),
      access_(access),
      camera_(make_module<Camera>(entry, access != DEVICE_ACCESS_READONLY)) {}

std::int32_t LocalDevice::access_status() const {
  return access_ == DEVICE_ACCESS_READONLY ? DEVICE_ACCESS_STATUS_OPEN_READONLY : DEVICE_ACCESS_STATUS_OPEN_READWRITE;
}

std::shared_ptr<Stream> LocalDevice::open_stream(const std::string& id) {
  require(id == kStreamId, GC_ERR_INVALID_ID, "the device has no such data stream");
  require(stream_ == nullptr, GC_ERR_RESOURCE_IN_USE, "the data stream is open already");
  stream_ = make_module<Stream>(camera_, handle);
  return stream_;
}

void LocalDevice::close() {
  close_stream();
  close_module(camera_);
  Module::close();
}

void LocalDevice::describe(FeatureSet& features) {
  const char* const category = "DeviceInformation";
  features.add(text_feature(category, "DeviceID", "The URI from which packets come.", [this] { return id(); }));
  features.add(text_feature(category, "DeviceVendorName", "Who made the device.", [] { return kVendor; }));
  features.add(text_feature(category, "DeviceModelName", "The rig.", [this] { return camera_->model(); }));
  features.add(text_feature(category, "DeviceType", "The transport.", [] { return kTransport; }));
}

bool Interface::update() {
  std::vector<DeviceEntry> found = list_devices();
  const auto ids = [](const std::vector<DeviceEntry>& entries) {
    std::vector<std::string> all;
    std::transform(entries.begin(), entries.end(), std::back_inserter(all), [](const auto& one) { return one.id; });
    return all;
  };
  const bool changed = ids(found) != ids(devices_);
  devices_ = std::move(found);
  return changed;
}

const DeviceEntry& Interface::entry(const char* id) const {
  require_pointer(id);
  const auto at =
      std::find_if(devices_.begin(), devices_.end(), [&](const DeviceEntry& device) { return device.id == id; });
  if (at == devices_.end()) {
    throw GenTLError(GC_ERR_INVALID_ID,
                     std::string(id) + ": is not in the list of devices; SELFPROJ_GENTL_DEVICES names devices");
  }
  return *at;
}

std::shared_ptr<LocalDevice> Interface::opened(const std::string& id) const {
  const auto at = open_.find(id);
  return at != open_.end() ? at->second : nullptr;
}

std::shared_ptr<LocalDevice> Interface::open(const char* id, DEVICE_ACCESS_FLAGS access) {
  const DeviceEntry& found = entry(id);
  require(access >= DEVICE_ACCESS_READONLY && access <= DEVICE_ACCESS_EXCLUSIVE, GC_ERR_INVALID_PARAMETER,
          "the way of access is none of DEVICE_ACCESS_READONLY, _CONTROL and _EXCLUSIVE");
  if (opened(id) != nullptr) {
    throw GenTLError(GC_ERR_RESOURCE_IN_USE, std::string(id) + ": this program has it open already");
  }
  return open_.emplace(id, make_module<LocalDevice>(found, access, handle)).first->second;
}

void Interface::close_device(const std::string& id) {
  close_module(open_.at(id));
  open_.erase(id);
}

void Interface::close() {
  while (!open_.empty()) {
    close_device(std::string(open_.begin()->first));
  }
  Module::close();
}

void Interface::describe(FeatureSet& features) {
  const char* const category = "InterfaceInformation";
  features.add(text_feature(category, "InterfaceID", "The name of the interface.", [this] { return id(); }));
  features.add(text_feature(category, "InterfaceType", "The transport.", [] { return kTransport; }));
  features.add(number_feature(category, "DeviceCount", "Devices that the last update found.",
                              [this] { return static_cast<std::int64_t>(devices_.size()); }));
}

std::shared_ptr<Interface> System::open(const char* id) {
  require_pointer(id);
  require(std::string(id) == kInterfaceId, GC_ERR_INVALID_ID, "there is no such interface");
  require(interface_ == nullptr, GC_ERR_RESOURCE_IN_USE, "the interface is open already");
  interface_ = make_module<Interface>(handle);
  return interface_;
}

void System::close() {
  close_interface();
  Module::close();
}

void System::describe(FeatureSet& features) {
  const char* const category = "SystemInformation";
  features.add(text_feature(category, "TLVendorName", "Who made the producer.", [] { return kVendor; }));
  features.add(text_feature(category, "TLModelName", "The producer.", [] { return "selfproj GenTL producer"; }));
  features.add(text_feature(category, "TLID", "The name of the producer.", [this] { return id(); }));
  features.add(text_feature(category, "TLVersion", "Its version.", [] { return producer_version(); }));
  features.add(text_feature(category, "TLType", "The transport.", [] { return kTransport; }));
  features.add(text_feature(category, "TLPath", "The file of the producer.", [] { return producer_path().string(); }));
  features.add(number_feature(category, "GenTLVersionMajor", "Version of the standard.", [] { return 1; }));
  features.add(number_feature(category, "GenTLVersionMinor", "Version of the standard.", [] { return 5; }));
}

void give_producer_info(TL_INFO_CMD command, const Answer& to) {
  switch (command) {
    case TL_INFO_ID:
    case TL_INFO_VENDOR:
      return give(kVendor, to);
    case TL_INFO_MODEL:
    case TL_INFO_DISPLAYNAME:
      return give("selfproj GenTL producer", to);
    case TL_INFO_VERSION:
      return give(producer_version(), to);
    case TL_INFO_TLTYPE:
      return give(kTransport, to);
    case TL_INFO_NAME:
      return give(producer_path().filename().string(), to);
    case TL_INFO_PATHNAME:
      return give(std::filesystem::absolute(producer_path()).string(), to);
    case TL_INFO_CHAR_ENCODING:
      return give(std::int32_t{TL_CHAR_ENCODING_UTF8}, to);
    case TL_INFO_GENTL_VER_MAJOR:
      return give(std::uint32_t{1}, to);
    case TL_INFO_GENTL_VER_MINOR:
      return give(std::uint32_t{5}, to);
    default:
      no_answer(command);
  }
}

void give_interface_info(INTERFACE_INFO_CMD command, const Answer& to) {
  switch (command) {
    case INTERFACE_INFO_ID:
      return give(kInterfaceId, to);
    case INTERFACE_INFO_DISPLAYNAME:
      return give("selfproj: boards, recordings and cameras", to);
    case INTERFACE_INFO_TLTYPE:
      return give(kTransport, to);
    default:
      no_answer(command);
  }
}

void give_device_info(const DeviceEntry& entry, const LocalDevice* opened, DEVICE_INFO_CMD command, const Answer& to) {
  switch (command) {
    case DEVICE_INFO_ID:
    case DEVICE_INFO_SERIAL_NUMBER:
      return give(entry.id, to);
    case DEVICE_INFO_VENDOR:
      return give(kVendor, to);
    case DEVICE_INFO_MODEL:
      return give(entry.rig, to);
    case DEVICE_INFO_TLTYPE:
      return give(kTransport, to);
    case DEVICE_INFO_DISPLAYNAME:
    case DEVICE_INFO_USER_DEFINED_NAME:
      return give(entry.display_name(), to);
    case DEVICE_INFO_VERSION:
      return give(producer_version(), to);
    case DEVICE_INFO_ACCESS_STATUS:
      return give(opened != nullptr                         ? opened->access_status()
                  : entry.in_use                            ? std::int32_t{DEVICE_ACCESS_STATUS_BUSY}
                  : !entry.usable || !entry.problem.empty() ? std::int32_t{DEVICE_ACCESS_STATUS_NOACCESS}
                                                            : std::int32_t{DEVICE_ACCESS_STATUS_READWRITE},
                  to);
    case DEVICE_INFO_TIMESTAMP_FREQUENCY:
      require(opened != nullptr, GC_ERR_NOT_AVAILABLE, "the clock is known when the device is open");
      return give(static_cast<std::uint64_t>(std::llround(opened->camera()->source().rig().pixel_clock_hz())), to);
    default:
      no_answer(command);
  }
}

}  // namespace selfproj::gentl
