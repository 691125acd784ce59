// A running line: parts out of profiles, judged, and told to everyone who wants to know.
#ifndef SELFPROJ_HOST_LINE_PART_LINE_H
#define SELFPROJ_HOST_LINE_PART_LINE_H

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "host/io/duration_histogram.h"
#include "host/light_section/profile.h"
#include "host/line/line_state.h"
#include "host/line/part_text.h"
#include "host/line/profile_queue.h"
#include "host/parts/judge.h"
#include "host/parts/part_cutter.h"
#include "host/parts/part_result.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

// Takes profiles from one thread and works on them in another, so that who takes packets only computes a profile in its
// place and passes it on. No profile is dropped: where the line falls kQueued profiles behind, claim() waits, the
// packets wait in the ring, and what is then lost is lost in the ring and counted there.
class PartLine {
 public:
  static constexpr std::size_t kQueued = 2048;

  // Who wants to know. Called in the line's thread; exceptions end the run at the next claim() or at finish().
  struct Listeners {
    std::function<void(const PacketHeader&, ProfileView)> profile = {};
    std::function<void(const PartResult&, const PlacedMaps&)> part = {};
  };

  // Without a judge nothing is cut, and only profiles are told. The judge must outlive the line.
  PartLine(const Rig& rig, const Judge* judge, Listeners listeners);
  PartLine(const PartLine&) = delete;
  PartLine& operator=(const PartLine&) = delete;
  ~PartLine();

  // The place for the next profile; publish() passes it on. Throws what a listener has thrown.
  ProfileView claim();
  void publish(const PacketHeader& header, std::int64_t arrival_ns);

  // Everything is judged when it returns, the part that is not complete too. Throws what a listener has thrown.
  void finish();

  // For any thread: the parts so far; a number that goes up every tenth of a second while the line works.
  [[nodiscard]] LineState state() const;
  [[nodiscard]] std::uint16_t heartbeat() const { return heartbeat_.load(); }

  // Copies of what is known over all parts. For any thread.
  [[nodiscard]] PartStatistics statistics() const;
  [[nodiscard]] DurationHistogram delays() const;  // from the arrival of a part's last frame to its result

 private:
  void run();
  void stop();
  bool work();  // takes what is there; false if nothing was
  void look_at_the_clock();
  void take(CutPart&& part);

  const Judge* judge_;
  Listeners listeners_;
  ProfileQueue queue_;
  std::optional<PartCutter> cutter_;
  double pause_s_ = 0;  // cut by trigger
  PlacedMaps maps_;
  std::atomic<std::uint16_t> heartbeat_{0};
  std::int64_t next_beat_ns_ = 0;
  std::int64_t last_arrival_ns_ = 0;
  mutable std::mutex mutex_;  // of the next four
  LineState state_;
  PartStatistics statistics_;
  DurationHistogram delays_;
  std::exception_ptr fault_;
  std::atomic<bool> failed_{false};
  std::atomic<bool> end_{false};
  std::thread thread_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_LINE_PART_LINE_H
