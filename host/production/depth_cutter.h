// Parts of depth images.
#ifndef SELFPROJ_HOST_PRODUCTION_DEPTH_CUTTER_H
#define SELFPROJ_HOST_PRODUCTION_DEPTH_CUTTER_H

#include <cstdint>
#include <functional>
#include <vector>

#include "host/images/float_image.h"
#include "host/production/cell_sums.h"
#include "host/production/map_grid.h"
#include "host/production/part_cutter.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

// Depth images of a scanner as heights above its plane, on an even grid over what the camera sees of the plane. along
// is x and across is y; along counts from the upper border of the view.
class DepthGrid {
 public:
  // Throws UserError, naming the rig, if it has no section `parts`, or its pixels are further apart than the cells.
  explicit DepthGrid(const Rig& rig);

  // The cells of a depth image, z in mm, of the camera's size; NaN where there is none.
  [[nodiscard]] HeightCells cells(const FloatImage& depth);

  // How much of the plane the camera sees, mm.
  [[nodiscard]] double length_mm() const { return sums_.grid().pitch_mm * (sums_.grid().rows - 1); }
  [[nodiscard]] double across_mm() const { return -sums_.grid().across_mm; }  // to each side

 private:
  double plane_z_;
  CellSums sums_;
  FloatImage x_per_z_;  // of each pixel's ray; NaN where the lens model has none
  FloatImage y_per_z_;
};

// By the rules of the rig's section `parts`:
//   - cut by image: every depth image is a part
//   - cut by trigger: the camera runs only while a part is there, and a pause of pause_s ends it. The part is the mean
//     of all depth images whose frames came between two pauses; of a pixel at least half of them have a depth. The
//     first m pairs after a pause belong to none, because codes of both parts are in their depth images.
// What has no depth image of its own is counted as a speck.
class DepthCutter {
 public:
  using Take = std::function<void(CutPart&&)>;

  // `patterns` are the frames of a depth image, 2 m. Throws UserError, naming the rig, as DepthGrid does.
  DepthCutter(const Rig& rig, int patterns, Take take);

  // Takes the next depth image. `header` is that of the last frame of it; `arrival_ns` is any clock that does not go
  // back.
  void add(const PacketHeader& header, const FloatImage& depth, std::int64_t arrival_ns);

  // No image comes any more, or not for a long time: gives the part that is there so far.
  void finish();

  [[nodiscard]] std::uint64_t specks() const { return specks_; }
  [[nodiscard]] bool in_part() const { return in_part_; }

 private:
  void begin(const PacketHeader& header);
  void collect(const PacketHeader& header, const FloatImage& depth, std::int64_t arrival_ns);

  RigParts rule_;
  double clock_hz_, frame_s_;
  std::uint64_t patterns_;
  Take take_;
  DepthGrid grid_;
  bool any_ = false, in_part_ = false;
  std::uint64_t time_stamp_ = 0, sequence_ = 0;  // of the newest image
  std::uint64_t clean_from_ = 0;                 // first sequence whose depth image is of this part alone
  std::uint64_t specks_ = 0;
  std::uint64_t images_ = 0;  // in the sums
  FloatImage sum_, count_, mean_;
  CutPart part_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_DEPTH_CUTTER_H
