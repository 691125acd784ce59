#include "host/app/line_run.h"

#include <fmt/format.h>

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "host/app/inspection_loop.h"
#include "host/cli/command_line.h"
#include "host/driver/clock.h"
#include "host/files/user_error.h"
#include "host/production/depth_cutter.h"
#include "host/production/endpoint.h"
#include "host/production/section_reference.h"
#include "host/production/tolerance.h"
#include "host/report/facts.h"

namespace selfproj {

void add_line_options(CLI::App& command, LineOptions& options) {
  begin_group(command, "Parts");
  command
      .add_option("--tolerance", options.tolerance,
                  "Judge parts by this file, which `selfproj tolerance learn` writes. The rig's section `parts` says "
                  "how they are cut.")
      ->type_name("FILE");
  command
      .add_option("--parts", options.folder,
                  "New folder for the results of parts: parts.jsonl, parts.csv, and a folder for each that is not OK.")
      ->type_name("DIR");
  command.add_option("--keep-parts", options.keep, "Folders of parts that are kept. Later ones are only counted.")
      ->transform(whole_number(0, 1'000'000))
      ->type_name("N")
      ->capture_default_str();
  command
      .add_option(
          "--modbus", options.modbus,
          "Answer Modbus TCP at this port of this machine, or at ADDRESS:PORT, with counters and the last result.")
      ->type_name("PORT");
  command
      .add_option(
          "--live", options.live,
          "Serve a page at this port of this machine, or at ADDRESS:PORT, that shows profiles, parts and results in "
          "a browser while they come. At ADDRESS:PORT it asks for the token that is printed.")
      ->type_name("PORT");
}

LineRun::LineRun(const LineOptions& options, const Rig& rig, const std::string& title,
                 const std::function<Judge(const Tolerance&, const std::string& source)>& make_judge)
    : options_(options) {
  const bool judges = !options.folder.empty() || !options.modbus.empty();
  if (options.tolerance.empty() && judges) {
    throw UserError(options.folder.empty() ? "--modbus" : "--parts", "needs --tolerance, by which parts are judged");
  }
  if (!options.tolerance.empty()) {
    if (!rig.parts) {
      throw UserError(rig.name, "has no section `parts`, which says how the stream is cut into parts");
    }
    judge_.emplace(make_judge(load_tolerance(options.tolerance), options.tolerance));
  }
  if (!options.live.empty()) {
    live_.emplace(endpoint_of_text("--live", options.live), rig, title);
    camera_.emplace(
        [this] { return live_->watched(); },
        [this, kind = rig.kind, measure = rig.measure](const PacketHeader& header, const ImageView& image) mutable {
          measure.apply(measure_of(header));  // a device may measure otherwise than the rig says
          const std::vector<float> line =
              kind == RigKind::light_section ? line_in_image(image, measure) : std::vector<float>();
          live_->camera(header, image, line, judge_exposure(image, line, measure));
        });
    fmt::print(stderr, "live page: {}\n", live_->url());
  }
}

void LineRun::open() {
  if (!options_.modbus.empty()) {
    modbus_.emplace(endpoint_of_text("--modbus", options_.modbus),
                    [this] { return modbus_registers(worker().state(), lost_, worker().heartbeat(), now_ns()); });
  }
  if (!options_.folder.empty()) {
    files_.emplace(options_.folder, options_.keep);
  }
}

SectionLineRun::SectionLineRun(const LineOptions& options, const Rig& rig, const ReferenceProfile& reference,
                               const DifferentialProfiler& profiler, const std::string& title)
    : LineRun(options, rig, title, [&](const Tolerance& tolerance, const std::string& source) {
        return Judge(rig, section_of(rig, reference, profiler), tolerance, source);
      }) {
  PartLine::Listeners listeners;
  listeners.part = [this](const PartResult& result, const PlacedMaps& maps) { take(result, maps); };
  if (live() != nullptr) {
    listeners.profile = [this](const PacketHeader&, const ProfileView& profile) { live()->profile(profile); };
  }
  line_.emplace(rig, judge(), listeners);
  open();
}

DepthLineRun::DepthLineRun(const LineOptions& options, const Rig& rig, const FloatImage& reference_depth, int patterns,
                           const std::string& title)
    : LineRun(options, rig, title, [&](const Tolerance& tolerance, const std::string& source) {
        return Judge(rig, DepthGrid(rig).cells(reference_depth), tolerance, source);
      }) {
  DepthLine::Listeners listeners;
  listeners.part = [this](const PartResult& result, const PlacedMaps& maps) { take(result, maps); };
  if (live() != nullptr) {
    listeners.image = [this](const PacketHeader&, const DepthLine::Maps& maps) { live()->depth(maps.difference); };
  }
  line_.emplace(rig, patterns, judge(), listeners);
  open();
}

void LineRun::take(const PartResult& result, const PlacedMaps& maps) {
  if (files_) {
    files_->add(result, maps);
  }
  if (live_) {
    live_->part(result, maps);
  }
}

void LineRun::seen(const Counters& counters, std::vector<Fact> figures) {
  lost_ = counters.lost_board + counters.lost_ring + counters.lost_network;
  if (live_) {
    const std::vector<Fact> more = facts();
    figures.insert(figures.end(), more.begin(), more.end());
    live_->seen(figures);
  }
}

std::string LineRun::text() const {
  if (!judge_) {
    return "";
  }
  const LineState state = worker().state();
  return fmt::format(", {} parts: {} OK, {} not OK, {} cannot tell", state.parts(), state.verdicts[0],
                     state.verdicts[1], state.verdicts[2]);
}

void LineRun::finish() {
  worker().finish();
  if (files_) {
    files_->finish(worker().statistics());
  }
}

std::vector<Fact> LineRun::facts() const {
  const LineState state = worker().state();
  const DurationHistogram delays = worker().delays();
  const auto ms = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-6; };
  std::vector<Fact> facts;
  if (live_) {
    facts.push_back({"live_dropped", "pictures dropped for slow browsers", fact_number(live_->dropped())});
  }
  if (!judge_) {
    return facts;
  }
  const std::vector<Fact> of_parts = {
      {"parts", "parts", fact_number(state.parts())},
      {"parts_ok", "parts that are OK", fact_number(state.verdicts[0])},
      {"parts_not_ok", "parts that are not OK", fact_number(state.verdicts[1])},
      {"parts_cannot_tell", "parts whose result is cannot tell", fact_number(state.verdicts[2])},
      {"specks", "objects too short to be a part", fact_number(state.specks)},
      {"result_delay_p50_ms", "a part's last frame to its result, median", ms(delays.percentile_ns(0.5)), "ms"},
      {"result_delay_p99_ms", "a part's last frame to its result, 99 %", ms(delays.percentile_ns(0.99)), "ms"}};
  facts.insert(facts.end(), of_parts.begin(), of_parts.end());
  if (files_) {
    facts.push_back({"part_folders", "folders of parts", fact_number(files_->folders())});
    facts.push_back({"part_folders_left_out", "folders left out", fact_number(files_->folders_left_out())});
  }
  return facts;
}

std::string LineRun::end_text() const {
  if (!judge_) {
    return "";
  }
  const DurationHistogram delays = worker().delays();
  return fmt::format("{}; result after the last frame p50 {}, p99 {}{}\n", text().substr(2),
                     time_text(delays.percentile_ns(0.5)), time_text(delays.percentile_ns(0.99)),
                     files_ ? " → " + options_.folder : std::string());
}

}  // namespace selfproj
