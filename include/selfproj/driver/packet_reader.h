// Finds packets in a stream of bytes that may be cut, shifted or damaged anywhere, and counts what is missing between
// them.
#ifndef SELFPROJ_DRIVER_PACKET_READER_H
#define SELFPROJ_DRIVER_PACKET_READER_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "selfproj/driver/counters.h"
#include "selfproj/model/packet.h"

namespace selfproj::driver {

// Takes bytes as they come and returns whole packets in place. After the start or a bad packet it discards everything
// up to the next whole packet, which may begin at any byte. It trusts no byte before parse_packet has found the whole
// packet right. A magic number inside a payload, or a damaged length, therefore costs only time.
//
//     std::span<std::uint8_t> room = reader.room();
//     reader.added(read(fd, room.data(), room.size()));
//     while (reader.next(packet)) { ... }
//
// Allocates only in the constructor.
class PacketStreamReader {
 public:
  static constexpr std::size_t kDefaultCapacity = std::size_t{1} << 20U;

  // Counts bad, other_spec, resynchronized and bytes_discarded in `counters`, which must outlive it. `capacity` is the
  // size of the buffer in bytes, and is raised to two of the largest packets. Unless `fill` is 0, any number of units
  // of so many zeros may follow a good packet. They are left out, and not counted; bytes must then come in whole units.
  explicit PacketStreamReader(Counters& counters, std::size_t capacity = kDefaultCapacity, std::size_t fill = 0);

  // The place for the next bytes of the stream. It is never empty after next() has returned all packets. Earlier
  // packets become invalid.
  [[nodiscard]] std::span<std::uint8_t> room();

  // The free bytes behind those held. Nothing is moved, so packets stay valid. May be empty.
  [[nodiscard]] std::span<std::uint8_t> room_in_place();

  // Call after writing this many bytes into the room.
  void added(std::size_t bytes) { end_ += bytes; }

  // Call when no more bytes will come: an incomplete packet is then a bad one.
  void finish() { finished_ = true; }

  // Call when the stream begins anew, possibly in the middle of a packet. Discards the bytes held, and counts them.
  void restart();

  // Returns the next whole packet in `packet`, which points into the buffer until room() or restart() is called.
  // Returns false if more bytes are needed.
  bool next(model::PacketView& packet);

  // Bytes held that belong to no packet returned so far.
  [[nodiscard]] std::size_t held() const { return end_ - begin_; }

  // The last `bytes` <= held() bytes added.
  [[nodiscard]] std::span<const std::uint8_t> newest(std::size_t bytes) const {
    return std::span(buffer_).subspan(end_ - bytes, bytes);
  }

 private:
  void discard(std::size_t bytes);
  void skip_fill();

  Counters& counters_;
  std::size_t fill_;
  std::vector<std::uint8_t> buffer_;
  std::size_t begin_ = 0;  // first byte not returned yet
  std::size_t end_ = 0;    // behind the last byte
  bool due_ = false;       // a packet should begin at begin_, because the one before it was good
  bool skipping_ = false;  // bytes were discarded since the last good packet
  bool finished_ = false;
};

// Follows sequence, time stamp and `lost` of every stream and kind. Losses before the first packet are not known and
// not counted. After a restart of the board all losses since its reset count.
class PacketTally {
 public:
  // Counts lost_board, missing, repeated and restarts in `counters`, which must outlive it.
  explicit PacketTally(Counters& counters) : counters_(counters) {}

  // Notes a good packet, in the order in which packets come. Returns false if it repeats the previous packet (same
  // frame, same line or an earlier one); it must not be given out then.
  bool accept(const model::PacketHeader& header);

  // The same for a packet that is given out if it returns true; counts it in delivered and flagged.
  bool deliver(const model::PacketView& packet);

  // Call when another writer takes over: its packets do not count as repetitions.
  void begin_anew();

 private:
  static constexpr std::size_t kStreams = 256;
  static constexpr std::size_t kKinds = 3;  // one for a frame, codes, images

  // The newest packet of a stream and kind.
  struct Newest {
    model::PacketHeader header = {};
    bool known = false;  // a packet has come
    bool reset = false;  // no packet since the board was reset
    bool anew = false;   // no packet of the new writer
  };

  Counters& counters_;
  std::array<std::array<Newest, kKinds>, kStreams> newest_{};
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_DRIVER_PACKET_READER_H
