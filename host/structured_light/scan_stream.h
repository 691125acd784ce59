// What a scanner gets from a board: code images that it has decoded, or the camera's images as they are.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_SCAN_STREAM_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_SCAN_STREAM_H

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "selfproj/driver/image_assembler.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/packet.h"

namespace selfproj::structured_light {

// Puts images together from packets. Where a board sends both kinds, the one of which a whole image comes first is
// taken from then on.
class ScanStream {
 public:
  enum class Got : std::uint8_t { nothing, codes, image };

  // Takes a packet, and says what it has completed. header() and codes() or image() hold until the next call; the
  // pixels of an image also hold while the next image comes, as decoders need it.
  Got add(const model::PacketView& packet);

  [[nodiscard]] const model::PacketHeader& header() const;
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return codes_.codes(); }
  [[nodiscard]] model::ImageView image() const;

  // The pattern of the image where the projector shows `patterns` in turn, from the board's frame 0 on.
  [[nodiscard]] int pattern(int patterns) const {
    return static_cast<int>(header().sequence % static_cast<std::uint64_t>(patterns));
  }

  // Whether the image follows the one that was completed before it: none between them was lost. A decoder must begin
  // anew where it does not, because after a whole number of sequences the pattern alone does not tell.
  [[nodiscard]] bool follows() const { return follows_; }

  // The number of its pair of images, from 0: that of the depth image that it completes.
  [[nodiscard]] std::uint64_t pair() const { return header().sequence / 2; }

  // Images of the kind that is taken of which lines were missing.
  [[nodiscard]] std::uint64_t incomplete() const;

 private:
  driver::ImageAssembler codes_{spec::kKindCodes, 0};
  driver::ImageAssembler images_{spec::kKindImage, 0};
  std::optional<Got> kind_;
  std::array<std::vector<std::uint8_t>, 2> pixels_;  // of the newest image and the one before, by turns
  std::size_t newest_ = 0;
  std::optional<std::uint64_t> last_;  // sequence of the newest image
  bool follows_ = false;
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_SCAN_STREAM_H
