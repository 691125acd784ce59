#ifndef SELFPROJ_HOST_IO_PROGRAM_MAIN_H
#define SELFPROJ_HOST_IO_PROGRAM_MAIN_H

#include <functional>
#include <stdexcept>
#include <string>

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj {

// A check that the program was asked for did not hold: exit status 1, where UserError gives 2.
class CheckFailed : public std::runtime_error {
  using std::runtime_error::runtime_error;
};

// What every program of the project does: takes its subcommands, prints an error as one line "NAME: ...", and gives the
// exit status: 0, 1 for a failed check or a failure of the program itself, 2 for bad usage or input (UserError and
// CLI11's own).
int program_main(const std::string& name, const std::string& description,
                 const std::function<void(CLI::App&)>& add_commands, int argc, char** argv);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_PROGRAM_MAIN_H
