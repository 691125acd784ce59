// libFuzzer target: the packet reader on streams that the fuzzer builds, damages and cuts into pieces.
//
// The input is a small program. Each step appends a good packet, damages the stream, or adds bytes as they are. The
// stream then goes through two readers in different pieces. Whatever the stream is, the following must hold:
// * Both readers give the same packets: how the bytes arrive does not matter.
// * What is given is, byte by byte, a stretch of the stream, in order and without overlap, and parse_packet finds it
//   right.
// * Every byte is either given or counted as discarded.
// * All packets that were appended and not touched since are given, and so is the packet that ends every stream: it is
//   right whatever came before it.
//
// The target runs under the address and undefined-behaviour sanitizers, which notice other faults, among them reads
// beyond the last byte that came.
//
// The two readers and all other memory are used again in the next case, because allocating them anew took half the
// time. The packet at the end of every stream leaves a reader in its initial state, except for its counters, which are
// set to 0.
#include <sanitizer/asan_interface.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <span>
#include <vector>

#include "selfproj/driver/counters.h"
#include "selfproj/driver/packet_reader.h"
#include "selfproj/model/packet.h"

namespace selfproj::test {
namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kLargestStream = 4 * 1024;
constexpr std::size_t kGuard = 64;  // bytes behind those that came, which must not be read

void require(bool holds, const char* what) {
  if (!holds) {
    std::fprintf(stderr, "packet_reader_fuzz: %s\n", what);
    std::abort();
  }
}

// The fuzzer's bytes, one after another, followed by zeros.
class Input {
 public:
  explicit Input(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}
  [[nodiscard]] bool empty() const { return bytes_.empty(); }
  std::uint8_t byte() {
    const std::uint8_t first = bytes_.empty() ? std::uint8_t{0} : bytes_.front();
    bytes_ = bytes_.subspan(bytes_.empty() ? 0 : 1);
    return first;
  }
  std::size_t word() {
    const std::size_t low = byte();
    return low | std::size_t{byte()} << 8U;
  }
  std::span<const std::uint8_t> take(std::size_t most) {
    const auto taken = bytes_.first(std::min(most, bytes_.size()));
    bytes_ = bytes_.subspan(taken.size());
    return taken;
  }

 private:
  std::span<const std::uint8_t> bytes_;
};

struct Stretch {
  std::size_t begin;
  std::size_t end;
  bool operator==(const Stretch&) const = default;
};

// A stream, and the appended packets that nothing has touched since.
struct Stream {
  Bytes bytes;
  std::vector<Stretch> good;
  Bytes scratch;

  void clear() {
    bytes.clear();
    good.clear();
  }

  // Notes that the bytes from `begin` on have changed.
  void touched(std::size_t begin, std::size_t end) {
    std::erase_if(good, [&](const Stretch& packet) { return packet.begin < end && begin < packet.end; });
  }
};

// `shape` selects the packet; `lost` is a field of its header.
void append_good_packet(std::uint8_t shape, std::uint8_t lost, std::uint64_t sequence, Stream& stream) {
  model::PacketHeader header;
  header.kind = static_cast<std::uint8_t>(spec::kKindMoments + shape % 3);
  header.mode = static_cast<std::uint8_t>(shape / 3 % 3);
  const bool moments = header.kind == spec::kKindMoments;
  if (moments) {
    header.kind = model::kind_of_columns(shape % 2 == 1, static_cast<model::Mode>(header.mode));
  }
  header.columns = static_cast<std::uint16_t>(spec::kPixelsPerBeat * (1 + shape / 9));
  header.rows = 8;
  header.sequence = sequence / 2;
  header.time_stamp = 100 * (sequence / 2);
  header.lost = lost;
  header.first_line = static_cast<std::uint16_t>(moments ? 0 : 1 + shape % 8);
  header.lines = moments ? 0 : 1;
  const std::size_t size = moments                           ? model::columns_payload_bytes(header)
                           : header.kind == spec::kKindImage ? model::image_line_payload_bytes(header.columns)
                                                             : model::codes_line_payload_bytes(header.columns);
  const bool empty = shape % 16 == 15;  // a frame that broke
  const std::size_t begin = stream.bytes.size();
  stream.scratch.assign(empty ? 0 : size, shape);
  model::append_packet(header, stream.scratch, empty ? spec::kStatusIncomplete : 0, stream.bytes);
  stream.good.push_back({begin, stream.bytes.size()});
}

void build(Input& input, Stream& stream) {
  stream.clear();
  std::uint64_t sequence = 0;
  while (!input.empty() && stream.bytes.size() < kLargestStream) {
    const std::size_t size = stream.bytes.size();
    switch (const std::uint8_t step = input.byte(); step % 8) {
      case 0:
      case 1:
      case 2: {
        const std::uint8_t shape = input.byte();
        append_good_packet(shape, input.byte(), sequence++, stream);
        break;
      }
      case 3: {  // cut
        const std::size_t less = std::min(input.word() % 600, size);
        stream.touched(size - less, size);
        stream.bytes.resize(size - less);
        break;
      }
      case 4: {  // damaged bytes, counted from the end
        const std::size_t back = input.word();
        const std::uint8_t change = input.byte();
        if (back < size && change != 0) {
          stream.bytes[size - 1 - back] ^= change;
          stream.touched(size - 1 - back, size - back);
        }
        break;
      }
      case 5: {  // bytes as they are
        const auto raw = input.take(input.byte());
        stream.bytes.insert(stream.bytes.end(), raw.begin(), raw.end());
        break;
      }
      case 6: {  // a header field of the last packet changes, and its check word is made right again
        if (!stream.good.empty() && stream.good.back().end == size) {
          const Stretch last = stream.good.back();
          stream.bytes[last.begin + input.byte() % spec::kHeaderBytes] ^= input.byte();
          stream.touched(last.begin, last.end);
          // The packet must be judged by everything else.
          model::seal_packet(std::span(stream.bytes).subspan(last.begin));
        }
        break;
      }
      default:  // the beginning of a packet, once more
        if (!stream.good.empty()) {
          const Stretch last = stream.good.back();
          const std::size_t bytes = std::min(input.word() % 600, last.end - last.begin);
          stream.bytes.resize(size + bytes);
          std::copy_n(stream.bytes.begin() + static_cast<std::ptrdiff_t>(last.begin), bytes,
                      stream.bytes.begin() + static_cast<std::ptrdiff_t>(size));
          if (bytes == last.end - last.begin) {
            stream.good.push_back({size, size + bytes});
          }
        }
    }
  }
  // A good packet that cannot be mistaken for the end of another.
  stream.bytes.insert(stream.bytes.end(), spec::kTrailerBytes, 0);
  append_good_packet(0, 0, sequence, stream);
}

// A reader with its counters.
struct Reader {
  driver::Counters counters;
  driver::PacketStreamReader reader{counters, 1};
  std::vector<Stretch> given;  // where the packets were found in the last stream

  void read(const Bytes& stream, std::size_t largest, std::uint32_t random);
};

// Feeds the stream in pieces of 1..largest bytes.
void Reader::read(const Bytes& stream, std::size_t largest, std::uint32_t random) {
  counters = {};
  given.clear();
  reader.restart();
  driver::PacketTally tally(counters);
  model::PacketView packet;
  std::size_t at = 0;
  const auto drain = [&] {
    while (reader.next(packet)) {
      const std::size_t end = at - reader.held();
      require(end >= packet.size, "a packet of bytes that have not come");
      const std::size_t begin = end - packet.size;
      require(given.empty() || begin >= given.back().end, "a byte was given twice");
      const std::span<const std::uint8_t> bytes = packet.bytes();
      require(std::equal(bytes.begin(), bytes.end(), stream.begin() + static_cast<std::ptrdiff_t>(begin)),
              "not the bytes of the stream");
      model::PacketView again;
      require(model::parse_packet(bytes, again) == model::PacketError::none && again.header == packet.header,
              "not a good packet");
      given.push_back({begin, end});
      tally.accept(packet.header);
    }
  };
  while (at < stream.size()) {
    const auto room = reader.room();
    require(!room.empty(), "no room for more bytes, and no packet either");
    random = random * 1664525 + 1013904223;
    const std::size_t piece = std::min({std::size_t{1} + (random >> 8U) % largest, room.size(), stream.size() - at});
    std::copy_n(stream.begin() + static_cast<std::ptrdiff_t>(at), piece, room.begin());
    const auto not_there = room.subspan(piece).first(std::min(kGuard, room.size() - piece));
    ASAN_POISON_MEMORY_REGION(not_there.data(), not_there.size());
    reader.added(piece);
    at += piece;
    drain();
    ASAN_UNPOISON_MEMORY_REGION(not_there.data(), not_there.size());
  }
  reader.finish();
  drain();
  require(reader.held() == 0, "bytes are left");
}

void fuzz(std::span<const std::uint8_t> data) {
  static Stream stream;
  static Reader whole;
  static Reader pieces;
  Input input(data);
  const std::uint8_t seed = input.byte();
  const std::size_t wanted = 1 + input.word() % 2000;
  build(input, stream);
  // Single bytes only in short streams. Many pieces of a long one take long and find nothing else.
  const std::size_t largest = std::max(wanted, stream.bytes.size() / 64);

  whole.read(stream.bytes, SIZE_MAX, seed);
  pieces.read(stream.bytes, largest, seed);
  require(whole.given == pieces.given, "pieces change what is given");
  require(whole.counters == pieces.counters, "pieces change what is counted");

  std::size_t bytes = whole.counters.bytes_discarded;
  for (const Stretch& packet : whole.given) {
    bytes += packet.end - packet.begin;
  }
  require(bytes == stream.bytes.size(), "bytes are neither given nor discarded");
  require(!stream.good.empty() && stream.good.back().end == stream.bytes.size(),
          "the stream does not end as it should");
  for (const Stretch& packet : stream.good) {
    require(std::any_of(whole.given.begin(), whole.given.end(),
                        [&](const Stretch& given) {
                          const bool ends_in_magic = given.begin < packet.begin && packet.begin < given.end &&
                                                     given.end - packet.begin < sizeof spec::kMagic;
                          return given == packet || ends_in_magic;
                        }),
            "a good packet was not given");
  }
  require(whole.given.back() == stream.good.back(), "the last packet was not given");
}

}  // namespace
}  // namespace selfproj::test

// NOLINTNEXTLINE(readability-identifier-naming): libFuzzer's name
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  selfproj::test::fuzz({data, size});
  return 0;
}
