// Cuts the stream of what is measured into parts.
#ifndef SELFPROJ_HOST_PRODUCTION_CUTTER_H
#define SELFPROJ_HOST_PRODUCTION_CUTTER_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "host/production/belt_position.h"
#include "host/production/height_map.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/verdict.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

// A part as it was cut out of the stream.
struct CutPart {
  HeightCells cells;         // along counts from begin_mm
  double begin_mm = 0;       // where the belt was, since the start, at the first frame in the map
  double length_mm = 0;      // belt from the first frame that made it a part to the last
  std::uint64_t first = 0;   // sequence numbers of these frames
  std::uint64_t last = 0;    //
  std::uint64_t frames = 0;  // frames in the map
  // Frames that did not come, or gave no profile: in between, and cut by the profile those right before and behind,
  // which may have been of it
  std::uint64_t missing = 0;
  bool too_long = false;     // cut at length_mm, although it goes on
  bool restarted = false;    // the board was restarted meanwhile: where the belt went is not known
  bool cut_off = false;      // cut by the profile: it lay in the first frame of the run, or in the last
  std::int64_t last_ns = 0;  // when its last frame came in, as `arrival_ns` of add()
};

// A profile, or a depth image, with the header of its last frame. What is not measured is empty.
struct MeasuredFrame {
  model::PacketHeader header;
  std::int64_t arrival_ns = 0;
  light_section::Profile profile;
  std::vector<std::uint32_t> m0, m1;         // of the frame's columns; empty where nobody asks for them
  std::optional<model::FrameVerdict> board;  // what the board has found in the frame
  images::FloatImage depth;                  // of the camera's size: z in mm, NaN where there is none
  images::FloatImage difference;             // from the reference: z_R - z
};

class Cutter {
 public:
  Cutter() = default;
  Cutter(const Cutter&) = delete;
  Cutter& operator=(const Cutter&) = delete;
  virtual ~Cutter() = default;

  // Receives what was measured next, and returns the part that is then complete.
  virtual std::optional<CutPart> add(MeasuredFrame& measured) = 0;

  // No frame comes any more, or not for a long time: returns the part that is there so far.
  virtual std::optional<CutPart> finish() = 0;

  // How often something was too short to be a part.
  [[nodiscard]] std::uint64_t specks() const { return specks_; }
  [[nodiscard]] bool in_part() const { return in_part_; }

 protected:
  bool in_part_ = false;
  std::uint64_t specks_ = 0;
};

// Cuts profiles by the rules of the rig's section `parts`. Keeps one part's map, and of what comes before a part the
// frames of gap_mm, at most some hundreds; nothing grows with time. A speck is shorter than min_length_mm.
class ProfileCutter final : public Cutter {
 public:
  // Throws UserError, naming the rig, if it has no section `parts`, or as HeightGrid does.
  explicit ProfileCutter(const rig::Rig& rig);

  // The profile of the next frame; `arrival_ns` is any clock that does not go back.
  std::optional<CutPart> add(const model::PacketHeader& header, const light_section::ProfileView& profile,
                             std::int64_t arrival_ns);
  std::optional<CutPart> add(MeasuredFrame& measured) override {
    return add(measured.header, measured.profile.view(), measured.arrival_ns);
  }

  // Cut by distance, a part that is not complete is dropped.
  std::optional<CutPart> finish() override;

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }

 private:
  struct Kept {  // a frame before a part
    double belt = 0;
    light_section::Profile profile;
  };

  void keep(double belt, const light_section::ProfileView& profile);
  [[nodiscard]] std::uint64_t lost_before(const model::PacketHeader& header) const;
  void begin(double belt, const model::PacketHeader& header);
  void put(double belt, const model::PacketHeader& header, const light_section::ProfileView& profile);
  void extend(double belt, const model::PacketHeader& header, std::int64_t arrival_ns);
  std::optional<CutPart> end();

  rig::Rig rig_;
  rig::RigParts rule_;
  BeltPosition belt_;
  HeightGrid grid_;
  bool any_ = false;
  bool began_with_a_part_ = false;  // this frame is the first of the run
  double present_from_ = 0;         // belt at the first and the last frame that make it a part
  double present_to_ = 0;
  double last_kept_ = 0;
  std::uint64_t last_sequence_ = 0;
  CutPart part_;
  std::vector<Kept> before_;  // a ring
  std::size_t newest_ = 0;
  std::size_t kept_ = 0;
};

// Cuts depth images by the rules of the rig's section `parts`:
//   - cut by image: every depth image is a part
//   - cut by trigger: the camera runs only while a part is there, and a pause of pause_s ends it. The part is the mean
//     of all depth images whose frames came between two pauses; of a pixel at least half of them have a depth. The
//     first m pairs after a pause belong to none, because codes of both parts are in their depth images.
// What has no depth image of its own is a speck.
class DepthCutter final : public Cutter {
 public:
  // `patterns` are the frames of a depth image, 2 m. Throws UserError, naming the rig, as DepthGrid does.
  DepthCutter(const rig::Rig& rig, int patterns);

  // The next depth image. `header` is that of the last frame of it; `arrival_ns` is any clock that does not go back.
  std::optional<CutPart> add(const model::PacketHeader& header, const images::FloatImage& depth,
                             std::int64_t arrival_ns);
  std::optional<CutPart> add(MeasuredFrame& measured) override {
    return add(measured.header, measured.depth, measured.arrival_ns);
  }
  std::optional<CutPart> finish() override;

 private:
  void begin(const model::PacketHeader& header);
  void collect(const model::PacketHeader& header, const images::FloatImage& depth, std::int64_t arrival_ns);

  DepthGrid grid_;  // first: it refuses a rig without the section
  rig::RigParts rule_;
  double clock_hz_, frame_s_;
  std::uint64_t patterns_;
  bool any_ = false;
  std::uint64_t time_stamp_ = 0, sequence_ = 0;  // of the newest image
  std::uint64_t clean_from_ = 0;                 // first sequence whose depth image is of this part alone
  std::uint64_t images_ = 0;                     // in the sums
  images::FloatImage sum_, count_, mean_;
  CutPart part_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_CUTTER_H
