#include "host/app/receive.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <string>
#include <system_error>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/clock.h"
#include "host/driver/control.h"
#include "host/files/notes.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

// The URI of the registers beside the device. Empty if there are none, or their file does not exist: the board then
// keeps its settings.
std::string control_of(const std::string& device) {
  const std::string uri = driver::control_uri(device);
  std::error_code unused;
  const bool missing = uri.starts_with("bar:") && !std::filesystem::exists(uri.substr(4), unused);
  return missing ? "" : uri;
}

driver::Wait wait_of(const std::string& name) {
  return name == "poll"    ? driver::Wait::polling
         : name == "block" ? driver::Wait::blocking
                           : driver::Wait::polling_then_blocking;
}

// Limits go to the bank that does not judge.
void write_verdict(driver::Control& control, const BoardSetup& setup) {
  if (control.build().verdict_log_sections < 0) {
    throw UserError(control.uri(), "this board gives no verdicts");
  }
  const production::VerdictTable& table = setup.verdict.value();
  model::BoardSettings settings;
  settings.verdict = true;
  settings.verdict_packets = 1;
  settings.verdict_settings = table.settings;
  settings.part_rule = table.rule;
  const bool judges = control.read("verdict_control.on") != 0;
  settings.verdict_settings.bank = judges ? 1 - static_cast<int>(control.read("verdict_defect.bank")) : 0;
  control.set_limits(settings.verdict_settings.bank, table.sections);
  control.set_ejector(setup.ejector_delay, setup.ejector_length);
  control.set_verdict(settings);
}

void write_setup(driver::Control& control, const BoardSetup& setup) {
  const rig::RigCamera& camera = setup.camera;
  const model::Measure& measure = setup.measure;
  const bool compact = setup.compact;
  const auto number = [](int value) { return static_cast<std::uint32_t>(value); };
  if (measure.select == model::Select::strongest && !control.build().runs) {
    throw UserError(control.uri(), "this board is built without the strongest run; select all lit pixels");
  }
  if (measure.bits != control.build().pixel_bits) {
    throw UserError(control.uri(), fmt::format("this board takes pixels of {} bits; the rig measures those of {} "
                                               "(measure.pixel_bits), to which its threshold belongs",
                                               control.build().pixel_bits, measure.bits));
  }
  const rig::RigRegion sent = camera.sent();
  control.need_columns(sent.columns);
  if (control.build().region) {
    control.write_together({{driver::register_part("region.row"), number(camera.region_row())},
                            {driver::register_part("region.column"), number(camera.region_column())}});
  }
  if (compact && !control.build().compact) {
    throw UserError(control.uri(),
                    "this board is built without compact columns; the rig asks for them (measure.words)");
  }
  if (control.build().compact) {
    control.write(driver::register_part("compact.on"), compact ? 1 : 0);
  }
  if (setup.verdict) {
    write_verdict(control, setup);
  }
  control.write_together({{driver::register_part("size.columns"), number(sent.columns)},
                          {driver::register_part("size.rows"), number(sent.rows)},
                          {driver::register_part("measure.mode"), number(static_cast<int>(measure.mode))},
                          {driver::register_part("measure.threshold"), number(measure.threshold)},
                          {driver::register_part("measure.select"), number(static_cast<int>(measure.select))},
                          {driver::register_part("measure.gap"), number(measure.gap)},
                          {driver::register_part("window.first"), number(measure.window.first)},
                          {driver::register_part("window.last"), number(measure.window.last)},
                          {driver::register_part("control.run"), 1}});
}

// What may be wrong where no packet comes.
std::string reason_of_silence(const std::string& device, const driver::Counters& counters) {
  if (counters.other_spec > 0) {
    return "packets come, but of another specification: this program and the board are of different versions";
  }
  if (counters.bad + counters.bytes_discarded + counters.datagrams_refused > 0) {
    return "something comes, but no packets of a board: does another program send here?";
  }
  if (device.starts_with("udp:")) {
    return "does the board run, do frames reach it, and does a firewall here let its datagrams in? A board sends to "
           "the host that has started it, until that one stops it";
  }
  if (device.starts_with("camera:")) {
    return "does the camera run, is it triggered, and is it free of other programs?";
  }
  return device.starts_with("file:") ? "does somebody write into it?"
                                     : "does the board run, and do frames reach it? `selfproj board status` says";
}

// All options of the command from the n-th on, but for those of `others`, go only with --device.
void need_device(CLI::App& command, std::size_t first, CLI::Option* device,
                 const std::vector<CLI::Option*>& others = {}) {
  const std::vector<CLI::Option*> options = command.get_options();
  std::for_each(options.begin() + static_cast<std::ptrdiff_t>(first), options.end(), [&](CLI::Option* option) {
    if (std::find(others.begin(), others.end(), option) == others.end()) {
      option->needs(device);
    }
  });
}

}  // namespace

CLI::Option* add_receive_options(CLI::App& command, ReceiveOptions& options, const std::string& things,
                                 const std::string& images_are, DeviceIs device, BoardIs board) {
  options.things = things;
  const bool required = device == DeviceIs::required;
  const bool set_up = board == BoardIs::set_up;
  cli::begin_group(command, "Device");
  CLI::Option* const uri =
      command
          .add_option("--device", options.device,
                      fmt::format("{}: ring:NAME, udp:HOST[:PORT] for a board on the network, litepcie:PATH for one on "
                                  "PCI Express, file:PATH for a recording, a pipe or a character device, or "
                                  "camera:NAME[?KEY=VALUE&...] for a camera{} `selfproj devices` lists cameras and "
                                  "their settings.",
                                  required ? "Where packets come from" : "Instead of images, a board", images_are))
          ->type_name("URI")
          ->required(required);
  const std::size_t first = command.get_options().size();
  command
      .add_option(
          "--control", options.control,
          fmt::format("The board's registers: bar:PATH[+OFFSET], litepcie:PATH, udp:HOST[:PORT], or none. {}The "
                      "board then runs until the end of the run.",
                      set_up ? "They get the rig's image size and all that it measures. " : ""))
      ->type_name("URI")
      ->default_str(set_up ? "those beside the device, if it has any" : "none");
  command
      .add_option("--wait", options.wait,
                  "How to wait for packets: poll takes a whole core and is quickest, block sleeps in the system.")
      ->check(cli::one_of({"poll", "block", "poll-then-block"}))
      ->type_name("HOW")
      ->capture_default_str();
  command.add_flag("--wait-for-board", options.wait_for_board,
                   "Wait until a ring and a board exist, also after the board has gone. Ctrl-C ends the run.");
  command.add_flag("--newest", options.newest, "Begin with the newest packet of the ring, not the oldest unread one.");
  cli::begin_group(command, "End of the run");
  CLI::Option* const count =
      command.add_option("--count", options.count, fmt::format("End after this many {}.", things))
          ->transform(cli::whole_number(1))
          ->type_name("N");
  command.add_option("--seconds", options.seconds, "End this many seconds after the first packet.")
      ->transform(cli::number_above_zero(1e9))
      ->type_name("S");
  CLI::Option* const check = command.add_flag(
      "--check", options.check,
      fmt::format("Exit with status 1 if anything was lost, bad or missing, if no {0} came, or fewer than "
                  "--count says.{1}",
                  things,
                  set_up ? " Also if fewer than half of the columns became points, or a part has no verdict." : ""));
  if (device == DeviceIs::instead_of_images) {
    need_device(command, first, uri);
  } else if (device == DeviceIs::or_images) {
    need_device(command, first, uri, {count, check});
  }
  return uri;
}

void add_production_options(CLI::App& command, production::ProductionOptions& options, CLI::Option* device) {
  const std::size_t first = command.get_options().size();
  cli::begin_group(command, "Parts");
  command
      .add_option(
          "--tolerance", options.tolerance,
          "Classify parts by this file, which `selfproj tolerance learn` writes. The rig's section `parts` says "
          "how they are cut.")
      ->type_name("FILE");
  command
      .add_option(
          "--parts", options.folder,
          "New folder for the results of parts: parts.jsonl, parts.csv, and a folder for each that is not good.")
      ->type_name("DIR");
  command.add_option("--keep-parts", options.keep, "Folders of parts that are kept. Later ones are only counted.")
      ->transform(cli::whole_number(0, 1'000'000))
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
  if (device != nullptr) {
    need_device(command, first, device);
  }
}

Receiver::~Receiver() {
  if (control_ != nullptr && !ran_) {
    try {
      control_->write("control.run", 0);
    } catch (const UserError&) {  // a board that does not answer any more cannot be stopped
    }
  }
}

void Receiver::open(const camera::CameraDefaults& camera, const std::optional<BoardSetup>& setup) {
  device_ = camera::open_any_device(
      options_.device,
      {.wait = wait_of(options_.wait), .wait_for_board = options_.wait_for_board, .discard_backlog = options_.newest},
      camera);
  start_board(setup);
}

void Receiver::start_board(const std::optional<BoardSetup>& setup) {
  const std::string by_default = setup ? control_of(options_.device) : std::string();
  const std::string uri = options_.control == "none" ? "" : options_.control.empty() ? by_default : options_.control;
  if (uri.empty()) {
    return;
  }
  control_ = driver::open_control(uri);
  ran_ = control_->read("control.run") != 0;
  if (setup) {
    write_setup(*control_, *setup);
  } else {
    control_->write("control.run", 1);
  }
}

void Receiver::run(const Handlers& handlers) {
  constexpr auto kPatience = std::chrono::milliseconds(50);  // so that Ctrl-C and the end of the time are noticed
  constexpr std::int64_t kShowNs = 200'000'000;
  constexpr std::int64_t kSilenceNs = 1'000'000'000;
  const std::uint64_t max_count = options_.count > 0 ? options_.count : std::numeric_limits<std::uint64_t>::max();
  const std::int64_t time_ns = options_.seconds > 0 ? static_cast<std::int64_t>(options_.seconds * 1e9)
                                                    : std::numeric_limits<std::int64_t>::max();
  cli::StatusLine line;
  model::PacketView packet;
  std::int64_t first_ns = 0;
  const std::int64_t begin_ns = driver::now_ns();
  std::int64_t shown_ns = begin_ns;
  bool silent = true;  // nothing has come, and it was not said
  std::uint64_t shown = 0;
  const auto show = [&](std::int64_t now) {
    const double rate =
        static_cast<double>(done_ - shown) * 1e9 / static_cast<double>(std::max<std::int64_t>(1, now - shown_ns));
    if (line.visible()) {
      const std::string status = handlers.status ? handlers.status() : std::string();
      line.show(fmt::format("{} {}, {:.0f}/s, {}{}{}", done_, options_.things, rate, report::losses_text(counters()),
                            status.empty() ? "" : ", ", status));
    }
    if (handlers.report) {
      handlers.report(rate);
    }
    shown_ns = now;
    shown = done_;
  };
  while (done_ < max_count && !files::StopSignal::came()) {
    const driver::Next next = device_->next(packet, kPatience);
    if (next == driver::Next::end) {
      if (first_ns == 0 && options_.device.starts_with("file:")) {
        line.show("");
        const std::uint64_t other = counters().bytes_discarded;
        throw UserError(options_.device, other > 0
                                             ? fmt::format("holds no packet of a board, but {} other bytes", other)
                                             : "holds no packet of a board");
      }
      break;
    }
    const std::int64_t now = driver::now_ns();
    if (next == driver::Next::packet) {
      first_ns = first_ns == 0 ? now : first_ns;  // a backlog came in long before
      silent = false;
      done_ = handlers.packet(packet);
      device_->release();
    }
    if (first_ns != 0 && now - first_ns >= time_ns) {
      break;
    }
    if (silent && now - begin_ns >= kSilenceNs) {
      silent = false;
      line.show("");
      files::note(fmt::format("{}: no packet for a second: {}", options_.device,
                              reason_of_silence(options_.device, counters())));
    }
    if (now - shown_ns >= kShowNs) {
      show(now);
    }
  }
  show(driver::now_ns());
  line.show("");
  ended_ = device_->counters();
}

void Receiver::check(std::uint64_t more) const {
  const driver::Counters c = counters();
  const std::uint64_t faults = c.lost_board + c.lost_ring + c.lost_network + c.missing + c.bad + c.flagged +
                               c.repeated + c.restarts + c.read_errors + more;
  if (options_.check && (faults > 0 || done_ == 0 || done_ < options_.count)) {
    throw CheckFailed(fmt::format("--check: {} {}{}, {} faults", done_, options_.things,
                                  options_.count > 0 ? fmt::format(" of {}", options_.count) : std::string(), faults));
  }
}

}  // namespace selfproj::app
