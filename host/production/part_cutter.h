// Cuts the stream of profiles into parts.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_CUTTER_H
#define SELFPROJ_HOST_PRODUCTION_PART_CUTTER_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "host/light_section/profile.h"
#include "host/production/belt_position.h"
#include "host/production/height_grid.h"
#include "host/production/map_grid.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

// A part as it was cut out of the stream.
struct CutPart {
  HeightCells cells;          // along counts from begin_mm
  double begin_mm = 0;        // where the belt was, since the start, at the first frame in the map
  double length_mm = 0;       // belt from the first frame that made it a part to the last
  std::uint64_t first = 0;    // sequence numbers of these frames
  std::uint64_t last = 0;     //
  std::uint64_t frames = 0;   // frames in the map
  std::uint64_t missing = 0;  // frames in between that did not come, or gave no profile
  bool too_long = false;      // cut at length_mm, although it goes on
  bool restarted = false;     // the board was restarted meanwhile: where the belt went is not known
  std::int64_t last_ns = 0;   // when its last frame came in, as `arrival_ns` of add()
};

// By the rules of the rig's section `parts`. Keeps one part's map, and of what comes before a part the frames of
// gap_mm, at most some hundreds; nothing grows with time.
class PartCutter {
 public:
  using Take = std::function<void(CutPart&&)>;

  // Throws UserError, naming the rig, if it has no section `parts`, or as HeightGrid does.
  PartCutter(const Rig& rig, Take take);

  // Takes the profile of the next frame; `arrival_ns` is any clock that does not go back. Calls `take` when a part is
  // complete.
  void add(const PacketHeader& header, const ProfileView& profile, std::int64_t arrival_ns);

  // No frame comes any more, or not for a long time: gives the part that is there so far. (Cut by distance, a part that
  // is not complete is dropped.)
  void finish();

  // What was shorter than min_length_mm.
  [[nodiscard]] std::uint64_t specks() const { return specks_; }

  [[nodiscard]] bool in_part() const { return in_part_; }
  [[nodiscard]] const Rig& rig() const { return rig_; }

 private:
  struct Kept {  // a frame before a part
    double belt = 0;
    Profile profile;
  };

  void keep(double belt, const ProfileView& profile);
  void begin(double belt, const PacketHeader& header);
  void put(double belt, const PacketHeader& header, const ProfileView& profile);
  void extend(double belt, const PacketHeader& header, std::int64_t arrival_ns);
  void end();

  Rig rig_;
  RigParts rule_;
  Take take_;
  BeltPosition belt_;
  HeightGrid grid_;
  bool in_part_ = false;
  bool any_ = false;
  double present_from_ = 0;  // belt at the first and the last frame that make it a part
  double present_to_ = 0;
  double last_kept_ = 0;
  std::uint64_t last_sequence_ = 0;
  std::uint64_t specks_ = 0;
  CutPart part_;
  std::vector<Kept> before_;  // a ring
  std::size_t newest_ = 0;
  std::size_t kept_ = 0;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_PART_CUTTER_H
