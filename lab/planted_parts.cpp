#include "lab/planted_parts.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>
#include <utility>
#include <vector>

#include "lab/image_profiler.h"
#include "selfproj/model/packet.h"
#include "sim/scene/parallel.h"
#include "sim/scene/random.h"

namespace selfproj::lab {
namespace {

constexpr double kHalfPart = PlantedPart::kLength / 2;

double square(double x, double y) { return x * x + y * y; }

// The squares of the least and the greatest distance of a rectangle's points from a point.
std::pair<double, double> square_distances(const sim::Box& box, double u, double w) {
  const double du = std::max({box.x0 - u, 0.0, u - box.x1});
  const double dw = std::max({box.y0 - w, 0.0, w - box.y1});
  return {square(du, dw), square(std::max(std::abs(box.x0 - u), std::abs(box.x1 - u)),
                                 std::max(std::abs(box.y0 - w), std::abs(box.y1 - w)))};
}

}  // namespace

PlantedPart::PlantedPart(const rig::Rig& rig, const PartPose& pose, std::vector<PlantedDefect> defects)
    : sim::ConveyedScene(rig, kLength),
      pose_(pose),
      cos_(std::cos(pose.turn_deg * std::numbers::pi / 180)),
      sin_(std::sin(pose.turn_deg * std::numbers::pi / 180)),
      defects_(std::move(defects)) {}

// (u, w) are the axes of the part: u along the belt, w across.
double PlantedPart::part_height(double x, double y) const {
  const double u = (x - pose_.along_mm) * cos_ + (y - pose_.across_mm) * sin_;
  const double w = (y - pose_.across_mm) * cos_ - (x - pose_.along_mm) * sin_;
  if (std::abs(u) > kHalfPart || std::abs(w) > kTreadWidth) {
    return 0;
  }
  double height = tread_height(w);
  for (const PlantedDefect& defect : defects_) {
    const double distance = square(kHalfPart - u - defect.along, w - defect.across);
    height -= distance <= square(defect.size / 2, 0) ? defect.depth : 0;
  }
  return height;
}

sim::HeightRange PlantedPart::part_range(const sim::Box& box) const {
  // The rectangle in the axes of the part that contains the turned box.
  const double x = (box.x0 + box.x1) / 2 - pose_.along_mm;
  const double y = (box.y0 + box.y1) / 2 - pose_.across_mm;
  const double half_x = (box.x1 - box.x0) / 2;
  const double half_y = (box.y1 - box.y0) / 2;
  const double half_u = half_x * cos_ + half_y * std::abs(sin_);
  const double half_w = half_y * cos_ + half_x * std::abs(sin_);
  const double u = x * cos_ + y * sin_;
  const double w = y * cos_ - x * sin_;
  const sim::Box own{u - half_u, u + half_u, w - half_w, w + half_w};
  if (own.x0 > kHalfPart || own.x1 < -kHalfPart || own.y0 > kTreadWidth || own.y1 < -kTreadWidth) {
    return {0, 0};
  }
  const bool inside = own.x0 >= -kHalfPart && own.x1 <= kHalfPart && own.y0 >= -kTreadWidth && own.y1 <= kTreadWidth;
  sim::HeightRange range{tread_height(own.y0), tread_height(own.y0)};
  range.join(tread_height(own.y1));
  for (const PlantedDefect& defect : defects_) {
    const auto [least, greatest] = square_distances(own, kHalfPart - defect.along, defect.across);
    const double rim = square(defect.size / 2, 0);
    if (least > rim) {
      continue;
    }
    const double bottom = kTreads.at(defect.tread) - defect.depth;
    if (greatest <= rim) {
      return {bottom, bottom};
    }
    range.join(bottom);
  }
  if (!inside) {
    range.join(0);
  }
  return range;
}

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

DrawnPart draw_part(const rig::Rig& rig, std::uint64_t seed, std::uint64_t number, bool is_planted) {
  constexpr std::uint64_t kMaxParts = 1'000'000;
  DrawnPart part;
  part.noise = seed * kMaxParts + number + static_cast<std::uint64_t>(rig.imaging.seed);
  sim::EvenNumbers numbers(part.noise);
  part.pose = {kStep * numbers.next(), numbers.within(1), numbers.within(1)};
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
                            .min_length_mm = 5,
                            .length_mm = 25};
  return rig;
}

// What the host gets of a part: the profiles of its packets.
std::vector<light_section::Profile> PlantedParts::profiles_of(const DrawnPart& part) const {
  sim::PerturbedRig actual = setup_.actual;
  actual.rig.imaging.seed = static_cast<std::int64_t>(part.noise);
  const PlantedPart scene(actual.rig, part.pose, part.defects);
  const sim::LineRenderer renderer(actual, scene, setup_.pattern, options_);
  const rig::RigCamera& camera = setup_.rig.camera;
  rig::Rig rig = setup_.rig;
  rig.measure.mode = sim::kAllModes[0];
  ImageProfiler profiler(rig, setup_.references[0]);
  std::vector<std::uint8_t> pixels(camera.pixels());
  std::vector<light_section::Profile> profiles(static_cast<std::size_t>(frames_of_part()));
  for (std::size_t i = 0; i < profiles.size(); ++i) {
    renderer.render(first_frame() + static_cast<int>(i), pixels);
    profiles[i].resize(camera.columns);
    profiler.profile({pixels.data(), camera.rows, camera.columns, camera.columns}, profiles[i].view());
  }
  return profiles;
}

void PlantedParts::pass(const std::vector<DrawnPart>& parts, int threads, const Take& take) {
  std::vector<std::vector<light_section::Profile>> profiles(parts.size());
  sim::parallel_for(static_cast<int>(parts.size()), threads, [&](int i) {
    profiles[static_cast<std::size_t>(i)] = profiles_of(parts[static_cast<std::size_t>(i)]);
  });
  const rig::Rig& rig = setup_.rig;
  for (std::vector<light_section::Profile>& of_part : profiles) {
    for (light_section::Profile& profile : of_part) {
      const double time = static_cast<double>(sequence_) / rig.camera.frame_rate_hz;
      model::PacketHeader header;
      header.kind = spec::kKindMoments;
      header.sequence = sequence_;
      header.time_stamp = static_cast<std::uint64_t>(std::llround(time * rig.pixel_clock_hz()));
      header.encoder = static_cast<std::uint32_t>(
          std::llround(time * rig.conveyor.speed_mm_per_s / rig.conveyor.encoder_mm_per_count));
      take(header, profile.view());
      ++sequence_;
    }
    sequence_ += kBare;
  }
}

}  // namespace selfproj::lab
