#include "capi/errors.h"

#include <array>
#include <cstdio>

#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {
namespace {

std::array<char, 1024>& last_error() {
  thread_local std::array<char, 1024> text{};
  return text;
}

}  // namespace

std::int32_t failed(std::int32_t result, const char* text) noexcept {
  static_cast<void>(std::snprintf(last_error().data(), last_error().size(), "%s", text));
  return result;
}

}  // namespace selfproj

std::uint32_t selfproj_abi_version() { return SELFPROJ_ABI_VERSION; }

std::uint32_t selfproj_spec_hash() { return selfproj::spec::kHash; }

const char* selfproj_last_error() { return selfproj::last_error().data(); }
