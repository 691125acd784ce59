// selfproj-sim: the world around the board, in simulation.

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <string>

#include "model/spec/generated/selfproj_spec.h"
#include "sim/app/moments_command.h"
#include "sim/app/user_error.h"

namespace {

constexpr int kFailed = 1;    // a check failed, or the program itself did
constexpr int kBadInput = 2;  // what the user can mend

// One line, whatever is in the message (a file's name may contain a line break).
int report(std::string message, int status) {
  std::replace_if(
      message.begin(), message.end(), [](char c) { return c >= '\0' && c < ' '; }, ' ');
  fmt::print(stderr, "selfproj-sim: {}\n", message);
  return status;
}

int run(int argc, char** argv) {
  CLI::App app("Simulated board of the light-section inspection", "selfproj-sim");
  app.require_subcommand(1);
  app.set_version_flag("--version",
                       fmt::format("selfproj-sim, specification {}.{}, hash 0x{:08X}", selfproj::spec::kVersion >> 8U,
                                   selfproj::spec::kVersion & 0xFFU, selfproj::spec::kHash));
  selfproj::add_moments_command(app);
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& success) {  // --help, --version
    return app.exit(success);
  } catch (const CLI::ParseError& error) {
    // CLI11 says only that a subcommand is missing where there is one that it does not know.
    const bool unknown = app.get_subcommands().empty() && app.remaining_size() > 0;
    return report(unknown ? app.remaining().front() + ": unknown subcommand or option; see --help" : error.what(),
                  kBadInput);
  } catch (const selfproj::UserError& error) {
    return report(error.what(), kBadInput);
  }
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    return report(error.what(), kFailed);
  }
}
