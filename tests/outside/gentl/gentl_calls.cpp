// Random calls of the GenTL producer in random order from several threads, with arguments that are right, slightly
// wrong, or null.
//
//     gentl_calls [--calls N] [--threads N] [--seed S]
//
// Every call must return an error of the standard, and a failed one must leave a text. What else may go wrong, the
// sanitizers notice: answers have exactly the size that the producer is told.
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <memory>
#include <mutex>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "host/files/results_file.h"
#include "tests/outside/gentl/producer.h"

namespace selfproj::test {
namespace {

enum class Kind : std::uint8_t { system, interface, device, port, stream, buffer, event };
constexpr int kKinds = 7;

// The handles that the threads have got, also those of what was closed since.
class Pool {
 public:
  void add(Kind kind, void* handle) {
    const std::lock_guard lock(mutex_);
    std::vector<void*>& all = handles_.at(static_cast<std::size_t>(kind));
    all.push_back(handle);
    if (all.size() > 6) {
      all.erase(all.begin());
    }
  }
  void* pick(Kind kind, std::uint64_t draw) {
    const std::lock_guard lock(mutex_);
    const std::vector<void*>& all = handles_.at(static_cast<std::size_t>(kind));
    return all.empty() ? nullptr : all[draw % 4 != 0 ? all.size() - 1 : draw / 4 % all.size()];
  }

 private:
  std::mutex mutex_;
  std::array<std::vector<void*>, kKinds> handles_;
};

class Caller {
 public:
  Caller(Pool& pool, std::uint64_t seed, const std::vector<std::string>& ids) : pool_(pool), random_(seed), ids_(ids) {
    for (std::size_t i = 0; i < 4; ++i) {
      memory_.push_back(std::make_unique<std::vector<std::uint8_t>>(std::size_t{300} << (4 * i)));
    }
  }

  void one() {
    static constexpr std::array kOften = {
        &Caller::questions, &Caller::buffer_questions, &Caller::ports,       &Caller::registers,
        &Caller::buffers,   &Caller::queues,           &Caller::acquisition, &Caller::events};
    if (between(0, 7) == 0) {
      open_something();
    } else if (between(0, 999) == 0) {
      close_something();
    } else {
      (this->*kOften.at(static_cast<std::size_t>(between(0, 7))))();
    }
  }

  [[nodiscard]] const std::map<GC_ERROR, long>& results() const { return results_; }

 private:
  int between(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool rarely() { return between(0, 15) == 0; }
  template <typename T>
  T* or_null(T* pointer) {
    return rarely() ? nullptr : pointer;
  }
  // A handle of this kind, rarely one of another kind or none.
  void* handle(Kind kind) {
    if (rarely()) {
      return rarely() ? &random_ : pool_.pick(static_cast<Kind>(between(0, kKinds - 1)), random_());
    }
    return pool_.pick(kind, random_());
  }
  // Room for an answer: an allocation of its own with exactly the bytes that the producer is told.
  struct Room {
    std::unique_ptr<std::uint8_t[]> bytes;
    std::size_t size = 0;
    INFO_DATATYPE type = 0;
  };
  Room room() {
    const auto size = static_cast<std::size_t>(rarely() ? between(0, 3) : rarely() ? 512 : 8 * between(1, 8));
    return {std::make_unique<std::uint8_t[]>(size), size};
  }
  void* bytes_of(Room& room) { return rarely() ? nullptr : room.bytes.get(); }
  const char* id() { return or_null(ids_[random_() % ids_.size()].c_str()); }

  void check(GC_ERROR result, const char* what) {
    ++results_[result];
    const bool known = result == GC_ERR_SUCCESS || (result <= GC_ERR_NOT_INITIALIZED && result >= GC_ERR_AMBIGUOUS);
    if (!known || (result != GC_ERR_SUCCESS && (last_failure().code != result || last_failure().text.empty()))) {
      std::fprintf(stderr, "gentl_calls: %s returned %d: %s\n", what, result, last_failure().text.c_str());
      std::exit(1);
    }
  }

  void open_something() {
    void* made = nullptr;
    switch (between(0, 6)) {
      case 0:
        check(GC(GCInitLib)(), "GCInitLib");
        return;
      case 1:
        return opened(GC(TLOpen)(or_null(&made)), Kind::system, made);
      case 2:
        return opened(GC(TLOpenInterface)(handle(Kind::system), rarely() ? id() : "selfproj", or_null(&made)),
                      Kind::interface, made);
      case 3:
        check(GC(IFUpdateDeviceList)(handle(Kind::interface), nullptr, 0), "IFUpdateDeviceList");
        return opened(GC(IFOpenDevice)(handle(Kind::interface), id(), between(1, 5), or_null(&made)), Kind::device,
                      made);
      case 4:
        return opened(GC(DevGetPort)(handle(Kind::device), or_null(&made)), Kind::port, made);
      case 5:
        return opened(GC(DevOpenDataStream)(handle(Kind::device), rarely() ? id() : "lines", or_null(&made)),
                      Kind::stream, made);
      default:
        return opened(GC(GCRegisterEvent)(handle(rarely() ? Kind::port : Kind::stream), between(0, 1), or_null(&made)),
                      Kind::event, made);
    }
  }
  // `made` is read after the call that makes it.
  void opened(GC_ERROR result, Kind kind, void* const& made) {
    check(result, "an open");
    if (result == GC_ERR_SUCCESS) {
      pool_.add(kind, made);
    }
  }
  void close_something() {
    switch (between(0, 19)) {
      case 0:
        return check(GC(GCCloseLib)(), "GCCloseLib");
      case 1:
        return check(GC(TLClose)(handle(Kind::system)), "TLClose");
      case 2:
        return check(GC(IFClose)(handle(Kind::interface)), "IFClose");
      case 3:
      case 4:
        return check(GC(DevClose)(handle(Kind::device)), "DevClose");
      case 5:
      case 6:
      case 7:
        return check(GC(DSClose)(handle(Kind::stream)), "DSClose");
      default:
        return check(GC(GCUnregisterEvent)(handle(Kind::stream), between(0, 1)), "GCUnregisterEvent");
    }
  }

  void questions() {
    Room to = room();
    const int command = between(-1, 14);
    void* const bytes = bytes_of(to);
    std::size_t* const size = or_null(&to.size);
    switch (between(0, 6)) {
      case 0:
        return check(GC(TLGetInfo)(handle(Kind::system), command, or_null(&to.type), bytes, size), "TLGetInfo");
      case 1:
        return check(GC(IFGetInfo)(handle(Kind::interface), command, or_null(&to.type), bytes, size), "IFGetInfo");
      case 2:
        return check(GC(IFGetDeviceInfo)(handle(Kind::interface), id(), command, or_null(&to.type), bytes, size),
                     "IFGetDeviceInfo");
      case 3:
        return check(GC(DevGetInfo)(handle(Kind::device), command, or_null(&to.type), bytes, size), "DevGetInfo");
      case 4:
        return check(GC(DSGetInfo)(handle(Kind::stream), command, or_null(&to.type), bytes, size), "DSGetInfo");
      case 5:
        return check(GC(IFGetDeviceID)(handle(Kind::interface), static_cast<std::uint32_t>(between(0, 4)),
                                       static_cast<char*>(bytes), size),
                     "IFGetDeviceID");
      default:
        return check(GC(GCGetInfo)(command, or_null(&to.type), bytes, size), "GCGetInfo");
    }
  }
  void buffer_questions() {
    Room to = room();
    void* const bytes = bytes_of(to);
    void* const stream = handle(Kind::stream);
    void* const buffer = handle(Kind::buffer);
    std::size_t* const size = or_null(&to.size);
    switch (between(0, 3)) {
      case 0: {
        std::array<SINGLE_CHUNK_DATA, 3> places{};
        std::size_t count = static_cast<std::size_t>(between(0, 3));
        return check(GC(DSGetBufferChunkData)(stream, buffer, or_null(places.data()), or_null(&count)), "chunks");
      }
      case 1:
        return check(GC(DSGetBufferPartInfo)(stream, buffer, static_cast<std::uint32_t>(between(0, 2)), between(-1, 13),
                                             or_null(&to.type), bytes, size),
                     "DSGetBufferPartInfo");
      case 2: {
        std::uint32_t parts = 0;
        return check(GC(DSGetNumBufferParts)(stream, buffer, or_null(&parts)), "DSGetNumBufferParts");
      }
      default:
        return check(GC(DSGetBufferInfo)(stream, buffer, between(-1, 31), or_null(&to.type), bytes, size),
                     "DSGetBufferInfo");
    }
  }

  void ports() {
    Room to = room();
    void* const port = handle(static_cast<Kind>(between(0, kKinds - 2)));
    void* const bytes = bytes_of(to);
    std::size_t* const size = or_null(&to.size);
    switch (between(0, 3)) {
      case 0:
        return check(GC(GCGetPortInfo)(port, between(-1, 13), or_null(&to.type), bytes, size), "GCGetPortInfo");
      case 1:
        return check(GC(GCGetPortURLInfo)(port, 0, between(-1, 11), or_null(&to.type), bytes, size),
                     "GCGetPortURLInfo");
      case 2:
        return check(GC(GCReadPort)(port, 0x100000 + random_() % 40000, bytes, size), "the XML");
      default:
        return check(
            GC(GCReadPort)(port, 0x1000 + 1024 * (random_() % 110) + (rarely() ? random_() % 1024 : 0), bytes, size),
            "GCReadPort");
    }
  }
  // Any register of a camera with any value that may mean something there.
  void registers() {
    static constexpr std::array<std::int64_t, 10> kValues{0, 1, 2, 3, 5, 8, -1, 1LL << 40, 0x012000BF, 0x026000C0};
    std::int64_t value = kValues.at(static_cast<std::size_t>(between(0, 9)));
    std::size_t size = sizeof value;
    const std::uint64_t address = 0x1000 + 1024 * (random_() % 60);
    if (rarely()) {
      PORT_REGISTER_STACK_ENTRY entry{address, or_null(&value), size};
      std::size_t count = 1;
      return check(GC(GCWritePortStacked)(handle(Kind::port), or_null(&entry), or_null(&count)), "GCWritePortStacked");
    }
    check(GC(GCWritePort)(handle(Kind::port), address, or_null(&value), or_null(&size)), "GCWritePort");
  }

  void buffers() {
    void* made = nullptr;
    void* const stream = handle(Kind::stream);
    std::size_t bytes = 0;
    std::size_t size = sizeof bytes;
    GC(DSGetInfo)(stream, STREAM_INFO_PAYLOAD_SIZE, nullptr, &bytes, &size);
    bytes = rarely() ? random_() % 1000 : std::min<std::size_t>(bytes, 1000000);
    switch (between(0, 3)) {
      case 0: {
        std::vector<std::uint8_t>& own = *memory_[random_() % memory_.size()];
        return opened(GC(DSAnnounceBuffer)(stream, or_null(own.data()), own.size(), this, or_null(&made)), Kind::buffer,
                      made);
      }
      case 1:
        return opened(GC(DSAllocAndAnnounceBuffer)(stream, bytes, this, or_null(&made)), Kind::buffer, made);
      case 2: {
        void* memory = nullptr;
        return check(GC(DSRevokeBuffer)(stream, handle(Kind::buffer), or_null(&memory), nullptr), "DSRevokeBuffer");
      }
      default:
        return check(GC(DSGetBufferID)(stream, static_cast<std::uint32_t>(between(0, 4)), or_null(&made)), "BufferID");
    }
  }
  void queues() {
    if (rarely()) {
      return check(GC(DSFlushQueue)(handle(Kind::stream), between(-1, 5)), "DSFlushQueue");
    }
    check(GC(DSQueueBuffer)(handle(Kind::stream), handle(Kind::buffer)), "DSQueueBuffer");
  }
  void acquisition() {
    if (between(0, 3) != 0) {
      const std::uint64_t count = rarely() ? static_cast<std::uint64_t>(between(0, 3)) : GENTL_INFINITE;
      return check(GC(DSStartAcquisition)(handle(Kind::stream), rarely() ? 1 : 0, count), "DSStartAcquisition");
    }
    if (between(0, 7) == 0) {
      check(GC(DSStopAcquisition)(handle(Kind::stream), between(0, rarely() ? 2 : 1)), "DSStopAcquisition");
    }
  }
  void events() {
    Room to = room();
    void* const event = handle(Kind::event);
    switch (between(0, 7)) {
      case 0:
        return check(GC(EventGetInfo)(event, between(-1, 5), or_null(&to.type), bytes_of(to), or_null(&to.size)),
                     "EventGetInfo");
      case 1:
        return check(rarely() ? GC(EventKill)(event) : GC(EventFlush)(event), "EventKill");
      case 2: {
        EVENT_NEW_BUFFER_DATA data{};
        return check(GC(EventGetDataInfo)(event, or_null(&data), sizeof data, between(-1, 3), or_null(&to.type),
                                          bytes_of(to), or_null(&to.size)),
                     "EventGetDataInfo");
      }
      default: {
        Room data{std::make_unique<std::uint8_t[]>(sizeof(EVENT_NEW_BUFFER_DATA)), sizeof(EVENT_NEW_BUFFER_DATA)};
        return check(GC(EventGetData)(event, bytes_of(data), or_null(&data.size), rarely() ? 1 : 0), "EventGetData");
      }
    }
  }

  Pool& pool_;
  std::mt19937_64 random_;
  const std::vector<std::string>& ids_;
  std::vector<std::unique_ptr<std::vector<std::uint8_t>>> memory_;
  std::map<GC_ERROR, long> results_;
};

std::uint64_t option(const std::vector<std::string>& arguments, const std::string& name, std::uint64_t otherwise) {
  const auto at = std::find(arguments.begin(), arguments.end(), name);
  return at != arguments.end() && at + 1 != arguments.end() ? std::strtoull((at + 1)->c_str(), nullptr, 10) : otherwise;
}

int run(const std::vector<std::string>& arguments) {
  const std::uint64_t calls = option(arguments, "--calls", 20000);
  const std::uint64_t threads = option(arguments, "--threads", 2);
  const std::uint64_t seed = option(arguments, "--seed", 1);
  const PacketFile file("gentl_calls_" + std::to_string(seed), 40);
  const std::vector<std::string> ids{file.uri(), file.uri(), file.uri(), "file:/no/such/line.slfp", "nonsense"};
  setenv("SELFPROJ_GENTL_DEVICES", (file.uri() + ";" + ids[3] + ";" + ids[4]).c_str(), 1);
  static_cast<void>(producer());
  Pool pool;
  std::vector<std::unique_ptr<Caller>> callers;
  std::vector<std::thread> running;
  for (std::uint64_t i = 0; i < threads; ++i) {
    callers.push_back(std::make_unique<Caller>(pool, seed + 1000 * i, ids));
    running.emplace_back([&caller = *callers.back(), count = calls / threads] {
      for (std::uint64_t call = 0; call < count; ++call) {
        caller.one();
      }
    });
  }
  std::map<GC_ERROR, long> results;
  for (std::uint64_t i = 0; i < threads; ++i) {
    running[i].join();
    for (const auto& [result, times] : callers[i]->results()) {
      results[result] += times;
    }
  }
  GC(GCCloseLib)();
  long refused = 0;
  std::printf("%llu rounds in %llu threads;", static_cast<unsigned long long>(calls),
              static_cast<unsigned long long>(threads));
  for (const auto& [result, times] : results) {
    refused += result != GC_ERR_SUCCESS ? times : 0;
    std::printf(" %d: %ld", result, times);
  }
  std::printf("\n");
  files::write_results(
      "gentl_calls", "Random calls of the GenTL producer in random order, under the sanitizers",
      {{"calls", calls}, {"threads", threads}, {"refused", refused}, {"faults", 0}});  // a fault ends it
  return results[GC_ERR_SUCCESS] > 0 && results[GC_ERR_INVALID_HANDLE] > 0 && results[GC_ERR_RESOURCE_IN_USE] > 0 ? 0
                                                                                                                  : 1;
}

}  // namespace
}  // namespace selfproj::test

int main(int count, char** values) { return selfproj::test::run(std::vector<std::string>(values + 1, values + count)); }
