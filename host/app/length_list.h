// Reads lists of lengths that options take.
#ifndef SELFPROJ_HOST_APP_LENGTH_LIST_H
#define SELFPROJ_HOST_APP_LENGTH_LIST_H

#include <string>
#include <vector>

namespace selfproj {

// Numbers of mm with commas between them, ascending. Throws UserError, naming the option, if one is not a number, not
// within 1e5 of 0, or not greater than the one before.
std::vector<double> ascending_lengths(const char* option, const std::string& text);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_LENGTH_LIST_H
