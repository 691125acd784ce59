#ifndef SELFPROJ_HOST_DRIVER_BOARD_LIST_H
#define SELFPROJ_HOST_DRIVER_BOARD_LIST_H

#include <filesystem>
#include <string>
#include <vector>

namespace selfproj {

// A place where a board may be.
struct BoardPlace {
  std::string uri;
  std::string problem;  // why no board can be opened there; empty if one was
};

// Looks for boards, and tries to open the registers of each. First come the files of `devices`, sorted as text:
// xdma*_user and uio* as bar:FILE, litepcie* as litepcie:FILE. Then come `hosts`, as udp:HOST. A folder that cannot be
// read counts as empty.
std::vector<BoardPlace> list_boards(const std::filesystem::path& devices = "/dev",
                                    const std::vector<std::string>& hosts = {});

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_BOARD_LIST_H
