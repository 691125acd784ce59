// Images and code images out of packets of lines.
#ifndef SELFPROJ_HOST_DRIVER_IMAGE_ASSEMBLER_H
#define SELFPROJ_HOST_DRIVER_IMAGE_ASSEMBLER_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "model/packet.h"

namespace selfproj {

// Puts the lines of one stream and kind together. Allocates in the constructor only.
class ImageAssembler {
 public:
  // `kind` is spec::kKindImage or spec::kKindCodes; images up to max_rows x max_columns. Throws std::invalid_argument
  // where one of them is none.
  ImageAssembler(std::uint8_t kind, int stream, int max_rows = spec::kMaxRows, int max_columns = spec::kMaxColumns);

  // Takes a packet; those of other kinds or streams are passed over. True where it completes an image whose lines have
  // all come, in order and with a good status: header() and pixels() or codes() are it, until the next call.
  bool add(const PacketView& packet);

  // Of the image's first line.
  [[nodiscard]] const PacketHeader& header() const { return header_; }

  // Row by row without gaps, header().columns a row; codes as 16-bit words of the specification.
  [[nodiscard]] const std::vector<std::uint8_t>& pixels() const { return pixels_; }
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return codes_; }

  [[nodiscard]] std::uint64_t complete() const { return complete_; }
  // Images of which at least one line came, and not all of them good; the one that is being put together is not
  // counted.
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }
  // Images larger than max_rows x max_columns.
  [[nodiscard]] std::uint64_t too_large() const { return too_large_; }

 private:
  std::uint8_t kind_;
  int stream_;
  int max_rows_;
  int max_columns_;
  PacketHeader header_;
  std::vector<std::uint8_t> pixels_;
  std::vector<std::uint16_t> codes_;
  int next_line_ = 0;  // expected, from 1; 0: the frame is given up
  bool open_ = false;  // lines of header_'s frame have come, the last one has not
  bool seen_ = false;  // header_ is that of a frame
  std::uint64_t complete_ = 0;
  std::uint64_t incomplete_ = 0;
  std::uint64_t too_large_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_DRIVER_IMAGE_ASSEMBLER_H
