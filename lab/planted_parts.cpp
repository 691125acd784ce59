#include "lab/planted_parts.h"

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

#include "lab/image_profiler.h"
#include "selfproj/model/packet.h"
#include "sim/scene/camera_errors.h"
#include "sim/scene/parallel.h"
#include "sim/scene/random.h"

namespace selfproj::lab {
namespace {

constexpr double kStep = 0.25;  // of the belt, mm a frame
constexpr double kLead = 2;     // bare belt before and behind a part, mm
constexpr int kBare = 40;       // frames between two parts that are not rendered: 10 mm of bare belt

double drawn(sim::EvenNumbers& numbers, double least, double most) {
  return least * std::pow(most / least, numbers.next());
}

// A defect of this size and depth anywhere on a tread, wholly.
PlantedDefect planted(sim::EvenNumbers& numbers, std::size_t tread, double size, double depth) {
  PlantedDefect defect{.tread = tread, .size = size, .depth = numbers.next() < 0.5 ? depth : -depth};
  defect.along = size / 2 + (PlantedPart::kLength - size) * numbers.next();
  defect.across = size / 2 + (PlantedPart::kTreadWidth - size) * numbers.next();
  defect.across -= tread == 0 ? PlantedPart::kTreadWidth : 0;
  return defect;
}

int first_frame() { return static_cast<int>((sim::ConveyedScene::kLead - kLead) / kStep); }
int frames_of_part() { return static_cast<int>((PlantedPart::kLength + 2 * kLead) / kStep); }

}  // namespace

DrawnPart draw_part(const rig::Rig& rig, std::uint64_t seed, std::uint64_t number, bool is_planted,
                    double max_shift_mm) {
  constexpr std::uint64_t kMaxParts = 1'000'000;
  DrawnPart part;
  part.noise = seed * kMaxParts + number + static_cast<std::uint64_t>(rig.imaging.seed);
  sim::EvenNumbers numbers(part.noise);
  part.pose = {kStep * numbers.next(), numbers.within(max_shift_mm), numbers.within(1)};
  if (is_planted) {
    const std::size_t of_goal = numbers.next() < 0.5 ? 0 : 1;
    part.defects.push_back(planted(numbers, of_goal, kGoalSize, kGoalDepth));
    const double size = drawn(numbers, kMinSize, kMaxSize);
    part.defects.push_back(planted(numbers, 1 - of_goal, size, drawn(numbers, kMinDepth, kMaxDepth)));
  }
  return part;
}

rig::Rig rig_of_planted_parts(rig::Rig rig) {
  rig.conveyor.speed_mm_per_s = kStep * rig.camera.frame_rate_hz;
  rig.parts = rig::RigParts{.cut = rig::PartCut::profile,
                            .by_encoder = true,
                            .grid_mm = 0.25,
                            .above_mm = 5,
                            .min_width_mm = 5,
                            .gap_mm = 1.5,
                            .pause_s = 0.005,
                            .min_length_mm = 5,
                            .length_mm = 25};
  return rig;
}

// What the host gets of a part: moments and profiles of its packets.
PlantedParts::Frames PlantedParts::measured(const Draw& draw) const {
  const rig::RigCamera& camera = setup_.rig.camera;
  rig::Rig rig = setup_.rig;
  rig.measure.mode = sim::kAllModes[0];
  ImageProfiler profiler(rig, setup_.references[0]);
  std::vector<std::uint8_t> pixels(camera.pixels());
  Frames frames(static_cast<std::size_t>(frames_of_part()));
  for (std::size_t i = 0; i < frames.size(); ++i) {
    draw(i, pixels);
    frames[i].profile.resize(camera.columns);
    profiler.profile({pixels.data(), camera.rows, camera.columns, camera.columns}, frames[i].profile.view(),
                     &frames[i].moments);
  }
  return frames;
}

void PlantedParts::pass(const std::vector<DrawnPart>& parts, int threads, const Take& take) {
  const auto part = [&](std::size_t number) {
    sim::PerturbedRig actual = setup_.actual;
    actual.rig.imaging.seed = static_cast<std::int64_t>(parts[number].noise);
    const PlantedPart scene(actual.rig, parts[number].pose, parts[number].defects);
    const sim::LineRenderer renderer(actual, scene, setup_.pattern, options_);
    return measured([&](std::size_t frame, std::span<std::uint8_t> pixels) {
      renderer.render(first_frame() + static_cast<int>(frame), pixels);
    });
  };
  pass(parts.size(), threads, part, take);
}

std::vector<images::Image> PlantedParts::images_of(const DrawnPart& part) const {
  sim::PerturbedRig actual = setup_.actual;
  actual.rig.imaging.seed = static_cast<std::int64_t>(part.noise);
  const PlantedPart scene(actual.rig, part.pose, part.defects);
  const sim::LineRenderer renderer(actual, scene, setup_.pattern, options_);
  const rig::RigCamera& camera = setup_.rig.camera;
  // Where the line falls on bare belt, the camera sees it up to 13 mm nearer to the next part, which is in no image.
  constexpr double kBefore = 14;
  const int first = static_cast<int>((sim::ConveyedScene::kLead - kBefore) / kStep);
  const int last = first_frame() + frames_of_part();
  std::vector<images::Image> frames;
  for (int frame = first; frame < last; ++frame) {
    frames.push_back({camera.rows, camera.columns, std::vector<std::uint8_t>(camera.pixels())});
    renderer.render(frame, frames.back().pixels);
  }
  return frames;
}

CleanPart PlantedParts::clean(const DrawnPart& part) const {
  sim::RenderOptions options = options_;
  options.shot_noise = options.read_noise = options.quantization = false;
  const PlantedPart scene(setup_.actual.rig, part.pose, part.defects);
  const sim::LineRenderer renderer(setup_.actual, scene, setup_.pattern, options);
  CleanPart clean;
  for (int frame = 0; frame < frames_of_part(); ++frame) {
    renderer.render(first_frame() + frame, clean.frames.emplace_back(setup_.rig.camera.pixels()));
  }
  return clean;
}

void PlantedParts::pass(const CleanPart& clean, const std::vector<std::uint64_t>& noise, int threads,
                        const Take& take) {
  const auto part = [&](std::size_t number) {
    rig::RigImaging imaging = setup_.actual.rig.imaging;
    imaging.seed = static_cast<std::int64_t>(noise[number]);
    std::vector<float> noisy;
    return measured([&](std::size_t frame, std::span<std::uint8_t> pixels) {
      noisy = clean.frames[frame];
      sim::add_noise(imaging, options_, first_frame() + static_cast<int>(frame), noisy);
      sim::quantize(noisy, pixels);
    });
  };
  pass(noise.size(), threads, part, take);
}

void PlantedParts::pass(std::size_t parts, int threads, const std::function<Frames(std::size_t)>& part,
                        const Take& take) {
  std::vector<Frames> all(parts);
  sim::parallel_for(static_cast<int>(parts), threads,
                    [&](int i) { all[static_cast<std::size_t>(i)] = part(static_cast<std::size_t>(i)); });
  const rig::Rig& rig = setup_.rig;
  for (Frames& frames : all) {
    for (Measured& frame : frames) {
      const double time = static_cast<double>(sequence_) / rig.camera.frame_rate_hz;
      model::PacketHeader header;
      header.kind = spec::kKindMoments;
      model::describe_frame(header, rig.camera.rows, rig.camera.columns, rig.measure.of_board());
      header.sequence = sequence_;
      header.time_stamp = static_cast<std::uint64_t>(std::llround(time * rig.pixel_clock_hz()));
      header.encoder = static_cast<std::uint32_t>(
          std::llround(time * rig.conveyor.speed_mm_per_s / rig.conveyor.encoder_mm_per_count));
      take(header, frame.profile.view(), frame.moments);
      ++sequence_;
    }
    sequence_ += kBare;
  }
}

}  // namespace selfproj::lab
