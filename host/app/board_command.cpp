#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <thread>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/boards.h"
#include "host/driver/control.h"
#include "host/driver/etherbone.h"
#include "host/driver/replay_sender.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

void print_boards(const std::vector<std::string>& hosts) {
  const std::vector<driver::BoardPlace> boards = driver::list_boards("/dev", hosts);
  if (boards.empty()) {
    fmt::print("no file of board registers in /dev\n");
  }
  for (const driver::BoardPlace& board : boards) {
    fmt::print("{:28} {}\n", board.uri, board.problem.empty() ? "a board of this specification" : board.problem);
  }
}

std::string yes(bool there) { return there ? "yes" : "no"; }

void print_info(driver::Control& control) {
  const model::BoardBuild& build = control.build();
  fmt::print("{}: selfproj board, specification {}.{}, hash 0x{:08X}\n", control.uri(), spec::kVersion >> 8U,
             spec::kVersion & 0xFFU, spec::kHash);
  fmt::print("largest image    {} x {} pixels\n", build.max_columns, build.max_rows);
  fmt::print("pixels           {} bits, {} a clock\n", build.pixel_bits, build.lanes);
  fmt::print("grey moments     {}\nraw images       {}\n", yes(build.grey), yes(build.image));
  fmt::print("verdicts         {}\n",
             build.verdict_log_sections < 0 ? "no" : fmt::format("{} sections", 1 << build.verdict_log_sections));
  fmt::print("Gray decoder     {}\n",
             build.codes ? fmt::format("{} bits{}", build.code_bits, build.median ? ", median" : "") : "no");
}

// All registers that the board has, with their fields.
void print_status(driver::Control& control) {
  static_cast<void>(control.state());  // time_low and time_high then belong together
  for (const spec::Register& one : spec::kRegisters) {
    if (!model::has_register(control.build(), one.address)) {
      continue;
    }
    const std::uint32_t word = control.read({&one, nullptr});
    std::string fields;
    for (const spec::RegisterField& field : one.fields) {
      const driver::RegisterPart part{&one, &field};
      if (!driver::Control::is_in_another(part)) {
        fields += fmt::format("  {}={}", field.name, control.value_in(word, part));
      }
    }
    fmt::print("0x{:02X} {:16} 0x{:08X}{}\n", one.address, one.name, word, fields);
  }
}

// "size.columns=512"; a mode may be given by its name.
std::pair<driver::RegisterPart, std::uint32_t> assignment(const std::string& text) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos) {
    throw UserError(text, "is not an assignment such as size.columns=512");
  }
  const std::string name = text.substr(0, equals);
  const std::string value = text.substr(equals + 1);
  const driver::RegisterPart part = driver::register_part(name);
  const std::vector<std::string> modes = images::mode_names();
  if (name == "measure.mode" && std::find(modes.begin(), modes.end(), value) != modes.end()) {
    return {part, static_cast<std::uint32_t>(images::mode_of(value))};
  }
  const std::optional<std::uint32_t> number = files::number_of_text<std::uint32_t>(value);
  if (!number) {
    throw UserError(text, fmt::format("'{}' is not a whole number from 0 to 4294967295", value));
  }
  return {part, *number};
}

struct TriggerOptions {
  std::optional<std::uint32_t> period;
  std::optional<std::uint32_t> camera;
  std::optional<std::uint32_t> width;
  std::uint32_t patterns = 1;
  bool on_frame = false;
  bool off = false;
};

// Stops the sequencer, writes its settings and starts it again, as the board wants it.
void set_trigger(driver::Control& control, const TriggerOptions& options) {
  control.write("trigger_control", 0);
  const auto write = [&](const char* name, const std::optional<std::uint32_t>& value) {
    if (value) {
      control.write(name, *value);
    }
  };
  write("trigger_period.clocks", options.period);
  write("trigger_camera.clocks", options.camera);
  write("trigger_width.clocks", options.width);
  if (options.off) {
    fmt::print("{}: no trigger pulses\n", control.uri());
  } else if (options.on_frame) {
    control.count_patterns_on_frames(static_cast<int>(options.patterns));
    fmt::print("{}: frames count {} patterns, no pulses\n", control.uri(), options.patterns);
  } else {
    control.write("trigger_control", 1U << spec::kRegTriggerControlRunLsb |
                                         (options.patterns - 1) << spec::kRegTriggerControlLastPatternLsb);
    fmt::print("{}: pulses every {} clocks, {} patterns\n", control.uri(), control.read("trigger_period.clocks"),
               options.patterns);
  }
}

void run_selftest(driver::Control& control) {
  const std::vector<driver::BoardTestResult> results = driver::test_board(control);
  std::size_t failed = 0;
  for (const driver::BoardTestResult& result : results) {
    fmt::print("{:5} {}{}\n", result.fault.empty() ? "good" : "FAULT", result.what,
               result.fault.empty() ? "" : ": " + result.fault);
    failed += result.fault.empty() ? 0 : 1;
  }
  if (failed > 0) {
    throw CheckFailed(fmt::format("{}: {} of {} checks failed", control.uri(), failed, results.size()));
  }
}

// Adds a subcommand that works on the board of --device.
CLI::App* add_on_board(CLI::App& parent, const cli::CommandText& text,
                       const std::function<void(driver::Control&)>& act) {
  CLI::App* command = cli::add_command(parent, text);
  const auto device = std::make_shared<std::string>();
  command
      ->add_option("--device", *device,
                   "The board: udp:HOST on the network; litepcie:PATH behind LitePCIe's driver; bar:PATH[+OFFSET] for "
                   "registers in a file mapped into memory; or file:/dev/xdma0_c2h_0 for those beside this device.")
      ->type_name("URI")
      ->required();
  command->callback([device, act] { act(*driver::open_control(*device)); });
  return command;
}

void add_set_command(CLI::App& board) {
  const auto values = std::make_shared<std::vector<std::string>>();
  CLI::App* command = add_on_board(
      board,
      {.name = "set",
       .purpose = "Writes registers of a board by name.",
       .details = "Settings change together, at the next frame start. A value that the board refuses is an error that "
                  "names its register. `selfproj board status` lists the names; measure.mode may be given as binary, "
                  "grey or grey-over.",
       .examples = R"(
# Frames of 512 x 96 pixels, grey moments over threshold 60 (needs hardware)
selfproj board set --device bar:/dev/xdma0_user size.columns=512 size.rows=96 \
  measure.mode=grey-over measure.threshold=60
)"},
      [values](driver::Control& control) {
        std::vector<std::pair<driver::RegisterPart, std::uint32_t>> parts;
        std::transform(values->begin(), values->end(), std::back_inserter(parts), assignment);
        control.write_together(std::move(parts));
      });
  command->add_option("SETTING", *values, "NAME=VALUE: a register or field, and its value.")->required();
}

void add_trigger_command(CLI::App& board) {
  const auto options = std::make_shared<TriggerOptions>();
  CLI::App* command = add_on_board(board,
                                   {.name = "trigger",
                                    .purpose = "Sets up, starts and stops the trigger pulses for projector and camera.",
                                    .details = "Stops the sequencer, writes what is given, and starts it again.",
                                    .examples = R"(
# 10,000 pulses a second at 151.2 MHz, the camera 100 clocks after the projector (needs hardware)
selfproj board trigger --device bar:/dev/xdma0_user --period 15120 --camera-delay 100
)"},
                                   [options](driver::Control& control) { set_trigger(control, *options); });
  constexpr std::int64_t kMaxClocks = (std::int64_t{1} << spec::kRegTriggerPeriodClocksBits) - 1;
  constexpr std::int64_t kMaxWidth = (std::int64_t{1} << spec::kRegTriggerWidthClocksBits) - 1;
  command->add_option("--period", options->period, "Pixel clocks from one projector pulse to the next.")
      ->transform(cli::whole_number(1, kMaxClocks))
      ->type_name("N");
  command->add_option("--camera-delay", options->camera, "Pixel clocks from the projector's pulse to the camera's.")
      ->transform(cli::whole_number(0, kMaxClocks))
      ->type_name("N");
  command->add_option("--width", options->width, "Pixel clocks that a pulse lasts.")
      ->transform(cli::whole_number(0, kMaxWidth))
      ->type_name("N");
  command->add_option("--patterns", options->patterns, "Patterns that follow each other.")
      ->transform(cli::whole_number(1, 1 << spec::kRegTriggerControlLastPatternBits))
      ->type_name("N")
      ->capture_default_str();
  CLI::Option* const on_frame =
      command->add_flag("--on-frame", options->on_frame, "Give no pulses, but count the patterns with the frames.");
  command->add_flag("--off", options->off, "Give no pulses.")->excludes(on_frame);
}

struct ReplayCommandOptions {
  std::string device;
  std::vector<std::string> images;
  images::Preparation preparation;
  std::optional<double> rate;  // frames a second
  bool jumbo = false;
};

// HOST of udp:HOST[:PORT].
std::string host_of(const std::string& uri) {
  if (!uri.starts_with("udp:")) {
    throw UserError(uri, "is no board on the network; use udp:HOST");
  }
  return uri.substr(4, uri.find(':', 4) - 4);
}

void add_device(CLI::App& command, std::string& device) {
  command.add_option("--device", device, "The board, udp:HOST on the network.")->type_name("URI")->required();
}

void replay(const ReplayCommandOptions& options) {
  const std::string host = host_of(options.device);
  images::PreparedImages images(images::image_arguments(options.images), options.preparation);
  std::unique_ptr<driver::RegisterPort> own = driver::make_etherbone_port(host);
  driver::RegisterPort& port = *own;  // the control keeps it
  driver::Control control(std::move(own));
  if (control.read("control.run") == 0) {
    throw UserError(control.uri(), "this board is stopped and drops frames; start it with selfproj board start");
  }
  const std::uint32_t columns = control.read("size.columns");
  const std::uint32_t rows = control.read("size.rows");
  if (static_cast<std::uint32_t>(images.columns()) != columns || static_cast<std::uint32_t>(images.rows()) != rows) {
    throw UserError(images.files().front(),
                    fmt::format("gives frames of {} x {} pixels, and the board is set to {} x {}", images.columns(),
                                images.rows(), columns, rows));
  }
  driver::ReplaySender sender(port, host,
                              {.datagram_bytes = options.jumbo ? model::kJumboDatagramBytes : model::kDatagramBytes});
  cli::Progress progress("frame", images.count());
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < images.count(); ++i) {
    const images::Image frame = images.frame(i);
    if (options.rate) {
      const std::chrono::duration<double> due(static_cast<double>(i) / *options.rate);
      std::this_thread::sleep_until(begin + std::chrono::duration_cast<std::chrono::steady_clock::duration>(due));
    }
    sender.send(frame.view());
    progress.update(i + 1);
  }
  sender.end();
  fmt::print("{}: {} frames left as video; {} datagrams sent, {} of them again\n", control.uri(), sender.frames(),
             sender.datagrams(), sender.repeated());
}

void add_replay_command(CLI::App& board) {
  const auto options = std::make_shared<ReplayCommandOptions>();
  CLI::App* command = cli::add_command(
      board, {.name = "replay",
              .purpose = "Sends images to a board on the network, in the place of its camera.",
              .details = "The board takes them for frames of its camera. It must be set to their size, and this host "
                         "must have started it. A frame leaves the board's memory only once all of it has come; what "
                         "the network loses is sent again. Afterwards the board has its former source of frames.",
              .examples = R"(
# Run recorded images through a board (needs hardware)
selfproj board set --device udp:192.168.1.50 size.columns=512 size.rows=96
selfproj board start --device udp:192.168.1.50
selfproj board replay --device udp:192.168.1.50 images
)"});
  add_device(*command, options->device);
  cli::add_files(*command, "IMAGE", options->images, "Images of the board's size, or a folder of them.")->required();
  cli::add_preparation_options(*command, options->preparation);
  command->add_option("--rate", options->rate, "Most frames a second; without it, as many as the board takes.")
      ->transform(cli::number_above_zero())
      ->type_name("HZ");
  command->add_flag("--jumbo", options->jumbo, "Send datagrams for frames of 9,000 bytes, not 1,500.");
  command->callback([options] { replay(*options); });
}

void add_source_command(CLI::App& board) {
  const auto device = std::make_shared<std::string>();
  const auto name = std::make_shared<std::string>();
  std::vector<std::string> names;
  std::transform(driver::kSourceNames.begin(), driver::kSourceNames.end(), std::back_inserter(names),
                 [](const driver::SourceName& source) { return std::string(source.name); });
  CLI::App* command =
      cli::add_command(board, {.name = "source",
                               .purpose = "Says or sets where the frames of a board come from.",
                               .details = "`camera` is the camera that the board was built for; without a "
                                          "sensor it is the test camera. A frame that has begun is cut off.",
                               .examples = R"(
# Frames of the test camera inside the FPGA (needs hardware)
selfproj board source test-camera --device udp:192.168.1.50
)"});
  add_device(*command, *device);
  command->add_option("NAME", *name, "The source from now on.")->check(cli::one_of(names))->type_name("SOURCE");
  command->callback([device, name] {
    const std::unique_ptr<driver::RegisterPort> port = driver::make_etherbone_port(host_of(*device));
    const auto named = std::find_if(driver::kSourceNames.begin(), driver::kSourceNames.end(),
                                    [&](const driver::SourceName& source) { return source.name == *name; });
    if (named != driver::kSourceNames.end()) {
      driver::set_video_source(*port, named->value);
    }
    const std::uint32_t source = driver::video_source(*port);
    const auto now = std::find_if(driver::kSourceNames.begin(), driver::kSourceNames.end(),
                                  [&](const driver::SourceName& one) { return one.value == source; });
    fmt::print("{}: frames of the source {}\n", port->uri(),
               now == driver::kSourceNames.end() ? std::to_string(source) : std::string(now->name));
  });
}

// Where a board's frames come from.
void add_replay_commands(CLI::App& board) {
  add_source_command(board);
  add_replay_command(board);
}

}  // namespace

void add_board_command(CLI::App& app) {
  CLI::App* board = cli::add_command(
      app, {.name = "board",
            .purpose = "Controls a board: its registers, settings and state.",
            .details = "The commands reach the board's registers over the network, or through a file that the system "
                       "maps into memory.",
            .examples = R"(
# List the boards of this machine.
selfproj board list
)"});
  board->require_subcommand(1);
  CLI::App* list = cli::add_command(
      *board, {.name = "list",
               .purpose = "Lists the boards of this machine and of hosts on the network.",
               .details = "Looks at /dev/xdma*_user, /dev/uio* and /dev/litepcie*, and asks every HOST given.",
               .examples = R"(
# List the boards of this machine.
selfproj board list
)"});
  const auto hosts = std::make_shared<std::vector<std::string>>();
  list->add_option("HOST", *hosts, "Hosts on the network to ask.")->type_name("NAME");
  list->callback([hosts] { print_boards(*hosts); });
  add_on_board(*board, {.name = "info", .purpose = "Says what a board can do.", .details = "", .examples = R"(
# The board behind the Xilinx DMA driver (needs hardware)
selfproj board info --device bar:/dev/xdma0_user
)"},
               print_info);
  add_on_board(*board,
               {.name = "status",
                .purpose = "Prints every register and field of a board by name.",
                .details = "",
                .examples = R"(
# Every register of the board behind the Xilinx DMA driver (needs hardware)
selfproj board status --device bar:/dev/xdma0_user
)"},
               print_status);
  add_set_command(*board);
  add_on_board(*board, {.name = "start", .purpose = "Lets a board accept frames.", .details = "", .examples = R"(
# Accept frames from now on (needs hardware)
selfproj board start --device bar:/dev/xdma0_user
)"},
               [](driver::Control& control) { control.write("control.run", 1); });
  add_on_board(*board,
               {.name = "stop",
                .purpose = "Lets a board accept no further frames; an open one is taken to its end.",
                .details = "",
                .examples = R"(
# Accept no further frames (needs hardware)
selfproj board stop --device bar:/dev/xdma0_user
)"},
               [](driver::Control& control) { control.write("control.run", 0); });
  add_trigger_command(*board);
  add_replay_commands(*board);
  add_on_board(*board,
               {.name = "selftest",
                .purpose = "Tests the way to a board's registers: patterns written and read, refusals, the clock.",
                .details = "The board must be stopped, and no trigger pulses may run. Every register has its old value "
                           "afterwards. The exit status is 1 if a check fails.",
                .examples = R"(
# Test the way to the registers of a stopped board (needs hardware)
selfproj board selftest --device bar:/dev/xdma0_user
)"},
               run_selftest);
}

}  // namespace selfproj::app
