// The curve of a projector: how much light it gives for each grey value.
#ifndef SELFPROJ_HOST_PROJECTOR_GREY_CURVE_H
#define SELFPROJ_HOST_PROJECTOR_GREY_CURVE_H

#include <string>
#include <vector>

#include "host/projector/projector.h"

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

// The table that makes light proportional to grey: for each grey value g the value whose light is nearest to g / 255 of
// the way from that of 0 to that of 255.
GreyTable linear_greys(const GreyCurve& curve);

// Reads a table with the columns grey,light, as `selfproj measure gamma` writes it. Throws UserError with the file if
// it cannot be read, is no such table, does not go from 0 to 255, or if light falls or does not rise at all.
GreyCurve load_grey_curve(const std::string& file);

// The text of such a file.
std::string grey_curve_text(const GreyCurve& curve);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PROJECTOR_GREY_CURVE_H
