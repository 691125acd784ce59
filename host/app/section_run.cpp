#include "host/app/section_run.h"

#include <fmt/format.h>

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>
#include <system_error>
#include <vector>

#include "host/cli/command_line.h"
#include "host/driver/clock.h"
#include "host/files/notes.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/production/part_result.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/pixel_clock.h"

namespace selfproj::app {

rig::Rig SectionOptions::load_rig(bool way_is_said) const {
  rig::Rig result = rig::load_any_rig(rig);
  if (result.kind != rig::RigKind::light_section) {
    throw UserError(rig, "is not a rig of kind light-section");
  }
  if (!assume.empty()) {
    rig::assume(result, assume, "--assume");
  }
  rig::expect_measured(result, rig, way_is_said ? rig::Millimetres::of_section : rig::Millimetres::of_part);
  if (pixel_clock_hz) {
    result.board = rig::RigBoard{.pixel_clock_hz = *pixel_clock_hz};
  }
  return result;
}

namespace {

// The file with the reference beside a recording or images, if there is one; else empty.
std::string reference_beside(const std::string& device, const std::vector<std::string>& images) {
  constexpr std::string_view kFile = "file:";
  std::string file;
  if (device.starts_with(kFile)) {
    file = light_section::reference_file_of(device.substr(kFile.size()));
  } else if (!images.empty()) {
    const std::string first = images::files_of_patterns("--images", images).front();
    file = (std::filesystem::path(first).parent_path() / images::kReferenceFile).string();
  }
  std::error_code unused;
  return std::filesystem::is_regular_file(file, unused) ? file : std::string();
}

}  // namespace

light_section::ReferenceProfile SectionOptions::load_reference(const rig::Rig& loaded, const std::string& device,
                                                               const std::vector<std::string>& images) const {
  const std::string beside = reference_beside(device, images);
  if (reference.empty()) {
    return beside.empty() ? light_section::reference_of_plane(loaded)
                          : selfproj::light_section::load_reference(loaded, beside);
  }
  light_section::ReferenceProfile chosen = selfproj::light_section::load_reference(loaded, reference);
  // That of images may be better than the one of their pattern: without its residual.
  if (!beside.empty() && images.empty() &&
      light_section::reference_csv(loaded, chosen) !=
          light_section::reference_csv(loaded, selfproj::light_section::load_reference(loaded, beside))) {
    throw UserError("--reference " + reference,
                    fmt::format("is not the one under which {} was taken, which is {}", device, beside));
  }
  return chosen;
}

std::string SectionOptions::reference_name(const std::string& device, const std::vector<std::string>& images) const {
  const std::string beside = reference_beside(device, images);
  return !reference.empty() ? reference : !beside.empty() ? beside : "plane";
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
      ->default_str("the one beside a recording (FILE.reference.csv) or images (reference.csv), or the empty plane");
  command
      .add_option("--pixel-clock-hz", options.pixel_clock_hz,
                  "Pixel clock of the board in Hz, which its time stamps count.")
      ->transform(cli::real_number(model::kMinPixelClockHz, model::kMaxPixelClockHz))
      ->type_name("HZ")
      ->default_str(fmt::format("the rig's, or {:.0f}", model::kDefaultPixelClockHz));
}

std::string doubt_about(const SectionCounts& counts, const rig::Rig& rig) {
  if (counts.profiles == 0 && counts.not_moments > 0) {
    return fmt::format("none of {} packets has moments: they are images, codes or verdicts alone", counts.not_moments);
  }
  rig::RigMeasure measure = rig.measure;
  measure.threshold = counts.threshold;
  const std::string doubt = light_section::doubt_about_columns(counts.columns, measure);
  return doubt.empty() || counts.profiles == 0 || counts.threshold == rig.measure.threshold
             ? doubt
             : fmt::format("{} (measured with the threshold {}; the rig's is {})", doubt, counts.threshold,
                           rig.measure.threshold);
}

const std::string& NewestDoubt::about(const SectionCounts& counts, const rig::Rig& rig) {
  constexpr int kCalls = 10;  // two seconds
  if (++calls_ >= kCalls) {
    SectionCounts newest = counts;
    for (std::size_t i = 0; i < before_.size(); ++i) {
      newest.columns.at(i) -= before_.at(i);
    }
    before_ = counts.columns;
    calls_ = 0;
    text_ = doubt_about(newest, rig);
  }
  return text_;
}

std::string delay_text(const driver::DurationHistogram& delay) {
  return fmt::format("delay p50 {}, p99 {}, max {}", production::time_text(delay.percentile_ns(0.5)),
                     production::time_text(delay.percentile_ns(0.99)), production::time_text(delay.longest_ns()));
}

void SectionRun::note_differences(const model::PacketHeader& header, const std::string& uri) const {
  const model::Measure of = model::measure_of(header);
  if (of.bits != measure_.bits) {
    files::note(
        fmt::format("{}: its moments are of pixels of {} bits, and measure.pixel_bits of the rig is {}: heights "
                    "are the same, M0 and thresholds are values of {} bits",
                    uri, of.bits, measure_.bits, of.bits));
  }
  if (!select_ && of.select != measure_.select) {
    files::note(fmt::format("{}: its packets are of select {}, and the rig says {} (measure.runs)", uri,
                            images::select_name(of.select), images::select_name(measure_.select)));
  } else if (of.select == model::Select::strongest &&
             model::column_word(header) == model::ColumnWord::tall_binary_run) {
    files::note(
        fmt::format("{}: words of mode binary and more than {} rows tell of no second run: no column is ambiguous", uri,
                    spec::kMaxRows));
  }
}

bool SectionRun::is_usable(const model::PacketView& packet, const std::string& uri) {
  const model::PacketHeader& header = packet.header;
  if (!model::has_columns(header.kind)) {
    ++counts_.not_moments;
    return false;
  }
  if (const std::string unlike = profiler_.unlike_camera(header); !unlike.empty()) {
    if (counts_.profiles == 0) {
      throw UserError(uri, unlike);
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
  if (bits_ == 0) {
    bits_ = header.pixel_bits;
    note_differences(header, uri);
  } else if (header.pixel_bits != bits_) {
    if (!other_bits_) {
      files::note(fmt::format("{}: some frames are of pixels of {} bits, those before of {}: they give no profile", uri,
                              header.pixel_bits, bits_));
      other_bits_ = true;
    }
    ++counts_.other_select;
    return false;
  }
  return true;
}

bool SectionRun::profile(const model::PacketView& packet, const driver::Device& device,
                         const light_section::ProfileView& to) {
  if (!is_usable(packet, device.uri()) || !profiler_.profile(packet, to)) {
    return false;
  }
  count(packet.header, to, device.arrival_ns());
  return true;
}

void SectionRun::profile(const model::PacketHeader& header, const model::RunsView& runs, const std::string& source,
                         std::int64_t arrival_ns, const light_section::ProfileView& to) {
  if (const std::string unlike = profiler_.unlike_reference(header); !unlike.empty()) {
    throw UserError(source, unlike + "; let the rig say what counts (measure.runs, measure.window)");
  }
  profiler_.profile(runs, to);
  count(header, to, arrival_ns);
}

void SectionRun::count(const model::PacketHeader& header, const light_section::ProfileView& made,
                       std::int64_t arrival_ns) {
  const std::int64_t now = driver::now_ns();
  counts_.first_done_ns = counts_.profiles == 0 ? now : counts_.first_done_ns;
  counts_.last_done_ns = now;
  counts_.delay.add(now - arrival_ns);
  ++counts_.profiles;
  counts_.threshold = header.threshold;
  light_section::count_columns({made.validity, static_cast<std::size_t>(profiler_.columns())}, counts_.columns);
}

}  // namespace selfproj::app
