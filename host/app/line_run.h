// What `selfproj inspect` and `selfproj match` do with parts: judge them and tell of them.
#ifndef SELFPROJ_HOST_APP_LINE_RUN_H
#define SELFPROJ_HOST_APP_LINE_RUN_H

#include <CLI/CLI.hpp>
#include <atomic>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/driver/counters.h"
#include "host/light_section/differential_profile.h"
#include "host/light_section/reference.h"
#include "host/production/camera_view.h"
#include "host/production/depth_line.h"
#include "host/production/judge.h"
#include "host/production/line_worker.h"
#include "host/production/live_page.h"
#include "host/production/modbus_server.h"
#include "host/production/part_files.h"
#include "host/production/part_line.h"
#include "host/report/facts.h"
#include "host/rig/rig.h"
#include "model/packet.h"

namespace selfproj {

struct LineOptions {
  std::string folder;     // of the results of parts; empty: none
  std::string tolerance;  // empty: no parts
  std::uint64_t keep = 1000;
  std::string modbus;
  std::string live;

  // The first option that was given; empty: none.
  [[nodiscard]] std::string first() const {
    return !tolerance.empty() ? "--tolerance"
           : !folder.empty()  ? "--parts"
           : !modbus.empty()  ? "--modbus"
           : !live.empty()    ? "--live"
                              : "";
  }
  [[nodiscard]] bool any() const { return !first().empty(); }
};

// Adds --tolerance, --parts, --keep-parts, --modbus and --live.
void add_line_options(CLI::App& command, LineOptions& options);

// What judges and reports the parts of a production line: the judge, the files, the live page and the registers. The
// parts may come as profiles or as depth images.
class LineRun {
 public:
  // Throws UserError about options, rig and tolerance. `make_judge` is called where there is a tolerance.
  LineRun(const LineOptions& options, const Rig& rig, const std::string& title,
          const std::function<Judge(const Tolerance&, const std::string& source)>& make_judge);
  LineRun(const LineRun&) = delete;
  LineRun& operator=(const LineRun&) = delete;
  virtual ~LineRun() = default;

  // Takes the counters so far, and the figures that the page shows.
  void seen(const Counters& counters, std::vector<Fact> figures);

  // Takes a packet. If it belongs to a raw image, the page may show it. Only for the thread that receives packets.
  void camera(const PacketView& packet) {
    if (camera_) {
      camera_->add(packet);
    }
  }

  // The end of the status line on a terminal: ", 12 parts: 10 OK, ...".
  [[nodiscard]] std::string text() const;

  // Judges the parts that are left, and writes their results. Throws UserError.
  void finish();

  // What is counted in the end.
  [[nodiscard]] std::vector<Fact> facts() const;
  [[nodiscard]] std::string end_text() const;  // for the terminal: one line, or nothing where no parts are judged

 protected:
  // The thread that judges. It lives as long as this object.
  [[nodiscard]] virtual const LineWorker& worker() const = 0;
  virtual LineWorker& worker() = 0;

  // Starts the Modbus server and opens the folder of results. Call it once the worker exists, because the server asks
  // the worker. Throws UserError about ports and folders.
  void open();

  [[nodiscard]] const Judge* judge() const { return judge_ ? &*judge_ : nullptr; }
  [[nodiscard]] LivePage* live() { return live_ ? &*live_ : nullptr; }
  void take(const PartResult& result, const PlacedMaps& maps);

  // Stops the Modbus server. Call it before the worker is destroyed.
  void close() { modbus_.reset(); }

 private:
  LineOptions options_;
  std::atomic<std::uint64_t> lost_{0};
  std::optional<Judge> judge_;
  std::optional<PartFiles> files_;
  std::optional<LivePage> live_;
  std::optional<CameraView> camera_;
  std::optional<ModbusServer> modbus_;
};

// The line of a light section.
class SectionLineRun final : public LineRun {
 public:
  // Throws UserError about options, rig, tolerance and ports.
  SectionLineRun(const LineOptions& options, const Rig& rig, const ReferenceProfile& reference,
                 const DifferentialProfiler& profiler, const std::string& title);
  SectionLineRun(const SectionLineRun&) = delete;
  SectionLineRun& operator=(const SectionLineRun&) = delete;
  ~SectionLineRun() override { close(); }

  // Where the profiles go.
  [[nodiscard]] PartLine& line() { return *line_; }

 private:
  [[nodiscard]] const LineWorker& worker() const override { return *line_; }
  LineWorker& worker() override { return *line_; }

  std::optional<PartLine> line_;
};

// The line of structured light.
class DepthLineRun final : public LineRun {
 public:
  // `reference_depth` is z_R in mm, NaN where there is none, and `patterns` are the frames of a depth image. Throws
  // UserError about options, rig, tolerance and ports.
  DepthLineRun(const LineOptions& options, const Rig& rig, const FloatImage& reference_depth, int patterns,
               const std::string& title);
  DepthLineRun(const DepthLineRun&) = delete;
  DepthLineRun& operator=(const DepthLineRun&) = delete;
  ~DepthLineRun() override { close(); }

  // Where the depth images go.
  [[nodiscard]] DepthLine& line() { return *line_; }

 private:
  [[nodiscard]] const LineWorker& worker() const override { return *line_; }
  LineWorker& worker() override { return *line_; }

  std::optional<DepthLine> line_;
};

}  // namespace selfproj

#endif  // SELFPROJ_HOST_APP_LINE_RUN_H
