// Parts inspected while they pass: cut out of what is measured, classified, and reported.
#ifndef SELFPROJ_HOST_PRODUCTION_PRODUCTION_H
#define SELFPROJ_HOST_PRODUCTION_PRODUCTION_H

#include <readerwriterqueue/readerwriterqueue.h>

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <exception>
#include <memory>
#include <mutex>
#include <optional>
#include <stop_token>
#include <string>
#include <thread>
#include <vector>

#include "host/driver/clock.h"
#include "host/production/camera_view.h"
#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/live_page.h"
#include "host/production/modbus_server.h"
#include "host/production/newest.h"
#include "host/production/part_files.h"
#include "host/production/part_reference.h"
#include "host/production/part_result.h"
#include "host/production/tolerance.h"
#include "host/production/verdict_run.h"
#include "host/report/facts.h"
#include "host/report/report.h"
#include "selfproj/driver/counters.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::production {

struct ProductionOptions {
  std::string folder;     // of the results of parts; empty: none
  std::string tolerance;  // empty: no parts
  std::uint64_t keep = 1000;
  std::string modbus;
  std::string live;
  bool verdict = false;  // of moments, which the device must bring

  // The first option that was given; empty: none.
  [[nodiscard]] std::string first() const {
    return !tolerance.empty() ? "--tolerance"
           : !folder.empty()  ? "--parts"
           : !modbus.empty()  ? "--modbus"
           : !live.empty()    ? "--live"
           : verdict          ? "--verdict"
                              : "";
  }
  [[nodiscard]] bool any() const { return !first().empty(); }
};

// A production:
//
//     who receives packets ─▶ queue ─▶ cutter ─▶ classifier ─▶ files, live page, Modbus
//
// The thread that receives packets only measures in a place of the queue and passes it on. All else is the work of a
// thread of its own. Nothing that was measured is dropped: where the work falls behind, claim() waits, the packets wait
// in the ring, and what is then lost is lost in the ring and counted there. Without a tolerance nothing is cut, and the
// page shows what was measured.
class Production {
 public:
  // Of a light section. Throws UserError about options, rig, tolerance, ports and folders, as the constructor below.
  // `title` stands above the page.
  // `verdict` judges the moments of each frame; null: nothing does.
  Production(const ProductionOptions& options, const rig::Rig& rig, const SectionReference& section,
             const std::string& title, std::unique_ptr<VerdictRun> verdict = nullptr);

  // Of structured light. `reference_depth` is z_R in mm, NaN where there is none, and `patterns` are the frames of a
  // depth image.
  Production(const ProductionOptions& options, const rig::Rig& rig, const images::FloatImage& reference_depth,
             int patterns, const std::string& title);
  Production(const Production&) = delete;
  Production& operator=(const Production&) = delete;
  ~Production() = default;

  // For the thread that receives packets. claim() gives the place for what is measured next, the same until publish()
  // passes it on. Throws what the thread of the production has thrown.
  MeasuredFrame& claim();
  void publish() { free_.pop(), filled_.enqueue(claimed_); }

  // A packet that may belong to a raw image, which the page may show.
  void image(const model::PacketView& packet);

  // The counters so far, and the figures that the page shows.
  void report(const driver::Counters& counters, std::vector<report::Fact> figures);

  // Classifies the parts that are left, and writes their results. Throws what the thread has thrown.
  void finish();

  // Throws UserError if the results of a part could not be written. For the end, after all else is done.
  void check() const {
    if (files_) {
      files_->check();
    }
  }

  // Why parts have no verdict, in words, after finish(): none was cut, the encoder did not count, or some are
  // inconclusive. Empty if all have one but those that the run cut off, or no parts are classified.
  [[nodiscard]] std::string doubt() const;

  // The verdict by moments, after finish(); null where there is none.
  [[nodiscard]] const VerdictRun* verdict() const { return verdict_.get(); }

  // What was counted so far; the end of the status line on a terminal: "12 parts: 10 good, ..."; and at the end one
  // line, or nothing where no parts are classified.
  [[nodiscard]] std::vector<report::Fact> facts() const;
  [[nodiscard]] std::string status_text() const;
  [[nodiscard]] std::string end_text() const;

  // What a report says of the parts: the last ones as a table, the counts, and the deepest of their defects in mm, or
  // the widest limit of the tolerance where there was none. After finish(); only where parts are classified.
  void describe(report::ReportParts& report) const;

 private:
  // Of the verdict by moments: frames of parts, those with a defect, parts by its own rule, those with a defect; and of
  // the parts that both judged, those on which it agrees with the classifier, where it finds a defect that the
  // classifier does not, and the other way round.
  struct MomentCounts {
    std::uint64_t frames = 0, defect_frames = 0, parts = 0, parts_with_defect = 0;
    std::uint64_t agree = 0, more = 0, less = 0;
    BoardAgreement board;
  };

  Production(const ProductionOptions& options, const rig::Rig& rig);
  void start(const std::string& title, std::size_t queued, const MeasuredFrame& empty);
  void run(const std::stop_token& stop);
  void work(MeasuredFrame& measured);
  void look_at_the_clock();
  // What changes without a part, too: objects that are too short, and the verdict by moments.
  void update_counts();
  void classify(const std::optional<CutPart>& part);
  [[nodiscard]] PartCounts counts() const;
  // Where frames came at another rate than the rig's, and the belt's way follows from it: the end of a sentence.
  [[nodiscard]] std::string odd_rate() const;
  [[nodiscard]] std::string doubt_about_moments() const;

  ProductionOptions options_;
  rig::Rig rig_;
  std::optional<Tolerance> tolerance_;

  std::vector<MeasuredFrame> slots_;
  moodycamel::ReaderWriterQueue<MeasuredFrame*> free_;
  moodycamel::ReaderWriterQueue<MeasuredFrame*> filled_;
  MeasuredFrame* claimed_ = nullptr;

  // Of the thread of the production:
  std::unique_ptr<Cutter> cutter_;
  std::optional<Classifier> classifier_;
  std::unique_ptr<VerdictRun> verdict_;
  PlacedMaps maps_;
  std::int64_t next_beat_ns_ = 0;
  std::int64_t last_arrival_ns_ = 0;
  std::optional<model::PacketHeader> first_;  // since the board was restarted
  model::PacketHeader newest_;
  bool encoder_counts_ = false;  // it has changed between two frames

  mutable std::mutex mutex_;       // of the next nine
  std::string last_inconclusive_;  // the reason of the last inconclusive part that the run did not cut off
  std::uint64_t cut_off_ = 0;      // parts that the run cut off
  MomentCounts moments_;
  PartCounts counts_;
  PartStatistics statistics_;
  std::deque<std::vector<std::string>> newest_parts_;  // the rows of the report's table
  double deepest_mm_ = 0;
  driver::DurationHistogram delays_;  // from the arrival of a part's last frame to its result
  std::exception_ptr fault_;
  std::atomic<bool> failed_{false};
  std::atomic<std::uint16_t> heartbeat_{0};  // tenths of a second while the thread works
  std::atomic<std::uint64_t> lost_{0};
  Newest<PartCounts> new_counts_;  // for the Modbus server

  std::optional<PartFiles> files_;
  bool finished_ = false;
  std::optional<LivePage> page_;
  CameraView camera_;
  std::optional<ModbusServer> modbus_;
  std::jthread thread_;
};

}  // namespace selfproj::production

#endif  // SELFPROJ_HOST_PRODUCTION_PRODUCTION_H
