// Pictures of a map (rows = frames, columns = image columns) in colours, to scale.
#ifndef SELFPROJ_HOST_REPORT_MAP_PICTURE_H
#define SELFPROJ_HOST_REPORT_MAP_PICTURE_H

#include <string>
#include <vector>

#include "host/io/float_image.h"
#include "host/report/colour_map.h"

namespace selfproj {

// Way on the surface from one row to the next (along x, by the belt) and from one column to the next (along y), > 0.
// Where it is not known what a row is worth (a belt that stands), row_mm is 0.
//
// What the axes are called is for the labels: of a camera's frame in which the rows are y, it is the other way round.
struct MapPitch {
  double row_mm = 0;
  double column_mm = 0;
  char row_axis = 'x';
  char column_axis = 'y';
};

// Which colour a value has: the ends of the map at low and high, in mm. Values outside have the ends' colours.
struct MapScale {
  ColourMap map = ColourMap::diverging;
  double low = 0;
  double high = 0;
};

// Size of a picture in pixels.
struct MapSize {
  int width = 0;
  int height = 0;
};

// Rows that have at least nine tenths of the values that the fullest one has: those that show the part, and not what is
// before and behind it.
std::vector<int> full_rows(const FloatImage& map);

// A scale symmetric about 0 that reaches over 99.5 % of the values in full rows: diverging. At least +-0.1 mm.
MapScale difference_scale(const FloatImage& difference);

// From the least to the greatest of the middle 99.8 % of the values: sequential. At least 1 mm wide.
MapScale height_scale(const FloatImage& height);

// The size of a picture of rows x columns > 0 whose longer side has `longest` pixels and which shows both directions at
// one scale, except that no side is shorter than a fifth of `longest`.
MapSize map_size(int rows, int columns, const MapPitch& pitch, int longest);

// The map alone as PNG. A pixel is the mean of the values that fall into it; where there is none it is hatched in grey,
// which no value looks like. Throws UserError where the map is empty.
std::string map_png(const FloatImage& map, const MapScale& scale, const MapSize& size);

// The map as PNG on white, with a title, a colour bar in mm, and a scale bar in mm for each direction.
std::string labelled_map_png(const FloatImage& map, const MapScale& scale, const MapPitch& pitch,
                             const std::string& title);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_REPORT_MAP_PICTURE_H
