#include "host/io/output_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <string>
#include <vector>

#include "host/io/user_error.h"
#include "tests/cli/program.h"

namespace selfproj {
namespace {
namespace fs = std::filesystem;

std::vector<std::string> names_in(const fs::path& folder) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  return names;
}

TEST(OutputFolder, AppearsWithTheCommit) {
  const test::ScratchFolder scratch;
  OutputFolder output(scratch / "results/");
  output.append("a", "1");
  output.append("b", "2");
  output.append("a", "3");
  EXPECT_FALSE(fs::exists(scratch / "results"));
  output.commit();
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"results"});
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "a"), "13");
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "b"), "2");
}

TEST(OutputFolder, ReplacesItsFilesAndKeepsOthers) {
  const test::ScratchFolder scratch;
  fs::create_directory(scratch / "results");
  test::write_text(scratch / "results" / "a", "old");
  test::write_text(scratch / "results" / "mine", "kept");
  OutputFolder output(scratch / "results");
  output.append("a", "new");
  output.append("b", "more");
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "a"), "old");
  output.commit();
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b", "mine"}));
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "a"), "new");
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "mine"), "kept");
}

TEST(OutputFolder, WithoutACommitNothingRemains) {
  const test::ScratchFolder scratch;
  fs::create_directory(scratch / "there");
  test::write_text(scratch / "there" / "a", "old");
  {
    OutputFolder fresh(scratch / "fresh");
    fresh.append("a", "1");
    OutputFolder there(scratch / "there");
    there.append("a", "1");
  }
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"there"});
  EXPECT_EQ(names_in(scratch / "there"), std::vector<std::string>{"a"});
  EXPECT_EQ(test::read_text(scratch.path() / "there" / "a"), "old");
}

// The second of three files cannot be put in place: the first one becomes the old one again.
TEST(OutputFolder, AFailureWhileMovingIsUndone) {
  const test::ScratchFolder scratch;
  fs::create_directories(scratch / "results" / "b");
  test::write_text(scratch / "results" / "a", "old");
  {
    OutputFolder output(scratch / "results");
    for (const char* file : {"new", "a", "b", "c"}) {
      output.append(file, "fresh");
    }
    EXPECT_THROW(output.commit(), UserError);
  }
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "a"), "old");
}

TEST(OutputFolder, ImpossibleNamesAreFoundAtOnce) {
  const test::ScratchFolder scratch;
  test::write_text(scratch / "file", "");
  EXPECT_THROW(OutputFolder(""), UserError);
  EXPECT_THROW(OutputFolder(scratch / "file"), UserError);
  EXPECT_THROW(OutputFolder(scratch / "file" / "a"), UserError);
  EXPECT_THROW(OutputFolder(scratch / "no" / "such"), UserError);
  EXPECT_THROW(OutputFolder("/proc/selfproj").append("a", ""), UserError);  // not even root can
  if (geteuid() != 0) {
    fs::create_directory(scratch / "closed");
    fs::permissions(scratch / "closed", fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THROW(OutputFolder(scratch / "closed"), UserError);
    EXPECT_THROW(OutputFolder(scratch / "closed" / "a"), UserError);
  }
}

// If no more can be written (here because of a limit on file sizes, which acts like a full disk), old files stay.
TEST(OutputFolder, AFullDiskLeavesWhatWasThere) {
  const test::ScratchFolder scratch;
  fs::create_directory(scratch / "results");
  test::write_text(scratch / "results" / "a", "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  std::string message;
  try {
    OutputFolder output(scratch / "results");
    output.append("a", std::string(600, '1'));
    output.append("a", std::string(600, '2'));
  } catch (const UserError& error) {
    message = error.what();
  }
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("results/a: "), std::string::npos) << message;
  EXPECT_EQ(names_in(scratch / "results"), std::vector<std::string>{"a"});
  EXPECT_EQ(test::read_text(scratch.path() / "results" / "a"), "old");
}

}  // namespace
}  // namespace selfproj
