// Rules for the whole run of a program, whatever its command does.
#ifndef SELFPROJ_HOST_CLI_PROGRAM_RUN_H
#define SELFPROJ_HOST_CLI_PROGRAM_RUN_H

#include <functional>
#include <string>

namespace selfproj {

// Calls `body`, which prints what it has to say and gives the exit status, and gives the program's:
//  - standard output that cannot be written to (a full disk, a closed pipe or descriptor) makes status 1 of 0, with one
//    line on standard error;
//  - no output may be one of the inputs (run_files.h);
//  - SIGINT, SIGTERM and SIGHUP leave nothing temporary behind; a closed pipe and a limit on sizes of files (SIGPIPE,
//    SIGXFSZ) are errors of the writing, not signals.
int run_as_program(const std::string& name, const std::function<int()>& body);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_CLI_PROGRAM_RUN_H
