#include "host/files/results_file.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <numeric>
#include <sstream>
#include <string>
#include <string_view>
#include <thread>
#include <vector>

#include "host/files/json_text.h"
#include "selfproj/files/user_error.h"

namespace selfproj::files {
namespace {

std::string text_of(const std::string& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

// Returns the standard output of a command without the final line break.
std::string output_of(const std::string& command) {
  const auto close = [](std::FILE* pipe) { pclose(pipe); };
  const std::unique_ptr<std::FILE, decltype(close)> pipe(popen(command.c_str(), "r"), close);
  std::string text;
  std::array<char, 256> part{};
  while (pipe && std::fgets(part.data(), part.size(), pipe.get()) != nullptr) {
    text += part.data();
  }
  return text.substr(0, text.find('\n'));
}

// The path of this program. Builds lie inside the sources, in build/release/... . Linux adds a note where it was built
// again while it ran.
std::filesystem::path program() {
  constexpr std::string_view kReplaced = " (deleted)";
  std::string path = std::filesystem::read_symlink("/proc/self/exe").string();
  if (path.ends_with(kReplaced)) {
    path.resize(path.size() - kReplaced.size());
  }
  return path;
}

std::string git(const std::string& words) {
  return output_of("git -C '" + program().parent_path().string() + "' " + words + " 2>/dev/null");
}

// The settings of this project in the environment, as typed before a command. Folders and files of this machine are
// left out.
std::string own_settings() {
  std::vector<std::string> settings;
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string setting = *entry;
    if (setting.starts_with("SELFPROJ_") && setting.find('/') == std::string::npos &&
        !setting.starts_with(std::string(kResultsFolder) + "=")) {
      settings.push_back(setting + " ");
    }
  }
  std::sort(settings.begin(), settings.end());
  return std::accumulate(settings.begin(), settings.end(), std::string());
}

// The command of this process, as typed in the root of the sources.
std::string own_command() {
  const std::filesystem::path root = git("rev-parse --show-toplevel");
  std::istringstream words(text_of("/proc/self/cmdline"));
  std::string command;
  for (std::string word; std::getline(words, word, '\0');) {
    if (command.empty() || word.starts_with('/')) {
      const std::filesystem::path path = command.empty() ? program() : std::filesystem::path(word);
      const std::filesystem::path relative = path.lexically_relative(root);
      word = (!relative.empty() && *relative.begin() != ".." ? relative : path.filename()).string();
    }
    command += (command.empty() ? "" : " ") + word;
  }
  return own_settings() + command;
}

// The commit of the sources, with "+" if tracked files other than results and documents differ from it.
std::string commit() {
  const std::string head = git("rev-parse --short=10 HEAD");
  const bool differs =
      !git("status --porcelain -uno -- ':/' ':(top,exclude)results' ':(top,exclude)lab/results' ':(top,exclude)*.md'")
           .empty();
  return head.empty() ? "unknown" : head + (differs ? "+" : "");
}

std::string today() {
  const std::time_t now = std::chrono::system_clock::to_time_t(std::chrono::system_clock::now());
  std::tm parts{};
  gmtime_r(&now, &parts);
  std::array<char, 16> text{};
  std::strftime(text.data(), text.size(), "%Y-%m-%d", &parts);
  return text.data();
}

double rounded(double value) { return std::round(10 * value) / 10; }

// Rounds every number to six digits, more than any measurement has.
void shorten(nlohmann::ordered_json& value) {
  if (value.is_number_float()) {
    std::array<char, 32> text{};
    std::snprintf(text.data(), text.size(), "%.6g", value.get<double>());
    value = std::strtod(text.data(), nullptr);
  }
  if (value.is_structured()) {
    for (nlohmann::ordered_json& part : value) {
      shorten(part);
    }
  }
}

std::size_t depth_of(const nlohmann::ordered_json& value) {
  std::size_t depth = 0;
  for (const nlohmann::ordered_json& inner : value) {
    depth = std::max(depth, inner.is_structured() ? depth_of(inner) : 0);
  }
  return depth + 1;
}

bool has_table(const nlohmann::ordered_json& value) {
  return value.is_structured() && (value.contains("rows") || std::any_of(value.begin(), value.end(), has_table));
}

// Returns a value as JSON with one record a line: an element of a list, a row of a table, and anything that is nested
// at most two levels deep is one line. scripts/results.py writes the same.
std::string text_of_json(const nlohmann::ordered_json& value, std::size_t indent = 0, bool is_record = false,
                         bool is_table = false) {
  const bool is_short = value.is_structured() && (is_record || (indent > 0 && depth_of(value) <= 2));
  if (!value.is_structured() || (is_short && !is_table && !has_table(value))) {
    return json_text(value);
  }
  std::string text = value.is_object() ? "{" : "[";
  for (const auto& [key, inner] : value.items()) {
    text += (text.size() == 1 ? "\n" : ",\n") + std::string(indent + 1, ' ');
    text += value.is_object() ? json_text(nlohmann::ordered_json(key)) + ": " : "";
    text += text_of_json(inner, indent + 1, value.is_array(), key == "rows");
  }
  return text + "\n" + std::string(indent, ' ') + (value.is_object() ? "}" : "]");
}

nlohmann::ordered_json machine() {
  const std::string facts = text_of("/proc/cpuinfo");
  const std::string key = "model name\t: ";
  const std::size_t at = facts.find(key);
  std::array<double, 1> load{};
  const bool has_load = getloadavg(load.data(), 1) == 1;
  constexpr double kGib = 1024.0 * 1024 * 1024;
  return {{"cpu",
           at == std::string::npos ? "unknown" : facts.substr(at + key.size(), facts.find('\n', at) - at - key.size())},
          {"cores", std::thread::hardware_concurrency()},
          {"memory_gib",
           rounded(static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGE_SIZE)) / kGib)},
          {"load", has_load ? rounded(load[0]) : 0}};
}

}  // namespace

void write_results(const std::string& name, const std::string& about, const nlohmann::ordered_json& results) {
  const char* folder = std::getenv(kResultsFolder);
  if (folder == nullptr || *folder == '\0') {
    return;
  }
  nlohmann::ordered_json envelope = {{"about", about},     {"command", own_command()}, {"date", today()},
                                     {"commit", commit()}, {"machine", machine()},     {"results", results}};
  shorten(envelope["results"]);
  const std::filesystem::path file = std::filesystem::path(folder) / (name + ".json");
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  std::ofstream out(file, std::ios::binary);
  out << text_of_json(envelope) << '\n';
  out.close();
  if (!out) {
    throw UserError(file.string(), "cannot be written");
  }
}

}  // namespace selfproj::files
