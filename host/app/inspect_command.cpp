#include "host/app/inspect_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/driver/clock.h"
#include "host/driver/counters.h"
#include "host/driver/open_device.h"
#include "host/io/duration_histogram.h"
#include "host/io/output_file.h"
#include "host/io/output_folder.h"
#include "host/io/program_main.h"
#include "host/io/status_line.h"
#include "host/io/stop_signal.h"
#include "host/io/user_error.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/inspection.h"
#include "host/light_section/reference.h"
#include "host/light_section/reference_file.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "host/rig/rig.h"

namespace selfproj {
namespace {

struct InspectOptions {
  std::string device;
  std::string rig = "light-section";
  std::string reference;  // empty: the plane
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

// What the inspection itself counts, beside the driver.
struct Work {
  std::uint64_t profiles = 0;      // frames that became one
  std::uint64_t broken = 0;        // frames flagged by the board
  std::uint64_t other_size = 0;    // frames of another size than the rig's camera
  std::uint64_t not_moments = 0;   // packets of images and codes
  std::uint64_t points = 0;        // valid columns of all profiles
  std::int64_t first_ns = 0;       // arrival of the first packet
  std::int64_t first_done_ns = 0;  // when the first profile was there
  std::int64_t last_done_ns = 0;   // and the last one
  DurationHistogram delay;         // from a packet's arrival to its profile

  // Frames a second, from the first profile to the last; 0 where there is no second one. (Packets of a file arrive many
  // at a time.)
  [[nodiscard]] double rate() const {
    const auto ns = static_cast<double>(last_done_ns - first_done_ns);
    return profiles > 1 && ns > 0 ? static_cast<double>(profiles - 1) * 1e9 / ns : 0;
  }
};

std::string time_text(std::int64_t ns) {
  const auto value = static_cast<double>(ns);
  return ns < 1'000'000 ? fmt::format("{:.1f} µs", value * 1e-3) : fmt::format("{:.2f} ms", value * 1e-6);
}

std::string delay_text(const DurationHistogram& delay) {
  return fmt::format("delay p50 {}, p99 {}, max {}", time_text(delay.percentile_ns(0.5)),
                     time_text(delay.percentile_ns(0.99)), time_text(delay.longest_ns()));
}

std::string counters_text(const Counters& counters) {
  return fmt::format("lost on the board {}, in the ring {}, missing {}, bad {}", counters.lost_board,
                     counters.lost_ring, counters.missing, counters.bad);
}

std::vector<Fact> facts(const Work& work, const Counters& counters) {
  const auto number = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
  const auto microseconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  return {
      {"profiles", "profiles", number(work.profiles)},
      {"points", "valid points", number(work.points)},
      {"frames_per_second", "frames a second", work.rate()},
      {"delay_p50_us", "delay, median", microseconds(work.delay.percentile_ns(0.5)), "µs"},
      {"delay_p99_us", "delay, 99 %", microseconds(work.delay.percentile_ns(0.99)), "µs"},
      {"delay_max_us", "delay, longest", microseconds(work.delay.longest_ns()), "µs"},
      {"broken_frames", "frames flagged by the board", number(work.broken)},
      {"other_size", "frames of another size", number(work.other_size)},
      {"other_packets", "packets of images and codes", number(work.not_moments)},
      {"packets", "packets", number(counters.delivered)},
      {"lost_on_board", "packets lost on the board", number(counters.lost_board)},
      {"lost_in_ring", "packets lost in the ring", number(counters.lost_ring)},
      {"missing_frames", "missing frames", number(counters.missing)},
      {"bad_packets", "bad packets", number(counters.bad)},
      {"other_specification", "packets of another specification", number(counters.other_spec)},
      {"resynchronized", "resynchronized", number(counters.resynchronized)},
      {"bytes_discarded", "bytes discarded", number(counters.bytes_discarded)},
      {"repeated_packets", "repeated packets", number(counters.repeated)},
      {"board_restarts", "restarts of the board", number(counters.restarts)},
      {"reattached", "changes of writer or ring", number(counters.reattached)},
      {"read_errors", "errors of the device", number(counters.read_errors)},
  };
}

std::string json_text(const std::vector<Fact>& facts) {
  nlohmann::ordered_json json = nlohmann::ordered_json::object();
  for (const Fact& fact : facts) {
    std::visit([&](const auto& value) { json[fact.key] = value; }, fact.value);
  }
  return json.dump(2) + "\n";
}

// The rig's empty table or conveyor.
ReferenceProfile plane_reference(const Rig& rig) {
  const std::vector<double> heights(static_cast<std::size_t>(rig.camera.columns), 0.0);
  return reference_of_curve(rig, curve_of_heights(rig, heights));
}

// One packet into a profile, which stays in `profile`; false where it is none.
bool take(const PacketView& packet, const Rig& rig, const DifferentialProfiler& profiler, const std::string& uri,
          Profile& profile, Work& work) {
  const PacketHeader& header = packet.header;
  if (header.kind != spec::kKindMoments) {
    ++work.not_moments;
    return false;
  }
  if (header.columns != rig.camera.columns || header.rows != rig.camera.rows) {
    if (work.profiles == 0) {
      throw UserError(uri, fmt::format("its frames are {} x {} pixels, those of the rig {} x {}", header.columns,
                                       header.rows, rig.camera.columns, rig.camera.rows));
    }
    ++work.other_size;
    return false;
  }
  if (packet.status != 0) {
    ++work.broken;
    return false;
  }
  profiler.profile(static_cast<Mode>(header.mode), packet.payload.data(), profile.view());
  return true;
}

void run_inspect(const InspectOptions& options) {
  const Rig rig = load_rig(options.rig);
  if (rig.kind != RigKind::light_section) {
    throw UserError(options.rig, "is no rig for light section");
  }
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  std::optional<OutputFile> json;
  if (!options.json.empty()) {
    json.emplace(options.json);
  }
  if (!(options.seconds >= 0) || options.seconds > 1e9) {
    throw UserError("--seconds", "a number from 0 to 1e9 is needed");
  }

  const ReferenceProfile reference =
      options.reference.empty() ? plane_reference(rig) : load_reference(rig, options.reference);
  const DifferentialProfiler profiler(rig, reference);
  Profile profile;
  profile.resize(profiler.columns());
  std::optional<Inspection> inspection;
  if (folder) {
    const std::uint64_t expected = options.count > 0 ? std::min(options.count, options.keep) : options.keep;
    inspection.emplace(rig, profiler.columns(),
                       InspectionOptions{.expected_frames = static_cast<std::size_t>(expected),
                                         .max_frames = static_cast<std::size_t>(options.keep)});
  }

  const Wait wait = std::find_if(kWaits.begin(), kWaits.end(), [&](const auto& entry) {
                      return entry.first == options.wait;
                    })->second;
  const std::unique_ptr<Device> device = open_device(
      options.device, {.wait = wait, .wait_for_board = options.wait_for_board, .discard_backlog = options.newest});
  const StopSignal stop;
  StatusLine status;
  Work work;

  constexpr std::int64_t kShowNs = 200'000'000;
  constexpr auto kPatience = std::chrono::milliseconds(50);  // so that Ctrl-C and the end of the time are noticed
  const std::uint64_t most = options.count > 0 ? options.count : std::numeric_limits<std::uint64_t>::max();
  const std::int64_t time_ns =
      options.seconds > 0 ? static_cast<std::int64_t>(options.seconds * 1e9) : std::numeric_limits<std::int64_t>::max();
  std::int64_t next_show = now_ns() + kShowNs;
  std::uint64_t profiles_shown = 0;
  PacketView packet;
  for (Next next = Next::timeout; next != Next::end && work.profiles < most && !StopSignal::came();) {
    next = device->next(packet, kPatience);
    std::int64_t now = 0;
    if (next == Next::packet) {
      work.first_ns = work.first_ns == 0 ? device->arrival_ns() : work.first_ns;
      const bool made = take(packet, rig, profiler, device->uri(), profile, work);
      now = now_ns();
      if (made) {
        work.first_done_ns = work.profiles == 0 ? now : work.first_done_ns;
        work.last_done_ns = now;
        work.delay.add(now - device->arrival_ns());
        ++work.profiles;
        work.points += static_cast<std::uint64_t>(std::count(profile.validity.begin(), profile.validity.end(), 0));
        if (inspection) {
          inspection->add(packet.header, packet.payload, profile.view());
        }
      }
      device->release();
    } else {
      now = now_ns();
    }
    if (work.first_ns != 0 && now - work.first_ns >= time_ns) {
      break;
    }
    if (now >= next_show) {
      if (status.visible()) {
        const double rate =
            static_cast<double>(work.profiles - profiles_shown) * 1e9 / static_cast<double>(now - next_show + kShowNs);
        status.show(fmt::format("{} frames, {:.0f}/s, {}, {}", work.profiles, rate, counters_text(device->counters()),
                                delay_text(work.delay)));
      }
      profiles_shown = work.profiles;
      next_show = now + kShowNs;
    }
  }
  status.show("");

  const Counters counters = device->counters();
  const std::vector<Fact> all = facts(work, counters);
  if (inspection && inspection->frames() > 0) {
    ReportParts parts;
    parts.title = "Inspection of " + options.device;
    parts.counters = all;
    parts.settings = {{"device", "device", options.device},
                      {"reference", "reference", options.reference.empty() ? "plane" : options.reference},
                      {"wait", "waiting", options.wait}};
    write_inspection(*inspection, *folder, parts);
    folder->commit();
  }
  if (json) {
    json->write(json_text(all));
  }
  fmt::print("{} profiles, {:.0f} frames/s, {}, resynchronized {}, repeated {}, restarts {}, {}\n", work.profiles,
             work.rate(), counters_text(counters), counters.resynchronized, counters.repeated, counters.restarts,
             delay_text(work.delay));
  if (inspection) {
    fmt::print("{} frames{} → {}\n", inspection->frames(),
               inspection->frames_not_kept() > 0 ? fmt::format(" (of {}, --keep {})", work.profiles, options.keep)
                                                 : std::string(),
               inspection->frames() > 0 ? options.out : "nothing written");
  }
  if (options.check) {
    const std::uint64_t faults = counters.lost_board + counters.lost_ring + counters.missing + counters.bad +
                                 counters.repeated + counters.restarts + counters.read_errors + work.broken +
                                 work.other_size;
    if (faults > 0 || work.profiles == 0 || (options.count > 0 && work.profiles < options.count)) {
      throw CheckFailed(fmt::format("--check: {} profiles{}, {} faults", work.profiles,
                                    options.count > 0 ? fmt::format(" of {}", options.count) : std::string(), faults));
    }
  }
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("inspect", "Light section on-line: packets of a device into profiles");
  const auto options = std::make_shared<InspectOptions>();
  command->add_option("--device", options->device, "ring:NAME, or file:PATH (recorded, pipe, character device)")
      ->type_name("URI")
      ->required();
  command->add_option("--rig", options->rig, "A built-in rig or a YAML file")->capture_default_str();
  command
      ->add_option(
          "--reference", options->reference,
          "What the projected pattern was made for: the folder that `selfproj pattern` wrote; else the empty plane")
      ->type_name("DIR");
  command->add_option("--out", options->out, "Folder for tables, cloud, images and report")->type_name("DIR");
  command->add_option("--keep", options->keep, "Frames kept for --out; those that follow are only counted")
      ->check(CLI::Range(1, 10'000'000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--json", options->json, "File for the counts, as JSON")->type_name("FILE");
  command->add_option("--count", options->count, "End after so many profiles")->type_name("N");
  command->add_option("--seconds", options->seconds, "End so long after the first packet")->type_name("S");
  command->add_option("--wait", options->wait, "How to wait for packets: poll, block, poll-then-block")
      ->check(CLI::IsMember(std::vector<std::string>{"poll", "block", "poll-then-block"}))
      ->capture_default_str();
  command->add_flag("--wait-for-board", options->wait_for_board,
                    "Wait where there is no ring or no board yet, and again when it has gone; Ctrl-C ends");
  command->add_flag("--newest", options->newest,
                    "Begin with the newest packet of the ring, not with the first unread one");
  command->add_flag("--check", options->check, "Exit status 1 if anything was lost, bad or missing");
  command->callback([options] { run_inspect(*options); });
}

}  // namespace selfproj
