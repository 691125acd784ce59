// The board in software: the packets that the FPGA board makes of the same frames, bit for bit, by the fast code of the
// host.
#ifndef SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H
#define SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/structured_light/fast_decoder.h"
#include "model/board.h"
#include "model/column_runs.h"
#include "model/packet.h"

namespace selfproj {

// Equal to BoardModel for frames that are whole, and for frames of which nothing came. The field `lost` is always 0,
// because nothing is lost between this board and its reader. Allocates everything in the constructor.
class SoftwareBoard {
 public:
  // Of the settings it ignores run, hold and timeout. Throws std::invalid_argument if a board of the largest size could
  // not have them.
  explicit SoftwareBoard(const BoardSettings& settings);

  // Processes the frame with this number: makes its packets; those of the frame before are gone. `complete` false: its
  // image did not come whole. As on the board the moments are then an empty packet with the status `incomplete`, and
  // the decoder waits for plane 0. Throws std::invalid_argument if the image has not the size of the settings.
  void process(const ImageView& image, bool complete, std::uint64_t sequence, const BoardInputs& inputs);

  // Gives the frame's packets one after another: the moments, then the lines of the image, then those of the codes.
  // Returns false if there are no more. A packet is valid until the next call of process().
  bool next(PacketView& packet);

  [[nodiscard]] const BoardSettings& settings() const { return settings_; }

 private:
  // A packet in bytes_.
  struct Place {
    PacketHeader header;
    std::size_t begin = 0;
    std::size_t size = 0;
    std::uint32_t status = 0;
  };

  void send(PacketHeader header, std::size_t payload_bytes, std::uint32_t status);
  void send_moments(const ImageView& image, const PacketHeader& header);
  void send_image(const ImageView& image, PacketHeader header);
  void send_codes(PacketHeader header);
  bool decode(const ImageView& image, bool complete, int pattern);

  BoardSettings settings_;
  Measure measure_;
  PacketHeader header_;  // what is the same in every packet
  Runs runs_;
  std::optional<FastGrayDecoder> decoder_;
  std::optional<FastMedian> median_;
  std::vector<std::uint8_t> positive_;  // kept until its negative comes
  std::vector<std::uint16_t> codes_;
  std::vector<std::uint8_t> payload_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Place> places_;
  std::size_t given_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H
