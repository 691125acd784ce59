#include "host/io/program_main.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <functional>
#include <string>

#include "host/io/user_error.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {
namespace {

constexpr int kFailed = 1;    // a check failed, or the program itself did
constexpr int kBadInput = 2;  // what the user can mend

// One line, whatever is in the message (a file's name may contain a line break).
int report(const std::string& program, std::string message, int status) {
  std::replace_if(
      message.begin(), message.end(), [](char c) { return c >= '\0' && c < ' '; }, ' ');
  fmt::print(stderr, "{}: {}\n", program, message);
  return status;
}

}  // namespace

int program_main(const std::string& name, const std::string& description,
                 const std::function<void(CLI::App&)>& add_commands, int argc, char** argv) {
  try {
    CLI::App app(description, name);
    app.require_subcommand(1);
    app.set_version_flag("--version", fmt::format("{}, specification {}.{}, hash 0x{:08X}", name, spec::kVersion >> 8U,
                                                  spec::kVersion & 0xFFU, spec::kHash));
    add_commands(app);
    try {
      app.parse(argc, argv);
    } catch (const CLI::Success& success) {  // --help, --version
      return app.exit(success);
    } catch (const CLI::ParseError& error) {
      // CLI11 says only that a subcommand is missing where there is one that it does not know.
      const bool unknown = app.get_subcommands().empty() && app.remaining_size() > 0;
      return report(name,
                    unknown ? app.remaining().front() + ": unknown subcommand or option; see --help" : error.what(),
                    kBadInput);
    }
  } catch (const UserError& error) {
    return report(name, error.what(), kBadInput);
  } catch (const std::exception& error) {
    return report(name, error.what(), kFailed);
  }
  return 0;
}

}  // namespace selfproj
