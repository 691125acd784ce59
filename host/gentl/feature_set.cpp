// GenICam XML (schema 1.1) of a list of features.
#include "host/gentl/feature_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>
#include <vector>

#include "host/gentl/answer.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::gentl {
namespace {

constexpr const char* kLineSelector = "ChunkScanLineSelector";

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    out += c == '&' ? "&amp;" : c == '<' ? "&lt;" : c == '>' ? "&gt;" : c == '"' ? "&quot;" : std::string(1, c);
  }
  return out;
}

std::string element(const char* name, const std::string& text) {
  return fmt::format("    <{0}>{1}</{0}>\n", name, escaped(text));
}

std::string opening(const char* kind, const std::string& name, bool standard) {
  return fmt::format("  <{} Name=\"{}\" NameSpace=\"{}\">\n", kind, name, standard ? "Standard" : "Custom");
}

// What every feature begins with, in the order of the schema.
std::string head(const char* kind, const Feature& feature) {
  std::string out = opening(kind, feature.name, feature.standard);
  out += element("ToolTip", feature.tip);
  out += element("Description", feature.tip);
  out += element("DisplayName", feature.name);
  out += element("Visibility", feature.category.empty() ? "Invisible" : "Beginner");
  if (!feature.locked_by.empty()) {
    out += element("pIsLocked", feature.locked_by);
  }
  return out;
}

std::string selected(const Feature& feature) {
  std::string out;
  for (const std::string& name : feature.selects) {
    out += element("pSelected", name);
  }
  return out;
}

std::string register_name(const Feature& feature) { return feature.name + "_Register"; }

std::string chunk_port(std::uint32_t id) { return fmt::format("ChunkPort_{:X}", id); }

// The register from which the feature gets its value.
std::string register_node(const char* kind, const Feature& feature, std::size_t index) {
  const bool chunk = feature.kind == FeatureKind::chunk;
  std::string out = opening(kind, register_name(feature), false);
  out += element("Visibility", "Invisible");
  out += element("Address", fmt::format("0x{:X}", chunk ? feature.chunk_offset : feature_address(index)));
  if (feature.stride > 0) {
    out += fmt::format("    <pIndex Offset=\"{}\">{}</pIndex>\n", feature.stride, kLineSelector);
  }
  out += element("Length", std::to_string(feature_bytes(feature)));
  out += element("AccessMode", feature.kind == FeatureKind::command ? "WO" : feature.set ? "RW" : "RO");
  out += element("pPort", chunk ? chunk_port(feature.chunk_id) : "Device");
  out += element("Cachable", "NoCache");
  if (feature.kind != FeatureKind::real && feature.kind != FeatureKind::text) {
    out += element("Sign", "Signed");
  }
  if (feature.kind != FeatureKind::text) {
    out += element("Endianess", "LittleEndian");
  }
  return out + fmt::format("  </{}>\n", kind);
}

std::string integer_node(const Feature& feature) {
  std::string out = head("Integer", feature);
  out += element("pValue", register_name(feature));
  if (feature.set) {
    out += element("Min", std::to_string(feature.min));
    out += element("Max", std::to_string(feature.max));
    out += element("Inc", "1");
  }
  if (!feature.unit.empty()) {
    out += element("Unit", feature.unit);
  }
  return out + selected(feature) + "  </Integer>\n";
}

std::string choice_node(const Feature& feature) {
  std::string out = head("Enumeration", feature);
  for (const FeatureEntry& entry : feature.entries) {
    out += fmt::format("    <EnumEntry Name=\"{}\" NameSpace=\"{}\">\n", entry.name,
                       feature.standard ? "Standard" : "Custom");
    if (!entry.available_by.empty()) {
      out += "  " + element("pIsAvailable", entry.available_by);
    }
    out += "  " + element("Value", std::to_string(entry.value)) + "    </EnumEntry>\n";
  }
  return out + element("pValue", register_name(feature)) + selected(feature) + "  </Enumeration>\n";
}

std::string real_node(const Feature& feature) {
  std::string out = head("Float", feature) + element("pValue", register_name(feature));
  if (!feature.unit.empty()) {
    out += element("Unit", feature.unit);
  }
  return out + "  </Float>\n";
}

std::string nodes_of(const Feature& feature, std::size_t index) {
  const std::string value = element("pValue", register_name(feature));
  switch (feature.kind) {
    case FeatureKind::integer:
    case FeatureKind::chunk:
      return integer_node(feature) + register_node("IntReg", feature, index);
    case FeatureKind::real:
      return real_node(feature) + register_node("FloatReg", feature, index);
    case FeatureKind::choice:
      return choice_node(feature) + register_node("IntReg", feature, index);
    case FeatureKind::flag:
      return head("Boolean", feature) + value + element("OnValue", "1") + element("OffValue", "0") + "  </Boolean>\n" +
             register_node("IntReg", feature, index);
    case FeatureKind::command:
      return head("Command", feature) + value + element("CommandValue", "1") + "  </Command>\n" +
             register_node("IntReg", feature, index);
    case FeatureKind::text: {
      const std::string rest = register_node("StringReg", feature, index);
      return head("StringReg", feature) + rest.substr(rest.find("    <Address>"));
    }
  }
  return {};
}

std::string categories(const std::vector<Feature>& features) {
  std::vector<std::string> names;
  for (const Feature& feature : features) {
    if (!feature.category.empty() && std::find(names.begin(), names.end(), feature.category) == names.end()) {
      names.push_back(feature.category);
    }
  }
  std::string out = opening("Category", "Root", true);
  for (const std::string& name : names) {
    out += element("pFeature", name);
  }
  out += "  </Category>\n";
  for (const std::string& name : names) {
    out += opening("Category", name, true);
    for (const Feature& feature : features) {
      if (feature.category == name) {
        out += element("pFeature", feature.name);
      }
    }
    const bool lines = std::any_of(features.begin(), features.end(), [&](const Feature& feature) {
      return feature.category == name && feature.stride > 0;
    });
    out += (lines ? element("pFeature", kLineSelector) : "") + "  </Category>\n";
  }
  return out;
}

}  // namespace

std::string feature_xml(const FeatureSetName& name, const std::vector<Feature>& features) {
  // The version changes with the specification, so that a consumer's cache of XML files never holds an old one of it.
  std::string out = fmt::format(
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<RegisterDescription ModelName=\"{0}\" VendorName=\"selfproj\" ToolTip=\"{1}\" StandardNameSpace=\"{2}\" "
      "SchemaMajorVersion=\"1\" SchemaMinorVersion=\"1\" SchemaSubMinorVersion=\"0\" MajorVersion=\"1\" "
      "MinorVersion=\"0\" SubMinorVersion=\"0\" ProductGuid=\"5E1F0000-0000-4000-8000-0000{3:08X}\" "
      "VersionGuid=\"5E1F0001-0000-4000-8000-0000{3:08X}\" "
      "xmlns=\"http://www.genicam.org/GenApi/Version_1_1\" xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
      "xsi:schemaLocation=\"http://www.genicam.org/GenApi/Version_1_1 "
      "http://www.genicam.org/GenApi/GenApiSchema_Version_1_1.xsd\">\n",
      name.model, escaped(name.tip), name.standard, spec::kHash);
  out += categories(features);
  std::set<std::uint32_t> chunks;
  for (std::size_t i = 0; i < features.size(); ++i) {
    out += nodes_of(features[i], i);
    if (features[i].kind == FeatureKind::chunk) {
      chunks.insert(features[i].chunk_id);
    }
  }
  for (const std::uint32_t id : chunks) {
    out += opening("Port", chunk_port(id), false) + element("Visibility", "Invisible") +
           element("ChunkID", fmt::format("{:X}", id)) + "  </Port>\n";
  }
  if (!chunks.empty()) {
    out += opening("Integer", kLineSelector, true) +
           element("ToolTip", "Line of the buffer, from 0, that the chunks below describe.") +
           element("Visibility", "Beginner") + element("Value", "0") + element("Min", "0") + element("Max", "65535") +
           "  </Integer>\n";
  }
  out += opening("Port", "Device", true) + element("Visibility", "Invisible") + "  </Port>\n";
  return out + "</RegisterDescription>\n";
}

std::size_t feature_bytes(const Feature& feature) {
  return feature.kind == FeatureKind::text ? FeatureSet::kTextBytes : sizeof(std::int64_t);
}

void FeatureSet::add(Feature feature) {
  features_.push_back(std::move(feature));
  xml_.clear();
}

const std::string& FeatureSet::xml() {
  if (xml_.empty()) {
    xml_ = feature_xml(name_, features_);
  }
  return xml_;
}

std::string FeatureSet::url() {
  return fmt::format("Local:{}.xml;{:X};{:X}?SchemaVersion=1.1.0", name_.model, kXmlAddress, xml().size());
}

const Feature* FeatureSet::find(std::string_view name) const {
  const auto at =
      std::find_if(features_.begin(), features_.end(), [&](const Feature& feature) { return feature.name == name; });
  return at != features_.end() ? &*at : nullptr;
}

std::vector<std::uint8_t> FeatureSet::value_of(const Feature& feature) {
  std::vector<std::uint8_t> bytes(feature_bytes(feature));
  if (feature.kind == FeatureKind::text) {
    const std::string text = feature.get_text();
    std::copy_n(text.begin(), std::min(text.size(), bytes.size() - 1), bytes.begin());
  } else if (feature.kind == FeatureKind::real) {
    const double value = feature.get_real();
    std::memcpy(bytes.data(), &value, sizeof value);
  } else {
    const std::int64_t value = feature.get ? feature.get() : 0;
    std::memcpy(bytes.data(), &value, sizeof value);
  }
  return bytes;
}

std::size_t FeatureSet::index_of(std::uint64_t address, std::size_t bytes) const {
  const std::uint64_t first = feature_address(0);
  const std::uint64_t index = (address - first) / kTextBytes;
  require(address >= first && index < features_.size() && features_[index].kind != FeatureKind::chunk &&
              bytes <= feature_bytes(features_[index]) &&
              address - feature_address(index) <= feature_bytes(features_[index]) - bytes,
          GC_ERR_INVALID_ADDRESS, "there is no register at this address, or it has fewer bytes");
  return index;
}

void FeatureSet::read(std::uint64_t address, std::span<std::uint8_t> to) {
  if (address >= kXmlAddress) {
    const std::uint64_t begin = address - kXmlAddress;
    require(begin <= xml().size() && to.size() <= xml().size() - begin, GC_ERR_INVALID_ADDRESS,
            "there are fewer bytes at this address");
    std::copy_n(xml().begin() + static_cast<std::ptrdiff_t>(begin), to.size(), to.begin());
    return;
  }
  const std::size_t index = index_of(address, to.size());
  const std::vector<std::uint8_t> value = value_of(features_[index]);
  std::copy_n(value.begin() + static_cast<std::ptrdiff_t>(address - feature_address(index)), to.size(), to.begin());
}

void FeatureSet::write(std::uint64_t address, std::span<const std::uint8_t> from) {
  require(address < kXmlAddress, GC_ERR_ACCESS_DENIED, "the XML cannot be written");
  const std::size_t index = index_of(address, from.size());
  const Feature& feature = features_[index];
  if (!feature.set) {
    throw GenTLError(GC_ERR_ACCESS_DENIED, feature.name + " can only be read");
  }
  if (!feature.locked_by.empty() && find(feature.locked_by)->get() != 0) {
    throw GenTLError(GC_ERR_ACCESS_DENIED,
                     fmt::format("{} cannot be written while {} is 1", feature.name, feature.locked_by));
  }
  std::int64_t value = 0;
  require(from.size() == sizeof value && address == feature_address(index), GC_ERR_INVALID_ADDRESS,
          "only the whole register can be written");
  std::memcpy(&value, from.data(), sizeof value);
  const bool entry = std::any_of(feature.entries.begin(), feature.entries.end(), [&](const FeatureEntry& one) {
    return one.value == value && (one.available_by.empty() || find(one.available_by)->get() != 0);
  });
  if (feature.kind == FeatureKind::choice ? !entry : value < feature.min || value > feature.max) {
    throw GenTLError(GC_ERR_INVALID_VALUE, fmt::format("{} cannot be {}", feature.name, value));
  }
  feature.set(value);
}

}  // namespace selfproj::gentl
