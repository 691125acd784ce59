#include "sim/scene/targets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "sim/scene/optics.h"
#include "sim/scene/random.h"

namespace selfproj::sim {

FlatPlate::FlatPlate(double height_mm, const TargetTolerance& tolerance, std::uint64_t seed) : height_(height_mm) {
  EvenNumbers random(seed);
  height_ += random.within(tolerance.height_mm);
  double sum = 0;
  for (std::size_t i = 0; i < waves_.size(); ++i) {
    constexpr double kTurn = 2 * std::numbers::pi;
    constexpr double kLongest = 800;  // mm; each wave is about half as long as the one before
    constexpr double kShrink = 0.53;
    const double length = kLongest * std::pow(kShrink, static_cast<double>(i));
    const double direction = kTurn * random.next();
    const double amplitude = 1 - 0.5 * random.next();
    waves_[i] = {amplitude, kTurn / length * std::cos(direction), kTurn / length * std::sin(direction),
                 kTurn * random.next()};
    sum += amplitude;
  }
  for (Wave& wave : waves_) {
    wave.amplitude *= tolerance.flatness_mm / 2 / sum;
  }
}

double FlatPlate::height(double x, double y, double /*t*/) const {
  double height = height_;
  for (const Wave& w : waves_) {
    height += w.amplitude * std::cos(w.along_x * x + w.along_y * y + w.phase);
  }
  return height;
}

HeightRange FlatPlate::range(const Box& box, double t0, double /*t1*/) const {
  const double dx = (box.x1 - box.x0) / 2;
  const double dy = (box.y1 - box.y0) / 2;
  const double middle = height((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, t0);
  double reach = 0;  // the height's greatest change from the middle
  double all = 0;
  for (const Wave& w : waves_) {
    const double amplitude = std::abs(w.amplitude);
    reach += amplitude * std::min(2.0, std::abs(w.along_x) * dx + std::abs(w.along_y) * dy);
    all += amplitude;
  }
  return {std::max(middle - reach, height_ - all), std::min(middle + reach, height_ + all)};
}

Smoothness FlatPlate::smoothness(const Box& /*box*/) const {
  Smoothness bounds{0, 0, 0};
  for (const Wave& w : waves_) {
    const double k = std::hypot(w.along_x, w.along_y);
    const double amplitude = std::abs(w.amplitude);
    bounds.slope += amplitude * k;
    bounds.curvature += amplitude * k * k;
    bounds.change += amplitude * k * k * k;
  }
  return bounds;
}

StepBlock::StepBlock(std::vector<double> heights_mm, double tread_mm, double shift_mm, const TargetTolerance& tolerance,
                     std::uint64_t seed)
    : heights_(std::move(heights_mm)),
      tread_(tread_mm),
      begin_(shift_mm - tread_mm * static_cast<double>(heights_.size()) / 2) {
  EvenNumbers random(seed);
  for (double& height : heights_) {
    height += random.within(tolerance.height_mm);
  }
}

double StepBlock::height(double /*x*/, double y, double /*t*/) const {
  const double tread = std::floor((y - begin_) / tread_);
  return tread >= 0 && tread < static_cast<double>(heights_.size()) ? heights_[static_cast<std::size_t>(tread)] : 0;
}

HeightRange StepBlock::range(const Box& box, double /*t0*/, double /*t1*/) const {
  const auto count = static_cast<double>(heights_.size());
  const double first = std::clamp(std::floor((box.y0 - begin_) / tread_), -1.0, count);
  const double last = std::clamp(std::floor((box.y1 - begin_) / tread_), -1.0, count);
  HeightRange result{1e300, -1e300};
  for (double tread = first; tread <= last; ++tread) {
    result.join(tread >= 0 && tread < count ? heights_[static_cast<std::size_t>(tread)] : 0);
  }
  return result;
}

namespace {

constexpr double kRadians = std::numbers::pi / 180;

// The vector, turned about an axis of length 1 (Rodrigues).
Point3 turned(Point3 v, Point3 axis, double angle) {
  const double c = std::cos(angle);
  const double s = std::sin(angle);
  return c * v + s * cross(axis, v) + ((1 - c) * dot(axis, v)) * axis;
}

// Checks whether camera and projector see the whole board, and so many squares beyond the outermost corners. A laser
// must cross most of it instead, if it is to be lit.
class Visible {
 public:
  enum class Light : std::uint8_t { needed, not_needed };
  Visible(const PerturbedRig& actual, const ChessboardShape& shape, double margin, Light light = Light::needed)
      : actual_(actual), shape_(shape), margin_(margin), light_(light) {}

  [[nodiscard]] bool operator()(const ChessboardPlace& place) const {
    const bool laser = actual_.rig.light_plane.has_value();
    if (laser && light_ == Light::needed && !crossed(place)) {
      return false;
    }
    for (const double side : {-1.0, 1.0}) {
      for (const double end : {-1.0, 1.0}) {
        const Point3 p = place.middle + side * shape_.square_mm * ((shape_.across - 1) / 2.0 + margin_) * place.right +
                         end * shape_.square_mm * ((shape_.down - 1) / 2.0 + margin_) * place.below;
        const rig::Rig& rig = actual_.rig;
        if (!inside(actual_.camera, p, rig.camera.rows, rig.camera.columns) ||
            (!laser && !inside(actual_.projector, p, rig.projector.lines, rig.projector.columns))) {
          return false;
        }
      }
    }
    return true;
  }

 private:
  static bool inside(const Pinhole& pinhole, Point3 p, int rows, int columns) {
    if (!(pinhole.depth(p) > 0)) {
      return false;
    }
    const PixelPoint at = pinhole.project(p);
    return at.row >= 0 && at.row <= rows - 1 && at.column >= 0 && at.column <= columns - 1;
  }

  // Whether the laser's plane has corners of the inner part of the board on both of its sides.
  [[nodiscard]] bool crossed(const ChessboardPlace& place) const {
    constexpr double kInner = 0.6;
    double least = 0;
    double most = 0;
    for (const double right : {-kInner, kInner}) {
      for (const double below : {-kInner, kInner}) {
        const Point3 p = place.middle + shape_.square_mm * (shape_.across - 1) / 2.0 * right * place.right +
                         shape_.square_mm * (shape_.down - 1) / 2.0 * below * place.below;
        const double off = dot(actual_.projector.axes()[0], p - actual_.projector.centre());
        least = std::min(least, off);
        most = std::max(most, off);
      }
    }
    return least < 0 && most > 0;
  }

  const PerturbedRig& actual_;
  const ChessboardShape& shape_;
  double margin_;
  Light light_;
};

// A board that faces the camera, turned about its normal and then tilted about an axis in its plane, in degrees but for
// the direction of the axis.
ChessboardPlace leaning(Point3 middle, double turn_deg, double axis_direction, double tilt_deg) {
  ChessboardPlace place;
  place.middle = middle;
  const Point3 normal{0, 0, 1};
  const Point3 axis = turned({1, 0, 0}, normal, axis_direction);
  for (Point3* side : {&place.right, &place.below}) {
    *side = turned(turned(*side, normal, turn_deg * kRadians), axis, tilt_deg * kRadians);
  }
  return place;
}

}  // namespace

ChessboardFlaws drawn_flaws(double scale, double bend_mm, std::uint64_t seed) {
  EvenNumbers random(seed);
  ChessboardFlaws flaws;
  flaws.across_scale = 1 + random.within(scale);
  flaws.down_scale = 1 + random.within(scale);
  for (double& bend : flaws.bend_mm) {
    bend = random.within(bend_mm);
  }
  return flaws;
}

ChessboardScene::ChessboardScene(const rig::Rig& rig, const ChessboardShape& shape, const ChessboardPlace& place,
                                 const ChessboardFlaws& flaws)
    : shape_(shape),
      place_(place),
      flaws_(flaws),
      bent_(flaws.bend_mm != std::array<double, 3>{}),
      normal_(cross(place.right, place.below)),
      plane_z_(rig.plane_z_mm),
      edge_(place.middle.z * rig.camera.pixel_pitch_mm / (rig.camera.focal_length_mm * kSubPixels * shape.square_mm)) {
  const Point3 normal = normal_;
  constexpr double kLeast = 0.17;  // cosine of 80 degrees
  if (!(std::abs(normal.z) > kLeast)) {
    throw std::invalid_argument("chessboard: too steep");
  }
  dx_ = -normal.x / normal.z;
  dy_ = -normal.y / normal.z;
  // The slope of the bend over the board's plane is at most `slope`; in z it is that by the cosine squared, and twice
  // that leaves room for how a sloped surface meets a vertical line.
  double slope = 0;
  for (const double part : flaws.bend_mm) {
    slope += 2 * std::abs(part) / (shape.square_mm * std::min(shape.across, shape.down) / 2);
  }
  steepest_bend_ = 2 * slope / (normal.z * normal.z);
}

double ChessboardScene::bend(double right, double below) const {
  const double u = std::clamp(right / (shape_.square_mm * shape_.across / 2), -1.0, 1.0);
  const double v = std::clamp(below / (shape_.square_mm * shape_.down / 2), -1.0, 1.0);
  return flaws_.bend_mm[0] * u * u + flaws_.bend_mm[1] * u * v + flaws_.bend_mm[2] * v * v;
}

double ChessboardScene::height(double x, double y, double /*t*/) const {
  const double level = place_.middle.z + dx_ * (x - place_.middle.x) + dy_ * (y - place_.middle.y);
  double z = level;
  constexpr int kSteps = 8;  // each takes away more than nine tenths of the error
  for (int i = 0; bent_ && i < kSteps; ++i) {
    const Point3 from = Point3{x, y, z} - place_.middle;
    const double next = level + bend(dot(from, place_.right), dot(from, place_.below)) / normal_.z;
    if (next == z) {
      break;  // and stays so
    }
    z = next;
  }
  return plane_z_ - z;
}

HeightRange ChessboardScene::range(const Box& box, double t0, double /*t1*/) const {
  const double middle = height((box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2, t0);
  const double half = 0.5 * ((std::abs(dx_) + steepest_bend_) * (box.x1 - box.x0) +
                             (std::abs(dy_) + steepest_bend_) * (box.y1 - box.y0));
  return {middle - half, middle + half};
}

ChessboardScene::Part ChessboardScene::part_in(const Box& box) const {
  double slack = 0;  // what the bend moves a place on the board, seen along z, at most
  for (const double part : flaws_.bend_mm) {
    slack += std::abs(part) / std::abs(normal_.z);
  }
  constexpr double kFar = std::numeric_limits<double>::infinity();
  Part part{kFar, -kFar, kFar, -kFar};
  for (const double x : {box.x0, box.x1}) {
    for (const double y : {box.y0, box.y1}) {
      const double z = place_.middle.z + dx_ * (x - place_.middle.x) + dy_ * (y - place_.middle.y);
      const Point3 from = Point3{x, y, z} - place_.middle;
      const double right = dot(from, place_.right);
      const double below = dot(from, place_.below);
      part = {std::min(part.right_0, right - slack), std::max(part.right_1, right + slack),
              std::min(part.below_0, below - slack), std::max(part.below_1, below + slack)};
    }
  }
  return part;
}

// The bend ends with a kink at the middles of the outermost squares.
Smoothness ChessboardScene::smoothness(const Box& box) const {
  Smoothness bounds;
  bounds.slope = std::hypot(dx_, dy_) + steepest_bend_;
  const Part part = part_in(box);
  const double half_right = shape_.square_mm * shape_.across / 2;
  const double half_below = shape_.square_mm * shape_.down / 2;
  const auto has_kink = [](double low, double high, double half) {
    return (low <= half && high >= half) || (low <= -half && high >= -half);
  };
  if (bent_ && (has_kink(part.right_0, part.right_1, half_right) || has_kink(part.below_0, part.below_1, half_below))) {
    return bounds;
  }
  const double least = std::min(half_right, half_below);
  double curvature = 0;  // over the board's plane
  for (const double b : flaws_.bend_mm) {
    curvature += 2 * std::abs(b) / (least * least);
  }
  constexpr double kRoom = 2;  // for how z turns with the slope
  bounds.curvature = kRoom * curvature / std::abs(normal_.z * normal_.z * normal_.z);
  bounds.change = kRoom * bounds.curvature * bounds.curvature;
  return bounds;
}

// Beside the board, or within one of its squares.
bool ChessboardScene::is_plain(const Box& box) const {
  const Part part = part_in(box);
  const double across = shape_.square_mm * flaws_.across_scale;
  const double down = shape_.square_mm * flaws_.down_scale;
  const std::array<double, 2> a{part.right_0 / across + (shape_.across - 1) / 2.0,
                                part.right_1 / across + (shape_.across - 1) / 2.0};
  const std::array<double, 2> d{part.below_0 / down + (shape_.down - 1) / 2.0,
                                part.below_1 / down + (shape_.down - 1) / 2.0};
  const auto beside = [&](const std::array<double, 2>& at, int corners) {
    return at[1] <= -1 - edge_ || at[0] >= corners + edge_;
  };
  const auto between_edges = [&](const std::array<double, 2>& at) {
    return std::floor(at[0] - edge_) == std::floor(at[1] + edge_);
  };
  return beside(a, shape_.across) || beside(d, shape_.down) || (between_edges(a) && between_edges(d));
}

double ChessboardScene::albedo(double x, double y, double t) const {
  const Point3 from = Point3{x, y, plane_z_ - height(x, y, t)} - place_.middle;
  const double across = dot(from, place_.right) / (shape_.square_mm * flaws_.across_scale) +
                        (shape_.across - 1) / 2.0;  // 0 at the first corner
  const double down = dot(from, place_.below) / (shape_.square_mm * flaws_.down_scale) + (shape_.down - 1) / 2.0;
  // Alternates between 1 and -1 from edge to edge.
  const auto sign = [&](double at) {
    const double edge = std::round(at);
    const double value = std::clamp(2 * (at - edge) / edge_, -1.0, 1.0);
    return std::fmod(std::abs(edge), 2) == 0 ? value : -value;
  };
  // The share within the board, whose first and last edges are at -1 and `corners`.
  const auto within = [&](double at, int corners) {
    return std::clamp(std::min(at + 1, corners - at) / edge_ + 0.5, 0.0, 1.0);
  };
  const double black =
      0.5 * (1 + sign(across) * sign(down)) * within(across, shape_.across) * within(down, shape_.down);
  return 1 - (1 - kBlack) * black;
}

std::vector<ChessboardPlace> places_on_plates(const PerturbedRig& actual, const ChessboardShape& shape,
                                              const PlateVisits& visits, const PlateFlaws& flaws, std::uint64_t seed) {
  constexpr std::uint64_t kOwn = 0x9e3779b97f4a7c15;  // other numbers than those of the board's flaws
  EvenNumbers random(seed ^ kOwn);
  const Visible visible(actual, shape, 1, Visible::Light::not_needed);
  const double plane = actual.rig.plane_z_mm;
  const Point3 aim = middle_of_view(actual, plane);
  const auto [first, last] = std::minmax_element(visits.belt_mm.begin(), visits.belt_mm.end());
  const double side = shape.square_mm * (std::max(shape.across, shape.down) - 1);
  std::vector<ChessboardPlace> places;
  for (const double height : visits.heights_mm) {
    ChessboardPlace place;
    const double turn = random.within(flaws.fence_mm) / side;
    const double lean_x = random.within(flaws.parallel_mm) / side;
    const double lean_y = random.within(flaws.parallel_mm) / side;
    for (Point3* along : {&place.right, &place.below}) {
      *along = turned(turned(turned(*along, {0, 0, 1}, turn), {1, 0, 0}, lean_x), {0, 1, 0}, lean_y);
    }
    place.middle = aim + Point3{random.within(flaws.fence_mm), random.within(flaws.fence_mm),
                                random.within(flaws.height_mm) - height};
    for (const double belt : visits.belt_mm) {
      ChessboardPlace moved = place;
      moved.middle.x += belt - (*first + *last) / 2;
      if (!visible(moved)) {
        throw UserError("--chessboard", fmt::format("camera and projector do not both see all of it at {:g} mm, with "
                                                    "the belt at {:g} mm; give smaller squares or fewer of them",
                                                    height, belt));
      }
      places.push_back(moved);
    }
  }
  return places;
}

std::vector<ChessboardPlace> chessboard_places(const PerturbedRig& actual, const ChessboardShape& shape, int count,
                                               double tilt_deg) {
  constexpr double kTurn = 12;  // degrees about the normal, to either side
  constexpr double kMinShare = 0.1;
  // Share of the distance, nearer and further away. The plane of a laser needs more of it.
  const double depth = actual.rig.light_plane ? 0.1 : 0.06;
  const rig::Rig& rig = actual.rig;
  const Visible visible(actual, shape, 2);
  std::vector<ChessboardPlace> places;
  for (int k = 0; k < count; ++k) {
    ChessboardPlace place;
    place.middle = middle_of_view(actual, rig.plane_z_mm);
    // The leaning directions go round, while the places shift across them, so that every part of the image gets all of
    // them.
    const double lean = 2 * std::numbers::pi * k / std::max(1, count - 1);
    if (k > 0) {
      // A long board in a narrow image cannot be turned or brought nearer as far.
      for (double share = 1; share > kMinShare; share /= 2) {
        const double z = rig.plane_z_mm * (1 + share * depth * (k % 3 - 1));
        place = leaning(middle_of_view(actual, z), share * kTurn * (k % 2 == 0 ? 1 : -1), lean, tilt_deg);
        if (visible(place)) {
          break;
        }
      }
    }
    if (!visible(place)) {
      throw UserError("--chessboard", fmt::format("camera and {} do not both see all of it in pose {}; give smaller "
                                                  "squares or fewer of them",
                                                  rig.light_plane ? "laser" : "projector", k + 1));
    }
    if (k > 0) {
      const double towards = 3 * lean + 0.5;
      const Point3 way{std::cos(towards), std::sin(towards), 0};
      double near = 0;
      double far = rig.plane_z_mm;
      constexpr int kHalvings = 30;
      for (int i = 0; i < kHalvings; ++i) {
        const double shift = (near + far) / 2;
        ChessboardPlace moved = place;
        moved.middle = moved.middle + shift * way;
        (visible(moved) ? near : far) = shift;
      }
      place.middle = place.middle + near * way;
    }
    places.push_back(place);
  }
  return places;
}

}  // namespace selfproj::sim
