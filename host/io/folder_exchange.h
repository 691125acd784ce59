// Exchanges two folders in one step.
#ifndef SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H
#define SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H

#include <filesystem>

namespace selfproj {

// Whether `folder`, whose name has no links, can be exchanged: it is not a mount point, not the current folder or one
// above it, and its parent folder can be written to.
bool is_exchangeable(const std::filesystem::path& folder);

// Replaces the existing `target` by `fresh` in one step. `fresh` first gets the other files of `target`, its
// permissions and its owner. The old folder then has the name of `fresh`, and the caller removes it. Returns false and
// leaves `target` unchanged if the system cannot do this.
bool exchange_folders(const std::filesystem::path& fresh, const std::filesystem::path& target);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H
