#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/app/receive.h"
#include "host/app/scanner_run.h"
#include "host/app/section_run.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/files/json_text.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/production/part_reference.h"
#include "host/production/production.h"
#include "host/report/facts.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "selfproj/driver/counters.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct InspectOptions {
  ReceiveOptions receive;
  SectionOptions section;
  production::ProductionOptions production;
  std::string select;  // empty: whatever comes
  std::string out;
  std::string json;
  std::uint64_t keep = light_section::InspectionOptions{}.max_frames;
};

// The counts of the inspection, then those of the driver.
std::vector<report::Fact> facts_of(const SectionCounts& work, const driver::Counters& counters) {
  const auto number = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
  const auto microseconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  std::vector<report::Fact> facts = {
      {"profiles", "profiles", number(work.profiles)},
      {"points", "valid points", number(work.points)},
      {"ambiguous", "ambiguous columns", number(work.ambiguous)},
      {"frames_per_second", "frames a second", work.rate()},
      {"delay_p50_us", "delay, median", microseconds(work.delay.percentile_ns(0.5)), "µs"},
      {"delay_p99_us", "delay, 99 %", microseconds(work.delay.percentile_ns(0.99)), "µs"},
      {"delay_max_us", "delay, longest", microseconds(work.delay.longest_ns()), "µs"},
      {"broken_frames", "frames flagged by the board", number(work.broken)},
      {"other_size", "frames of another size", number(work.other_size)},
      {"other_select", "frames of another select", number(work.other_select)},
      {"other_packets", "packets of images and codes", number(work.not_moments)}};
  const std::vector<report::Fact> driver = report::counter_facts(counters);
  facts.insert(facts.end(), driver.begin(), driver.end());
  return facts;
}

// Times differ from run to run; what else the folder holds does not.
bool is_time(const report::Fact& fact) {
  return fact.key == "frames_per_second" || fact.key.starts_with("delay_") || fact.key.starts_with("result_delay_");
}

void write_outputs(const InspectOptions& options, const light_section::Inspection& inspection,
                   const std::vector<report::Fact>& facts, files::OutputFolder& folder) {
  report::ReportParts parts;
  parts.title = "Inspection of " + options.receive.device;
  std::vector<report::Fact> times;
  std::partition_copy(facts.begin(), facts.end(), std::back_inserter(times), std::back_inserter(parts.counters),
                      is_time);
  parts.settings = {{"device", "device", options.receive.device},
                    {"reference", "reference", options.section.reference.empty() ? "plane" : options.section.reference},
                    {"wait", "waiting", options.receive.wait}};
  report::write_inspection(inspection, folder, parts);
  folder.append("times.json", files::json_text(report::facts_json(times), 2) + "\n");
  folder.commit();
}

void print_outcome(const InspectOptions& options, const SectionCounts& work, const driver::Counters& counters,
                   const std::optional<light_section::Inspection>& inspection) {
  fmt::print("{} profiles, {:.0f} frames/s, {}, {}, {}\n", work.profiles, work.rate(), losses_text(counters),
             driver::counters_text(counters, {&driver::Counters::resynchronized, &driver::Counters::repeated,
                                              &driver::Counters::restarts}),
             delay_text(work.delay));
  if (inspection) {
    fmt::print("{} frames{} → {}\n", inspection->frames(),
               inspection->frames_not_kept() > 0 ? fmt::format(" (of {}, --keep {})", work.profiles, options.keep)
                                                 : std::string(),
               inspection->frames() > 0 ? options.out : "nothing written");
  }
}

void run_inspect(const InspectOptions& options) {
  const rig::Rig rig = options.section.load_rig();
  std::optional<files::OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  std::optional<files::OutputFile> json;
  if (!options.json.empty()) {
    json.emplace(options.json);
  }
  const light_section::ReferenceProfile reference = options.section.load_reference(rig);
  const light_section::DifferentialProfiler profiler(rig, reference);
  std::optional<light_section::Inspection> inspection;
  if (folder) {
    const std::uint64_t count = options.receive.count;
    const std::uint64_t expected = count > 0 ? std::min(count, options.keep) : options.keep;
    inspection.emplace(rig, profiler.columns(),
                       light_section::InspectionOptions{.expected_frames = static_cast<std::size_t>(expected),
                                                        .max_frames = static_cast<std::size_t>(options.keep)});
  }
  SectionRun section(rig, profiler,
                     options.select.empty() ? std::nullopt : std::optional(images::select_of(options.select)));
  const SectionCounts& counts = section.counts();
  Receiver receiver(options.receive);  // before the page can be seen
  std::optional<production::Production> production;
  if (options.production.any()) {
    production.emplace(options.production, rig, production::section_of(rig, reference, profiler),
                       fmt::format("{}: {}", rig.name, options.receive.device));
  }
  const model::Measure measure = measure_of_rig(rig, options.select);
  receiver.open(camera::camera_of_rig(rig, measure), BoardSetup{rig.camera, measure});

  light_section::Profile own;
  own.resize(profiler.columns());
  const auto receive = [&](const model::PacketView& packet) {
    production::MeasuredFrame* const slot = production ? &production->claim() : nullptr;
    const light_section::ProfileView profile = slot != nullptr ? slot->profile.view() : own.view();
    const bool made = section.profile(packet, receiver.device(), profile);
    if (made && inspection) {
      inspection->add(packet.header, packet.payload, profile);
    }
    if (made && slot != nullptr) {
      slot->header = packet.header;
      slot->arrival_ns = receiver.device().arrival_ns();
      production->publish();
    } else if (production) {
      production->image(packet);
    }
    return counts.profiles;
  };
  const auto status = [&] {
    const std::string parts = production ? production->status_text() : std::string();
    return delay_text(counts.delay) + (parts.empty() ? "" : ", ") + parts;
  };
  const auto report = [&](double /*rate*/) {
    if (production) {
      production->report(receiver.counters(), facts_of(counts, receiver.counters()));
    }
  };
  receiver.run({receive, status, report});

  const driver::Counters counters = receiver.counters();
  std::vector<report::Fact> facts = facts_of(counts, counters);
  if (production) {
    production->finish();
    const std::vector<report::Fact> more = production->facts();
    facts.insert(facts.end(), more.begin(), more.end());
  }
  if (inspection && inspection->frames() > 1 && !rig.parts) {
    rig::expect_way_measured(rig, inspection->encoder_counts(), options.section.rig);
  }
  if (inspection && inspection->frames() > 0) {
    write_outputs(options, *inspection, facts, *folder);
  }
  if (json) {
    json->write(files::json_text(report::facts_json(facts), 2) + "\n");
  }
  print_outcome(options, counts, counters, inspection);
  if (production) {
    fmt::print("{}", production->end_text());
  }
  if (production) {
    production->check();
  }
  receiver.check(counts.other_size + counts.other_select);
  if (counts.profiles > 0 && counts.points == 0) {
    const std::string reason = fmt::format(
        "none of the {} columns of {} profiles is valid: is there no light, or are rig, mode and threshold not those "
        "of "
        "the frames?",
        counts.profiles * static_cast<std::uint64_t>(profiler.columns()), counts.profiles);
    if (options.receive.check) {
      throw CheckFailed("--check: " + reason);
    }
    note_doubt(options.receive.device, reason);
  }
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app, {.name = "inspect",
            .purpose = "Inspects parts on-line by light section: turns the packets of a board into profiles.",
            .details =
                "A terminal shows frames per second, losses, and the delay from a packet's arrival to its profile. The "
                "run ends after --count profiles, after --seconds, at Ctrl-C, or when the device has ended and "
                "everything is read.\n\n"
                "The folder of --out gets moments.csv, profile.csv, cloud.ply, height.tiff and .png, difference.tiff "
                "and .png, summary.json and report.html.",
            .examples = R"(
# Record packets of a simulated board, then inspect the recording.
selfproj-sim cosim --engine model --count 50 --packets part.packets
selfproj inspect --device file:part.packets --out part

# Inspect at 10,000 frames a second: the board runs in a process of its own.
selfproj-sim board --line 512x96 --ring line1 --count 20000 --wait-for-reader &
selfproj inspect --device ring:line1 --wait-for-board --seconds 3 --json counts.json

# Inspect what a real board delivers, beside a good part (needs hardware)
selfproj inspect --device file:/dev/xdma0_c2h_0 --reference good-part --check --count 100000 \
  --out part
)"});
  const auto options = std::make_shared<InspectOptions>();
  add_receive_options(*command, options->receive, "profiles",
                      ", of whose images this program makes the packets itself, as the rig says.", DeviceIs::required,
                      BoardIs::set_up);
  cli::begin_group(*command, "Measuring");
  add_section_options(*command, options->section);
  command
      ->add_option("--select", options->select,
                   "What the board must have selected of each column; another stream is refused.")
      ->check(cli::one_of(images::select_names()))
      ->type_name("SELECT")
      ->default_str("what comes");
  add_production_options(*command, options->production);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for tables, cloud, pictures and report.")->type_name("DIR");
  command->add_option("--keep", options->keep, "Frames kept in memory for --out. Later ones are only counted.")
      ->transform(cli::whole_number(1, 10'000'000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--json", options->json, "File for the counts as JSON.")->type_name("FILE");
  command->callback([options] { run_inspect(*options); });
}

}  // namespace selfproj::app
