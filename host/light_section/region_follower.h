// Where the region of the sensor should lie, so that the camera sees the line of the part that passes.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_REGION_FOLLOWER_H
#define SELFPROJ_HOST_LIGHT_SECTION_REGION_FOLLOWER_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

// Looks at frames in time, and says where the region should begin. It only ever changes the region's row.
//
// In each column with a reference it finds the middle of the line, also of a line that is cut off as long as some of it
// is seen: its inner end and the number of rows that lines light tell. It then counts, for each place of the region,
// the columns that it would measure (line_is_cut_off). The region is moved to the middle of the best places if that
// gains more than kGain of the lit columns; with less to gain it stays where it is. Where no light has been seen for
// kHomeMs, it goes back to where the rig has it, and waits there for the next part.
//
// A part is thus caught if its line, or a part of it, falls into the region where that lies: up to half the region's
// rows and nearly half the line's off its middle.
class RegionFollower {
 public:
  static constexpr double kLookMs = 1;      // between two looks, by time stamps
  static constexpr double kHomeMs = 10;     // without light until it goes home
  static constexpr double kAnswerMs = 500;  // until a move that was asked for has come; then it is taken as failed
  static constexpr double kGain = 0.05;     // share of the lit columns

  // Throws UserError about `name` if the rig has no region.
  RegionFollower(const rig::Rig& rig, const ReferenceProfile& reference, const std::string& name);

  // Looks at a packet of a good frame whose columns SectionRun takes. Returns the row of the sensor, from 0, at which
  // the region should begin, if it is to be moved. Frames that come until it is there are not looked at. Throws
  // UserError about `name` if frames say twice that the region has moved, but their line has not.
  std::optional<int> look(const model::PacketView& packet);

  struct Counts {
    std::uint64_t looks = 0;
    std::uint64_t moves = 0;   // asked for
    std::uint64_t failed = 0;  // of them, those that never came
    std::uint64_t left = 0;    // looks at a line that left the region in more than kGain of the lit columns
  };
  [[nodiscard]] const Counts& counts() const { return counts_; }
  [[nodiscard]] int row() const { return asked_; }

 private:
  // Where the line was in the frames before a move, in rows, and by how many rows the region was to move.
  struct Before {
    double in_frame = 0;
    int rows = 0;
  };
  void expect_moved(double in_frame);
  [[nodiscard]] std::optional<int> better_place(std::size_t whole) const;
  std::optional<int> ask(int row, std::uint64_t clock);

  rig::RigCamera camera_;
  rig::RigMeasure measure_;
  std::string name_;
  std::vector<std::uint8_t> valid_;  // columns with a reference
  double clocks_per_ms_;
  int home_;
  int asked_;                   // where the region lies, or is to lie
  std::uint64_t asked_at_ = 0;  // clock
  std::uint64_t looked_at_ = 0;
  std::uint64_t lit_at_ = 0;
  bool first_ = true;
  model::RowWindow counted_;  // rows of a frame that count, from 1
  std::optional<Before> before_;
  int unmoved_ = 0;   // moves one after another that the frames do not show
  double half_line_;  // half the rows that a line lights; follows those that are seen
  model::Runs runs_;
  std::vector<float> middles_;  // of the lines, rows of the sensor from 1
  Counts counts_;
};

}  // namespace selfproj::light_section

#endif  // SELFPROJ_HOST_LIGHT_SECTION_REGION_FOLLOWER_H
