#include "host/driver/ring_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <string>
#include <system_error>

#include "host/io/user_error.h"

namespace selfproj::ring {
namespace {

std::string reason(int error) { return std::generic_category().message(error); }

struct flock range(short type, long which) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = which;
  lock.l_len = 1;
  return lock;
}

bool take_lock(int descriptor, long which) {
  struct flock lock = range(F_WRLCK, which);
  return fcntl(descriptor, F_OFD_SETLK, &lock) == 0;
}

}  // namespace

bool is_name(const std::string& name) {
  constexpr std::size_t kLongest = 64;
  return !name.empty() && name.size() <= kLongest && std::all_of(name.begin(), name.end(), [](char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_' || c == '-' || c == '.';
  });
}

std::string shared_name(const std::string& name) {
  if (!is_name(name)) {
    throw UserError("ring:" + name, "a ring's name has 1 to 64 letters, digits, '_', '-' or '.'");
  }
  return "/selfproj-ring-" + name;
}

Memory::Found Memory::map() {
  struct stat status {};
  if (fstat(descriptor_, &status) != 0) {
    return Found::no_access;
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  if (size < sizeof(Header)) {
    return Found::unready;
  }
  void* memory = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (memory == MAP_FAILED) {
    return Found::no_access;
  }
  header_ = static_cast<Header*>(memory);
  bytes_ = size;
  if (header_->magic.load(std::memory_order_acquire) != kMagic) {
    return Found::unready;
  }
  slots_ = header_->slots;
  const bool ours = header_->version == kVersion && header_->spec_hash == spec::kHash &&
                    header_->slot_bytes == kSlotBytes && std::has_single_bit(slots_) && slots_ <= kMaxSlots &&
                    size == ring_bytes(slots_);
  return ours ? Found::ring : Found::other;
}

Memory::Found Memory::attach(const char* shared) {
  detach();
  descriptor_ = shm_open(shared, O_RDWR | O_CLOEXEC, 0);
  if (descriptor_ < 0) {
    return errno == ENOENT ? Found::none : Found::no_access;
  }
  const Found found = map();
  if (found != Found::ring) {
    const int error = errno;
    detach();
    errno = error;
  }
  return found;
}

void Memory::create(const std::string& name, std::uint32_t slots) {
  const std::string uri = "ring:" + name;
  const std::string shared = shared_name(name);
  for (;;) {
    detach();
    descriptor_ = shm_open(shared.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0660);  // less the user's umask
    if (descriptor_ < 0) {
      throw UserError(uri, reason(errno));
    }
    if (!take_lock(descriptor_, kWriterLock)) {
      detach();
      throw UserError(uri, "another board is writing into it");
    }
    if (removed()) {
      continue;  // by another process, since it was opened
    }
    struct stat status {};
    if (fstat(descriptor_, &status) == 0 && status.st_size > 0) {
      if (map() == Found::ring && slots_ == slots) {
        return;
      }
      shm_unlink(shared.c_str());
      continue;
    }
    break;
  }
  // Its pages are taken now: with a full /dev/shm, writing to them later would end the program.
  const std::size_t bytes = ring_bytes(slots);
  if (const int error = posix_fallocate(descriptor_, 0, static_cast<off_t>(bytes)); error != 0) {
    shm_unlink(shared.c_str());
    detach();
    throw UserError(uri, reason(error) + ", " + std::to_string(bytes >> 20U) + " MiB of shared memory are needed");
  }
  static_cast<void>(map());  // all zeros but for what follows
  if (header_ == nullptr) {
    throw UserError(uri, reason(errno));
  }
  slots_ = slots;
  header_->version = kVersion;
  header_->spec_hash = spec::kHash;
  header_->slots = slots;
  header_->slot_bytes = static_cast<std::uint32_t>(kSlotBytes);
  header_->magic.store(kMagic, std::memory_order_release);
}

void Memory::detach() {
  if (header_ != nullptr) {
    munmap(header_, bytes_);
    header_ = nullptr;
  }
  if (descriptor_ >= 0) {
    close(descriptor_);
    descriptor_ = -1;
  }
}

Slot& Memory::slot(std::uint64_t count) const {
  auto* slots = reinterpret_cast<std::uint8_t*>(header_) + sizeof(Header);
  return *reinterpret_cast<Slot*>(slots + (count & (slots_ - 1)) * kSlotBytes);
}

std::uint8_t* Memory::packet(std::uint64_t count) const {
  return reinterpret_cast<std::uint8_t*>(&slot(count)) + sizeof(Slot);
}

bool Memory::lock(long which) const { return take_lock(descriptor_, which); }

bool Memory::locked(long which) const {
  struct flock lock = range(F_WRLCK, which);
  return fcntl(descriptor_, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool Memory::removed() const {
  struct stat status {};
  return fstat(descriptor_, &status) == 0 && status.st_nlink == 0;
}

}  // namespace selfproj::ring
