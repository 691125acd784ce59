// The curve of a projector: how much light it gives for each grey value.
#ifndef SELFPROJ_HOST_CAPTURE_GREY_CURVE_H
#define SELFPROJ_HOST_CAPTURE_GREY_CURVE_H

#include <cstddef>
#include <string>
#include <vector>

#include "host/capture/projector.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"

namespace selfproj::capture {

// Light at some grey values, in any unit.
struct GreyCurve {
  struct Point {
    double grey = 0;
    double light = 0;
  };
  std::vector<Point> points;  // grey rises from 0 to 255, light does not fall

  // The light at a grey value 0..255, on straight lines between the points.
  [[nodiscard]] double light_at(double grey) const;
};

// Returns the table that makes light rise linearly with grey. For each grey value g it holds the value whose light is
// nearest to dark + (bright - dark) g / 255, where dark is the light at 0 and bright the light at 255. Grey 0 stays 0.
GreyTable linear_greys(const GreyCurve& curve);

// Reads a table with the columns grey,light, as `selfproj measure gamma` writes it. Throws UserError, which names the
// file, if the file cannot be read or is no such table, if grey does not rise from 0 to 255, or if light falls anywhere
// or does not rise at all.
GreyCurve load_grey_curve(const std::string& file);

// The text of such a file.
std::string grey_curve_text(const GreyCurve& curve);

// `levels` grey values from 0 to 255, evenly spaced and rounded. 2 <= levels <= 256.
std::vector<int> grey_levels(int levels);

// Each grey value everywhere, for a projector of rows x columns pixels.
images::ImageSequence grey_patterns(const std::vector<int>& greys, int rows, int columns);

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
GreyResponse grey_response(const std::vector<int>& greys, const std::vector<images::Image>& images,
                           const std::string& camera);

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_GREY_CURVE_H
