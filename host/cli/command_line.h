// Shared by all commands: the form of their help, and strict reading of option values. CLI11 parses the command line,
// but every word that a user reads comes from here or from the command itself.
#ifndef SELFPROJ_HOST_CLI_COMMAND_LINE_H
#define SELFPROJ_HOST_CLI_COMMAND_LINE_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "host/images/prepared_images.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::cli {

// A command as its help describes it.
struct CommandText {
  std::string name;
  std::string purpose;  // one sentence; the list of commands shows it, too
  std::string details;  // paragraphs, and lists whose lines begin with "- "; may be empty
  // Shell lines that work one after another in an empty folder, each group under a comment "# What it does." A comment
  // that ends in "(needs hardware)", "(needs your files)" or "(takes minutes)" says why a test does not run its lines.
  std::string examples;
};

// Adds a command to a program or to another command.
CLI::App* add_command(CLI::App& parent, const CommandText& text);

// Sets the same texts for a program.
void set_text(CLI::App& app, const CommandText& text);

// These commands of the program stand under this heading in its help. Commands of a heading follow each other.
void set_heading(CLI::App& program, const std::string& heading, const std::vector<std::string>& commands);

// Options added from now on appear in this group of the command's help.
void begin_group(CLI::App& command, const std::string& name);

// Reads an option also by its old name, for one version and with a note on standard error. No help shows that name.
void add_old_name(CLI::App& command, const std::string& old_name, const std::string& name);

// Checks of option values, for Option::transform. Each value must be a decimal number, without a sign if the
// minimum is 0, without other text around it, and without overflow, infinity or NaN. They pass on the number without
// leading zeros, because CLI11 would read 010 as octal.
constexpr std::int64_t kNoLimit = std::numeric_limits<std::int64_t>::max();
CLI::Validator whole_number(std::int64_t min, std::int64_t max = kNoLimit);
CLI::Validator real_number(double min, double max);
CLI::Validator number_above_zero(double max = 1e6);

// One of these names. For Option::check.
CLI::Validator one_of(const std::vector<std::string>& names);

// The names of an option's one_of; none if it has no such check.
std::vector<std::string> names_of_choice(const CLI::Option& option);

// Numbers of mm with commas between them, ascending. Throws UserError, naming the option, if one is not a number, not
// within 1e5 of 0, or not greater than the one before.
std::vector<double> ascending_lengths(const char* option, const std::string& text);

// Adds an option or argument for files. It gives the files of the command line in the order of in_listed_order.
CLI::Option* add_files(CLI::App& command, const std::string& name, std::vector<std::string>& files,
                       const std::string& text);

// Adds --unchecked.
CLI::Option* add_unchecked_option(CLI::App& command, bool& unchecked);

// Throws CheckFailed, naming `subject`, if images, options or geometry contradict each other; with `unchecked`, and for
// a doubt, there is a note. Empty texts: nothing.
void refuse_contradiction(const std::string& subject, const std::string& contradiction, bool unchecked);
void note_doubt(const std::string& subject, const std::string& doubt);

// Adds --channel and --shift: how the pixels of images become one channel of 8 bits.
void add_pixel_options(CLI::App& command, images::PixelOptions& pixels);

// What of a column is measured, as --select, --gap and --rows say it; nothing where an option is not given.
struct SelectOptions {
  std::string select = {};
  std::optional<int> gap = {};
  std::string rows = {};

  // Changes `measure` where an option says so. Throws UserError about --rows, or about --gap without the strongest run.
  void apply(model::Measure& measure, int max_rows = spec::kRowLimit) const;
};

// Adds --select, --gap and --rows. `by_default` is what --help says of --select; with kRigsSelect of all three.
inline constexpr const char* kRigsSelect = "the rig's";
void add_select_options(CLI::App& command, SelectOptions& options, const std::string& by_default = "all");

// Adds --channel, --shift, --roi and --transpose.
void add_preparation_options(CLI::App& command, images::Preparation& preparation);

}  // namespace selfproj::cli

#endif  // SELFPROJ_HOST_CLI_COMMAND_LINE_H
