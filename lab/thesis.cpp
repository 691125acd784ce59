#include "lab/thesis.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <ctime>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <regex>
#include <sstream>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/files/results_file.h"
#include "host/report/page.h"
#include "host/report/report.h"
#include "lab/thesis_figures.h"
#include "lab/thesis_page.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"

namespace selfproj::lab {
namespace {

struct ThesisOptions {
  std::vector<std::string> figures;
  bool all = false;
  bool list = false;
  std::string out = "thesis";
};

std::string trimmed(const std::string& text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == std::string::npos ? "" : text.substr(first, text.find_last_not_of(' ') + 1 - first);
}

// The cells of a row "| a | b |".
std::vector<std::string> cells_of(const std::string& line) {
  std::vector<std::string> cells;
  std::string cell;
  for (std::size_t i = 1; i < line.size(); ++i) {
    if (line[i] == '\\' && i + 1 < line.size() && line[i + 1] == '|') {
      cell += line[++i];
    } else if (line[i] == '|') {
      cells.push_back(trimmed(cell));
      cell.clear();
    } else {
      cell += line[i];
    }
  }
  return cells;
}

std::string plain(const std::string& text) {
  static const std::regex link(R"(\[([^\]]*)\]\([^)]*\))");
  static const std::regex mark(R"([`*]|<[^>]*>)");
  return std::regex_replace(std::regex_replace(text, link, "$1"), mark, "");
}

// The figure that a row is of: "3.9" of "figure 3.9a".
std::string figure_of(const ThesisRow& row) {
  static const std::regex number(R"(^(\d\.\d+))");
  std::smatch found;
  const std::string& first = row.cells.front();
  return std::regex_search(first, found, number) ? found[1].str() : "";
}

// What the page says of one figure: each of its rows as a table of two columns, which any screen is wide enough for.
std::vector<report::ReportTable> rows_of_figure(const std::vector<ThesisTable>& tables, const std::string& number) {
  std::vector<report::ReportTable> found;
  for (const ThesisTable& of : tables) {
    for (const ThesisRow& row : of.rows) {
      if (figure_of(row) != number) {
        continue;
      }
      report::ReportTable& table = found.emplace_back();
      table.title = row.cells.at(0) + ": " + row.cells.at(1);
      if (row.cells.back().find("ours: ") != std::string::npos) {
        table.note = "The pictures are of an ideal world; \"ours\" is of the whole experiment.";
      }
      for (std::size_t i = 2; i < row.cells.size() && i < of.header.size(); ++i) {
        if (row.cells[i] == "–") {
          continue;
        }
        table.rows.push_back({of.header[i], row.cells[i]});
      }
    }
  }
  return found;
}

std::string page_name(const std::string& number) { return "figure-" + number + ".html"; }

void write_figure(const std::vector<ThesisTable>& tables, const ThesisFigure& figure, double seconds,
                  files::OutputFolder& folder) {
  if (figure.pictures.empty() &&
      std::all_of(figure.plots.begin(), figure.plots.end(), [](const auto& plot) { return plot.traces.empty(); })) {
    throw std::logic_error("figure " + figure.number + " shows nothing");
  }
  report::ReportPage page;
  page.links = {{"the book", "index.html"}};
  page.title = "Figure " + figure.number;
  page.subtitle = figure.caption;
  page.plots = figure.plots;
  page.pictures = figure.pictures;
  page.tables = rows_of_figure(tables, figure.number);
  page.settings = {{"command", "command", "selfproj-lab thesis --figure " + figure.number},
                   {"core_seconds", "made in",
                    fmt::format("{:.1f} s of one processor core, less what figures before it had made", seconds)}};
  if (!figure.source.empty()) {
    page.settings.push_back({"experiment", "the whole experiment", "selfproj-lab experiment " + figure.source});
  }
  for (std::size_t i = 0; i < figure.pictures.size(); ++i) {
    folder.append(fmt::format("figure-{}-{}.png", figure.number, i + 1), figure.pictures[i].png);
  }
  for (const auto& [name, map] : figure.maps) {
    folder.append(name + ".tiff", images::encode_float_tiff(name + ".tiff", map));
    page.links.emplace_back(name + ".tiff", name + ".tiff");
  }
  if (!figure.csv.empty()) {
    const std::string file = "figure-" + figure.number + ".csv";
    folder.append(file, figure.csv);
    page.links.emplace_back(file, file);
  }
  folder.append(page_name(figure.number), report::page_html(page));
}

// On a narrow screen a row of the first page is a block, and its cells say what they are.
constexpr std::string_view kContentsStyle = R"css(<style>
.book th, .book td { text-align: left; min-width: 0; overflow-wrap: anywhere; }
.book td:nth-child(2) { width: 45%; }
.book td:first-child, .book td:nth-child(5), .book th:nth-child(5) { white-space: nowrap; }
@media (max-width: 700px) {
  .book thead { display: none; }
  .book tr { display: block; border-top: 1px solid var(--rule); padding: 10px 0; }
  .book td, .book td:nth-child(2) { display: block; width: auto; border: 0; padding: 2px 0; }
  .book td[data-name]::before { content: attr(data-name) ": "; color: var(--dim); }
}
</style>
)css";

constexpr std::size_t kColumns = 5;  // of the first page

// The cells of a row as HTML: these, or all there are; the others stand in small type below the second one.
std::string row_html(const std::vector<std::string>& header, const ThesisRow& row, bool is_made) {
  constexpr std::size_t kWhat = 1;
  std::string more;
  for (std::size_t i = kColumns; i < row.cells.size() && i < header.size(); ++i) {
    if (row.cells[i] != "–") {
      more += (more.empty() ? "" : "<br>") + (i > kColumns ? report::escaped(header[i]) + ": " : std::string()) +
              report::escaped(row.cells[i]);
    }
  }
  std::string html = "<tr>";
  for (std::size_t i = 0; i < row.cells.size() && i < kColumns; ++i) {
    const std::string text = report::escaped(row.cells[i]);
    html += i > kWhat ? "<td data-name=\"" + report::escaped(header[i]) + "\">" : std::string("<td>");
    html += i == 0 && is_made ? "<a href=\"" + page_name(figure_of(row)) + "\">" + text + "</a>" : text;
    html += i == kWhat && !more.empty() ? "<div class=\"dim small\">" + more + "</div></td>" : "</td>";
  }
  return html + "</tr>";
}

// The first page of the book: the tables, with a link at each figure that was made.
std::string contents_html(const std::vector<ThesisTable>& tables, const std::vector<std::string>& made) {
  std::string html;
  report::add_head(html, "The thesis, figure by figure",
                   "A Study on High-Speed Three-Dimensional Shape Inspection Based on Self-Projection Method, chapters "
                   "3 and 4, repeated in simulation",
                   {});
  html += kContentsStyle;
  for (const ThesisTable& table : tables) {
    html += "<section class=\"card\"><h2>" + report::escaped(table.title) + "</h2><table class=\"book\"><thead><tr>";
    for (std::size_t i = 0; i < table.header.size() && i < kColumns; ++i) {
      html += "<th>" + report::escaped(table.header[i]) + "</th>";
    }
    html += "</tr></thead><tbody>";
    for (const ThesisRow& row : table.rows) {
      html += row_html(table.header, row, std::find(made.begin(), made.end(), figure_of(row)) != made.end());
    }
    html += "</tbody></table></section>";
  }
  report::add_foot(html, {}, {});
  return html;
}

// The numbers of these figures, in their order, each once; (a), (b) and so on are parts of a figure.
std::vector<std::string> numbers_of(const std::vector<std::string>& figures, const std::vector<std::string>& all) {
  std::vector<std::string> numbers;
  for (const std::string& figure : figures) {
    std::string number = figure;
    while (!number.empty() && !(number.back() >= '0' && number.back() <= '9')) {
      number.pop_back();
    }
    if (std::find(all.begin(), all.end(), number) == all.end()) {
      throw UserError("--figure", fmt::format("is '{}'; those that are made are {}; docs/thesis.md says what became of "
                                              "the others",
                                              figure, fmt::join(all, ", ")));
    }
    if (std::find(numbers.begin(), numbers.end(), number) == numbers.end()) {
      numbers.push_back(number);
    }
  }
  return numbers;
}

void run_thesis(const ThesisOptions& options) {
  std::vector<std::string> numbers = ThesisFigures::numbers();
  if (options.list) {
    fmt::print("{}\n", fmt::join(numbers, "\n"));
    return;
  }
  if (options.all == !options.figures.empty()) {
    throw UserError("--figure, --all", "give one of them");
  }
  if (!options.all) {
    numbers = numbers_of(options.figures, numbers);
  }
  files::OutputFolder folder(options.out);
  const std::vector<ThesisTable> tables = tables_of_page(kThesisPage);
  nlohmann::ordered_json record;
  std::string current;
  std::optional<cli::Progress> progress;
  std::size_t images = 0;
  std::size_t begun = 0;
  ThesisFigures figures([&] { progress->update(++images); });
  for (const std::string& number : numbers) {
    const std::clock_t begin = std::clock();
    progress.emplace(fmt::format("figure {} ({} of {}), image", number, ++begun, numbers.size()), 0);
    images = 0;
    const ThesisFigure figure = figures.make(number);
    progress.reset();
    // Of all processors: how long it takes depends on how many there are, and on who else uses them.
    const double seconds = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    write_figure(tables, figure, seconds, folder);
    record[number]["core_seconds"] = seconds;
    for (const auto& [key, value] : figure.values) {
      record[number][key] = value;
    }
    fmt::print("figure {}: {} ({:.0f} s of one core)\n", number, figure.caption, seconds);
  }
  folder.append("index.html", contents_html(tables, numbers));
  folder.commit();
  if (options.all) {
    files::write_results("thesis_book", "The figures of the thesis, made again in simulation", record);
  }
  fmt::print("{} {} → {}/index.html\n", numbers.size(), numbers.size() == 1 ? "figure" : "figures", options.out);
}

}  // namespace

std::vector<ThesisTable> tables_of_page(const std::string& markdown) {
  std::vector<ThesisTable> tables;
  std::istringstream lines(markdown);
  std::string title;
  bool open = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("#")) {
      title = trimmed(line.substr(line.find_first_not_of('#')));
    }
    if (!line.starts_with("|")) {
      open = false;
      continue;
    }
    if (line.starts_with("|--")) {
      continue;
    }
    std::vector<std::string> cells = cells_of(line);
    std::transform(cells.begin(), cells.end(), cells.begin(), plain);
    if (open) {
      tables.back().rows.push_back({std::move(cells)});
    } else {
      tables.push_back({title, std::move(cells), {}});
      open = true;
    }
  }
  return tables;
}

void add_thesis_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "thesis",
       .purpose = "Makes the figures of the thesis again, with what it says and what we found beside them.",
       .details = "The folder of --out gets a page for each figure, figure-3.9.html, its pictures as PNG, its maps "
                  "as TIFF, the numbers behind it as figure-3.9.csv, and index.html: every figure, table and "
                  "published number of chapters 3 and 4, met or not and why. That table is docs/thesis.md as it "
                  "was when the program was built.\n\n"
                  "The figures are made in an ideal world by a rig that is known (null tests). The figures of "
                  "merit in the table come from the whole experiments, whose command stands on each page.",
       .examples = R"(
# The errors of quantization on three planes, figure 4.10.
selfproj-lab thesis --figure 4.10 --out figure

# The whole book (takes minutes)
selfproj-lab thesis --all --out thesis
)"});
  const auto options = std::make_shared<ThesisOptions>();
  cli::begin_group(*command, "What is made");
  command->add_option("--figure", options->figures, "One figure, such as 3.9, or several.")->type_name("NUMBER");
  command->add_flag("--all", options->all, "All of them.");
  command->add_flag("--list", options->list, "Only list the figures that can be made.");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder of the book.")->type_name("DIR")->capture_default_str();
  command->callback([options] { run_thesis(*options); });
}

}  // namespace selfproj::lab
