// Images of a scene under the patterns of a cycle, one after another into a scanner.
#ifndef SELFPROJ_LAB_PATTERN_SCAN_H
#define SELFPROJ_LAB_PATTERN_SCAN_H

#include <cstdint>
#include <functional>
#include <vector>

#include "host/images/float_image.h"
#include "host/images/image_files.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj {

// Gives a scanner the images of a scene under the 2 bits patterns of a cycle, frames `first` and on. `see` gets each
// image before the scanner.
template <class AnyScanner>
void scan_cycle(const PatternRenderer& renderer, int first, int bits, const std::function<FloatImage(int)>& pattern,
                const std::function<void(int, const ImageView&)>& see, AnyScanner& scanner) {
  std::vector<std::uint8_t> positive;  // the scanner reads it again when the negative comes
  take_images(renderer,
              {.count = 2 * bits, .first = first, .pattern = [&](int i) { return pattern_image(pattern(i)); }},
              [&](int i, const ImageView& image) {
                see(i, image);
                if (i % 2 == 0) {
                  positive.assign(image.pixels, image.pixels + renderer.rig().camera.pixels());
                  scanner.add_frame({positive.data(), image.rows, image.columns, image.columns}, i);
                } else {
                  scanner.add_frame(image, i);
                }
              });
}

}  // namespace selfproj

#endif  // SELFPROJ_LAB_PATTERN_SCAN_H
