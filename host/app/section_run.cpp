#include "host/app/section_run.h"

#include <fmt/format.h>

#include <cstdint>
#include <string>

#include "host/cli/command_line.h"
#include "host/driver/clock.h"
#include "host/images/frame_options.h"
#include "host/production/part_result.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::app {

rig::Rig SectionOptions::load_rig() const {
  rig::Rig result = rig::load_any_rig(rig);
  if (result.kind != rig::RigKind::light_section) {
    throw UserError(rig, "is not a rig of kind light-section");
  }
  if (!assume.empty()) {
    rig::assume(result, assume, "--assume");
  }
  rig::expect_measured(result, rig);
  if (pixel_clock_hz) {
    result.board = rig::RigBoard{.pixel_clock_hz = *pixel_clock_hz};
  }
  return result;
}

light_section::ReferenceProfile SectionOptions::load_reference(const rig::Rig& loaded) const {
  return reference.empty() ? light_section::reference_of_plane(loaded)
                           : selfproj::light_section::load_reference(loaded, reference);
}

model::Measure measure_of_rig(const rig::Rig& rig, const std::string& select) {
  model::Measure measure = rig.measure.of_board();
  if (!select.empty()) {
    measure.select = images::select_of(select);
    measure.gap = measure.select == model::Select::all ? 0 : measure.gap;
  }
  return measure;
}

void add_section_options(CLI::App& command, SectionOptions& options) {
  command.add_option("--rig", options.rig, "Built-in rig or YAML file.")->type_name("RIG")->capture_default_str();
  command
      .add_option("--assume", options.assume,
                  "Values of the rig that are taken though no calibration measured them (its section `sources`), with "
                  "commas between them: camera, light, belt, speed, encoder.")
      ->type_name("NAME,...");
  command
      .add_option("--reference", options.reference,
                  "Folder that `selfproj pattern` wrote for the good part whose pattern is projected.")
      ->type_name("DIR")
      ->default_str("the empty plane");
  command
      .add_option("--pixel-clock-hz", options.pixel_clock_hz,
                  "Pixel clock of the board in Hz, which its time stamps count.")
      ->transform(cli::real_number(model::kMinPixelClockHz, model::kMaxPixelClockHz))
      ->type_name("HZ")
      ->default_str(fmt::format("the rig's, or {:.0f}", model::kDefaultPixelClockHz));
}

std::string delay_text(const driver::DurationHistogram& delay) {
  return fmt::format("delay p50 {}, p99 {}, max {}", production::time_text(delay.percentile_ns(0.5)),
                     production::time_text(delay.percentile_ns(0.99)), production::time_text(delay.longest_ns()));
}

bool SectionRun::is_usable(const model::PacketView& packet, const std::string& uri) {
  const model::PacketHeader& header = packet.header;
  if (header.kind != spec::kKindMoments) {
    ++counts_.not_moments;
    return false;
  }
  if (header.columns != rig_.camera.columns || header.rows != rig_.camera.rows) {
    if (counts_.profiles == 0) {
      throw UserError(uri, fmt::format("its frames are {} x {} pixels, those of the rig {} x {}", header.columns,
                                       header.rows, rig_.camera.columns, rig_.camera.rows));
    }
    ++counts_.other_size;
    return false;
  }
  if (packet.status != 0) {
    ++counts_.broken;
    return false;
  }
  if (select_ && header.select != static_cast<std::uint8_t>(*select_)) {
    if (counts_.profiles == 0) {
      throw UserError(uri, fmt::format("its packets are of {}, not of --select {}",
                                       images::select_name(static_cast<model::Select>(header.select)),
                                       images::select_name(*select_)));
    }
    ++counts_.other_select;
    return false;
  }
  if (const std::string unlike = profiler_.unlike_reference(header); !unlike.empty()) {
    if (counts_.profiles == 0) {
      throw UserError(uri, unlike + "; let the rig say what counts (measure.runs, measure.window)");
    }
    ++counts_.other_select;
    return false;
  }
  return true;
}

bool SectionRun::profile(const model::PacketView& packet, const driver::Device& device,
                         const light_section::ProfileView& to) {
  if (!is_usable(packet, device.uri())) {
    return false;
  }
  profiler_.profile(static_cast<model::Select>(packet.header.select), static_cast<model::Mode>(packet.header.mode),
                    packet.payload.data(), to);
  const std::int64_t now = driver::now_ns();
  counts_.first_done_ns = counts_.profiles == 0 ? now : counts_.first_done_ns;
  counts_.last_done_ns = now;
  counts_.delay.add(now - device.arrival_ns());
  ++counts_.profiles;
  std::uint32_t points = 0;
  std::uint32_t ambiguous = 0;
  for (int i = 0; i < profiler_.columns(); ++i) {
    points += to.validity[i] == static_cast<std::uint8_t>(light_section::Validity::valid) ? 1U : 0U;
    ambiguous += to.validity[i] == static_cast<std::uint8_t>(light_section::Validity::ambiguous) ? 1U : 0U;
  }
  counts_.points += points;
  counts_.ambiguous += ambiguous;
  return true;
}

}  // namespace selfproj::app
