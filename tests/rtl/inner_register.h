// A register inside a Verilated model, read and set by its name: one of those that the counters.vlt of the model makes
// public.
#ifndef SELFPROJ_TESTS_RTL_INNER_REGISTER_H
#define SELFPROJ_TESTS_RTL_INNER_REGISTER_H

#include <verilated_vpi.h>

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>

namespace selfproj::test {

// Belongs to the model whose context is the thread's (Verilated::threadContextp) when it is made.
class InnerRegister {
 public:
  explicit InnerRegister(std::string name) : handle_(vpi_handle_by_name(name.data(), nullptr)) {
    if (handle_ == nullptr) {
      throw std::runtime_error("no register " + name);
    }
  }
  InnerRegister(const InnerRegister&) = delete;
  InnerRegister& operator=(const InnerRegister&) = delete;
  ~InnerRegister() { vpi_release_handle(handle_); }

  // up to 64 bits
  [[nodiscard]] std::uint64_t get() const {
    s_vpi_value value{};
    value.format = vpiVectorVal;
    vpi_get_value(handle_, &value);
    const auto word = [&](int i) {
      return static_cast<std::uint64_t>(static_cast<std::uint32_t>(value.value.vector[i].aval));
    };
    return vpi_get(vpiSize, handle_) > 32 ? word(0) | word(1) << 32U : word(0);
  }
  void set(std::uint64_t number) {
    std::array<s_vpi_vecval, 2> words{};
    words[0].aval = static_cast<PLI_INT32>(number);
    words[1].aval = static_cast<PLI_INT32>(number >> 32U);
    s_vpi_value value{};
    value.format = vpiVectorVal;
    value.value.vector = words.data();
    vpi_put_value(handle_, &value, nullptr, vpiNoDelay);
  }

 private:
  vpiHandle handle_;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_INNER_REGISTER_H
