// The region follows the line: it moves where that gains columns, stays where it does not, and goes home without light.
#include "host/light_section/region_follower.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/board.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr int kRows = 20;
constexpr double kNowhere = -100;  // a row outside the image: no line

// Frames of a camera that sends what it is told.
class World {
 public:
  explicit World(bool compact = false) : compact_(compact) {
    rig_.measure.mode = model::Mode::grey_over;
    const int rows = rig_.camera.rows;
    rig_.camera.region = rig::RigRegion{.row_offset = (rows - kRows) / 2,
                                        .rows = kRows,
                                        .column_offset = 0,
                                        .columns = rig_.camera.columns,
                                        .frame_rate_hz = 50000,
                                        .exposure_s = 18e-6};
    row_ = camera_row_ = home();
    follower_.emplace(rig_, light_section::reference_of_plane(rig_), "few.yaml");
  }

  // Frames of a line in the middle of the image but for `aside` rows, for some milliseconds; the camera obeys. Returns
  // how often it was moved.
  int show(const std::function<double(int column)>& aside, double ms, bool obeys = true) {
    return show(aside, ms, obeys, obeys);
  }
  // The same; `board_obeys`: packets say that the region has moved.
  int show(const std::function<double(int column)>& aside, double ms, bool camera_obeys, bool board_obeys) {
    int moves = 0;
    for (double end = now_ms_ + ms; now_ms_ < end; now_ms_ += 1) {
      packet_ = packet_of(aside);
      model::PacketView view;
      EXPECT_EQ(model::parse_packet(packet_, view), model::PacketError::none);
      if (const std::optional<int> to = follower_->look(view)) {
        ++moves;
        row_ = board_obeys ? *to : row_;
        camera_row_ = camera_obeys ? *to : camera_row_;
      }
    }
    return moves;
  }
  int show(double aside, double ms, bool obeys = true) {
    return show([aside](int /*column*/) { return aside; }, ms, obeys);
  }

  // Columns of the newest frame that have a point.
  [[nodiscard]] int points() const {
    const light_section::DifferentialProfiler profiler(rig_, light_section::reference_of_plane(rig_));
    light_section::Profile profile;
    profile.resize(profiler.columns());
    model::PacketView view;
    EXPECT_EQ(model::parse_packet(packet_, view), model::PacketError::none);
    EXPECT_TRUE(profiler.profile(view, profile.view()));
    return static_cast<int>(std::count(profile.validity.begin(), profile.validity.end(), 0));
  }

  [[nodiscard]] int home() const { return rig_.camera.region->row_offset; }
  [[nodiscard]] int row() const { return row_; }
  [[nodiscard]] int columns() const { return rig_.camera.columns; }
  [[nodiscard]] const light_section::RegionFollower::Counts& counts() const { return follower_->counts(); }

 private:
  std::vector<std::uint8_t> packet_of(const std::function<double(int)>& aside) {
    const int columns = rig_.camera.columns;
    std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kRows) * static_cast<std::size_t>(columns));
    for (int column = 0; column < columns; ++column) {
      const double centre = 0.5 * (rig_.camera.rows - 1) + aside(column);
      for (int row = 0; row < kRows; ++row) {
        const double light = 180 * std::exp(-0.5 * std::pow((camera_row_ + row - centre) / 1.5, 2));
        pixels[static_cast<std::size_t>(row * columns + column)] =
            static_cast<std::uint8_t>(light + static_cast<double>(random_() % 8));
      }
    }
    model::PacketHeader header;
    header.kind = compact_ ? spec::kKindCompact : spec::kKindMoments;
    header.time_stamp = static_cast<std::uint64_t>(now_ms_ * rig_.pixel_clock_hz() / 1000);
    header.region_row = static_cast<std::uint16_t>(row_ + 1);
    header.region_column = 1;
    std::vector<std::uint8_t> packet;
    model::append_moments_packet({pixels.data(), kRows, columns, columns}, rig_.measure.of_board(), header, packet);
    return packet;
  }

  rig::Rig rig_ = rig::load_rig("light-section");
  bool compact_;
  std::mt19937 random_{5};
  int row_ = 0;         // that packets say
  int camera_row_ = 0;  // and where the camera is
  double now_ms_ = 0;
  std::optional<light_section::RegionFollower> follower_;
  std::vector<std::uint8_t> packet_;
};

class RegionFollower : public ::testing::TestWithParam<bool> {};

// A line of 6 rows that lies up to 10 rows off the middle is partly seen, and one look is enough.
TEST_P(RegionFollower, CatchesAPartThatLiesHigherOrLower) {
  for (double aside = -10; aside <= 10; aside += 1.25) {
    World world(GetParam());
    const int moves = world.show(aside, 5);
    EXPECT_EQ(world.points(), world.columns()) << aside;
    EXPECT_LE(moves, 2) << aside;
    EXPECT_TRUE(std::abs(aside) > 5 || moves == 0) << aside;
    EXPECT_TRUE(std::abs(aside) < 7 || moves > 0) << aside;
    EXPECT_EQ(world.counts().failed, 0U);
  }
}

TEST_P(RegionFollower, StaysWhereThereIsLittleToGain) {
  World world(GetParam());
  const int few = world.columns() / 25;  // 4 %
  EXPECT_EQ(world.show([&](int column) { return column < few ? 9.0 : 0.0; }, 200), 0);
  EXPECT_EQ(world.show([&](int column) { return column < few ? kNowhere : 4.0; }, 200), 0);
  EXPECT_EQ(world.counts().left, 0U);
  EXPECT_EQ(world.row(), world.home());
  // As many columns above as below: no place is better.
  EXPECT_EQ(world.show([&](int column) { return column % 2 == 0 ? -9.0 : 9.0; }, 50), 1);
  EXPECT_EQ(world.show([&](int column) { return column % 2 == 0 ? -9.0 : 9.0; }, 50), 0);
  EXPECT_EQ(world.points(), world.columns() / 2);
}

TEST_P(RegionFollower, GoesHomeBetweenPartsAndTakesTheNext) {
  World world(GetParam());
  for (const double aside : {8.0, -8.0, 10.0, -10.0}) {
    EXPECT_GE(world.show(aside, 5), 1);
    EXPECT_EQ(world.points(), world.columns());
    EXPECT_NE(world.row(), world.home());
    EXPECT_EQ(world.show(kNowhere, 8), 0);
    EXPECT_EQ(world.show(kNowhere, 8), 1);
    EXPECT_EQ(world.row(), world.home());
    EXPECT_EQ(world.show(kNowhere, 50), 0);
  }
}

TEST_P(RegionFollower, FollowsALineThatLeavesSlowly) {
  World world(GetParam());
  for (double aside = 0; aside < 30; aside += 0.5) {
    world.show(aside, 3);
    EXPECT_EQ(world.points(), world.columns()) << aside;
  }
  EXPECT_LT(world.counts().moves, 8U);
  EXPECT_NEAR(world.row(), world.home() + 30, 7);
}

TEST_P(RegionFollower, StopsAtTheEdgeOfTheSensorAndSaysSo) {
  World world(GetParam());
  for (double aside = 0; aside < 52; aside += 2) {
    world.show(aside, 3);
  }
  EXPECT_GE(world.row() + kRows, 95);
  EXPECT_EQ(world.points(), 0);
  EXPECT_GT(world.counts().left, 3U);
}

// The camera does not obey: what comes stays measured where it lies, and the move counts as failed.
TEST_P(RegionFollower, AMoveThatNeverComesIsCounted) {
  World world(GetParam());
  EXPECT_EQ(world.show(9, 400, false), 1);
  EXPECT_EQ(world.counts().failed, 0U);
  EXPECT_EQ(world.show(9, 200, false), 1);
  EXPECT_EQ(world.counts().failed, 1U);
}

// A board that says so, and a camera that stays where it is: heights would be wrong.
TEST_P(RegionFollower, ACameraThatDoesNotObeyIsFoundOut) {
  for (const double aside : {-9.0, 8.0, 10.0}) {
    World world(GetParam());
    const auto line = [aside](int /*column*/) { return aside; };
    EXPECT_EQ(error_of([&] { world.show(line, 10, false, true); }),
              "few.yaml: the region was moved, but the line stays in the same rows of its frames: the camera does not "
              "obey the register `region`");
    EXPECT_LE(world.counts().looks, 4U);
  }
}

// A part that moves by chance with the region looks as if the camera did not obey. Now and then that does no harm.
TEST_P(RegionFollower, APartThatMovesWithTheRegionNowAndThen) {
  World world(GetParam());
  double aside = 0;
  for (int time = 0; time < 6; ++time) {
    const int before = world.row();
    const double step = time % 2 == 0 ? 8 : -8;
    aside += step;
    ASSERT_EQ(world.show(aside, 1), 1) << time;
    aside += world.row() - before;
    ASSERT_EQ(world.show(aside, 1), 1) << time;  // the same rows of the frame as before
    ASSERT_EQ(world.show(aside, 5), 0) << time;
    EXPECT_EQ(world.points(), world.columns()) << time;
  }
}

INSTANTIATE_TEST_SUITE_P(Words, RegionFollower, ::testing::Bool(),
                         [](const auto& compact) { return std::string(compact.param ? "Compact" : "Exact"); });

TEST(RegionFollowerOfARig, NeedsARegion) {
  const rig::Rig rig = rig::load_rig("light-section");
  EXPECT_THROW(light_section::RegionFollower(rig, light_section::reference_of_plane(rig), "few.yaml"), UserError);
}

}  // namespace
}  // namespace selfproj::test
