#include "host/inspect/inspection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <span>
#include <stdexcept>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/inspect/colour_map.h"
#include "host/inspect/frame_picture.h"
#include "host/inspect/number_text.h"
#include "host/io/frame_options.h"
#include "host/io/user_error.h"
#include "model/spec/generated/selfproj_spec.h"

namespace selfproj {
namespace {

constexpr std::array<const char*, 7> kValidityNames = {"valid",   "unlit",        "too_few",     "too_wide",
                                                       "cut_off", "no_reference", "out_of_range"};
constexpr std::array<const char*, 7> kValidityLabels = {"points",
                                                        "columns without light",
                                                        "columns with too few lit pixels",
                                                        "columns with too many lit pixels",
                                                        "columns whose line the image's border cuts off",
                                                        "columns without a reference",
                                                        "columns out of range"};

// Text that goes to a file of the folder a megabyte at a time.
class Table {
 public:
  Table(OutputFolder& folder, std::string file) : folder_(folder), file_(std::move(file)), text_(kBytes, '\0') {}

  void append(std::string_view text) {
    char* at = room(text.size());
    std::memcpy(at, text.data(), text.size());
    end(at + text.size());
  }

  // A place for up to `bytes` characters, less than kBytes; `end` tells where they ended.
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

  OutputFolder& folder_;
  std::string file_;
  std::string text_;
  std::size_t used_ = 0;
};

// A 32-bit number, little endian, on every machine.
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

Statistics statistics(const FloatImage& image) {
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

// With four digits after the point: tenths of a micrometre.
double rounded(double millimetres) { return std::round(millimetres * 1e4) / 1e4; }

nlohmann::ordered_json to_json(const Statistics& s) {
  if (s.count == 0) {
    return nullptr;
  }
  return {{"min", rounded(s.least)}, {"max", rounded(s.greatest)}, {"mean", rounded(s.mean)}, {"rms", rounded(s.rms)}};
}

nlohmann::ordered_json to_json(const std::vector<Fact>& facts) {
  nlohmann::ordered_json result = nlohmann::ordered_json::object();
  for (const Fact& fact : facts) {
    std::visit([&](const auto& value) { result[fact.key] = value; }, fact.value);
  }
  return result;
}

}  // namespace

Inspection::Inspection(const Rig& rig, int columns, const InspectionOptions& options)
    : rig_(rig), columns_(columns), options_(options) {
  if (columns <= 0) {
    throw std::invalid_argument("an inspection needs columns");
  }
  const std::size_t frames = std::min(options.expected_frames, options.max_frames);
  frames_.reserve(frames);
  const std::size_t size = frames * static_cast<std::size_t>(columns);
  for (auto* values : {&m0_, &m1_, &n_}) {
    values->reserve(size);
  }
  for (auto* values : {&x_, &y_, &z_, &dx_, &dy_, &dz_}) {
    values->reserve(size);
  }
  validity_.reserve(size);
}

bool Inspection::begin_frame(const PacketHeader& header) {
  if (header.columns != columns_) {
    throw std::invalid_argument("a frame of another width");
  }
  if (frames_.size() >= options_.max_frames) {
    ++not_kept_;
    return false;
  }
  frames_.push_back({header.sequence, header.time_stamp, header.encoder, header.mode, header.threshold});
  return true;
}

void Inspection::add_profile(const ProfileView& profile) {
  const auto append = [this](auto& to, const auto* values) { to.insert(to.end(), values, values + columns_); };
  append(x_, profile.x);
  append(y_, profile.y);
  append(z_, profile.z);
  append(dx_, profile.dx);
  append(dy_, profile.dy);
  append(dz_, profile.dz);
  append(validity_, profile.validity);
}

void Inspection::add(const PacketHeader& header, const MomentsView& moments, const ProfileView& profile) {
  if (!begin_frame(header)) {
    return;
  }
  m0_.insert(m0_.end(), moments.m0, moments.m0 + columns_);
  m1_.insert(m1_.end(), moments.m1, moments.m1 + columns_);
  n_.insert(n_.end(), moments.n, moments.n + columns_);
  add_profile(profile);
}

void Inspection::add(const PacketHeader& header, std::span<const std::uint8_t> payload, const ProfileView& profile) {
  const auto mode = static_cast<Mode>(header.mode);
  if (payload.size() != moments_payload_bytes(mode, columns_)) {
    throw std::invalid_argument("a payload of another width");
  }
  if (!begin_frame(header)) {
    return;
  }
  const std::size_t begin = m0_.size();
  for (auto* values : {&m0_, &m1_, &n_}) {
    values->resize(begin + static_cast<std::size_t>(columns_));
  }
  unpack_moments(mode, columns_, payload.data(), {m0_.data() + begin, m1_.data() + begin, n_.data() + begin});
  add_profile(profile);
}

bool Inspection::encoder_counts() const {
  return std::any_of(frames_.begin(), frames_.end(),
                     [this](const Frame& frame) { return frame.encoder != frames_.front().encoder; });
}

std::vector<double> Inspection::belt_mm() const {
  const bool by_encoder = encoder_counts();
  std::vector<double> belt;
  belt.reserve(frames_.size());
  double position = 0;
  double step = rig_.conveyor.speed_mm_per_s / rig_.camera.frame_rate_hz;
  for (std::size_t i = 0; i < frames_.size(); ++i) {
    const bool restarted = i > 0 && frames_[i].time_stamp < frames_[i - 1].time_stamp;
    if (i > 0 && !restarted) {
      // Differences modulo 2^32 and 2^64, so that counters may wrap.
      step = by_encoder ? static_cast<std::int32_t>(frames_[i].encoder - frames_[i - 1].encoder) *
                              rig_.conveyor.encoder_mm_per_count
                        : static_cast<double>(frames_[i].time_stamp - frames_[i - 1].time_stamp) /
                              options_.pixel_clock_hz * rig_.conveyor.speed_mm_per_s;
    }
    position += i > 0 ? step : 0;
    belt.push_back(position);
  }
  return belt;
}

MapPitch Inspection::pitch() const {
  MapPitch result;
  result.column_mm = rig_.plane_z_mm * rig_.camera.pixel_pitch_mm / rig_.camera.focal_length_mm;
  if (frames_.size() > 1) {
    result.row_mm = std::abs(belt_mm().back()) / static_cast<double>(frames_.size() - 1);
  } else {
    result.row_mm = rig_.conveyor.speed_mm_per_s / rig_.camera.frame_rate_hz;
  }
  return result;
}

FloatImage Inspection::map(const std::vector<float>& values, double offset, double factor) const {
  FloatImage image(static_cast<int>(frames_.size()), columns_, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (validity_[i] == static_cast<std::uint8_t>(Validity::valid)) {
      image.values[i] = static_cast<float>(offset + factor * static_cast<double>(values[i]));
    }
  }
  return image;
}

FloatImage Inspection::height() const { return map(z_, rig_.plane_z_mm, -1); }

FloatImage Inspection::difference() const { return map(dz_, 0, -1); }

FloatImage Inspection::x() const { return map(x_, 0, 1); }

FloatImage Inspection::y() const { return map(y_, 0, 1); }

FloatImage Inspection::centroid() const {
  FloatImage image(static_cast<int>(frames_.size()), columns_, std::numeric_limits<float>::quiet_NaN());
  for (std::size_t i = 0; i < m0_.size(); ++i) {
    if (m0_[i] > 0 && validity_[i] == static_cast<std::uint8_t>(Validity::valid)) {
      image.values[i] = static_cast<float>(static_cast<double>(m1_[i]) / m0_[i]);  // (3.2)
    }
  }
  return image;
}

void Inspection::write_moments(OutputFolder& folder) const {
  Table table(folder, "moments.csv");
  table.append("frame,column,m0,m1,n\n");
  std::size_t at = 0;
  for (std::size_t frame = 1; frame <= frames_.size(); ++frame) {
    std::array<char, kMaxNumberText> name{};
    const std::string_view frame_text(name.data(),
                                      static_cast<std::size_t>(append_integer(name.data(), frame) - name.data()));
    for (int column = 1; column <= columns_; ++column, ++at) {
      char* to = table.room(6 * kMaxNumberText);
      to = std::copy(frame_text.begin(), frame_text.end(), to);
      for (const std::uint64_t value : {static_cast<std::uint64_t>(column), std::uint64_t{m0_[at]},
                                        std::uint64_t{m1_[at]}, std::uint64_t{n_[at]}}) {
        *to++ = ',';
        to = append_integer(to, value);
      }
      *to++ = '\n';
      table.end(to);
    }
  }
  table.flush();
}

void Inspection::write_profile(OutputFolder& folder) const {
  Table table(folder, "profile.csv");
  table.append("frame,column,x,y,z,dx,dy,dz\n");
  std::size_t at = 0;
  for (std::size_t frame = 1; frame <= frames_.size(); ++frame) {
    for (int column = 1; column <= columns_; ++column, ++at) {
      if (validity_[at] != static_cast<std::uint8_t>(Validity::valid)) {
        continue;
      }
      char* to = append_integer(table.room(9 * kMaxNumberText), frame);
      *to++ = ',';
      to = append_integer(to, static_cast<std::uint64_t>(column));
      for (const float value : {x_[at], y_[at], z_[at], dx_[at], dy_[at], dz_[at]}) {
        *to++ = ',';
        to = append_tenth_micrometres(to, static_cast<double>(value));
      }
      *to++ = '\n';
      table.end(to);
    }
  }
  table.flush();
}

void Inspection::write_cloud(OutputFolder& folder, const MapScale& scale) const {
  const auto points = std::count(validity_.begin(), validity_.end(), static_cast<std::uint8_t>(Validity::valid));
  Table cloud(folder, "cloud.ply");
  cloud.append(
      fmt::format("ply\nformat binary_little_endian 1.0\n"
                  "comment millimetres; x carried back by the belt; difference positive towards the camera\n"
                  "element vertex {}\n"
                  "property float x\nproperty float y\nproperty float z\nproperty float difference\n"
                  "property uchar red\nproperty uchar green\nproperty uchar blue\nend_header\n",
                  points));
  const std::vector<double> belt = belt_mm();
  std::size_t at = 0;
  for (const double way : belt) {
    for (int column = 0; column < columns_; ++column, ++at) {
      if (validity_[at] != static_cast<std::uint8_t>(Validity::valid)) {
        continue;
      }
      const double difference = -static_cast<double>(dz_[at]);
      char* to = append_float(cloud.room(19), static_cast<float>(static_cast<double>(x_[at]) - way));
      to = append_float(to, y_[at]);
      to = append_float(to, z_[at]);
      to = append_float(to, static_cast<float>(difference));
      const Colour colour = colour_at(scale.map, (difference - scale.low) / (scale.high - scale.low));
      for (const std::uint8_t part : {colour.red, colour.green, colour.blue}) {
        *to++ = static_cast<char>(part);
      }
      cloud.end(to);
    }
  }
  cloud.flush();
}

std::string Inspection::summary(const ReportParts& parts) const {
  nlohmann::ordered_json json;
  json["title"] = parts.title;
  json["spec"] = {{"version", fmt::format("{}.{}", spec::kVersion >> 8U, spec::kVersion & 0xFFU)},
                  {"hash", fmt::format("{:08x}", spec::kHash)}};
  json["frames"] = frames_.size();
  json["frames_not_kept"] = not_kept_;
  json["columns"] = columns_;
  std::array<std::int64_t, kValidityNames.size()> counts{};
  for (const std::uint8_t validity : validity_) {
    counts.at(validity)++;
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    json["column_count"][kValidityNames[i]] = counts[i];
  }
  json["height_mm"] = to_json(statistics(height()));
  json["difference_mm"] = to_json(statistics(difference()));
  const MapPitch way = pitch();
  json["belt"] = {{"x_from", encoder_counts() ? "encoder" : "speed"},
                  {"mm", rounded(belt_mm().back())},
                  {"mm_per_frame", rounded(way.row_mm)},
                  {"mm_per_column", rounded(way.column_mm)}};
  json["first_sequence"] = frames_.front().sequence;
  json["last_sequence"] = frames_.back().sequence;
  json["mode"] = mode_name(static_cast<Mode>(frames_.front().mode));
  json["threshold"] = frames_.front().threshold;
  json["counters"] = to_json(parts.counters);
  json["settings"] = to_json(parts.settings);
  json["rig"] = {{"name", rig_.name}, {"yaml", to_yaml(rig_)}};
  for (const ReportTable& table : parts.tables) {
    json["tables"].push_back({{"title", table.title}, {"header", table.header}, {"rows", table.rows}});
  }
  return json.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

ReportData Inspection::report_data(const ReportParts& parts) const {
  ReportData data;
  data.title = parts.title;
  data.subtitle = fmt::format("rig {} · {} × {} px · mode {} · threshold {}", rig_.name, rig_.camera.rows, columns_,
                              mode_name(static_cast<Mode>(frames_.front().mode)), frames_.front().threshold);
  data.height = height();
  data.difference = difference();
  data.y = y();
  data.pitch = pitch();
  data.counters = parts.counters;
  data.settings = parts.settings;
  data.tables = parts.tables;
  data.camera = parts.camera;

  std::array<std::int64_t, kValidityNames.size()> counts{};
  for (const std::uint8_t validity : validity_) {
    counts.at(validity)++;
  }
  const auto all = static_cast<double>(validity_.size());
  const Statistics h = statistics(data.height);
  const Statistics d = statistics(data.difference);
  data.highlights = {
      {"frames", "frames", static_cast<std::int64_t>(frames_.size())},
      {"points", "points", counts[0]},
      {"valid", "of all columns", fmt::format("{:.1f}", 100 * static_cast<double>(counts[0]) / all), "%"}};
  if (counts[0] > 0) {
    data.highlights.push_back({"height", "height", fmt::format("{:.2f} … {:.2f}", h.least, h.greatest), "mm"});
    data.highlights.push_back(
        {"difference", "difference", fmt::format("{:+.2f} … {:+.2f}", d.least, d.greatest), "mm"});
    data.highlights.push_back({"difference_rms", "difference, RMS", fmt::format("{:.3f}", d.rms), "mm"});
  }
  for (std::size_t i = 1; i < counts.size(); ++i) {
    data.counters.push_back({kValidityNames[i], kValidityLabels[i], counts[i]});
  }
  if (not_kept_ > 0) {
    data.counters.push_back(
        {"frames_not_kept", "frames not kept for this report", static_cast<std::int64_t>(not_kept_)});
  }
  data.settings.push_back(
      {"belt", "x of the belt from", std::string(encoder_counts() ? "encoder" : "speed and time stamp")});
  data.settings.push_back({"mm_per_frame", "way from frame to frame", rounded(data.pitch.row_mm), "mm"});
  data.settings.push_back(
      {"mm_per_column", "way from column to column, on the plane", rounded(data.pitch.column_mm), "mm"});
  data.settings.push_back({"spec", "specification",
                           fmt::format("{}.{}, {:08x}", spec::kVersion >> 8U, spec::kVersion & 0xFFU, spec::kHash)});
  return data;
}

void Inspection::write(OutputFolder& folder, const ReportParts& parts) const {
  if (frames_.empty()) {
    throw UserError(folder.name(), "there is no frame to write");
  }
  write_moments(folder);
  write_profile(folder);
  const FloatImage heights = height();
  const FloatImage differences = difference();
  const MapScale scale = difference_scale(differences);
  write_cloud(folder, scale);
  folder.append("height.tiff", encode_float_tiff("height.tiff", heights));
  folder.append("difference.tiff", encode_float_tiff("difference.tiff", differences));
  folder.append("height.png", labelled_map_png(heights, height_scale(heights), pitch(), "height"));
  folder.append("difference.png", labelled_map_png(differences, scale, pitch(), "difference from the reference"));
  if (parts.camera) {
    folder.append(fmt::format("frame_{}.png", parts.camera->frame), frame_png(*parts.camera));
  }
  folder.append("summary.json", summary(parts));
  folder.append("report.html", report_html(report_data(parts)));
}

}  // namespace selfproj
