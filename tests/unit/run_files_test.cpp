#include "host/files/run_files.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <string>

#include "host/files/input_file.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {
namespace fs = std::filesystem;

class RunFilesTest : public ::testing::Test {
 protected:
  void SetUp() override {
    write_text(scratch_ / "in", "input");
    fs::create_hard_link(scratch_ / "in", scratch_ / "hard");
    fs::create_symlink("in", scratch_ / "soft");
  }
  void TearDown() override { EXPECT_EQ(read_text(scratch_ / "in"), "input"); }

  const ScratchFolder scratch_;
  const files::RunFiles files_;
};

TEST_F(RunFilesTest, AnOutputFileIsNoInput) {
  EXPECT_EQ(files::read_input(scratch_ / "in", 100), "input");
  for (const char* name : {"in", "hard", "soft", "./in"}) {
    EXPECT_THROW(files::OutputFile(scratch_ / name), UserError) << name;
  }
  EXPECT_NO_THROW(files::OutputFile(scratch_ / "new").write("x"));
}

TEST_F(RunFilesTest, AnInputIsNoOutputThatWasNamedBefore) {
  const files::OutputFile output(scratch_ / "soft");
  EXPECT_THROW(files::read_input(scratch_ / "in", 100), UserError);
}

TEST_F(RunFilesTest, AFileOfAFolderIsNoInput) {
  EXPECT_EQ(files::read_input(scratch_ / "in", 100), "input");
  files::OutputFolder folder(scratch_.path());
  for (const char* name : {"in", "hard", "soft"}) {
    EXPECT_THROW(folder.check(name), UserError) << name;
    EXPECT_THROW(folder.append(name, "x"), UserError) << name;
  }
}

TEST_F(RunFilesTest, AFileOfAFolderIsNoInputThatIsReadLater) {
  files::OutputFolder folder(scratch_.path());
  folder.append("in", "x");
  EXPECT_EQ(files::read_input(scratch_ / "in", 100), "input");
  EXPECT_THROW(folder.commit(), UserError);
}

TEST_F(RunFilesTest, TwoOutputsAreNotOneFile) {
  const files::OutputFile first(scratch_ / "out");
  EXPECT_THROW(files::OutputFile(scratch_ / "." / "out"), UserError);
  files::OutputFolder folder(scratch_.path());
  EXPECT_THROW(folder.append("out", "x"), UserError);
}

TEST_F(RunFilesTest, DevicesAreNotWatched) {
  EXPECT_EQ(files::read_input("/dev/null", 100), "");
  EXPECT_NO_THROW(files::OutputFile("/dev/null").write("x"));
}

TEST_F(RunFilesTest, LimitsOfInputs) {
  EXPECT_THROW(files::read_input(scratch_ / "in", 4), UserError);
  EXPECT_EQ(files::read_input(scratch_ / "in", 5), "input");
  EXPECT_THROW(files::read_input("/dev/zero", 1000), UserError);
  EXPECT_THROW(files::read_input(scratch_.path(), 1000), UserError);
  EXPECT_THROW(files::read_input(scratch_ / "none", 1000), UserError);
}

}  // namespace
}  // namespace selfproj::test
