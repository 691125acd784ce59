// What the commands that take frames have in common: names of modes and channels, sizes the board takes.
#ifndef SELFPROJ_SIM_APP_FRAME_OPTIONS_H
#define SELFPROJ_SIM_APP_FRAME_OPTIONS_H

#include <string>
#include <vector>

#include "host/io/image_files.h"
#include "model/column_moments.h"

namespace selfproj {

// Names of the modes as options spell them: binary, grey, grey-over.
std::vector<std::string> mode_names();

// The mode of one of these names, and its name.
Mode mode_of(const std::string& name);
std::string mode_name(Mode mode);

// Names of the channels: red, green, blue, grey; and the channel of one of them.
std::vector<std::string> channel_names();
Channel channel_of(const std::string& name);

// "512 x 96": columns x rows.
std::string size_text(int rows, int columns);

// Throws UserError naming the file where the board takes no image of this size.
void check_frame_size(const std::string& file, const Image& image);

// Throws UserError naming the file where it has another size than the first one.
void check_same_size(const std::string& file, const Image& image, const std::string& first, int rows, int columns);

}  // namespace selfproj

#endif  // SELFPROJ_SIM_APP_FRAME_OPTIONS_H
