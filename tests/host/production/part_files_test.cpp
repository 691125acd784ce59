// Tests the files of a run with parts where they cannot all be written.
#include "host/production/part_files.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <chrono>
#include <csignal>
#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

#include "tests/cli/program.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// No file can become larger, which acts like a full disk.
class SmallFiles {
 public:
  explicit SmallFiles(rlim_t bytes) : handler_(std::signal(SIGXFSZ, SIG_IGN)) {
    getrlimit(RLIMIT_FSIZE, &before_);
    rlimit small = before_;
    small.rlim_cur = bytes;
    setrlimit(RLIMIT_FSIZE, &small);
  }
  SmallFiles(const SmallFiles&) = delete;
  SmallFiles& operator=(const SmallFiles&) = delete;
  ~SmallFiles() {
    setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  void (*handler_)(int);
  rlimit before_{};
};

production::PartResult part(std::uint64_t number, production::Verdict verdict) {
  production::PartResult result;
  result.number = number;
  result.verdict = verdict;
  result.reason = std::string(300, 'r');
  return result;
}

production::PlacedMaps maps(int side) {
  return {.grid = {.rows = side, .columns = side, .pitch_mm = 0.5},
          .height = images::FloatImage(side, side),
          .difference = images::FloatImage(side, side)};
}

std::vector<std::string> lines_of(const fs::path& file) {
  std::istringstream text(read_text(file));
  std::vector<std::string> lines;
  for (std::string line; std::getline(text, line);) {
    lines.push_back(line);
  }
  return lines;
}

// A device that cannot be opened leaves no folder behind, so that the command can be given again.
TEST(PartFiles, NothingStaysOfARunThatNeverBegan) {
  const ScratchFolder scratch;
  fs::create_directory(scratch / "empty");
  for (const char* const name : {"today", "empty"}) {
    const production::PartFiles files(scratch / name, 10);
    EXPECT_TRUE(fs::exists(scratch / name / "parts.jsonl"));
  }
  EXPECT_EQ(scratch.names(), std::vector<std::string>{"empty"});
  EXPECT_TRUE(fs::is_empty(scratch / "empty"));
}

// Lines, rows and folders are whole or are left out, and go on where there is room again. The statistics are there.
TEST(PartFiles, OnAFullDisk) {
  constexpr rlim_t kSmall = 70'000;
  constexpr std::uint64_t kParts = 400;
  const ScratchFolder scratch;
  const fs::path folder = scratch / "today";
  production::PartFiles files(folder, 1000);
  {
    const SmallFiles full(kSmall);
    files.add(part(1, production::Verdict::bad), maps(200));  // its maps are too large
    std::string error;
    while ((error = error_of([&] { files.check(); })) == "none") {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_NE(error.find("part_000001"), std::string::npos) << error;
    for (std::uint64_t number = 2; number <= kParts; ++number) {
      files.add(part(number, production::Verdict::good), maps(1));
    }
  }
  files.add(part(kParts + 1, production::Verdict::bad), maps(200));
  files.add(part(kParts + 2, production::Verdict::good), maps(1));
  files.finish({});

  std::uint64_t before = 0;
  const std::vector<std::string> lines = lines_of(folder / "parts.jsonl");
  for (const std::string& line : lines) {
    const auto number = nlohmann::json::parse(line).at("part").get<std::uint64_t>();
    EXPECT_GT(number, before);
    before = number;
  }
  EXPECT_EQ(before, kParts + 2) << "there was room again";
  EXPECT_LT(lines.size(), kParts);
  EXPECT_GT(lines.size(), 100U);
  const std::vector<std::string> rows = lines_of(folder / "parts.csv");
  EXPECT_EQ(std::count(rows.back().begin(), rows.back().end(), ','), std::count(rows[0].begin(), rows[0].end(), ','));
  EXPECT_FALSE(fs::exists(folder / "part_000001"));
  EXPECT_TRUE(fs::exists(folder / "part_000401" / "difference.png"));
  EXPECT_TRUE(fs::exists(folder / "statistics.json"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder), {}), 4) << "nothing else is left";
  EXPECT_NE(error_of([&] { files.check(); }), "none");
}

}  // namespace
}  // namespace selfproj::test
