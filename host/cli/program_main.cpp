#include "host/cli/program_main.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>
#include <new>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/help_text.h"
#include "host/files/file_descriptor.h"
#include "host/files/notes.h"
#include "host/files/run_files.h"
#include "host/files/stop_signal.h"
#include "host/files/text.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::cli {
namespace {

constexpr int kFailed = 1;    // a check or the program itself failed
constexpr int kBadInput = 2;  // errors that the user can fix

// Prints one line whatever the message contains (a file name may contain a line break). Nobody may be there to read it.
int report(const std::string& program, std::string message, int status) {
  std::replace_if(
      message.begin(), message.end(), [](char c) { return c >= '\0' && c < ' '; }, ' ');
  static_cast<void>(std::fputs(fmt::format("{}: {}\n", program, files::shown(message)).c_str(), stderr));
  return status;
}

// The command that the command line names.
const CLI::App* command_given(const CLI::App& program) {
  const CLI::App* command = &program;
  while (!command->get_subcommands().empty()) {
    command = command->get_subcommands().front();
  }
  return command;
}

std::string full_name(const CLI::App* command) {
  const CLI::App* parent = command->get_parent();
  return parent == nullptr ? command->get_name() : full_name(parent) + " " + command->get_name();
}

// How many letters must be changed, added, left out or exchanged with their neighbours to make one word of the other
// (Damerau and Levenshtein).
std::size_t letters_between(const std::string& one, const std::string& other) {
  std::vector<std::vector<std::size_t>> d(one.size() + 1, std::vector<std::size_t>(other.size() + 1));
  for (std::size_t i = 0; i <= one.size(); ++i) {
    for (std::size_t j = 0; j <= other.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (one[i - 1] == other[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && one[i - 1] == other[j - 2] && one[i - 2] == other[j - 1]) {
        d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
      }
    }
  }
  return d[one.size()][other.size()];
}

// " (did you mean --threshold?)" if one of the command's names is near the word, which is none of them; else empty.
std::string suggestion(const CLI::App& command, const std::string& typed) {
  const std::string word = typed.substr(0, typed.find('='));
  std::vector<std::string> names;
  if (word.starts_with("-")) {
    for (const CLI::Option* option : command.get_options()) {
      for (const std::string& name : option->get_group().empty() ? std::vector<std::string>() : option->get_lnames()) {
        names.push_back("--" + name);
      }
    }
  } else {
    for (const CLI::App* inner : command.get_subcommands([](const CLI::App*) { return true; })) {
      names.push_back(inner->get_name());
    }
  }
  const std::size_t letters = word.size() - std::min(word.find_first_not_of('-'), word.size());
  std::string best;
  std::size_t least = std::max<std::size_t>(letters / 3 + 1, 2);  // as far away it may be another word
  for (const std::string& name : names) {
    const std::size_t away = letters_between(word, name);
    if (away < least) {
      least = away;
      best = name;
    }
  }
  return best.empty() ? "" : fmt::format(" (did you mean {}?)", best);
}

// "--a requires --b" becomes "--a: goes only with --b".
std::string with_relation(const std::string& text, const std::string& word, const std::string& relation) {
  const std::size_t at = text.find(" " + word + " ");
  return at == std::string::npos ? text
                                 : text.substr(0, at) + ": " + relation + " " + text.substr(at + word.size() + 2);
}

// Rewords an error of CLI11: the option first, then the reason.
std::string explained(const CLI::App& program, const CLI::ParseError& error) {
  const CLI::App* command = command_given(program);
  const std::string see = fmt::format("; see {} --help", full_name(command));
  std::string text = error.what();
  if (const std::vector<std::string> unknown = program.remaining(true); !unknown.empty()) {
    const bool option = unknown.front().starts_with('-');
    const bool no_command = command->get_require_subcommand_min() > 0;
    return unknown.front() +
           (option       ? ": unknown option"
            : no_command ? ": unknown command"
                         : ": unexpected argument") +
           suggestion(*command, unknown.front()) + see;
  }
  if (dynamic_cast<const CLI::RequiredError*>(&error) != nullptr) {
    return (text == "A subcommand is required" ? "a command is missing" : with_relation(text, "is", "is")) + see;
  }
  if (dynamic_cast<const CLI::RequiresError*>(&error) != nullptr) {
    return with_relation(text, "requires", "goes only with");
  }
  if (dynamic_cast<const CLI::ExcludesError*>(&error) != nullptr) {
    return with_relation(text, "excludes", "cannot be combined with");
  }
  if (dynamic_cast<const CLI::ArgumentMismatch*>(&error) != nullptr) {
    if (const std::size_t end = text.find(" was given a disallowed flag override"); end != std::string::npos) {
      return (end == 1 ? "-" : "--") + text.substr(0, end) + ": takes no value" + see;
    }
    const std::size_t colon = text.find(": ");
    return colon == std::string::npos ? text + see : text.substr(0, colon) + ": a value is missing" + see;
  }
  return text;
}

// With --check-usage as the first word, a command line is only parsed and not run. The tests of the documents use this.
// The callbacks stay, because they own the variables into which the options are read.
void parse_check_usage(CLI::App& program, std::vector<std::string>& words) {
  if (!words.empty() && words.front() == "--check-usage") {
    words.erase(words.begin());
    program.parse_complete_callback([] { throw CLI::Success(); });
  }
}

// --check=3 is an error. Without this, CLI11 reads a value of a flag as a number or a truth value.
void refuse_values_of_flags(CLI::App& app) {
  for (CLI::Option* option : app.get_options([](CLI::Option*) { return true; })) {
    if (option->get_items_expected_max() == 0) {
      option->disable_flag_override();
    }
  }
  for (CLI::App* command : app.get_subcommands([](CLI::App*) { return true; })) {
    refuse_values_of_flags(*command);
  }
}

// The text of an exception, unless it is one that a library writes for programmers: those have no place here, and a
// user can only report them.
std::string of_ourselves(const std::string& text) {
  for (const auto& [begin, library] :
       {std::pair{"OpenCV(", "OpenCV"}, {"[json.exception", "the library for JSON"}, {"yaml-cpp", "yaml-cpp"}}) {
    if (text.starts_with(begin)) {
      return fmt::format(
          "{} could not work with this input, and selfproj did not expect that; please report the command "
          "and the input",
          library);
    }
  }
  return text;
}

// CLI11 reads [a,b] as a list. No value of ours is one, but a path may be called so; the same path with ./ before it is
// none.
void keep_brackets(std::string& word) {
  const std::size_t value = word.starts_with("--") ? std::min(word.find('=') + 1, word.size()) : 0;
  if (word.ends_with(']') && word.substr(value).starts_with('[')) {
    word.insert(value, "./");
  }
}

int run_commands(const CommandText& text, const std::function<void(CLI::App&)>& add_commands, int argc, char** argv) {
  const std::string& name = text.name;
  try {
    CLI::App app("", name);
    app.formatter(std::make_shared<HelpFormatter>());
    app.require_subcommand(1);
    app.set_help_flag("-h,--help", "Print this help and end.");
    app.set_version_flag("--version",
                         fmt::format("{} {}, specification {}.{}, hash 0x{:08X}", name, SELFPROJ_VERSION,
                                     spec::kVersion >> 8U, spec::kVersion & 0xFFU, spec::kHash),
                         "Print the versions of the program and of the packets' specification, and end.");
    set_text(app, text);
    add_commands(app);
    refuse_values_of_flags(app);
    std::vector<std::string> words(argv + 1, argv + argc);
    std::for_each(words.begin(), words.end(), keep_brackets);
    if (words == std::vector<std::string>{"--help-json"}) {  // for docs/site/commands.py
      fmt::print("{}", help_json(app));
      return 0;
    }
    parse_check_usage(app, words);
    // A note is printed once, however often its file is read.
    files::note_sink() = [name, said = std::set<std::string>()](const std::string& line) mutable {
      if (said.insert(line).second) {
        report(name, line, 0);
      }
    };
    std::reverse(words.begin(), words.end());  // CLI11 takes the words from the back
    try {
      app.parse(std::move(words));
    } catch (const CLI::Success& success) {  // --help, --version
      return app.exit(success);
    } catch (const CLI::ParseError& error) {
      return report(name, explained(app, error), kBadInput);
    }
  } catch (const UserError& error) {
    return report(name, error.what(), kBadInput);
  } catch (const std::filesystem::filesystem_error& error) {
    return report(name, error.path1().string() + ": " + error.code().message(), kBadInput);
  } catch (const std::bad_alloc&) {
    return report(name, "there is not enough memory for this input", kFailed);
  } catch (const std::exception& error) {
    return report(name, of_ourselves(error.what()), kFailed);
  }
  return 0;
}

// If a standard descriptor is closed, the first file that is opened would get its number, and printed text would go
// into this file. Opens /dev/null instead, so that reading gives nothing and writing to standard output fails.
void open_standard_descriptors() {
  for (const int number : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO}) {
    if (fcntl(number, F_GETFD) < 0 && errno == EBADF) {
      // open() takes the lowest free number.
      static_cast<void>(open("/dev/null", number == STDERR_FILENO ? O_WRONLY : O_RDONLY));
    }
  }
}

// Flushes standard output, and returns whether everything could be printed.
bool flush_output() {
  errno = 0;
  const bool stream = static_cast<bool>(std::cout.flush());
  return std::fflush(stdout) == 0 && std::ferror(stdout) == 0 && stream;
}

// Calls `body`, which prints what it has to say and gives the exit status, and gives the program's:
//  - standard output that cannot be written to (a full disk, a closed pipe or descriptor) makes status 1 of 0, with one
//    line on standard error;
//  - no output may be one of the inputs (run_files.h);
//  - SIGINT, SIGTERM and SIGHUP leave nothing temporary behind; a closed pipe and a limit on sizes of files (SIGPIPE,
//    SIGXFSZ) are errors of the writing, not signals.
int run_as_program(const std::string& name, const std::function<int()>& body) {
  open_standard_descriptors();
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  files::tidy_up_on_signals();
  const files::RunFiles files;
  const int status = body();
  if (!flush_output() && status == 0) {
    static_cast<void>(std::fputs(
        fmt::format("{}: standard output: {}\n", name, files::error_text(errno != 0 ? errno : EIO)).c_str(), stderr));
    return 1;
  }
  return status;
}

}  // namespace

int program_main(const CommandText& text, const std::function<void(CLI::App&)>& add_commands, int argc, char** argv) {
  return run_as_program(text.name, [&] { return run_commands(text, add_commands, argc, argv); });
}

}  // namespace selfproj::cli
