#include "host/gentl/device_list.h"

#include <algorithm>
#include <cstdlib>
#include <map>
#include <sstream>

#include "host/camera/camera_uri.h"
#include "host/driver/ring_memory.h"

namespace selfproj::gentl {
namespace {

std::vector<std::string> split_text(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, separator);) {
    parts.push_back(part);
  }
  return parts;
}

void set_key(DeviceEntry& entry, const std::string& word) {
  const std::map<std::string, std::string DeviceEntry::*> keys{{"rig", &DeviceEntry::rig},
                                                               {"reference", &DeviceEntry::reference},
                                                               {"control", &DeviceEntry::control},
                                                               {"name", &DeviceEntry::name}};
  const std::size_t equals = word.find('=');
  const auto key = keys.find(word.substr(0, equals));
  if (camera::is_camera_uri(entry.id)) {
    if (key == keys.end()) {  // the camera's own, which is checked when it is opened
      entry.parameters += (entry.parameters.empty() ? "" : "&") + word;
      return;
    }
    if (key->first == "control") {
      entry.problem =
          entry.id + ": SELFPROJ_GENTL_DEVICES has '" + word + "', but a camera without a board has no control";
      return;
    }
  }
  if (key == keys.end() || equals == std::string::npos || equals + 1 == word.size()) {
    entry.problem = entry.id + ": SELFPROJ_GENTL_DEVICES has '" + word +
                    "' behind '?'; use rig=RIG, reference=DIR, control=URI or name=TEXT";
    return;
  }
  entry.*(key->second) = word.substr(equals + 1);
}

}  // namespace

std::vector<DeviceEntry> parse_devices(const std::string& text) {
  std::vector<DeviceEntry> entries;
  for (const std::string& part : split_text(text, ';')) {
    if (part.find_first_not_of(' ') == std::string::npos) {
      continue;
    }
    const std::size_t question = part.rfind('?');
    DeviceEntry entry;
    entry.id = part.substr(0, question);
    if (question != std::string::npos) {
      for (const std::string& word : split_text(part.substr(question + 1), '&')) {
        set_key(entry, word);
      }
    }
    const bool known =
        std::any_of(entries.begin(), entries.end(), [&](const DeviceEntry& other) { return other.id == entry.id; });
    if (!known) {
      entries.push_back(entry);
    }
  }
  return entries;
}

std::vector<DeviceEntry> list_devices() {
  const char* const variable = std::getenv("SELFPROJ_GENTL_DEVICES");
  std::vector<DeviceEntry> entries = parse_devices(variable != nullptr ? variable : "");
  for (const driver::RingInfo& ring : driver::list_rings()) {
    const std::string id = "ring:" + ring.name;
    auto at = std::find_if(entries.begin(), entries.end(), [&](const DeviceEntry& entry) { return entry.id == id; });
    if (at == entries.end()) {
      at = entries.insert(entries.end(), DeviceEntry{.id = id});
    }
    at->in_use = ring.reader;
    at->usable = ring.problem.empty();
  }
  return entries;
}

}  // namespace selfproj::gentl
