// The cameras of this machine and its network.
#ifndef SELFPROJ_HOST_CAMERA_CAMERA_LIST_H
#define SELFPROJ_HOST_CAMERA_CAMERA_LIST_H

#include <string>

namespace selfproj {

struct CameraEntry {
  std::string uri;      // for --device and --camera
  std::string kind;     // "GigE Vision", "USB3 Vision", "V4L2"
  std::string model;    // its maker and model, as it says
  std::string address;  // in the network, on the bus, or its path
  std::string problem;  // why it cannot be used; empty if nothing is known
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_CAMERA_LIST_H
