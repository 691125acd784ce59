// The features of a module: one list from which its registers and its GenICam XML are made.
#ifndef SELFPROJ_HOST_GENTL_FEATURE_SET_H
#define SELFPROJ_HOST_GENTL_FEATURE_SET_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace selfproj::gentl {

enum class FeatureKind : std::uint8_t { integer, real, text, choice, flag, command, chunk };

// An entry of a choice. Entries that the standard defines have the standard's numbers.
struct FeatureEntry {
  std::string name;
  std::int64_t value = 0;
  std::string available_by = {};  // a feature that is 1 when it can be chosen; empty: always
};

// One feature. Without `set` it can only be read.
struct Feature {
  FeatureKind kind = FeatureKind::integer;
  std::string name = {};
  std::string category = {};  // empty: not shown; only other features use it
  std::string tip = {};
  std::function<std::int64_t()> get = {};  // integer, choice (the entry's number), flag
  std::function<void(std::int64_t)> set = {};
  std::function<double()> get_real = {};
  std::function<std::string()> get_text = {};
  std::int64_t min = 0;
  std::int64_t max = INT64_MAX;
  std::string unit = {};
  std::vector<FeatureEntry> entries = {};
  std::vector<std::string> selects = {};  // features whose meaning depends on this one
  std::string locked_by = {};             // a feature that is 1 when this one cannot be written
  bool standard = true;                   // its name is one of the standard's names
  // Chunks: an 8-byte number in a chunk of a buffer. With `stride` there is one for each line.
  std::uint32_t chunk_id = 0;
  std::size_t chunk_offset = 0;
  std::size_t stride = 0;
};

// What the XML says of the module.
struct FeatureSetName {
  std::string model;     // without spaces
  std::string tip;       // what the module is
  std::string standard;  // name space of the standard: None, GEV, ...
};

class FeatureSet {
 public:
  static constexpr std::uint64_t kXmlAddress = 0x100000;
  static constexpr std::size_t kTextBytes = 1024;

  explicit FeatureSet(FeatureSetName name) : name_(std::move(name)) {}

  void add(Feature feature);

  // The XML of the features added so far, and the URL by which a consumer finds it at kXmlAddress.
  [[nodiscard]] const std::string& xml();
  [[nodiscard]] std::string url();
  [[nodiscard]] const FeatureSetName& name() const { return name_; }

  // Read or write a register, a part of one, or the XML. Throw GC_ERR_INVALID_ADDRESS for any other address,
  // GC_ERR_ACCESS_DENIED for writes to what can only be read, and GC_ERR_INVALID_VALUE for a value that the feature
  // cannot have.
  void read(std::uint64_t address, std::span<std::uint8_t> to);
  void write(std::uint64_t address, std::span<const std::uint8_t> from);

  // A feature by its name; null if there is none.
  [[nodiscard]] const Feature* find(std::string_view name) const;

 private:
  [[nodiscard]] static std::vector<std::uint8_t> value_of(const Feature& feature);
  [[nodiscard]] std::size_t index_of(std::uint64_t address, std::size_t bytes) const;

  FeatureSetName name_;
  std::vector<Feature> features_;
  std::string xml_;
};

// The address of the register of feature `index`, and the number of bytes of a feature's register.
constexpr std::uint64_t feature_address(std::size_t index) {
  return 0x1000 + static_cast<std::uint64_t>(index) * FeatureSet::kTextBytes;
}
std::size_t feature_bytes(const Feature& feature);

// The XML of these features.
std::string feature_xml(const FeatureSetName& name, const std::vector<Feature>& features);

}  // namespace selfproj::gentl

#endif  // SELFPROJ_HOST_GENTL_FEATURE_SET_H
