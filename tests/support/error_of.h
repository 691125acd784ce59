// The error message of an action, for tests that expect it to be refused.
#ifndef SELFPROJ_TESTS_SUPPORT_ERROR_OF_H
#define SELFPROJ_TESTS_SUPPORT_ERROR_OF_H

#include <functional>
#include <string>

#include "selfproj/files/user_error.h"

namespace selfproj::test {

// Returns the text of the UserError that `act` throws, or "none" if it throws nothing. Other exceptions pass through.
inline std::string error_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const UserError& error) {
    return error.what();
  }
  return "none";
}

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_SUPPORT_ERROR_OF_H
