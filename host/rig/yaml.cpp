#include "host/rig/yaml.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cstddef>
#include <functional>
#include <sstream>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"

namespace selfproj::rig {
namespace {

using Fault = std::function<std::string(const std::string&)>;

// Looks at a document without building it.
class DocumentValidator final : public YAML::EventHandler {
 public:
  DocumentValidator(const std::string& source, const Fault& fault) : source_(source), fault_(fault) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) {
      fail(mark, "a second document begins; one is expected");
    }
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { fail(mark, "aliases are not understood"); }
  void OnScalar(const YAML::Mark& mark, const std::string& tag, YAML::anchor_t /*anchor*/,
                const std::string& value) override {
    const bool quoted = tag == "!";
    if (const std::string reason = fault_ && !quoted ? fault_(value) : ""; !reason.empty()) {
      fail(mark, reason.c_str());
    }
  }
  void OnSequenceStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                       YAML::EmitterStyle::value /*style*/) override {
    enter(mark);
  }
  void OnSequenceEnd() override { --depth_; }
  void OnMapStart(const YAML::Mark& mark, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                  YAML::EmitterStyle::value /*style*/) override {
    enter(mark);
  }
  void OnMapEnd() override { --depth_; }

 private:
  void enter(const YAML::Mark& mark) {
    if (++depth_ > kDeepestDocument) {
      fail(mark, "is nested too deeply");
    }
  }
  [[noreturn]] void fail(const YAML::Mark& mark, const char* reason) const {
    throw UserError(source_, fmt::format("line {}: {}", mark.line + 1, reason));
  }

  const std::string& source_;
  const Fault& fault_;
  int documents_ = 0;
  int depth_ = 0;
};

}  // namespace

void validate_yaml(const std::string& text, const std::string& source, const Fault& fault) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    DocumentValidator validator(source, fault);
    while (parser.HandleNextDocument(validator)) {
    }
  } catch (const YAML::Exception& error) {
    throw UserError(source, fmt::format("line {}: {}", error.mark.line + 1, error.msg));
  }
}

YAML::Node parse_yaml(const std::string& text, const std::string& source) {
  validate_yaml(text, source, {});
  try {
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw UserError(source, fmt::format("line {}: {}", error.mark.line + 1, error.msg));
  }
}

std::vector<std::string> earlier_names(const std::string& key) {
  const std::size_t last = key.rfind('.') + 1;  // 0 without a point
  const std::string prefix = key.substr(0, last);
  const std::string rest = key.substr(std::min(key.size(), last + 4));
  if (key.compare(last, 4, "min_") == 0) {
    return {prefix + "least_" + rest, prefix + "lowest_" + rest};
  }
  if (key.compare(last, 4, "max_") == 0) {
    return {prefix + "most_" + rest, prefix + "highest_" + rest};
  }
  return {};
}

}  // namespace selfproj::rig
