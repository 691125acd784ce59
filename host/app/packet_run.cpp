#include "host/app/packet_run.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "host/camera/camera_device.h"
#include "host/cli/command_line.h"
#include "host/cli/status_line.h"
#include "host/driver/clock.h"
#include "host/files/stop_signal.h"
#include "host/files/user_error.h"

namespace selfproj {

void add_end_of_run(CLI::App& command, std::uint64_t& count, double& seconds, const std::string& what) {
  begin_group(command, "End of the run");
  command.add_option("--count", count, fmt::format("End after this many {}.", what))
      ->transform(whole_number(1))
      ->type_name("N");
  command.add_option("--seconds", seconds, "End this many seconds after the first packet.")
      ->transform(number_above_zero(1e9))
      ->type_name("S");
}

void add_packet_run_options(CLI::App& command, PacketRunOptions& options, const std::string& what) {
  begin_group(command, "Input");
  command
      .add_option("--device", options.device,
                  "Where packets come from: ring:NAME, udp:HOST[:PORT] for a board on the network, litepcie:PATH for "
                  "one on PCI Express, file:PATH for a recording, a pipe or a character device, or "
                  "camera:NAME[?KEY=VALUE&...] for a camera, of whose "
                  "images this program makes the packets itself.")
      ->type_name("URI")
      ->required();
  command.add_flag("--wait-for-board", options.wait_for_board,
                   "Wait until a ring and a board exist, also after the board has gone. Ctrl-C ends the run.");
  command.add_flag("--newest", options.newest, "Begin with the newest packet of the ring, not the oldest unread one.");
  add_end_of_run(command, options.count, options.seconds, what);
  command.add_flag("--check", options.check, "Exit with status 1 if anything was lost, bad or missing.");
}

std::unique_ptr<Device> open_device(const PacketRunOptions& options) {
  return open_any_device(options.device, {.wait_for_board = options.wait_for_board, .discard_backlog = options.newest});
}

void run_packets(Device& device, const PacketRunOptions& options,
                 const std::function<std::uint64_t(const PacketView&)>& take,
                 const std::function<std::string()>& status, const std::function<void()>& seen) {
  constexpr auto kPatience = std::chrono::milliseconds(50);  // so that Ctrl-C and the end of the time are noticed
  constexpr std::int64_t kShowNs = 200'000'000;
  const std::uint64_t most = options.count > 0 ? options.count : std::numeric_limits<std::uint64_t>::max();
  const std::int64_t time_ns =
      options.seconds > 0 ? static_cast<std::int64_t>(options.seconds * 1e9) : std::numeric_limits<std::int64_t>::max();
  std::optional<StopSignal> stop;
  if (!options.stop_held) {
    stop.emplace();
  }
  StatusLine line;
  PacketView packet;
  std::uint64_t done = 0;
  std::int64_t first_ns = 0;
  std::int64_t next_show = now_ns() + kShowNs;
  while (done < most && !StopSignal::came()) {
    const Next next = device.next(packet, kPatience);
    if (next == Next::end) {
      break;
    }
    const std::int64_t now = now_ns();
    if (next == Next::packet) {
      first_ns = first_ns == 0 ? now : first_ns;
      done = take(packet);
      device.release();
    }
    if (first_ns != 0 && now - first_ns >= time_ns) {
      break;
    }
    if (now >= next_show) {
      if (line.visible()) {
        line.show(status());
      }
      if (seen) {
        seen();
      }
      next_show = now + kShowNs;
    }
  }
  line.show("");
}

void check_packets(const PacketRunOptions& options, const Counters& counters, std::uint64_t more) {
  const std::uint64_t faults = counters.lost_board + counters.lost_ring + counters.lost_network + counters.missing +
                               counters.bad + counters.flagged + counters.repeated + counters.restarts +
                               counters.read_errors + more;
  if (options.check && faults > 0) {
    throw CheckFailed(fmt::format("--check: {} faults", faults));
  }
}

}  // namespace selfproj
