#include "host/driver/ring_list.h"

#include <sys/mman.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

#include "host/driver/ring_layout.h"
#include "host/driver/ring_memory.h"
#include "host/files/user_error.h"

namespace selfproj {
namespace {

constexpr const char* kFolder = "/dev/shm";  // where Linux keeps shared memory
constexpr const char* kPrefix = "selfproj-ring-";

RingInfo info_of(const std::string& name) {
  RingInfo info;
  info.name = name;
  ring::Memory memory;
  switch (memory.attach(ring::shared_name(name).c_str(), ring::Memory::Access::look)) {
    case ring::Memory::Found::ring:
      break;
    case ring::Memory::Found::other:
      info.problem = "another version or specification";
      return info;
    case ring::Memory::Found::no_access:
      info.problem = std::generic_category().message(errno);
      return info;
    case ring::Memory::Found::being_made:
      info.problem = "a board is making it";
      return info;
    default:
      info.problem = "not complete";
      return info;
  }
  const ring::Header& header = memory.header();
  info.board = memory.locked(ring::kWriterLock);
  info.reader = memory.locked(ring::kReaderLock);
  info.board_pid = header.writer_pid.load();
  info.reader_pid = header.reader_pid.load();
  info.slots = memory.slots();
  info.read = header.read.load();
  info.written = header.written.load();
  info.lost = header.lost.load();
  info.boards = header.generation.load();
  info.readers = header.readers.load();
  // A process that is marked as open but holds no lock has crashed, too.
  info.board_crashes = header.writer_crashes.load() + (!info.board && header.writer_open.load() != 0 ? 1 : 0);
  info.reader_crashes = header.reader_crashes.load() + (!info.reader && header.reader_open.load() != 0 ? 1 : 0);
  return info;
}

}  // namespace

std::vector<RingInfo> list_rings() {
  std::vector<RingInfo> rings;
  std::error_code error;
  const std::string prefix = kPrefix;
  for (std::filesystem::directory_iterator at(kFolder, error), end; !error && at != end; at.increment(error)) {
    const std::string file = at->path().filename().string();
    if (file.starts_with(prefix) && ring::is_name(file.substr(prefix.size()))) {
      rings.push_back(info_of(file.substr(prefix.size())));
    }
  }
  std::sort(rings.begin(), rings.end(), [](const RingInfo& a, const RingInfo& b) { return a.name < b.name; });
  return rings;
}

bool remove_ring(const std::string& name) {
  if (shm_unlink(ring::shared_name(name).c_str()) == 0) {
    return true;
  }
  if (errno != ENOENT) {
    throw UserError("ring:" + name, std::generic_category().message(errno));
  }
  return false;
}

}  // namespace selfproj
