// Owns a file descriptor and closes it.
#ifndef SELFPROJ_HOST_FILES_FILE_DESCRIPTOR_H
#define SELFPROJ_HOST_FILES_FILE_DESCRIPTOR_H

#include <poll.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <ctime>
#include <string>
#include <string_view>
#include <system_error>

namespace selfproj::files {

// The system's text for an error number.
inline std::string error_text(int error) { return std::generic_category().message(error); }

// close() returns false if closing fails; the destructor ignores that. A negative number means no file.
class FileDescriptor {
 public:
  explicit FileDescriptor(int number) : number_(number) {}
  FileDescriptor(const FileDescriptor&) = delete;
  FileDescriptor& operator=(const FileDescriptor&) = delete;
  ~FileDescriptor() { static_cast<void>(close()); }

  [[nodiscard]] int number() const { return number_; }

  // Closes the current descriptor and takes another one.
  void reset(int number) {
    static_cast<void>(close());
    number_ = number;
  }

  [[nodiscard]] bool close() {
    const int number = number_;
    number_ = -1;
    return number < 0 || ::close(number) == 0;
  }

 private:
  int number_;
};

// Writes the whole text. Returns false if it fails; errno then has the reason.
[[nodiscard]] inline bool write_all(int descriptor, std::string_view text) {
  while (!text.empty()) {
    const ssize_t count = ::write(descriptor, text.data(), text.size());
    if (count < 0 && errno != EINTR) {
      return false;
    }
    text.remove_prefix(count < 0 ? 0 : static_cast<std::size_t>(count));
  }
  return true;
}

// A duration as the system's calls take it.
inline timespec timespec_of(std::int64_t ns) {
  constexpr std::int64_t kSecond = 1'000'000'000;
  return {static_cast<std::time_t>(ns / kSecond), static_cast<long>(ns % kSecond)};
}

// Waits until there is something to read, no longer than this; a signal ends the wait early. Returns whether there is.
inline bool wait_readable(int descriptor, std::int64_t ns) {
  const timespec limit = timespec_of(std::max<std::int64_t>(ns, 0));
  pollfd watched{descriptor, POLLIN, 0};
  return ppoll(&watched, 1, &limit, nullptr) > 0;
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_FILE_DESCRIPTOR_H
