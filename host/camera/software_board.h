// The board in software: the packets that the FPGA board makes of the same frames, bit for bit, by the fast code of the
// host.
#ifndef SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H
#define SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/structured_light/fast_decoder.h"

namespace selfproj::camera {

// Equal to BoardModel for frames that are whole, and for frames of which nothing came. The field `lost` is always 0,
// because nothing is lost between this board and its reader. Allocates everything in the constructor.
class SoftwareBoard {
 public:
  // Pixels have `pixel_bits` bits, 8..12. Of the settings it ignores run, hold and timeout. Throws
  // std::invalid_argument if a board of the largest size could not have them.
  explicit SoftwareBoard(const model::BoardSettings& settings, int pixel_bits = spec::kPixelBits);

  // Processes the frame with this number: makes its packets; those of the frame before are gone. `complete` false: its
  // image did not come whole. As on the board the moments are then an empty packet with the status `incomplete`, and
  // the decoder waits for plane 0. Throws std::invalid_argument if the image has not the size of the settings.
  //
  // With more than 8 bits a pixel, `wide` has all of them, and `image` the upper 8, of which images and codes are.
  void process(const model::ImageView& image, bool complete, std::uint64_t sequence, const model::BoardInputs& inputs,
               const model::WideImageView& wide = {});

  // Gives the frame's packets one after another: the moments, then the lines of the image, then those of the codes.
  // Returns false if there are no more. A packet is valid until the next call of process().
  bool next(model::PacketView& packet);

  [[nodiscard]] const model::BoardSettings& settings() const { return settings_; }

 private:
  // A packet in bytes_.
  struct Place {
    model::PacketHeader header;
    std::size_t begin = 0;
    std::size_t size = 0;
    std::uint32_t status = 0;
  };

  void send(model::PacketHeader header, std::size_t payload_bytes, std::uint32_t status);
  void send_moments(const model::ImageView& image, const model::WideImageView& wide, const model::PacketHeader& header);
  void send_image(const model::ImageView& image, model::PacketHeader header);
  void send_codes(model::PacketHeader header);
  bool decode(const model::ImageView& image, bool complete, int pattern);

  model::BoardSettings settings_;
  model::Measure measure_;
  model::PacketHeader header_;  // what is the same in every packet
  model::Runs runs_;
  std::optional<structured_light::FastGrayDecoder> decoder_;
  std::optional<structured_light::FastMedian> median_;
  std::vector<std::uint8_t> positive_;  // kept until its negative comes
  std::vector<std::uint16_t> codes_;
  std::vector<std::uint8_t> payload_;
  std::vector<std::uint8_t> bytes_;
  std::vector<Place> places_;
  std::size_t given_ = 0;
};

}  // namespace selfproj::camera

#endif  // SELFPROJ_HOST_CAMERA_SOFTWARE_BOARD_H
