#include "lab/part_detection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/stop_signal.h"
#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/learn.h"
#include "host/production/part_reference.h"
#include "host/production/tolerance.h"
#include "host/production/verdict_run.h"
#include "host/production/verdict_table.h"
#include "lab/learned_rig.h"
#include "lab/planted_parts.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/rig/rig.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/perturbed_rig.h"

namespace selfproj::lab {
namespace {

using Json = nlohmann::ordered_json;

// Upper bounds of the bins of the curves, mm.
constexpr std::array<double, 7> kSizes = {0.75, 1, 1.5, 2, 3, 5, 10};
constexpr std::array<double, 7> kDepths = {0.07, 0.1, 0.15, 0.2, 0.3, 0.5, 1};

// Smallest areas, mm2, and bands, mm, of the curves of false alarms.
constexpr std::array<double, 4> kAreas = {0.0625, 0.25, 0.5, 2};
constexpr std::array<double, 7> kBands = {0.02, 0.03, 0.04, 0.05, 0.07, 0.1, 0.15};

// A defect is found by one whose middle is within its radius and this of its own, mm; and one that is further from
// all planted ones than their radius and twice this is a false alarm.
constexpr double kNear = 1;

constexpr double kBesideParts = 6;  // mm that are lit beside a part
constexpr double kMaxShift = 2;     // mm across, of the parts that are judged by moments, too

template <std::size_t Count>
std::size_t bin_of(const std::array<double, Count>& bounds, double value) {
  const auto at = std::lower_bound(bounds.begin(), bounds.end(), value);
  return std::min(static_cast<std::size_t>(at - bounds.begin()), Count - 1);
}

template <std::size_t Count>
std::string bin_text(const std::array<double, Count>& bounds, std::size_t bin, double least) {
  return fmt::format("{:g}–{:g}", bin == 0 ? least : bounds.at(bin - 1), bounds.at(bin));
}

// How far the defect is from the edges of its tread, less its radius.
double from_edges(const PlantedDefect& defect) {
  const double wall = defect.tread == 0 ? -PlantedPart::kTreadWidth : 0;
  return std::min({defect.along, PlantedPart::kLength - defect.along, defect.across - wall,
                   wall + PlantedPart::kTreadWidth - defect.across}) -
         defect.size / 2;
}

// `middle` is where the host has the middle of the part across: its y is that of the camera.
double distance(const production::Defect& found, double middle, const PlantedDefect& planted) {
  return std::hypot(found.along_mm - planted.along, found.across_mm - middle - planted.across);
}

// What was found of what was planted.
class Tally {
 public:
  Tally(double edge_mm, const production::Tolerance& tolerance)
      : edge_mm_(edge_mm), middle_(0.5 * (tolerance.left_mm + tolerance.right_mm)) {}

  // Whether the host found the goal's defect of the part that was added last; nothing if it could not judge the part.
  [[nodiscard]] std::optional<bool> found_goal() const { return found_goal_; }

  void add(const DrawnPart& part, const production::PartResult& result) {
    found_goal_.reset();
    ++of_.parts;
    of_.inconclusive += result.verdict == production::Verdict::inconclusive ? 1 : 0;
    for (std::size_t i = 0; i < part.defects.size(); ++i) {
      const PlantedDefect& planted = part.defects[i];
      const auto at = std::find_if(result.defects.begin(), result.defects.end(), [&](const production::Defect& found) {
        return distance(found, middle_, planted) <= planted.size / 2 + kNear;
      });
      count(planted, at != result.defects.end() ? &*at : nullptr, i == 0);
      if (i == 0 && result.verdict != production::Verdict::inconclusive) {
        found_goal_ = at != result.defects.end();
      }
    }
    const auto wrong =
        std::count_if(result.defects.begin(), result.defects.end(), [&](const production::Defect& found) {
          return std::none_of(part.defects.begin(), part.defects.end(), [&](const PlantedDefect& planted) {
            return distance(found, middle_, planted) <= planted.size / 2 + 2 * kNear;
          });
        });
    of_.false_defects += static_cast<std::uint64_t>(wrong);
    of_.false_parts += wrong > 0 ? 1 : 0;
  }

  [[nodiscard]] const PartDetectionResult& counts() const { return of_; }
  [[nodiscard]] const DetectionCount& cell(std::size_t size, std::size_t depth) const {
    return cells_.at(size).at(depth);
  }
  [[nodiscard]] const DetectionCount& at_edges() const { return at_edges_; }
  // Of the goal's defects that were found: how far their depth was off, mm.
  [[nodiscard]] std::pair<double, double> depth_error() const {
    const double n = std::max(1.0, static_cast<double>(of_.goal.found));
    const double mean = depth_sum_ / n;
    return {mean, std::sqrt(std::max(0.0, depth_squares_ / n - mean * mean))};
  }

 private:
  void count(const PlantedDefect& planted, const production::Defect* found, bool of_goal) {
    const bool judged = from_edges(planted) >= edge_mm_;
    if (of_goal) {
      (judged ? of_.goal : of_.goal_at_edges).add(found != nullptr);
      if (judged && found != nullptr) {
        const double off = found->depth_mm + planted.depth;  // a dent is below 0
        depth_sum_ += off;
        depth_squares_ += off * off;
      }
    } else if (judged) {
      cells_.at(bin_of(kSizes, planted.size))
          .at(bin_of(kDepths, planted.depth < 0 ? -planted.depth : planted.depth))
          .add(found != nullptr);
    } else {
      at_edges_.add(found != nullptr);
    }
  }

  double edge_mm_;
  double middle_;
  PartDetectionResult of_;
  std::array<std::array<DetectionCount, kDepths.size()>, kSizes.size()> cells_;
  DetectionCount at_edges_;
  double depth_sum_ = 0;
  double depth_squares_ = 0;
  std::optional<bool> found_goal_;
};

// How often good parts would have been called bad, had the smallest area and the band been others.
class FalseAlarms {
 public:
  FalseAlarms(const rig::Rig& rig, const production::SectionReference& section,
              const production::Tolerance& tolerance) {
    for (const double area : kAreas) {
      production::Tolerance open = tolerance;
      open.min_defect_mm2 = area;
      for (production::ToleranceRegion& region : open.regions) {
        region.low_mm = -1e6;
        region.high_mm = 1e6;
      }
      classifiers_.emplace_back(rig, section, open, "the tolerance");
    }
  }

  void add(const production::CutPart& part) {
    ++parts_;
    for (std::size_t a = 0; a < kAreas.size(); ++a) {
      const production::PartResult result = classifiers_[a].classify(part, maps_);
      double furthest = 0;
      for (const production::RegionFigures& region : result.regions) {
        furthest = std::max({furthest, region.highest_mm, -region.lowest_mm});
      }
      for (std::size_t b = 0; b < kBands.size(); ++b) {
        beyond_.at(a).at(b) += furthest > kBands.at(b) ? 1 : 0;
      }
    }
  }

  [[nodiscard]] std::uint64_t parts() const { return parts_; }
  [[nodiscard]] std::uint64_t beyond(std::size_t area, std::size_t band) const { return beyond_.at(area).at(band); }

 private:
  std::vector<production::Classifier> classifiers_;
  production::PlacedMaps maps_;
  std::uint64_t parts_ = 0;
  std::array<std::array<std::uint64_t, kBands.size()>, kAreas.size()> beyond_{};
};

class Detection {
 public:
  Detection(const PartDetectionOptions& options, const std::function<void(std::size_t, std::size_t)>& progress)
      : options_(options), progress_(progress), drawn_(rig_of_planted_parts(rig::load_rig("light-section"))) {
    all_ = options.learn_parts + options.parts + options.good_parts;
    if (!options.null_test) {
      all_ += static_cast<std::size_t>(learning_images(drawn_, learning_)) +
              static_cast<std::size_t>(scanning_images(drawn_, learning_.every_line));
    }
    set_up();
  }

  PartDetectionResult run() {
    const light_section::DifferentialProfiler profiler(setup_->rig, setup_->references[0]);
    const production::SectionReference section = production::section_of(setup_->rig, setup_->references[0], profiler);
    const production::LearnOptions learn;
    production::Learner learner(setup_->rig, section, learn);
    parts_of(options_.seed - 1, 0, options_.learn_parts, false,
             [&](const DrawnPart&, production::CutPart&& part) { learner.add(std::move(part)); });
    tolerance_ = production::parse_tolerance(production::to_yaml(learner.learn("the good parts")), "the tolerance");
    const production::Classifier classifier(setup_->rig, section, tolerance_, "the tolerance");
    production::PlacedMaps maps;
    tally_.emplace(learn.edge_mm, tolerance_);
    good_.emplace(learn.edge_mm, tolerance_);
    alarms_.emplace(setup_->rig, section, tolerance_);
    const auto take_planted = [&](const DrawnPart& drawn, production::CutPart&& part) {
      const production::PartResult result = classifier.classify(part, maps);
      tally_->add(drawn, result);
      count_moments(drawn, part, result);
    };
    const auto take_good = [&](const DrawnPart& drawn, production::CutPart&& part) {
      const production::PartResult result = classifier.classify(part, maps);
      good_->add(drawn, result);
      if (options_.verdict) {
        count_moments(drawn, part, result);
      } else {
        alarms_->add(part);
      }
    };
    if (options_.verdict) {
      make_table();
    }
    if (options_.line_parts > 0) {
      make_line();
    }
    // A share of each at a time, so that a run that is stopped has both.
    constexpr std::uint64_t kShares = 50;
    const files::StopSignal stop;
    for (std::uint64_t i = 0; i < kShares && !files::StopSignal::came(); ++i) {
      const auto share = [&](std::uint64_t of, std::uint64_t k) { return of * k / kShares; };
      const std::uint64_t first = share(options_.parts, i);
      parts_of(options_.seed, first, share(options_.parts, i + 1) - first, true, take_planted);
      const std::uint64_t good = share(options_.good_parts, i);
      const std::uint64_t of_share = share(options_.good_parts, i + 1) - good;
      if (options_.verdict) {
        good_parts_of(options_.parts + i, good, of_share, take_good);
      } else {
        parts_of(options_.seed, options_.parts + good, of_share, false, take_good);
      }
    }
    return result();
  }

 private:
  using Take = std::function<void(const DrawnPart&, production::CutPart&&)>;

  // The table that `selfproj verdict table --defect 2x2` makes.
  void make_table() {
    verdict_options_.defect_across_mm = verdict_options_.defect_along_mm = kGoalSize;
    verdict_options_.start = 0;
    verdict_options_.pitch = model::kCountMask / 2;
    table_ =
        production::VerdictTables(setup_->rig, setup_->references[0], tolerance_, verdict_options_, "the tolerance")
            .table();
  }

  void make_line() {
    const light_section::ReferenceProfile& reference = setup_->references[0];
    line_ = {rig::to_yaml(setup_->rig),
             light_section::reference_csv(setup_->rig, reference),
             production::to_yaml(tolerance_),
             {},
             {}};
    constexpr std::uint64_t kNumber = 1'000'000;  // none of those that are judged here
    const PlantedParts belt(*setup_, options_.render);
    for (std::uint64_t i = 0; i < options_.line_parts; ++i) {
      for (const bool bad : {false, true}) {
        DrawnPart part = draw_part(drawn_, options_.seed, kNumber + i, bad, kMaxShift);
        part.pose = draw_part(drawn_, options_.seed, kNumber, false, kMaxShift).pose;
        part.defects.resize(bad ? 1 : 0);
        std::vector<images::Image>& frames = bad ? line_.bad : line_.good;
        for (images::Image& image : belt.images_of(part)) {
          frames.push_back(std::move(image));
        }
      }
    }
  }

  // For the parts that follow, which lie where the host finds them.
  void begin_moments() {
    run_.reset();
    if (table_) {
      run_.emplace(setup_->rig, *table_, "the table", 0,
                   std::make_unique<production::VerdictTables>(setup_->rig, setup_->references[0], tolerance_,
                                                               verdict_options_, "the tolerance"));
    }
  }

  void count_moments(const DrawnPart& drawn, const production::CutPart& part, const production::PartResult& result) {
    const std::optional<production::PartMoments> found = run_ ? run_->judge(part, result) : std::nullopt;
    if (!found) {
      return;
    }
    if (drawn.defects.empty()) {
      ++moments_.good_parts;
      moments_.false_parts += found->defect() ? 1 : 0;
      return;
    }
    const bool of_host = tally_->found_goal().value_or(false);
    const PlantedDefect& goal = drawn.defects.front();
    const bool judged = from_edges(goal) >= production::LearnOptions{}.edge_mm;
    (!of_host ? moments_.of_others : judged ? moments_.of_host : moments_.of_host_at_edges).add(found->defect());
    if (of_host && !found->defect()) {
      moments_.missed.push_back(fmt::format("{:+.1f} mm deep at ({:.2f}, {:.2f}) mm, shifted by {:.2f}", goal.depth,
                                            goal.along, goal.across, drawn.pose.across_mm));
    }
  }

  // Good parts that all lie as part `number` of the series, each with noise of its own.
  void good_parts_of(std::uint64_t number, std::uint64_t first, std::uint64_t count, const Take& take) {
    constexpr std::uint64_t kAtOnce = 16;
    constexpr std::uint64_t kNoise = 1'000'000'000;
    DrawnPart drawn = draw_part(drawn_, options_.seed, number, false, kMaxShift);
    PlantedParts belt(*setup_, options_.render);
    const CleanPart clean = count > 0 ? belt.clean(drawn) : CleanPart{};
    for (std::uint64_t begin = 0; begin < count && !files::StopSignal::came(); begin += kAtOnce) {
      std::vector<std::uint64_t> noise;
      for (std::uint64_t i = begin; i < std::min(count, begin + kAtOnce); ++i) {
        noise.push_back(kNoise * options_.seed + first + i);
      }
      pass(std::vector<DrawnPart>(noise.size(), drawn), take,
           [&](const PlantedParts::Take& take_frame) { belt.pass(clean, noise, options_.threads, take_frame); });
    }
  }

  void set_up() {
    make_setup();
    // Light falls only where parts pass.
    const rig::RigProjector& projector = drawn_.projector;
    const double distance = drawn_.plane_z_mm - projector.z_mm;
    const double half =
        (PlantedPart::kTreadWidth + kBesideParts) / distance * projector.focal_length_mm / projector.column_pitch_mm;
    images::FloatImage& pattern = setup_->pattern;
    for (int column = 0; column < pattern.columns; ++column) {
      for (int line = 0; line < pattern.rows && std::abs(column - 0.5 * (pattern.columns - 1)) > half; ++line) {
        pattern.row(line)[column] = 0;
      }
    }
  }

  void make_setup() {
    const auto one_more = [this] { progress_(++done_, all_); };
    const MakeScene good = [](const rig::Rig& rig) {
      return std::make_unique<PlantedPart>(rig, PartPose{}, std::vector<PlantedDefect>{});
    };
    if (options_.null_test) {
      setup_.emplace(sim::self_projection(drawn_, drawn_, *good(drawn_), options_.render, true));
      return;
    }
    const sim::PerturbedRig actual = sim::hidden_rig(drawn_, options_.perturbed_rig_seed);
    learning_.seed = options_.perturbed_rig_seed;
    rig::Rig learned = learn_rig(actual, options_.render, learning_, one_more).rig;
    learned.parts = drawn_.parts;
    setup_.emplace(scanned_projection(learned, actual, good, {options_.render, learning_.every_line, true}, one_more));
  }

  // Passes parts by the camera, and hands on what the cutter makes of them. Throws CheckFailed if that is not as many.
  void parts_of(std::uint64_t seed, std::uint64_t first, std::uint64_t count, bool planted, const Take& take) {
    constexpr std::uint64_t kAtOnce = 8;
    PlantedParts belt(*setup_, options_.render);
    for (std::uint64_t begin = 0; begin < count && !files::StopSignal::came(); begin += kAtOnce) {
      std::vector<DrawnPart> drawn;
      for (std::uint64_t i = begin; i < std::min(count, begin + kAtOnce); ++i) {
        drawn.push_back(draw_part(drawn_, seed, first + i, planted, options_.verdict ? kMaxShift : 1));
        if (options_.verdict && planted) {
          drawn.back().defects.resize(1);
        }
      }
      pass(drawn, take, [&](const PlantedParts::Take& take_frame) { belt.pass(drawn, options_.threads, take_frame); });
    }
  }

  // Cuts the parts out of the frames that `pass_frames` passes on.
  void pass(const std::vector<DrawnPart>& drawn, const Take& take,
            const std::function<void(const PlantedParts::Take&)>& pass_frames) {
    std::size_t came = 0;
    production::ProfileCutter cutter(setup_->rig);
    begin_moments();
    const auto take_part = [&](std::optional<production::CutPart> part) {
      if (part && came < drawn.size()) {
        take(drawn[came], std::move(*part));
      }
      came += part ? 1 : 0;
    };
    pass_frames([&](const model::PacketHeader& header, const light_section::ProfileView& profile,
                    const model::Moments& moments) {
      if (run_) {
        run_->add(header, moments.m0, moments.m1);
      }
      take_part(cutter.add(header, profile, 0));
    });
    take_part(cutter.finish());
    if (came != drawn.size()) {
      throw CheckFailed(fmt::format("{} parts were cut out of {}", came, drawn.size()));
    }
    done_ += drawn.size();
    progress_(done_, all_);
  }

  PartDetectionResult result() const;
  [[nodiscard]] report::ReportTable detection_table() const;
  [[nodiscard]] report::ReportTable alarm_table() const;
  [[nodiscard]] report::ReportTable moments_table() const;
  [[nodiscard]] report::ReportTable summary_table(const PartDetectionResult& result) const;
  [[nodiscard]] Json data(const PartDetectionResult& result) const;
  [[nodiscard]] std::vector<report::ReportPlot> plots() const;

  const PartDetectionOptions& options_;
  const std::function<void(std::size_t, std::size_t)>& progress_;
  rig::Rig drawn_;
  LearningSettings learning_;
  std::optional<sim::LightSection> setup_;
  production::Tolerance tolerance_;
  std::optional<Tally> tally_;  // parts with planted defects
  std::optional<Tally> good_;   // parts without
  std::optional<FalseAlarms> alarms_;
  production::VerdictOptions verdict_options_;
  std::optional<production::VerdictTable> table_;
  std::optional<production::VerdictRun> run_;
  MomentDetection moments_;
  PartLine line_;
  std::size_t done_ = 0;
  std::size_t all_ = 0;
};

std::string percent(const DetectionCount& count) {
  return count.planted == 0 ? "–" : fmt::format("{:.1f} % of {}", 100 * count.share(), count.planted);
}

report::ReportTable Detection::detection_table() const {
  report::ReportTable table{"Defects found, by size across and depth, mm",
                            {"size"},
                            {},
                            "Defects that lie wholly on the surface that is judged."};
  for (std::size_t depth = 0; depth < kDepths.size(); ++depth) {
    table.header.push_back(bin_text(kDepths, depth, kMinDepth));
  }
  for (std::size_t size = 0; size < kSizes.size(); ++size) {
    table.rows.push_back({bin_text(kSizes, size, kMinSize)});
    for (std::size_t depth = 0; depth < kDepths.size(); ++depth) {
      table.rows.back().push_back(percent(tally_->cell(size, depth)));
    }
  }
  return table;
}

report::ReportTable Detection::alarm_table() const {
  report::ReportTable table{"Good parts with a false alarm, had the smallest area and the band been these",
                            {"smallest area, mm²"},
                            {},
                            fmt::format("Of {} good parts; a band of ±0.05 mm is “0.05”.", alarms_->parts())};
  for (const double band : kBands) {
    table.header.push_back(fmt::format("±{:g} mm", band));
  }
  for (std::size_t area = 0; area < kAreas.size(); ++area) {
    table.rows.push_back({fmt::format("{:g}", kAreas.at(area))});
    for (std::size_t band = 0; band < kBands.size(); ++band) {
      const double share = static_cast<double>(alarms_->beyond(area, band)) /
                           static_cast<double>(std::max<std::uint64_t>(1, alarms_->parts()));
      table.rows.back().push_back(fmt::format("{:.1f} %", 100 * share));
    }
  }
  return table;
}

report::ReportTable Detection::moments_table() const {
  report::ReportTable table{
      "Verdict by moments, each part where the host has placed it",
      {"what", "result"},
      {{"of the defects that the host finds on the inspected surface", percent(moments_.of_host)},
       {"of those that it finds partly in the strips along edges and walls", percent(moments_.of_host_at_edges)},
       {"of those that it does not find or judge", percent(moments_.of_others)},
       {"good parts with a defect", fmt::format("{} of {}", moments_.false_parts, moments_.good_parts)}},
      fmt::format("w = {}, h = {}, m = {}; {} columns are judged. Good parts lie in up to 50 "
                  "ways, and each has noise of its own.",
                  table_->settings.width, table_->settings.history, table_->settings.hits, table_->judged())};
  for (const std::string& missed : moments_.missed) {
    table.rows.push_back({"missed", missed});
  }
  return table;
}

report::ReportTable Detection::summary_table(const PartDetectionResult& result) const {
  const auto [mean, spread] = tally_->depth_error();
  return {
      "Planted defects and false alarms",
      {"what", "result"},
      {{fmt::format("{:g} mm wide, {:g} mm deep, on the inspected surface", kGoalSize, kGoalDepth),
        percent(result.goal)},
       {"the same, partly in the strips along edges and walls", percent(result.goal_at_edges)},
       {"any size and depth, partly or wholly in these strips", percent(tally_->at_edges())},
       {"their depth, mean error and spread, mm", fmt::format("{:+.3f}, {:.3f}", mean, spread)},
       {"parts inspected, with and without planted defects",
        fmt::format("{} + {}", tally_->counts().parts, good_->counts().parts)},
       {"parts with a false defect", fmt::format("{} + {}", tally_->counts().false_parts, good_->counts().false_parts)},
       {"inconclusive parts", fmt::format("{} + {}", tally_->counts().inconclusive, good_->counts().inconclusive)}},
      ""};
}

std::vector<report::ReportPlot> Detection::plots() const {
  report::ReportPlot plot{"Defects found", "size, mm", "found, %", {}, 1};
  for (std::size_t depth = 0; depth < kDepths.size(); ++depth) {
    report::ReportTrace trace{{}, {}, depth % 2 == 0 ? "a" : "b", bin_text(kDepths, depth, kMinDepth) + " mm deep"};
    for (std::size_t size = 0; size < kSizes.size(); ++size) {
      const DetectionCount& cell = tally_->cell(size, depth);
      trace.x.push_back(std::sqrt((size == 0 ? kMinSize : kSizes.at(size - 1)) * kSizes.at(size)));
      trace.y.push_back(cell.planted > 0 ? 100 * cell.share() : std::nan(""));
    }
    plot.traces.push_back(std::move(trace));
  }
  return {plot};
}

Json count_json(const DetectionCount& count) {
  return {{"planted", count.planted}, {"found", count.found}, {"share", count.share()}};
}

Json tally_json(const PartDetectionResult& counts) {
  return {{"parts", counts.parts},
          {"parts_with_a_false_defect", counts.false_parts},
          {"false_defects", counts.false_defects},
          {"inconclusive", counts.inconclusive}};
}

Json Detection::data(const PartDetectionResult& result) const {
  Json json{{"goal", count_json(result.goal)},
            {"goal_at_edges", count_json(result.goal_at_edges)},
            {"at_edges", count_json(tally_->at_edges())},
            {"planted_parts", tally_json(tally_->counts())},
            {"good_parts", tally_json(good_->counts())},
            {"false_share", static_cast<double>(result.false_parts) / static_cast<double>(result.parts)}};
  const auto [mean, spread] = tally_->depth_error();
  json["depth_error_mm"] = {{"mean", mean}, {"spread", spread}};
  json["learn_parts"] = options_.learn_parts;
  for (const production::ToleranceRegion& region : tolerance_.regions) {
    json["bands"].push_back({{"region", region.name}, {"low_mm", region.low_mm}, {"high_mm", region.high_mm}});
  }
  if (table_) {
    json["moments"] = {{"of_host", count_json(moments_.of_host)},
                       {"of_host_at_edges", count_json(moments_.of_host_at_edges)},
                       {"of_others", count_json(moments_.of_others)},
                       {"good_parts", moments_.good_parts},
                       {"false_parts", moments_.false_parts},
                       {"missed", moments_.missed},
                       {"width", table_->settings.width},
                       {"history", table_->settings.history},
                       {"hits", table_->settings.hits},
                       {"judged_columns", table_->judged()}};
  }
  for (std::size_t size = 0; size < kSizes.size(); ++size) {
    for (std::size_t depth = 0; depth < kDepths.size(); ++depth) {
      Json cell = count_json(tally_->cell(size, depth));
      cell["size_mm"] = {size == 0 ? kMinSize : kSizes.at(size - 1), kSizes.at(size)};
      cell["depth_mm"] = {depth == 0 ? kMinDepth : kDepths.at(depth - 1), kDepths.at(depth)};
      json["curves"].push_back(std::move(cell));
    }
  }
  return json;
}

PartDetectionResult Detection::result() const {
  PartDetectionResult result = tally_->counts();
  const PartDetectionResult& good = good_->counts();
  result.parts += good.parts;
  result.false_defects += good.false_defects;
  result.false_parts += good.false_parts;
  result.inconclusive += good.inconclusive;
  result.moments = moments_;
  result.line = line_;
  result.tables = {summary_table(result)};
  if (table_) {
    result.tables.push_back(moments_table());
  } else {
    result.tables.push_back(detection_table());
    result.tables.push_back(alarm_table());
  }
  result.data = data(result).dump();
  const double share = static_cast<double>(result.false_parts) / static_cast<double>(result.parts);
  if (!(result.goal.share() >= kMinFound)) {
    result.not_reached.push_back(fmt::format("{:g} mm wide, {:g} mm deep: {} found, at least {:g} % wanted", kGoalSize,
                                             kGoalDepth, percent(result.goal), 100 * kMinFound));
  }
  if (!(share <= kMaxFalseParts)) {
    result.not_reached.push_back(fmt::format("{} of {} parts have a false defect, at most {:g} % wanted",
                                             result.false_parts, result.parts, 100 * kMaxFalseParts));
  }
  if (table_ && !(moments_.of_host.share() >= kMinFoundOfHost)) {
    result.not_reached.push_back(fmt::format("by moments {} of the host's found, at least {:g} % wanted",
                                             percent(moments_.of_host), 100 * kMinFoundOfHost));
  }
  if (moments_.false_parts > 0) {
    result.not_reached.push_back(fmt::format("by moments {} of {} good parts have a defect, none wanted",
                                             moments_.false_parts, moments_.good_parts));
  }
  result.page.title = "Experiment parts";
  result.page.subtitle = "Defects planted into parts on a running line";
  result.page.plots = plots();
  result.page.tables = result.tables;
  return result;
}

}  // namespace

PartDetectionResult run_part_detection(const PartDetectionOptions& options,
                                       const std::function<void(std::size_t, std::size_t)>& progress) {
  return Detection(options, progress).run();
}

}  // namespace selfproj::lab
