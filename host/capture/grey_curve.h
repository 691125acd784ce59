// The curve of a projector: how much light it gives for each grey value.
#ifndef SELFPROJ_HOST_CAPTURE_GREY_CURVE_H
#define SELFPROJ_HOST_CAPTURE_GREY_CURVE_H

#include <string>
#include <vector>

#include "host/capture/projector.h"

namespace selfproj {

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

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CAPTURE_GREY_CURVE_H
