// Two folders change places in one step.
#ifndef SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H
#define SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H

#include <filesystem>

namespace selfproj {

// Whether `folder`, without links in its name, can change its place: it is no mount point, not the current folder or
// one above it, and the folder above can be written to.
bool is_exchangeable(const std::filesystem::path& folder);

// Puts `fresh` in the place of `target`, which is there, in one step: what `target` has beside is in `fresh` then, too,
// and `fresh` has its rights and owner. The old folder has the name of `fresh` then, and is to be removed. False, and
// `target` is untouched, where the system cannot do that.
bool exchange_folders(const std::filesystem::path& fresh, const std::filesystem::path& target);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_FOLDER_EXCHANGE_H
