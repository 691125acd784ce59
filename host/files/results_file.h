// Figures as data: writes the measurements of a benchmark, soak or experiment to results/NAME.json.
#ifndef SELFPROJ_HOST_FILES_RESULTS_FILE_H
#define SELFPROJ_HOST_FILES_RESULTS_FILE_H

#include <nlohmann/json.hpp>
#include <string>

namespace selfproj::files {

// The environment variable that names the folder for results.
inline constexpr const char* kResultsFolder = "SELFPROJ_RESULTS";

// Writes NAME.json into the folder that kResultsFolder names; does nothing if the variable is unset or empty. The file
// holds `results`, what was measured (`about`, one sentence), the command of this process with the settings SELFPROJ_*
// of its environment, the date, the commit and the machine. scripts/results.py writes the same form, and generates the
// tables of the documents from it. Throws UserError if the file cannot be written.
void write_results(const std::string& name, const std::string& about, const nlohmann::ordered_json& results);

}  // namespace selfproj::files

#endif  // SELFPROJ_HOST_FILES_RESULTS_FILE_H
