#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <nlohmann/json.hpp>
#include <numeric>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/app/image_source.h"
#include "host/app/receive.h"
#include "host/app/region_mover.h"
#include "host/app/section_run.h"
#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/driver/clock.h"
#include "host/files/json_text.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/light_section/region_follower.h"
#include "host/production/cutter.h"
#include "host/production/part_reference.h"
#include "host/production/production.h"
#include "host/production/tolerance.h"
#include "host/production/verdict_file.h"
#include "host/production/verdict_run.h"
#include "host/production/verdict_table.h"
#include "host/report/facts.h"
#include "host/report/inspection_output.h"
#include "host/report/report.h"
#include "selfproj/driver/counters.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct InspectOptions {
  ReceiveOptions receive;
  ImageSourceOptions images;
  SectionOptions section;
  production::ProductionOptions production;
  std::string select;  // empty: whatever comes
  std::string out;
  std::string json;
  std::string verdict;  // a table; empty: nothing is judged by moments
  bool verdict_placed = false;
  bool verdict_board = false;
  std::vector<double> ejector_mm;  // delay and length; empty: no pulses
  bool follow = false;
  std::string move_camera;  // empty: the camera obeys the register
  std::uint64_t keep = light_section::InspectionOptions{}.max_frames;

  // What is inspected, in messages and titles.
  [[nodiscard]] const std::string& source() const {
    return receive.device.empty() ? images.images.front() : receive.device;
  }
  [[nodiscard]] std::string reference_name() const { return section.reference_name(receive.device, images.images); }
};

// The counts of the inspection, then those of the driver, if there is one.
std::vector<report::Fact> facts_of(const SectionCounts& work, const std::optional<driver::Counters>& counters) {
  const auto number = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
  const auto microseconds = [](std::int64_t ns) { return static_cast<double>(ns) * 1e-3; };
  std::vector<report::Fact> facts = {
      {"profiles", "profiles", number(work.profiles)},
      {"points", "valid points", number(work.points())},
      {"ambiguous", "ambiguous columns", number(work.of(light_section::Validity::ambiguous))},
      {"frames_per_second", "frames a second", work.rate()},
      {"delay_p50_us", "delay, median", microseconds(work.delay.percentile_ns(0.5)), "µs"},
      {"delay_p99_us", "delay, 99 %", microseconds(work.delay.percentile_ns(0.99)), "µs"},
      {"delay_max_us", "delay, longest", microseconds(work.delay.longest_ns()), "µs"},
      {"broken_frames", "frames flagged by the board", number(work.broken)},
      {"other_size", "frames of another size", number(work.other_size)},
      {"other_select", "frames of another select or of other bits", number(work.other_select)},
      {"other_packets", "packets of images, codes and verdicts alone", number(work.not_moments)}};
  if (counters) {
    const std::vector<report::Fact> driver = report::counter_facts(*counters);
    facts.insert(facts.end(), driver.begin(), driver.end());
  }
  return facts;
}

// Times differ from run to run; what else the folder holds does not.
bool is_time(const report::Fact& fact) {
  return fact.key == "frames_per_second" || fact.key.starts_with("delay_") || fact.key.starts_with("result_delay_");
}

void write_outputs(const InspectOptions& options, const light_section::Inspection& inspection,
                   const std::vector<report::Fact>& facts, const std::vector<std::string>& doubts,
                   const production::Production* production, files::OutputFolder& folder) {
  report::ReportParts parts;
  parts.title = "Inspection of " + options.source();
  parts.doubts = doubts;
  std::vector<report::Fact> times;
  std::partition_copy(facts.begin(), facts.end(), std::back_inserter(times), std::back_inserter(parts.counters),
                      is_time);
  const bool device = !options.receive.device.empty();
  parts.settings = {{device ? "device" : "images", device ? "device" : "images", options.source()},
                    {"reference", "reference", options.reference_name()}};
  if (device) {
    parts.settings.push_back({"wait", "waiting", options.receive.wait});
  }
  if (options.images.says_way()) {
    parts.settings.push_back({"mm_per_image", "way from image to image, as given", *options.images.spacing_mm, "mm"});
  }
  if (production != nullptr) {
    production->describe(parts);
  }
  report::write_inspection(inspection, folder, parts);
  if (const production::VerdictRun* const verdict = production != nullptr ? production->verdict() : nullptr) {
    folder.append("verdict.csv", production::judged_csv(verdict->frames()));
  }
  folder.append("times.json", files::json_text(report::facts_json(times), 2) + "\n");
  folder.commit();
}

void print_outcome(const InspectOptions& options, const SectionCounts& work,
                   const std::optional<driver::Counters>& counters,
                   const std::optional<light_section::Inspection>& inspection) {
  if (counters) {
    using driver::Counters;
    fmt::print("{} profiles, {:.0f} frames/s, {}\n{}\n", work.profiles, work.rate(),
               report::losses_text(
                   *counters, {&Counters::lost_board, &Counters::lost_ring, &Counters::lost_network, &Counters::missing,
                               &Counters::bad, &Counters::resynchronized, &Counters::repeated, &Counters::restarts}),
               delay_text(work.delay));
  } else {
    const auto columns = static_cast<double>(std::accumulate(work.columns.begin(), work.columns.end(), 0ULL));
    fmt::print("{} profiles, points in {:.1f} % of the columns\n", work.profiles,
               columns > 0 ? 100 * static_cast<double>(work.points()) / columns : 0.0);
  }
  if (inspection) {
    fmt::print("{} frames{} → {}\n", inspection->frames(),
               inspection->frames_not_kept() > 0 ? fmt::format(" (of {}, --keep {})", work.profiles, options.keep)
                                                 : std::string(),
               inspection->frames() > 0 ? options.out : "nothing written");
    const std::string reference = options.reference_name();
    fmt::print("reference: {}\n",
               reference == "plane" ? "none given: the empty plane under a straight line" : reference);
  }
}

// Parts that the region follows may lie beside their place.
light_section::ReferenceProfile reference_of(const InspectOptions& options, const rig::Rig& rig) {
  light_section::ReferenceProfile reference =
      options.section.load_reference(rig, options.receive.device, options.images.images);
  return options.follow ? light_section::without_walls(rig, std::move(reference)) : reference;
}

// An inspection while it runs.
class Run {
 public:
  explicit Run(const InspectOptions& options)
      : options_(options),
        rig_(options.section.load_rig(options.images.says_way())),
        folder_(options.out.empty() ? nullptr : std::make_unique<files::OutputFolder>(options.out)),
        json_(options.json.empty() ? nullptr : std::make_unique<files::OutputFile>(options.json)),
        reference_(reference_of(options, rig_)),
        profiler_(rig_, reference_),
        section_(profiler_, rig_.measure,
                 options.select.empty() ? std::nullopt : std::optional(images::select_of(options.select))),
        measure_(measure_of_rig(rig_, options.select)) {
    if (!options.verdict.empty()) {
      verdict_ = production::load_verdict_table(options.verdict);  // once: it may be a pipe
    }
    if (options.follow) {
      follower_.emplace(rig_, reference_, "--rig " + options.section.rig);
    }
    own_.resize(profiler_.columns());
    if (folder_) {
      const std::uint64_t count = options.receive.count;
      const std::uint64_t expected = count > 0 ? std::min(count, options.keep) : options.keep;
      inspection_.emplace(rig_, profiler_.columns(),
                          light_section::InspectionOptions{.expected_frames = static_cast<std::size_t>(expected),
                                                           .max_frames = static_cast<std::size_t>(options.keep)});
    }
  }

  void receive() {
    Receiver receiver(options_.receive);  // before the page can be seen
    produce();
    receiver.open(camera::camera_of_rig(rig_, measure_), board_setup());
    if (options_.verdict_board && receiver.control() == nullptr) {
      throw UserError("--verdict-board",
                      fmt::format("needs a board with registers beside {} (--control)", options_.receive.device));
    }
    std::optional<RegionMover> mover;
    if (follower_) {
      if (receiver.control() == nullptr || !receiver.control()->build().region) {
        throw UserError("--follow", fmt::format("needs a board with the register region beside {} (--control)",
                                                options_.receive.device));
      }
      mover.emplace(*receiver.control(), options_.move_camera);
    }
    const auto take = [&](const model::PacketView& packet) {
      if (mover && packet.header.region_row == 0 && model::has_columns(packet.header.kind)) {
        mover->check();
        ++frames_of_moves_;  // the camera is being moved
        return counts().profiles;
      }
      const light_section::ProfileView profile = place();
      if (section_.profile(packet, receiver.device(), profile)) {
        if (inspection_) {
          inspection_->add(packet.header, packet.payload, profile);
        }
        take_moments(packet);
        publish(packet.header, receiver.device().arrival_ns());
        if (mover) {
          if (const std::optional<int> row = follower_->look(packet)) {
            mover->move(*row);
          }
        }
      } else if (production_) {
        production_->image(packet);
      }
      return counts().profiles;
    };
    const auto status = [&] {
      const std::string parts = production_ ? production_->status_text() : std::string();
      return delay_text(counts().delay) + (parts.empty() ? "" : ", ") + parts;
    };
    receiver.run({take, status, [&](double /*rate*/) { report(receiver.counters()); }});
    if (mover) {
      mover->finish();
    }
    finish(receiver.counters());
    if (counts().profiles == 0) {
      say_doubts();
    }
    receiver.check(counts().other_size + counts().other_select);
    say_doubts();
  }

  void measure_images() {
    ImageSource source(options_.images, rig_, measure_);
    gap_in_images_ = source.doubt();
    produce();
    std::int64_t next_report_ns = 0;
    source.run(options_.receive.count, [&](const model::PacketHeader& header, const model::RunsView& runs) {
      constexpr std::int64_t kReportNs = 200'000'000;
      const light_section::ProfileView profile = place();
      const std::int64_t now = driver::now_ns();
      section_.profile(header, runs, source.first(), now, profile);
      if (inspection_) {
        inspection_->add(header, runs, profile);
      }
      if (!options_.verdict.empty() && slot_ != nullptr) {
        slot_->m0.assign(runs.moments.m0, runs.moments.m0 + header.columns);
        slot_->m1.assign(runs.moments.m1, runs.moments.m1 + header.columns);
      }
      publish(header, now);
      if (now >= next_report_ns) {
        next_report_ns = now + kReportNs;
        report({});
      }
    });
    report({});
    finish({});
    if (options_.receive.check && counts().profiles < std::max<std::uint64_t>(1, options_.receive.count)) {
      throw CheckFailed(fmt::format("--check: {} profiles of {}", counts().profiles, options_.receive.count));
    }
    say_doubts();
  }

 private:
  [[nodiscard]] const SectionCounts& counts() const { return section_.counts(); }

  void produce() {
    if (options_.production.any()) {
      production_.emplace(options_.production, rig_, production::section_of(rig_, reference_, profiler_),
                          fmt::format("{}: {}", rig_.name, options_.source()), verdict_run());
    }
  }

  BoardSetup board_setup() const {
    BoardSetup setup{rig_.camera, measure_, rig_.measure.sends_compact()};
    if (!options_.verdict_board) {
      return setup;
    }
    setup.verdict = verdict_;
    production::check_verdict_table(*setup.verdict, rig_, options_.verdict);
    if (!options_.ejector_mm.empty()) {
      if (!(rig_.conveyor.encoder_mm_per_count > 0)) {
        throw UserError("--ejector-mm", "the rig's belt has no encoder (conveyor.encoder_mm_per_count)");
      }
      const auto counts = [&](double mm, std::uint32_t most) {
        const double number = std::round(mm / rig_.conveyor.encoder_mm_per_count);
        if (!(number >= 0 && number <= most)) {
          throw UserError("--ejector-mm",
                          fmt::format("{} mm are {} counts of the encoder; the board takes 0 to {}", mm, number, most));
        }
        return static_cast<std::uint32_t>(number);
      };
      if (options_.ejector_mm.size() != 2) {
        throw UserError("--ejector-mm",
                        fmt::format("has {} value{}; two are expected, where the pulse begins and how long "
                                    "it is",
                                    options_.ejector_mm.size(), options_.ejector_mm.size() == 1 ? "" : "s"));
      }
      setup.ejector_delay = counts(options_.ejector_mm[0], (1U << spec::kRegEjectorDelayCountsBits) - 1);
      setup.ejector_length = counts(options_.ejector_mm[1], (1U << spec::kRegEjectorLengthCountsBits) - 1);
      if (setup.ejector_length == 0) {
        throw UserError("--ejector-mm", fmt::format("a pulse of {} mm is shorter than a count of the encoder, {} mm",
                                                    options_.ejector_mm[1], rig_.conveyor.encoder_mm_per_count));
      }
    }
    return setup;
  }

  std::unique_ptr<production::VerdictRun> verdict_run() const {
    if (options_.verdict.empty()) {
      return nullptr;
    }
    const auto keep = static_cast<std::size_t>(folder_ ? options_.keep : 0);
    const production::VerdictTable& table = *verdict_;
    std::unique_ptr<production::VerdictTables> tables;
    if (options_.verdict_placed) {
      if (options_.production.tolerance.empty()) {
        throw UserError("--verdict-placed", "needs --tolerance, by which parts are placed");
      }
      tables = std::make_unique<production::VerdictTables>(
          rig_, reference_, production::load_tolerance(options_.production.tolerance),
          production::VerdictOptions{.margin_mm = table.margin_mm,
                                     .play_across_mm = table.play_across_mm,
                                     .play_along_mm = table.play_along_mm,
                                     .lit_rows = table.lit_rows,
                                     .section_mm = table.section_mm,
                                     .frame_mm = table.frame_mm,
                                     .start = 0,
                                     .pitch = model::kCountMask / 2},
          options_.production.tolerance);
    }
    return std::make_unique<production::VerdictRun>(rig_, table, options_.verdict, keep, std::move(tables));
  }

  // The moments of the packet go with the profile in place().
  void take_moments(const model::PacketView& packet) {
    if (options_.verdict.empty() || slot_ == nullptr) {
      return;
    }
    const model::PacketHeader& header = packet.header;
    if (header.kind != spec::kKindMoments) {
      throw UserError(
          "--verdict",
          "needs exact moments (measure.words: exact, on the board too); these packets have divided columns");
    }
    slot_->board = model::has_verdict(header)
                       ? model::unpack_verdict(packet.payload.data() + model::columns_payload_bytes(header))
                       : std::nullopt;
    const std::size_t columns = header.columns;
    slot_->m0.resize(columns);
    slot_->m1.resize(columns);
    n_.resize(columns);
    runs_.resize(columns);
    second_.resize(columns);
    model::unpack_columns(header, packet.payload.data(),
                          {{slot_->m0.data(), slot_->m1.data(), n_.data()}, runs_.data(), second_.data()});
  }

  // Where the next profile goes.
  light_section::ProfileView place() {
    slot_ = production_ ? &production_->claim() : nullptr;
    return slot_ != nullptr ? slot_->profile.view() : own_.view();
  }

  // The profile in place() is made.
  void publish(const model::PacketHeader& header, std::int64_t arrival_ns) {
    if (slot_ != nullptr) {
      slot_->header = header;
      slot_->arrival_ns = arrival_ns;
      production_->publish();
    }
  }

  void report(const std::optional<driver::Counters>& counters) {
    if (production_) {
      std::vector<report::Fact> facts = facts_of(counts(), counters);
      if (const std::string& doubt = newest_doubt_.about(counts(), rig_); !doubt.empty()) {
        facts.push_back({"doubt", "doubtful", doubt});
      }
      production_->report(counters.value_or(driver::Counters{}), std::move(facts));
    }
  }

  // Why there are too few points or verdicts, each a line.
  [[nodiscard]] std::vector<std::string> doubts() const {
    std::vector<std::string> all;
    for (const std::string& doubt : {gap_in_images_, doubt_about(counts(), rig_),
                                     production_ && counts().profiles > 0 ? production_->doubt() : std::string()}) {
      if (!doubt.empty()) {
        all.push_back(doubt);
      }
    }
    return all;
  }

  void finish(const std::optional<driver::Counters>& counters) {
    std::vector<report::Fact> facts = facts_of(counts(), counters);
    if (follower_) {
      const auto number = [](std::uint64_t value) { return static_cast<std::int64_t>(value); };
      const light_section::RegionFollower::Counts& followed = follower_->counts();
      facts.insert(facts.end(), {{"region_moves", "moves of the region", number(followed.moves)},
                                 {"region_moves_failed", "moves that did not come", number(followed.failed)},
                                 {"region_looks", "looks at the region", number(followed.looks)},
                                 {"region_left", "looks at a line that left it", number(followed.left)},
                                 {"region_moving", "frames while it was moved", number(frames_of_moves_)}});
    }
    if (production_) {
      production_->finish();
      const std::vector<report::Fact> more = production_->facts();
      facts.insert(facts.end(), more.begin(), more.end());
    }
    if (inspection_ && inspection_->frames() > 1 && !options_.images.says_way() &&
        (!rig_.parts || !inspection_->encoder_counts())) {
      rig::expect_way_measured(rig_, inspection_->encoder_counts(), options_.section.rig);
    }
    if (inspection_ && inspection_->frames() > 0) {
      write_outputs(options_, *inspection_, facts, doubts(), production_ ? &*production_ : nullptr, *folder_);
    }
    if (json_) {
      json_->write(files::json_text(report::facts_json(facts), 2) + "\n");
    }
    print_outcome(options_, counts(), counters, inspection_);
    if (follower_) {
      const light_section::RegionFollower::Counts& followed = follower_->counts();
      fmt::print("region moved {} times; in {} of {} looks the line left it\n", followed.moves, followed.left,
                 followed.looks);
    }
    if (production_) {
      fmt::print("{}", production_->end_text());
      production_->check();
    }
  }

  void say_doubts() const {
    const std::vector<std::string> all = doubts();
    if (options_.receive.check && !all.empty()) {
      throw CheckFailed(fmt::format("--check: {}", fmt::join(all, "; ")));
    }
    for (const std::string& doubt : all) {
      cli::note_doubt(options_.source(), doubt);
    }
  }

  const InspectOptions& options_;
  const rig::Rig rig_;
  std::unique_ptr<files::OutputFolder> folder_;
  std::unique_ptr<files::OutputFile> json_;
  const light_section::ReferenceProfile reference_;
  const light_section::DifferentialProfiler profiler_;
  SectionRun section_;
  const model::Measure measure_;
  std::optional<light_section::Inspection> inspection_;
  std::optional<production::Production> production_;
  std::optional<light_section::RegionFollower> follower_;
  std::optional<production::VerdictTable> verdict_;
  std::string gap_in_images_;
  std::uint64_t frames_of_moves_ = 0;  // whose place on the sensor was not said
  NewestDoubt newest_doubt_;
  light_section::Profile own_;
  production::MeasuredFrame* slot_ = nullptr;
  std::vector<std::uint32_t> n_;  // of a packet's columns: what the verdict does not take
  std::vector<std::uint8_t> runs_, second_;
};

void run_inspect(const InspectOptions& options) {
  if (options.receive.device.empty() == options.images.images.empty()) {
    throw UserError("--device, --images", "one of them is required");
  }
  if (options.verdict_board && options.receive.device.empty()) {
    throw UserError("--verdict-board", "needs a board: recorded images have none");
  }
  Run run(options);
  if (options.receive.device.empty()) {
    run.measure_images();
  } else {
    run.receive();
  }
}

}  // namespace

void add_inspect_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app, {.name = "inspect",
            .purpose = "Inspects parts by light section: turns packets of a board, or recorded images, into profiles.",
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

# Inspect recorded images, without a board.
selfproj-sim scene render mountain --first 680 --count 40 --out frames
selfproj inspect --images 'frames/*.png' --out mountain

# Inspect what a real board delivers, beside a good part (needs hardware)
selfproj inspect --device file:/dev/xdma0_c2h_0 --reference good-part --check --count 100000 \
  --out part
)"});
  const auto options = std::make_shared<InspectOptions>();
  CLI::Option* const device =
      add_receive_options(*command, options->receive, "profiles",
                          ", of whose images this program makes the packets itself, as the rig says.",
                          DeviceIs::or_images, BoardIs::set_up);
  add_image_source_options(*command, options->images, device);
  cli::begin_group(*command, "Measuring");
  add_section_options(*command, options->section);
  command
      ->add_option("--select", options->select,
                   "What the board must have selected of each column; another stream is refused.")
      ->check(cli::one_of(images::select_names()))
      ->type_name("SELECT")
      ->default_str("what comes");
  CLI::Option* const follow =
      command
          ->add_flag("--follow", options->follow,
                     "Move the rig's region (camera.region) to where the line is, by the register `region`. The camera "
                     "must send the region that this register says, as simulated ones do, or be moved by "
                     "--move-camera; otherwise heights are wrong.")
          ->needs(device);
  command
      ->add_option("--move-camera", options->move_camera,
                   "Command that moves the camera's region, for the shell. Its last word is the region's first row, "
                   "from 0. While it runs nothing is measured.")
      ->type_name("COMMAND")
      ->needs(follow);
  add_production_options(*command, options->production);
  cli::begin_group(*command, "Verdict by moments");
  command
      ->add_option("--verdict", options->verdict,
                   "Judge the moments of each frame by this table, which `selfproj verdict table` writes, as a board "
                   "with a verdict does. The results are in parts.jsonl, in --json, and frame by frame in verdict.csv "
                   "of --out.")
      ->type_name("FILE");
  command
      ->add_flag("--verdict-placed", options->verdict_placed,
                 "Judge each part where --tolerance has placed it: with limits computed for its shift across, from "
                 "where its leading edge passed.")
      ->needs("--verdict");
  CLI::Option* const on_board =
      command
          ->add_flag(
              "--verdict-board", options->verdict_board,
              "Write the table to the board, which then judges frames itself and says in its packets what it has "
              "found. Frames of which board and model say different things are counted, and the first is told.")
          ->needs("--verdict")
          ->excludes("--verdict-placed");
  command
      ->add_option(
          "--ejector-mm", options->ejector_mm,
          "Where the board's pulse for an ejector begins behind the first bad frame of a part, and how long it "
          "is, along the belt.")
      ->transform(cli::real_number(0, 1e6))
      ->expected(1, 9)  // two; more and fewer are told apart from other mistakes below
      ->delimiter(',')
      ->type_name("MM,MM")
      ->needs(on_board);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for tables, cloud, pictures and report.")->type_name("DIR");
  command->add_option("--keep", options->keep, "Frames kept in memory for --out. Later ones are only counted.")
      ->transform(cli::whole_number(1, 10'000'000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--json", options->json, "File for the counts as JSON.")->type_name("FILE");
  command->callback([options] {
    options->production.verdict = !options->verdict.empty();
    run_inspect(*options);
  });
}

}  // namespace selfproj::app
