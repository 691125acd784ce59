// Verdicts worked out by hand, as one would on paper.
#include "selfproj/model/verdict.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

namespace selfproj::test {
namespace {

using model::ColumnLimits;
using model::ColumnState;
using model::FrameVerdict;
using model::PartRule;
using model::VerdictSettings;

constexpr std::uint32_t kRow = model::kRowParts;
// One lit row of weight 2 in each column: row 10, 8 or 12.
constexpr std::uint32_t kWeight = 2;

// A frame as a picture: '.' a line on row 10, '^' on row 8, 'v' on row 12, ' ' no light.
struct Frame {
  explicit Frame(const std::string& picture) {
    for (const char cell : picture) {
      const std::uint32_t row = cell == '^' ? 8 : cell == 'v' ? 12 : 10;
      m0.push_back(cell == ' ' ? 0 : kWeight);
      m1.push_back(cell == ' ' ? 0 : kWeight * row);
    }
  }
  std::vector<std::uint32_t> m0, m1;
};

// Columns between rows 9 and 11 are good.
class OnPaper {
 public:
  OnPaper(int columns, VerdictSettings settings, PartRule rule = PartRule())
      : verdict_(columns, 2), settings_(settings), rule_(rule) {
    for (int bank = 0; bank < 2; ++bank) {
      for (int section = 0; section < 2; ++section) {
        for (int column = 0; column < columns; ++column) {
          verdict_.write(bank, section, column, {9 * kRow, 11 * kRow, true});
        }
      }
    }
  }

  FrameVerdict see(const std::string& picture, bool whole = true) {
    const Frame frame(picture);
    return verdict_.frame(settings_, hold, rule_, encoder, frame.m0, frame.m1, whole);
  }
  model::Verdict& verdict() { return verdict_; }
  VerdictSettings& settings() { return settings_; }

  std::uint32_t encoder = 0;
  bool hold = false;

 private:
  model::Verdict verdict_;
  VerdictSettings settings_;
  PartRule rule_;
};

TEST(VerdictByHand, AColumnAtItsLimits) {
  const ColumnLimits limits = {9 * kRow, 11 * kRow, true};
  EXPECT_EQ(column_state(limits, 0, 0, 0), ColumnState::unlit);
  EXPECT_EQ(column_state(limits, 0, 10, 90), ColumnState::good);   // row 9 exactly
  EXPECT_EQ(column_state(limits, 0, 10, 89), ColumnState::above);  // 8.9
  EXPECT_EQ(column_state(limits, 0, 10, 110), ColumnState::good);
  EXPECT_EQ(column_state(limits, 0, 10, 111), ColumnState::below);
  // The band a row further down
  EXPECT_EQ(column_state(limits, kRow, 10, 99), ColumnState::above);
  EXPECT_EQ(column_state(limits, kRow, 10, 120), ColumnState::good);
  // and a 128th of a row up
  EXPECT_EQ(column_state(limits, -1, 128, 128 * 11 - 1), ColumnState::good);
  EXPECT_EQ(column_state(limits, -1, 128, 128 * 11), ColumnState::below);
  // The largest products
  EXPECT_EQ(column_state(ColumnLimits{model::kMaxLimit, model::kMaxLimit, true}, -model::kMaxShiftRows, 255 * 1023,
                         255 * 1023 * 512),
            ColumnState::above);
}

TEST(VerdictByHand, NeighboursThatAreOutOftenEnough) {
  VerdictSettings settings;
  settings.width = 3;
  settings.history = 3;
  settings.hits = 2;
  OnPaper paper(12, settings);
  EXPECT_FALSE(paper.see("............").in_part);  // the part begins with the next frame
  EXPECT_FALSE(paper.see("..^^^.......").defect);   // one hit each
  EXPECT_FALSE(paper.see("............").defect);
  const FrameVerdict found = paper.see("..^^^v......");  // two of three; the last has one hit
  EXPECT_TRUE(found.defect);
  EXPECT_EQ(found.first_column, 3);
  EXPECT_EQ(found.columns, 3);
  EXPECT_FALSE(paper.see("............").defect);  // the first hits are too old
  EXPECT_FALSE(paper.see("....^v.^^^^^").defect);
  const FrameVerdict edge = paper.see(".......^^^^^");  // up to the border
  EXPECT_EQ(edge.first_column, 8);
  EXPECT_EQ(edge.columns, 5);
}

TEST(VerdictByHand, OnlyOneSideIsAskedFor) {
  VerdictSettings settings;
  settings.above = false;
  OnPaper paper(8, settings);
  paper.see("........");
  EXPECT_FALSE(paper.see("..^^....").defect);
  EXPECT_EQ(paper.see("..^^.v..").first_column, 6);
}

TEST(VerdictByHand, LightIsCountedByALimitOfItsOwn) {
  VerdictSettings settings;
  settings.most_unlit = 2;
  OnPaper paper(8, settings);
  paper.see("........");
  EXPECT_FALSE(paper.see("..  ....").lacks_light);
  const FrameVerdict dark = paper.see("..   ...");
  EXPECT_TRUE(dark.lacks_light);
  EXPECT_FALSE(dark.defect);
  EXPECT_EQ(dark.unlit, 3);
}

TEST(VerdictByHand, AShiftedPartIsGood) {
  OnPaper paper(8, {});
  // A step that is part of the shape: columns 5 to 8 lie two rows further down.
  for (int column = 4; column < 8; ++column) {
    paper.verdict().write(0, 0, column, {11 * kRow, 13 * kRow, true});
  }
  paper.see("....vvvv");
  EXPECT_FALSE(paper.see("....vvvv").defect);
  EXPECT_TRUE(paper.see("..vvvvvv").defect);
  paper.see("        ");  // the part is over
  paper.settings().shift_columns = -2;
  paper.see("..vvvvvv");
  EXPECT_FALSE(paper.see("..vvvvvv").defect);  // the last two columns have no limits
  paper.see("        ");
  paper.settings().shift_rows = 2 * kRow;
  paper.see("vv......");
  EXPECT_EQ(paper.see("vv......").first_column, 3);
}

TEST(VerdictByHand, PartsByTheEncoderAndTheirSections) {
  PartRule rule;
  rule.by_encoder = true;
  rule.start = 100;
  rule.length = 20;
  rule.pitch = 50;
  VerdictSettings settings;
  OnPaper paper(4, settings, rule);
  paper.verdict().begin_section(0, 1, 10);
  for (int column = 0; column < 4; ++column) {
    paper.verdict().write(0, 1, column, {11 * kRow, 13 * kRow, true});
  }
  const auto at = [&](std::uint32_t encoder, const std::string& picture) {
    paper.encoder = encoder;
    return paper.see(picture);
  };
  EXPECT_FALSE(at(99, "....").in_part);
  EXPECT_TRUE(at(100, "....").in_part);
  EXPECT_EQ(at(109, "....").section, 0);
  EXPECT_EQ(at(110, "vvvv").section, 1);
  EXPECT_FALSE(at(119, "vvvv").defect);
  EXPECT_FALSE(at(120, "....").in_part);
  const FrameVerdict next = at(155, "....");
  EXPECT_TRUE(next.in_part && next.part == 2 && next.section == 0);
  EXPECT_TRUE(at(169, "....").in_part);
  EXPECT_FALSE(at(170, "....").in_part);
}

TEST(VerdictByHand, AFrameThatBreaks) {
  VerdictSettings settings;
  settings.history = 2;
  settings.hits = 2;
  OnPaper paper(8, settings);
  paper.see("........");
  EXPECT_FALSE(paper.see("..^.", false).defect);  // the part has no whole frame yet: it is judged by itself
  EXPECT_FALSE(paper.see("..^..^..").defect);
  EXPECT_EQ(paper.see("..^.", false).first_column, 3);  // the second half keeps its hit
  EXPECT_EQ(paper.see(".....^..").first_column, 6);
}

TEST(VerdictByHand, SettingsThatAreHeld) {
  OnPaper paper(8, {});
  paper.hold = true;
  paper.see("........");
  EXPECT_FALSE(paper.see("........").in_part);  // there are none to be held
  paper.hold = false;
  EXPECT_TRUE(paper.see("..^.....").defect);
  paper.see("        ");
  paper.hold = true;
  paper.settings().above = false;
  paper.see("........");
  EXPECT_TRUE(paper.see("..^.....").defect);  // as before
  EXPECT_EQ(paper.verdict().bad_parts(), 2U);
  paper.verdict().stop();
  EXPECT_FALSE(paper.verdict().in_part());
  EXPECT_FALSE(paper.see("..^.....").in_part);
}

TEST(VerdictByHand, WordsOfRegistersAndPackets) {
  const VerdictSettings settings = {.width = 16,
                                    .history = 8,
                                    .hits = 5,
                                    .above = false,
                                    .most_unlit = 300,
                                    .shift_columns = -17,
                                    .shift_rows = 33,
                                    .bank = 1};
  const model::VerdictWords words = verdict_words(settings, {.lit = 40, .dark_frames = 3});
  EXPECT_EQ(words.defect, 300U << 20 | 1U << 18 | 1U << 17 | 5U << 12 | 7U << 8 | 16U);
  EXPECT_EQ(words.shift, (16384U - 33U) << 16 | (256U - 17U));
  EXPECT_EQ(words.light, 3U << 16 | 40U);
  EXPECT_EQ(settings_of_words(words), settings);

  const FrameVerdict verdict = {.in_part = true,
                                .defect = true,
                                .section = 5,
                                .bank = 1,
                                .part = 0x1234,
                                .first_column = 4096,
                                .columns = 3,
                                .unlit = 700};
  std::vector<std::uint8_t> bytes(16);
  EXPECT_FALSE(model::unpack_verdict(bytes.data()));
  model::pack_verdict(verdict, bytes.data());
  EXPECT_EQ(model::unpack_verdict(bytes.data()), verdict);
}

TEST(VerdictByHand, BadSettingsAreRefused) {
  EXPECT_THROW(model::Verdict(6, 1), std::invalid_argument);
  EXPECT_THROW(model::Verdict(8, 65), std::invalid_argument);
  VerdictSettings settings;
  settings.width = 0;
  OnPaper paper(4, settings);
  paper.see("....");
  EXPECT_THROW(paper.see("...."), std::invalid_argument);
}

}  // namespace
}  // namespace selfproj::test
