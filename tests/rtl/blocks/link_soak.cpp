// Soak of the link: random requests from three hosts, good and malformed, every answer and every register compared with
// the model.
//
//     link_soak [QUESTIONS] [FIRST_SEED]      1,000,000 questions from seed 1 on by default
#include <cstdint>

#include "tests/rtl/blocks/link_bench.h"
#include "tests/support/soak.h"

namespace selfproj::test {
namespace {

TEST(Soak, EveryQuestionIsAnsweredAsTheModelDoes) {
  LinkFigures figures;
  soak(figures.questions, 1'000'000, [&](std::uint64_t seed) { expect_link_equals_model(seed, 1000, figures); });
  report_soak("link_soak", "The link's RTL against the models, random requests, good and malformed",
              {{"questions", figures.questions}, {"answers", figures.answers}, {"mismatches", 0}});
}

}  // namespace
}  // namespace selfproj::test
