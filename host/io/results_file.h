// Figures as data: what a benchmark, soak or experiment measured, in results/NAME.json.
#ifndef SELFPROJ_HOST_IO_RESULTS_FILE_H
#define SELFPROJ_HOST_IO_RESULTS_FILE_H

#include <nlohmann/json.hpp>
#include <string>

namespace selfproj {

// The environment variable that names the folder for results.
inline constexpr const char* kResultsFolder = "SELFPROJ_RESULTS";

// Writes NAME.json into the folder that kResultsFolder names; does nothing where the variable is unset or empty.
// Around `results` stand what was measured (`about`, one sentence), the command of this process, the date, the commit
// and the machine. scripts/results.py writes the same envelope and makes the tables of the documents of it.
// Throws UserError where the file cannot be written.
void write_results(const std::string& name, const std::string& about, const nlohmann::ordered_json& results);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_IO_RESULTS_FILE_H
