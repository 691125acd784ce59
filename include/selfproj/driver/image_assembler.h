// Images and code images from packets of lines.
#ifndef SELFPROJ_DRIVER_IMAGE_ASSEMBLER_H
#define SELFPROJ_DRIVER_IMAGE_ASSEMBLER_H

#include <cstddef>
#include <cstdint>
#include <vector>

#include "selfproj/model/packet.h"

namespace selfproj::driver {

// Assembles the lines of one stream and kind. Allocates only in the constructor.
class ImageAssembler {
 public:
  // `kind` is spec::kKindImage or spec::kKindCodes; images may have up to max_rows x max_columns. Throws
  // std::invalid_argument if an argument is out of range.
  ImageAssembler(std::uint8_t kind, int stream, int max_rows = spec::kRowLimit, int max_columns = spec::kColumnLimit);

  // Takes a packet; ignores those of other kinds or streams. Returns true if the packet completes an image whose lines
  // have all come, in order and with a good status. header() and pixels() or codes() then hold it until the next call.
  bool add(const model::PacketView& packet);

  // The header of the image's first line.
  [[nodiscard]] const model::PacketHeader& header() const { return header_; }

  // Row by row without gaps, header().columns in each row; codes are 16-bit words of the specification.
  [[nodiscard]] const std::vector<std::uint8_t>& pixels() const { return pixels_; }
  [[nodiscard]] const std::vector<std::uint16_t>& codes() const { return codes_; }

  [[nodiscard]] std::uint64_t complete() const { return complete_; }
  // Images of which at least one line came, but not all lines were good. Does not count the current image.
  [[nodiscard]] std::uint64_t incomplete() const { return incomplete_; }
  // Images larger than max_rows x max_columns.
  [[nodiscard]] std::uint64_t too_large() const { return too_large_; }

 private:
  std::uint8_t kind_;
  int stream_;
  int max_rows_;
  int max_columns_;
  model::PacketHeader header_;
  std::vector<std::uint8_t> pixels_;
  std::vector<std::uint16_t> codes_;
  int next_line_ = 0;  // next expected line, from 1; 0: the frame is given up
  bool open_ = false;  // lines of header_'s frame have come, but not the last one
  bool seen_ = false;  // header_ belongs to a frame
  std::uint64_t complete_ = 0;
  std::uint64_t incomplete_ = 0;
  std::uint64_t too_large_ = 0;
};

}  // namespace selfproj::driver

#endif  // SELFPROJ_DRIVER_IMAGE_ASSEMBLER_H
