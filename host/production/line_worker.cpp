#include "host/production/line_worker.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "host/driver/clock.h"
#include "host/files/signals_held.h"

namespace selfproj {
namespace {

// A sleep that is short beside 20 ms, and long beside the way into the kernel.
constexpr auto kNap = std::chrono::microseconds(500);
constexpr std::int64_t kBeatNs = 100'000'000;
// A pause of frames that ends a part by trigger is told by the time stamps. Where no further frame comes, the clock of
// this machine says it, so much later.
constexpr double kLateS = 0.1;

}  // namespace

LineWorker::LineWorker(const Rig& rig, const Judge* judge, TakePart part) : judge_(judge), part_(std::move(part)) {
  pause_s_ = judge_ != nullptr && rig.parts->cut == PartCut::trigger ? rig.parts->pause_s : 0;
}

LineWorker::~LineWorker() = default;

void LineWorker::start(int between_looks) {
  const SignalsHeld held;  // signals are for the main thread
  thread_ = std::thread([this, between_looks] { run(between_looks); });
}

void LineWorker::stop() {
  end_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

void LineWorker::check() {
  if (failed_) {
    finish();
  }
}

void LineWorker::finish() {
  stop();
  const std::lock_guard lock(mutex_);
  if (fault_) {
    std::rethrow_exception(std::exchange(fault_, nullptr));
  }
}

LineState LineWorker::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

PartStatistics LineWorker::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

DurationHistogram LineWorker::delays() const {
  const std::lock_guard lock(mutex_);
  return delays_;
}

void LineWorker::take(CutPart&& part) {
  PartResult result = judge_->judge(part, maps_);
  {
    const std::lock_guard lock(mutex_);
    result.number = state_.parts() + 1;
    const std::int64_t now = now_ns();
    result.delay_ns = now - part.last_ns;
    ++state_.verdicts.at(static_cast<std::size_t>(result.verdict));
    state_.specks = specks();
    state_.last_part = result.number;
    state_.last_verdict = result.verdict;
    state_.last_defects = result.defects.size();
    state_.last_depth_mm = result.defects.empty() ? 0 : result.defects.front().depth_mm;
    state_.last_delay_ns = result.delay_ns;
    state_.last_ns = now;
    delays_.add(result.delay_ns);
    add_figures(result, statistics_);
  }
  if (part_) {
    part_(result, maps_);
  }
}

void LineWorker::look_at_the_clock() {
  const std::int64_t now = now_ns();
  if (now >= next_beat_ns_) {
    next_beat_ns_ = now + kBeatNs;
    ++heartbeat_;
  }
  if (pause_s_ > 0 && in_part() && !any() && static_cast<double>(now - last_arrival_ns_) * 1e-9 > pause_s_ + kLateS) {
    cut_now();
  }
}

void LineWorker::run(int between_looks) {
  try {
    for (;;) {
      const bool end = end_;  // what was published before is seen below
      for (int i = 0; i < between_looks && work(); ++i) {
      }
      look_at_the_clock();
      if (any()) {
        continue;
      }
      if (end) {
        break;
      }
      std::this_thread::sleep_for(kNap);
    }
    if (judges()) {
      cut_now();
      const std::lock_guard lock(mutex_);
      state_.specks = specks();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    failed_ = true;
  }
}

}  // namespace selfproj
