#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/stop_signal.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "selfproj/files/user_error.h"
#include "sim/app/commands.h"

#ifdef SELFPROJ_HAS_GIGE
#include <algorithm>
#include <cstddef>
#include <cstdint>

#include "sim/board/gige_camera.h"
#endif

namespace selfproj::sim {
namespace {

struct NetworkCameraOptions {
  std::vector<std::string> images;
  images::PixelOptions pixels;
  std::string interface = "lo";
  double rate = 25;
  double seconds = 0;  // 0: until Ctrl-C
};

#ifdef SELFPROJ_HAS_GIGE

// Copies the upper left part of the image, and makes dark what it does not have.
void draw(const images::Image& image, const Picture& picture) {
  for (int row = 0; row < picture.rows; ++row) {
    std::uint8_t* const to = picture.pixels + static_cast<std::ptrdiff_t>(row) * picture.columns;
    const int copied = row < image.rows ? std::min(image.columns, picture.columns) : 0;
    std::copy_n(image.view().pixels + static_cast<std::ptrdiff_t>(copied > 0 ? row : 0) * image.columns, copied, to);
    std::fill_n(to + copied, picture.columns - copied, std::uint8_t{0});
  }
}

void run_camera(const NetworkCameraOptions& options) {
  images::ImageSequence sequence(images::image_arguments(options.images), options.pixels.rule());
  std::vector<images::Image> images;
  {
    cli::Progress progress("image", sequence.count());
    for (std::size_t i = 0; i < sequence.count(); ++i) {
      images.push_back(sequence.read(i));
      progress.update(i + 1);
    }
  }
  const files::StopSignal stop;
  cli::StatusLine status;
  std::uint64_t sent = 0;
  {
    const GigeCamera camera(
        [&](const Picture& picture) {
          draw(images[static_cast<std::size_t>(picture.number % images.size())], picture);
        },
        0, 1000 / options.rate, options.interface);
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(options.seconds);
    while (!files::StopSignal::came() && (options.seconds == 0 || std::chrono::steady_clock::now() < end)) {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      status.show(fmt::format("{} images", camera.drawn()));
    }
    sent = camera.drawn();
  }
  status.show("");
  fmt::print("{} images sent\n", sent);
}

#else

void run_camera(const NetworkCameraOptions& /*options*/) {
  throw UserError("camera", "this program was built without Aravis, and knows no GigE cameras");
}

#endif

}  // namespace

void add_camera_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "camera",
       .purpose = "Is a GigE Vision camera that sends recorded images.",
       .details = "The camera answers in a network of this machine, as one of a maker would: `selfproj devices` lists "
                  "it, and every command takes it as camera:ADDRESS, on the loopback camera:127.0.0.1. It sends the "
                  "images one after another, over and over, while somebody takes them. A network can have one such "
                  "camera.",
       .examples = R"(
# The camera of a simulated line, which sends 100 images a second for half a minute.
selfproj-sim production --belt clock --rate 100 --parts 3 --images --out camera-line
selfproj-sim camera camera-line/run --rate 100 --seconds 15 &
sleep 5
selfproj inspect --rig camera-line/rig.yaml --reference camera-line/part \
  --device camera:127.0.0.1 --count 240 --out seen
wait
)"});
  const auto options = std::make_shared<NetworkCameraOptions>();
  cli::add_files(*command, "IMAGE", options->images, "Images of one size, or a folder of them.")->required();
  cli::add_pixel_options(*command, options->pixels);
  command->add_option("--interface", options->interface, "Network in which it answers.")
      ->type_name("NAME")
      ->capture_default_str();
  command->add_option("--rate", options->rate, "Images a second, unless the program that takes them sets another rate.")
      ->transform(cli::real_number(0.1, 10000))
      ->type_name("FPS")
      ->capture_default_str();
  command->add_option("--seconds", options->seconds, "Ends after so many seconds.")
      ->transform(cli::real_number(0, 1e9))
      ->type_name("S")
      ->default_str("at Ctrl-C");
  command->callback([options] { run_camera(*options); });
}

}  // namespace selfproj::sim
