#include "host/app/inspect_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/board_run.h"
#include "host/app/inspection_loop.h"
#include "host/app/line_run.h"
#include "host/app/packet_run.h"
#include "host/app/section_options.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/driver/counters.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/files/stop_signal.h"
#include "host/files/user_error.h"
#include "host/images/frame_options.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/inspection.h"
#include "host/report/facts.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "model/column_runs.h"

namespace selfproj {
namespace {

struct InspectOptions {
  std::string device;
  std::string control;  // empty: the device's, if it has one
  SectionOptions section;
  LineOptions line;
  std::string select;  // empty: whatever comes
  std::string out;
  std::string json;
  std::uint64_t count = 0;
  double seconds = 0;
  std::uint64_t keep = InspectionOptions{}.max_frames;
  std::string wait = "poll-then-block";
  bool wait_for_board = false;
  bool newest = false;
  bool check = false;
};

const std::array<std::pair<const char*, Wait>, 3> kWaits{
    {{"poll", Wait::polling}, {"block", Wait::blocking}, {"poll-then-block", Wait::polling_then_blocking}}};

// The counts of the inspection, then those of the driver.
std::vector<Fact> facts_of(const InspectionWork& work, const Counters& counters) {
  const auto number = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
  const auto microseconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  std::vector<Fact> facts = {{"profiles", "profiles", number(work.profiles)},
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
  const std::vector<Fact> driver = counter_facts(counters);
  facts.insert(facts.end(), driver.begin(), driver.end());
  return facts;
}

std::string json_text(const std::vector<Fact>& facts) { return facts_json(facts).dump(2) + "\n"; }

std::unique_ptr<Device> open(const InspectOptions& options, const Rig& rig) {
  const Wait wait = std::find_if(kWaits.begin(), kWaits.end(), [&](const auto& entry) {
                      return entry.first == options.wait;
                    })->second;
  return open_any_device(options.device,
                         {.wait = wait, .wait_for_board = options.wait_for_board, .discard_backlog = options.newest},
                         camera_of_rig(rig, measure_of_rig(rig, options.select)));
}

void write_outputs(const InspectOptions& options, const Inspection& inspection, const std::vector<Fact>& facts,
                   OutputFolder& folder) {
  ReportParts parts;
  parts.title = "Inspection of " + options.device;
  parts.counters = facts;
  parts.settings = {{"device", "device", options.device},
                    {"reference", "reference", options.section.reference.empty() ? "plane" : options.section.reference},
                    {"wait", "waiting", options.wait}};
  write_inspection(inspection, folder, parts);
  folder.commit();
}

void print_outcome(const InspectOptions& options, const InspectionWork& work, const Counters& counters,
                   const Inspection* inspection) {
  fmt::print("{} profiles, {:.0f} frames/s, {}, {}, {}\n", work.profiles, work.rate(), losses_text(counters),
             counters_text(counters, {&Counters::resynchronized, &Counters::repeated, &Counters::restarts}),
             delay_text(work.delay));
  if (inspection != nullptr) {
    fmt::print("{} frames{} → {}\n", inspection->frames(),
               inspection->frames_not_kept() > 0 ? fmt::format(" (of {}, --keep {})", work.profiles, options.keep)
                                                 : std::string(),
               inspection->frames() > 0 ? options.out : "nothing written");
  }
}

// Throws CheckFailed if anything was lost, bad or missing.
void check(const InspectOptions& options, const InspectionWork& work, const Counters& counters) {
  const std::uint64_t faults = counters.lost_board + counters.lost_ring + counters.lost_network + counters.missing +
                               counters.bad + counters.repeated + counters.restarts + counters.read_errors +
                               work.broken + work.other_size + work.other_select;
  if (faults > 0 || work.profiles == 0 || (options.count > 0 && work.profiles < options.count)) {
    throw CheckFailed(fmt::format("--check: {} profiles{}, {} faults", work.profiles,
                                  options.count > 0 ? fmt::format(" of {}", options.count) : std::string(), faults));
  }
}

void run_inspect(const InspectOptions& options) {
  const Rig rig = options.section.load_rig();
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  std::optional<OutputFile> json;
  if (!options.json.empty()) {
    json.emplace(options.json);
  }
  const ReferenceProfile reference = options.section.load_reference(rig);
  const DifferentialProfiler profiler(rig, reference);
  std::optional<Inspection> inspection;
  if (folder) {
    const std::uint64_t expected = options.count > 0 ? std::min(options.count, options.keep) : options.keep;
    inspection.emplace(rig, profiler.columns(),
                       InspectionOptions{.expected_frames = static_cast<std::size_t>(expected),
                                         .max_frames = static_cast<std::size_t>(options.keep)});
  }
  Inspection* const kept = inspection ? &*inspection : nullptr;
  const StopSignal stop;  // before the line can be seen
  std::optional<SectionLineRun> line;
  if (options.line.any()) {
    line.emplace(options.line, rig, reference, profiler, fmt::format("{}: {}", rig.name, options.device));
  }

  InspectionTarget target{.select = options.select.empty() ? std::nullopt : std::optional(select_of(options.select)),
                          .count = options.count,
                          .seconds = options.seconds,
                          .inspection = kept};
  if (line) {
    target.line = &line->line();
    target.image = [&](const PacketView& packet) { line->camera(packet); };
    target.more = [&] { return line->text(); };
    target.seen = [&](const InspectionWork& work, const Counters& counters) {
      line->seen(counters, facts_of(work, counters));
    };
  }
  InspectionLoop loop(target, rig, profiler);
  const std::unique_ptr<Device> device = open(options, rig);
  const BoardRun board(options.device, options.control, rig.camera, measure_of_rig(rig, options.select));
  loop.run(*device);

  const Counters counters = device->counters();
  std::vector<Fact> facts = facts_of(loop.work(), counters);
  if (line) {
    line->seen(counters, facts);
    line->finish();
    const std::vector<Fact> more = line->facts();
    facts.insert(facts.end(), more.begin(), more.end());
  }
  if (kept != nullptr && kept->frames() > 0) {
    write_outputs(options, *kept, facts, *folder);
  }
  if (json) {
    json->write(json_text(facts));
  }
  print_outcome(options, loop.work(), counters, kept);
  if (line) {
    fmt::print("{}", line->end_text());
  }
  if (options.check) {
    check(options, loop.work(), counters);
  }
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = add_command(
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
  begin_group(*command, "Input");
  command
      ->add_option("--device", options->device,
                   "Where packets come from: ring:NAME, udp:HOST[:PORT] for a board on the network, litepcie:PATH for "
                   "one on PCI Express, file:PATH for a recording, a pipe or a character device, or "
                   "camera:NAME[?KEY=VALUE&...] for a camera, of whose "
                   "images this program makes the packets itself, as the rig says. `selfproj devices` lists cameras "
                   "and their settings.")
      ->type_name("URI")
      ->required();
  command
      ->add_option("--control", options->control,
                   "The board's registers, which get the rig's image size and all that it measures: bar:PATH[+OFFSET], "
                   "litepcie:PATH, udp:HOST[:PORT], or none.")
      ->type_name("URI")
      ->default_str("those beside the device, if it has any");
  add_section_options(*command, options->section);
  command
      ->add_option("--select", options->select,
                   "What the board must have selected of each column; another stream is refused.")
      ->check(one_of(select_names()))
      ->type_name("SELECT")
      ->default_str("what comes");
  command
      ->add_option("--wait", options->wait,
                   "How to wait for packets: poll takes a whole core and is quickest, block sleeps in the system.")
      ->check(one_of({"poll", "block", "poll-then-block"}))
      ->type_name("HOW")
      ->capture_default_str();
  command->add_flag("--wait-for-board", options->wait_for_board,
                    "Wait until a ring and a board exist, also after the board has gone. Ctrl-C ends the run.");
  command->add_flag("--newest", options->newest,
                    "Begin with the newest packet of the ring, not the oldest unread one.");
  add_line_options(*command, options->line);
  add_end_of_run(*command, options->count, options->seconds, "profiles");
  command->add_flag("--check", options->check,
                    "Exit with status 1 unless every frame became a profile and nothing was lost, bad or missing.");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for tables, cloud, pictures and report.")->type_name("DIR");
  command->add_option("--keep", options->keep, "Frames kept in memory for --out. Later ones are only counted.")
      ->transform(whole_number(1, 10'000'000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--json", options->json, "File for the counts as JSON.")->type_name("FILE");
  command->callback([options] { run_inspect(*options); });
}

}  // namespace selfproj
