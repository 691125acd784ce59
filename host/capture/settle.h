// How long after a pattern was shown an image shows it: measured by flashes of the projector that the camera sees.
#ifndef SELFPROJ_HOST_CAPTURE_SETTLE_H
#define SELFPROJ_HOST_CAPTURE_SETTLE_H

#include <optional>
#include <string>
#include <vector>

#include "host/capture/light_check.h"
#include "host/capture/shots.h"
#include "host/images/image_files.h"

namespace selfproj::capture {

// The delays from Shots::show() until the first image that shows the new light has come in. A wait of this length
// before the trigger is enough for any camera: some take a triggered image at once, others at the next tick of a clock
// of their own, so that only the arrival of an image says that it was taken by then.
struct Settle {
  double min_ms = 0;     // the shortest delay observed
  double max_ms = 0;     // the longest
  double settle_ms = 0;  // how long to wait
};

// What one flash tells: when the last image with the old light and the first with the new came in, in ms after it was
// shown.
struct FlashTimes {
  double old_ms = 0;
  double new_ms = 0;
};

// The settle time of several flashes. If one delay can explain all of them, give or take 5 ms, it lies between the
// latest old and the earliest new image; then the wait is the later of the two, a tenth more, and by how much they
// contradict each other. Otherwise delays spread, and the wait is the longest and the whole spread more. In both cases
// at least 2 ms are added. Throws std::invalid_argument without flashes.
Settle settle_of(const std::vector<FlashTimes>& flashes);

// White and black, as the camera sees them 0.7 s after they were shown, or where the settle time is known, 0.2 s and
// twice this time. Throws UserError about the camera if it does not see the projector: their means are less than 3 grey
// values apart.
WhiteAndBlack take_white_and_black(Shots& shots, const std::string& camera, std::optional<double> settle_ms = {});

// Flashes 16 times, or 48 times where two images take longer than the light. An image has the new light when all
// of it has followed (light_check.h). Throws UserError if the light does not follow within 3 s.
Settle measure_settle(Shots& shots, const WhiteAndBlack& levels, const std::string& camera);

// The exposure of the white image.
struct ExposureCheck {
  double saturated = 0;               // share of pixels with the largest value
  double dark = 0;                    // share of pixels to which the projector adds less than 10 grey values
  std::optional<double> factor = {};  // by which the exposure should change, if it should
};

// Too long if more than 0.5 % of the pixels are saturated: half is proposed, for nobody knows by how much they are too
// bright. Too short if 99.5 % of the lit pixels are below 150: what brings them to 220 is proposed.
ExposureCheck check_exposure(const WhiteAndBlack& levels);

// "1.2 % of the pixels are saturated, 30.0 % are dark; try half the exposure".
std::string exposure_text(const ExposureCheck& check);

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_SETTLE_H
