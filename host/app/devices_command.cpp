#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/camera/camera_uri.h"
#include "host/camera/open_camera.h"
#include "host/capture/projector.h"
#include "host/cli/command_line.h"
#include "host/driver/ring_memory.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

// The settings of a URI as a list.
std::string camera_keys() {
  std::string text;
  for (const std::string& line : camera::camera_uri_help()) {
    text += (text.empty() ? "- " : "\n- ") + line;
  }
  return text;
}

std::string side(bool there, std::uint32_t pid, std::uint32_t crashes) {
  std::string text = there ? fmt::format("process {}", pid) : "none";
  return crashes == 0 ? text : fmt::format("{}, {} crashed", text, crashes);
}

void print_cameras() {
  const std::vector<camera::CameraEntry> cameras = camera::list_cameras();
  if (cameras.empty()) {
    fmt::print("no camera{}\n",
               camera::has_aravis() ? "" : "; built without Aravis, this program knows no GigE and USB3 cameras");
    return;
  }
  fmt::print("{:40} {:12} {:32} {}\n", "camera", "interface", "model", "address");
  for (const camera::CameraEntry& camera : cameras) {
    fmt::print("{:40} {:12} {:32} {}\n", camera.uri, camera.kind, camera.model,
               camera.problem.empty() ? camera.address : "cannot be used: " + camera.problem);
  }
}

void print_displays() {
  const std::vector<capture::DisplayEntry> displays = capture::list_displays();
  if (displays.empty()) {
    fmt::print("no display\n");
    return;
  }
  fmt::print("{:14} {:14} {:>8} {}\n", "display", "pixels", "rate, Hz", "name");
  for (const capture::DisplayEntry& display : displays) {
    fmt::print("{:14} {:14} {:8g} {}\n", fmt::format("--display {}", display.number),
               fmt::format("{} x {}", display.columns, display.rows), display.rate_hz, display.name);
  }
}

void print_rings() {
  const std::vector<driver::RingInfo> rings = driver::list_rings();
  if (rings.empty()) {
    fmt::print("no ring; a board's driver or `selfproj-sim board --ring NAME` makes one\n");
    return;
  }
  fmt::print("{:24} {:26} {:26} {:>14} {:>14} {:>11} {:>12}\n", "device", "board", "reader", "written", "lost",
             "unread", "slots");
  for (const driver::RingInfo& ring : rings) {
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
  CLI::App* command = cli::add_command(
      app,
      {.name = "devices",
       .purpose = "Lists the shared-memory rings of this machine, who writes and reads them, its cameras and "
                  "displays.",
       .details = "A ring's line shows its URI for --device, the processes of board and reader and how often each has "
                  "crashed, the packets written, lost because the ring was full, and not yet read, and the slots of "
                  "the ring.\n\n"
                  "A camera's line shows its URI for --device and --camera, and its address. GigE cameras of the "
                  "network have a second to answer. One in another network is opened by its address: "
                  "camera:192.168.1.20. camera:Fake_1 is one that Aravis simulates within the program.\n\n"
                  "Settings follow the name of a camera, the first after ?, the others after &:\n\n" +
                  camera_keys(),
       .examples = R"(
# Make a ring, list it and remove it.
selfproj-sim board --line 512x96 --ring line1 --count 100 --keep
selfproj devices
selfproj devices --remove line1

# Packets of a simulated camera: this program is the board.
selfproj record --device "camera:Fake_1?region=512x96&mode=grey&threshold=100" --count 20 \
  --out camera.packets
)"});
  auto remove = std::make_shared<std::string>();
  command
      ->add_option("--remove", *remove,
                   "Remove this ring instead of listing. A reader that has it open still reads what is in it.")
      ->type_name("NAME");
  command->callback([remove] {
    if (remove->empty()) {
      print_rings();
      print_cameras();
      print_displays();
    } else if (!driver::remove_ring(*remove)) {
      throw UserError("ring:" + *remove, "there is no such ring");
    }
  });
}

}  // namespace selfproj::app
