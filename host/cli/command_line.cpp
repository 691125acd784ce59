#include "host/cli/command_line.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <optional>
#include <string>
#include <vector>

#include "host/files/notes.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "host/images/natural_order.h"
#include "host/images/prepared_images.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_runs.h"

namespace selfproj::cli {
namespace {

std::string expected(const std::string& text, const std::string& what) {
  return fmt::format("is '{}'; {} is expected", text, what);
}

// "1e6", not "1e+06".
std::string short_text(double number) {
  std::string text = fmt::format("{:g}", number);
  const std::size_t e = text.find("e+");
  return e == std::string::npos ? text : text.substr(0, e + 1) + text.substr(text.find_first_not_of('0', e + 2));
}

// The words for a range in the help, and in an error.
struct RangeText {
  std::string in_help;
  std::string in_error;
};

RangeText range_of(const std::string& min, const std::string& max) {
  const std::string range = fmt::format("{} to {}", min, max);
  return {range, "from " + range};
}

CLI::Validator real_validator(const RangeText& range, double min, double max, bool min_is_allowed) {
  return CLI::Validator(
      [=](std::string& text) {
        const std::optional<double> number = files::number_of_text<double>(text);
        const bool good = number && *number <= max && (min_is_allowed ? *number >= min : *number > min);
        return good ? std::string() : expected(text, "a number " + range.in_error);
      },
      range.in_help);
}

}  // namespace

CLI::App* add_command(CLI::App& parent, const CommandText& text) {
  CLI::App* command = parent.add_subcommand(text.name);
  set_text(*command, text);
  return command;
}

void set_text(CLI::App& app, const CommandText& text) {
  app.description(text.details.empty() ? text.purpose : text.purpose + "\n\n" + text.details);
  app.footer(text.examples);
  for (CLI::Option* option : app.get_options()) {  // --help, --version
    option->group("Help");
  }
}

void set_heading(CLI::App& program, const std::string& heading, const std::vector<std::string>& commands) {
  for (const std::string& command : commands) {
    program.get_subcommand(command)->group(heading);
  }
}

void begin_group(CLI::App& command, const std::string& name) { command.option_defaults()->group(name); }

void add_old_name(CLI::App& command, const std::string& old_name, const std::string& name) {
  CLI::Option* const option = command.get_option(name);
  command
      .add_option_function<std::string>(old_name,
                                        [=](const std::string& value) {
                                          fmt::print(stderr, "note: {} is now {}\n", old_name, name);
                                          option->add_result(value);
                                        })
      ->trigger_on_parse()
      ->group("");
}

CLI::Validator whole_number(std::int64_t min, std::int64_t max) {
  const RangeText range = max == kNoLimit ? RangeText{fmt::format("{} or more", min), fmt::format("of {} or more", min)}
                                          : range_of(std::to_string(min), std::to_string(max));
  return CLI::Validator(
      [=](std::string& text) {
        const std::optional<std::int64_t> number = files::number_of_text<std::int64_t>(text);
        if (!number || *number < min || *number > max) {
          return expected(text, "a whole number " + range.in_error);
        }
        text = std::to_string(*number);
        return std::string();
      },
      range.in_help);
}

CLI::Validator real_number(double min, double max) {
  return real_validator(range_of(short_text(min), short_text(max)), min, max, true);
}

CLI::Validator number_above_zero(double max) {
  return real_validator({"above 0", "above 0, at most " + short_text(max)}, 0, max, false);
}

namespace {

constexpr const char* kOneOf = "one of";  // the name of its validators, by which they are found again

}  // namespace

CLI::Validator one_of(const std::vector<std::string>& names) {
  std::string list;
  for (std::size_t i = 0; i < names.size(); ++i) {
    list += (i == 0 ? "" : i + 1 == names.size() ? " or " : ", ") + names[i];
  }
  return CLI::Validator(
      [=](std::string& text) {
        for (const std::string& name : names) {
          if (text == name) {
            return std::string();
          }
        }
        return expected(text, list);
      },
      list, kOneOf);
}

std::vector<std::string> names_of_choice(const CLI::Option& option) {
  std::vector<std::string> names;
  std::string list;
  try {
    list = const_cast<CLI::Option&>(option).get_validator(kOneOf)->get_description();  // has no const form
  } catch (const CLI::OptionNotFound&) {
    return names;
  }
  for (std::size_t begin = 0; begin < list.size();) {
    const std::size_t comma = std::min(list.find(", ", begin), list.size());
    const std::size_t last = std::min(list.find(" or ", begin), list.size());
    const std::size_t end = std::min(comma, last);
    names.push_back(list.substr(begin, end - begin));
    begin = end + (end == comma ? 2 : 4);
  }
  return names;
}

std::vector<double> ascending_lengths(const char* option, const std::string& text) {
  constexpr double kMost = 1e5;
  std::vector<double> values;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    const std::string entry = text.substr(begin, end - begin);
    const std::optional<double> value = files::number_of_text<double>(entry);
    if (!value || !(std::abs(*value) <= kMost)) {
      throw UserError(option, fmt::format("'{}' is not a number of mm", entry));
    }
    if (!values.empty() && !(*value > values.back())) {
      throw UserError(option,
                      fmt::format("{} follows {}; numbers are expected in ascending order", *value, values.back()));
    }
    values.push_back(*value);
    begin = end + 1;
  }
  return values;
}

CLI::Option* add_files(CLI::App& command, const std::string& name, std::vector<std::string>& files,
                       const std::string& text) {
  return command
      .add_option_function<std::vector<std::string>>(
          name, [&files](const std::vector<std::string>& given) { files = images::in_listed_order(given); }, text)
      ->type_name("FILE");
}

CLI::Option* add_unchecked_option(CLI::App& command, bool& unchecked) {
  return command.add_flag(
      "--unchecked", unchecked,
      "Only warn where the images contradict each other, the options or the geometry. Without it they are refused.");
}

void refuse_contradiction(const std::string& subject, const std::string& contradiction, bool unchecked) {
  if (!contradiction.empty() && !unchecked) {
    throw CheckFailed(fmt::format("{}: {}{} --unchecked goes on all the same", subject, contradiction,
                                  contradiction.ends_with('?') ? "" : ";"));
  }
  note_doubt(subject, contradiction);
}

void note_doubt(const std::string& subject, const std::string& doubt) {
  if (!doubt.empty()) {
    files::note(fmt::format("{}: warning: {}", subject, doubt));
  }
}

void add_pixel_options(CLI::App& command, images::PixelOptions& pixels) {
  command
      .add_option("--channel", pixels.channel,
                  "Channel to take of colour images. Without it, colour images are refused.")
      ->check(one_of(images::channel_names()))
      ->type_name("CHANNEL");
  command
      .add_option(
          "--shift", pixels.shift,
          "Images of more than 8 bits: a value becomes value / 2^N, rounded down; 4 takes values of 12 bits, 8 "
          "of 16. Without it they are refused, unless the file says its bits, as a PGM does. With a --rig of more bits "
          "(measure.pixel_bits) as many are taken, and N is 0 unless values are shifted up.")
      ->transform(whole_number(0, images::kMaxShift))
      ->type_name("N");
}

void SelectOptions::apply(model::Measure& measure, int max_rows) const {
  if (!select.empty()) {
    measure.select = images::select_of(select);
  }
  if (gap) {
    if (measure.select != model::Select::strongest) {
      throw UserError("--gap", "goes only with --select strongest");
    }
    measure.gap = *gap;
  }
  if (measure.select == model::Select::all) {
    measure.gap = 0;
  }
  if (!rows.empty()) {
    measure.window = images::rows_of_text("--rows", rows, max_rows);
  }
}

void add_select_options(CLI::App& command, SelectOptions& options, const std::string& by_default) {
  const bool of_rig = by_default == kRigsSelect;
  command
      .add_option("--select", options.select,
                  "What of a column counts: all lit pixels, or its strongest run, which leaves out what is lit apart "
                  "from the line.")
      ->check(one_of(images::select_names()))
      ->type_name("SELECT")
      ->default_str(by_default);
  command.add_option("--gap", options.gap, "Dark rows that two lit pixels of one run may have between them.")
      ->transform(whole_number(0, model::kMaxGap))
      ->type_name("G")
      ->default_str(of_rig ? by_default : "0");
  command.add_option("--rows", options.rows, "First and last row that count, from 1, such as 10..80.")
      ->type_name("A..B")
      ->default_str(of_rig ? by_default : "all");
}

void add_preparation_options(CLI::App& command, images::Preparation& preparation) {
  add_pixel_options(command, preparation.pixels);
  command
      .add_option(
          "--roi", preparation.roi,
          "Part of the images to take: columns, rows, and its left and upper pixel from 0, such as 320x60+0+40.")
      ->type_name("WxH+X+Y")
      ->default_str("all");
  command.add_flag("--transpose", preparation.transpose,
                   "Exchange rows and columns, for lines that run from top to bottom. --roi comes first.");
}

}  // namespace selfproj::cli
