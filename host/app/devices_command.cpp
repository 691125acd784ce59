#include "host/app/devices_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/driver/ring_list.h"
#include "host/io/user_error.h"

namespace selfproj {
namespace {

std::string side(bool there, std::uint32_t pid, std::uint32_t crashes) {
  std::string text = there ? fmt::format("process {}", pid) : "none";
  return crashes == 0 ? text : fmt::format("{}, {} crashed", text, crashes);
}

void list() {
  const std::vector<RingInfo> rings = list_rings();
  if (rings.empty()) {
    fmt::print("no ring; a board's driver or `selfproj-sim board --ring NAME` makes one\n");
    return;
  }
  fmt::print("{:24} {:26} {:26} {:>14} {:>14} {:>11} {:>12}\n", "device", "board", "reader", "written", "lost",
             "unread", "slots");
  for (const RingInfo& ring : rings) {
    if (!ring.problem.empty()) {
      fmt::print("{:24} cannot be used: {}\n", "ring:" + ring.name, ring.problem);
      continue;
    }
    fmt::print("{:24} {:26} {:26} {:>14} {:>14} {:>11} {:>12}\n", "ring:" + ring.name,
               side(ring.board, ring.board_pid, ring.board_crashes),
               side(ring.reader, ring.reader_pid, ring.reader_crashes), ring.written, ring.lost,
               ring.written - ring.read, ring.slots);
  }
}

}  // namespace

void add_devices_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand("devices", "List the rings of this machine and who writes and reads them");
  auto remove = std::make_shared<std::string>();
  command->add_option("--remove", *remove, "Take this ring away instead; what is in it is still read to its end")
      ->type_name("NAME");
  command->callback([remove] {
    if (remove->empty()) {
      list();
    } else if (!remove_ring(*remove)) {
      throw UserError("ring:" + *remove, "there is no such ring");
    }
  });
}

}  // namespace selfproj
