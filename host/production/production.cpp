#include "host/production/production.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <exception>
#include <memory>
#include <mutex>
#include <numbers>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/files/numbers.h"
#include "host/files/signals_held.h"
#include "host/production/endpoint.h"
#include "host/production/height_map.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::production {
namespace {

constexpr std::size_t kQueuedProfiles = 2048;
constexpr std::size_t kQueuedDepthImages = 8;
// Short beside the 20 ms in which a result is wanted, and long beside a call of the kernel.
constexpr auto kNap = std::chrono::microseconds(500);
constexpr auto kNapWhenFull = std::chrono::microseconds(100);
constexpr std::int64_t kBeatNs = 100'000'000;
// A pause that ends a part by trigger is found by the time stamps of the next frame. Where none comes, the part ends
// this long after its pause by the clock of this machine.
constexpr double kLateS = 0.1;
constexpr std::size_t kPartsInReport = 100;

std::vector<std::string> report_row(const PartResult& result) {
  const auto text = [](double value) { return fmt::format("{:.2f}", files::rounded(value, 2)); };
  const auto mm = [&](const std::optional<double>& value) { return value ? text(*value) : "–"; };
  const Placement placed = result.placement.value_or(Placement{});
  const bool lies = result.placement && !placed.edges.empty();
  const Defect* const worst = result.defects.empty() ? nullptr : &result.defects.front();
  return {std::to_string(result.number),
          verdict_name(result.verdict),
          mm(placed.length_mm),
          mm(placed.width_mm),
          lies ? text(placed.across_mm) : "–",
          lies ? text(placed.turn_rad * 180 / std::numbers::pi) : "–",
          std::to_string(result.defects.size()),
          worst != nullptr ? text(worst->area_mm2) : "–",
          worst != nullptr ? fmt::format("{:+.3f}", files::rounded(worst->depth_mm, 3)) : "–",
          result.reason};
}

}  // namespace

Production::Production(const ProductionOptions& options, const rig::Rig& rig) : options_(options), rig_(rig) {
  if (options.tolerance.empty() && (!options.folder.empty() || !options.modbus.empty())) {
    throw UserError(options.folder.empty() ? "--modbus" : "--parts",
                    "needs --tolerance, by which parts are classified");
  }
  if (!options.tolerance.empty()) {
    parts_of(rig);  // throws if there are none
    tolerance_ = load_tolerance(options.tolerance);
  }
}

Production::Production(const ProductionOptions& options, const rig::Rig& rig, const SectionReference& section,
                       const std::string& title, std::unique_ptr<VerdictRun> verdict)
    : Production(options, rig) {
  verdict_ = std::move(verdict);
  if (tolerance_) {
    classifier_.emplace(rig, section, *tolerance_, options.tolerance);
    cutter_ = std::make_unique<ProfileCutter>(rig);
  }
  MeasuredFrame empty;
  empty.profile.resize(rig.camera.columns);
  if (verdict_) {
    empty.m0.resize(static_cast<std::size_t>(rig.camera.columns));
    empty.m1 = empty.m0;
  }
  start(title, kQueuedProfiles, empty);
}

Production::Production(const ProductionOptions& options, const rig::Rig& rig, const images::FloatImage& reference_depth,
                       int patterns, const std::string& title)
    : Production(options, rig) {
  if (tolerance_) {
    classifier_.emplace(rig, DepthGrid(rig).cells(reference_depth), *tolerance_, options.tolerance);
    cutter_ = std::make_unique<DepthCutter>(rig, patterns);
  }
  MeasuredFrame empty;
  empty.depth = empty.difference = images::FloatImage(rig.camera.rows, rig.camera.columns);
  start(title, kQueuedDepthImages, empty);
}

void Production::start(const std::string& title, std::size_t queued, const MeasuredFrame& empty) {
  slots_.resize(queued, empty);
  free_ = moodycamel::ReaderWriterQueue<MeasuredFrame*>(queued);
  filled_ = moodycamel::ReaderWriterQueue<MeasuredFrame*>(queued);
  for (MeasuredFrame& slot : slots_) {
    free_.enqueue(&slot);
  }
  if (!options_.live.empty()) {
    page_.emplace(endpoint_of_text("--live", options_.live), rig_, title);
  }
  if (!options_.modbus.empty()) {
    modbus_.emplace(endpoint_of_text("--modbus", options_.modbus), [this, shown = PartCounts()]() mutable {
      if (const std::unique_ptr<PartCounts> newer = new_counts_.take()) {
        shown = *newer;
      }
      return modbus_registers(shown, lost_, heartbeat_, driver::now_ns());
    });
  }
  if (page_) {  // Modbus answers by now, too
    fmt::print(stderr, "live page: {}\n", page_->url());
  }
  if (!options_.folder.empty()) {
    files_.emplace(options_.folder, options_.keep);
  }
  const files::SignalsHeld held;  // signals are for the main thread
  thread_ = std::jthread([this](const std::stop_token& stop) { run(stop); });
}

MeasuredFrame& Production::claim() {
  for (;;) {
    if (failed_) {
      finish();
    }
    if (MeasuredFrame** const next = free_.peek()) {
      claimed_ = *next;
      return *claimed_;
    }
    std::this_thread::sleep_for(kNapWhenFull);
  }
}

void Production::image(const model::PacketView& packet) {
  if (!page_ || !camera_.add(packet, page_->watched())) {
    return;
  }
  rig::Rig rig = rig_;
  rig.measure.apply(model::measure_of(camera_.header()));  // a device may measure otherwise than the rig says
  const std::vector<float> line =
      rig.kind == rig::RigKind::light_section ? line_in_image(camera_.image(), rig) : std::vector<float>();
  page_->camera(camera_.header(), camera_.image(), line, exposure_figures(camera_.image(), line, rig.measure));
}

void Production::run(const std::stop_token& stop) {
  try {
    for (bool end = false; !end;) {
      end = stop.stop_requested();  // what was published before is found below
      while (MeasuredFrame** const next = filled_.peek()) {
        MeasuredFrame* const slot = *next;
        work(*slot);
        filled_.pop();
        free_.enqueue(slot);
        look_at_the_clock();
      }
      look_at_the_clock();
      if (!end) {
        std::this_thread::sleep_for(kNap);
      }
    }
    if (cutter_) {
      classify(cutter_->finish());
    }
    update_counts();
  } catch (...) {
    const std::lock_guard lock(mutex_);
    fault_ = std::current_exception();
    failed_ = true;
  }
}

void Production::work(MeasuredFrame& measured) {
  last_arrival_ns_ = measured.arrival_ns;
  if (!first_ || measured.header.time_stamp < newest_.time_stamp) {  // also where the board was restarted
    first_ = measured.header;
  }
  newest_ = measured.header;
  encoder_counts_ = encoder_counts_ || first_->encoder != newest_.encoder;
  if (verdict_) {
    verdict_->add(measured.header, measured.m0, measured.m1, measured.board);
  }
  if (cutter_) {
    classify(cutter_->add(measured));
  }
  update_counts();
  if (page_) {
    page_->measured(measured);
  }
}

void Production::update_counts() {
  if (cutter_ && cutter_->specks() != counts_.specks) {  // no other thread changes them
    {
      const std::lock_guard lock(mutex_);
      counts_.specks = cutter_->specks();
    }
    new_counts_.put(std::make_unique<PartCounts>(counts_));
  }
  if (verdict_) {
    const std::lock_guard lock(mutex_);
    moments_.frames = verdict_->judged_frames();
    moments_.defect_frames = verdict_->defect_frames();
    moments_.parts = verdict_->parts();
    moments_.parts_with_defect = verdict_->parts_with_defect();
    moments_.board = verdict_->board();
  }
}

void Production::look_at_the_clock() {
  const std::int64_t now = driver::now_ns();
  if (now >= next_beat_ns_) {
    next_beat_ns_ = now + kBeatNs;
    ++heartbeat_;
  }
  const bool by_trigger = cutter_ && rig_.parts->cut == rig::PartCut::trigger;
  if (by_trigger && cutter_->in_part() && filled_.peek() == nullptr &&
      static_cast<double>(now - last_arrival_ns_) * 1e-9 > rig_.parts->pause_s + kLateS) {
    classify(cutter_->finish());
  }
}

void Production::classify(const std::optional<CutPart>& part) {
  if (!part) {
    return;
  }
  PartResult result = classifier_->classify(*part, maps_);
  if (verdict_) {
    result.moments = verdict_->judge(*part, result);
  }
  {
    const std::lock_guard lock(mutex_);
    if (result.moments && result.moments->frames > 0 && result.verdict != Verdict::inconclusive) {
      const bool bad = result.verdict == Verdict::bad;
      ++(result.moments->defect() == bad ? moments_.agree : bad ? moments_.less : moments_.more);
    }
    result.number = counts_.parts() + 1;
    const std::int64_t now = driver::now_ns();
    result.delay_ns = now - part->last_ns;
    ++counts_.verdicts.at(static_cast<std::size_t>(result.verdict));
    counts_.last_part = result.number;
    counts_.last_verdict = result.verdict;
    counts_.last_defects = result.defects.size();
    counts_.last_depth_mm = result.defects.empty() ? 0 : result.defects.front().depth_mm;
    counts_.last_moments = result.moments;
    counts_.by_moments += result.moments && result.moments->defect() ? 1 : 0;
    counts_.board_disagrees = verdict_ ? verdict_->board().disagree : 0;
    counts_.last_delay_ns = result.delay_ns;
    counts_.last_ns = now;
    if (part->cut_off) {
      ++cut_off_;
    } else if (result.verdict == Verdict::inconclusive) {
      last_inconclusive_ = result.reason;
    }
    delays_.add(result.delay_ns);
    add_figures(result, statistics_);
    deepest_mm_ = std::max(deepest_mm_, deepest_mm(result.defects));
    newest_parts_.push_back(report_row(result));
    if (newest_parts_.size() > kPartsInReport) {
      newest_parts_.pop_front();
    }
  }
  new_counts_.put(std::make_unique<PartCounts>(counts_));  // no other thread changes them
  if (files_) {
    files_->add(result, maps_);
  }
  if (page_) {
    page_->part(result, maps_, statistics_);
  }
}

PartCounts Production::counts() const {
  const std::lock_guard lock(mutex_);
  return counts_;
}

void Production::report(const driver::Counters& counters, std::vector<report::Fact> figures) {
  lost_ = counters.lost_board + counters.lost_ring + counters.lost_network;
  if (page_) {
    const std::vector<report::Fact> more = facts();
    figures.insert(figures.end(), more.begin(), more.end());
    page_->report(figures);
  }
}

void Production::finish() {
  thread_.request_stop();
  if (thread_.joinable()) {
    thread_.join();
  }
  if (files_ && !finished_) {
    finished_ = true;
    files_->finish(statistics_);
  }
  if (fault_) {
    std::rethrow_exception(fault_);
  }
}

std::vector<report::Fact> Production::facts() const {
  const auto ms = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-6; };
  std::vector<report::Fact> facts;
  if (page_) {
    facts.push_back({"live_dropped", "pictures dropped for slow browsers", report::fact_number(page_->dropped())});
  }
  const std::lock_guard lock(mutex_);
  if (verdict_) {
    const std::vector<report::Fact> of_moments = {
        {"verdict_frames", "frames judged by moments", report::fact_number(moments_.frames)},
        {"verdict_defect_frames", "frames with a defect by moments", report::fact_number(moments_.defect_frames)},
        {"verdict_parts", "parts judged by moments", report::fact_number(moments_.parts)},
        {"verdict_parts_with_defect", "parts with a defect by moments",
         report::fact_number(moments_.parts_with_defect)}};
    facts.insert(facts.end(), of_moments.begin(), of_moments.end());
    const BoardAgreement& board = moments_.board;
    if (board.frames > 0) {
      facts.push_back({"board_frames", "frames judged by the board", report::fact_number(board.frames)});
      facts.push_back({"board_defect_frames", "frames with a defect by the board", report::fact_number(board.defects)});
      facts.push_back({"board_after_gap", "not compared, behind missing frames", report::fact_number(board.after_gap)});
      facts.push_back({"board_disagrees", "judged otherwise by the model", report::fact_number(board.disagree)});
    }
  }
  if (!classifier_) {
    return facts;
  }
  if (verdict_) {
    facts.push_back(
        {"verdict_agrees", "parts judged alike by moments and heights", report::fact_number(moments_.agree)});
    facts.push_back({"verdict_more", "parts with a defect by moments alone", report::fact_number(moments_.more)});
    facts.push_back({"verdict_less", "parts with a defect by heights alone", report::fact_number(moments_.less)});
  }
  const std::vector<report::Fact> of_parts = {
      {"parts", "parts", report::fact_number(counts_.parts())},
      {"parts_good", "good parts", report::fact_number(counts_.verdicts[0])},
      {"parts_bad", "bad parts", report::fact_number(counts_.verdicts[1])},
      {"parts_inconclusive", "inconclusive parts", report::fact_number(counts_.verdicts[2])},
      {"specks",
       rig_.kind == rig::RigKind::scanner ? "pauses without a depth image before" : "objects too short to be a part",
       report::fact_number(counts_.specks)},
      {"result_delay_p50_ms", "a part's last frame to its result, median", ms(delays_.percentile_ns(0.5)), "ms"},
      {"result_delay_p99_ms", "a part's last frame to its result, 99 %", ms(delays_.percentile_ns(0.99)), "ms"}};
  facts.insert(facts.end(), of_parts.begin(), of_parts.end());
  if (files_) {
    facts.push_back({"part_folders", "folders of parts", report::fact_number(files_->folders())});
    facts.push_back({"part_folders_left_out", "folders left out", report::fact_number(files_->folders_left_out())});
  }
  return facts;
}

void Production::describe(report::ReportParts& report) const {
  const std::lock_guard lock(mutex_);
  if (!classifier_) {
    return;
  }
  report.settings.push_back({"tolerance", "tolerance", options_.tolerance});
  for (std::size_t i = 0; i < kVerdictNames.size(); ++i) {
    report.highlights.push_back({kVerdictNames.at(i), fmt::format("{} parts", kVerdictNames.at(i)),
                                 report::fact_number(counts_.verdicts.at(i))});
  }
  double widest = 0;
  for (const ToleranceRegion& region : tolerance_->regions) {
    widest = std::max({widest, std::abs(region.low_mm), std::abs(region.high_mm)});
  }
  report.difference_mm = deepest_mm_ > 0 ? deepest_mm_ : widest;
  if (newest_parts_.empty()) {
    return;
  }
  report.tables.push_back({newest_parts_.size() < counts_.parts()
                               ? fmt::format("The last {} of {} parts", newest_parts_.size(), counts_.parts())
                               : "The parts",
                           {"part", "verdict", "length, mm", "width, mm", "across, mm", "turned, °", "defects",
                            "largest, mm²", "its depth, mm", "reason"},
                           {newest_parts_.begin(), newest_parts_.end()},
                           options_.folder.empty()
                               ? ""
                               : "All parts, with all that was found, are in parts.jsonl of " + options_.folder + "."});
}

std::string Production::doubt_about_moments() const {
  const std::uint64_t parts = counts_.parts();
  if (!verdict_) {
    return "";
  }
  const char* const ask =
      "; are --start, --pitch and --shift of the table, or the light that begins a part, those of "
      "these parts?";
  // Of many parts, one in so many may differ. Those that the end of the frames cuts off may come by one way only.
  constexpr std::uint64_t kOneOfMany = 20;
  const std::uint64_t apart = std::max(moments_.parts, parts) - std::min(moments_.parts, parts);
  if ((parts > 0 && moments_.parts == 0) || apart > cut_off_ + std::max(parts, moments_.parts) / kOneOfMany) {
    const std::uint64_t defects = moments_.parts_with_defect;
    return fmt::format("by moments {} parts came{}, by heights {}{}", moments_.parts,
                       defects > 0 ? fmt::format(" ({} with a defect)", defects) : std::string(), parts, ask);
  }
  if (moments_.parts_with_defect > counts_.by_moments + 1) {
    return fmt::format("by moments {} parts have a defect, but only {} where heights find a part{}",
                       moments_.parts_with_defect, counts_.by_moments, ask);
  }
  constexpr std::uint64_t kOneOf = 100;  // parts may be taken for bad by noise
  if (kOneOf * moments_.more > parts) {
    return fmt::format(
        "by moments {} of the good parts {} a defect; noise may make them (`selfproj verdict table` says how many; a "
        "larger --defect or --margin helps){}",
        moments_.more, moments_.more == 1 ? "has" : "have", ask);
  }
  const std::uint64_t bad = counts_.verdicts[static_cast<std::size_t>(Verdict::bad)];
  if (kOneOfMany * moments_.less > bad) {
    return fmt::format(
        "by moments {} of the {} bad parts {} no defect; {}columns beside edges and walls are not judged (`selfproj "
        "verdict table` says how much is){}",
        moments_.less, bad, moments_.less == 1 ? "has" : "have",
        verdict_->one_side_only() ? "the table looks for defects above or below only (--look-for), and " : "", ask);
  }
  return "";
}

std::string Production::doubt() const {
  const std::lock_guard lock(mutex_);
  if (verdict_ && moments_.board.disagree > 0) {
    return fmt::format(
        "board and model judge {} of {} frames differently, so the board has another table, or packets "
        "are wrong; {}",
        moments_.board.disagree, moments_.board.frames, moments_.board.first);
  }
  if (!classifier_) {
    return "";
  }
  const rig::RigParts& parts = *rig_.parts;
  if (rig_.kind == rig::RigKind::light_section && parts.by_encoder && !encoder_counts_) {
    return "the encoder did not count, so the belt stood still or its encoder is not connected; `belt: clock` in the "
           "rig's section `parts` takes speed and time instead";
  }
  const std::uint64_t inconclusive = counts_.verdicts[static_cast<std::size_t>(Verdict::inconclusive)] - cut_off_;
  if (inconclusive > 0) {
    return fmt::format("{} of {} parts {} no verdict; the last: {}{}", inconclusive, counts_.parts(),
                       inconclusive == 1 ? "has" : "have", last_inconclusive_, odd_rate());
  }
  if (std::string moments = doubt_about_moments(); !moments.empty()) {
    return moments;
  }
  if (counts_.parts() > 0) {
    return "";
  }
  if (counts_.specks > 0 && rig_.kind == rig::RigKind::light_section) {
    return fmt::format(
        "no part was cut: {} times something came that is shorter than min_length_mm ({} mm) of the rig's "
        "section `parts`",
        counts_.specks, parts.min_length_mm);
  }
  switch (parts.cut) {
    case rig::PartCut::profile:
      return fmt::format(
          "no part was cut: nothing was higher than above_mm ({} mm) over min_width_mm ({} mm) of a "
          "profile; the rig's section `parts` and plane_z_mm say where the belt is and what a part is",
          parts.above_mm, parts.min_width_mm);
    case rig::PartCut::distance:
      return fmt::format("no part was cut: the belt moved less than length_mm ({} mm)", parts.length_mm);
    case rig::PartCut::trigger:
    case rig::PartCut::image:
      break;
  }
  return "no part was cut: no depth image came complete between two pauses";
}

std::string Production::odd_rate() const {
  constexpr double kOdd = 0.05;
  const bool calibrated = rig_.sources && rig_.sources->speed == rig::ValueSource::measured;  // of it no rate is known
  if (rig_.kind != rig::RigKind::light_section || rig_.parts->by_encoder || !first_ || calibrated) {
    return "";
  }
  const double seconds = model::seconds_of_clocks(newest_.time_stamp - first_->time_stamp, rig_.pixel_clock_hz());
  const double wanted = rig_.camera.sent().frame_rate_hz;
  const double rate = seconds > 0 ? static_cast<double>(newest_.sequence - first_->sequence) / seconds : wanted;
  return std::abs(rate / wanted - 1) < kOdd
             ? ""
             : fmt::format(
                   "; by their time stamps or --mm-per-image {:.0f} frames a second came, the rig says {:.0f}: what "
                   "lies along the belt is taken from speed and time stamps (from frame to frame {:.3g} mm, by the rig "
                   "{:.3g})",
                   rate, wanted, rig_.conveyor.speed_mm_per_s / rate, rig_.conveyor.speed_mm_per_s / wanted);
}

std::string Production::status_text() const {
  const PartCounts all = counts();
  return classifier_ ? fmt::format("{} parts: {} good, {} bad, {} inconclusive", all.parts(), all.verdicts[0],
                                   all.verdicts[1], all.verdicts[2])
                     : std::string();
}

std::string Production::end_text() const {
  const std::string parts = status_text();
  const std::lock_guard lock(mutex_);
  std::string moments;
  if (verdict_) {
    moments = fmt::format("by moments {} of {} parts have a defect, in {} of {} frames", moments_.parts_with_defect,
                          moments_.parts, moments_.defect_frames, moments_.frames);
    if (classifier_) {
      moments += fmt::format("; as by heights {}, more {}, less {}", moments_.agree, moments_.more, moments_.less);
    }
    moments += "\n";
    if (const BoardAgreement& board = moments_.board; board.frames > 0) {
      moments +=
          fmt::format("the board judged {} frames, {} with a defect; {} otherwise than the model{}\n", board.frames,
                      board.defects, board.disagree, board.disagree > 0 ? ", first " + board.first : std::string());
    }
  }
  if (!classifier_) {
    return moments;
  }
  const std::string delay =
      counts_.parts() > 0 ? fmt::format("; result after the last frame p50 {}, p99 {}",
                                        time_text(delays_.percentile_ns(0.5)), time_text(delays_.percentile_ns(0.99)))
                          : std::string();
  return moments + parts + delay + (files_ ? " → " + options_.folder : std::string()) + "\n";
}

}  // namespace selfproj::production
