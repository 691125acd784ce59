#include "host/driver/board_list.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "host/driver/open_control.h"
#include "host/files/user_error.h"

namespace selfproj {

std::vector<BoardPlace> list_boards(const std::filesystem::path& devices, const std::vector<std::string>& hosts) {
  std::vector<BoardPlace> boards;
  std::error_code error;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(devices, error)) {
    const std::string name = entry.path().filename().string();
    if ((name.starts_with("xdma") && name.ends_with("_user")) || name.starts_with("uio")) {
      boards.push_back({.uri = "bar:" + entry.path().string(), .problem = ""});
    } else if (name.starts_with("litepcie")) {
      boards.push_back({.uri = "litepcie:" + entry.path().string(), .problem = ""});
    }
  }
  std::sort(boards.begin(), boards.end(), [](const auto& one, const auto& other) { return one.uri < other.uri; });
  for (const std::string& host : hosts) {
    boards.push_back({.uri = "udp:" + host, .problem = ""});
  }
  for (BoardPlace& board : boards) {
    try {
      static_cast<void>(open_control(board.uri));
    } catch (const UserError& problem) {
      const std::string text = problem.what();
      board.problem = text.starts_with(board.uri + ": ") ? text.substr(board.uri.size() + 2) : text;
    }
  }
  return boards;
}

}  // namespace selfproj
