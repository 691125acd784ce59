// What `selfproj inspect` does with parts: judges them and tells of them.
#ifndef SELFPROJ_HOST_APP_LINE_RUN_H
#define SELFPROJ_HOST_APP_LINE_RUN_H

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/inspection_loop.h"
#include "host/driver/counters.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/reference_profile.h"
#include "host/line/live_page.h"
#include "host/line/modbus_server.h"
#include "host/line/part_files.h"
#include "host/line/part_line.h"
#include "host/parts/judge.h"
#include "host/report/facts.h"
#include "host/rig/rig.h"

namespace selfproj {

struct LineOptions {
  std::string folder;     // of the results of parts; empty: none
  std::string tolerance;  // empty: no parts
  std::uint64_t keep = 1000;
  std::string modbus;
  std::string live;

  [[nodiscard]] bool any() const { return !folder.empty() || !tolerance.empty() || !modbus.empty() || !live.empty(); }
};

// Adds --tolerance, --parts, --keep-parts, --modbus and --live.
void add_line_options(CLI::App& command, LineOptions& options);

class LineRun {
 public:
  // Throws UserError about options, rig, tolerance and ports.
  LineRun(const LineOptions& options, const Rig& rig, const ReferenceProfile& reference,
          const DifferentialProfiler& profiler, const std::string& title);

  // Where the profiles go.
  [[nodiscard]] PartLine& line() { return *line_; }

  // Takes what has been counted so far, and the figures that stand for it.
  void seen(const Counters& counters, std::vector<Fact> figures);

  // For the line on a terminal: ", 12 parts: 10 OK, ...".
  [[nodiscard]] std::string text() const;

  // Judges and writes what is left. Throws UserError.
  void finish();

  // What is counted in the end.
  [[nodiscard]] std::vector<Fact> facts() const;
  void print() const;

 private:
  void take(const PartResult& result, const PlacedMaps& maps);

  LineOptions options_;
  std::atomic<std::uint64_t> lost_{0};
  std::optional<Judge> judge_;
  std::optional<PartFiles> files_;
  std::optional<LivePage> live_;
  std::optional<PartLine> line_;  // before what asks it
  std::optional<ModbusServer> modbus_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_LINE_RUN_H
