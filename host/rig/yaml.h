// YAML: one document out of a text, and its keys: a reader and a writer with the same functions, one for each type of
// value.
#ifndef SELFPROJ_HOST_RIG_YAML_H
#define SELFPROJ_HOST_RIG_YAML_H

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <functional>
#include <initializer_list>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/notes.h"
#include "host/files/numbers.h"
#include "selfproj/files/user_error.h"

namespace selfproj::rig {

// The document of the text. Throws UserError, naming `source` and the line: it is not YAML, has none or more than one
// document, aliases (which could name each other without an end), or is nested deeper than any file of ours.
YAML::Node parse_yaml(const std::string& text, const std::string& source);

inline constexpr int kDeepestDocument = 16;  // levels

// The same checks without the document, which is then read by something else. `fault` gets each scalar that stands
// without quotation marks; if it returns a text, the scalar is refused for this reason.
void validate_yaml(const std::string& text, const std::string& source,
                   const std::function<std::string(const std::string&)>& fault);

inline constexpr double kMaxMagnitude = 1e6;  // mm: larger than any machine

// The range of a number.
struct ValueRange {
  double low;
  double high;
  bool zero = true;  // may be 0, or nearer to it than kMinMagnitude
};
inline constexpr double kMinMagnitude =
    1e-9;  // smaller than any quantity that may not be 0: its inverse is a number, too
inline constexpr ValueRange kPositive{.low = kMinMagnitude, .high = kMaxMagnitude};
inline constexpr ValueRange kNotNegative{.low = 0, .high = kMaxMagnitude};
inline constexpr ValueRange kAny{.low = -kMaxMagnitude, .high = kMaxMagnitude};
inline constexpr ValueRange kNotZero{.low = -kMaxMagnitude, .high = kMaxMagnitude, .zero = false};

// The names under which files of earlier versions have a key, for one version more: least_x or lowest_x for min_x,
// most_x or highest_x for max_x, also behind a prefix that ends with a point. Empty for other keys.
std::vector<std::string> earlier_names(const std::string& key);

// Reads the keys from a YAML document. A key under an earlier name is read, and noted (host/files/notes.h).
class FieldReader {
 public:
  FieldReader(std::string source, const YAML::Node& root) : source_(std::move(source)) { enter({}, root); }

  void text(const char* key, std::string& value) {
    value = scalar(key).Scalar();
    if (value.empty()) {
      fail(key, "is empty");
    }
  }

  template <class T>
  void choice(const char* key, T& value, const std::vector<std::pair<const char*, T>>& choices) {
    const std::string given = scalar(key).Scalar();
    std::string names;
    for (const auto& [name, meaning] : choices) {
      if (given == name) {
        value = meaning;
        return;
      }
      names += names.empty() ? name : fmt::format(", {}", name);
    }
    fail(key, fmt::format("is '{}'; one of {} is expected", given, names));
  }

  void number(const char* key, double& value, double unit, ValueRange range) {
    const auto given = as<double>(key, "a number");
    if (!range.zero && std::abs(given) < kMinMagnitude) {
      fail(key, given == 0 ? "is 0" : fmt::format("is {}; its size must be at least {}", given, kMinMagnitude));
    }
    if (given < range.low || given > range.high) {
      const bool open = range.low == kMinMagnitude && given <= 0;
      fail(key, range.low == -kMaxMagnitude
                    ? fmt::format("is {}; its size may be at most {}", given, range.high)
                    : fmt::format("is {}; it must be {} {} and at most {}", given, open ? "greater than" : "at least",
                                  open ? 0 : range.low, range.high));
    }
    value = given * unit;
  }

  void integer(const char* key, int& value, int low, int high) {
    const int given = as<int>(key, "a whole number");
    if (given < low || given > high) {
      fail(key, fmt::format("is {}; it must be at least {} and at most {}", given, low, high));
    }
    value = given;
  }

  // A list of numbers of this range.
  void numbers(const char* key, std::vector<double>& values, double unit, ValueRange range) {
    const YAML::Node node = find(key);
    if (!node.IsSequence()) {
      fail(key, "is not a list of numbers");
    }
    values.clear();
    for (const auto& entry : node) {
      const auto given = entry.IsScalar() ? files::number_of_text<double>(entry.Scalar()) : std::nullopt;
      if (!given || *given < range.low || *given > range.high) {
        fail(key, fmt::format("has an entry, number {}, that is not a number from {} to {}", values.size() + 1,
                              range.low, range.high));
      }
      values.push_back(*given * unit);
    }
  }

  // Throws if one of the keys is present, as `other` takes its place.
  void refuse(std::initializer_list<const char*> keys, const char* other) {
    for (const char* key : keys) {
      if (std::as_const(levels_.back().node)[key].IsDefined()) {
        fail(key, fmt::format("does not go with {}", other));
      }
    }
  }

  void integer64(const char* key, std::int64_t& value) { value = as<std::int64_t>(key, "a whole number"); }

  // Returns whether one of these keys is present, and if so creates the value.
  template <class T>
  bool has_any(std::initializer_list<const char*> keys, std::optional<T>& value) {
    const YAML::Node& node = levels_.back().node;
    if (std::any_of(keys.begin(), keys.end(), [&](const char* key) { return std::as_const(node)[key].IsDefined(); })) {
      value.emplace();
    }
    return value.has_value();
  }

  void begin(const char* key) {
    const YAML::Node node = find(key);
    if (!node.IsMap()) {
      fail(key, "is not a map of keys");
    }
    enter(path(key), node);
  }

  // Throws for any key that nobody has asked for, since it does not exist.
  void end() {
    const Level& level = levels_.back();
    std::set<std::string> seen;
    for (const auto& entry : level.node) {
      const std::string key = entry.first.IsScalar() ? entry.first.Scalar() : "?";
      if (level.asked.count(key) == 0) {
        std::string wanted;
        for (const std::string& name : level.asked) {  // perhaps the same quantity in another unit
          if (name.substr(0, name.rfind('_')) == key.substr(0, key.rfind('_'))) {
            wanted = fmt::format("; the key is {}", name);
          }
        }
        throw UserError(
            source_, fmt::format("line {}: {}: unknown key{}", entry.first.Mark().line + 1, path(key.c_str()), wanted));
      }
      if (!seen.insert(key).second) {
        throw UserError(source_,
                        fmt::format("line {}: {}: occurs twice", entry.first.Mark().line + 1, path(key.c_str())));
      }
    }
    levels_.pop_back();
  }

 private:
  struct Level {
    std::string prefix;
    YAML::Node node;
    std::set<std::string> asked;
  };

  void enter(const std::string& prefix, const YAML::Node& node) { levels_.push_back({prefix, node, {}}); }

  std::string path(const char* key) const {
    const std::string& prefix = levels_.back().prefix;
    return prefix.empty() ? key : prefix + "." + key;
  }

  [[noreturn]] void fail(const char* key, const std::string& reason) {
    const auto& [node, name] = lookup(key);
    throw UserError(source_, fmt::format("line {}: {} {}", node.Mark().line + 1, path(name.c_str()), reason));
  }

  // The node of a key and the name that it has in the file; not defined if there is none.
  std::pair<YAML::Node, std::string> lookup(const char* key) const {
    const YAML::Node& level = levels_.back().node;
    std::vector<std::string> names = earlier_names(key);
    names.insert(names.begin(), key);
    for (const std::string& name : names) {
      if (const YAML::Node node = level[name]; node.IsDefined()) {
        return {node, name};
      }
    }
    return {level[key], key};
  }

  // If the key is missing but present in another unit, the error names the latter, which `end` would call unknown.
  YAML::Node find(const char* key) {
    Level& level = levels_.back();
    const auto [node, found] = lookup(key);
    level.asked.insert({key, found});
    const std::string name = key;
    if (node.IsDefined()) {
      if (found != name) {
        files::note(fmt::format("{}: line {}: {}: this key is now called {}; the old name is read for one version more",
                                source_, node.Mark().line + 1, path(found.c_str()), name));
      }
      return node;
    }
    for (const auto& entry : level.node) {
      const std::string other = entry.first.IsScalar() ? entry.first.Scalar() : "";
      const std::string stem = name.substr(0, name.rfind('_'));
      if (other != name && name.find('_') != std::string::npos && other.rfind(stem + "_", 0) == 0 &&
          other.find('_', stem.size() + 1) == std::string::npos && level.asked.count(other) == 0) {
        throw UserError(source_, fmt::format("line {}: {}: unknown key; the key is {}", entry.first.Mark().line + 1,
                                             path(other.c_str()), name));
      }
    }
    throw UserError(source_, fmt::format("{} is missing", path(key)));
  }

  YAML::Node scalar(const char* key) {
    const YAML::Node node = find(key);
    if (!node.IsScalar()) {
      fail(key, "has no single value");
    }
    return node;
  }

  template <class T>
  T as(const char* key, const char* what) {
    const std::string text = scalar(key).Scalar();
    const std::optional<T> value = files::number_of_text<T>(text);
    if (!value) {
      fail(key, fmt::format("is '{}', not {}", text, what));
    }
    return *value;
  }

  std::string source_;
  std::vector<Level> levels_;
};

// Writes the keys as YAML.
class FieldWriter {
 public:
  void text(const char* key, const std::string& value) {
    YAML::Emitter quoted;  // quotes the name if it needs quotes
    quoted << value;
    line(key, quoted.c_str());
  }
  template <class T>
  void choice(const char* key, const T& value, const std::vector<std::pair<const char*, T>>& choices) {
    const auto found = std::find_if(choices.begin(), choices.end(), [&](const auto& c) { return c.second == value; });
    line(key, found->first);
  }
  void number(const char* key, double value, double unit, ValueRange /*range*/) { line(key, shortest(value, unit)); }
  void numbers(const char* key, const std::vector<double>& values, double unit, ValueRange /*range*/) {
    std::string list;
    for (const double value : values) {
      list += (list.empty() ? "" : ", ") + shortest(value, unit);
    }
    line(key, "[" + list + "]");
  }
  void refuse(std::initializer_list<const char*> /*keys*/, const char* /*other*/) {}
  void integer(const char* key, int value, int /*low*/, int /*high*/) { line(key, std::to_string(value)); }
  void integer64(const char* key, std::int64_t value) { line(key, std::to_string(value)); }
  template <class T>
  bool has_any(std::initializer_list<const char*> /*keys*/, const std::optional<T>& value) {
    return value.has_value();
  }
  void begin(const char* key) {
    line(key, "");
    indent_ += kIndent;
  }
  void end() { indent_.resize(indent_.size() - kIndent.size()); }
  [[nodiscard]] const std::string& yaml() const { return yaml_; }

 private:
  static constexpr std::string_view kIndent = "  ";

  // The shortest text that reads back to the same value.
  static std::string shortest(double value, double unit) {
    double shown = value / unit;
    for (int digits = 6; digits < 18; ++digits) {
      const std::optional<double> candidate = files::number_of_text<double>(fmt::format("{:.{}g}", shown, digits));
      if (candidate && *candidate * unit == value) {
        shown = *candidate;
        break;
      }
    }
    return fmt::format("{}", shown);
  }

  void line(const char* key, const std::string& value) {
    yaml_ += fmt::format("{}{}:{}{}\n", indent_, key, value.empty() ? "" : " ", value);
  }

  std::string indent_;
  std::string yaml_;
};

}  // namespace selfproj::rig

#endif  // SELFPROJ_HOST_RIG_YAML_H
