#ifndef SELFPROJ_FILES_USER_ERROR_H
#define SELFPROJ_FILES_USER_ERROR_H

#include <stdexcept>
#include <string>

namespace selfproj {

// An error that the user can fix: a file or an option, and the reason. The program prints it as one line, "PROGRAM:
// SUBJECT: REASON", and exits with status 2.
class UserError : public std::runtime_error {
 public:
  UserError(const std::string& subject, const std::string& reason) : std::runtime_error(subject + ": " + reason) {}
};

// A check that the user asked for has failed. The exit status is 1, while UserError gives 2.
class CheckFailed : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace selfproj

#endif  // SELFPROJ_FILES_USER_ERROR_H
