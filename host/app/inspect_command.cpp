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
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/board_run.h"
#include "host/camera/camera_device.h"
#include "host/camera/camera_uri.h"
#include "host/driver/clock.h"
#include "host/driver/counters.h"
#include "host/io/command_line.h"
#include "host/io/duration_histogram.h"
#include "host/io/frame_options.h"
#include "host/io/output_file.h"
#include "host/io/output_folder.h"
#include "host/io/status_line.h"
#include "host/io/stop_signal.h"
#include "host/io/user_error.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/inspection.h"
#include "host/light_section/reference.h"
#include "host/light_section/reference_file.h"
#include "host/report/counter_facts.h"
#include "host/report/facts_json.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "host/rig/rig.h"
#include "model/column_runs.h"
#include "model/pixel_clock.h"

namespace selfproj {
namespace {

struct InspectOptions {
  std::string device;
  std::string control;  // empty: the device's, if it has one
  std::string rig = "light-section";
  std::string reference;  // empty: the plane
  std::string select;     // empty: whatever comes
  std::string out;
  std::string json;
  std::uint64_t count = 0;
  double seconds = 0;
  std::uint64_t keep = InspectionOptions{}.max_frames;
  std::string wait = "poll-then-block";
  bool wait_for_board = false;
  bool newest = false;
  bool check = false;
  std::optional<double> pixel_clock_hz;  // empty: the rig's
};

const std::array<std::pair<const char*, Wait>, 3> kWaits{
    {{"poll", Wait::polling}, {"block", Wait::blocking}, {"poll-then-block", Wait::polling_then_blocking}}};

// The counters of the inspection itself, beside those of the driver.
struct Work {
  std::uint64_t profiles = 0;      // frames that became a profile
  std::uint64_t broken = 0;        // frames flagged by the board
  std::uint64_t other_size = 0;    // frames of another size than the rig's camera
  std::uint64_t other_select = 0;  // frames of which the board sent something else than --select
  std::uint64_t not_moments = 0;   // packets of images and codes
  std::uint64_t ambiguous = 0;     // columns whose second run is nearly as strong as the strongest
  std::uint64_t points = 0;        // valid columns of all profiles
  std::int64_t first_ns = 0;       // when the first packet was taken
  std::int64_t first_done_ns = 0;  // when the first profile was there
  std::int64_t last_done_ns = 0;   // and the last one
  DurationHistogram delay;         // from a packet's arrival to its profile

  // Frames per second from the first profile to the last; 0 if there are fewer than two. (Packets of a file arrive many
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

// The counters of the driver that are shown while packets come.
std::string losses_text(const Counters& counters) {
  return counters_text(counters, {&Counters::lost_board, &Counters::lost_ring, &Counters::lost_network,
                                  &Counters::missing, &Counters::bad});
}

// The counts of the inspection, then those of the driver.
std::vector<Fact> facts_of(const Work& work, const Counters& counters) {
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

// The rig of the options, with their pixel clock.
Rig rig_of(const InspectOptions& options) {
  Rig rig = load_any_rig(options.rig);
  if (rig.kind != RigKind::light_section) {
    throw UserError(options.rig, "is not a rig of kind light-section");
  }
  if (options.pixel_clock_hz) {
    rig.board = RigBoard{.pixel_clock_hz = *options.pixel_clock_hz};
  }
  return rig;
}

// What the board is told to measure: as the rig says, except for what an option says.
Measure measure_of(const InspectOptions& options, const Rig& rig) {
  Measure measure = rig.measure.of_board();
  if (!options.select.empty()) {
    measure.select = select_of(options.select);
    measure.gap = measure.select == Select::all ? 0 : measure.gap;
  }
  return measure;
}

std::unique_ptr<Device> open(const InspectOptions& options, const Rig& rig) {
  const Wait wait = std::find_if(kWaits.begin(), kWaits.end(), [&](const auto& entry) {
                      return entry.first == options.wait;
                    })->second;
  const Measure measure = measure_of(options, rig);
  return open_any_device(options.device,
                         {.wait = wait, .wait_for_board = options.wait_for_board, .discard_backlog = options.newest},
                         {.region = CameraRegion{.columns = rig.camera.columns, .rows = rig.camera.rows},
                          .board = {.mode = measure.mode,
                                    .threshold = measure.threshold,
                                    .select = measure.select,
                                    .gap = measure.gap,
                                    .window = measure.window,
                                    .pixel_clock_hz = rig.pixel_clock_hz()}});
}

// Turns packets of a device into profiles, until there are enough, the time is up, or no more come.
class InspectionLoop {
 public:
  // Ctrl-C ends it while a StopSignal exists. Keeps the profiles in `inspection`, if given. All arguments except the
  // options must outlive it.
  InspectionLoop(const InspectOptions& options, const Rig& rig, const DifferentialProfiler& profiler,
                 Inspection* inspection)
      : rig_(rig),
        select_(options.select.empty() ? std::nullopt : std::optional(select_of(options.select))),
        profiler_(profiler),
        inspection_(inspection),
        most_(options.count > 0 ? options.count : std::numeric_limits<std::uint64_t>::max()),
        time_ns_(options.seconds > 0 ? static_cast<std::int64_t>(options.seconds * 1e9)
                                     : std::numeric_limits<std::int64_t>::max()) {
    profile_.resize(profiler.columns());
  }

  void run(Device& device) {
    constexpr auto kPatience = std::chrono::milliseconds(50);  // so that Ctrl-C and the end of the time are noticed
    StatusLine status;
    next_show_ = now_ns() + kShowNs;
    PacketView packet;
    for (Next next = Next::timeout; next != Next::end && work_.profiles < most_ && !StopSignal::came();) {
      next = device.next(packet, kPatience);
      const std::int64_t now = next == Next::packet ? take(packet, device) : now_ns();
      if (work_.first_ns != 0 && now - work_.first_ns >= time_ns_) {
        break;
      }
      if (now >= next_show_) {
        show(status, device, now);
      }
    }
    status.show("");
  }

  [[nodiscard]] const Work& work() const { return work_; }

 private:
  static constexpr std::int64_t kShowNs = 200'000'000;

  // Takes the packet and returns it to the device. Returns the time when that was done.
  std::int64_t take(const PacketView& packet, Device& device) {
    work_.first_ns = work_.first_ns == 0 ? now_ns() : work_.first_ns;  // a backlog came in long before
    const bool made = make_profile(packet, device.uri());
    const std::int64_t now = now_ns();
    if (made) {
      work_.first_done_ns = work_.profiles == 0 ? now : work_.first_done_ns;
      work_.last_done_ns = now;
      work_.delay.add(now - device.arrival_ns());
      ++work_.profiles;
      for (const std::uint8_t validity : profile_.validity) {
        work_.points += validity == static_cast<std::uint8_t>(Validity::valid) ? 1U : 0U;
        work_.ambiguous += validity == static_cast<std::uint8_t>(Validity::ambiguous) ? 1U : 0U;
      }
      if (inspection_ != nullptr) {
        inspection_->add(packet.header, packet.payload, profile_.view());
      }
    }
    device.release();
    return now;
  }

  // Computes the packet's profile into profile_. Returns false if it gives none.
  bool make_profile(const PacketView& packet, const std::string& uri) {
    const PacketHeader& header = packet.header;
    if (header.kind != spec::kKindMoments) {
      ++work_.not_moments;
      return false;
    }
    if (header.columns != rig_.camera.columns || header.rows != rig_.camera.rows) {
      if (work_.profiles == 0) {
        throw UserError(uri, fmt::format("its frames are {} x {} pixels, those of the rig {} x {}", header.columns,
                                         header.rows, rig_.camera.columns, rig_.camera.rows));
      }
      ++work_.other_size;
      return false;
    }
    if (packet.status != 0) {
      ++work_.broken;
      return false;
    }
    if (select_ && header.select != static_cast<std::uint8_t>(*select_)) {
      if (work_.profiles == 0) {
        throw UserError(uri, fmt::format("its packets tell of {}, not of --select {}",
                                         select_name(static_cast<Select>(header.select)), select_name(*select_)));
      }
      ++work_.other_select;
      return false;
    }
    profiler_.profile(static_cast<Select>(header.select), static_cast<Mode>(header.mode), packet.payload.data(),
                      profile_.view());
    return true;
  }

  void show(StatusLine& status, const Device& device, std::int64_t now) {
    if (status.visible()) {
      const double rate =
          static_cast<double>(work_.profiles - profiles_shown_) * 1e9 / static_cast<double>(now - next_show_ + kShowNs);
      status.show(fmt::format("{} frames, {:.0f}/s, {}, {}", work_.profiles, rate, losses_text(device.counters()),
                              delay_text(work_.delay)));
    }
    profiles_shown_ = work_.profiles;
    next_show_ = now + kShowNs;
  }

  const Rig& rig_;
  std::optional<Select> select_;  // empty: whatever comes
  const DifferentialProfiler& profiler_;
  Inspection* inspection_;
  std::uint64_t most_;
  std::int64_t time_ns_;
  Profile profile_;
  Work work_;
  std::int64_t next_show_ = 0;
  std::uint64_t profiles_shown_ = 0;
};

void write_outputs(const InspectOptions& options, const Inspection& inspection, const std::vector<Fact>& facts,
                   OutputFolder& folder) {
  ReportParts parts;
  parts.title = "Inspection of " + options.device;
  parts.counters = facts;
  parts.settings = {{"device", "device", options.device},
                    {"reference", "reference", options.reference.empty() ? "plane" : options.reference},
                    {"wait", "waiting", options.wait}};
  write_inspection(inspection, folder, parts);
  folder.commit();
}

void print_outcome(const InspectOptions& options, const Work& work, const Counters& counters,
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
void check(const InspectOptions& options, const Work& work, const Counters& counters) {
  const std::uint64_t faults = counters.lost_board + counters.lost_ring + counters.lost_network + counters.missing +
                               counters.bad + counters.repeated + counters.restarts + counters.read_errors +
                               work.broken + work.other_size + work.other_select;
  if (faults > 0 || work.profiles == 0 || (options.count > 0 && work.profiles < options.count)) {
    throw CheckFailed(fmt::format("--check: {} profiles{}, {} faults", work.profiles,
                                  options.count > 0 ? fmt::format(" of {}", options.count) : std::string(), faults));
  }
}

void run_inspect(const InspectOptions& options) {
  const Rig rig = rig_of(options);
  std::optional<OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  std::optional<OutputFile> json;
  if (!options.json.empty()) {
    json.emplace(options.json);
  }
  const ReferenceProfile reference =
      options.reference.empty() ? reference_of_plane(rig) : load_reference(rig, options.reference);
  const DifferentialProfiler profiler(rig, reference);
  std::optional<Inspection> inspection;
  if (folder) {
    const std::uint64_t expected = options.count > 0 ? std::min(options.count, options.keep) : options.keep;
    inspection.emplace(rig, profiler.columns(),
                       InspectionOptions{.expected_frames = static_cast<std::size_t>(expected),
                                         .max_frames = static_cast<std::size_t>(options.keep)});
  }
  Inspection* const kept = inspection ? &*inspection : nullptr;

  InspectionLoop loop(options, rig, profiler, kept);
  const std::unique_ptr<Device> device = open(options, rig);
  const BoardRun board(options.device, options.control, rig.camera, measure_of(options, rig));
  const StopSignal stop;
  loop.run(*device);

  const Counters counters = device->counters();
  const std::vector<Fact> facts = facts_of(loop.work(), counters);
  if (kept != nullptr && kept->frames() > 0) {
    write_outputs(options, *kept, facts, *folder);
  }
  if (json) {
    json->write(json_text(facts));
  }
  print_outcome(options, loop.work(), counters, kept);
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
                   "Where packets come from: ring:NAME, udp:HOST[:PORT] for a board on the network, file:PATH for a "
                   "recording, a pipe or a character device, or camera:NAME[?KEY=VALUE&...] for a camera, of whose "
                   "images this program makes the packets itself, as the rig says. `selfproj devices` lists cameras "
                   "and their settings.")
      ->type_name("URI")
      ->required();
  command
      ->add_option("--control", options->control,
                   "The board's registers, which get the rig's image size, mode and threshold: bar:PATH[+OFFSET], or "
                   "none.")
      ->type_name("URI")
      ->default_str("those beside the device, if it has any");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")->type_name("RIG")->capture_default_str();
  command
      ->add_option("--reference", options->reference,
                   "Folder that `selfproj pattern` wrote for the good part whose pattern is projected.")
      ->type_name("DIR")
      ->default_str("the empty plane");
  command
      ->add_option("--select", options->select,
                   "What the board must have selected of each column; another stream is refused.")
      ->check(one_of(select_names()))
      ->type_name("SELECT")
      ->default_str("what comes");
  command
      ->add_option("--pixel-clock-hz", options->pixel_clock_hz,
                   "Pixel clock of the board in Hz, which its time stamps count.")
      ->transform(real_number(kLeastPixelClockHz, kMostPixelClockHz))
      ->type_name("HZ")
      ->default_str(fmt::format("the rig's, or {:.0f}", kDefaultPixelClockHz));
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
  begin_group(*command, "End of the run");
  command->add_option("--count", options->count, "End after this many profiles.")
      ->transform(whole_number(1))
      ->type_name("N");
  command->add_option("--seconds", options->seconds, "End this many seconds after the first packet.")
      ->transform(number_above_zero(1e9))
      ->type_name("S");
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
