// Makes the missing parent folders of an output.
#ifndef SELFPROJ_HOST_FILES_OUTPUT_PARENTS_H
#define SELFPROJ_HOST_FILES_OUTPUT_PARENTS_H

#include <filesystem>
#include <string>
#include <system_error>
#include <vector>

namespace selfproj {

// The folder that holds the file: "." if the name has none.
std::filesystem::path parent_of(const std::filesystem::path& path);

// The nearest existing folder above `target`. Throws UserError about `name`, which the user gave, if nothing can be
// made in it.
std::filesystem::path writable_parent(const std::string& name, const std::filesystem::path& target);

// Makes a folder and its missing parents, and removes them again unless they are kept.
class MadeFolders {
 public:
  MadeFolders(const std::filesystem::path& folder, std::error_code& error);
  MadeFolders(const MadeFolders&) = delete;
  MadeFolders& operator=(const MadeFolders&) = delete;
  ~MadeFolders();

  void keep() { made_.clear(); }

 private:
  std::vector<std::filesystem::path> made_;  // from the top down
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_FILES_OUTPUT_PARENTS_H
