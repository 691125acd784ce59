// Exchanges two folders in one step.
#ifndef SELFPROJ_HOST_FILES_FOLDER_EXCHANGE_H
#define SELFPROJ_HOST_FILES_FOLDER_EXCHANGE_H

#include <filesystem>

namespace selfproj {

// Returns whether `folder` can be exchanged: it is not a mount point, it is not the current folder or one above it, and
// its parent folder can be written to. No part of its path may be a link.
bool is_exchangeable(const std::filesystem::path& folder);

// Replaces the existing folder `target` by `fresh` in one step. Before that, `fresh` gets the permissions and the owner
// of `target`, and those of its files that `fresh` does not have. Afterwards the old folder has the name of `fresh`,
// and the caller must remove it. Returns false and leaves `target` unchanged if the system cannot do this.
bool exchange_folders(const std::filesystem::path& fresh, const std::filesystem::path& target);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_FOLDER_EXCHANGE_H
