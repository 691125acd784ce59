// Collects the frames of an inspection as they come: moments and profile of every column, and where the belt was.
// host/report/inspection_output.h writes them as tables, cloud, images and report.
#ifndef SELFPROJ_LIGHT_SECTION_INSPECTION_H
#define SELFPROJ_LIGHT_SECTION_INSPECTION_H

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::light_section {

struct InspectionOptions {
  std::size_t expected_frames = 0;  // reserves room for this many frames; more may come
  std::size_t max_frames = 20000;   // frames after these are only counted (512 columns take 18 kB a frame)
};

class Inspection {
 public:
  // The fields kept from a frame's header.
  struct Frame {
    std::uint64_t sequence = 0;
    std::uint64_t time_stamp = 0;
    std::uint32_t encoder = 0;
    std::uint8_t mode = 0;  // a value of Mode
    std::uint16_t threshold = 0;
    std::uint8_t pixel_bits = spec::kPixelBits;
    std::uint8_t select = 0;  // a value of Select
    std::uint8_t gap = 0;
    model::RowWindow window = {};
    std::uint16_t row_offset = 0;  // rows of the sensor before the frame

    [[nodiscard]] model::Measure measure() const {
      return {.mode = static_cast<model::Mode>(mode),
              .threshold = threshold,
              .select = static_cast<model::Select>(select),
              .gap = gap,
              .window = window,
              .bits = pixel_bits};
    }
  };

  // One entry for each column, frame after frame. Profiles are in mm, and without meaning unless validity is
  // Validity::valid.
  struct Values {
    std::vector<std::uint32_t> m0, m1, n;
    std::vector<float> x, y, z, dx, dy, dz;
    std::vector<std::uint8_t> validity;  // a Validity for each column
    // Number of runs, and the second in sixteenths of the strongest, as RunsView has them; 0 in frames without runs.
    // Empty as long as no frame has them.
    std::vector<std::uint8_t> runs, second;
  };

  // For profiles of `columns` > 0 columns, measured with this rig.
  Inspection(const rig::Rig& rig, int columns, const InspectionOptions& options = {});

  // Adds a frame: the header of its packet, its moments or runs as numbers, or the packet's payload, and its profile,
  // the moments with the header's columns, the profile with `columns`. Columns that the frame has not have no light.
  // Allocates nothing while there are no more frames than expected_frames. Throws std::invalid_argument if the frame
  // does not lie within the columns, or the payload has another width than the header says.
  void add(const model::PacketHeader& header, const model::RunsView& runs, const ProfileView& profile);
  void add(const model::PacketHeader& header, const model::MomentsView& moments, const ProfileView& profile) {
    add(header, model::RunsView{moments, nullptr, nullptr}, profile);
  }
  void add(const model::PacketHeader& header, std::span<const std::uint8_t> payload, const ProfileView& profile);

  // Frames kept, and frames that came after max_frames.
  [[nodiscard]] std::size_t frames() const { return frames_.size(); }
  [[nodiscard]] std::size_t frames_not_kept() const { return not_kept_; }
  [[nodiscard]] const Frame& frame(std::size_t index) const { return frames_.at(index); }  // from 0
  [[nodiscard]] const Values& values() const { return values_; }
  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] int columns() const { return columns_; }

  // How far the belt has moved from the first frame to frame `index` (from 0), in mm: by the encoder if it has counted,
  // else by the rig's speed and the time stamps, which count its pixel clock. If the board was restarted in between,
  // the belt is assumed to have moved on as before.
  [[nodiscard]] std::vector<double> belt_mm() const;

  // Whether the encoder has counted.
  [[nodiscard]] bool encoder_counts() const;

  // The mean distance in mm between frames along the belt. For a single frame it is what the rig's speed gives, and 0
  // if the belt stands still. The second function gives the distance between columns on the plane, mm.
  [[nodiscard]] double frame_spacing_mm() const;
  [[nodiscard]] double column_spacing_mm() const;

  // Height (plane_z - z) and difference (-dz) in mm; rows are frames, columns are image columns. NaN if there is no
  // point. Both are positive towards the camera.
  [[nodiscard]] images::FloatImage height() const;
  [[nodiscard]] images::FloatImage difference() const;

  // Centroids (rows of the sensor, from 1), and x (not carried back by the belt) and y in mm, in the same layout.
  [[nodiscard]] images::FloatImage centroid() const;
  [[nodiscard]] images::FloatImage x() const;
  [[nodiscard]] images::FloatImage y() const;

  // Whether a frame with the strongest run of each column came.
  [[nodiscard]] bool has_runs() const { return !values_.runs.empty(); }

 private:
  // Makes room for one more frame. Returns false if the frame is not to be kept.
  bool begin_frame(const model::PacketHeader& header);
  void add_profile(const ProfileView& profile);
  // Where the moments and runs of the frame go that begin_frame() made room for, from its first column on.
  model::RunsView last_frame(const model::PacketHeader& header);
  [[nodiscard]] images::FloatImage map(const std::vector<float>& values, double offset, double factor) const;

  rig::Rig rig_;
  int columns_;
  InspectionOptions options_;
  std::size_t not_kept_ = 0;
  std::vector<Frame> frames_;
  Values values_;
};

}  // namespace selfproj::light_section

#endif  // SELFPROJ_LIGHT_SECTION_INSPECTION_H
