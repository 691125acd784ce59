// Records the inputs and outputs of a Verilated model, so that another simulator can be compared with it.
//
// Off unless the environment variable SELFPROJ_RECORD names a file. The first model of the program then writes
// NAME.ports (one line for each port: input or output, name, bits) and NAME.vectors (one line for each evaluation: the
// values of all ports in hexadecimal, inputs before outputs, x for an output that is not valid), with at most
// SELFPROJ_RECORD_STEPS lines (default 12,000).
#ifndef SELFPROJ_TESTS_RTL_BLOCKS_RECORDER_H
#define SELFPROJ_TESTS_RTL_BLOCKS_RECORDER_H

#include <verilated.h>

#include <cstdint>
#include <fstream>
#include <functional>
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

namespace selfproj::test {

class Recorder {
 public:
  // The recorder of this program for the first caller. Null for every other caller, and if nothing is to be recorded.
  static std::unique_ptr<Recorder> claim();

  explicit Recorder(const std::string& name, int steps);

  template <typename T>
  void input(const char* name, int bits, const T& value) {
    inputs_.push_back({name, bits, printer(bits, value), {}});
  }

  template <typename T>
  void output(const char* name, int bits, const T& value) {
    outputs_.push_back({name, bits, printer(bits, value), {}});
  }

  // The output counts only while `valid` returns true.
  void valid_when(const std::string& output, std::function<bool()> valid);

  // From now on outputs count, because the first reset is over.
  void outputs_are_known() { known_ = true; }

  // Call after every evaluation.
  void sample();

 private:
  struct Port {
    std::string name;
    int bits;
    std::function<void(std::string&)> print;
    std::function<bool()> valid;
  };

  static void append_hex(std::string& line, std::uint64_t value, int digits);

  template <typename T>
  static std::function<void(std::string&)> printer(int bits, const T& value) {
    if constexpr (std::is_integral_v<T>) {
      return [bits, &value](std::string& line) { append_hex(line, value, (bits + 3) / 4); };
    } else {  // an array of 32-bit words
      return [bits, &value](std::string& line) {
        for (int word = (bits - 1) / 32; word >= 0; --word) {
          append_hex(line, value[static_cast<std::size_t>(word)], (std::min(bits - 32 * word, 32) + 3) / 4);
        }
      };
    }
  }

  void write_ports();

  std::string name_;
  std::vector<Port> inputs_;
  std::vector<Port> outputs_;
  std::ofstream vectors_;
  int steps_left_;
  bool known_ = false;
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_RTL_BLOCKS_RECORDER_H
