#include "host/cli/completion.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command_line.h"

namespace selfproj::cli {
namespace {

std::vector<const CLI::App*> commands_below(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

// --threshold and the like; old names have no group.
std::vector<std::string> long_options(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) {
      if (!option->get_group().empty()) {
        names.push_back("--" + name);
      }
    }
  }
  return names;
}

// The `case` patterns of what is typed, and what is offered there.
struct Cases {
  std::string paths;     // commands that have commands below them
  std::string commands;  // the words behind each
  std::string options;   // the options of each
  std::string values;    // the words behind an option
};

void add_cases(const CLI::App& app, const std::string& path, Cases& cases) {
  std::vector<std::string> names;
  for (const CLI::App* command : commands_below(app)) {
    names.push_back(command->get_name());
    cases.paths += fmt::format("{}'{} {}'", cases.paths.empty() ? "" : " | ", path, command->get_name());
  }
  auto to = [](std::string& text) { return std::back_inserter(text); };
  if (!names.empty()) {
    fmt::format_to(to(cases.commands), "    '{}') words='{}' ;;\n", path, fmt::join(names, " "));
  }
  fmt::format_to(to(cases.options), "    '{}') words='{}' ;;\n", path, fmt::join(long_options(app), " "));
  for (const CLI::Option* option : app.get_options()) {
    const std::vector<std::string> words = names_of_choice(*option);
    for (const std::string& name : words.empty() ? std::vector<std::string>() : option->get_lnames()) {
      fmt::format_to(to(cases.values), "    '{} --{}') words='{}' ;;\n", path, name, fmt::join(words, " "));
    }
  }
  for (const CLI::App* command : commands_below(app)) {
    add_cases(*command, path + " " + command->get_name(), cases);
  }
}

}  // namespace

std::string bash_completion(const CLI::App& program) {
  const std::string& name = program.get_name();
  Cases cases;
  add_cases(program, name, cases);
  std::string function = "_" + name;
  std::replace(function.begin(), function.end(), '-', '_');
  return fmt::format(R"(# Completion of {0} in bash, written by `{0} completion bash`.
{1}() {{
  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD - 1]}} path={0} words= i
  for ((i = 1; i < COMP_CWORD; ++i)); do
    case "$path ${{COMP_WORDS[i]}}" in
    {2}) path+=" ${{COMP_WORDS[i]}}" ;;
    esac
  done
  case "$path $before" in
{3}  esac
  if [[ -z $words && $word == -* ]]; then
    case $path in
{4}    esac
  elif [[ -z $words && $before != -* ]]; then
    case $path in
{5}    esac
  fi
  mapfile -t COMPREPLY < <(compgen -W "$words" -- "$word")
}}
complete -o default -F {1} {0}
)",
                     name, function, cases.paths, cases.values, cases.options, cases.commands);
}

void add_completion_command(CLI::App& program) {
  const std::string name = program.get_name();
  CLI::App* command =
      add_command(program, {.name = "completion",
                            .purpose = "Prints the completion of commands and options for a shell.",
                            .details = "Bash reads it from a file of this name in "
                                       "~/.local/share/bash-completion/completions, or where it is sourced.",
                            .examples = fmt::format(R"(
# Completion for every new shell of this user.
{0} completion bash > {0}.bash
install -D -m 644 {0}.bash ~/.local/share/bash-completion/completions/{0}
)",
                                                    name)});
  command->group("Shell");
  const auto shell = std::make_shared<std::string>();
  command->add_option("SHELL", *shell, "The shell.")->required()->check(one_of({"bash"}));
  command->callback([&program, shell] { fmt::print("{}", bash_completion(program)); });
}

}  // namespace selfproj::cli
