// What is to be said of a file although it can be read, such as a key that has a new name.
#ifndef SELFPROJ_HOST_FILES_NOTES_H
#define SELFPROJ_HOST_FILES_NOTES_H

#include <functional>
#include <string>

namespace selfproj::files {

// The function that receives each note, one line: a program shows it on its terminal. Empty: notes are dropped. Set it
// before threads begin.
inline std::function<void(const std::string& line)>& note_sink() {
  static std::function<void(const std::string& line)> sink;
  return sink;
}

inline void note(const std::string& line) {
  if (note_sink()) {
    note_sink()(line);
  }
}

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_NOTES_H
