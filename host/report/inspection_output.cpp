#include "host/report/inspection_output.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/files/json_text.h"
#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "host/report/facts.h"
#include "host/report/frame_picture.h"
#include "host/report/map_picture.h"
#include "host/report/tables.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace selfproj::report {
namespace {

constexpr std::array<const char*, light_section::kValidities> kValidityNames = {
    "valid", "unlit", "too_few", "too_wide", "cut_off", "no_reference", "out_of_range", "ambiguous", "outside"};
constexpr std::array<const char*, light_section::kValidities> kValidityLabels = {
    "points",
    "columns without light",
    "columns with too few lit pixels",
    "columns with too many lit pixels",
    "columns whose line the image's border cuts off",
    "columns without a reference",
    "columns out of range",
    "columns whose second run is nearly as strong",
    "columns outside the camera's region"};
constexpr std::size_t kOutside = static_cast<std::size_t>(light_section::Validity::outside);

// Collects text and appends it to a file of the folder, one megabyte at a time.
class Table {
 public:
  Table(files::OutputFolder& folder, std::string file) : folder_(folder), file_(std::move(file)), text_(kBytes, '\0') {}

  void append(std::string_view text) {
    char* at = room(text.size());
    std::memcpy(at, text.data(), text.size());
    end(at + text.size());
  }

  // Returns space for up to `bytes` characters, fewer than kBytes. Then call `end` with the position after the last
  // one.
  char* room(std::size_t bytes) {
    if (used_ + bytes > kBytes) {
      flush();
    }
    return text_.data() + used_;
  }
  void end(const char* at) { used_ = static_cast<std::size_t>(at - text_.data()); }

  void flush() {
    folder_.append(file_, std::string_view(text_).substr(0, used_));
    used_ = 0;
  }

 private:
  static constexpr std::size_t kBytes = std::size_t{1} << 20U;

  files::OutputFolder& folder_;
  std::string file_;
  std::string text_;
  std::size_t used_ = 0;
};

// Writes a 32-bit number in little-endian order on every machine.
char* append_float(char* to, float value) {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  for (unsigned i = 0; i < 4; ++i) {
    *to++ = static_cast<char>(bits >> (8 * i));
  }
  return to;
}

struct Statistics {
  std::int64_t count = 0;
  double least = 0;
  double greatest = 0;
  double mean = 0;
  double rms = 0;
};

Statistics statistics(const images::FloatImage& image) {
  Statistics result;
  double sum = 0;
  double squares = 0;
  for (const float entry : image.values) {
    if (std::isnan(entry)) {
      continue;
    }
    const auto value = static_cast<double>(entry);
    result.least = result.count == 0 ? value : std::min(result.least, value);
    result.greatest = result.count == 0 ? value : std::max(result.greatest, value);
    sum += value;
    squares += value * value;
    ++result.count;
  }
  if (result.count > 0) {
    result.mean = sum / static_cast<double>(result.count);
    result.rms = std::sqrt(squares / static_cast<double>(result.count));
  }
  return result;
}

// Rounds to four decimals: tenths of a micrometre.
double rounded(double millimetres) { return selfproj::files::rounded(millimetres, 4); }

nlohmann::ordered_json to_json(const Statistics& s) {
  if (s.count == 0) {
    return nullptr;
  }
  return {{"min", rounded(s.least)}, {"max", rounded(s.greatest)}, {"mean", rounded(s.mean)}, {"rms", rounded(s.rms)}};
}

MapPitch pitch_of(const light_section::Inspection& inspection) {
  return {.row_mm = inspection.frame_spacing_mm(), .column_mm = inspection.column_spacing_mm()};
}

using ValidityCounts = std::array<std::int64_t, kValidityNames.size()>;

ValidityCounts count_validity(const light_section::Inspection& inspection) {
  ValidityCounts counts{};
  for (const std::uint8_t validity : inspection.values().validity) {
    counts.at(validity)++;
  }
  return counts;
}

void write_moments(const light_section::Inspection& inspection, files::OutputFolder& folder) {
  const light_section::Inspection::Values& values = inspection.values();
  Table table(folder, "moments.csv");
  const bool runs = inspection.has_runs();
  table.append(moments_csv_header(runs ? model::Select::strongest : model::Select::all));
  std::size_t at = 0;
  for (std::size_t frame = 1; frame <= inspection.frames(); ++frame) {
    std::array<char, kMaxNumberText> name{};
    const std::string_view frame_text(name.data(),
                                      static_cast<std::size_t>(append_integer(name.data(), frame) - name.data()));
    for (int column = 1; column <= inspection.columns(); ++column, ++at) {
      char* to = table.room(8 * kMaxNumberText);
      to = std::copy(frame_text.begin(), frame_text.end(), to);
      for (const std::uint64_t value : {static_cast<std::uint64_t>(column), std::uint64_t{values.m0[at]},
                                        std::uint64_t{values.m1[at]}, std::uint64_t{values.n[at]}}) {
        *to++ = ',';
        to = append_integer(to, value);
      }
      if (runs) {
        *to++ = ',';
        to = append_integer(to, std::uint64_t{values.runs[at]});
        *to++ = ',';
        to = append_integer(to, std::uint64_t{values.second[at]});
      }
      *to++ = '\n';
      table.end(to);
    }
  }
  table.flush();
}

void write_profile(const light_section::Inspection& inspection, files::OutputFolder& folder) {
  const light_section::Inspection::Values& values = inspection.values();
  Table table(folder, "profile.csv");
  table.append("frame,column,x,y,z,dx,dy,dz\n");
  std::size_t at = 0;
  for (std::size_t frame = 1; frame <= inspection.frames(); ++frame) {
    for (int column = 1; column <= inspection.columns(); ++column, ++at) {
      if (values.validity[at] != static_cast<std::uint8_t>(light_section::Validity::valid)) {
        continue;
      }
      char* to = append_integer(table.room(9 * kMaxNumberText), frame);
      *to++ = ',';
      to = append_integer(to, static_cast<std::uint64_t>(column));
      for (const float value :
           {values.x[at], values.y[at], values.z[at], values.dx[at], values.dy[at], values.dz[at]}) {
        *to++ = ',';
        if (!std::isnan(value)) {  // without a reference there is no difference
          to = append_tenth_micrometres(to, static_cast<double>(value));
        }
      }
      *to++ = '\n';
      table.end(to);
    }
  }
  table.flush();
}

void write_cloud(const light_section::Inspection& inspection, files::OutputFolder& folder, const MapScale& scale) {
  const light_section::Inspection::Values& values = inspection.values();
  const auto points = std::count(values.validity.begin(), values.validity.end(),
                                 static_cast<std::uint8_t>(light_section::Validity::valid));
  Table cloud(folder, "cloud.ply");
  cloud.append(
      fmt::format("ply\nformat binary_little_endian 1.0\n"
                  "comment millimetres; x along the belt and carried back by it, y along the image's columns, z away "
                  "(left-handed); difference positive towards the camera\n"
                  "comment intensity: mean grey value of the line's lit pixels; quality: M0, the light of the line, in "
                  "proportion to which the variance of its place falls\n"
                  "element vertex {}\n"
                  "property float x\nproperty float y\nproperty float z\nproperty float difference\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\n"
                  "property float intensity\nproperty float quality\nend_header\n",
                  points));
  const std::vector<double> belt = inspection.belt_mm();
  std::size_t at = 0;
  for (const double travel : belt) {
    for (int column = 0; column < inspection.columns(); ++column, ++at) {
      if (values.validity[at] != static_cast<std::uint8_t>(light_section::Validity::valid)) {
        continue;
      }
      const double difference = -static_cast<double>(values.dz[at]);
      char* to = append_float(cloud.room(27), static_cast<float>(static_cast<double>(values.x[at]) - travel));
      to = append_float(to, values.y[at]);
      to = append_float(to, values.z[at]);
      to = append_float(to, static_cast<float>(difference));
      const double place = (difference - scale.low) / (scale.high - scale.low);
      const Colour colour = colour_at(scale.map, std::isnan(place) ? 0.5 : place);
      for (const std::uint8_t part : {colour.red, colour.green, colour.blue}) {
        *to++ = static_cast<char>(part);
      }
      const auto light = static_cast<float>(values.m0[at]);
      to = append_float(to, values.n[at] > 0 ? light / static_cast<float>(values.n[at]) : 0.0F);
      cloud.end(append_float(to, light));
    }
  }
  cloud.flush();
}

struct Maps {
  images::FloatImage height, difference;
};

std::string summary(const light_section::Inspection& inspection, const Maps& maps, const ReportParts& parts) {
  const rig::Rig& rig = inspection.rig();
  const light_section::Inspection::Frame& first = inspection.frame(0);
  nlohmann::ordered_json json;
  json["title"] = parts.title;
  json["spec"] = {{"version", fmt::format("{}.{}", spec::kVersion >> 8U, spec::kVersion & 0xFFU)},
                  {"hash", fmt::format("{:08x}", spec::kHash)}};
  json["frames"] = inspection.frames();
  json["frames_not_kept"] = inspection.frames_not_kept();
  json["columns"] = inspection.columns();
  const ValidityCounts counts = count_validity(inspection);
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (i != kOutside || counts[i] > 0) {
      json["column_count"][kValidityNames[i]] = counts[i];
    }
  }
  if (!parts.doubts.empty()) {
    json["doubts"] = parts.doubts;
  }
  json["height_mm"] = to_json(statistics(maps.height));
  json["difference_mm"] = to_json(statistics(maps.difference));
  const MapPitch pitch = pitch_of(inspection);
  json["belt"] = {{"x_from", inspection.encoder_counts() ? "encoder" : "speed"},
                  {"mm", rounded(inspection.belt_mm().back())},
                  {"mm_per_column", rounded(pitch.column_mm)}};
  if (inspection.frames() > 1) {
    json["belt"]["mm_per_frame"] = rounded(pitch.row_mm);
  }
  json["first_sequence"] = first.sequence;
  json["last_sequence"] = inspection.frame(inspection.frames() - 1).sequence;
  json["mode"] = images::mode_name(static_cast<model::Mode>(first.mode));
  json["threshold"] = first.threshold;
  if (first.pixel_bits > spec::kPixelBits) {
    json["pixel_bits"] = first.pixel_bits;
  }
  if (first.measure().select != model::Select::all || first.measure().window != model::RowWindow{}) {
    json["select"] = images::select_name(first.measure().select);
    json["gap"] = first.gap;
    if (first.measure().window != model::RowWindow{}) {
      json["rows"] = {first.window.first, first.window.last};
    }
  }
  json["counters"] = facts_json(parts.counters);
  json["settings"] = facts_json(parts.settings);
  json["rig"] = {{"name", rig.name}, {"yaml", rig::to_yaml(rig)}};
  for (const ReportTable& table : parts.tables) {
    json["tables"].push_back({{"title", table.title}, {"header", table.header}, {"rows", table.rows}});
  }
  return files::json_text(json, 2) + "\n";
}

// The differences in frames of a part, where parts are cut by profile and some passed; otherwise none. The reference is
// a good part, from which the belt between parts differs by a part's whole height: nothing else would be seen on a
// page.
std::optional<images::FloatImage> differences_of_parts(const light_section::Inspection& inspection, const Maps& maps) {
  if (!inspection.rig().parts || inspection.rig().parts->cut != rig::PartCut::profile) {
    return std::nullopt;
  }
  images::FloatImage difference = maps.difference;
  const rig::RigParts& parts = *inspection.rig().parts;
  int frames = 0;
  for (int r = 0; r < difference.rows; ++r) {
    const auto high = std::count_if(maps.height.row(r), maps.height.row(r) + difference.columns,
                                    [&](float value) { return static_cast<double>(value) > parts.above_mm; });
    if (static_cast<double>(high) * inspection.column_spacing_mm() < std::max(parts.min_width_mm, 1e-9)) {
      std::fill_n(difference.row(r), difference.columns, images::kNoValue);
    } else {
      ++frames;
    }
  }
  return frames > 0 ? std::optional(std::move(difference)) : std::nullopt;
}

// What nine tenths of the differences on parts do not exceed, to both sides of 0; 0 where there is none. Without the
// tenth at walls, where a small shift makes a large difference.
double usual_difference(const images::FloatImage& difference, const images::FloatImage& height, double above_mm) {
  std::vector<float> values;
  for (std::size_t i = 0; i < difference.values.size(); ++i) {
    if (!std::isnan(difference.values[i]) && static_cast<double>(height.values[i]) > above_mm) {
      values.push_back(std::abs(difference.values[i]));
    }
  }
  if (values.empty()) {
    return 0;
  }
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(0.9 * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return static_cast<double>(*at);
}

ReportData report_data(const light_section::Inspection& inspection, Maps maps, const ReportParts& parts) {
  const rig::Rig& rig = inspection.rig();
  const light_section::Inspection::Frame& first = inspection.frame(0);
  ReportData data;
  data.title = parts.title;
  data.subtitle = fmt::format("rig {} · {} px · mode {} · threshold {}", rig.name,
                              images::size_text(rig.camera.sent().rows, inspection.columns()),
                              images::mode_name(static_cast<model::Mode>(first.mode)), first.threshold);
  if (const std::string select = images::select_text(first.measure()); !select.empty()) {
    data.subtitle += " · " + select;
  }
  if (const auto& region = rig.camera.region) {
    data.subtitle += fmt::format(" · rig's region: {} rows from row {}, {:.0f} fps", region->rows,
                                 region->row_offset + 1, region->frame_rate_hz);
  }
  std::optional<images::FloatImage> of_parts = differences_of_parts(inspection, maps);
  data.of_parts = of_parts.has_value();
  data.height = std::move(maps.height);
  data.difference = of_parts ? std::move(*of_parts) : std::move(maps.difference);
  data.difference_colours = difference_scale(data.difference, parts.difference_mm);
  data.y = inspection.y();
  data.pitch = pitch_of(inspection);
  data.counters = parts.counters;
  data.settings = parts.settings;
  data.tables = parts.tables;
  data.camera = parts.camera;
  data.doubts = parts.doubts;

  const auto two = [](double value) { return selfproj::files::rounded(value, 2); };
  const ValidityCounts counts = count_validity(inspection);
  const auto all = static_cast<double>(inspection.values().validity.size());
  const Statistics h = statistics(data.height);
  const Statistics d = statistics(data.difference);
  data.highlights = {
      {"frames", "frames", static_cast<std::int64_t>(inspection.frames())},
      {"points", "points", counts[0]},
      {"valid", "of all columns", fmt::format("{:.1f}", 100 * static_cast<double>(counts[0]) / all), "%"}};
  if (counts[0] > 0) {
    data.highlights.push_back(
        {"height", "height", fmt::format("{:.2f} … {:.2f}", two(h.least), two(h.greatest)), "mm"});
  }
  if (d.count > 0) {
    if (data.of_parts) {
      data.highlights.push_back(
          {"difference", "nine tenths of the parts' difference within",
           fmt::format("±{:.3f}", usual_difference(data.difference, data.height, rig.parts->above_mm)), "mm"});
    } else {
      data.highlights.push_back(
          {"difference", "difference", fmt::format("{:+.2f} … {:+.2f}", two(d.least), two(d.greatest)), "mm"});
      data.highlights.push_back({"difference_rms", "difference, RMS", fmt::format("{:.3f}", d.rms), "mm"});
    }
  }
  data.highlights.insert(data.highlights.end(), parts.highlights.begin(), parts.highlights.end());
  for (std::size_t i = 1; i < counts.size(); ++i) {
    if (i != kOutside || counts[i] > 0) {
      data.counters.push_back({kValidityNames[i], kValidityLabels[i], counts[i]});
    }
  }
  if (inspection.frames_not_kept() > 0) {
    data.counters.push_back({"frames_not_kept", "frames not kept for this report",
                             static_cast<std::int64_t>(inspection.frames_not_kept())});
  }
  data.settings.push_back(
      {"belt", "x of the belt from", std::string(inspection.encoder_counts() ? "encoder" : "speed and time stamp")});
  if (inspection.frames() > 1) {
    data.settings.push_back({"mm_per_frame", "way from frame to frame", rounded(data.pitch.row_mm), "mm"});
  }
  data.settings.push_back(
      {"mm_per_column", "way from column to column, on the plane", rounded(data.pitch.column_mm), "mm"});
  data.settings.push_back({"spec", "specification",
                           fmt::format("{}.{}, {:08x}", spec::kVersion >> 8U, spec::kVersion & 0xFFU, spec::kHash)});
  return data;
}

}  // namespace

void write_inspection(const light_section::Inspection& inspection, files::OutputFolder& folder,
                      const ReportParts& parts) {
  if (inspection.frames() == 0) {
    throw UserError(folder.name(), "there is no frame to write");
  }
  write_moments(inspection, folder);
  write_profile(inspection, folder);
  Maps maps{inspection.height(), inspection.difference()};
  const MapScale scale = difference_scale(maps.difference);
  write_cloud(inspection, folder, scale);
  folder.append("height.tiff", images::encode_float_tiff("height.tiff", maps.height));
  folder.append("difference.tiff", images::encode_float_tiff("difference.tiff", maps.difference));
  folder.append("height.png", labelled_map_png(maps.height, height_scale(maps.height), pitch_of(inspection), "height"));
  folder.append("difference.png",
                labelled_map_png(maps.difference, scale, pitch_of(inspection), "difference from the reference"));
  if (parts.camera) {
    folder.append(fmt::format("frame_{}.png", parts.camera->frame), frame_png(*parts.camera));
  }
  folder.append("summary.json", summary(inspection, maps, parts));
  folder.append("report.html", report_html(report_data(inspection, std::move(maps), parts)));
}

}  // namespace selfproj::report
