#include "host/app/preview_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <mutex>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>

#include "host/app/preview_files.h"
#include "host/camera/open_camera.h"
#include "host/driver/clock.h"
#include "host/io/image_files.h"
#include "host/io/stop_signal.h"
#include "host/projector/projector.h"
#include "host/web/page_server.h"

namespace selfproj {
namespace {

constexpr int kMostSide = 1280;  // of the image on the page, in pixels

// The newest image, from the thread that takes it to those of the server.
class Newest {
 public:
  void put(const CameraImage& image, const CameraCounters& counters, const std::string& camera) {
    auto picture = std::make_shared<Image>();
    picture->rows = image.view.rows;
    picture->columns = image.view.columns;
    for (int row = 0; row < image.view.rows; ++row) {
      const std::uint8_t* pixels = image.view.pixels + static_cast<std::ptrdiff_t>(row) * image.view.stride;
      picture->pixels.insert(picture->pixels.end(), pixels, pixels + image.view.columns);
    }
    const std::lock_guard lock(mutex_);
    picture_ = std::move(picture);
    counters_ = counters;
    camera_ = camera;
    const double seconds = static_cast<double>(image.arrival_ns - last_ns_) * 1e-9;
    rate_ = last_ns_ > 0 && seconds > 0 ? 0.9 * rate_ + 0.1 / seconds : 0;
    last_ns_ = image.arrival_ns;
  }

  // The image as PNG, each n-th pixel where it is large.
  PageServer::Text png() {
    const auto [picture, unused] = both();
    const int every = std::max(1, (std::max(picture->rows, picture->columns) + kMostSide - 1) / kMostSide);
    Image shown{(picture->rows + every - 1) / every, (picture->columns + every - 1) / every, {}};
    for (int row = 0; row < picture->rows; row += every) {
      for (int column = 0; column < picture->columns; column += every) {
        shown.pixels.push_back(
            picture->pixels[static_cast<std::size_t>(row) * static_cast<std::size_t>(picture->columns) +
                            static_cast<std::size_t>(column)]);
      }
    }
    return std::make_shared<const std::string>(encode_png(shown));
  }

  PageServer::Text figures() {
    const auto [picture, text] = both();
    return std::make_shared<const std::string>(text);
  }

 private:
  std::pair<std::shared_ptr<const Image>, std::string> both() {
    const std::lock_guard lock(mutex_);
    const auto share = [&](auto&& counts) {
      const auto count = std::count_if(picture_->pixels.begin(), picture_->pixels.end(), counts);
      const double pixels = static_cast<double>(std::max<std::size_t>(1, picture_->pixels.size()));
      return fmt::format("{:.1f} %", 100 * static_cast<double>(count) / pixels);
    };
    const nlohmann::ordered_json json = {
        {"camera", camera_},
        {"pixels", fmt::format("{} x {}", picture_->columns, picture_->rows)},
        {"images a second", fmt::format("{:.1f}", rate_)},
        {"saturated (255)", share([](std::uint8_t pixel) { return pixel == UINT8_MAX; })},
        {"bright (200 or more)", share([](std::uint8_t pixel) { return pixel >= 200; })},
        {"dark (below 20)", share([](std::uint8_t pixel) { return pixel < 20; })},
        {"incomplete images", fmt::format("{}", counters_.incomplete)},
        {"dropped images", fmt::format("{}", counters_.dropped)}};
    return {picture_, json.dump()};
  }

  std::mutex mutex_;
  std::shared_ptr<const Image> picture_ = std::make_shared<Image>(Image{1, 1, {0}});
  CameraCounters counters_;
  std::string camera_;
  double rate_ = 0;
  std::int64_t last_ns_ = 0;
};

}  // namespace

void run_preview(const CaptureOptions& options, const std::string& endpoint_text) {
  constexpr std::chrono::milliseconds kLook(20);
  const Endpoint endpoint = endpoint_of_text("--preview", endpoint_text);
  CameraUri uri = parse_camera_uri(options.camera);
  uri.camera.trigger = uri.camera.trigger.empty() ? "free" : uri.camera.trigger;
  const std::unique_ptr<Camera> camera = open_camera(uri);
  const StopSignal stop;
  Projector projector(options.display.display, greys_of(options.display));
  Newest newest;
  const std::string token = page_token(endpoint);
  const PageServer server("--preview", endpoint, token,
                          {PageServer::fixed("/", "text/html; charset=utf-8", kPreviewHtml),
                           PageServer::fixed("/preview.css", "text/css; charset=utf-8", kPreviewCss),
                           PageServer::fixed("/preview.js", "text/javascript; charset=utf-8", kPreviewJs),
                           {"/image.png", "image/png", [&newest] { return newest.png(); }},
                           {"/figures", "application/json", [&newest] { return newest.figures(); }}});
  projector.show(std::uint8_t{UINT8_MAX});
  camera->start();
  fmt::print("{} at {}; Esc or Ctrl-C ends it\n", camera->uri(), page_url(endpoint, token));
  static_cast<void>(std::fflush(stdout));
  while (!StopSignal::came() && !projector.stopped()) {
    CameraImage image;
    if (camera->next(image, kLook) && image.complete) {
      newest.put(image, camera->counters(), camera->uri());
    }
  }
  camera->stop();
}

}  // namespace selfproj
