// The order of numbered files: img2 before img10.
#ifndef SELFPROJ_HOST_IMAGES_NATURAL_ORDER_H
#define SELFPROJ_HOST_IMAGES_NATURAL_ORDER_H

#include <string>
#include <string_view>
#include <vector>

namespace selfproj::images {

// Compares numbers within names by value, and everything else byte by byte. The order is strict: names that differ only
// in leading zeros are compared as texts.
bool natural_less(std::string_view a, std::string_view b);

std::vector<std::string> in_natural_order(std::vector<std::string> names);

// Orders files of a command line. Neighbours that differ only in their numbers and are in alphabetical order, as a
// shell expands img*.png, are put into natural order. Any other order, such as pos1 neg1 pos2 neg2, is intended by the
// user and stays.
std::vector<std::string> in_listed_order(std::vector<std::string> files);

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_NATURAL_ORDER_H
