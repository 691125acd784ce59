// The devices that appear as cameras: those of the environment variable SELFPROJ_GENTL_DEVICES, and the rings of this
// machine.
#ifndef SELFPROJ_HOST_GENTL_DEVICE_LIST_H
#define SELFPROJ_HOST_GENTL_DEVICE_LIST_H

#include <string>
#include <vector>

#include "host/gentl/gentl_types.h"

namespace selfproj::gentl {

// One device, in the variable as URI[?KEY=VALUE[&KEY=VALUE]...]. Keys are rig, reference, control and name. A camera
// without a board, camera:NAME, has no control, and also takes the keys of host/camera/camera_uri.h.
struct DeviceEntry {
  std::string id = {};          // the URI without the keys: the device's ID
  std::string parameters = {};  // of a camera: its own keys, KEY=VALUE[&KEY=VALUE]...
  std::string rig = "light-section";
  std::string reference = {};  // empty: the plane
  std::string control = {};    // empty: the control that belongs to the device, if there is one
  std::string name = {};       // empty: the ID
  std::string problem = {};    // what is wrong with the text; empty: nothing
  bool usable = true;          // false: a ring that could not be opened when the list was made
  bool in_use = false;         // another process reads it

  bool operator==(const DeviceEntry&) const = default;

  // The URI with which the device is opened.
  [[nodiscard]] std::string uri() const { return parameters.empty() ? id : id + "?" + parameters; }

  [[nodiscard]] const std::string& display_name() const { return name.empty() ? id : name; }
};

// The devices of a text in the format of the variable, separated by `;`. A part that cannot be parsed becomes an entry
// with a problem.
std::vector<DeviceEntry> parse_devices(const std::string& text);

// The present devices: first those of the variable, then the other rings.
std::vector<DeviceEntry> list_devices();

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_DEVICE_LIST_H
