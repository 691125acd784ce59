#ifndef SELFPROJ_HOST_DRIVER_BOARD_LIST_H
#define SELFPROJ_HOST_DRIVER_BOARD_LIST_H

#include <filesystem>
#include <string>
#include <vector>

namespace selfproj {

struct BoardPlace {
  std::string uri;
  std::string problem;  // why no board can be controlled there; empty if one can
};

// The files in `devices` that may hold registers of boards, xdma*_user and uio*, in the order of their names, and after
// them these hosts on the network.
std::vector<BoardPlace> list_boards(const std::filesystem::path& devices = "/dev",
                                    const std::vector<std::string>& hosts = {});

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_BOARD_LIST_H
