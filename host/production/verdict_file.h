// Files of verdict tables: YAML, to be looked at and changed.
#ifndef SELFPROJ_HOST_PRODUCTION_VERDICT_FILE_H
#define SELFPROJ_HOST_PRODUCTION_VERDICT_FILE_H

#include <string>

#include "host/production/verdict_table.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// The table's text, and the table of such a text. Throws UserError with `source`, line, key and reason if it is none,
// or a value is not one that the circuit takes.
std::string to_yaml(const VerdictTable& table);
VerdictTable parse_verdict_table(const std::string& yaml, const std::string& source);
VerdictTable load_verdict_table(const std::string& file);

// Throws UserError, naming `source`, if limits, shifted as the settings say, are not rows of the frames. In a table
// that was read they are.
void check_rows(const VerdictTable& table, const std::string& source);

// Throws UserError, naming `source`, if frames of this rig are not those of the table.
void check_verdict_table(const VerdictTable& table, const rig::Rig& rig, const std::string& source);

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_VERDICT_FILE_H
