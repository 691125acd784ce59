#include "sim/scene/perturbed_rig.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <numbers>

#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "sim/scene/random.h"

namespace selfproj::sim {
namespace {

// A vector of the calibration's axes (x along columns, y along rows) in the world's.
Point3 exchanged(Point3 v) { return {v.y, v.x, v.z}; }

Point3 unit(Point3 v) { return 1 / std::sqrt(dot(v, v)) * v; }

Pinhole pinhole_of(const rig::RigLens& lens, Point3 centre, const std::array<Point3, 3>& axes) {
  return {centre,
          axes,
          {lens.fy_px, lens.fx_px, lens.cy_px, lens.cx_px},
          BrownLens({lens.k1, lens.k2, lens.p1, lens.p2, lens.k3})};
}

Pinhole camera_of(const rig::Rig& rig) {
  if (!rig.calibration) {
    return Pinhole::of_camera(rig.camera);
  }
  return pinhole_of(rig.calibration->camera, {}, {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}});
}

// x_projector = R x_camera + T, so that the rows of R are the projector's axes: columns, rows, optical axis. Its centre
// is −Rᵀ T.
Pinhole projector_of(const rig::Rig& rig) {
  if (!rig.calibration) {
    return Pinhole::of_projector(rig.projector);
  }
  const std::array<double, 3>& v = rig.calibration->rotation_rad;
  const Point3 turn{v[0], v[1], v[2]};
  const double angle = std::sqrt(dot(turn, turn));
  // Row i of R is the unit vector i, turned about the same axis by the opposite angle.
  const auto row = [&](Point3 u) {
    if (angle == 0) {
      return u;
    }
    const Point3 axis = 1 / angle * turn;
    const double c = std::cos(angle);
    return c * u - std::sin(angle) * cross(axis, u) + (1 - c) * dot(axis, u) * axis;
  };
  const std::array<Point3, 3> rows{row({1, 0, 0}), row({0, 1, 0}), row({0, 0, 1})};
  const std::array<double, 3>& t = rig.calibration->translation_mm;
  const Point3 centre = -1 * (t[0] * rows[0] + t[1] * rows[1] + t[2] * rows[2]);
  return pinhole_of(rig.calibration->projector, exchanged(centre),
                    {exchanged(rows[1]), exchanged(rows[0]), exchanged(rows[2])});
}

// The belt's axes, along, across and away from the camera, in the camera's: rows, columns, optical axis.
std::array<Point3, 3> belt_of(const rig::Rig& rig) {
  if (!rig.belt_pose) {
    return {{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  }
  const auto& [direction, normal] = *rig.belt_pose;
  const Point3 z = unit(exchanged({normal[0], normal[1], normal[2]}));
  const Point3 given = exchanged({direction[0], direction[1], direction[2]});
  const Point3 x = unit(given - dot(given, z) * z);
  return {x, cross(z, x), z};
}

// The pinhole in the belt's axes.
Pinhole over_belt(const Pinhole& p, const std::array<Point3, 3>& belt) {
  const auto turned = [&](Point3 v) { return Point3{dot(belt[0], v), dot(belt[1], v), dot(belt[2], v)}; };
  const std::array<Point3, 3>& axes = p.axes();
  return {turned(p.centre()), {turned(axes[0]), turned(axes[1]), turned(axes[2])}, p.intrinsics(), p.lens()};
}

// What stands for a laser, and where the camera sees its light on the belt in the middle of its columns.
struct Laser {
  Pinhole projector;
  Point3 aim;
};

// As far away from there as the camera, square to the line on the belt, with pixels as large as the camera's.
Laser laser_of(const rig::Rig& rig, const Pinhole& camera, const std::array<Point3, 3>& belt) {
  const auto& n = rig.light_plane->normal;
  const Point3 in_camera = exchanged({n[0], n[1], n[2]});
  const Point3 normal{dot(belt[0], in_camera), dot(belt[1], in_camera), dot(belt[2], in_camera)};
  const double level = std::hypot(normal.x, normal.y);
  if (!(level > 1e-6)) {
    throw UserError(rig.name, "its light_plane is parallel to the belt");
  }
  Point3 along{-normal.y / level, normal.x / level, 0};  // the line on the belt
  along = (dot(along, camera.axes()[1]) < 0 ? -1.0 : 1.0) * along;
  const double off = (rig.light_plane->distance_mm - normal.z * rig.plane_z_mm) / (level * level);
  const Point3 on{off * normal.x, off * normal.y, rig.plane_z_mm};
  const Point3& across = camera.axes()[1];
  if (!(std::abs(dot(across, along)) > 1e-6)) {
    throw UserError(rig.name, "its laser's line does not cross the camera's columns");
  }
  const Point3 aim = on - (dot(across, on) / dot(across, along)) * along;
  if (!(camera.depth(aim) > 0)) {
    throw UserError(rig.name, "its laser's line on the belt is behind the camera");
  }
  Point3 up = cross(normal, along);
  up = (up.z > 0 ? -1.0 : 1.0) * up;
  const Pinhole::Intrinsics& k = camera.intrinsics();
  const double away = std::sqrt(dot(aim, aim));
  return {{aim + away * up,
           {normal, along, -1 * up},
           {k.row_scale, k.column_scale, double{kLaserLine}, rig.camera.columns - 0.5}},
          aim};
}

// The rig with the size of what stands for its laser.
rig::Rig with_laser(const rig::Rig& rig) {
  rig::Rig result = rig;
  if (rig.light_plane) {
    const double pitch = rig.camera.pixel_pitch_mm;
    result.projector = {.x_mm = 1,
                        .focal_length_mm = rig.camera.focal_length_mm,
                        .lines = kLaserLines,
                        .columns = 2 * rig.camera.columns,
                        .line_pitch_mm = pitch,
                        .column_pitch_mm = pitch};
  }
  return result;
}

Pinhole shifted(const Pinhole& p, Point3 by) { return {p.centre() + by, p.axes(), p.intrinsics(), p.lens()}; }

PerturbedRig as_it_stands(const rig::Rig& of) {
  if (!of.belt_pose && !of.light_plane) {
    return {of, camera_of(of), projector_of(of)};
  }
  const std::array<Point3, 3> belt = belt_of(of);
  const Pinhole camera = over_belt(camera_of(of), belt);
  if (of.light_plane) {
    const Laser laser = laser_of(of, camera, belt);
    const Point3 back{-laser.aim.x, -laser.aim.y, 0};
    return {with_laser(of), shifted(camera, back), shifted(laser.projector, back)};
  }
  const PerturbedRig there{of, camera, over_belt(projector_of(of), belt)};
  const Point3 aim = middle_of_view(there, of.plane_z_mm);
  const Point3 back{-aim.x, -aim.y, 0};
  return {of, shifted(there.camera, back), shifted(there.projector, back)};
}

Point3 turned_by(Point3 v, const std::array<double, 3>& angles) {
  const std::array<Point3, 3> axes{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};
  for (std::size_t i = 0; i < axes.size(); ++i) {
    const double c = std::cos(angles.at(i));
    const Point3 axis = axes.at(i);
    v = c * v + std::sin(angles.at(i)) * cross(axis, v) + (1 - c) * dot(axis, v) * axis;
  }
  return unit(v);
}

Pinhole perturbed(const Pinhole& nominal, const Perturbation& d) {
  const Pinhole::Intrinsics& k = nominal.intrinsics();
  const std::array<Point3, 3>& axes = nominal.axes();
  return {nominal.centre() + d.shift_mm,
          {turned_by(axes[0], d.rotation_rad), turned_by(axes[1], d.rotation_rad), turned_by(axes[2], d.rotation_rad)},
          {k.row_scale * d.focal_factor, k.column_scale * d.focal_factor, k.row_0 + d.row_centre_px,
           k.column_0 + d.column_centre_px},
          BrownLens(d.lens)};
}

Perturbation drawn_perturbation(EvenNumbers& random) {
  const auto within = [&](double bound) { return random.within(bound); };
  Perturbation d;
  for (double& angle : d.rotation_rad) {
    angle = within(kMaxRotationDeg * std::numbers::pi / 180);
  }
  d.shift_mm.x = within(kMaxShiftMm);
  d.shift_mm.y = within(kMaxShiftMm);
  d.shift_mm.z = within(kMaxShiftMm);
  d.focal_factor = 1 + within(kMaxFocal);
  d.row_centre_px = within(kMaxCentrePx);
  d.column_centre_px = within(kMaxCentrePx);
  d.lens.k1 = within(kMaxDistortion.k1);
  d.lens.k2 = within(kMaxDistortion.k2);
  d.lens.p1 = within(kMaxDistortion.p1);
  d.lens.p2 = within(kMaxDistortion.p2);
  return d;
}

}  // namespace

PerturbedRig::PerturbedRig(const rig::Rig& of) : PerturbedRig(as_it_stands(of)) {}

PerturbedRig::PerturbedRig(const rig::Rig& of, const Pinhole& its_camera, const Pinhole& its_projector)
    : rig(of), camera(its_camera), projector(its_projector) {}

Point3 middle_of_view(const PerturbedRig& actual, double z) {
  const rig::Rig& rig = actual.rig;
  std::array<double, 4> bounds{-1e9, 1e9, -1e9, 1e9};  // x, y
  const auto narrow = [&](const Pinhole& pinhole, int rows, int columns) {
    const auto on_plane = [&](double row, double column) {
      const Point3 ray = pinhole.ray({row, column});
      return pinhole.centre() + ((z - pinhole.centre().z) / ray.z) * ray;
    };
    const double x0 = on_plane(0, (columns - 1) / 2.0).x;
    const double x1 = on_plane(rows - 1, (columns - 1) / 2.0).x;
    const double y0 = on_plane((rows - 1) / 2.0, 0).y;
    const double y1 = on_plane((rows - 1) / 2.0, columns - 1).y;
    bounds = {std::max(bounds[0], std::min(x0, x1)), std::min(bounds[1], std::max(x0, x1)),
              std::max(bounds[2], std::min(y0, y1)), std::min(bounds[3], std::max(y0, y1))};
  };
  narrow(actual.camera, rig.camera.rows, rig.camera.columns);
  narrow(actual.projector, rig.projector.lines, rig.projector.columns);
  return {(bounds[0] + bounds[1]) / 2, (bounds[2] + bounds[3]) / 2, z};
}

PerturbedRig perturbed_rig(const rig::Rig& nominal, const Perturbation& camera, const Perturbation& projector) {
  return {nominal, perturbed(Pinhole::of_camera(nominal.camera), camera),
          perturbed(Pinhole::of_projector(nominal.projector), projector)};
}

PerturbedRig hidden_rig(const rig::Rig& nominal, std::uint64_t seed) {
  EvenNumbers random(seed);
  Perturbation camera = drawn_perturbation(random);
  Perturbation projector = drawn_perturbation(random);
  const Point3 aim = middle_of_view(perturbed_rig(nominal, camera, projector), nominal.plane_z_mm);
  const Point3 back{-aim.x, -aim.y, 0};
  camera.shift_mm = camera.shift_mm + back;
  projector.shift_mm = projector.shift_mm + back;
  return perturbed_rig(nominal, camera, projector);
}

}  // namespace selfproj::sim
