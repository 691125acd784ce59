// The curve of a projector, measured by a camera: how much light it gives for each grey value.
#ifndef SELFPROJ_HOST_CAPTURE_GREY_RESPONSE_H
#define SELFPROJ_HOST_CAPTURE_GREY_RESPONSE_H

#include <cstddef>
#include <string>
#include <vector>

#include "host/capture/grey_curve.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"

namespace selfproj {

// `levels` grey values from 0 to 255, evenly spaced and rounded. 2 <= levels <= 256.
std::vector<int> grey_levels(int levels);

// Each grey value everywhere, for a projector of rows x columns pixels.
ImageSequence grey_patterns(const std::vector<int>& greys, int rows, int columns);

struct GreyResponse {
  GreyCurve curve;         // light in grey values of the camera above that of black
  std::size_t pixels = 0;  // of the camera that took part
  double gamma = 0;        // of the power law light = (grey / 255)^gamma that is nearest
  double off_law = 0;      // the largest distance from that law, as a share of the light of white
  double off_line = 0;     // the largest distance from light in proportion to grey, likewise
};

// The response of images of one size, taken under these greys, which rise from 0 to 255. Takes the pixels that white
// makes brighter by 30 or more and to no more than 250, for a camera that is saturated tells no light. Where noise lets
// the mean fall by less than 1 % of white, it counts as equal. Throws UserError about `camera` if fewer than 100 pixels
// take part, or the light falls.
GreyResponse grey_response(const std::vector<int>& greys, const std::vector<Image>& images, const std::string& camera);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAPTURE_GREY_RESPONSE_H
