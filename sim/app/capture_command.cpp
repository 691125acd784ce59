#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/app/commands.h"
#include "sim/cosim/render_options.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"
#include "sim/scene/targets.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::sim {
namespace {

struct CaptureOptions {
  std::string scene;
  std::string rig;
  std::string patterns;
  std::string chessboard;
  double square_mm = 0;
  int poses = 8;
  double tilt_deg = 30;
  PlateVisits visits{{}, {0}};
  double fence_mm = 0.05;
  std::optional<double> plate_mm;
  std::vector<double> steps_mm;
  double tread_mm = 35;
  double shift_mm = 0;
  bool stopped = false;
  std::optional<std::uint64_t> target_seed;
  double print_scale = 1e-4;
  double bend_mm = 0.2;
  TargetTolerance tolerance{0.005, 0.01};
  std::optional<std::int64_t> seed;
  std::optional<std::uint64_t> perturbed_rig_seed;
  bool without_noise = false;
  WorldOptions world;
  int threads = 0;
  std::string out;
};

void check(const CaptureOptions& options) {
  const int given = static_cast<int>(!options.scene.empty()) + static_cast<int>(!options.chessboard.empty()) +
                    static_cast<int>(options.plate_mm.has_value()) + static_cast<int>(!options.steps_mm.empty());
  if (given != 1) {
    throw UserError("--scene, --chessboard, --plate, --steps", "give one of them");
  }
  if (!options.chessboard.empty() && !(options.square_mm > 0)) {
    throw UserError("--square", "is required with --chessboard");
  }
}

// Where the chessboard is, pose by pose.
std::vector<ChessboardPlace> places_of(const CaptureOptions& options, const PerturbedRig& actual,
                                       const ChessboardShape& shape) {
  if (options.visits.heights_mm.empty()) {
    return chessboard_places(actual, shape, options.poses, options.tilt_deg);
  }
  const TargetTolerance& tolerance = options.tolerance;
  const PlateFlaws flaws =
      options.target_seed ? PlateFlaws{tolerance.height_mm, tolerance.flatness_mm, options.fence_mm} : PlateFlaws{};
  return places_on_plates(actual, shape, options.visits, flaws, options.target_seed.value_or(0));
}

// What stands still under the patterns, unless it is a chessboard.
std::unique_ptr<Scene> scene_of(const CaptureOptions& options, const rig::Rig& rig) {
  const TargetTolerance tolerance = options.target_seed ? options.tolerance : TargetTolerance{};
  if (options.plate_mm) {
    return std::make_unique<FlatPlate>(*options.plate_mm, tolerance, options.target_seed.value_or(0));
  }
  if (!options.steps_mm.empty()) {
    return std::make_unique<StepBlock>(options.steps_mm, options.tread_mm, options.shift_mm, tolerance,
                                       options.target_seed.value_or(0));
  }
  std::unique_ptr<Scene> scene = make_scene(options.scene, rig);
  if (scene->speed() != 0) {
    throw UserError(options.scene, "moves on this rig's conveyor; stop it with --stopped");
  }
  return scene;
}

std::string what_of(const CaptureOptions& options) {
  if (options.plate_mm) {
    return fmt::format("flat plate at {:g} mm", *options.plate_mm);
  }
  if (!options.steps_mm.empty()) {
    return fmt::format("steps of {:g} mm", fmt::join(options.steps_mm, ", "));
  }
  const std::size_t poses = options.visits.heights_mm.empty()
                                ? static_cast<std::size_t>(options.poses)
                                : options.visits.heights_mm.size() * options.visits.belt_mm.size();
  return options.scene.empty() ? fmt::format("chessboard of {} corners in {} poses", options.chessboard, poses)
                               : "scene " + options.scene;
}

void run_capture(const CaptureOptions& options) {
  constexpr int kMaxCorners = 200;
  files::OutputFolder out(options.out);
  if (!options.chessboard.empty() && std::filesystem::exists(options.out)) {
    throw UserError(options.out, "exists already; poses need a new folder");
  }
  rig::Rig rig = rig::load_any_rig(options.rig);
  if (!options.chessboard.empty()) {
    rig::need_eight_bits(rig, options.rig, "--chessboard");
  }
  const bool laser = rig.light_plane.has_value();
  if (laser != options.patterns.empty()) {
    throw UserError("--patterns", laser ? "is for a projector, and the rig has a laser" : "is required");
  }
  if (laser && options.perturbed_rig_seed) {
    throw UserError("--perturbed-rig-seed", "is for a projector, and the rig has a laser");
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  if (options.stopped) {
    rig.conveyor.speed_mm_per_s = 0;
  }
  const bool on_belt = options.chessboard.empty() || !options.visits.heights_mm.empty();
  if (laser && !on_belt) {  // the board is held before the camera, about as far away as the line on the belt
    rig.plane_z_mm = PerturbedRig(rig).camera.depth({0, 0, rig.plane_z_mm});
    rig.belt_pose.reset();
  }
  const PerturbedRig actual = rig_of_seed(rig, options.perturbed_rig_seed);
  std::vector<ProjectedLight> patterns;
  CaptureSettings settings;
  settings.render.world = options.world.world();
  if (laser) {
    patterns.push_back(laser_light(actual, settings.render));
  } else {
    for (const std::string& file : images::files_of_folder(options.patterns)) {
      patterns.push_back(project_image(rig, images::read_image(file, images::Channel::grey), settings.render, file));
    }
  }
  std::optional<cli::Progress> progress;
  std::size_t done = 0;
  settings.render.shot_noise = settings.render.read_noise = !options.without_noise;
  settings.threads = options.threads;
  settings.done = [&] { progress->update(++done); };
  if (options.chessboard.empty()) {
    const std::unique_ptr<Scene> scene = scene_of(options, rig);
    progress.emplace("image", patterns.size());
    capture_scene(actual, *scene, patterns, settings, out);
  } else {
    const images::FrameSize corners = images::size_of_text("--chessboard", options.chessboard, kMaxCorners);
    const ChessboardShape shape{corners.columns, corners.rows, options.square_mm};
    const std::vector<ChessboardPlace> places = places_of(options, actual, shape);
    const ChessboardFlaws flaws = options.target_seed
                                      ? drawn_flaws(options.print_scale, options.bend_mm, *options.target_seed)
                                      : ChessboardFlaws{};
    if (laser) {
      progress.emplace("pose", places.size());
      capture_chessboard_and_laser(actual, shape, flaws, places, settings, out);
      done *= 2;
    } else {
      progress.emplace("image", patterns.size() * places.size());
      capture_chessboard(actual, shape, flaws, places, patterns, settings, out);
    }
  }
  progress.reset();
  out.commit();
  fmt::print("{} images of {}, {}, rig {}{}, seed {} → {}\n", done,
             images::size_text(rig.camera.rows, rig.camera.columns), what_of(options), rig.name,
             options.perturbed_rig_seed ? fmt::format(" (perturbed rig {})", *options.perturbed_rig_seed) : "",
             rig.imaging.seed, out.name());
}

// Which options go with what is captured.
constexpr const char* kScene = "--scene";
constexpr const char* kBoard = "--chessboard";
constexpr const char* kPlate = "--plate";
constexpr const char* kSteps = "--steps";

std::string case_of(const CaptureOptions& options) {
  return !options.scene.empty() ? kScene : !options.chessboard.empty() ? kBoard : options.plate_mm ? kPlate : kSteps;
}

void add_target_options(CLI::App& command, OptionFamilies& families, CaptureOptions& options) {
  families.begin("Scene (--scene)", {kScene});
  command.add_flag("--stopped", options.stopped, "Stop the belt, with the middle of the scene's part at x = 0.");
  families.begin("Steps (--steps)", {kSteps});
  command.add_option("--tread", options.tread_mm, "Width of a tread in mm, across the belt.")
      ->transform(cli::number_above_zero())
      ->type_name("MM")
      ->capture_default_str();
  command.add_option("--shift", options.shift_mm, "Place of the block's middle across the belt in mm.")
      ->transform(cli::real_number(-1e4, 1e4))
      ->type_name("MM")
      ->capture_default_str();
  families.begin("Chessboard (--chessboard)", {kBoard});
  command.add_option("--square", options.square_mm, "Side of a square in mm. Required with --chessboard.")
      ->transform(cli::number_above_zero())
      ->type_name("MM");
  command.add_option("--poses", options.poses, "Number of poses of the chessboard.")
      ->transform(cli::whole_number(1, 99))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--tilt", options.tilt_deg, "Angle in degrees by which it leans in all poses but the first.")
      ->transform(cli::real_number(0, 60))
      ->type_name("DEG")
      ->capture_default_str();
  command
      .add_option("--heights", options.visits.heights_mm,
                  "Heights in mm over the belt of a plate that carries it, instead of --poses.")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(cli::real_number(-1e4, 1e4))
      ->type_name("MM,...");
  command
      .add_option("--moves", options.visits.belt_mm,
                  "Places of the belt in mm. The belt takes the plate to all of them at each height.")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(cli::real_number(-1e4, 1e4))
      ->type_name("MM,...")
      ->default_str("0");
  command.add_option("--print-scale", options.print_scale, "Relative error of its squares, to either side.")
      ->transform(cli::real_number(0, 0.1))
      ->type_name("SHARE")
      ->capture_default_str();
  command.add_option("--bend", options.bend_mm, "How far it bends out of its plane, mm to either side.")
      ->transform(cli::real_number(0, 100))
      ->type_name("MM")
      ->capture_default_str();
  command
      .add_option("--fence", options.fence_mm,
                  "With --heights: how far the plate misses its place on the belt, to either side, in mm.")
      ->transform(cli::real_number(0, 10))
      ->type_name("MM")
      ->capture_default_str();
  families.begin("Flaws of chessboard and plate", {kBoard, kPlate});
  command
      .add_option(
          "--flatness", options.tolerance.flatness_mm,
          "Plate: mm from the lowest point of its surface to the highest. --heights: mm by which one end of the "
          "chessboard is higher than the other, to either side.")
      ->transform(cli::real_number(0, 10))
      ->type_name("MM")
      ->capture_default_str();
  families.begin("Flaws of chessboard, plate and steps", {kBoard, kPlate, kSteps});
  command
      .add_option("--target-seed", options.target_seed,
                  "Seed of the target's flaws, each drawn within the tolerances that go with it.")
      ->transform(cli::whole_number(0))
      ->type_name("N")
      ->default_str("no flaws");
  command
      .add_option("--height-tolerance", options.tolerance.height_mm,
                  "Plate, steps, --heights: error of a height, mm to either side.")
      ->transform(cli::real_number(0, 10))
      ->type_name("MM")
      ->capture_default_str();
}

}  // namespace

void add_capture_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app, {.name = "capture",
            .purpose = "Captures a scene or a target under each pattern of a folder, with a simulated camera.",
            .details = "A chessboard (--chessboard) gives pose_01/image_00.png and so on, and truth.json with the true "
                       "camera, projector and poses; everything else gives image_00.png and so on. With a laser a "
                       "chessboard gives boards/pose_01.png in room light and lines/pose_01.png with the laser's line.",
            .examples = R"(
# Capture a scene under the patterns of its projector.
selfproj pattern gray --rig scanner --out patterns
selfproj-sim capture --rig scanner --scene desk --patterns patterns --out desk

# Capture a chessboard in 2 poses, as `selfproj calibrate` takes it.
selfproj-sim capture --rig scanner --patterns patterns --chessboard 9x7 --square 21 --poses 2 \
  --out captures

# The same at 3 heights over the belt, moved by 6 mm at each, as --plates and --moves take it.
selfproj pattern gray --rig light-section --out gray
selfproj-sim capture --rig light-section --patterns gray --chessboard 21x3 --square 2.2 \
  --heights 0,20,40 --moves 0,6 --out plates

# A sweep of lines over a plate 10 mm above the belt, seen by a rig that nobody knows.
selfproj pattern --sweep --every 32 --out lines
selfproj-sim capture --rig light-section --perturbed-rig-seed 7 --plate 10 --target-seed 1 \
  --patterns lines --out plate
)"});
  const auto options = std::make_shared<CaptureOptions>();
  cli::begin_group(*command, "Rig and patterns");
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")->type_name("RIG")->required();
  command
      ->add_option("--patterns", options->patterns,
                   "Folder of images of the projector's size, such as `selfproj pattern gray` writes. Required unless "
                   "the rig has a laser, whose line is what is shown.")
      ->type_name("DIR");
  cli::begin_group(*command, "What is captured (one of --scene, --chessboard, --plate and --steps is required)");
  command->add_option("--scene", options->scene, "A scene that stands still, of `selfproj-sim scene list`.")
      ->type_name("NAME");
  command->add_option("--chessboard", options->chessboard, "Inner corners along the two sides of a chessboard.")
      ->type_name("NxM");
  command->add_option("--plate", options->plate_mm, "A flat plate, this many mm over the belt.")
      ->transform(cli::real_number(-1e4, 1e4))
      ->type_name("MM");
  command
      ->add_option("--steps", options->steps_mm, "A block of treads side by side, with commas between their heights.")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->transform(cli::real_number(-1e4, 1e4))
      ->type_name("MM,...");
  OptionFamilies families(*command);
  add_target_options(*command, families, *options);
  cli::begin_group(*command, "Simulation");
  add_perturbed_rig_option(*command, options->perturbed_rig_seed);
  add_noise_seed_option(*command, options->seed);
  command->add_flag("--without-noise", options->without_noise, "Leave out shot noise and read noise.");
  add_world_options(*command, options->world);
  command->add_option("--threads", options->threads, "Threads to use.")
      ->transform(cli::whole_number(1, 1024))
      ->type_name("N")
      ->default_str("one for each core");
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the images. With --chessboard it must be new.")
      ->type_name("DIR")
      ->required();
  command->callback([options, families] {
    check(*options);
    families.check(case_of(*options), case_of(*options));
    run_capture(*options);
  });
}

}  // namespace selfproj::sim
