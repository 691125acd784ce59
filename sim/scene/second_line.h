// A second reflection: the camera sees the projected light again, weaker and at another place, as in a shiny wall or
// between the glasses of a window.
#ifndef SELFPROJ_SIM_SCENE_SECOND_LINE_H
#define SELFPROJ_SIM_SCENE_SECOND_LINE_H

#include <span>

namespace selfproj {

// The second image lies `least_rows` to `most_rows` below the first one. The distance swings with the way of the part,
// so that a measurement of the good part at one place does not know it.
struct SecondLine {
  double share = 0;  // of the first reflection's light
  double least_rows = 0;
  double most_rows = 0;
  double period_mm = 1;
};

// The distance in rows when the part has moved `way_mm`: (least + most)/2 + (most - least)/2 sin(2π way / period).
double second_line_rows(const SecondLine& line, double way_mm);

// Adds the second reflection to an image of grey values. `without` is the grey value without projected light; what lies
// above it is reflected, linear between rows.
void add_second_line(const SecondLine& line, double way_mm, int rows, int columns, double without,
                     std::span<float> pixels);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_SCENE_SECOND_LINE_H
