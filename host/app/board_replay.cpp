#include "host/app/board_replay.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/driver/control.h"
#include "host/driver/etherbone.h"
#include "host/driver/replay_sender.h"
#include "host/files/user_error.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"

namespace selfproj {
namespace {

struct ReplayCommandOptions {
  std::string device;
  std::vector<std::string> images;
  Preparation preparation;
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
  PreparedImages images(image_arguments(options.images), options.preparation);
  std::unique_ptr<RegisterPort> own = make_etherbone_port(host);
  RegisterPort& port = *own;  // the control keeps it
  Control control(std::move(own));
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
  ReplaySender sender(port, host, {.datagram_bytes = options.jumbo ? kJumboDatagramBytes : kDatagramBytes});
  Progress progress("frame", images.count());
  const auto begin = std::chrono::steady_clock::now();
  for (std::size_t i = 0; i < images.count(); ++i) {
    const Image frame = images.frame(i);
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
  CLI::App* command = add_command(
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
  add_files(*command, "IMAGE", options->images, "Images of the board's size, or a folder of them.")->required();
  add_preparation_options(*command, options->preparation);
  command->add_option("--rate", options->rate, "Most frames a second; without it, as many as the board takes.")
      ->transform(number_above_zero())
      ->type_name("HZ");
  command->add_flag("--jumbo", options->jumbo, "Send datagrams for frames of 9,000 bytes, not 1,500.");
  command->callback([options] { replay(*options); });
}

void add_source_command(CLI::App& board) {
  const auto device = std::make_shared<std::string>();
  const auto name = std::make_shared<std::string>();
  std::vector<std::string> names;
  std::transform(kSourceNames.begin(), kSourceNames.end(), std::back_inserter(names),
                 [](const SourceName& source) { return std::string(source.name); });
  CLI::App* command = add_command(board, {.name = "source",
                                          .purpose = "Says or sets where the frames of a board come from.",
                                          .details = "`camera` is the camera that the board was built for; without a "
                                                     "sensor it is the test camera. A frame that has begun is cut off.",
                                          .examples = R"(
# Frames of the test camera inside the FPGA (needs hardware)
selfproj board source test-camera --device udp:192.168.1.50
)"});
  add_device(*command, *device);
  command->add_option("NAME", *name, "The source from now on.")->check(one_of(names))->type_name("SOURCE");
  command->callback([device, name] {
    const std::unique_ptr<RegisterPort> port = make_etherbone_port(host_of(*device));
    const auto named = std::find_if(kSourceNames.begin(), kSourceNames.end(),
                                    [&](const SourceName& source) { return source.name == *name; });
    if (named != kSourceNames.end()) {
      set_video_source(*port, named->value);
    }
    const std::uint32_t source = video_source(*port);
    const auto now = std::find_if(kSourceNames.begin(), kSourceNames.end(),
                                  [&](const SourceName& one) { return one.value == source; });
    fmt::print("{}: frames of the source {}\n", port->uri(),
               now == kSourceNames.end() ? std::to_string(source) : std::string(now->name));
  });
}

}  // namespace

void add_board_replay_commands(CLI::App& board) {
  add_source_command(board);
  add_replay_command(board);
}

}  // namespace selfproj
