#include "host/gentl/gentl_errors.h"

#include <array>
#include <cstdio>

namespace selfproj::gentl {
namespace {

struct LastError {
  GC_ERROR code = GC_ERR_SUCCESS;
  std::array<char, 1024> text{};
};

LastError& last_error() {
  thread_local LastError error;
  return error;
}

}  // namespace

GC_ERROR failed(GC_ERROR code, const char* text) noexcept {
  last_error().code = code;
  static_cast<void>(std::snprintf(last_error().text.data(), last_error().text.size(), "%s", text));
  return code;
}

GC_ERROR last_error_code() noexcept { return last_error().code; }

const char* last_error_text() noexcept {
  return last_error().code == GC_ERR_SUCCESS ? "no error" : last_error().text.data();
}

}  // namespace selfproj::gentl
