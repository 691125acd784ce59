#include "host/app/region_mover.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdint>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <utility>

#include "host/files/file_descriptor.h"
#include "host/files/notes.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

// Runs a command of the shell to its end.
void run_command(const std::string& command) {
  std::string shell = "/bin/sh";
  std::string option = "-c";
  std::string text = command;
  const std::array<char*, 4> words{shell.data(), option.data(), text.data(), nullptr};
  pid_t process = 0;
  if (const int error = posix_spawn(&process, shell.c_str(), nullptr, nullptr, words.data(), environ); error != 0) {
    throw UserError("--move-camera " + command, files::error_text(error));
  }
  int status = 0;
  while (waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) {
    throw UserError("--move-camera " + command, "has failed; where the camera's region lies is not known any more");
  }
}

}  // namespace

RegionMover::RegionMover(driver::Control& control, std::string command)
    : control_(control), command_(std::move(command)), thread_([this] { run(); }) {}

RegionMover::~RegionMover() { end(); }

void RegionMover::finish() {
  end();
  check();
}

void RegionMover::end() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
  }
  changed_.notify_one();
  if (thread_.joinable()) {
    thread_.join();
  }
}

void RegionMover::move(int row) {
  check();
  {
    const std::lock_guard lock(mutex_);
    wanted_ = row;
  }
  changed_.notify_one();
}

void RegionMover::check() {
  const std::lock_guard lock(mutex_);
  if (failure_) {
    std::rethrow_exception(failure_);
  }
}

void RegionMover::run() {
  std::unique_lock lock(mutex_);
  for (;;) {
    changed_.wait(lock, [this] { return ends_ || wanted_; });
    if (ends_) {
      return;
    }
    const int row = *std::exchange(wanted_, std::nullopt);
    lock.unlock();
    std::exception_ptr failure;
    try {
      carry_out(row);
    } catch (const UserError& error) {
      if (command_.empty()) {
        files::note(error.what());  // each packet says where its frame begins, whether the region has moved or not
      } else {
        failure = std::current_exception();
      }
    }
    lock.lock();
    if (failure) {
      failure_ = failure;
      return;
    }
  }
}

void RegionMover::carry_out(int row) {
  if (!command_.empty()) {
    control_.write("region.row", 0);
    run_command(command_ + " " + std::to_string(row));
  }
  control_.write("region.row", static_cast<std::uint32_t>(row + 1));
}

}  // namespace selfproj::app
