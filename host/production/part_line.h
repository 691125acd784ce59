// A running line of a light section: parts out of profiles, judged, and told to everyone who wants to know.
#ifndef SELFPROJ_HOST_PRODUCTION_PART_LINE_H
#define SELFPROJ_HOST_PRODUCTION_PART_LINE_H

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>

#include "host/light_section/profile.h"
#include "host/production/judge.h"
#include "host/production/line_worker.h"
#include "host/production/part_cutter.h"
#include "host/production/slot_queue.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

// Takes profiles from one thread and works on them in another, so that who takes packets only computes a profile in its
// place and passes it on. No profile is dropped: where the line falls kQueued profiles behind, claim() waits, the
// packets wait in the ring, and what is then lost is lost in the ring and counted there.
class PartLine final : public LineWorker {
 public:
  static constexpr std::size_t kQueued = 2048;

  // Who wants to know. Called in the line's thread; exceptions end the run at the next claim() or at finish().
  struct Listeners {
    std::function<void(const PacketHeader&, ProfileView)> profile = {};
    TakePart part = {};
  };

  // Without a judge nothing is cut, and only profiles are told. The judge must outlive the line.
  PartLine(const Rig& rig, const Judge* judge, Listeners listeners);
  PartLine(const PartLine&) = delete;
  PartLine& operator=(const PartLine&) = delete;
  ~PartLine() override { stop(); }

  // The place for the next profile; publish() passes it on. Throws what a listener has thrown.
  ProfileView claim();
  void publish(const PacketHeader& header, std::int64_t arrival_ns);

 private:
  bool work() override;
  bool any() override { return queue_.front() != nullptr; }
  [[nodiscard]] bool in_part() const override { return cutter_ && cutter_->in_part(); }
  void cut_now() override { cutter_->finish(); }
  [[nodiscard]] std::uint64_t specks() const override { return cutter_->specks(); }

  std::function<void(const PacketHeader&, ProfileView)> profile_;
  SlotQueue<Profile> queue_;
  std::optional<PartCutter> cutter_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_PRODUCTION_PART_LINE_H
