// The book of the thesis: its page has everything, and its figures show what it says.
#include "lab/thesis.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <regex>
#include <set>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/report/map_picture.h"
#include "lab/relief_picture.h"
#include "lab/thesis_figures.h"
#include "selfproj/images/float_image.h"

namespace selfproj::test {
namespace {

std::string page() {
  std::ifstream file(SELFPROJ_SOURCE_DIR "/docs/thesis.md");
  return {std::istreambuf_iterator<char>(file), {}};
}

// The first cells of all rows.
std::set<std::string> items() {
  std::set<std::string> found;
  for (const lab::ThesisTable& table : lab::tables_of_page(page())) {
    for (const lab::ThesisRow& row : table.rows) {
      EXPECT_EQ(row.cells.size(), table.header.size());
      found.insert(row.cells.front());
    }
  }
  return found;
}

TEST(ThesisPage, HasEveryFigureAndTableOfChapters3And4) {
  const std::set<std::string> found = items();
  for (int i = 1; i <= 9; ++i) {
    EXPECT_TRUE(found.contains(fmt::format("3.{}", i))) << i;
  }
  for (int i = 1; i <= 20; ++i) {
    EXPECT_TRUE(found.contains(fmt::format("4.{}", i))) << i;
  }
  for (const char* table : {"table 3.1", "table 4.1", "table 4.2"}) {
    EXPECT_TRUE(found.contains(table)) << table;
  }
}

TEST(ThesisPage, NamesTheFiguresThatAreMadeAndNoOthers) {
  const std::string text = page();
  const std::regex command("thesis --figure (\\d\\.\\d+)`");
  std::set<std::string> named;
  for (std::sregex_iterator at(text.begin(), text.end(), command); at != std::sregex_iterator(); ++at) {
    named.insert((*at)[1]);
  }
  const std::vector<std::string> made = lab::ThesisFigures::numbers();
  EXPECT_EQ(named, std::set<std::string>(made.begin(), made.end()));
}

// The commands of a row have their minutes, one by one, and those that were measured are commands of the page.
TEST(ThesisPage, SaysTheMinutesOfEachCommand) {
  int rows = 0;
  for (const lab::ThesisTable& table : lab::tables_of_page(page())) {
    const auto column = [&](const char* name) {
      return static_cast<std::size_t>(std::find(table.header.begin(), table.header.end(), name) - table.header.begin());
    };
    if (column("minutes") == table.header.size()) {
      continue;
    }
    for (const lab::ThesisRow& row : table.rows) {
      const std::string& made = row.cells.at(column("made by"));
      const std::string& minutes = row.cells.at(column("minutes"));
      if (minutes != "–") {  // not measured
        EXPECT_EQ(std::count(minutes.begin(), minutes.end(), ','), std::count(made.begin(), made.end(), ','))
            << row.cells.front() << ": " << made << ": " << minutes;
        ++rows;
      }
    }
  }
  EXPECT_GT(rows, 25);
  std::ifstream file(SELFPROJ_SOURCE_DIR "/lab/results/thesis_times.json");
  const std::string text = page();
  for (const auto& [name, measured] : nlohmann::json::parse(file).at("results").items()) {
    EXPECT_NE(text.find("`" + measured.at("command").get<std::string>()), std::string::npos) << name;
  }
}

TEST(ThesisPage, IsReadAsPlainText) {
  const std::vector<lab::ThesisTable> tables = lab::tables_of_page(
      "# Book\n\ntext | no table\n\n## One\n\n| of | what |\n|---|---|\n| 3.9 | `a` [b](c.md) x \\| y |\n\n| n "
      "|\n|---|\n");
  ASSERT_EQ(tables.size(), 2U);
  EXPECT_EQ(tables[0].title, "One");
  ASSERT_EQ(tables[0].rows.size(), 1U);
  EXPECT_EQ(tables[0].rows[0].cells, (std::vector<std::string>{"3.9", "a b x | y"}));
}

TEST(ThesisFigures, SayWhatTheThesisSays) {
  int images = 0;
  lab::ThesisFigures figures([&] { ++images; });
  std::map<std::string, double> values;
  for (const char* number : {"3.4", "3.5", "4.10"}) {
    const lab::ThesisFigure figure = figures.make(number);
    EXPECT_EQ(figure.number, number);
    EXPECT_FALSE(figure.pictures.empty() && figure.plots.empty());
    EXPECT_GT(std::count(figure.csv.begin(), figure.csv.end(), '\n'), 100);
    values.insert(figure.values.begin(), figure.values.end());
  }
  EXPECT_EQ(images, 2);  // the mountain is measured once for both
  EXPECT_LT(values["width_self_projected_px"], 3);
  EXPECT_GT(values["width_straight_px"], 55);
  EXPECT_LT(values["self_projected_mm"], 0.36);
  EXPECT_NEAR(values["centre_at_0_mm"], 1.79, 0.01);
  EXPECT_THROW(figures.make("3.1"), std::invalid_argument);
}

// The nearest surface is seen: of a step, its face towards the viewer and not the ground behind it.
TEST(ReliefPicture, ShowsASurfaceAndLeavesGapsOpen) {
  images::FloatImage map(40, 60, 0);
  for (int r = 10; r < 30; ++r) {
    for (int c = 20; c < 40; ++c) {
      map.row(r)[c] = 10;
    }
  }
  const report::MapScale scale{report::ColourMap::sequential, 0, 10};
  const std::string whole = lab::relief_png(map, scale, {1, 1}, 1);
  EXPECT_EQ(whole.substr(1, 3), "PNG");
  map.row(35)[5] = images::kNoValue;
  EXPECT_NE(lab::relief_png(map, scale, {1, 1}, 1), whole);
  EXPECT_NE(lab::relief_png(map, scale, {1, 1}, 3), lab::relief_png(map, scale, {1, 1}, 1));
  EXPECT_THROW(lab::relief_png({1, 5, 0}, scale, {1, 1}, 1), std::invalid_argument);
  EXPECT_THROW(lab::relief_png({5, 5, images::kNoValue}, scale, {1, 1}, 1), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
