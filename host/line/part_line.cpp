#include "host/line/part_line.h"

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

#include "host/driver/clock.h"
#include "host/io/signals_held.h"

namespace selfproj {
namespace {

// Sleeps of the two threads: short beside 20 ms, long beside the way into the kernel.
constexpr auto kNap = std::chrono::microseconds(500);
constexpr auto kNapWhenFull = std::chrono::microseconds(100);
constexpr std::int64_t kBeatNs = 100'000'000;
// A pause of frames that ends a part by trigger is told by the time stamps. Where no further frame comes, the clock of
// this machine says it, so much later.
constexpr double kLateS = 0.1;

}  // namespace

PartLine::PartLine(const Rig& rig, const Judge* judge, Listeners listeners)
    : judge_(judge), listeners_(std::move(listeners)), queue_(rig.camera.columns, kQueued) {
  if (judge_ != nullptr) {
    cutter_.emplace(rig, [this](CutPart&& part) { take(std::move(part)); });
    pause_s_ = rig.parts->cut == PartCut::trigger ? rig.parts->pause_s : 0;
  }
  const SignalsHeld held;
  thread_ = std::thread([this] { run(); });
}

PartLine::~PartLine() { stop(); }

void PartLine::stop() {
  end_ = true;
  if (thread_.joinable()) {
    thread_.join();
  }
}

ProfileView PartLine::claim() {
  ProfileQueue::Slot* slot = queue_.claim();
  while (slot == nullptr || failed_) {
    if (failed_) {
      finish();
    }
    std::this_thread::sleep_for(kNapWhenFull);
    slot = queue_.claim();
  }
  return slot->profile.view();
}

void PartLine::publish(const PacketHeader& header, std::int64_t arrival_ns) {
  ProfileQueue::Slot* const slot = queue_.claim();  // that of the last claim()
  slot->header = header;
  slot->arrival_ns = arrival_ns;
  queue_.publish();
}

void PartLine::finish() {
  stop();
  const std::lock_guard lock(mutex_);
  if (fault_) {
    std::rethrow_exception(std::exchange(fault_, nullptr));
  }
}

LineState PartLine::state() const {
  const std::lock_guard lock(mutex_);
  return state_;
}

PartStatistics PartLine::statistics() const {
  const std::lock_guard lock(mutex_);
  return statistics_;
}

DurationHistogram PartLine::delays() const {
  const std::lock_guard lock(mutex_);
  return delays_;
}

void PartLine::take(CutPart&& part) {
  PartResult result = judge_->judge(part, maps_);
  {
    const std::lock_guard lock(mutex_);
    result.number = state_.parts() + 1;
    const std::int64_t now = now_ns();
    result.delay_ns = now - part.last_ns;
    ++state_.verdicts.at(static_cast<std::size_t>(result.verdict));
    state_.specks = cutter_->specks();
    state_.last_part = result.number;
    state_.last_verdict = result.verdict;
    state_.last_defects = result.defects.size();
    state_.last_depth_mm = result.defects.empty() ? 0 : result.defects.front().depth_mm;
    state_.last_delay_ns = result.delay_ns;
    state_.last_ns = now;
    delays_.add(result.delay_ns);
    add_figures(result, statistics_);
  }
  if (listeners_.part) {
    listeners_.part(result, maps_);
  }
}

bool PartLine::work() {
  ProfileQueue::Slot* const slot = queue_.front();
  if (slot == nullptr) {
    return false;
  }
  const ProfileView profile = slot->profile.view();
  if (cutter_) {
    cutter_->add(slot->header, profile, slot->arrival_ns);
  }
  if (listeners_.profile) {
    listeners_.profile(slot->header, profile);
  }
  last_arrival_ns_ = slot->arrival_ns;
  queue_.release();
  return true;
}

void PartLine::look_at_the_clock() {
  const std::int64_t now = now_ns();
  if (now >= next_beat_ns_) {
    next_beat_ns_ = now + kBeatNs;
    ++heartbeat_;
  }
  if (pause_s_ > 0 && cutter_->in_part() && queue_.front() == nullptr &&
      static_cast<double>(now - last_arrival_ns_) * 1e-9 > pause_s_ + kLateS) {
    cutter_->finish();
  }
}

void PartLine::run() {
  try {
    for (;;) {
      const bool end = end_;  // what was published before is seen below
      constexpr int kBetweenLooks = 64;
      for (int i = 0; i < kBetweenLooks && work(); ++i) {
      }
      look_at_the_clock();
      if (queue_.front() != nullptr) {
        continue;
      }
      if (end) {
        break;
      }
      std::this_thread::sleep_for(kNap);
    }
    if (cutter_) {
      cutter_->finish();
      const std::lock_guard lock(mutex_);
      state_.specks = cutter_->specks();
    }
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    failed_ = true;
  }
}

}  // namespace selfproj
