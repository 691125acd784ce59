#ifndef SELFPROJ_HOST_IO_USER_ERROR_H
#define SELFPROJ_HOST_IO_USER_ERROR_H

#include <stdexcept>
#include <string>

namespace selfproj {

// Something the user can mend: a file or an option, and what is wrong with it. The program prints it as one line,
// "PROGRAM: SUBJECT: REASON", and exits with status 2.
class UserError : public std::runtime_error {
 public:
  UserError(const std::string& subject, const std::string& reason) : std::runtime_error(subject + ": " + reason) {}
};

// A check that the program was asked for did not hold: exit status 1, where UserError gives 2.
class CheckFailed : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_USER_ERROR_H
