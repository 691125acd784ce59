// What commands that take packets of any kind have in common.
#ifndef SELFPROJ_HOST_APP_PACKET_RUN_H
#define SELFPROJ_HOST_APP_PACKET_RUN_H

#include <CLI/CLI.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>

#include "host/driver/counters.h"
#include "host/driver/device.h"
#include "model/packet.h"

namespace selfproj {

struct PacketRunOptions {
  std::string device;
  bool wait_for_board = false;
  bool newest = false;
  std::uint64_t count = 0;  // 0: no limit
  double seconds = 0;       // 0: no limit
  bool check = false;
  bool stop_held = false;  // the caller has a StopSignal already
};

// Adds --device, --wait-for-board, --newest, --count, --seconds and --check, whose help says that `what` are counted.
void add_packet_run_options(CLI::App& command, PacketRunOptions& options, const std::string& what);

// Adds --count and --seconds alone.
void add_end_of_run(CLI::App& command, std::uint64_t& count, double& seconds, const std::string& what);

std::unique_ptr<Device> open_device(const PacketRunOptions& options);

// Gives every packet to `take`, which returns how many of the things that --count counts there are so far. Ends at
// --count, --seconds after the first packet, Ctrl-C, or the end of the device. `status` makes the line on a terminal;
// `seen` is called five times a second.
void run_packets(Device& device, const PacketRunOptions& options,
                 const std::function<std::uint64_t(const PacketView&)>& take,
                 const std::function<std::string()>& status, const std::function<void()>& seen = {});

// Throws CheckFailed if --check was given and the driver counted a fault, or `more` is not 0.
void check_packets(const PacketRunOptions& options, const Counters& counters, std::uint64_t more = 0);

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_PACKET_RUN_H
