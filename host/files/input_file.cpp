#include "host/files/input_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstddef>
#include <string>

#include "host/files/file_descriptor.h"
#include "host/files/run_files.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace {

using std::chrono::steady_clock;

constexpr std::chrono::seconds kPatience{10};

std::string size_text(std::size_t bytes) {
  constexpr std::size_t kMega = std::size_t{1} << 20U;
  return std::to_string(bytes / kMega) + " MiB";
}

// Waits for bytes of a pipe or terminal; throws if they do not come.
void wait_for_bytes(const std::string& file, int descriptor, steady_clock::time_point end) {
  for (;;) {
    const auto left = std::chrono::nanoseconds(end - steady_clock::now()).count();
    if (left <= 0) {
      throw UserError(file, "brought nothing for " + std::to_string(kPatience.count()) + " seconds");
    }
    if (wait_readable(descriptor, left)) {
      return;
    }
  }
}

}  // namespace

std::string read_input(const std::string& file, std::size_t most_bytes) {
  // Without O_NONBLOCK, opening a pipe would wait for its writer.
  const FileDescriptor input(open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  struct stat status {};
  if (input.number() < 0 || fstat(input.number(), &status) != 0) {
    throw UserError(file, error_text(errno));
  }
  if (S_ISDIR(status.st_mode)) {
    throw UserError(file, "is a folder");
  }
  const bool regular = S_ISREG(status.st_mode);
  note_input(file);
  std::string bytes;
  if (regular) {
    bytes.reserve(std::min(static_cast<std::size_t>(status.st_size), most_bytes));
  }
  const auto end = steady_clock::now() + kPatience;
  constexpr std::size_t kBlock = std::size_t{1} << 16U;
  for (;;) {
    if (!regular) {
      wait_for_bytes(file, input.number(), end);
    }
    const std::size_t held = bytes.size();
    bytes.resize(held + std::min(kBlock, most_bytes - held + 1));
    const ssize_t count = read(input.number(), bytes.data() + held, bytes.size() - held);
    bytes.resize(held + static_cast<std::size_t>(std::max<ssize_t>(count, 0)));
    if (count == 0) {
      return bytes;
    }
    if (count < 0 && errno != EINTR && errno != EAGAIN) {
      throw UserError(file, error_text(errno));
    }
    if (bytes.size() > most_bytes) {
      throw UserError(file, "has more than " + size_text(most_bytes));
    }
  }
}

}  // namespace selfproj::files
