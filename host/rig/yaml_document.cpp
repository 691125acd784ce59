#include "host/rig/yaml_document.h"

#include <fmt/format.h>
#include <yaml-cpp/eventhandler.h>
#include <yaml-cpp/parser.h>
#include <yaml-cpp/yaml.h>

#include <sstream>
#include <string>

#include "host/io/user_error.h"

namespace selfproj {
namespace {

constexpr int kDeepest = 16;

// Looks at a document without building it.
class Judge final : public YAML::EventHandler {
 public:
  explicit Judge(const std::string& source) : source_(source) {}

  void OnDocumentStart(const YAML::Mark& mark) override {
    if (++documents_ > 1) {
      fail(mark, "a second document begins; one is expected");
    }
  }
  void OnDocumentEnd() override {}
  void OnNull(const YAML::Mark& /*mark*/, YAML::anchor_t /*anchor*/) override {}
  void OnAlias(const YAML::Mark& mark, YAML::anchor_t /*anchor*/) override { fail(mark, "aliases are not understood"); }
  void OnScalar(const YAML::Mark& /*mark*/, const std::string& /*tag*/, YAML::anchor_t /*anchor*/,
                const std::string& /*value*/) override {}
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
    if (++depth_ > kDeepest) {
      fail(mark, "is nested too deeply");
    }
  }
  [[noreturn]] void fail(const YAML::Mark& mark, const char* reason) const {
    throw UserError(source_, fmt::format("line {}: {}", mark.line + 1, reason));
  }

  const std::string& source_;
  int documents_ = 0;
  int depth_ = 0;
};

}  // namespace

YAML::Node parse_yaml(const std::string& text, const std::string& source) {
  try {
    std::istringstream stream(text);
    YAML::Parser parser(stream);
    Judge judge(source);
    while (parser.HandleNextDocument(judge)) {
    }
    return YAML::Load(text);
  } catch (const YAML::Exception& error) {
    throw UserError(source, fmt::format("line {}: {}", error.mark.line + 1, error.msg));
  }
}

}  // namespace selfproj
