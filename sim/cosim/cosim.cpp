#include "sim/cosim/cosim.h"

#include <fmt/format.h>

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <system_error>
#include <utility>
#include <vector>

#include "host/cli/progress.h"
#include "host/driver/sim_device.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/files/results_file.h"
#include "host/files/temporary.h"
#include "host/images/image_files.h"
#include "host/light_section/line_finder.h"
#include "host/report/facts.h"
#include "host/report/report.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/packet.h"
#include "sim/board/packet_scoreboard.h"
#include "sim/cosim/cosim_measurement.h"
#include "sim/cosim/cosim_options.h"
#include "sim/cosim/vector_files.h"
#include "sim/platform/platform.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

namespace fs = std::filesystem;

std::unique_ptr<CosimMeasurement> make_measurement(const CosimOptions& options) {
  if (!options.frames.empty()) {
    return make_recorded_cosim(options);
  }
  const SceneInfo& scene = find_scene(options.scene);
  switch (scene.method) {
    case SceneMethod::gray_codes:
      return make_scanner_cosim(options, scene);
    case SceneMethod::self_projected:
      return make_self_projected_cosim(options, scene);
    case SceneMethod::light_section:
      break;
  }
  return make_light_section_cosim(options, scene);
}

// A waveform file, written by the simulator. It is named NAME.part until commit(), and is removed if the run fails
// before that.
class TraceFile {
 public:
  TraceFile(std::string name, const std::string& part) : name_(std::move(name)) {
    if (name_.empty()) {
      return;
    }
    const files::OutputFile check(name_);
    const files::OutputFile check_part(part);
    std::error_code error;
    parents_.emplace(files::parent_of(name_), error);
    if (error) {
      throw UserError(name_, error.message());
    }
    part_.emplace(part);
    hierarchy_.emplace(part + ".hier");
  }
  void commit() {
    if (name_.empty()) {
      return;
    }
    std::error_code error;
    fs::rename(part_->path(), name_, error);
    if (error) {
      throw UserError(name_, error.message());
    }
    part_->keep();
    parents_->keep();
  }

 private:
  std::string name_;
  std::optional<files::MadeFolders> parents_;
  std::optional<files::RemovedAtEnd> part_;
  std::optional<files::RemovedAtEnd> hierarchy_;
};

// The file beside the packets for the reference under whose pattern they are taken; null where that is not known.
// Throws UserError if one lies there that would go with these packets.
std::unique_ptr<files::OutputFile> reference_file_of(const CosimOptions& options, const CosimMeasurement& measurement) {
  if (options.packets.empty()) {
    return nullptr;
  }
  const std::string beside = light_section::reference_file_of(options.packets);
  std::error_code unused;
  if (!measurement.reference().empty()) {
    return std::make_unique<files::OutputFile>(beside);
  }
  if (fs::exists(beside, unused)) {
    throw UserError("--packets " + options.packets,
                    beside + " lies beside it and would go with these packets; give another name");
  }
  return nullptr;
}

PlatformOptions platform_of(const CosimOptions& options, CosimMeasurement& measurement) {
  PlatformOptions platform = measurement.platform();
  platform.bus.stall_percent = options.bus_stall;
  if (!options.trace.empty()) {
    if (platform.engine != PlatformEngine::rtl) {
      throw UserError("--trace " + options.trace, "goes only with --engine rtl");
    }
    const std::size_t total = measurement.source().total();
    if (options.trace_from > total) {
      throw UserError(fmt::format("--trace-from {}", options.trace_from), fmt::format("the run has {} frames", total));
    }
    platform.trace_file = options.trace + ".part";
    platform.trace_from = options.trace_from;
  }
  return platform;
}

// Packets of all kinds.
std::uint64_t counted_as_lost(const BoardCounters& board) {
  return board.lost_moments + board.lost_image + board.lost_codes;
}

// Adds a mismatch for each counter that does not have the value that this run must give.
void compare_counters(CosimResult& result, std::uint64_t misframed) {
  const auto must_be = [&](std::uint64_t got, std::uint64_t want, const char* what) {
    if (got != want) {
      result.mismatch(fmt::format("{}: {}, expected {}", what, got, want));
    }
  };
  const BoardCounters& board = result.platform.board;
  must_be(board.frames, result.platform.frames, "frames accepted by the board");
  must_be(board.broken, 0, "broken frames");
  must_be(board.stray, 0, "beats outside any frame");
  must_be(counted_as_lost(board), result.lost, "packets that the board counted as lost");
  must_be(board.abandoned, 0, "frames abandoned by the decoder");
  must_be(result.driver.bad, 0, "packets refused by the driver");
  must_be(result.driver.bytes_discarded, 0, "bytes discarded by the driver");
  must_be(misframed, 0, "packets whose end is not where their header says");
  must_be(result.driver.delivered, result.platform.packets, "packets delivered by the driver");
}

// One run. The platform feeds the frames to the board. Each packet that the driver delivers is compared with the model,
// appended to `stream`, and given to the vectors and the measurement.
class Run {
 public:
  // `stream`, `vectors` and `folder` may be null.
  Run(CosimMeasurement& measurement, std::string* stream, VectorFiles* vectors, files::OutputFolder* folder)
      : measurement_(measurement), stream_(stream), vectors_(vectors), folder_(folder) {}

  CosimResult operator()(const PlatformOptions& options) {
    FrameSource& source = measurement_.source();
    cli::Progress progress("frame", source.total());
    std::size_t given = 0;
    Platform platform(
        options,
        [&]() -> std::optional<model::SensorView> {
          const images::SensorImage* image = source.next();
          if (image == nullptr) {
            return std::nullopt;
          }
          measurement_.frame(given++, source.picture());
          progress.update(given);
          if (vectors_ != nullptr) {
            vectors_->frame(light_section::view_of(*image));
          }
          return light_section::view_of(*image);
        },
        [&](std::span<const std::uint8_t> bytes, std::uint64_t /*time_ps*/) { receive(bytes); },
        [&](model::BoardPacket&& packet) { scoreboard_.expect(std::move(packet)); });
    platform.run();
    device_.finish();
    next_packets();
    scoreboard_.finish();

    result_.columns = scoreboard_.matched_columns();
    result_.codes = scoreboard_.matched_codes();
    result_.mismatches = scoreboard_.mismatches();
    result_.first_mismatch = scoreboard_.first_mismatch();
    result_.lost = scoreboard_.lost();
    result_.platform = platform.report();
    result_.driver = device_.counters();
    compare_counters(result_, device_.misframed());
    measurement_.compare(result_);
    return result_;
  }

 private:
  void receive(std::span<const std::uint8_t> bytes) {
    for (std::size_t at = 0; at < bytes.size(); at += spec::kPacketBeatBytes) {
      const bool last = at + spec::kPacketBeatBytes >= bytes.size();
      if (!device_.push(bytes.subspan(at, last ? bytes.size() - at : spec::kPacketBeatBytes), last)) {
        throw std::logic_error("the driver's buffer is full");
      }
    }
    next_packets();
  }

  void next_packets() {
    model::PacketView packet;
    while (device_.next(packet, std::chrono::nanoseconds(0)) == driver::Next::packet) {
      const std::span<const std::uint8_t> bytes = packet.bytes();
      const auto kind = packet.header.kind;
      if (scoreboard_.compare(bytes) && (model::has_columns(kind) || kind == spec::kKindVerdict)) {
        ++result_.frames;
      }
      if (stream_ != nullptr) {
        stream_->append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
      }
      if (vectors_ != nullptr) {
        vectors_->packet(packet);
      }
      measurement_.packet(packet, folder_);
      device_.release();
    }
  }

  CosimMeasurement& measurement_;
  std::string* stream_;
  VectorFiles* vectors_;
  files::OutputFolder* folder_;
  PacketScoreboard scoreboard_;
  driver::SimDevice device_;
  CosimResult result_;
};

std::vector<report::Fact> counters_of(const CosimMeasurement& measurement, const CosimResult& result) {
  std::vector<report::Fact> facts = measurement.counters(result);
  const auto add = [&](const char* key, const char* label, std::uint64_t value) {
    facts.push_back({key, label, static_cast<std::int64_t>(value)});
  };
  add("matched_columns", "columns of moments equal to the model's", result.columns);
  add("matched_frames", "frames equal to the model's", result.frames);
  add("mismatches", "mismatches with the model", result.mismatches);
  facts.push_back(report::counter_fact(&driver::Counters::delivered, result.driver.delivered));
  // Also those after the last packet that came, which the driver cannot know of.
  facts.push_back(report::counter_fact(&driver::Counters::lost_board, result.lost));
  facts.push_back(report::counter_fact(&driver::Counters::lost_ring, result.driver.lost_ring));
  facts.push_back(report::counter_fact(&driver::Counters::bad, result.driver.bad));
  facts.push_back(report::counter_fact(&driver::Counters::resynchronized, result.driver.resynchronized));
  return facts;
}

CosimFacts facts_of(const CosimOptions& options, const CosimMeasurement& measurement, const CosimResult& result) {
  std::vector<report::Fact> settings = measurement.settings();
  settings.push_back({"clocks", "pixel clocks simulated", static_cast<std::int64_t>(result.platform.clocks)});
  settings.push_back({"bus_stall", "bus not ready", std::int64_t{options.bus_stall}, "%"});
  return {.title = options.frames.empty() ? "Co-simulation: " + options.scene : "Co-simulation of recorded images",
          .counters = counters_of(measurement, result),
          .settings = std::move(settings)};
}

// Results are named cosim_SCENE, or cosim_SCENE_ENGINE if the engine is not the RTL. For recorded images none are kept.
void keep_results(const CosimOptions& options, const CosimMeasurement& measurement, const CosimResult& result) {
  if (options.frames.empty()) {
    const CosimFacts facts = facts_of(options, measurement, result);
    files::write_results("cosim_" + options.scene + (options.engine == "rtl" ? "" : "_" + options.engine),
                         "Co-simulation of the scene " + options.scene + ", every packet compared with the model",
                         {{"matched", measurement.matched(result)},
                          {"counters", report::facts_json(facts.counters)},
                          {"findings", report::facts_json(measurement.findings())},
                          {"settings", report::facts_json(facts.settings)}});
  }
}

// Prints the outcome for the user. Throws CheckFailed if something did not match.
void print_outcome(const CosimOptions& options, const CosimMeasurement& measurement, const CosimResult& result,
                   double seconds) {
  const auto clocks = static_cast<double>(result.platform.clocks);
  fmt::print("{}", measurement.text());
  fmt::print("{:.2f} M pixel clocks in {:.1f} s: {:.2f} M clocks/s, 1/{:.0f} of real time\n", clocks * 1e-6, seconds,
             clocks / seconds * 1e-6, seconds / result.platform.seconds);
  if (result.lost != 0) {
    const bool counted = counted_as_lost(result.platform.board) == result.lost;
    fmt::print("{} expected packets did not arrive{}\n", result.lost,
               counted ? ", and the board counted all of them" : "");
  }
  for (const std::string& written : {options.out, options.packets, options.vectors, options.trace}) {
    if (!written.empty()) {
      fmt::print("→ {}\n", written);
    }
  }
  fmt::print("matched {}, {} mismatches\n", measurement.matched(result), result.mismatches);
  if (result.mismatches != 0) {
    std::fflush(stdout);
    throw CheckFailed(result.first_mismatch);
  }
}

}  // namespace

void run_cosim(const CosimOptions& options) {
  const std::optional<files::OutputFile> packets_file =
      options.packets.empty() ? std::nullopt : std::optional<files::OutputFile>(options.packets);
  std::optional<files::OutputFolder> folder;
  if (!options.out.empty()) {
    folder.emplace(options.out);
  }
  const std::unique_ptr<CosimMeasurement> measurement = make_measurement(options);
  const std::unique_ptr<files::OutputFile> reference_file = reference_file_of(options, *measurement);
  const PlatformOptions platform = platform_of(options, *measurement);
  std::optional<VectorFiles> vectors;
  if (!options.vectors.empty()) {
    vectors.emplace(options.vectors, platform);
  }
  TraceFile trace(options.trace, platform.trace_file);
  if (folder) {
    measurement->choose_pictures();
  }

  std::string stream;
  const auto start = std::chrono::steady_clock::now();
  const CosimResult result = Run(*measurement, packets_file ? &stream : nullptr, vectors ? &*vectors : nullptr,
                                 folder ? &*folder : nullptr)(platform);
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

  if (folder) {
    measurement->write(*folder, facts_of(options, *measurement, result));
    folder->commit();
  }
  if (packets_file) {
    packets_file->write(stream);
  }
  if (vectors) {
    vectors->commit();
  }
  if (reference_file) {
    reference_file->write(measurement->reference());
  }
  trace.commit();
  keep_results(options, *measurement, result);
  print_outcome(options, *measurement, result, seconds);
}

}  // namespace selfproj::sim
