#include "tests/rtl/blocks/recorder.h"

#include <cstdlib>
#include <stdexcept>

namespace selfproj::test {

std::unique_ptr<Recorder> Recorder::claim() {
  static bool claimed = false;
  const char* name = std::getenv("SELFPROJ_RECORD");
  if (name == nullptr || claimed) {
    return nullptr;
  }
  claimed = true;
  const char* steps = std::getenv("SELFPROJ_RECORD_STEPS");
  return std::make_unique<Recorder>(name, steps != nullptr ? std::atoi(steps) : 12000);
}

Recorder::Recorder(const std::string& name, int steps) : name_(name), vectors_(name + ".vectors"), steps_left_(steps) {
  if (!vectors_) {
    throw std::runtime_error("Recorder: cannot write " + name + ".vectors");
  }
}

void Recorder::valid_when(const std::string& output, std::function<bool()> valid) {
  for (Port& port : outputs_) {
    if (port.name == output) {
      port.valid = std::move(valid);
      return;
    }
  }
  throw std::logic_error("Recorder: no output " + output);
}

void Recorder::append_hex(std::string& line, std::uint64_t value, int digits) {
  for (int digit = digits - 1; digit >= 0; --digit) {
    line.push_back("0123456789abcdef"[value >> (4 * digit) & 15]);
  }
}

void Recorder::write_ports() {
  std::ofstream ports(name_ + ".ports");
  for (const Port& port : inputs_) {
    ports << "input " << port.name << ' ' << port.bits << '\n';
  }
  for (const Port& port : outputs_) {
    ports << "output " << port.name << ' ' << port.bits << '\n';
  }
  if (!ports.flush()) {
    throw std::runtime_error("Recorder: cannot write " + name_ + ".ports");
  }
}

void Recorder::sample() {
  if (steps_left_ == 0) {
    return;
  }
  if (vectors_.tellp() == std::ofstream::pos_type(0)) {
    write_ports();
  }
  std::string line;
  for (const Port& port : inputs_) {
    port.print(line);
    line.push_back(' ');
  }
  for (const Port& port : outputs_) {
    if (known_ && (!port.valid || port.valid())) {
      port.print(line);
    } else {
      line.push_back('x');
    }
    line.push_back(' ');
  }
  line.back() = '\n';
  vectors_ << line;
  if (--steps_left_ == 0 && !vectors_.flush()) {
    throw std::runtime_error("Recorder: cannot write " + name_ + ".vectors");
  }
}

}  // namespace selfproj::test
