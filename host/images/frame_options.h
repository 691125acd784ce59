// Shared by the commands that take frames: names of modes and channels, sizes of images.
#ifndef SELFPROJ_HOST_IMAGES_FRAME_OPTIONS_H
#define SELFPROJ_HOST_IMAGES_FRAME_OPTIONS_H

#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::images {

// The names of the modes in options and rigs.
inline constexpr std::array<std::pair<const char*, model::Mode>, 3> kModes{
    {{"binary", model::Mode::binary}, {"grey", model::Mode::grey}, {"grey-over", model::Mode::grey_over}}};
std::vector<std::string> mode_names();

// The mode of one of these names; throws std::invalid_argument for any other. The name of a mode; "unknown" for any
// other value.
model::Mode mode_of(const std::string& name);
std::string mode_name(model::Mode mode);

// The names of the selects in options: "all" and "strongest". Throws std::invalid_argument for any other name; the name
// of a select, "unknown" for any other value.
std::vector<std::string> select_names();
model::Select select_of(const std::string& name);
std::string select_name(model::Select select);

// The window of a text "A..B", first and last row that count, from 1. Throws UserError about `option` unless
// 1 <= A <= B <= max_rows.
model::RowWindow rows_of_text(const std::string& option, const std::string& text, int max_rows = spec::kRowLimit);

// "strongest, gap 1, rows 10..80": what `measure` has that is not what a board measures by default; empty if nothing.
std::string select_text(const model::Measure& measure);

// Names of the channels, kChannels; and the channel of one of them, none for the empty name. Throws
// std::invalid_argument for any other.
std::vector<std::string> channel_names();
std::optional<Channel> channel_of(const std::string& name);

// "512 x 96": columns x rows.
std::string size_text(int rows, int columns);

struct FrameSize {
  int rows = 0;
  int columns = 0;
};

// The size of such a text, both sides 1..max_side. Throws UserError about `option` otherwise.
FrameSize size_of_text(const std::string& option, const std::string& text, int max_side);

// Throws UserError, naming the file, if a circuit with these maxima takes no image of this size.
void check_frame_size(const std::string& file, const Image& image, int max_rows, int max_columns);

// Throws UserError, naming the file, if its size differs from that of the first one.
void check_same_size(const std::string& file, const FrameSize& size, const std::string& first, int rows, int columns);

}  // namespace selfproj::images

#endif  // SELFPROJ_HOST_IMAGES_FRAME_OPTIONS_H
