#include "sim/app/capture_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/io/command_line.h"
#include "host/io/frame_options.h"
#include "host/io/image_files.h"
#include "host/io/output_folder.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "host/rig/rig.h"
#include "sim/scene/chessboard.h"
#include "sim/scene/pattern_set.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scene_list.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj {
namespace {

struct CaptureOptions {
  std::string scene;
  std::string rig;
  std::string patterns;
  std::string chessboard;
  double square_mm = 0;
  int poses = 8;
  double tilt_deg = 30;
  std::optional<std::int64_t> seed;
  bool without_noise = false;
  int threads = 0;
  std::string out;
};

void run_capture(const CaptureOptions& options) {
  constexpr int kMostCorners = 200;
  if (options.scene.empty() == options.chessboard.empty()) {
    throw UserError("--scene, --chessboard", "give one of them, not both");
  }
  if (!options.chessboard.empty() && !(options.square_mm > 0)) {
    throw UserError("--square", "is required with --chessboard");
  }
  OutputFolder out(options.out);
  if (!options.chessboard.empty() && std::filesystem::exists(options.out)) {
    throw UserError(options.out, "exists already; poses need a new folder");
  }
  Rig rig = load_rig(options.rig);
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  const std::vector<std::string> files = files_of_folder(options.patterns);
  std::vector<ProjectedLight> patterns;
  patterns.reserve(files.size());
  for (const std::string& file : files) {
    patterns.push_back(project_image(rig, read_image(file, Channel::grey), {}, file));
  }
  std::optional<Progress> progress;
  std::size_t done = 0;
  CaptureSettings settings;
  settings.render.shot_noise = settings.render.read_noise = !options.without_noise;
  settings.threads = options.threads;
  settings.done = [&] { progress->update(++done); };
  if (options.chessboard.empty()) {
    const std::unique_ptr<Scene> scene = make_scene(options.scene, rig);
    if (scene->speed() != 0) {
      throw UserError(options.scene, "moves on this rig's conveyor; capture only scenes that stand still");
    }
    progress.emplace("image", files.size());
    capture_scene(rig, *scene, patterns, settings, out);
  } else {
    const FrameSize corners = size_of_text("--chessboard", options.chessboard, kMostCorners);
    const ChessboardShape shape{corners.columns, corners.rows, options.square_mm};
    const std::vector<ChessboardPlace> places = chessboard_places(rig, shape, options.poses, options.tilt_deg);
    progress.emplace("image", files.size() * places.size());
    capture_chessboard(rig, shape, places, patterns, settings, out);
  }
  progress.reset();
  out.commit();
  fmt::print("{} images of {}, {}, rig {}, seed {} → {}\n", done, size_text(rig.camera.rows, rig.camera.columns),
             options.chessboard.empty()
                 ? "scene " + options.scene
                 : fmt::format("chessboard of {} corners in {} poses", options.chessboard, options.poses),
             rig.name, rig.imaging.seed, out.name());
}

}  // namespace

void add_capture_command(CLI::App& app) {
  CLI::App* command = add_command(
      app, {.name = "capture",
            .purpose = "Captures a scene or a chessboard under each pattern of a folder, with a simulated camera.",
            .details = "A scene (--scene) gives image_00.png and so on. A chessboard (--chessboard) gives "
                       "pose_01/image_00.png and so on, and truth.json with the true camera, projector and poses.",
            .examples = R"(
# Capture a scene under the patterns of its projector.
selfproj pattern gray --rig scanner --out patterns
selfproj-sim capture --rig scanner --scene desk --patterns patterns --out desk

# Capture a chessboard in 2 poses, as `selfproj calibrate` takes it.
selfproj-sim capture --rig scanner --patterns patterns --chessboard 9x7 --square 21 --poses 2 \
  --out captures
)"});
  const auto options = std::make_shared<CaptureOptions>();
  begin_group(*command, "Rig and patterns");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")->type_name("RIG")->required();
  command
      ->add_option("--patterns", options->patterns,
                   "Folder of images of the projector's size, such as `selfproj pattern gray` writes.")
      ->type_name("DIR")
      ->required();
  begin_group(*command, "What is captured (one of --scene and --chessboard is required)");
  command->add_option("--scene", options->scene, "A scene that stands still, of `selfproj-sim scene list`.")
      ->type_name("NAME");
  command->add_option("--chessboard", options->chessboard, "Inner corners along the two sides of a chessboard.")
      ->type_name("NxM");
  command->add_option("--square", options->square_mm, "Side of a square in mm. Required with --chessboard.")
      ->transform(number_above_zero())
      ->type_name("MM");
  command->add_option("--poses", options->poses, "Number of poses of the chessboard.")
      ->transform(whole_number(1, 99))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--tilt", options->tilt_deg, "Angle in degrees by which it leans in all poses but the first.")
      ->transform(real_number(0, 60))
      ->type_name("DEG")
      ->capture_default_str();
  begin_group(*command, "Simulation");
  command->add_option("--seed", options->seed, "Seed of the noise.")
      ->transform(whole_number(0))
      ->type_name("N")
      ->default_str("the rig's");
  command->add_flag("--without-noise", options->without_noise, "Leave out shot noise and read noise.");
  command->add_option("--threads", options->threads, "Threads to use.")
      ->transform(whole_number(1, 1024))
      ->type_name("N")
      ->default_str("one for each core");
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the images. With --chessboard it must be new.")
      ->type_name("DIR")
      ->required();
  command->callback([options] { run_capture(*options); });
}

}  // namespace selfproj
