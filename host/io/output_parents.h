// The folders above an output, which are made with it.
#ifndef SELFPROJ_HOST_IO_OUTPUT_PARENTS_H
#define SELFPROJ_HOST_IO_OUTPUT_PARENTS_H

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace selfproj {

// The folder that holds it: "." where the name has no other.
std::filesystem::path parent_of(const std::filesystem::path& path);

// The nearest folder above `target` that is there. Throws UserError about `name`, which the user gave, where nothing
// can be made in it.
std::filesystem::path writable_parent(const std::string& name, const std::filesystem::path& target);

// Makes a folder and those above it; what it made goes away again unless it is kept.
class MadeFolders {
 public:
  MadeFolders(const std::filesystem::path& folder, std::error_code& error);
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;
  ~MadeFolders();

  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  // from above
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_OUTPUT_PARENTS_H
