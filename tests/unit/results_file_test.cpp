#include "host/files/results_file.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

using Json = nlohmann::ordered_json;

class ResultsFile : public ::testing::Test {
 protected:
  void TearDown() override { unsetenv(files::kResultsFolder); }

  static void name_folder(const std::string& folder) { setenv(files::kResultsFolder, folder.c_str(), 1); }

  ScratchFolder folder_;
};

// The same keys in the same order as scripts/results.py writes them.
TEST_F(ResultsFile, HasTheEnvelope) {
  name_folder(folder_ / "results");
  files::write_results("speed", "How fast it is", {{"per_s", 38834.2}, {"steps", {0.1234567891, 3}}});
  const Json file = Json::parse(read_text(folder_ / "results/speed.json"));
  std::vector<std::string> keys;
  for (const auto& entry : file.items()) {
    keys.push_back(entry.key());
  }
  EXPECT_EQ(keys, (std::vector<std::string>{"about", "command", "date", "commit", "machine", "results"}));
  EXPECT_EQ(file["about"], "How fast it is");
  EXPECT_EQ(file["command"].get<std::string>().find("/tmp"), std::string::npos);
  EXPECT_NE(file["command"].get<std::string>().find("unit_io"), std::string::npos);
  EXPECT_EQ(file["date"].get<std::string>().size(), std::string("2026-01-02").size());
  EXPECT_GE(file["machine"]["cores"], 1);
  EXPECT_GT(file["machine"]["memory_gib"], 0);
  EXPECT_TRUE(file["machine"].contains("cpu") && file["machine"].contains("load"));
  EXPECT_EQ(file["results"], (Json{{"per_s", 38834.2}, {"steps", {0.123457, 3}}}));
}

// One record a line, as scripts/results.py writes it too.
TEST_F(ResultsFile, IsCompact) {
  name_folder(folder_ / "results");
  files::write_results("speed", "",
                       {{"a", {{"b", {1, 2}}}},
                        {"list", {{{"x", {{"y", {{"z", 1}}}}}}}},
                        {"deep", {{"x", {{"y", {{"z", 1}}}}}}},
                        {"table", {{"header", {"mm"}}, {"rows", {{"0.1"}, {"0.2"}}}}}});
  EXPECT_TRUE(read_text(folder_ / "results/speed.json").ends_with(R"(
 "results": {
  "a": {"b":[1,2]},
  "list": [
   {"x":{"y":{"z":1}}}
  ],
  "deep": {
   "x": {"y":{"z":1}}
  },
  "table": {
   "header": ["mm"],
   "rows": [
    ["0.1"],
    ["0.2"]
   ]
  }
 }
}
)"));
}

// A run that was made larger by a setting can be repeated; paths of this machine are nobody's business.
TEST_F(ResultsFile, CommandHasTheSettings) {
  name_folder(folder_ / "results");
  setenv("SELFPROJ_TEST_SCANS", "100", 1);
  setenv("SELFPROJ_TEST_FILE", "/somewhere/file", 1);
  files::write_results("speed", "", {});
  unsetenv("SELFPROJ_TEST_SCANS");
  unsetenv("SELFPROJ_TEST_FILE");
  const auto command = Json::parse(read_text(folder_ / "results/speed.json"))["command"].get<std::string>();
  EXPECT_NE(command.find("SELFPROJ_TEST_SCANS=100 "), std::string::npos) << command;
  EXPECT_LT(command.find("SELFPROJ_TEST_SCANS=100 "), command.find("unit_io"));
  EXPECT_EQ(command.find("SELFPROJ_TEST_FILE"), std::string::npos) << command;
  EXPECT_EQ(command.find("SELFPROJ_RESULTS"), std::string::npos) << command;
}

TEST_F(ResultsFile, IsNotWrittenUnlessAFolderIsNamed) {
  unsetenv(files::kResultsFolder);
  files::write_results("speed", "", {{"per_s", 1}});
  name_folder("");
  files::write_results("speed", "", {{"per_s", 1}});
  EXPECT_EQ(folder_.names(), std::vector<std::string>{});
}

TEST_F(ResultsFile, ThatCannotBeWrittenIsAnError) {
  write_text(folder_ / "file", "");
  name_folder(folder_ / "file");
  EXPECT_THROW(files::write_results("speed", "", {{"per_s", 1}}), UserError);
}

}  // namespace
}  // namespace selfproj::test
