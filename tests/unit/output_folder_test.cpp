#include "host/files/output_folder.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/ptrace.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <filesystem>
#include <functional>
#include <set>
#include <string>
#include <vector>

#include "host/files/output_file.h"
#include "host/files/stop_signal.h"
#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
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
  const ScratchFolder scratch;
  files::OutputFolder output(scratch / "results/");
  output.append("a", "1");
  output.append("b", "2");
  output.append("a", "3");
  EXPECT_FALSE(fs::exists(scratch / "results"));
  output.commit();
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"results"});
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(read_text(scratch.path() / "results" / "a"), "13");
  EXPECT_EQ(read_text(scratch.path() / "results" / "b"), "2");
}

// Whoever reads a series takes all of its files.
TEST(OutputFolder, NoSeriesOfTwoRuns) {
  const ScratchFolder scratch;
  const auto run = [&](int count) {
    files::OutputFolder output(scratch / "results");
    for (int i = 0; i < count; ++i) {
      output.append("frame_0" + std::to_string(i) + ".png", std::to_string(count));
    }
    output.commit();
  };
  run(3);
  fs::create_directory(scratch / "results" / "frame_07.png.d");
  write_text(scratch / "results" / "frame_07.txt", "another kind");
  write_text(scratch / "results" / "frame_7.png", "one digit");
  run(3);
  EXPECT_EQ(error_of([&] {
              run(2);
            }).find((scratch / "results").string() + ": holds numbered files of another run, such as frame_02.png"),
            0U);
  EXPECT_EQ(read_text(scratch.path() / "results" / "frame_00.png"), "3") << "nothing is written";
  run(4);
}

TEST(OutputFolder, ReplacesItsFilesAndKeepsOthers) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "results");
  write_text(scratch / "results" / "a", "old");
  write_text(scratch / "results" / "mine", "kept");
  files::OutputFolder output(scratch / "results");
  output.append("a", "new");
  output.append("b", "more");
  EXPECT_EQ(read_text(scratch.path() / "results" / "a"), "old");
  output.commit();
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b", "mine"}));
  EXPECT_EQ(read_text(scratch.path() / "results" / "a"), "new");
  EXPECT_EQ(read_text(scratch.path() / "results" / "mine"), "kept");
}

TEST(OutputFolder, WithoutACommitNothingRemains) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "there");
  write_text(scratch / "there" / "a", "old");
  {
    files::OutputFolder fresh(scratch / "fresh");
    fresh.append("a", "1");
    files::OutputFolder there(scratch / "there");
    there.append("a", "1");
  }
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"there"});
  EXPECT_EQ(names_in(scratch / "there"), std::vector<std::string>{"a"});
  EXPECT_EQ(read_text(scratch.path() / "there" / "a"), "old");
}

// The second of three files cannot be put in place, so the first one is replaced by the old one again.
TEST(OutputFolder, AFailureWhileMovingIsUndone) {
  const ScratchFolder scratch;
  fs::create_directories(scratch / "results" / "b");
  write_text(scratch / "results" / "a", "old");
  {
    files::OutputFolder output(scratch / "results");
    for (const char* file : {"new", "a", "b", "c"}) {
      output.append(file, "fresh");
    }
    EXPECT_THROW(output.commit(), UserError);
  }
  EXPECT_EQ(names_in(scratch / "results"), (std::vector<std::string>{"a", "b"}));
  EXPECT_EQ(read_text(scratch.path() / "results" / "a"), "old");
}

TEST(OutputFolder, ImpossibleNamesAreFoundAtOnce) {
  const ScratchFolder scratch;
  write_text(scratch / "file", "");
  EXPECT_THROW(files::OutputFolder(""), UserError);
  EXPECT_THROW(files::OutputFolder(scratch / "file"), UserError);
  EXPECT_THROW(files::OutputFolder(scratch / "file" / "a"), UserError);
  EXPECT_THROW(files::OutputFolder("/proc/selfproj").append("a", ""), UserError);  // not even root can
  if (geteuid() != 0) {
    fs::create_directory(scratch / "closed");
    fs::permissions(scratch / "closed", fs::perms::owner_read | fs::perms::owner_exec);
    EXPECT_THROW(files::OutputFolder(scratch / "closed"), UserError);
    EXPECT_THROW(files::OutputFolder(scratch / "closed" / "a"), UserError);
  }
}

TEST(OutputFolder, MissingFoldersAboveAreMadeWithIt) {
  const ScratchFolder scratch;
  {
    files::OutputFolder output(scratch / "a" / "b" / "results");
    output.append("x", "1");
    EXPECT_FALSE(fs::exists(scratch / "a"));
  }
  EXPECT_TRUE(scratch.names().empty());
  files::OutputFolder output(scratch / "a" / "b" / "results");
  output.append("x", "1");
  output.commit();
  EXPECT_EQ(read_text(scratch.path() / "a" / "b" / "results" / "x"), "1");
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"a"});
}

// Other contents of the folder stay: inner folders, links, permissions. The folder keeps its own permissions.
TEST(OutputFolder, TheRestOfTheFolderIsKept) {
  const ScratchFolder scratch;
  const fs::path results = scratch / "results";
  fs::create_directories(results / "inner" / "deeper");
  write_text(results / "inner" / "deeper" / "mine", "kept");
  write_text(results / "old", "old");
  fs::create_symlink("inner/deeper/mine", results / "link");
  fs::permissions(results, fs::perms::owner_all | fs::perms::group_all);
  fs::permissions(results / "inner", fs::perms::owner_all);
  const auto inode = [](const fs::path& file) {
    struct stat status {};
    stat(file.c_str(), &status);
    return status.st_ino;
  };
  const ino_t before = inode(results / "inner" / "deeper" / "mine");
  files::OutputFolder output(results);
  output.append("old", "new");
  output.commit();
  EXPECT_EQ(read_text(results / "old"), "new");
  EXPECT_EQ(read_text(results / "link"), "kept");
  EXPECT_EQ(inode(results / "inner" / "deeper" / "mine"), before);
  EXPECT_EQ(fs::status(results).permissions(), fs::perms::owner_all | fs::perms::group_all);
  EXPECT_EQ(fs::status(results / "inner").permissions(), fs::perms::owner_all);
  EXPECT_EQ(names_in(results), (std::vector<std::string>{"inner", "link", "old"}));
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"results"});
}

// A program whose current folder it is (a shell, for example) keeps it, even behind a link.
TEST(OutputFolder, TheCurrentFolderIsWrittenInPlace) {
  const ScratchFolder scratch;
  const fs::path before = fs::current_path();
  fs::current_path(scratch.path());
  write_text(scratch / "a", "old");
  {
    files::OutputFolder output(".");
    output.append("a", "new");
    output.commit();
  }
  EXPECT_EQ(read_text("a"), "new");
  fs::current_path(before);
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"a"});
}

// Three writers write at the same time, again and again. The files always belong to one of them.
TEST(OutputFolder, ManyWritersAtOnce) {
  const ScratchFolder scratch;
  const fs::path results = scratch / "results";
  const std::vector<std::string> files{"a", "b", "c", "d", "e"};
  std::vector<pid_t> writers;
  for (const char* mine : {"1", "2", "3"}) {
    const pid_t child = fork();
    if (child == 0) {
      for (int i = 0; i < 40; ++i) {
        files::OutputFolder output(results);
        for (const std::string& file : files) {
          output.append(file, mine);
        }
        output.commit();
      }
      _exit(0);
    }
    writers.push_back(child);
  }
  // A reader that has opened the folder sees the files of one writer.
  int looks = 0;
  for (std::size_t ended = 0; ended < writers.size();) {
    const int folder = open(results.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
    std::set<std::string> contents;
    for (const std::string& file : files) {
      char byte = 0;
      const int descriptor = openat(folder, file.c_str(), O_RDONLY | O_CLOEXEC);
      if (descriptor >= 0 && read(descriptor, &byte, 1) == 1) {
        contents.insert(std::string(1, byte));
      }
      close(descriptor);
    }
    close(folder);
    EXPECT_LE(contents.size(), 1U);
    ++looks;
    int status = 0;
    while (waitpid(-1, &status, WNOHANG) > 0) {
      EXPECT_EQ(status, 0);
      ++ended;
    }
  }
  EXPECT_GT(looks, 3);
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"results"});
  EXPECT_EQ(names_in(results), files);
}

// Runs `what` in a traced process and kills it at its system call number `call`. Returns whether it came so far.
bool killed_at(int call, const std::function<void()>& what) {
  const pid_t child = fork();
  if (child == 0) {
    ptrace(PTRACE_TRACEME, 0, nullptr, nullptr);
    raise(SIGSTOP);
    what();
    _exit(0);
  }
  int status = 0;
  waitpid(child, &status, 0);
  for (int stop = 0; WIFSTOPPED(status) && stop < 2 * call; ++stop) {  // each call stops twice
    ptrace(PTRACE_SYSCALL, child, nullptr, nullptr);
    waitpid(child, &status, 0);
  }
  if (WIFSTOPPED(status)) {
    kill(child, SIGKILL);
    waitpid(child, &status, 0);
    return true;
  }
  EXPECT_EQ(status, 0);
  return false;
}

// Whenever a program is killed, a folder holds its old files or the new ones, and the next program tidies up.
TEST(OutputFolder, KilledAtAnyMoment) {
  const ScratchFolder scratch;
  const fs::path results = scratch / "results";
  const std::vector<std::string> files{"a", "b", "c"};
  const auto write_all = [&](const char* text) {
    files::OutputFolder output(results);
    for (const std::string& file : files) {
      output.append(file, text);
    }
    output.commit();
  };
  write_all("old");
  int calls = 1;
  int kept = 0;
  for (; killed_at(calls, [&] { write_all("new"); }); ++calls) {
    std::set<std::string> contents;
    for (const std::string& file : files) {
      contents.insert(fs::exists(results / file) ? read_text(results / file) : "missing");
    }
    ASSERT_EQ(contents.size(), 1U) << "old and new files after " << calls << " system calls";
    kept += contents.contains("old") ? 1 : 0;
    write_all("old");
    ASSERT_EQ(scratch.names(), std::vector<std::string>{"results"}) << calls;
  }
  EXPECT_GT(kept, 20);
  EXPECT_LT(kept, calls - 1) << "some kills come after the exchange";
}

// The next program that writes there removes the files of a killed one. A folder of a running program stays.
TEST(OutputFolder, WhatAKillLeftIsTakenAway) {
  const ScratchFolder scratch;
  const pid_t child = fork();
  if (child == 0) {
    files::OutputFolder output(scratch / "results");
    output.append("a", "1");
    kill(getpid(), SIGKILL);
  }
  waitpid(child, nullptr, 0);
  ASSERT_EQ(scratch.names().size(), 1U) << "the kill left its folder";
  files::OutputFolder living(scratch / "other");
  living.append("a", "1");
  ASSERT_EQ(scratch.names().size(), 1U);
  files::OutputFolder output(scratch / "results");
  output.append("a", "1");
  output.commit();
  living.commit();
  EXPECT_EQ(scratch.names(), (std::vector<std::string>{"other", "results"}));
}

// A signal that ends the program also removes temporary files.
TEST(OutputFolder, SignalsLeaveNothingBehind) {
  const ScratchFolder scratch;
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) {
    const pid_t child = fork();
    if (child == 0) {
      files::tidy_up_on_signals();
      files::OutputFolder output(scratch / "results");
      output.append("a/b", "1");
      raise(number);
      _exit(0);
    }
    int status = 0;
    waitpid(child, &status, 0);
    EXPECT_TRUE(WIFSIGNALED(status) && WTERMSIG(status) == number) << status;
    EXPECT_TRUE(scratch.names().empty()) << number;
  }
}

// What was written whole before the disk was full can be kept.
TEST(OutputStream, CommitsTheFirstBytesOnAFullDisk) {
  const ScratchFolder scratch;
  write_text(scratch / "out", "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const files::OutputFile file(scratch / "out");
  files::OutputStream stream(file);
  stream.append(std::string(600, '1'));
  const std::string message = error_of([&] { stream.append(std::string(600, '2')); });
  EXPECT_EQ(read_text(scratch / "out"), "old");
  stream.commit_first(600);
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("out: "), std::string::npos) << message;
  EXPECT_EQ(read_text(scratch / "out"), std::string(600, '1')) << "nothing of the piece that was torn";
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"out"});
}

// If no more can be written (here because of a limit on file sizes, which acts like a full disk), old files stay.
TEST(OutputFolder, AFullDiskLeavesWhatWasThere) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "results");
  write_text(scratch / "results" / "a", "old");
  rlimit before{};
  ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
  rlimit small = before;
  small.rlim_cur = 1000;
  auto* const handler = std::signal(SIGXFSZ, SIG_IGN);
  ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
  const std::string message = error_of([&] {
    files::OutputFolder output(scratch / "results");
    output.append("a", std::string(600, '1'));
    output.append("a", std::string(600, '2'));
  });
  setrlimit(RLIMIT_FSIZE, &before);
  std::signal(SIGXFSZ, handler);
  EXPECT_NE(message.find("results/a: "), std::string::npos) << message;
  EXPECT_EQ(names_in(scratch / "results"), std::vector<std::string>{"a"});
  EXPECT_EQ(read_text(scratch.path() / "results" / "a"), "old");
}

}  // namespace
}  // namespace selfproj::test
