#include "host/cli/help_text.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "host/files/json_text.h"

namespace selfproj::cli {
namespace {

constexpr std::size_t kWidth = 100;
constexpr std::size_t kTextColumn = 26;  // column in which the texts of options begin

// Characters on a terminal: code points.
std::size_t width_of(const std::string& text) {
  return static_cast<std::size_t>(
      std::count_if(text.begin(), text.end(), [](char c) { return (static_cast<unsigned char>(c) & 0xC0U) != 0x80U; }));
}

// Wraps the words into lines of at most kWidth characters. The first line continues one with `used` characters; the
// others begin with `indent` spaces.
std::string wrapped(const std::string& text, std::size_t indent, std::size_t used) {
  std::istringstream words(text);
  std::string result;
  std::string word;
  bool first = true;
  while (words >> word) {
    const std::size_t needed = width_of(word) + (first ? 0 : 1);
    if (!first && used + needed > kWidth) {
      result += "\n" + std::string(indent, ' ');
      used = indent + width_of(word);
    } else {
      result += first ? "" : " ";
      used += needed;
    }
    result += word;
    first = false;
  }
  return result + "\n";
}

// Paragraphs and list items, one in each line of the result.
std::vector<std::string> paragraphs_of(const std::string& text) {
  std::istringstream lines(text);
  std::vector<std::string> paragraphs;
  bool open = false;
  for (std::string line; std::getline(lines, line);) {
    const bool item = line.starts_with("- ");
    if (line.empty()) {
      open = false;
    } else if (open && !item) {
      paragraphs.back() += " " + line;
    } else {
      paragraphs.push_back(line);
      open = true;
    }
  }
  return paragraphs;
}

struct Texts {
  std::string purpose;
  std::vector<std::string> details;
};

Texts texts_of(const CLI::App& app) {
  std::vector<std::string> paragraphs = paragraphs_of(app.get_description());
  Texts texts;
  if (!paragraphs.empty()) {
    texts.purpose = paragraphs.front();
    texts.details.assign(paragraphs.begin() + 1, paragraphs.end());
  }
  return texts;
}

std::string examples_of(const CLI::App& app) {
  const std::string footer = app.get_footer();
  const std::size_t first = footer.find_first_not_of('\n');
  return first == std::string::npos ? "" : footer.substr(first, footer.find_last_not_of('\n') + 1 - first);
}

bool takes_value(const CLI::Option& option) { return option.get_items_expected_max() > 0; }

bool takes_several(const CLI::Option& option) {
  return option.get_expected_max() >= CLI::detail::expected_max_vector_size;
}

// CLI11 appends the descriptions of the validators to the type, each after a colon.
std::string value_name(const CLI::Option& option) {
  const std::string name = option.get_type_name();
  return takes_value(option) ? name.substr(0, name.find(':')) : "";
}

std::string limits(const CLI::Option& option) {
  const std::string name = option.get_type_name();
  const std::size_t colon = name.find(':');
  return takes_value(option) && colon != std::string::npos ? name.substr(colon + 1) : "";
}

std::string list_of(const std::set<CLI::Option*>& options) {
  std::set<std::string> names;
  for (const CLI::Option* option : options) {
    names.insert(option->get_name());
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

// The end of an option's text: "[1 to 12; default: 8]".
std::string facts_of(const CLI::Option& option) {
  std::vector<std::string> facts;
  if (option.get_required()) {
    facts.emplace_back("required");
  }
  if (!limits(option).empty()) {
    facts.push_back(limits(option));
  }
  if (takes_value(option) && !option.get_default_str().empty()) {
    facts.push_back("default: " + option.get_default_str());
  }
  if (!option.get_needs().empty()) {
    facts.push_back("needs " + list_of(option.get_needs()));
  }
  if (!option.get_excludes().empty()) {
    facts.push_back("not with " + list_of(option.get_excludes()));
  }
  return facts.empty() ? "" : fmt::format("[{}]", fmt::join(facts, "; "));
}

std::string name_of(const CLI::Option& option) {
  std::string name = option.get_positional() ? option.get_name(true) : option.get_name(false, true);
  name = CLI::detail::find_and_replace(name, ",", ", ");
  if (!option.get_positional() && !value_name(option).empty()) {
    name += " " + value_name(option);
  }
  return takes_several(option) && !name.ends_with("...") ? name + "..." : name;
}

std::vector<const CLI::Option*> options_of(const CLI::App& app, const std::string& group) {
  return app.get_options(
      [&](const CLI::Option* option) { return !option->get_positional() && option->get_group() == group; });
}

std::vector<const CLI::Option*> arguments_of(const CLI::App& app) {
  return app.get_options([](const CLI::Option* option) { return option->get_positional(); });
}

// The groups of a command in the order in which its options were added, the one with --help last.
std::vector<std::string> groups_of(const CLI::App& app) {
  std::vector<std::string> groups = app.get_groups();
  if (app.get_help_ptr() != nullptr) {
    std::stable_partition(groups.begin(), groups.end(),
                          [&](const std::string& group) { return group != app.get_help_ptr()->get_group(); });
  }
  groups.erase(
      std::remove_if(groups.begin(), groups.end(),
                     [&](const std::string& group) { return group.empty() || options_of(app, group).empty(); }),
      groups.end());
  return groups;
}

std::vector<const CLI::App*> commands_of(const CLI::App& app) {
  return app.get_subcommands([](const CLI::App* command) { return !command->get_name().empty(); });
}

// "selfproj-sim decode --bits M --out DIR [options] IMAGE..."
std::string usage_of(const CLI::App& app, const std::string& name) {
  std::string usage = name;
  bool optional = false;
  for (const std::string& group : groups_of(app)) {
    for (const CLI::Option* option : options_of(app, group)) {
      if (option->get_required()) {
        usage += fmt::format(" {} {}", option->get_name(), value_name(*option));
      } else if (option != app.get_help_ptr()) {
        optional = true;
      }
    }
  }
  usage += optional ? " [options]" : "";
  for (const CLI::Option* argument : arguments_of(app)) {
    usage += argument->get_required() ? " " + name_of(*argument) : " [" + name_of(*argument) + "]";
  }
  if (!commands_of(app).empty()) {
    usage += app.get_require_subcommand_min() > 0 ? " COMMAND ..." : " [COMMAND ...]";
  }
  return usage;
}

// An option and its value, then its text, wrapped in its column.
std::string entry(const std::string& name, const std::string& text) {
  std::string line = "  " + name;
  if (width_of(line) + 2 > kTextColumn) {
    line += "\n" + std::string(kTextColumn, ' ');
  } else {
    line += std::string(kTextColumn - width_of(line), ' ');
  }
  return line + wrapped(text, kTextColumn, kTextColumn);
}

std::string option_entry(const CLI::Option& option) {
  return entry(name_of(option), option.get_description() + " " + facts_of(option));
}

nlohmann::json json_of(const CLI::Option& option) {
  return {{"name", name_of(option)},          {"text", option.get_description()},
          {"facts", facts_of(option)},        {"value", value_name(option)},
          {"limits", limits(option)},         {"default", takes_value(option) ? option.get_default_str() : ""},
          {"required", option.get_required()}};
}

void add_json(const CLI::App& app, const std::string& name, nlohmann::json& commands) {
  const Texts texts = texts_of(app);
  nlohmann::json command = {{"name", name},
                            {"purpose", texts.purpose},
                            {"details", texts.details},
                            {"usage", usage_of(app, name)},
                            {"examples", examples_of(app)},
                            {"arguments", nlohmann::json::array()},
                            {"groups", nlohmann::json::array()},
                            {"commands", nlohmann::json::array()}};
  for (const CLI::Option* argument : arguments_of(app)) {
    command["arguments"].push_back(json_of(*argument));
  }
  for (const std::string& group : groups_of(app)) {
    nlohmann::json options = nlohmann::json::array();
    for (const CLI::Option* option : options_of(app, group)) {
      options.push_back(json_of(*option));
    }
    command["groups"].push_back({{"name", group}, {"options", options}});
  }
  for (const CLI::App* inner : commands_of(app)) {
    command["commands"].push_back(name + " " + inner->get_name());
  }
  commands.push_back(command);
  for (const CLI::App* inner : commands_of(app)) {
    add_json(*inner, name + " " + inner->get_name(), commands);
  }
}

}  // namespace

std::string HelpFormatter::make_help(const CLI::App* app, std::string name, CLI::AppFormatMode) const {
  const Texts texts = texts_of(*app);
  std::string help = wrapped(texts.purpose, 0, 0);
  help += "\nUsage: " + wrapped(usage_of(*app, name), 11, 7);
  bool in_list = false;
  for (const std::string& paragraph : texts.details) {
    const bool item = paragraph.starts_with("- ");
    help += item && in_list ? "" : "\n";
    help += wrapped(paragraph, item ? 2 : 0, 0);
    in_list = item;
  }
  if (!arguments_of(*app).empty()) {
    help += "\nArguments:\n";
    for (const CLI::Option* argument : arguments_of(*app)) {
      help += option_entry(*argument);
    }
  }
  if (!commands_of(*app).empty()) {
    help += "\nCommands:\n";
    std::string heading = CLI::App().get_group();  // which the library gives to commands without one
    for (const CLI::App* command : commands_of(*app)) {
      if (command->get_group() != heading) {
        heading = command->get_group();
        help += "  " + heading + ":\n";
      }
      help += entry(command->get_name(), texts_of(*command).purpose);
    }
  }
  for (const std::string& group : groups_of(*app)) {
    help += "\n" + group + ":\n";
    for (const CLI::Option* option : options_of(*app, group)) {
      help += option_entry(*option);
    }
  }
  std::istringstream examples(examples_of(*app));
  help += examples.str().empty() ? "" : "\nExamples:\n";
  for (std::string line; std::getline(examples, line);) {
    help += line.empty() ? "\n" : "  " + line + "\n";
  }
  return help;
}

std::string help_json(const CLI::App& program) {
  nlohmann::json commands = nlohmann::json::array();
  add_json(program, program.get_name(), commands);
  return files::json_text(commands, 1) + "\n";
}

}  // namespace selfproj::cli
