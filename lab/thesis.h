// The book of the thesis: each figure of its chapters 3 and 4 again, with what the thesis says and what we found.
#ifndef SELFPROJ_LAB_THESIS_H
#define SELFPROJ_LAB_THESIS_H

#include <string>
#include <vector>

namespace CLI {  // NOLINT(readability-identifier-naming): the library's
class App;
}

namespace selfproj::lab {

// A row of a table of docs/thesis.md: its cells, of which the first says which figure, table or equation it is of.
struct ThesisRow {
  std::vector<std::string> cells;
};
struct ThesisTable {
  std::string title;  // the heading above it
  std::vector<std::string> header;
  std::vector<ThesisRow> rows;
};

// The tables of a page in Markdown, with links and code as plain text.
std::vector<ThesisTable> tables_of_page(const std::string& markdown);

// Adds `thesis` to the program.
void add_thesis_command(CLI::App& app);

}  // namespace selfproj::lab

#endif  // SELFPROJ_LAB_THESIS_H
