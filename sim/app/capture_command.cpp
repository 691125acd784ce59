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
  std::string board;
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
  if (options.scene.empty() == options.board.empty()) {
    throw UserError("--scene, --board", "one of them is needed, and not both");
  }
  if (!options.board.empty() && !(options.square_mm > 0)) {
    throw UserError("--square", "is needed with --board");
  }
  OutputFolder out(options.out);
  if (!options.board.empty() && std::filesystem::exists(options.out)) {
    throw UserError(options.out, "is there already; poses need a new folder");
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
  if (options.board.empty()) {
    const std::unique_ptr<Scene> scene = make_scene(options.scene, rig);
    if (scene->speed() != 0) {
      throw UserError(options.scene, "moves on this rig's conveyor; patterns are captured of what stands still");
    }
    progress.emplace("image", files.size());
    capture_scene(rig, *scene, patterns, settings, out);
  } else {
    const FrameSize corners = size_of_text("--board", options.board, kMostCorners);
    const ChessboardShape shape{corners.columns, corners.rows, options.square_mm};
    const std::vector<ChessboardPlace> places = chessboard_places(rig, shape, options.poses, options.tilt_deg);
    progress.emplace("image", files.size() * places.size());
    capture_chessboard(rig, shape, places, patterns, settings, out);
  }
  progress.reset();
  out.commit();
  fmt::print("{} images of {}, {}, rig {}, seed {} → {}\n", done, size_text(rig.camera.rows, rig.camera.columns),
             options.board.empty() ? "scene " + options.scene
                                   : fmt::format("board of {} corners in {} poses", options.board, options.poses),
             rig.name, rig.imaging.seed, out.name());
}

}  // namespace

void add_capture_command(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "capture", "The camera's images under each pattern of a folder: of a scene, or of a chessboard in several poses");
  const auto options = std::make_shared<CaptureOptions>();
  command->add_option("--rig", options->rig, "A built-in rig or a YAML file")->required();
  command->add_option("--patterns", options->patterns, "Folder of images of the projector's size, as of `pattern gray`")
      ->type_name("DIR")
      ->required();
  command->add_option("--scene", options->scene, "A scene that stands still: image_00.png ...")->type_name("SCENE");
  command
      ->add_option(
          "--board", options->board,
          "Instead, a chessboard of so many inner corners along columns and rows: pose_01/image_00.png ... and "
          "truth.json")
      ->type_name("NxM");
  command->add_option("--square", options->square_mm, "Side of its squares")
      ->check(CLI::PositiveNumber)
      ->type_name("MM");
  command->add_option("--poses", options->poses, "Number of its poses")
      ->check(CLI::Range(1, 99))
      ->capture_default_str();
  command->add_option("--tilt", options->tilt_deg, "How far it leans in all poses but the first")
      ->check(CLI::Range(0.0, 60.0))
      ->type_name("DEG")
      ->capture_default_str();
  command->add_option("--seed", options->seed, "Of the noise, instead of the rig's");
  command->add_flag("--without-noise", options->without_noise, "No shot noise and no read noise");
  command->add_option("--threads", options->threads, "Threads; default: one a core")
      ->check(CLI::Range(1, 1024))
      ->type_name("N");
  command->add_option("--out", options->out, "Folder for the images; of a board, a new one")
      ->type_name("DIR")
      ->required();
  command->callback([options] { run_capture(*options); });
}

}  // namespace selfproj
