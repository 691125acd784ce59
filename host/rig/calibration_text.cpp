#include "host/rig/calibration_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstddef>
#include <string>
#include <string_view>

#include "host/files/user_error.h"
#include "host/rig/yaml_document.h"

namespace selfproj {
namespace {

bool is_digit(char c) { return std::isdigit(static_cast<unsigned char>(c)) != 0; }

bool is_space(char c) { return std::isspace(static_cast<unsigned char>(c)) != 0; }

// Whether OpenCV reads the text as an octal or hexadecimal number.
bool is_not_decimal(std::string_view text) {
  if (text.starts_with('+') || text.starts_with('-')) {
    text.remove_prefix(1);
  }
  if (text.size() < 2 || text[0] != '0') {
    return false;
  }
  return text[1] == 'x' || text[1] == 'X' || std::all_of(text.begin(), text.end(), is_digit);
}

std::string not_decimal(std::string_view number) {
  return fmt::format("{} begins with 0; OpenCV would not read it as a decimal number", number);
}

// Walks through the tags of an XML text and the words between them.
class XmlJudge {
 public:
  XmlJudge(std::string_view text, const std::string& source) : text_(text), source_(source) {}

  void judge() {
    while (at_ < text_.size()) {
      if (text_[at_] == '<') {
        tag();
      } else {
        word();
      }
    }
  }

 private:
  // A comment is no tag, and neither are <? ... > and <! ... >.
  void tag() {
    const std::string_view rest = text_.substr(at_);
    const bool comment = rest.starts_with("<!--");
    const std::size_t end = text_.find(comment ? "-->" : ">", at_);
    const std::string_view inside = text_.substr(at_, end == std::string_view::npos ? end : end - at_);
    if (rest.starts_with("</")) {
      --depth_;
    } else if (!comment && !rest.starts_with("<?") && !rest.starts_with("<!") && !inside.ends_with('/') &&
               ++depth_ > kDeepestDocument) {
      fail("is nested too deeply");
    }
    at_ = end == std::string_view::npos ? text_.size() : end + 1;
  }

  // What stands between quotation marks is one word and no number.
  void word() {
    std::size_t end = at_;
    if (text_[at_] == '"') {
      end = std::min(text_.find_first_of("\"<", at_ + 1), text_.size());
      end += end < text_.size() && text_[end] == '"' ? 1 : 0;
    } else {
      while (end < text_.size() && text_[end] != '<' && !is_space(text_[end])) {
        ++end;
      }
      if (const std::string_view found = text_.substr(at_, end - at_); is_not_decimal(found)) {
        fail(not_decimal(found));
      }
    }
    at_ = std::max(end, at_ + 1);  // at least the space that stands here
  }

  [[noreturn]] void fail(const std::string& reason) const {
    const auto line = 1 + std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(at_), '\n');
    throw UserError(source_, fmt::format("line {}: {}", line, reason));
  }

  std::string_view text_;
  const std::string& source_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

}  // namespace

void check_calibration_text(const std::string& text, const std::string& source) {
  const std::size_t begin = std::min(text.find_first_not_of(" \t\r\n"), text.size());
  if (std::string_view(text).substr(begin).starts_with('<')) {
    XmlJudge(text, source).judge();
    return;
  }
  judge_yaml(text, source, [](const std::string& scalar) { return is_not_decimal(scalar) ? not_decimal(scalar) : ""; });
}

}  // namespace selfproj
