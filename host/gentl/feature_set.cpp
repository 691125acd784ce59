#include "host/gentl/feature_set.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

#include "host/gentl/gentl_errors.h"

namespace selfproj::gentl {

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
  if (feature.kind == FeatureKind::choice ? !entry : value < feature.least || value > feature.greatest) {
    throw GenTLError(GC_ERR_INVALID_VALUE, fmt::format("{} cannot be {}", feature.name, value));
  }
  feature.set(value);
}

}  // namespace selfproj::gentl
