// Soak of the link: random requests from three hosts, good and malformed, every answer and every register compared with
// the model.
//
//     link_soak [QUESTIONS] [FIRST_SEED]      1,000,000 questions from seed 1 on by default
//
// The last line says what was compared. The first mismatch ends the program with exit status 1.
#include <gtest/gtest.h>

#include <cstdint>
#include <cstdio>
#include <cstdlib>

#include "host/files/results_file.h"
#include "tests/rtl/blocks/link_bench.h"

namespace {

std::uint64_t g_questions = 1'000'000;
std::uint64_t g_seed = 1;

}  // namespace

namespace selfproj::test {
namespace {

TEST(Soak, EveryQuestionIsAnsweredAsTheModelDoes) {
  LinkFigures figures;
  for (std::uint64_t seed = g_seed; figures.questions < g_questions; ++seed) {
    SCOPED_TRACE(::testing::Message() << "seed " << seed << "; repeat with: link_soak 1 " << seed);
    expect_link_equals_model(seed, 1000, figures);
    ASSERT_FALSE(HasFailure());
  }
  std::printf("asked %llu questions, %llu answers, 0 mismatches\n", static_cast<unsigned long long>(figures.questions),
              static_cast<unsigned long long>(figures.answers));
  write_results("link_soak", "The link's RTL against the models, random requests, good and malformed",
                {{"questions", figures.questions}, {"answers", figures.answers}, {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test

int main(int argc, char** argv) {
  ::testing::InitGoogleTest(&argc, argv);
  if (argc > 1) {
    g_questions = std::strtoull(argv[1], nullptr, 10);
  }
  if (argc > 2) {
    g_seed = std::strtoull(argv[2], nullptr, 10);
  }
  return RUN_ALL_TESTS();
}
