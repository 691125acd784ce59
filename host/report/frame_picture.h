// A camera image with the line that was found in it.
#ifndef SELFPROJ_HOST_REPORT_FRAME_PICTURE_H
#define SELFPROJ_HOST_REPORT_FRAME_PICTURE_H

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/model/column_moments.h"

namespace selfproj::report {

// A camera image as it came, with the moments of its columns.
struct CameraPicture {
  images::Image image;
  model::Moments moments;
  std::vector<std::uint8_t> ambiguous = {};  // not 0: the column is to be marked; empty: none
  std::size_t frame = 0;                     // from 1
};

// PNG of the enlarged image with the centroid of every column drawn over it, that of an ambiguous column in magenta and
// apart. Below it are the moments M0 (amount of light over the threshold) and n (lit pixels) of the columns.
std::string frame_png(const CameraPicture& camera);

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_FRAME_PICTURE_H
