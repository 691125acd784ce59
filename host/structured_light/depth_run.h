// Depth images from recorded images, or from the packets of a board or a camera.
#ifndef SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H
#define SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_sequence.h"
#include "host/structured_light/scan_stream.h"
#include "host/structured_light/sequence_check.h"
#include "selfproj/driver/counters.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/packet.h"
#include "selfproj/structured_light/depth_geometry.h"
#include "selfproj/structured_light/foreground.h"
#include "selfproj/structured_light/scanner.h"
#include "selfproj/structured_light/triangulation.h"

namespace selfproj::structured_light {

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
  driver::Counters counters;
  std::uint64_t incomplete = 0;  // images or code images with lines missing
};

// What light each pixel got, in grey values: under light, and the difference of the two images of the finest pattern,
// which is how sure its last bit is.
struct LightOfPixels {
  std::vector<float> intensity, contrast;
};

struct DepthRun {
  std::unique_ptr<Triangulation> triangulation;
  std::size_t depth_images = 0;
  images::FloatImage depth;  // the newest, mm
  DepthShares shares;        // shares of the newest
  // Values of all depth images in order. From a device only of the newest, because explaining takes longer than
  // computing.
  std::vector<OfImage<DepthShares>> all_shares;
  // With a background: of all depth images in order, and the depth in mm of what moved in the newest, NaN elsewhere.
  std::vector<OfImage<Foreground>> moved;
  std::optional<images::FloatImage> moved_depth;
  double median_residual_px = std::numeric_limits<double>::quiet_NaN();  // both axes: over the pixels with a depth
  std::optional<LightOfPixels> light;                                    // of the newest pair of recorded images
  std::optional<DeviceCounts> device;
  // Between images, options and geometry (sequence_check.h): the first; empty: none. Of a device the newest one's.
  std::string contradiction;
  std::string doubt;  // likewise, of the newest depth image
};

// Receives each depth image with the number of its newest pair.
using OnDepth = std::function<void(std::size_t pair, const images::FloatImage& depth)>;

// Receives the number of images that are done, and a note on the newest depth image.
using OnImage = std::function<void(std::size_t images, const std::string& note)>;

// One coded axis: images pos0 neg0 pos1 neg1 ..., and a depth image after every pair from the m-th on. Throws UserError
// as make_triangulation, read_float_tiff and ImageSequence do, and for a background of another size.
DepthRun depth_of_images(const DepthSetup& setup, images::ImageSequence& images, const OnDepth& on_depth,
                         const OnImage& on_image = {});

// Both axes: one depth image from 2 bits images of the columns' code, followed by 2 row_bits images of the rows' code.
// Throws UserError as make_lens_triangulation and ImageSequence do.
DepthRun depth_of_both_axes(const DepthSetup& setup, images::ImageSequence& images, const OnImage& on_image = {});

// Depth images from the code images of a device, or from its images, which are decoded here.
class DepthStream {
 public:
  // `uri` is the device's name for messages. `setup` must outlive it.
  DepthStream(const DepthSetup& setup, std::string uri) : setup_(setup), uri_(std::move(uri)) {}

  // Returns whether the packet has completed a depth image. Throws UserError as depth_of_images does, and if the images
  // change size.
  bool add(const model::PacketView& packet);

  [[nodiscard]] std::size_t depth_images() const { return run_.depth_images; }
  [[nodiscard]] std::uint64_t incomplete() const { return stream_.incomplete(); }

  // Of the newest depth image: the number of its pair, and its depths in mm.
  [[nodiscard]] std::uint64_t pair() const { return stream_.pair(); }
  [[nodiscard]] const images::FloatImage& depth() const { return scanner_->depth(); }

  // What differs from the background in the newest depth image; null without a background.
  [[nodiscard]] const Foreground* moved() const;

  // The run so far; the stream is spent. Throws UserError if there is no depth image.
  DepthRun result(const driver::Counters& counters);

 private:
  const DepthSetup& setup_;
  std::string uri_;
  ScanStream stream_;
  DepthRun run_;
  std::optional<Scanner> scanner_;  // made with the first image, whose size it needs
  std::optional<SequenceCheck> check_;
  std::uint64_t sequence_ = 0;  // of the newest depth image
};

}  // namespace selfproj::structured_light

#endif  // SELFPROJ_HOST_STRUCTURED_LIGHT_DEPTH_RUN_H
