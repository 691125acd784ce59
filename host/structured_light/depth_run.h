// A run of `selfproj depth`: depth images from recorded images, or from the code images that a board decodes.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "host/images/float_image.h"
#include "host/images/image_sequence.h"
#include "host/structured_light/depth_geometry.h"
#include "host/structured_light/foreground.h"
#include "host/structured_light/scanner.h"
#include "host/structured_light/triangulation.h"

namespace selfproj {

struct DepthSetup {
  DepthGeometry geometry;
  ScannerSettings scanner;
  std::string background;  // TIFF of the depths in mm of what does not move; empty: none
};

// A value of one depth image among several. `number` is that of the newest pair, from 0, or of the newest frame.
template <typename Value>
struct OfImage {
  std::uint64_t number = 0;
  Value value;
};

struct DeviceCounts {
  Counters counters;
  std::uint64_t incomplete = 0;  // images or code images with lines missing
};

struct DepthRun {
  std::unique_ptr<Triangulation> triangulation;
  std::size_t depth_images = 0;
  FloatImage depth;    // the newest, mm
  DepthShares shares;  // shares of the newest
  // Values of all depth images in order. From a device only of the newest, because explaining takes longer than
  // computing.
  std::vector<OfImage<DepthShares>> all_shares;
  // With a background: of all depth images in order, and the depth in mm of what moved in the newest, NaN elsewhere.
  std::vector<OfImage<Foreground>> moved;
  std::optional<FloatImage> moved_depth;
  double median_residual_px = std::numeric_limits<double>::quiet_NaN();  // both axes: over the pixels with a depth
  std::optional<DeviceCounts> device;
};

// Receives each depth image with the number of its newest pair.
using TakeDepth = std::function<void(std::size_t pair, const FloatImage& depth)>;

// One coded axis: images pos0 neg0 pos1 neg1 ..., and a depth image after every pair from the m-th on. Shows progress.
// Throws UserError as make_triangulation, read_float_tiff and ImageSequence do, and for a background of another size.
DepthRun depth_of_images(const DepthSetup& setup, ImageSequence& images, const TakeDepth& take);

// Both axes: one depth image from 2 bits images of the columns' code, followed by 2 row_bits images of the rows' code.
// Shows progress. Throws UserError as make_lens_triangulation and ImageSequence do.
DepthRun depth_of_both_axes(const DepthSetup& setup, ImageSequence& images);

// Code images from the device, or images that are decoded here, until it ends, `count` depth images have been made (0:
// any number), or Ctrl-C. Shows progress. `uri` is its name for messages. Throws UserError as depth_of_images does, and
// if the images change size, or none is complete.
DepthRun depth_of_device(const DepthSetup& setup, const std::string& uri, std::unique_ptr<Device> device,
                         std::size_t count, const TakeDepth& take);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H
