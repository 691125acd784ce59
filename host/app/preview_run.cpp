#include "host/app/preview_run.h"

#include <fmt/format.h>

#include <chrono>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <string>

#include "host/app/preview_files.h"
#include "host/camera/open_camera.h"
#include "host/capture/newest_image.h"
#include "host/capture/projector.h"
#include "host/files/stop_signal.h"
#include "host/production/page_server.h"

namespace selfproj {

void run_preview(const CaptureOptions& options, const std::string& endpoint_text) {
  constexpr std::chrono::milliseconds kLook(20);
  const Endpoint endpoint = endpoint_of_text("--preview", endpoint_text);
  CameraUri uri = parse_camera_uri(options.camera);
  uri.camera.trigger = uri.camera.trigger.empty() ? "free" : uri.camera.trigger;
  const std::unique_ptr<Camera> camera = open_camera(uri);
  const StopSignal stop;
  Projector projector(options.display.display, greys_of(options.display));
  NewestImage newest;
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
