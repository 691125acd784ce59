// The frames of an inspection, collected as they come: moments and profile of every column, and where the belt was.
// host/report/inspection_output.h writes them as tables, cloud, images and report.
#ifndef SELFPROJ_HOST_LIGHT_SECTION_INSPECTION_H
#define SELFPROJ_HOST_LIGHT_SECTION_INSPECTION_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "host/io/float_image.h"
#include "host/light_section/profile.h"
#include "host/rig/rig.h"
#include "model/column_moments.h"
#include "model/packet.h"

namespace selfproj {

struct InspectionOptions {
  std::size_t expected_frames = 0;  // room is made for so many at once; more may come
  std::size_t max_frames = 20000;   // those after it are counted and not kept (a frame of 512 columns takes 18 kB)
};

class Inspection {
 public:
  // What is kept of a frame's header.
  struct Frame {
    std::uint64_t sequence = 0;
    std::uint64_t time_stamp = 0;
    std::uint32_t encoder = 0;
    std::uint8_t mode = 0;  // a value of Mode
    std::uint8_t threshold = 0;
  };

  // One entry a column, frame after frame. Profiles in mm; where validity is not Validity::valid they have no meaning.
  struct Values {
    std::vector<std::uint32_t> m0, m1, n;
    std::vector<float> x, y, z, dx, dy, dz;
    std::vector<std::uint8_t> validity;  // a Validity each
  };

  // Profiles of columns > 0 columns, measured with the rig.
  Inspection(const Rig& rig, int columns, const InspectionOptions& options = {});

  // Takes a frame: the header of its packet, its moments as numbers or as the packet's payload, its profile, all of
  // `columns` columns. Allocates nothing while there are no more frames than expected_frames. Throws
  // std::invalid_argument where the header or the payload has another width.
  void add(const PacketHeader& header, const MomentsView& moments, const ProfileView& profile);
  void add(const PacketHeader& header, std::span<const std::uint8_t> payload, const ProfileView& profile);

  // Frames kept, and those that came after max_frames.
  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  [[nodiscard]] std::size_t frames_not_kept() const { return not_kept_; }
  [[nodiscard]] const Frame& frame(std::size_t index) const { return frames_.at(index); }  // from 0
  [[nodiscard]] const Values& values() const { return values_; }
  [[nodiscard]] const Rig& rig() const { return rig_; }
  [[nodiscard]] int columns() const { return columns_; }

  // How far the belt has moved from the first frame to frame `index` (from 0), in mm: by the encoder where it has
  // counted, else by the rig's speed and the time stamps, which count its pixel clock. Where the board was restarted in
  // between the belt is taken to have moved on as before.
  [[nodiscard]] std::vector<double> belt_mm() const;

  // Whether the encoder has counted.
  [[nodiscard]] bool encoder_counts() const;

  // The belt's way from frame to frame, mm, on average; of a single frame what the rig's speed gives, 0 where the belt
  // stands. And from column to column on the plane, mm.
  [[nodiscard]] double frame_spacing_mm() const;
  [[nodiscard]] double column_spacing_mm() const;

  // Height (plane_z - z) and difference (-dz) in mm, rows = frames, columns = image columns, NaN where there is no
  // point. Both are positive towards the camera.
  [[nodiscard]] FloatImage height() const;
  [[nodiscard]] FloatImage difference() const;

  // Centroids (rows from 1), x (not carried back by the belt) and y in mm, likewise.
  [[nodiscard]] FloatImage centroid() const;
  [[nodiscard]] FloatImage x() const;
  [[nodiscard]] FloatImage y() const;

 private:
  // Makes room for one more frame. False where it is not to be kept.
  bool begin_frame(const PacketHeader& header);
  void add_profile(const ProfileView& profile);
  [[nodiscard]] FloatImage map(const std::vector<float>& values, double offset, double factor) const;

  Rig rig_;
  int columns_;
  InspectionOptions options_;
  std::size_t not_kept_ = 0;
  std::vector<Frame> frames_;
  Values values_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LIGHT_SECTION_INSPECTION_H
