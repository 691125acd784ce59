#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/light_section/pattern.h"
#include "host/structured_light/self_reference.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"
#include "sim/app/commands.h"
#include "sim/board/packet_recording.h"
#include "sim/cosim/light_section.h"
#include "sim/scene/optics.h"
#include "sim/scene/parallel.h"
#include "sim/scene/pattern_renderer.h"
#include "sim/scene/perturbed_rig.h"
#include "sim/scene/planted_part.h"
#include "sim/scene/projected_light.h"
#include "sim/scene/random.h"
#include "sim/scene/region.h"
#include "sim/scene/renderer.h"
#include "sim/scene/targets.h"
#include "sim/scene/virtual_capture.h"

namespace selfproj::sim {
namespace {

constexpr double kStep = 0.25;  // of the belt, mm a frame
// Bare belt before and behind a part, mm. Each part is rendered alone, and where the line falls on bare belt the camera
// sees it up to 13 mm nearer to the next part: that one must be in the image by then.
constexpr double kBefore = 14;
constexpr double kBehind = 2;
constexpr double kEnlarged = 5;   // parts of a scanner, whose view is larger, against those of a light section
constexpr double kFromEdges = 2;  // defects keep so far from edges and walls, mm, so that each of them is inspected
constexpr double kMinSize = 2.5, kMaxSize = 5;
constexpr double kMinDepth = 0.4, kMaxDepth = 1;

struct ProductionOptions {
  std::string rig = "light-section";
  int good = 8;
  int parts = 9;
  int bad_every = 3;
  double rate = 1000;
  std::string belt = "encoder";
  bool images = false;
  std::int64_t seed = 1;
  std::string out;
};

// A part of the line: how it lies, and its defect, if it has one.
struct LinePart {
  PartPose pose;
  std::vector<PlantedDefect> defects;
  std::int64_t noise = 0;  // seed
};

// Part `number` of a series. Series differ in their noise, and in how their parts lie.
LinePart draw(std::int64_t seed, std::int64_t series, int number, bool bad) {
  constexpr std::int64_t kMaxParts = 1'000'000;
  LinePart part;
  part.noise = (2 * seed + series) * kMaxParts + number;
  EvenNumbers numbers(static_cast<std::uint64_t>(part.noise));
  part.pose = {kStep * numbers.next(), numbers.within(1), numbers.within(1)};
  if (!bad) {
    return part;
  }
  const auto between = [&](double least, double most) { return least * std::pow(most / least, numbers.next()); };
  PlantedDefect defect{.tread = numbers.next() < 0.5 ? 0U : 1U, .size = between(kMinSize, kMaxSize)};
  defect.depth = between(kMinDepth, kMaxDepth) * (numbers.next() < 0.5 ? 1 : -1);
  const double margin = kFromEdges + defect.size / 2;
  defect.along = margin + (PlantedPart::kLength - 2 * margin) * numbers.next();
  defect.across = margin + (PlantedPart::kTreadWidth - 2 * margin) * numbers.next();
  defect.across -= defect.tread == 0 ? PlantedPart::kTreadWidth : 0;
  part.defects.push_back(defect);
  return part;
}

std::vector<LinePart> series_of(const ProductionOptions& options, std::int64_t series, int count, int bad_every) {
  std::vector<LinePart> parts;
  for (int i = 1; i <= count; ++i) {
    parts.push_back(draw(options.seed, series, i, bad_every > 0 && i % bad_every == 0));
  }
  return parts;
}

// A scene in which all lengths are larger, and which stands still.
class Enlarged final : public Scene {
 public:
  Enlarged(const Scene& scene, double factor) : scene_(scene), factor_(factor) {}

  [[nodiscard]] int frames() const override { return scene_.frames(); }
  [[nodiscard]] double height(double x, double y, double t) const override {
    return factor_ * scene_.height(x / factor_, y / factor_, t);
  }
  [[nodiscard]] HeightRange range(const Box& box, double t0, double t1) const override {
    const HeightRange range =
        scene_.range({box.x0 / factor_, box.x1 / factor_, box.y0 / factor_, box.y1 / factor_}, t0, t1);
    return {factor_ * range.low, factor_ * range.high};
  }
  [[nodiscard]] double speed() const override { return 0; }

 private:
  const Scene& scene_;
  double factor_;
};

// A kind of line: what the host must know of it, and its packets.
class Line {
 public:
  using Done = std::function<void()>;
  using TakeImage = std::function<void(std::size_t frame, const std::string& png)>;

  explicit Line(rig::Rig rig) : rig_(std::move(rig)) {}
  Line(const Line&) = delete;
  Line& operator=(const Line&) = delete;
  virtual ~Line() = default;

  [[nodiscard]] const rig::Rig& rig() const { return rig_; }
  [[nodiscard]] virtual const char* reference() const = 0;  // the name of its folder
  virtual void write_reference(files::OutputFolder& folder) const = 0;

  // The reference that lies beside a recording; empty if there is none of this kind.
  [[nodiscard]] virtual std::string reference_beside() const { return ""; }

  // The images of targets from which the rig is calibrated, if a calibration takes them.
  virtual void write_targets(files::OutputFolder& /*folder*/) const {}

  // The packets of parts one after another. `done` is called after each part, `take_image`, if any, with each image.
  [[nodiscard]] virtual PacketRecording packets(const std::vector<LinePart>& parts, const Done& done,
                                                const TakeImage& take_image) const = 0;

  // Where `selfproj` says that a defect lies.
  struct Place {
    double along, across, size, depth;
  };
  [[nodiscard]] virtual Place place(const PlantedDefect& defect) const {
    return {defect.along, defect.across, defect.size, -defect.depth};
  }

 private:
  rig::Rig rig_;
};

rig::Rig rig_of_moving_parts(rig::Rig rig, const ProductionOptions& options) {
  // The rig is the simulation's truth: nothing of it remains to be measured or corrected.
  rig.sources.reset();
  rig.heights.reset();
  constexpr double kMostExposed = 0.9;  // of the time from frame to frame
  const double pixel =
      PerturbedRig(rig).camera.depth({0, 0, rig.plane_z_mm}) * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  rig.name = "line";
  // The whole sensor of a camera with a region scans, and is not at work here.
  double& rate = rig.camera.region ? rig.camera.region->frame_rate_hz : rig.camera.frame_rate_hz;
  double& exposure = rig.camera.region ? rig.camera.region->exposure_s : rig.camera.exposure_s;
  rate = options.rate;
  exposure = std::min(exposure, kMostExposed / options.rate);
  rig.conveyor.speed_mm_per_s = kStep * options.rate;
  rig.parts = rig::RigParts{.cut = rig::PartCut::profile,
                            .by_encoder = options.belt == "encoder",
                            .grid_mm = std::max(0.25, std::ceil(20 * pixel) / 20),
                            .above_mm = 5,
                            .min_width_mm = 5,
                            .gap_mm = 1.5,
                            .pause_s = 0.005,
                            .min_length_mm = 5,
                            .length_mm = 25};
  return rig;
}

// The camera, held by hand, of a rig with a laser: as far from the chessboard as from the line on the belt.
rig::Rig rig_of_held_boards(rig::Rig rig) {
  rig.plane_z_mm = PerturbedRig(rig).camera.depth({0, 0, rig.plane_z_mm});
  rig.belt_pose.reset();
  return rig;
}

constexpr ChessboardShape kBoard{9, 6, 6};
constexpr int kPoses = 10;
constexpr double kLean = 30;                               // degrees, of held boards
constexpr std::array<double, 4> kPlaces = {0, 8, 16, 24};  // mm, of the board on the belt
constexpr double kBlock = 20;                              // mm, height of the gauge block
constexpr double kBlockWidth = 40;

// Where the belt was at each image of the board on it.
std::string places_csv(const rig::Rig& rig) {
  std::string text = "moves_mm,counts,seconds\n";
  for (const double place : kPlaces) {
    text += fmt::format("{},{},{}\n", place, std::llround(place / rig.conveyor.encoder_mm_per_count),
                        place / rig.conveyor.speed_mm_per_s);
  }
  return text;
}

// Where along the belt, mm, the light meets the part.
struct LightOnPart {
  double first, last;
};

// The light is a plane: that of a laser, or through the camera's middle row, on which the line is seen.
LightOnPart light_on_part(const rig::Rig& rig) {
  const PerturbedRig actual(rig);
  const Pinhole& camera = actual.camera;
  const Pinhole::Intrinsics& k = camera.intrinsics();
  const double middle = (0.5 * (rig.camera.rows - 1) - k.row_0) / k.row_scale;
  const Point3 normal = rig.light_plane ? actual.projector.axes()[0] : camera.axes()[0] - middle * camera.axes()[2];
  const Point3 on = (rig.light_plane ? actual.projector : camera).centre();
  LightOnPart light{0, 0};
  for (const double height : {0.0, PlantedPart::kTreads[1] + kMaxDepth}) {
    for (const double y : {-PlantedPart::kTreadWidth, PlantedPart::kTreadWidth}) {
      const double x = on.x - (normal.y * (y - on.y) + normal.z * (rig.plane_z_mm - height - on.z)) / normal.x;
      light = {std::min(light.first, x), std::max(light.last, x)};
    }
  }
  return light;
}

// Parts that pass under the pattern of the good one, or under a laser's line.
class MovingLine final : public Line {
 public:
  explicit MovingLine(const ProductionOptions& options)
      : Line(rig_of_moving_parts(rig::load_any_rig(options.rig), options)),
        light_(rig().is_pinholes() ? LightOnPart{0, 0} : light_on_part(rig())),
        foot_(PerturbedRig(rig()).camera.centre().y) {
    const PlantedPart part(rig(), {}, {});
    if (rig().light_plane) {
      pattern_ = light_section::draw_straight_line(PerturbedRig(rig()).rig, kLaserLine);
    }
    light_section::ReferenceCurve curve = curve_of_scene(rig(), part);
    // The host's y counts from the camera.
    std::transform(curve.y_mm.begin(), curve.y_mm.end(), curve.y_mm.begin(), [this](double y) { return y - foot_; });
    if (!rig().light_plane) {
      pattern_ = light_section::draw_pattern(rig(), light_section::pattern_of_curve(rig(), curve));
    }
    reference_ = light_section::reference_of_curve(rig(), curve);
    if (reference_.valid_columns() == 0) {
      throw UserError("--rig " + options.rig, rig().light_plane
                                                  ? "no camera column sees the laser on the part"
                                                  : "no camera column sees the part in the projector's light");
    }
  }

  [[nodiscard]] const char* reference() const override { return "part"; }

  void write_reference(files::OutputFolder& folder) const override {
    folder.append("part/reference.csv", light_section::reference_csv(rig(), reference_));
    if (!rig().light_plane) {
      folder.append("part/pattern.tiff", images::encode_float_tiff("pattern.tiff", pattern_));
      folder.append("part/pattern.png", light_section::encode_pattern_png(pattern_));
    }
    folder.append("part/preview.png",
                  light_section::draw_preview(rig(), rig().light_plane ? images::FloatImage() : pattern_, reference_));
  }

  // Of a laser.
  void write_targets(files::OutputFolder& folder) const override {
    if (!rig().light_plane) {
      return;
    }
    CaptureSettings settings;
    const auto draw_noise = [seed = rig().imaging.seed](rig::Rig of, int target) {
      constexpr std::int64_t kTargets = 10;
      of.imaging.seed = kTargets * seed + target;
      return PerturbedRig(of);
    };
    const PerturbedRig by_hand = draw_noise(rig_of_held_boards(rig()), 1);
    settings.prefix = "held/";
    capture_chessboard_and_laser(by_hand, kBoard, {}, chessboard_places(by_hand, kBoard, kPoses, kLean), settings,
                                 folder);
    const PerturbedRig carried = draw_noise(rig(), 2);
    settings.prefix = "carried/";
    const PlateVisits visits{{0}, {kPlaces.begin(), kPlaces.end()}};
    capture_chessboard_and_laser(carried, kBoard, {}, places_on_plates(carried, kBoard, visits, {}, 0), settings,
                                 folder);
    folder.append("carried/places.csv", places_csv(rig()));
    const auto take = [&](const std::string& name, const Scene& scene, int target) {
      const PerturbedRig actual = draw_noise(rig(), target);
      settings.prefix = name + "/";
      capture_scene(actual, scene, {laser_light(actual, settings.render)}, settings, folder);
    };
    take("empty", FlatPlate(0, {}, 0), 3);
    take("block", StepBlock({kBlock}, kBlockWidth, 0, {}, 0), 4);
    take("golden",
         StepBlock({PlantedPart::kTreads.begin(), PlantedPart::kTreads.end()}, PlantedPart::kTreadWidth, 0, {}, 0), 5);
  }

  // A laser's line is the same whatever it is compared with.
  [[nodiscard]] std::string reference_beside() const override {
    return rig().light_plane ? "" : light_section::reference_csv(rig(), reference_);
  }

  [[nodiscard]] PacketRecording packets(const std::vector<LinePart>& parts, const Done& done,
                                        const TakeImage& take_image) const override {
    return rig().measure.bits() > spec::kPixelBits ? packets_of<std::uint16_t>(parts, done, take_image)
                                                   : packets_of<std::uint8_t>(parts, done, take_image);
  }

  [[nodiscard]] Place place(const PlantedDefect& defect) const override {
    Place place = Line::place(defect);
    place.across -= foot_;
    return place;
  }

 private:
  template <typename Pixel>
  [[nodiscard]] PacketRecording packets_of(const std::vector<LinePart>& parts, const Done& done,
                                           const TakeImage& take_image) const {
    const auto first = static_cast<int>(std::floor((ConveyedScene::kLead - kBefore + light_.first) / kStep));
    const auto count =
        static_cast<int>(std::ceil((PlantedPart::kLength + kBefore + kBehind + light_.last - light_.first) / kStep));
    const rig::RigCamera& camera = rig().camera;
    const rig::RigRegion sent = camera.sent();
    const model::Measure measure = rig().measure.of_board();
    const double counts_per_frame = kStep / rig().conveyor.encoder_mm_per_count;
    model::PacketHeader header;
    header.kind = model::kind_of_columns(rig().measure.sends_compact(), measure.mode);
    model::describe_frame(header, sent.rows, sent.columns, measure);
    header.region_row = static_cast<std::uint16_t>(camera.region_row());
    header.region_column = static_cast<std::uint16_t>(camera.region_column());
    std::vector<std::vector<std::vector<std::uint8_t>>> payloads(parts.size());
    std::mutex mutex;
    parallel_for(static_cast<int>(parts.size()), 0, [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      PerturbedRig actual(rig());
      actual.rig.imaging.seed = parts[at].noise;
      expose_as_sent(camera, actual.rig);
      actual.rig.camera.frame_rate_hz = sent.frame_rate_hz;
      const PlantedPart scene(actual.rig, parts[at].pose, parts[at].defects);
      const LineRenderer renderer(actual, scene, pattern_);
      std::vector<Pixel> sensor(camera.pixels());
      images::ImageOf<Pixel> image{sent.rows, sent.columns,
                                   std::vector<Pixel>(static_cast<std::size_t>(sent.rows * sent.columns))};
      model::Runs runs;
      runs.resize(measure.select, sent.columns);
      for (int frame = 0; frame < count; ++frame) {
        renderer.render(first + frame, std::span(sensor));
        crop_as_sent<Pixel>(camera, sensor, image.pixels);
        light_section::fast_measure_columns(image.view(), measure, runs.view());
        std::vector<std::uint8_t>& payload = payloads[at].emplace_back(model::columns_payload_bytes(header));
        model::pack_columns(header, runs.view(), payload.data());
        if (take_image) {
          const std::string png = images::encode_png(image);
          const std::lock_guard lock(mutex);
          take_image(at * static_cast<std::size_t>(count) + static_cast<std::size_t>(frame), png);
        }
      }
      const std::lock_guard lock(mutex);
      done();
    });
    PacketRecording recording;
    std::vector<std::uint8_t> packet;
    for (const auto& of_part : payloads) {
      for (const std::vector<std::uint8_t>& payload : of_part) {
        header.encoder =
            static_cast<std::uint32_t>(std::llround(static_cast<double>(header.sequence) * counts_per_frame));
        packet.clear();
        model::append_packet(header, payload, 0, packet);
        recording.add(header, packet);
        ++header.sequence;
      }
    }
    return recording;
  }

  LightOnPart light_;
  double foot_;  // y of the camera, above the middle of the parts' way
  images::FloatImage pattern_;
  light_section::ReferenceProfile reference_;
};

rig::Rig rig_of_still_parts(rig::Rig rig, const ProductionOptions& options) {
  if (rig.conveyor.speed_mm_per_s != 0) {
    throw UserError("--rig " + options.rig, "its conveyor moves; a scanner needs a surface that stands still");
  }
  const double pixel = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  rig.name = "line";
  rig.camera.frame_rate_hz = options.rate;
  rig.camera.exposure_s = std::min(rig.camera.exposure_s, 1 / options.rate);
  rig.parts = rig::RigParts{.cut = rig::PartCut::image, .grid_mm = std::ceil(4 * pixel) / 4, .pause_s = 0.05};
  return rig;
}

// Parts that stand still, each under the patterns of the good one. Then comes one dark frame, whose number is that of
// no pattern, so that each depth image is of one part alone.
class StillLine final : public Line {
 public:
  explicit StillLine(const ProductionOptions& options) : Line(rig_of_still_parts(rig::load_rig(options.rig), options)) {
    const PlantedPart good(rig(), {}, {});
    const Enlarged scene(good, kEnlarged);
    const structured_light::ProjectorPoints points = scan_points(rig(), scene, {}, ScanMethod::gray_codes, [] {});
    try {
      reference_ = structured_light::make_self_reference(rig(), points, {});
    } catch (const std::invalid_argument&) {
      throw UserError("--rig " + options.rig, "no camera pixel sees the part in the projector's light");
    }
    for (int i = 0; i < 2 * reference_.stripes.bits; ++i) {
      patterns_.push_back(
          project_image(rig(), pattern_image(structured_light::self_projected_pattern(reference_, i)), {}));
    }
  }

  [[nodiscard]] const char* reference() const override { return "stripes"; }

  void write_reference(files::OutputFolder& folder) const override {
    structured_light::write_self_reference(rig(), reference_, folder, "stripes/");
  }

  [[nodiscard]] PacketRecording packets(const std::vector<LinePart>& parts, const Done& done,
                                        const TakeImage& take_image) const override {
    const rig::RigCamera& camera = rig().camera;
    const auto patterns = static_cast<int>(patterns_.size());
    const model::BoardSettings settings{.columns = camera.columns,
                                        .rows = camera.rows,
                                        .mode = rig().measure.mode,
                                        .threshold = rig().measure.threshold,
                                        .codes = true,
                                        .code_bits = reference_.stripes.bits,
                                        .code_threshold = rig().measure.code_threshold};
    std::unique_ptr<PlantedPart> part;
    std::unique_ptr<Enlarged> scene;
    std::unique_ptr<PatternRenderer> renderer;
    images::Image image{camera.rows, camera.columns, std::vector<std::uint8_t>(camera.pixels())};
    const auto frames = static_cast<std::size_t>(patterns) + 1;
    return recording_of_images(settings, spec::kPixelBits, parts.size() * frames, patterns + 1, [&](std::size_t i) {
      const auto pattern = i % frames;
      if (pattern == 0) {
        PerturbedRig actual(rig());
        actual.rig.imaging.seed = parts[i / frames].noise;
        renderer.reset();
        part = std::make_unique<PlantedPart>(actual.rig, PartPose{}, parts[i / frames].defects);
        scene = std::make_unique<Enlarged>(*part, kEnlarged);
        renderer = std::make_unique<PatternRenderer>(actual, *scene);
      }
      if (pattern == patterns_.size()) {
        std::fill(image.pixels.begin(), image.pixels.end(), std::uint8_t{0});
        done();
      } else {
        renderer->render(static_cast<int>(pattern), patterns_[pattern], std::span(image.pixels));
      }
      if (take_image) {
        take_image(i, images::encode_png(image));
      }
      return image.view();
    });
  }

  // The map begins at the upper border of the camera's view of the plane.
  [[nodiscard]] Place place(const PlantedDefect& defect) const override {
    const rig::RigCamera& camera = rig().camera;
    const double half = 0.5 * camera.rows * rig().plane_z_mm * camera.pixel_pitch_mm / camera.focal_length_mm;
    return {half + kEnlarged * (PlantedPart::kLength / 2 - defect.along), kEnlarged * defect.across,
            kEnlarged * defect.size, -kEnlarged * defect.depth};
  }

 private:
  structured_light::SelfReference reference_;
  std::vector<ProjectedLight> patterns_;
};

std::unique_ptr<Line> line_of(const ProductionOptions& options) {
  const rig::Rig rig = rig::load_any_rig(options.rig);
  if (options.images && rig.light_plane) {
    rig::need_eight_bits(rig, options.rig, "--images with a laser");  // chessboards are among them
  }
  if (rig.kind == rig::RigKind::scanner) {
    rig::need_eight_bits(rig, options.rig, "a line of parts that stand still");
    return std::make_unique<StillLine>(options);
  }
  return std::make_unique<MovingLine>(options);
}

std::string stream_of(const PacketRecording& recording, double clocks_per_frame) {
  std::string stream;
  stream.reserve(recording.bytes());
  for (std::uint64_t frame = 0; frame < recording.frames(); ++frame) {
    recording.play(frame, clocks_per_frame, [&](std::size_t size, const auto& stamp) {
      stream.resize(stream.size() + size);
      stamp(reinterpret_cast<std::uint8_t*>(stream.data()) + stream.size() - size);
    });
  }
  return stream;
}

std::string truth_csv(const Line& line, const std::vector<LinePart>& parts) {
  std::string text = "part,verdict,along_mm,across_mm,size_mm,depth_mm\n";
  for (std::size_t i = 0; i < parts.size(); ++i) {
    if (parts[i].defects.empty()) {
      text += fmt::format("{},good,,,,\n", i + 1);
    } else {
      const Line::Place place = line.place(parts[i].defects.front());
      text += fmt::format("{},bad,{:.3f},{:.3f},{:.3f},{:.3f}\n", i + 1, place.along, place.across, place.size,
                          place.depth);
    }
  }
  return text;
}

void run_production(const ProductionOptions& options) {
  files::OutputFolder folder(options.out);
  folder.check("part/reference.csv");  // before a long run
  const std::unique_ptr<Line> line = line_of(options);
  const double clocks = line->rig().pixel_clock_hz() / options.rate;
  folder.append("rig.yaml", rig::to_yaml(line->rig()));
  line->write_reference(folder);
  if (options.images) {
    line->write_targets(folder);
  }
  const std::vector<LinePart> good = series_of(options, 0, options.good, 0);
  const std::vector<LinePart> parts = series_of(options, 1, options.parts, options.bad_every);
  cli::Progress progress("part", good.size() + parts.size());
  std::size_t done = 0;
  const auto play = [&](const std::string& name, const std::vector<LinePart>& series) {
    Line::TakeImage take_image;
    if (options.images) {
      take_image = [&](std::size_t frame, const std::string& png) {
        folder.append(fmt::format("{}/frame_{:05}.png", name, frame + 1), png);
      };
    }
    folder.append(name + ".packets", stream_of(line->packets(
                                                   series, [&] { progress.update(++done); }, take_image),
                                               clocks));
  };
  if (const std::string reference = line->reference_beside(); !reference.empty()) {
    folder.append("good.packets.reference.csv", reference);
    folder.append("run.packets.reference.csv", reference);
  }
  play("good", good);
  play("run", parts);
  folder.append("run.csv", truth_csv(*line, parts));
  folder.commit();
  const auto bad =
      std::count_if(parts.begin(), parts.end(), [](const LinePart& part) { return !part.defects.empty(); });
  fmt::print("{} good parts, then {} of which {} {} bad → {}\n", good.size(), parts.size(), bad,
             bad == 1 ? "is" : "are", folder.name());
}

}  // namespace

void add_production_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "production",
       .purpose = "Makes the files of a simulated production line: good parts, and a run of good and bad ones.",
       .details =
           "Parts with two treads pass under the camera of a light section, 0.25 mm from frame to frame, each a little "
           "shifted and turned. A bad part has one dent or bump, 2.5 to 5 mm wide and 0.4 to 1 mm deep. With a rig of "
           "kind scanner the parts are five times larger, and stand still under the stripes of the good part. A camera "
           "with a region (`selfproj rows`) sends only that, with the region's exposure.\n\n"
           "The output folder, which must be new, gets\n"
           "- rig.yaml: the rig, with the section `parts`\n"
           "- part/ (of a scanner stripes/): the reference and its patterns, as `selfproj pattern` writes them; of a "
           "laser, which has no patterns, the reference alone\n"
           "- good.packets: what the board sends of good parts, for `selfproj tolerance learn`\n"
           "- run.packets: what it sends of good and bad ones; `selfproj-sim board --replay` plays it, with --loop "
           "without end\n"
           "- good.packets.reference.csv, run.packets.reference.csv: the reference under which they were taken, of a "
           "light section with a projector\n"
           "- run.csv: the truth: which parts of the run are bad, and where\n"
           "- with --images good/ and run/: the camera's images. Of a laser also those from which the rig is "
           "calibrated: held/boards/ and held/lines/, a chessboard of 9x6 corners with squares of 6 mm in ten poses, "
           "and the line on it; carried/boards/, the same on the belt at the places of carried/places.csv; the line on "
           "the empty belt (empty/), on a block 20 mm high (block/), and on a good part (golden/)",
       .examples = R"(
# A line; the tolerance of its good parts; its parts classified.
selfproj-sim production --out line
selfproj tolerance learn --rig line/rig.yaml --reference line/part \
  --device file:line/good.packets --out tolerance.yaml
selfproj inspect --rig line/rig.yaml --reference line/part --device file:line/run.packets \
  --tolerance tolerance.yaml --parts today

# A laser's line, with all images that its calibration takes.
selfproj-sim production --rig laser --images --good 5 --parts 3 --out laser-line
)"});
  const auto options = std::make_shared<ProductionOptions>();
  command->add_option("--rig", options->rig, "Built-in rig or YAML file.")->type_name("RIG")->capture_default_str();
  command->add_option("--good", options->good, "Good parts in good.packets.")
      ->transform(cli::whole_number(1, 1000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--parts", options->parts, "Parts in run.packets.")
      ->transform(cli::whole_number(1, 1000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--bad-every", options->bad_every, "Every which part of the run is bad. 0: none.")
      ->transform(cli::whole_number(0, 1000))
      ->type_name("N")
      ->capture_default_str();
  command
      ->add_option("--rate", options->rate, "Frames a second of the rig. Its belt moves 0.25 mm from frame to frame.")
      ->transform(cli::real_number(1, 1e6))
      ->type_name("FPS")
      ->capture_default_str();
  command
      ->add_option("--belt", options->belt,
                   "How the rig knows the belt: encoder, or clock, where a camera alone sends the images, at --rate.")
      ->check(cli::one_of({"encoder", "clock"}))
      ->type_name("HOW")
      ->capture_default_str();
  command->add_flag("--images", options->images, "Write the camera's images, too.");
  command->add_option("--seed", options->seed, "Seed of the parts and of the noise.")
      ->transform(cli::whole_number(0, 1'000'000))
      ->type_name("N")
      ->capture_default_str();
  command->add_option("--out", options->out, "Folder for the files.")->type_name("DIR")->required();
  command->callback([options] { run_production(*options); });
}

}  // namespace selfproj::sim
