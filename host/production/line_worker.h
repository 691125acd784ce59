// The thread of a running line, and what it tells of the parts.
#ifndef SELFPROJ_HOST_PRODUCTION_LINE_WORKER_H
#define SELFPROJ_HOST_PRODUCTION_LINE_WORKER_H

#include <atomic>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

#include "host/driver/clock.h"
#include "host/production/judge.h"
#include "host/production/line_state.h"
#include "host/production/part_cutter.h"
#include "host/production/part_result.h"
#include "host/production/part_text.h"
#include "host/rig/rig.h"

namespace selfproj {

// Works in a thread of its own on what another thread brings, judges the parts, and counts. What is brought, and how
// parts are cut out of it, is the business of the classes derived from it: PartLine for profiles, DepthLine for depth
// images.
class LineWorker {
 public:
  using TakePart = std::function<void(const PartResult&, const PlacedMaps&)>;

  LineWorker(const LineWorker&) = delete;
  LineWorker& operator=(const LineWorker&) = delete;
  virtual ~LineWorker();

  // Everything is judged when it returns, the part that is not complete too. Throws what a listener has thrown.
  void finish();

  // For any thread.
  [[nodiscard]] LineState state() const;
  [[nodiscard]] std::uint16_t heartbeat() const { return heartbeat_; }  // tenths of a second while the line works
  [[nodiscard]] PartStatistics statistics() const;
  [[nodiscard]] DurationHistogram delays() const;  // from the arrival of a part's last frame to its result

 protected:
  // Without a judge no parts are made. The judge must outlive the line; `part` is called in the line's thread.
  LineWorker(const Rig& rig, const Judge* judge, TakePart part);

  // To be called at the end of the derived constructor, and at the beginning of its destructor. The clock is looked at
  // after so many things at the latest.
  void start(int between_looks);
  void stop();

  // In the thread. work() takes one thing, and returns false if there is none; any() says whether there is one.
  // in_part() says whether a part has begun; cut_now() ends it. Exceptions end the run at the next check() or at
  // finish().
  virtual bool work() = 0;
  virtual bool any() = 0;
  [[nodiscard]] virtual bool in_part() const = 0;
  virtual void cut_now() = 0;
  [[nodiscard]] virtual std::uint64_t specks() const = 0;

  // In the thread: judges a part. `arrival_ns` of the newest thing goes to arrived().
  void take(CutPart&& part);
  void arrived(std::int64_t arrival_ns) { last_arrival_ns_ = arrival_ns; }

  // In the thread that brings: throws what has been thrown in the line's thread.
  void check();

  [[nodiscard]] bool judges() const { return judge_ != nullptr; }

 private:
  void run(int between_looks);
  void look_at_the_clock();

  const Judge* judge_;
  TakePart part_;
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

#endif  // SELFPROJ_HOST_PRODUCTION_LINE_WORKER_H
