#include "sim/cosim/vector_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstddef>
#include <iterator>
#include <limits>
#include <string>
#include <variant>
#include <vector>

#include "model/register_file.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/model/little_endian.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/model/verdict.h"

namespace selfproj::sim {
namespace {

constexpr const char* kRegisters = "registers.hex";
constexpr const char* kCamera = "camera.hex";
constexpr const char* kEncoder = "encoder.hex";
constexpr const char* kPackets = "packets.hex";
constexpr const char* kColumns = "columns.hex";

// Idle clocks after the last write, in which it comes into force.
constexpr std::uint64_t kAfterWrites = 64;

std::vector<model::RegisterWrite> writes_of(const PlatformOptions& options) {
  const model::BoardSettings& settings = options.settings;
  std::vector<model::RegisterWrite> writes;
  if (!options.limits.empty()) {
    const auto sections = static_cast<int>(std::bit_ceil(options.limits.size()));
    writes = model::limits_writes(settings.verdict_settings.bank, options.limits, settings.columns, sections);
  }
  if (options.patterns > 1) {
    writes.push_back({spec::kRegTriggerControl,
                      1U << spec::kRegTriggerControlOnFrameLsb | static_cast<std::uint32_t>(options.patterns - 1)
                                                                     << spec::kRegTriggerControlLastPatternLsb});
  }
  if (settings.verdict) {  // refused before these are written; the pin is in no vector
    writes.push_back({spec::kRegEjectorDelay, 0});
    writes.push_back({spec::kRegEjectorLength, 1});
  }
  for (const model::RegisterWrite& write : model::setting_writes(settings, {}, settings.codes)) {
    writes.push_back(write);
  }
  return writes;
}

}  // namespace

VectorFiles::VectorFiles(const std::string& folder, const PlatformOptions& options)
    : folder_(folder),
      timing_(camera_timing(options.settings.rows, options.settings.columns, options.frame_rate_hz,
                            options.pixel_clock_hz)),
      pixel_bits_(options.pixel_bits),
      clocks_a_step_(options.encoder_steps_per_s > 0 ? options.pixel_clock_hz / options.encoder_steps_per_s : 0),
      idle_(kAfterWrites) {
  std::string text = "// writes at the AXI4-Lite port: address, data\n";
  for (const auto& [address, data] : writes_of(options)) {
    fmt::format_to(std::back_inserter(text), "{:02x}{:08x}\n", address, data);
  }
  folder_.append(kRegisters, text);
  folder_.append(kCamera,
                 fmt::format("// pixels of {} bits; beats: idle clocks before it, flags (1: frame start, 2: line "
                             "end), {} pixels\n",
                             pixel_bits_, spec::kPixelsPerBeat));
  folder_.append(kEncoder, "// changes of the pins: clocks after the first beat, levels (1: a, 2: b)\n");
  folder_.append(kPackets, "// beats: 1 if the last of a packet, 128 bits of data\n");
  folder_.append(kColumns, "// columns: m0, m1\n");
}

void VectorFiles::frame(const model::SensorView& image) {
  std::string text;
  const std::uint64_t beats = timing_.beats_a_line();
  const auto pixels_of = [&](const auto& view, int row, std::uint64_t beat) {
    const auto* pixels = view.pixels + row * view.stride + static_cast<std::ptrdiff_t>(spec::kPixelsPerBeat * beat);
    std::uint64_t word = 0;
    for (int i = spec::kPixelsPerBeat; i-- > 0;) {
      word = word << pixel_bits_ | pixels[i];
    }
    return word;
  };
  for (int row = 0; row < timing_.rows; ++row) {
    for (std::uint64_t beat = 0; beat < beats; ++beat) {
      const unsigned flags = (row == 0 && beat == 0 ? 1U : 0U) | (beat == beats - 1 ? 2U : 0U);
      const std::uint64_t word = std::visit([&](const auto& view) { return pixels_of(view, row, beat); }, image);
      fmt::format_to(std::back_inserter(text), "{:08x}{:02x}{:0{}x}\n", beat == 0 ? idle_ : 0, flags, word,
                     spec::kPixelsPerBeat * pixel_bits_ / 4);
    }
    idle_ = timing_.line_clocks - beats;
  }
  idle_ += timing_.frame_clocks - static_cast<std::uint64_t>(timing_.rows) * timing_.line_clocks;
  // Where 32 bits do not hold a pause, a shorter one changes only time stamps.
  idle_ = std::min<std::uint64_t>(idle_, std::numeric_limits<std::uint32_t>::max());
  folder_.append(kCamera, text);
  ++frames_;
}

// The encoder's clocks are those of Conveyor.
void VectorFiles::commit() {
  std::string text;
  const std::uint64_t end =
      std::min<std::uint64_t>(frames_ * timing_.frame_clocks, std::numeric_limits<std::uint32_t>::max());
  for (std::uint64_t step = 1; clocks_a_step_ > 0; ++step) {
    const auto clock = static_cast<std::uint64_t>(std::llround(static_cast<double>(step) * clocks_a_step_));
    if (clock >= end) {
      break;
    }
    const EncoderLevels levels = levels_of_step(step);
    fmt::format_to(std::back_inserter(text), "{:08x}{:02x}\n", clock, (levels.a ? 1 : 0) + (levels.b ? 2 : 0));
  }
  folder_.append(kEncoder, text);
  folder_.commit();
}

void VectorFiles::packet(const model::PacketView& packet) {
  std::string text;
  const std::span<const std::uint8_t> bytes = packet.bytes();
  for (std::size_t at = 0; at < bytes.size(); at += spec::kPacketBeatBytes) {
    fmt::format_to(std::back_inserter(text), "{:02x}{:016x}{:016x}\n",
                   at + spec::kPacketBeatBytes == bytes.size() ? 1 : 0,
                   model::load_little_endian<std::uint64_t>(bytes.data() + at + 8),
                   model::load_little_endian<std::uint64_t>(bytes.data() + at));
  }
  folder_.append(kPackets, text);

  const model::PacketHeader& header = packet.header;
  if (!model::has_columns(header.kind) || packet.payload.empty()) {
    return;
  }
  const model::Measure measure = model::measure_of(header);
  model::Runs columns;
  columns.resize(measure.select, header.columns);
  model::unpack_columns(header, packet.payload.data(), columns.view());
  text.clear();
  for (std::size_t i = 0; i < header.columns; ++i) {
    fmt::format_to(std::back_inserter(text), "{:08x}{:08x}\n", columns.moments.m0[i], columns.moments.m1[i]);
  }
  folder_.append(kColumns, text);
}

}  // namespace selfproj::sim
