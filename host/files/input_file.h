// Reads whole files.
#ifndef SELFPROJ_HOST_FILES_INPUT_FILE_H
#define SELFPROJ_HOST_FILES_INPUT_FILE_H

#include <cstddef>
#include <string>

namespace selfproj::files {

// Rigs, calibrations and other files that people write.
inline constexpr std::size_t kMostTextBytes = std::size_t{1} << 20U;
// Tables and clouds that programs write.
inline constexpr std::size_t kMostTableBytes = std::size_t{1} << 28U;
// Images, before they are decoded.
inline constexpr std::size_t kMostImageBytes = std::size_t{1} << 30U;

// Returns the bytes of a file, or of a pipe, which must deliver them within ten seconds. Notes the file as an input
// (run_files.h). Throws UserError, naming the file, if it cannot be read, is a folder, or has more than `most_bytes`.
std::string read_input(const std::string& file, std::size_t most_bytes);

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_INPUT_FILE_H
