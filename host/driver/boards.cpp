#include "host/driver/boards.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <string>
#include <system_error>
#include <thread>
#include <utility>
#include <vector>

#include "host/driver/control.h"
#include "selfproj/files/user_error.h"

namespace selfproj::driver {
namespace {

// A bit that walks, and its complement.
std::string patterns_fault(Control& control, const RegisterPart& part) {
  const std::uint32_t mask = part.in->mask();
  const std::uint32_t before = control.read(part) & mask;
  std::string fault;
  for (std::uint32_t bit = 1; bit != 0 && fault.empty(); bit <<= 1U) {
    if ((bit & mask) == 0) {
      continue;
    }
    for (const std::uint32_t value : {bit, ~bit & mask}) {
      if (value == 0) {
        continue;  // the period may not be 0
      }
      try {
        control.write(part, value);
        if (const std::uint32_t read = control.read(part) & mask; read != value) {
          fault = "wrote " + std::to_string(value) + ", read " + std::to_string(read);
        }
      } catch (const UserError& error) {
        fault = error.what();
      }
      if (!fault.empty()) {
        break;
      }
    }
  }
  try {
    control.write(part, before);
  } catch (const UserError& error) {
    fault = fault.empty() ? error.what() : fault;
  }
  return fault;
}

// The board must refuse this value, and keep the old one.
std::string refusal_fault(Control& control, const char* name, std::uint32_t value) {
  const std::uint32_t before = control.read(name);
  try {
    control.write(name, value);
  } catch (const UserError&) {
    return control.read(name) == before ? "" : "refused, but changed";
  }
  control.write(name, before);
  return "accepted";
}

std::string clock_fault(Control& control) {
  const std::uint64_t first = control.state().time;
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return control.state().time > first ? "" : "it stands still";
}

}  // namespace

std::vector<BoardPlace> list_boards(const std::filesystem::path& devices, const std::vector<std::string>& hosts) {
  std::vector<BoardPlace> boards;
  std::error_code error;
  for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(devices, error)) {
    const std::string name = entry.path().filename().string();
    if ((name.starts_with("xdma") && name.ends_with("_user")) || name.starts_with("uio")) {
      boards.push_back({.uri = "bar:" + entry.path().string(), .problem = ""});
    } else if (name.starts_with("litepcie")) {
      boards.push_back({.uri = "litepcie:" + entry.path().string(), .problem = ""});
    }
  }
  std::sort(boards.begin(), boards.end(), [](const auto& one, const auto& other) { return one.uri < other.uri; });
  for (const std::string& host : hosts) {
    boards.push_back({.uri = "udp:" + host, .problem = ""});
  }
  for (BoardPlace& board : boards) {
    try {
      static_cast<void>(open_control(board.uri));
    } catch (const UserError& problem) {
      const std::string text = problem.what();
      board.problem = text.starts_with(board.uri + ": ") ? text.substr(board.uri.size() + 2) : text;
    }
  }
  return boards;
}

std::vector<BoardTestResult> test_board(Control& control) {
  if (control.read("control.run") != 0 || control.read("trigger_control.run") != 0) {
    throw UserError(control.uri(), "the board runs; stop it and its trigger pulses before the test");
  }
  std::vector<BoardTestResult> results;
  for (const char* const name : {"timeout", "trigger_period", "trigger_camera", "trigger_width"}) {
    results.push_back({std::string("patterns in ") + name, patterns_fault(control, register_part(name))});
  }
  const std::array<std::pair<const char*, std::uint32_t>, 3> refused{{
      {"size.columns", 2},          // no multiple of 4
      {"size.rows", 0},             // no row
      {"trigger_period.clocks", 0}  // no period
  }};
  for (const auto& [name, value] : refused) {
    results.push_back(
        {std::string("refusal of ") + name + "=" + std::to_string(value), refusal_fault(control, name, value)});
  }
  results.push_back({"the pixel clock", clock_fault(control)});
  return results;
}

}  // namespace selfproj::driver
