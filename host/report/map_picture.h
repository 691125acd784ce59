// Colours for numbers, and pictures of a map (rows are frames, columns are image columns) in these colours, to scale.
#ifndef SELFPROJ_HOST_REPORT_MAP_PICTURE_H
#define SELFPROJ_HOST_REPORT_MAP_PICTURE_H

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "selfproj/images/float_image.h"

namespace selfproj::report {

struct Colour {
  std::uint8_t red = 0;
  std::uint8_t green = 0;
  std::uint8_t blue = 0;
};

enum class ColourMap : std::uint8_t {
  diverging,   // blue - white - red, perceptually symmetric about white: for signed values around 0
  sequential,  // viridis, dark to light in perceptually even steps: for heights
};

// The colour at t, which is clamped to 0..1 and must not be NaN.
Colour colour_at(ColourMap map, double t);

// Distance on the surface from one row to the next (along x, by the belt) and from one column to the next (along y), >
// 0. row_mm is 0 if the distance between rows is unknown, because the belt stands still.
//
// The names of the axes are for the labels. In a camera's frame in which rows are y, they are exchanged.
struct MapPitch {
  double row_mm = 0;
  double column_mm = 0;
  std::string row_axis = "x";
  std::string column_axis = "y";
  std::string_view unit = "mm";  // of the scale bars
};

// The colours of values: low and high, in mm, have the end colours. Values outside have the same colours as the ends.
struct MapScale {
  ColourMap map = ColourMap::diverging;
  double low = 0;
  double high = 0;
  std::string_view unit = "mm";  // of the colour bar
};

// Size of a picture in pixels.
struct MapSize {
  int width = 0;
  int height = 0;
};

// Rows that have at least nine tenths as many values as the fullest row. These show the part, and not what is before
// and behind it.
std::vector<int> full_rows(const images::FloatImage& map);

// A diverging scale, symmetric about 0, that covers 99.5 % of the values in full rows, at least +-0.1 mm; but no more
// than `at_most`, if it is given and above 0.
MapScale difference_scale(const images::FloatImage& difference, double at_most = 0);

// A sequential scale over the middle 99.8 % of the values; at least 1 mm wide.
MapScale height_scale(const images::FloatImage& height);

// The size of a picture of rows x columns > 0 whose longer side has `longest` pixels. Both directions have one scale,
// except that no side is shorter than a fifth of `longest`.
MapSize map_size(int rows, int columns, const MapPitch& pitch, int longest);

// The map alone as PNG. A pixel is the mean of the values that fall into it. A pixel without values is hatched in grey,
// which is the colour of no value. Throws UserError if the map is empty.
std::string map_png(const images::FloatImage& map, const MapScale& scale, const MapSize& size);

// A frame around a place of a map, in rows and columns from 0; its middle and its size.
struct MapMark {
  double row = 0;
  double column = 0;
  double rows = 0;
  double columns = 0;
};

// The map as PNG on white, with a title, a colour bar, a scale bar for each direction, and the marks.
std::string labelled_map_png(const images::FloatImage& map, const MapScale& scale, const MapPitch& pitch,
                             const std::string& title, const std::vector<MapMark>& marks = {});

}  // namespace selfproj::report

#endif  // SELFPROJ_HOST_REPORT_MAP_PICTURE_H
