// The help of a command as text for a terminal, and as JSON for the pages of the documents.
#ifndef SELFPROJ_HOST_CLI_HELP_TEXT_H
#define SELFPROJ_HOST_CLI_HELP_TEXT_H

#include <CLI/CLI.hpp>
#include <string>

namespace selfproj::cli {

// At most 100 columns wide: purpose, usage, details, arguments, options by group, commands, examples.
class HelpFormatter : public CLI::FormatterBase {
 public:
  [[nodiscard]] std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override;
};

// A program and all its commands, with everything in their help.
std::string help_json(const CLI::App& program);

}  // namespace selfproj::cli

#endif  // SELFPROJ_HOST_CLI_HELP_TEXT_H
