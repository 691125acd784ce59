// The order of numbered files: img2 before img10.
#ifndef SELFPROJ_HOST_IO_NATURAL_ORDER_H
#define SELFPROJ_HOST_IO_NATURAL_ORDER_H

#include <string>
#include <string_view>
#include <vector>

namespace selfproj {

// Compares numbers within the names by their value, and all else byte by byte. A strict order: names that differ only
// in leading zeros are compared as texts.
bool natural_less(std::string_view a, std::string_view b);

std::vector<std::string> in_natural_order(std::vector<std::string> names);

// Files as a user lists them. Neighbours that differ only in their numbers and stand in alphabetical order, as a shell
// expands img*.png, are put in natural order. Any other order, such as pos1 neg1 pos2 neg2, is the user's and stays.
std::vector<std::string> in_listed_order(std::vector<std::string> files);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_NATURAL_ORDER_H
