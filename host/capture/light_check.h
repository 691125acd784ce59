// Whether an image shows the pattern that it should, as far as images under white and black can tell.
#ifndef SELFPROJ_HOST_CAPTURE_LIGHT_CHECK_H
#define SELFPROJ_HOST_CAPTURE_LIGHT_CHECK_H

#include "host/images/image_files.h"

namespace selfproj::capture {

// A scene with all of the projector white, and black.
struct WhiteAndBlack {
  images::Image white;
  images::Image black;
};

// All functions look at blocks of 16 x 16 pixels, and there at the pixels to which white adds 10 grey values or more. A
// block with less than a quarter of such pixels is passed over.

// Whether the light is that of white, or of black, everywhere: 97 % of the way from the other one in the mean, and 90 %
// in each block. An image in which only a part has followed does not count.
bool all_white(const images::Image& image, const WhiteAndBlack& levels);
bool all_black(const images::Image& image, const WhiteAndBlack& levels);

// Whether the second pattern is black where the first is white and the other way round, and both have no greys.
bool is_negative(const images::Image& pattern, const images::Image& negative);

// Whether the images of a pattern and its negative together have the light of white and black. They do not if one of
// them shows another pattern, or several patterns at once. All of the light may be 15 % less or 20 % more. Beyond that,
// a block may differ by 5 % of its light, and its pixels by 10 % and 3 grey values in the mean. Where the pattern is
// bright, a block may differ from where it is dark by 5 % of their contrast, or by what noise explains.
bool adds_up(const images::Image& pattern, const images::Image& negative, const WhiteAndBlack& levels);

// Whether two images show the same light: a block may differ by 10 % of its light and 3 grey values.
bool same_light(const images::Image& a, const images::Image& b, const WhiteAndBlack& levels);

}  // namespace selfproj::capture

#endif  // SELFPROJ_HOST_CAPTURE_LIGHT_CHECK_H
