// Tests that a board takes the registers of vectors.
#include "sim/cosim/vector_files.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <string>

#include "model/register_file.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "sim/platform/platform.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

TEST(VectorFiles, ABoardTakesTheRegisters) {
  constexpr int kColumns = 64;
  sim::PlatformOptions options;
  options.settings.columns = kColumns;
  options.settings.rows = 16;
  options.settings.verdict = true;
  options.settings.verdict_settings.width = 4;
  options.limits.resize(1);
  options.limits.front().limits.resize(kColumns, {.low = 128, .high = 1000, .judged = true});
  const ScratchFolder folder;
  const std::string vectors = (folder / "vectors").string();
  sim::VectorFiles(vectors, options).commit();

  model::BoardBuild build;
  build.verdict_log_sections = 0;
  model::RegisterFile registers(build);
  std::ifstream file(vectors + "/registers.hex");
  std::string line;
  std::getline(file, line);  // the comment
  int writes = 0;
  while (std::getline(file, line)) {
    const auto address = static_cast<std::uint32_t>(std::stoul(line.substr(0, 2), nullptr, 16));
    const auto data = static_cast<std::uint32_t>(std::stoul(line.substr(2), nullptr, 16));
    EXPECT_FALSE(registers.write(address, data).error) << line;
    ++writes;
  }
  EXPECT_GT(writes, 2 * kColumns);
  EXPECT_TRUE(registers.settings().verdict);
}

}  // namespace
}  // namespace selfproj::test
