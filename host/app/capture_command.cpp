#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/capture_run.h"
#include "host/app/commands.h"
#include "host/app/preview_files.h"
#include "host/camera/open_camera.h"
#include "host/capture/newest_image.h"
#include "host/capture/projector.h"
#include "host/capture/sequence_capture.h"
#include "host/cli/command_line.h"
#include "host/files/output_folder.h"
#include "host/files/stop_signal.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "host/production/page_server.h"
#include "selfproj/files/user_error.h"

namespace selfproj::app {
namespace {

struct SequenceOptions {
  CaptureOptions capture;
  std::string patterns;
  std::string preview;  // where the page is
  std::string out;
};

// Shows white on the projector, and serves a page with the camera's newest image and figures of its exposure. Ends at
// Esc or Ctrl-C. The camera runs free.
void run_preview(const CaptureOptions& options, const std::string& endpoint_text) {
  constexpr std::chrono::milliseconds kLook(20);
  const production::Endpoint endpoint = production::endpoint_of_text("--preview", endpoint_text);
  camera::CameraUri uri = camera::parse_camera_uri(options.camera);
  uri.camera.trigger = uri.camera.trigger.empty() ? "free" : uri.camera.trigger;
  const std::unique_ptr<camera::Camera> camera = camera::open_camera(uri);
  const files::StopSignal stop;
  capture::Projector projector(options.display.display, greys_of(options.display));
  capture::NewestImage newest;
  const std::string token = production::page_token(endpoint);
  production::PageServer server(
      "--preview", endpoint, token,
      {production::PageServer::fixed("/", "text/html; charset=utf-8", kPreviewHtml),
       production::PageServer::fixed("/preview.css", "text/css; charset=utf-8", kPreviewCss),
       production::PageServer::fixed("/preview.js", "text/javascript; charset=utf-8", kPreviewJs),
       {"/image.png", "image/png", [&newest](std::uint64_t& asked) { return newest.png(asked); }},
       {"/figures", "application/json", [&newest](std::uint64_t& asked) { return newest.figures(asked); }}});
  projector.show(std::uint8_t{UINT8_MAX});
  camera->start();
  fmt::print("{} at {}; Esc or Ctrl-C ends it\n", camera->uri(), production::page_url(endpoint, token));
  static_cast<void>(std::fflush(stdout));
  while (!files::StopSignal::came() && !projector.stopped()) {
    camera::CameraImage image;
    if (camera->next(image, kLook) && image.complete) {
      newest.put(image, camera->counters(), camera->uri());
      server.wake();
    }
  }
  camera->stop();
}

void run_sequence(const SequenceOptions& options) {
  if (!options.preview.empty()) {
    if (!options.patterns.empty() || !options.out.empty()) {
      throw UserError("--preview", "captures nothing; leave out --patterns and --out");
    }
    run_preview(options.capture, options.preview);
    return;
  }
  if (options.patterns.empty() || options.out.empty()) {
    throw UserError(options.patterns.empty() ? "--patterns" : "--out", "is required");
  }
  files::OutputFolder out(options.out);
  const images::ImageSequence patterns(images::files_of_folder(options.patterns), std::nullopt);
  std::vector<std::string> images;  // as PNG; written at the end, so that a capture that fails leaves nothing
  const capture::CaptureRecord record = run_capture(
      options.capture, options.out,
      [&](const capture::CaptureSizes& /*sizes*/) { return images::ImageSequence(patterns); },
      [&](std::size_t /*i*/, std::size_t /*count*/, const images::Image& image) {
        images.push_back(images::encode_png(image));
      });
  for (std::size_t i = 0; i < images.size(); ++i) {
    out.append(record.shots[i].image, images[i]);
  }
  out.append("capture.json", capture::capture_json(record));
  out.commit();
  fmt::print("{} images → {}; {}\n", images.size(), out.name(), retaken_text(record));
}

}  // namespace

void add_capture_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "capture",
       .purpose = "Shows patterns on a projector and takes an image of each.",
       .details =
           "First the projector shows black and white. From these two images the command says which shares of the "
           "pixels are saturated and dark, and how the exposure should change. Then it flashes, and measures how long "
           "after showing a pattern an image shows it, and how much this spreads. It waits so long before each "
           "image.\n\n"
           "The camera's software trigger is used where it has one; otherwise it runs free, and images that came too "
           "early are passed over. There is never a second trigger under way. An image of which parts were lost, or "
           "that did not come, is taken again and counted. Where a pattern of black and white is followed by its "
           "negative, the two images must add up to white; if they do not, because one shows another pattern or two at "
           "once, both are taken again after a longer wait. Automatic exposure and gain are switched off, and come "
           "back "
           "at the end.\n\n"
           "The folder gets image_0001.png and so on, in the order of the patterns, and capture.json. `selfproj "
           "depth`, "
           "`selfproj match` and `selfproj calibrate` take it as it is. Esc and Ctrl-C end the capture; nothing is "
           "written then, and the exit status is 1.",
       .examples = R"(
# Set up: what the camera sees, in a browser at http://127.0.0.1:8080/ (needs hardware)
selfproj capture --camera camera:192.168.1.20 --display 1 --preview 8080

# Gray codes of a projector of 1280 x 800 pixels, seen by a GigE camera (needs hardware)
selfproj pattern gray --projector 1280x800 --out gray
selfproj capture --camera "camera:192.168.1.20?exposure-us=20000" --display 1 --patterns gray \
  --out seen
)"});
  const auto options = std::make_shared<SequenceOptions>();
  cli::begin_group(*command, "Input");
  add_camera_option(*command, options->capture);
  command
      ->add_option("--patterns", options->patterns,
                   "Folder of the patterns, in natural order. Required without --preview.")
      ->type_name("DIR");
  command
      ->add_option("--preview", options->preview,
                   "Capture nothing: show white, and the camera's image in a browser at this port of this machine, or "
                   "at ADDRESS:PORT, which then needs the token that is printed.")
      ->type_name("PORT");
  add_projector_options(*command, options->capture);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the images. Required without --preview.")->type_name("DIR");
  command->callback([options] { run_sequence(*options); });
}

}  // namespace selfproj::app
