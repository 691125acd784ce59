#include "host/driver/ring_memory.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/driver/bus_guard.h"
#include "host/files/file_descriptor.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver::ring {
namespace {

struct flock range(short type, long which) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  lock.l_start = which;
  lock.l_len = 1;
  return lock;
}

bool try_lock(int descriptor, long which) {
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

// Reads the header before anything is mapped, because the file may have any content and size.
Memory::Found Memory::map(Access access) {
  struct stat status {};
  if (fstat(descriptor_, &status) != 0) {
    return Found::no_access;
  }
  const auto size = static_cast<std::size_t>(status.st_size);
  std::array<std::byte, offsetof(Header, written)> bytes{};
  static_assert(bytes.size() >= offsetof(Header, slot_bytes) + sizeof(Header::slot_bytes));
  if (size < sizeof(Header) ||
      pread(descriptor_, bytes.data(), bytes.size(), 0) != static_cast<ssize_t>(bytes.size())) {
    return locked(kWriterLock) ? Found::being_made : Found::unready;
  }
  const auto word = [&](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    return value;
  };
  std::uint64_t magic = 0;
  std::memcpy(&magic, bytes.data() + offsetof(Header, magic), sizeof magic);
  if (magic != kMagic) {
    return locked(kWriterLock) ? Found::being_made : Found::unready;
  }
  slots_ = word(offsetof(Header, slots));
  if (word(offsetof(Header, version)) != kVersion || word(offsetof(Header, spec_hash)) != spec::kHash ||
      word(offsetof(Header, slot_bytes)) != kSlotBytes || !std::has_single_bit(slots_) || slots_ > kMaxSlots ||
      size != ring_bytes(slots_)) {
    return Found::other;
  }
  const int rights = access == Access::use ? PROT_READ | PROT_WRITE : PROT_READ;
  void* memory = mmap(nullptr, size, rights, MAP_SHARED, descriptor_, 0);
  if (memory == MAP_FAILED) {
    return Found::no_access;
  }
  header_ = static_cast<Header*>(memory);
  bytes_ = size;
  guard_mapping(memory, size);
  // Data written before the magic number is visible after it.
  return header_->magic.load(std::memory_order_acquire) == kMagic ? Found::ring : Found::unready;
}

Memory::Found Memory::attach(const char* shared, Access access) {
  detach();
  descriptor_ = shm_open(shared, (access == Access::use ? O_RDWR : O_RDONLY) | O_CLOEXEC, 0);
  if (descriptor_ < 0) {
    return errno == ENOENT ? Found::none : Found::no_access;
  }
  const Found found = map(access);
  if (found != Found::ring) {
    const int error = errno;
    detach();
    errno = error;
  }
  return found;
}

// Opens the shared memory `shared` and takes the writer's lock: nobody else then writes the file behind descriptor_,
// and the name still belongs to it. Returns whether it holds a ring of `slots` slots, which is then mapped; otherwise
// the file is empty.
bool Memory::open_for_writer(const std::string& uri, const std::string& shared, std::uint32_t slots, Memory& replaced) {
  constexpr int kTries = 1000;
  for (int i = 0; i < kTries; ++i) {
    detach();
    descriptor_ = shm_open(shared.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0660);  // minus the user's umask
    if (descriptor_ < 0) {
      throw UserError(uri, files::error_text(errno));
    }
    if (!try_lock(descriptor_, kWriterLock)) {
      throw UserError(uri, "another board is writing into it");
    }
    if (removed()) {
      continue;  // another process did this since it was opened
    }
    struct stat status {};
    if (fstat(descriptor_, &status) != 0) {
      throw UserError(uri, files::error_text(errno));
    }
    if (status.st_size == 0) {
      return false;
    }
    const Found found = map();
    if (found == Found::ring && slots_ == slots) {
      return true;
    }
    if (found == Found::no_access) {
      throw UserError(uri, "is there and cannot be used: " + files::error_text(errno));
    }
    if (shm_unlink(shared.c_str()) != 0 && errno != ENOENT) {
      throw UserError(uri, "is a ring of another size or kind, which cannot be replaced: " + files::error_text(errno));
    }
    unmap();
    replaced.swap(*this);
  }
  throw UserError(uri, "is removed by another process again and again");
}

void Memory::create(const std::string& name, std::uint32_t slots) {
  const std::string uri = "ring:" + name;
  const std::string shared = shared_name(name);
  Memory replaced;  // keeps its lock to the end
  Memory made;
  if (!made.open_for_writer(uri, shared, slots, replaced)) {
    made.fill(uri, shared, slots);
  }
  swap(made);
}

// Makes an empty ring in the empty file.
void Memory::fill(const std::string& uri, const std::string& shared, std::uint32_t slots) {
  // Allocates all pages now. With a full /dev/shm, writing to them later would lose packets.
  const std::size_t bytes = ring_bytes(slots);
  const int error = posix_fallocate(descriptor_, 0, static_cast<off_t>(bytes));
  if (error != 0) {
    shm_unlink(shared.c_str());
    throw UserError(
        uri, files::error_text(error) + ", " + std::to_string(bytes >> 20U) + " MiB of shared memory are needed");
  }
  void* memory = mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, descriptor_, 0);
  if (memory == MAP_FAILED) {
    const int why = errno;
    shm_unlink(shared.c_str());
    throw UserError(uri,
                    files::error_text(why) + ", " + std::to_string(bytes >> 20U) + " MiB of address space are needed");
  }
  header_ = static_cast<Header*>(memory);  // all zeros except for the following fields
  bytes_ = bytes;
  guard_mapping(memory, bytes);
  slots_ = slots;
  header_->version = kVersion;
  header_->spec_hash = spec::kHash;
  header_->slots = slots;
  header_->slot_bytes = static_cast<std::uint32_t>(kSlotBytes);
  header_->magic.store(kMagic, std::memory_order_release);
}

void Memory::unmap() {
  if (header_ != nullptr) {
    unguard_mapping(header_);
    munmap(header_, bytes_);
    header_ = nullptr;
  }
}

void Memory::swap(Memory& other) noexcept {
  std::swap(descriptor_, other.descriptor_);
  std::swap(header_, other.header_);
  std::swap(bytes_, other.bytes_);
  std::swap(slots_, other.slots_);
}

void Memory::detach() {
  unmap();
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

bool Memory::lock(long which) const { return try_lock(descriptor_, which); }

bool Memory::locked(long which) const {
  struct flock lock = range(F_WRLCK, which);
  return fcntl(descriptor_, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool Memory::removed() const {
  struct stat status {};
  return fstat(descriptor_, &status) == 0 && status.st_nlink == 0;
}

bool Memory::shortened() const {
  struct stat status {};
  return fstat(descriptor_, &status) == 0 && static_cast<std::size_t>(status.st_size) < bytes_;
}

}  // namespace selfproj::driver::ring

namespace selfproj::driver {
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
      info.problem = files::error_text(errno);
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
    throw UserError("ring:" + name, files::error_text(errno));
  }
  return false;
}

}  // namespace selfproj::driver
