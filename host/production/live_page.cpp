#include "host/production/live_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/driver/clock.h"
#include "host/files/input_file.h"
#include "host/files/json_text.h"
#include "host/production/live_files.h"
#include "host/production/page_server.h"
#include "host/report/facts.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"

namespace selfproj::production {
namespace {

constexpr std::int64_t kSecondNs = 1'000'000'000;
constexpr int kRowsPerSecond = 100;   // of the waterfall
constexpr std::size_t kMaxRows = 64;  // in one message
constexpr int kMaxPixels = 640;       // along each side of a camera image, as the page shows it
constexpr int kMaxCells = 256;        // along each side of a map, as the page shows it

void append_number(std::string& text, std::size_t number) {
  for (unsigned shift = 0; shift < 32; shift += 8) {
    text += static_cast<char>(number >> shift & 0xFFU);
  }
}

// Production PCs are little endian, and so is every browser's.
void append_floats(std::string& text, const float* values, std::size_t count) {
  text.append(reinterpret_cast<const char*>(values), count * sizeof(float));
}

std::string message_of(const std::string& json, const std::string& floats) {
  // The floats begin at a multiple of four bytes.
  const std::string padding((4 - json.size() % 4) % 4, ' ');
  std::string bytes;
  bytes.reserve(8 + json.size() + padding.size() + floats.size());
  append_number(bytes, json.size() + padding.size());
  append_number(bytes, floats.size());
  return bytes + json + padding + floats;
}

// Every n-th cell of a map, so that the page draws no more than it can show.
images::FloatImage thinned(const images::FloatImage& map, int every) {
  images::FloatImage result((map.rows + every - 1) / every, (map.columns + every - 1) / every);
  for (int r = 0; r < result.rows; ++r) {
    for (int c = 0; c < result.columns; ++c) {
      result.row(r)[c] = map.row(r * every)[c * every];
    }
  }
  return result;
}

int every_cell(int rows, int columns) { return std::max(1, (std::max(rows, columns) + kMaxCells - 1) / kMaxCells); }

// three.js of this machine; nothing where it is not installed, and the page says that there is no 3-D view.
std::string three_js() {
  try {
    return files::read_input(SELFPROJ_THREE_JS, std::size_t{1} << 24U);
  } catch (const UserError&) {
    return {};
  }
}

std::vector<PageServer::File> files_of_page(std::function<PageServer::Text(std::uint64_t&)> part,
                                            std::function<PageServer::Text(std::uint64_t&)> camera) {
  constexpr const char* kScript = "text/javascript; charset=utf-8";
  return {PageServer::fixed("/", "text/html; charset=utf-8", kLiveHtml),
          PageServer::fixed("/live.js", kScript, kLiveJs),
          PageServer::fixed("/live.css", "text/css; charset=utf-8", kLiveCss),
          PageServer::fixed("/three.js", kScript, three_js()),
          {"/part", "application/octet-stream", std::move(part)},
          {"/camera", "application/octet-stream", std::move(camera)}};
}

}  // namespace

// The server's view of the page.
class LivePage::Server : public PageServer {
 public:
  Server(LivePage& page, const Endpoint& endpoint, const std::string& token)
      : PageServer("--live", endpoint, token,
                   files_of_page([&page](std::uint64_t&) { return page.last_part(); },
                                 [&page](std::uint64_t&) { return page.last_image(); }),
                   Stream{.path = "/stream",
                          .next = [&page](std::uint64_t& number) { return page.next_message(number); },
                          .begin = [&page] { ++page.watchers_; },
                          .finish = [&page] { --page.watchers_; }}) {}
};

LivePage::LivePage(const Endpoint& endpoint, const rig::Rig& rig, const std::string& title)
    : endpoint_(endpoint),
      columns_(rig.camera.columns),
      plane_z_(rig.plane_z_mm),
      title_(title),
      token_(page_token(endpoint)) {
  rows_.reserve(kMaxRows * static_cast<std::size_t>(columns_));
  part_ = std::make_shared<const std::string>(message_of("{\"part\": 0}", ""));
  camera_ = std::make_shared<const std::string>(message_of("{\"rows\": 0}", ""));
  server_ = std::make_unique<Server>(*this, endpoint, token_);
}

LivePage::~LivePage() = default;

std::string LivePage::url() const { return page_url(endpoint_, token_); }

std::shared_ptr<const std::string> LivePage::next_message(std::uint64_t& number) {
  if (const std::unique_ptr<Message> newer = new_message_.take()) {
    message_ = *newer;
  }
  if (message_.number <= number) {
    return nullptr;
  }
  dropped_ += number > 0 ? message_.number - number - 1 : 0;
  number = message_.number;
  return message_.bytes;
}

std::shared_ptr<const std::string> LivePage::last_part() {
  if (std::unique_ptr<const std::string> newer = new_part_.take()) {
    part_ = std::move(newer);
  }
  return part_;
}

std::shared_ptr<const std::string> LivePage::last_image() {
  if (std::unique_ptr<const std::string> newer = new_camera_.take()) {
    camera_ = std::move(newer);
  }
  return camera_;
}

void LivePage::camera(const model::PacketHeader& header, const model::ImageView& image, const std::vector<float>& line,
                      const ExposureFigures& exposure) {
  const int every = std::max(1, (std::max(image.rows, image.columns) + kMaxPixels - 1) / kMaxPixels);
  const int rows = (image.rows + every - 1) / every;
  const int columns = (image.columns + every - 1) / every;
  std::string bytes;
  for (std::size_t c = 0; c < line.size(); c += static_cast<std::size_t>(every)) {
    append_floats(bytes, &line[c], 1);
  }
  for (int r = 0; r < rows; ++r) {
    const std::uint8_t* const row = image.pixels + static_cast<std::ptrdiff_t>(r) * every * image.stride;
    for (int c = 0; c < columns; ++c) {
      bytes += static_cast<char>(row[c * every]);
    }
  }
  const nlohmann::ordered_json json = {{"frame", header.sequence},
                                       {"rows", rows},
                                       {"columns", columns},
                                       {"every", every},
                                       {"line", line.empty() ? 0 : columns},
                                       {"saturated", exposure.saturated},
                                       {"dark", exposure.dark},
                                       {"bright_grey", exposure.bright_grey},
                                       {"good", exposure.good},
                                       {"advice", exposure.advice}};
  new_camera_.put(std::make_unique<const std::string>(message_of(files::json_text(json), bytes)));
  ++camera_images_;
}

void LivePage::add_row(const light_section::ProfileView& profile) {
  if (rows_.size() >= kMaxRows * static_cast<std::size_t>(columns_)) {
    return;
  }
  for (int i = 0; i < columns_; ++i) {
    rows_.push_back(-profile.dz[i]);
  }
}

void LivePage::measured(MeasuredFrame& measured) {
  if (watchers_ == 0) {
    return;
  }
  if (measured.depth.values.empty()) {
    profile(measured.profile.view());
  } else {
    depth(measured.difference);
  }
}

void LivePage::profile(const light_section::ProfileView& profile) {
  const std::int64_t now = driver::now_ns();
  if (now >= next_row_ns_) {
    next_row_ns_ = std::max(now, next_row_ns_ + kSecondNs / kRowsPerSecond);
    add_row(profile);
  }
  if (!message_is_due()) {
    return;
  }
  std::string floats;
  append_floats(floats, profile.y, static_cast<std::size_t>(columns_));
  std::vector<float> heights(static_cast<std::size_t>(columns_));
  std::vector<float> differences(static_cast<std::size_t>(columns_));
  for (int i = 0; i < columns_; ++i) {
    heights[static_cast<std::size_t>(i)] = static_cast<float>(plane_z_ - static_cast<double>(profile.z[i]));
    differences[static_cast<std::size_t>(i)] = -profile.dz[i];
  }
  append_floats(floats, heights.data(), heights.size());
  append_floats(floats, differences.data(), differences.size());
  append_floats(floats, rows_.data(), rows_.size());
  send("profiles", static_cast<int>(rows_.size()) / columns_, columns_, floats);
  rows_.clear();
}

void LivePage::depth(const images::FloatImage& difference) {
  if (!message_is_due()) {
    return;
  }
  const images::FloatImage shown = thinned(difference, every_cell(difference.rows, difference.columns));
  std::string floats;
  append_floats(floats, shown.values.data(), shown.values.size());
  send("depth", shown.rows, shown.columns, floats);
}

bool LivePage::message_is_due() {
  const std::int64_t now = driver::now_ns();
  if (now < next_message_ns_) {
    return false;
  }
  next_message_ns_ = std::max(now, next_message_ns_ + kSecondNs / kPerSecond);
  return true;
}

void LivePage::send(const std::string& kind, int rows, int columns, const std::string& floats) {
  if (std::unique_ptr<std::string> newer = new_figures_.take()) {
    figures_ = std::move(*newer);
  }
  std::string parts;
  for (const std::string& part : parts_) {
    parts += (parts.empty() ? "" : ",") + part;
  }
  ++messages_;
  const std::string json =
      fmt::format(R"({{"message":{},"kind":"{}","dropped":{},"title":{},"columns":{},"rows":{},"camera":{},)"
                  R"("figures":{},"parts":[{}],"statistics":{}}})",
                  messages_, kind, dropped_.load(), files::json_text(nlohmann::json(title_)), columns, rows,
                  camera_images_.load(), figures_, parts, statistics_);
  new_message_.put(std::make_unique<Message>(
      Message{.number = messages_, .bytes = std::make_shared<const std::string>(message_of(json, floats))}));
  server_->wake();
}

void LivePage::part(const PartResult& result, const PlacedMaps& maps, const PartStatistics& statistics) {
  const int every = every_cell(maps.grid.rows, maps.grid.columns);
  const images::FloatImage height = thinned(maps.height, every);
  const images::FloatImage difference = thinned(maps.difference, every);
  nlohmann::ordered_json json = part_json(result);
  const std::string text = files::json_text(json);
  json["rows"] = height.rows;
  json["columns"] = height.columns;
  json["pitch_mm"] = maps.grid.pitch_mm * every;
  json["along_mm"] = maps.grid.along_mm;
  json["across_mm"] = maps.grid.across_mm;
  std::string floats;
  append_floats(floats, height.values.data(), height.values.size());
  append_floats(floats, difference.values.data(), difference.values.size());
  new_part_.put(std::make_unique<const std::string>(message_of(files::json_text(json), floats)));
  parts_.push_front(text);
  if (parts_.size() > kPartsShown) {
    parts_.pop_back();
  }
  statistics_ = files::json_text(statistics_json(statistics));
}

void LivePage::report(const std::vector<report::Fact>& figures) {
  new_figures_.put(std::make_unique<std::string>(files::json_text(report::facts_json(figures))));
}

}  // namespace selfproj::production
