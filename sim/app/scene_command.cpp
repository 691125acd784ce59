#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <functional>
#include <iterator>
#include <memory>
#include <mutex>
#include <optional>
#include <span>
#include <string>
#include <system_error>
#include <tuple>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/input_file.h"
#include "host/files/output_file.h"
#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/rig.h"
#include "sim/app/commands.h"
#include "sim/cosim/render_options.h"
#include "sim/scene/moved_scene.h"
#include "sim/scene/optics.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/region.h"
#include "sim/scene/renderer.h"
#include "sim/scene/scene.h"
#include "sim/scene/scenes.h"

namespace selfproj::sim {
namespace {

namespace fs = std::filesystem;

constexpr int kDefaultBits = 8;
constexpr int kMaxBits = 12;
constexpr int kMaxDepths = 256;  // 1 MB each
constexpr int kMaxFrames = 100'000;
constexpr const char* kPatternFile = "pattern.tiff";

struct SceneOptions {
  std::string scene;
  std::string height_map;
  Displacement displacement;
  double mm_per_pixel = 0;
  std::string rig;         // empty: the scene's own
  std::string region_of;   // the rig whose region the camera sends; empty: the whole sensor
  bool uncropped = false;  // the whole sensor all the same
  std::vector<std::string> patterns;
  int bits = 0;  // 0: not given
  std::string out;
  std::string truth;
  int first = 1;
  int count = 0;  // 0: to the scene's end
  std::optional<std::int64_t> seed;
  std::optional<std::uint64_t> perturbed_rig_seed;
  std::vector<std::string> without;
  bool falloff = false;
  WorldOptions world;
  int threads = 0;
};

RenderOptions render_options(const SceneOptions& options) {
  RenderOptions result = options_without(options.without);
  result.falloff = options.falloff;
  result.world = options.world.world();
  return result;
}

rig::Rig rig_of(const SceneOptions& options) {
  std::string name = options.rig;
  if (name.empty()) {
    name = options.scene.empty() ? SceneInfo{}.rig() : find_scene(options.scene).rig();
  }
  rig::Rig rig = rig::load_any_rig(name);
  if (rig.light_plane && (!options.patterns.empty() || options.perturbed_rig_seed)) {
    throw UserError("--pattern, --perturbed-rig-seed", "are for a projector, and the rig has a laser");
  }
  rig.imaging.seed = options.seed.value_or(rig.imaging.seed);
  if (options.region_of.empty()) {
    rig.camera.region.reset();
    return rig;
  }
  const rig::RigCamera camera = rig::load_rig(options.region_of).camera;
  if (!camera.region || camera.rows != rig.camera.rows || camera.columns != rig.camera.columns) {
    throw UserError("--region-of " + options.region_of,
                    camera.region ? "has a camera of another size" : "has no region (camera.region)");
  }
  rig.camera.region = camera.region;
  rig.camera.frame_rate_hz = camera.region->frame_rate_hz;  // of all that moves
  if (options.uncropped) {
    rig::RigRegion& sent = *rig.camera.region;
    std::tie(sent.row_offset, sent.rows, sent.column_offset, sent.columns) =
        std::tuple(0, camera.rows, 0, camera.columns);
  }
  return rig;
}

// Light 0..1 from a file: 32-bit TIFF as it is, 8-bit images with 255 for full light.
// The text of the reference that lies beside the pattern of a light section, as `selfproj pattern` writes both; empty
// where there is none.
std::string reference_of_pattern(const SceneOptions& options) {
  if (options.patterns.size() != 1) {
    return "";
  }
  const std::string file = (fs::path(options.patterns.front()).parent_path() / images::kReferenceFile).string();
  std::error_code unused;
  return fs::is_regular_file(file, unused) ? files::read_input(file, files::kMostTableBytes) : "";
}

images::FloatImage read_pattern(const std::string& file, const rig::Rig& rig) {
  images::FloatImage pattern;
  const std::string extension = fs::path(file).extension().string();
  if (extension == ".tiff" || extension == ".tif") {
    pattern = images::read_float_tiff(file);
  } else {
    const images::Image image = images::read_image(file, std::nullopt);
    pattern = images::FloatImage(image.rows, image.columns);
    std::transform(image.pixels.begin(), image.pixels.end(), pattern.values.begin(),
                   [](std::uint8_t value) { return static_cast<float>(value) / 255; });
  }
  check_pattern(pattern, rig.projector, file);
  return pattern;
}

// Without a file, a straight line that the camera sees in the middle of its image of the plane.
images::FloatImage pattern_of(const SceneOptions& options, const rig::Rig& rig) {
  if (options.patterns.empty() && rig.light_plane) {
    return light_section::draw_straight_line(rig, kLaserLine);
  }
  if (options.patterns.empty()) {
    return light_section::draw_straight_line(rig,
                                             Pinhole::of_projector(rig.projector).project({0, 0, rig.plane_z_mm}).row);
  }
  return read_pattern(options.patterns.front(), rig);
}

std::string frame_file(int number, bool quantized) {
  return fmt::format("frame_{:05}.{}", number, quantized ? "png" : "tiff");
}

// The frames of an earlier run would be taken for this one's.
void check_for_other_frames(const std::string& folder, int first, int count, bool quantized) {
  std::error_code error;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder, error)) {
    const std::string name = entry.path().filename().string();
    if (name.rfind("frame_", 0) != 0) {
      continue;
    }
    const int number = std::atoi(name.c_str() + std::strlen("frame_"));
    if (number < first || number >= first + count || name != frame_file(number, quantized)) {
      throw UserError("--out " + folder, "holds frames of another run, such as " + name + "; give another folder");
    }
  }
}

// A file that may lie in the folder of the frames, which then need not exist yet.
bool is_in(const std::string& folder, const std::string& file) {
  const fs::path parent = fs::absolute(file).lexically_normal().parent_path();
  return parent == (fs::absolute(folder) / "").lexically_normal().parent_path();
}

// Makes the frames of a scene and knows the truth about them.
struct FrameMaker {
  std::function<void(int frame, std::span<float> pixels)> render;
  std::function<void(int frame, std::span<float> values)> truth;
  int truth_rows = 1;          // a frame
  images::FloatImage pattern;  // where there is one alone
};

FrameMaker light_section(const SceneOptions& options, const PerturbedRig& actual, const Scene& scene,
                         const RenderOptions& render_with) {
  const rig::Rig& rig = actual.rig;
  if (options.bits > 0) {
    throw UserError("--bits", "goes only with rigs of kind scanner; " + rig.name + " is not one");
  }
  if (options.patterns.size() > 1) {
    throw UserError("--pattern", "a light section takes only one");
  }
  FrameMaker maker;
  maker.pattern = pattern_of(options, rig);
  const auto renderer = std::make_shared<LineRenderer>(actual, scene, maker.pattern, render_with);
  maker.render = [renderer](int frame, std::span<float> pixels) { renderer->render(frame, pixels); };
  maker.truth = [renderer](int frame, std::span<float> heights) { renderer->truth(frame, heights); };
  return maker;
}

FrameMaker whole_patterns(const SceneOptions& options, const PerturbedRig& actual, const Scene& scene,
                          const RenderOptions& render_with) {
  const rig::Rig& rig = actual.rig;
  if (scene.speed() != 0) {
    throw UserError("--rig " + rig.name, "its conveyor moves; a scanner needs a surface that stands still");
  }
  if (options.bits > 0 && !options.patterns.empty()) {
    throw UserError("--bits", "cannot be combined with --pattern");
  }
  const auto light = std::make_shared<std::vector<ProjectedLight>>();
  for (const std::string& file : options.patterns) {
    light->push_back(throw_light(rig, read_pattern(file, rig), render_with));
  }
  if (options.patterns.empty()) {
    for (const images::Image& image : gray_patterns(rig.projector, options.bits > 0 ? options.bits : kDefaultBits)) {
      light->push_back(project_image(rig, image, render_with));
    }
  }
  const auto renderer = std::make_shared<PatternRenderer>(actual, scene, render_with, options.threads);
  FrameMaker maker;
  // The first frame that is rendered shows the first pattern, so that a window of a scene is a whole sequence.
  const int first = options.first - 1;
  maker.render = [renderer, light, first](int frame, std::span<float> pixels) {
    const auto pattern = static_cast<std::size_t>(frame - first) % light->size();
    renderer->render(frame, (*light)[pattern], pixels);
  };
  maker.truth = [renderer](int frame, std::span<float> z) { renderer->depth(frame, z); };
  maker.truth_rows = rig.camera.rows;
  return maker;
}

void render(const SceneOptions& options) {
  files::OutputFolder out(options.out);
  std::optional<files::OutputFile> truth_file;
  const bool truth_inside = !options.truth.empty() && is_in(options.out, options.truth);
  if (!options.truth.empty() && !truth_inside) {
    truth_file.emplace(options.truth);
  }
  const rig::Rig rig = rig_of(options);
  const std::unique_ptr<Scene> as_it_should = options.height_map.empty()
                                                  ? make_scene(options.scene, rig)
                                                  : height_map_scene(images::read_float_tiff(options.height_map),
                                                                     options.mm_per_pixel, rig, options.height_map);
  const std::unique_ptr<Scene> moved =
      options.displacement.any()
          ? std::make_unique<MovedScene>(*as_it_should, options.displacement, "--lift, --aside, --turn")
          : nullptr;
  const Scene* const scene = moved ? moved.get() : as_it_should.get();
  if (options.count == 0 && options.first > scene->frames()) {
    throw UserError(fmt::format("--first {}", options.first),
                    fmt::format("the scene ends after {} frames; give --count to see more", scene->frames()));
  }
  const int count = options.count > 0 ? options.count : scene->frames() + 1 - options.first;
  const RenderOptions render_with = render_options(options);
  PerturbedRig actual = rig_of_seed(rig, options.perturbed_rig_seed);
  expose_as_sent(rig.camera, actual.rig);
  const rig::RigRegion sent = rig.camera.sent();
  const bool quantized = render_with.quantization;
  check_for_other_frames(options.out, options.first, count, quantized);
  const FrameMaker maker = rig.kind == rig::RigKind::scanner ? whole_patterns(options, actual, *scene, render_with)
                                                             : light_section(options, actual, *scene, render_with);
  if (!options.truth.empty() && maker.truth_rows > 1 && count > kMaxDepths) {
    throw UserError("--truth " + options.truth,
                    fmt::format("takes at most {} frames of depth, not {}", kMaxDepths, count));
  }
  if (!maker.pattern.values.empty() && options.patterns.empty()) {
    out.append(kPatternFile, images::encode_float_tiff(kPatternFile, maker.pattern));
  }
  if (const std::string reference = reference_of_pattern(options); !reference.empty()) {
    out.append(images::kReferenceFile, reference);
  }
  images::FloatImage truth(options.truth.empty() ? 0 : count * maker.truth_rows, rig.camera.columns);
  {
    cli::Progress progress("frame", static_cast<std::size_t>(count));
    std::mutex mutex;
    std::size_t done = 0;
    parallel_for(count, options.threads, [&](int i) {
      const int number = options.first + i;
      const std::string file = frame_file(number, quantized);
      std::string bytes;
      images::FloatImage values(rig.camera.rows, rig.camera.columns);
      maker.render(number - 1, values.values);
      if (rig.camera.region) {
        images::FloatImage part(sent.rows, sent.columns);
        crop_as_sent<float>(rig.camera, values.values, part.values);
        values = std::move(part);
      }
      if (quantized && rig.measure.bits() > spec::kPixelBits) {
        images::WideImage image{values.rows, values.columns, std::vector<std::uint16_t>(values.values.size())};
        quantize(rig.measure.bits(), values.values, image.pixels);
        bytes = images::encode_png(image);
      } else if (quantized) {
        images::Image image{values.rows, values.columns, std::vector<std::uint8_t>(values.values.size())};
        quantize(values.values, image.pixels);
        bytes = images::encode_png(image);
      } else {
        bytes = images::encode_float_tiff(file, values);
      }
      if (truth.rows > 0) {
        maker.truth(number - 1, {truth.row(i * maker.truth_rows),
                                 static_cast<std::size_t>(maker.truth_rows) * static_cast<std::size_t>(truth.columns)});
      }
      const std::lock_guard lock(mutex);
      out.append(file, bytes);
      progress.update(++done);
    });
  }
  if (truth_inside) {
    out.append(fs::path(options.truth).filename().string(), images::encode_float_tiff(options.truth, truth));
  }
  out.commit();
  if (truth_file) {
    truth_file->write(images::encode_float_tiff(options.truth, truth));
  }
  fmt::print("{} {} of {} x {}, {}, rig {}, seed {}{} → {}\n", count, count == 1 ? "frame" : "frames", sent.columns,
             sent.rows, options.height_map.empty() ? "scene " + options.scene : "height map " + options.height_map,
             rig.name, rig.imaging.seed,
             (options.without.empty() ? "" : fmt::format(", without {}", fmt::join(options.without, ", "))) +
                 (options.world.disturb.empty() ? "" : fmt::format(", {}", fmt::join(options.world.disturb, ", "))),
             out.name());
}

void list() {
  fmt::print("{:14} {:>6}  {:14} {:10} {}\n", "scene", "frames", "rig", "reference", "what is to be seen");
  for (const SceneInfo& info : scenes()) {
    fmt::print("{:14} {:6}  {:14} {:10} {}\n", info.name, info.frames, info.rig(),
               info.reference.empty() ? "-" : info.reference, info.description);
  }
}

void add_part_options(CLI::App& command, SceneOptions& options) {
  CLI::Option* name = command.add_option("SCENE", options.scene, "A scene of `selfproj-sim scene list`.");
  cli::begin_group(command, "Part and rig");
  CLI::Option* map =
      command.add_option("--height-map", options.height_map,
                         "A part instead of a scene: heights over the plane in mm as 32-bit floats. Rows run "
                         "along the conveyor, the first one first; NaN is bare plane.");
  map->type_name("FILE.tiff")->excludes(name);
  CLI::Option* scale =
      command.add_option("--mm-per-pixel", options.mm_per_pixel, "Side of a pixel of the height map in mm.");
  scale->transform(cli::number_above_zero())->type_name("MM")->needs(map);
  map->needs(scale);
  const auto displace = [&](const char* option, double& value, double most, const char* text, const char* unit) {
    command.add_option(option, value, text)
        ->transform(cli::real_number(-most, most))
        ->type_name(unit)
        ->capture_default_str();
  };
  displace("--lift", options.displacement.lift_mm, 100, "The part lies higher by this much, mm; the belt does not.",
           "MM");
  displace("--aside", options.displacement.aside_mm, 1000,
           "It lies farther in the direction of increasing columns, mm.", "MM");
  displace("--turn", options.displacement.turn_deg, 180, "It is turned about the vertical through its middle, degrees.",
           "DEG");
  command.add_option("--rig", options.rig, "Built-in rig or YAML file.")->type_name("RIG")->default_str("the scene's");
  cli::begin_group(command, "Frames");
  command.add_option("--first", options.first, "First frame, from 1.")
      ->transform(cli::whole_number(1, kMaxFrames))
      ->type_name("N")
      ->capture_default_str();
  command.add_option("--count", options.count, "Number of frames.")
      ->transform(cli::whole_number(1, kMaxFrames))
      ->type_name("N")
      ->default_str("all to the end of the scene");
}

void add_light_options(CLI::App& command, SceneOptions& options) {
  cli::begin_group(command, "Light and camera");
  cli::add_files(
      command, "--pattern", options.patterns,
      "Image of the projector's size that it shows: light 0 to 1 as 32-bit floats (.tiff), or 0 to 255. With a "
      "scanner several, with commas between them: one for each frame, over and over.")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->default_str("a straight line on the plane; Gray codes with a scanner");
  command.add_option("--bits", options.bits, "With a scanner: bits of the Gray codes that are shown.")
      ->transform(cli::whole_number(1, kMaxBits))
      ->type_name("M")
      ->default_str(std::to_string(kDefaultBits));
  add_error_source_option(
      command, "--without", options.without,
      "Sources of error to leave out, with commas between them. Without quantization the frames are 32-bit TIFF.");
  CLI::Option* const region =
      command
          .add_option("--region-of", options.region_of,
                      "Rig whose region (camera.region) the camera sends, with its exposure and frame rate.")
          ->type_name("RIG")
          ->default_str("the whole sensor");
  command
      .add_flag("--uncropped", options.uncropped,
                "The whole sensor all the same, with that exposure and frame rate: for `selfproj-sim board --sensor`.")
      ->needs(region);
  command.add_flag("--falloff", options.falloff, "Light falls with the squared distance from the projector.");
  add_world_options(command, options.world);
  add_perturbed_rig_option(command, options.perturbed_rig_seed);
  add_noise_seed_option(command, options.seed);
  command.add_option("--threads", options.threads, "Threads to use.")
      ->transform(cli::whole_number(1, 1024))
      ->type_name("N")
      ->default_str("one for each core");
}

void add_render(CLI::App& scene) {
  CLI::App* command = cli::add_command(
      scene,
      {.name = "render",
       .purpose = "Renders the camera images of a scene, and the true heights.",
       .details = "The output folder gets frame_00001.png and so on, and pattern.tiff with the straight line "
                  "that is shown without --pattern. "
                  "Frames of another run in the folder are an error. With a scanner the first frame that is rendered "
                  "shows the first pattern, and there is no pattern.tiff. With the --pattern of a reference "
                  "folder (`selfproj pattern`) the folder gets its reference.csv, too, by which `selfproj inspect` "
                  "measures the frames.",
       .examples = R"(
# 4 frames of stairs that pass under the camera, with the true heights.
selfproj-sim scene render stairs --first 700 --count 4 --truth frames/truth.tiff --out frames

# A desk under 8-bit Gray codes, without noise.
selfproj-sim scene render desk --count 16 --without shot-noise,read-noise --out codes

# Stairs of painted metal, seen again in a shiny wall by a camera with defect pixels.
selfproj-sim scene render stairs --first 700 --count 2 --disturb gloss,defect-pixels --out shiny
)"});
  const auto options = std::make_shared<SceneOptions>();
  add_part_options(*command, *options);
  add_light_options(*command, *options);
  cli::begin_group(*command, "Output");
  command
      ->add_option(
          "--truth", options->truth,
          fmt::format("True heights in mm where the light falls, one row for each frame, NaN where unseen. With a "
                      "scanner: z in mm of what each pixel sees, frame below frame, up to {} frames.",
                      kMaxDepths))
      ->type_name("FILE.tiff");
  command->add_option("--out", options->out, "Folder for the frames.")->type_name("DIR")->required();
  command->callback([options] {
    if (options->scene.empty() && options->height_map.empty()) {
      throw UserError("SCENE", "name a scene, or give --height-map; `selfproj-sim scene list` lists the scenes");
    }
    render(*options);
  });
}

}  // namespace

void add_scene_command(CLI::App& app) {
  CLI::App* command = cli::add_command(app, {.name = "scene",
                                             .purpose = "Lists and renders the scenes under the simulated camera.",
                                             .details = {},
                                             .examples = R"(
# What scenes there are.
selfproj-sim scene list
)"});
  command->require_subcommand(1);
  cli::add_command(*command,
                   {.name = "list",
                    .purpose = "Lists the built-in scenes.",
                    .details = "A line shows the scene, its number of frames, its rig, its good part or background, "
                               "and what is to be seen.",
                    .examples = R"(
# What scenes there are.
selfproj-sim scene list
)"})
      ->callback(list);
  add_render(*command);
}

}  // namespace selfproj::sim
