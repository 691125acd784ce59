// A network interface of this machine that is a file: what the kernel sends on it can be read, and what is written to
// it comes to the kernel.
#ifndef SELFPROJ_SIM_TARGET_TAP_H
#define SELFPROJ_SIM_TARGET_TAP_H

#include <optional>
#include <string>

#include "sim/target/rgmii.h"

namespace selfproj {

class Tap {
 public:
  // Throws std::runtime_error with the interface's name and the reason.
  explicit Tap(const std::string& name);
  Tap(const Tap&) = delete;
  Tap& operator=(const Tap&) = delete;
  ~Tap();

  std::optional<EthernetFrame> receive();  // nothing if none waits
  bool send(const EthernetFrame& frame);   // false if the kernel has no room or the interface is down

 private:
  int file_ = -1;
};

}  // namespace selfproj

#endif  // SELFPROJ_SIM_TARGET_TAP_H
