// Random calls of the C interface in random order, with arguments that are right, slightly wrong, or null.
//
//     c_interface_calls [--calls N] [--seed S]
//
// Every call must return one of the results that the header names, and a failed one must leave a text. What else may go
// wrong, the sanitizers notice: buffers have exactly the size that the header asks for.
#include <algorithm>
#include <array>
#include <climits>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <map>
#include <memory>
#include <random>
#include <string>
#include <vector>

#include "host/files/results_file.h"
#include "selfproj.h"

namespace {

using Bytes = std::vector<std::uint8_t>;
using Words = std::vector<std::uint32_t>;

class Calls {
 public:
  explicit Calls(std::uint64_t seed)
      : random_(seed), file_(std::filesystem::temp_directory_path() / ("c_interface_calls_" + std::to_string(seed))) {
    write_file();
  }
  Calls(const Calls&) = delete;
  Calls& operator=(const Calls&) = delete;
  ~Calls() {
    selfproj_gray_destroy(gray_);
    selfproj_device_close(device_);
    selfproj_profiler_destroy(profiler_);
    std::filesystem::remove(file_);
  }

  void one() {
    static constexpr std::array kKinds = {&Calls::moments,       &Calls::gray,   &Calls::gray_handle, &Calls::median,
                                          &Calls::match,         &Calls::pack,   &Calls::unpack,      &Calls::build,
                                          &Calls::whole,         &Calls::parse,  &Calls::device,      &Calls::next,
                                          &Calls::device_others, &Calls::profile};
    (this->*kKinds[static_cast<std::size_t>(between(0, static_cast<int>(kKinds.size()) - 1))])();
  }

  [[nodiscard]] const std::map<std::int32_t, long>& results() const { return results_; }

 private:
  int between(int low, int high) { return std::uniform_int_distribution<int>(low, high)(random_); }
  bool rarely() { return between(0, 15) == 0; }
  // Mostly a value of the range, sometimes one at or beyond its ends.
  int value(int low, int high) {
    const std::array odd = {low - 1, high + 1, 0, -1, INT_MAX, INT_MIN};
    return rarely() ? odd[static_cast<std::size_t>(between(0, 5))] : between(low, high);
  }
  template <typename T>
  T* or_null(T* pointer) {
    return rarely() ? nullptr : pointer;
  }
  template <typename Struct>
  Struct sized() {
    Struct made{};
    made.size = rarely() ? static_cast<std::uint32_t>(between(0, static_cast<int>(sizeof made))) : sizeof made;
    return made;
  }
  Bytes bytes(std::size_t count) {
    Bytes made(count);
    std::generate(made.begin(), made.end(), [this] { return static_cast<std::uint8_t>(random_()); });
    return made;
  }

  void check(std::int32_t result, const char* what) {
    ++results_[result];
    const bool known = result >= SELFPROJ_INTERNAL && result <= SELFPROJ_END;
    if (!known || result == SELFPROJ_INTERNAL || (result < 0 && *selfproj_last_error() == '\0')) {
      std::fprintf(stderr, "c_interface_calls: %s returned %d: %s\n", what, result, selfproj_last_error());
      std::exit(1);
    }
  }

  // An image whose fields may be wrong, but whose pixels are there if they are right.
  selfproj_image image(int rows, int columns) {
    const int r = rarely() ? value(1, 40) : rows;
    const int c = rarely() ? value(1, 40) : columns;
    const bool possible = r >= 1 && r <= 40 && c >= 1 && c <= 40;
    pixels_ = bytes(possible ? static_cast<std::size_t>(r) * static_cast<std::size_t>(c) : 1);
    return {or_null(pixels_.data()), r, c, !possible ? 0 : rarely() ? c - 1 : c};
  }
  selfproj_measure measure() {
    auto made = sized<selfproj_measure>();
    made.mode = value(0, 2);
    made.threshold = value(0, 255);
    made.select = value(0, 1);
    made.gap = value(0, 3);
    made.first_row = value(0, 10);
    made.last_row = value(0, 2047);
    return made;
  }
  selfproj_header header() {
    auto made = sized<selfproj_header>();
    made.kind = static_cast<std::uint32_t>(value(1, 3));
    made.columns = static_cast<std::uint32_t>(value(0, 64));
    made.rows = static_cast<std::uint32_t>(value(1, 64));
    made.mode = static_cast<std::uint32_t>(value(0, 2));
    made.sequence = random_();
    return made;
  }

  void moments() {
    const selfproj_image from = image(between(1, 40), between(1, 40));
    const selfproj_measure how = measure();
    const auto count = static_cast<std::size_t>(std::clamp(from.columns, 1, 40));
    Words m0(count);
    Words m1(count);
    Words n(count);
    Bytes runs(count);
    Bytes second(count);
    check(selfproj_moments(or_null(&from), or_null(&how), or_null(m0.data()), or_null(m1.data()), or_null(n.data()),
                           or_null(runs.data()), or_null(second.data())),
          "moments");
  }

  void gray() {
    if (gray_ != nullptr && !rarely()) {
      const selfproj_image from = image(gray_rows_, gray_columns_);
      std::vector<std::uint16_t> codes(static_cast<std::size_t>(gray_rows_ * gray_columns_));
      std::int32_t due = 0;
      check(selfproj_gray_take(or_null(gray_), or_null(&from), rarely() ? value(0, 24) : gray_next_, value(0, 1),
                               or_null(codes.data()), or_null(&due)),
            "gray_take");
      gray_next_ = (gray_next_ + 1) % (2 * gray_bits_);
      return;
    }
    selfproj_gray_destroy(gray_);
    gray_ = nullptr;
    const int rows = value(1, 20);
    const int columns = value(1, 20);
    const int bits = value(1, 12);
    const std::int32_t result = selfproj_gray_create(rows, columns, bits, value(0, 255), or_null(&gray_));
    check(result, "gray_create");
    if (result == SELFPROJ_OK) {
      gray_rows_ = rows;
      gray_columns_ = columns;
      gray_bits_ = bits;
      gray_next_ = 0;
    }
  }
  void gray_handle() { check(selfproj_gray_restart(or_null(gray_)), "gray_restart"); }

  void median() {
    const int rows = value(1, 20);
    const int columns = value(1, 20);
    const bool possible = rows >= 1 && rows <= 21 && columns >= 1 && columns <= 21;
    const std::size_t count = possible ? static_cast<std::size_t>(rows * columns) : 1;
    std::vector<std::uint16_t> codes(count);
    std::generate(codes.begin(), codes.end(), [this] { return static_cast<std::uint16_t>(random_()); });
    std::vector<std::uint16_t> out(count);
    const bool refused = rows < 1 || columns < 1 || rows > 32768 || columns > 32768;
    if (possible || refused) {
      check(selfproj_median3x3(or_null(codes.data()), rows, columns, or_null(out.data())), "median3x3");
    }
  }

  void match() {
    const auto count = static_cast<std::size_t>(between(0, 50));
    const int bits = value(1, 8);
    std::vector<std::uint16_t> codes(count + 1);
    std::generate(codes.begin(), codes.end(), [this] { return static_cast<std::uint16_t>(random_()); });
    const std::vector<std::uint16_t> table((count << static_cast<unsigned>(std::clamp(bits, 0, 8))) + 1);
    std::vector<std::uint16_t> lines(count + 1);
    check(selfproj_match(or_null(codes.data()), count, bits, or_null(table.data()), or_null(lines.data())), "match");
  }

  void pack() {
    const int mode = value(0, 2);
    const int columns = value(0, 64);
    std::size_t size = 0;
    const std::int32_t result =
        selfproj_payload_bytes(static_cast<std::uint32_t>(value(1, 3)), mode, columns, or_null(&size));
    check(result, "payload_bytes");
    const auto count = static_cast<std::size_t>(std::clamp(columns, 0, 65));
    const Words values(count + 1, 3);
    Bytes payload(size + 1);
    const Bytes others(count + 1, 2);
    check(selfproj_pack_moments(value(0, 1), mode, columns, or_null(values.data()), values.data(), values.data(),
                                or_null(others.data()), others.data(), or_null(payload.data()), size),
          "pack_moments");
  }
  void unpack() {
    const int mode = value(0, 2);
    const int columns = value(0, 64);
    const Bytes payload = bytes(static_cast<std::size_t>(between(1, 600)));
    const auto count = static_cast<std::size_t>(std::clamp(columns, 0, 65));
    Words m0(count + 1);
    Words m1(count + 1);
    Words n(count + 1);
    Bytes runs(count + 1);
    Bytes second(count + 1);
    check(selfproj_unpack_moments(value(0, 1), mode, columns, or_null(payload.data()), payload.size(),
                                  or_null(m0.data()), m1.data(), n.data(), or_null(runs.data()), second.data()),
          "unpack_moments");
    std::vector<std::uint16_t> codes(count + 1);
    check(selfproj_unpack_compact(value(0, 1), columns, or_null(payload.data()), payload.size(), or_null(m0.data()),
                                  or_null(m1.data()), or_null(n.data()), or_null(runs.data()), or_null(second.data())),
          "unpack_compact");
    check(selfproj_unpack_codes(columns, or_null(payload.data()), payload.size(), or_null(codes.data())),
          "unpack_codes");
  }

  void build() {
    const selfproj_header how = header();
    const Bytes payload = bytes(static_cast<std::size_t>(rarely() ? between(0, 100) : 16 * between(1, 20)));
    Bytes out(static_cast<std::size_t>(between(80, 500)));
    std::size_t written = 0;
    const std::int32_t result = selfproj_build_packet(or_null(&how), or_null(payload.data()), payload.size(),
                                                      static_cast<std::uint32_t>(random_()), or_null(out.data()),
                                                      out.size(), or_null(&written));
    check(result, "build_packet");
    if (result == SELFPROJ_OK) {
      out.resize(written);
      packet_ = out;
    }
  }
  void whole() {
    const selfproj_image from = image(between(1, 40), 4 * between(1, 10));
    const selfproj_measure how = measure();
    const selfproj_header fields = header();
    Bytes out(static_cast<std::size_t>(between(80, 500)));
    std::size_t written = 0;
    const std::int32_t result = selfproj_moments_packet(or_null(&from), or_null(&how), or_null(&fields),
                                                        or_null(out.data()), out.size(), or_null(&written));
    check(result, "moments_packet");
    if (result == SELFPROJ_OK) {
      out.resize(written);
      packet_ = out;
    }
  }

  void parse() {
    Bytes damaged = packet_;
    if (rarely() && !damaged.empty()) {
      damaged[random_() % damaged.size()] ^= static_cast<std::uint8_t>(random_());
    }
    if (rarely()) {
      damaged.resize(random_() % (damaged.size() + 1));
    }
    damaged.shrink_to_fit();
    auto found = sized<selfproj_packet>();
    const std::int32_t result = selfproj_parse_packet(or_null(damaged.data()), damaged.size(), or_null(&found));
    check(result, "parse_packet");
    if (result == SELFPROJ_OK && found.byte_count > damaged.size()) {
      std::fprintf(stderr, "c_interface_calls: a packet longer than its bytes\n");
      std::exit(1);
    }
  }

  void write_file() {
    std::ofstream out(file_, std::ios::binary);
    for (int i = 0; i < 20; ++i) {
      const Bytes from = bytes(96 * 512);
      const selfproj_image view{from.data(), 96, 512, 512};
      const selfproj_measure how{sizeof how, i % 3, 200, 0, 0, 0, 0};
      selfproj_header fields{};
      fields.size = sizeof fields;
      fields.sequence = static_cast<std::uint64_t>(i);
      fields.time_stamp = fields.sequence * 15120;
      Bytes made(5000);
      std::size_t written = 0;
      check(selfproj_moments_packet(&view, &how, &fields, made.data(), made.size(), &written), "moments_packet");
      out.write(reinterpret_cast<const char*>(made.data()), static_cast<std::streamsize>(written));
      if (i % 5 == 4) {
        out.write("garbage", 7);
      }
    }
  }

  void device() {
    if (device_ != nullptr && !rarely()) {
      return;
    }
    selfproj_device_close(device_);
    device_ = nullptr;
    held_ = {};
    const std::array<std::string, 4> uris = {"file:" + file_.string(), "file:/no/such/file", "ring:", "nonsense"};
    auto options = sized<selfproj_device_options>();
    options.wait = value(0, 2);
    options.wait_for_board = between(0, 1);
    options.discard_backlog = between(0, 1);
    check(
        selfproj_device_open(or_null(uris[rarely() ? random_() % 4 : 0].c_str()), or_null(&options), or_null(&device_)),
        "device_open");
  }
  void next() {
    auto found = sized<selfproj_packet>();
    const std::int32_t result = selfproj_device_next(or_null(device_), rarely() ? value(-3, 3) : 1000, or_null(&found));
    check(result, "device_next");
    if (result == SELFPROJ_OK) {
      held_ = found;
    } else {
      held_ = {};  // next() may have freed its place
    }
  }
  void device_others() {
    auto counters = sized<selfproj_counters>();
    check(selfproj_device_counters(or_null(device_), or_null(&counters)), "device_counters");
    if (rarely()) {
      held_ = {};
      check(selfproj_device_release(or_null(device_)), "device_release");
    }
  }

  void profile() {
    if (profiler_ == nullptr || between(0, 2000) == 0) {
      selfproj_profiler_destroy(profiler_);
      profiler_ = nullptr;
      const std::array<const char*, 4> rigs = {"light-section", "scanner", "no-such-rig", nullptr};
      check(selfproj_profiler_create(rigs[rarely() ? random_() % 4 : 0], rarely() ? "/no/such/reference" : nullptr,
                                     or_null(&profiler_)),
            "profiler_create");
      return;
    }
    std::int32_t rows = 0;
    std::int32_t columns = 0;
    check(selfproj_profiler_size(or_null(profiler_), or_null(&rows), or_null(&columns)), "profiler_size");
    std::vector<float> z(512);
    Bytes validity(512);
    auto out = sized<selfproj_profile>();
    out.columns = static_cast<std::uint32_t>(rarely() ? value(0, 1000) : 512);
    out.z = or_null(z.data());
    out.validity = or_null(validity.data());
    if (between(0, 1) == 0) {
      check(selfproj_profile_of_packet(or_null(profiler_), or_null(&held_), or_null(&out)), "profile_of_packet");
    } else {
      const Words values(512, static_cast<std::uint32_t>(between(0, INT_MAX)));
      check(selfproj_profile_of_moments(or_null(profiler_), or_null(values.data()), values.data(), values.data(),
                                        or_null(&out)),
            "profile_of_moments");
    }
  }

  std::mt19937_64 random_;
  std::filesystem::path file_;
  Bytes pixels_, packet_;
  selfproj_gray* gray_ = nullptr;
  int gray_rows_ = 0, gray_columns_ = 0, gray_bits_ = 1, gray_next_ = 0;
  selfproj_device* device_ = nullptr;
  selfproj_packet held_{};
  selfproj_profiler* profiler_ = nullptr;
  std::map<std::int32_t, long> results_;
};

// The value of an option, or `otherwise`.
std::uint64_t option(const std::vector<std::string>& arguments, const std::string& name, std::uint64_t otherwise) {
  const auto at = std::find(arguments.begin(), arguments.end(), name);
  return at != arguments.end() && at + 1 != arguments.end() ? std::strtoull((at + 1)->c_str(), nullptr, 10) : otherwise;
}

}  // namespace

int main(int count, char** values) {
  const std::vector<std::string> arguments(values + 1, values + count);
  const std::uint64_t calls = option(arguments, "--calls", 5000);
  Calls run(option(arguments, "--seed", 1));
  for (std::uint64_t i = 0; i < calls; ++i) {
    run.one();
  }
  std::printf("%llu rounds;", static_cast<unsigned long long>(calls));
  for (const auto& [result, times] : run.results()) {
    std::printf(" %d: %ld", result, times);
  }
  std::printf("\n");
  long refused = 0;
  for (const std::int32_t result : {SELFPROJ_BAD_ARGUMENT, SELFPROJ_BAD_INPUT}) {
    refused += run.results().count(result) > 0 ? run.results().at(result) : 0;
  }
  selfproj::files::write_results("c_interface_calls",
                                 "Random calls of the C interface in random order, under the sanitizers",
                                 {{"calls", calls}, {"refused", refused}, {"faults", 0}});  // a fault ends the process
  return run.results().count(SELFPROJ_OK) > 0 && run.results().count(SELFPROJ_BAD_ARGUMENT) > 0 ? 0 : 1;
}
