// Of selfproj.calibration: a camera alone, the plane of a laser, and the belt before them.
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <string_view>
#include <tuple>
#include <utility>
#include <vector>

#include "host/calibration/belt.h"
#include "host/calibration/laser_plane.h"
#include "host/images/image_files.h"
#include "host/production/height_map.h"
#include "python/bindings/arrays.h"
#include "python/bindings/chessboards.h"
#include "python/bindings/images_input.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"

namespace selfproj::python {
namespace {

// A camera, and what else its laser needs of it.
struct CameraResult {
  std::shared_ptr<const calibration::CameraReport> report;
  [[nodiscard]] rig::Lens lens() const { return calibration::lens_of(report->model.result.bundle.camera); }
};

struct LaserResult {
  CameraResult camera;
  calibration::LaserPlane laser;
};

CameraResult calibrate_camera_alone(const ImagesArgument& images, const Size& corners, double square_mm, int distortion,
                                    bool bent, const std::string& channel, std::optional<int> shift) {
  calibration::CameraSettings settings;
  settings.chessboard = chessboard_of(corners, square_mm);
  require(distortion >= -1 && distortion <= 5 && distortion != 3,
          "distortion: must be -1 (by the data), 0, 1, 2, 4 or 5");
  settings.distortion = distortion;
  settings.bent = bent;
  const GivenImages given(images, {channel, shift});
  return without_gil([&] {
    images::ImageSequence sequence = given.sequence();
    std::vector<calibration::BoardImage> boards;
    for (std::size_t i = 0; i < given.count(); ++i) {
      boards.push_back(calibration::observe_board(given.names()[i], sequence.read(i), settings.chessboard));
    }
    auto report =
        std::make_shared<calibration::CameraReport>(calibration::calibrate_camera(std::move(boards), settings));
    if (!report->model.refusal.empty()) {
      throw UserError("images", report->model.refusal);
    }
    return CameraResult{std::move(report)};
  });
}

LaserResult laser_of(const CameraResult& camera, const ImagesArgument& images, int threshold,
                     const std::string& channel, std::optional<int> shift) {
  require(threshold >= 0 && threshold <= 255, "threshold: must be in 0..255");
  const GivenImages given(images, {channel, shift});
  require(given.count() == camera.report->images.size(),
          "images: one of each pose of the camera's images is needed, in the same order");
  return without_gil([&] {
    std::vector<images::Image> lines;
    images::ImageSequence sequence = given.sequence();
    for (std::size_t i = 0; i < given.count(); ++i) {
      lines.push_back(sequence.read(i));
    }
    const calibration::BoardImage& first = camera.report->images.front();
    require(lines.front().rows == first.rows && lines.front().columns == first.columns,
            "images: their size is not that of the camera's images");
    calibration::CameraReport report = *camera.report;
    report.settings.threshold = threshold;
    try {
      return LaserResult{camera, calibration::laser_plane(report, lines)};
    } catch (const UserError& error) {
      const std::string text = error.what();
      constexpr std::string_view kOption = "--laser: ";  // the images of the command
      throw UserError("images", text.starts_with(kOption) ? text.substr(kOption.size()) : text);
    }
  });
}

// One value for each image, ascending, or none.
void check_values(const std::vector<double>& values, std::size_t images, const char* text) {
  require(values.empty() || (values.size() == images &&
                             std::adjacent_find(values.begin(), values.end(), std::greater_equal<>()) == values.end()),
          text);
}

// The images of an argument, each as large as those of the rig's camera.
template <typename Take>
void for_each_image(const rig::Rig& rig, const GivenImages& given, const Take& take) {
  images::ImageSequence sequence = given.sequence();
  for (std::size_t i = 0; i < given.count(); ++i) {
    const images::Image image = sequence.read(i);
    if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
      throw UserError(given.names()[i], "has not the size of the rig's camera");
    }
    take(i, image);
  }
}

calibration::BeltCalibration belt_of(const rig::Rig& rig, const ImagesArgument& images, const Size& corners,
                                     double square_mm, double thickness_mm, const std::vector<double>& moves,
                                     const std::vector<double>& counts, const std::vector<double>& seconds,
                                     const std::optional<ImagesArgument>& laser, std::vector<double> heights,
                                     int threshold, double scale_tolerance, double height_tolerance,
                                     const std::string& channel, std::optional<int> shift) {
  require(rig.kind == rig::RigKind::light_section, "rig: must be of kind light-section");
  require(!rig.heights, "rig: has corrected heights, which hold for its belt_pose; find the belt before them");
  require(!laser || rig.light_plane, "laser: is for a rig with a laser; fit_heights is for a projector");
  require(thickness_mm >= 0 && scale_tolerance > 0 && height_tolerance > 0,
          "scale_tolerance, height_tolerance_mm: must be above 0, thickness_mm 0 or more");
  require(threshold >= 0 && threshold <= 255, "threshold: must be in 0..255");
  const GivenImages given(images, {channel, shift});
  require(given.count() >= 2, "images: the chessboard is needed at two or more places of the belt");
  check_values(moves, given.count(), "moves_mm: one for each image is needed, in ascending order");
  check_values(counts, given.count(), "counts: one for each image is needed, in ascending order");
  check_values(seconds, given.count(), "seconds: one for each image is needed, in ascending order");
  std::optional<GivenImages> of_laser;
  if (laser) {
    of_laser.emplace(*laser, images::PixelOptions{channel, shift});
    heights = heights.empty() && of_laser->count() == 1 ? std::vector<double>{0} : heights;
  }
  require(heights.size() == (of_laser ? of_laser->count() : 0) && (heights.empty() || heights.front() == 0),
          "heights_mm: one for each image of the laser is needed, ascending from 0, that of the empty belt");
  check_values(heights, heights.size(), "heights_mm: must be in ascending order");
  calibration::BeltSettings settings;
  settings.chessboard = chessboard_of(corners, square_mm);
  settings.thickness_mm = thickness_mm;
  settings.moves_mm = moves;
  settings.counts = counts;
  settings.seconds = seconds;
  settings.scale_tolerance = scale_tolerance;
  settings.height_tolerance = height_tolerance;
  return without_gil([&] {
    std::vector<calibration::BoardImage> boards;
    for_each_image(rig, given, [&](std::size_t i, const images::Image& image) {
      boards.push_back(calibration::observe_board(given.names()[i], image, settings.chessboard));
    });
    std::vector<calibration::LineAtHeight> lines;
    if (of_laser) {
      for_each_image(rig, *of_laser, [&](std::size_t i, const images::Image& image) {
        lines.push_back({of_laser->names()[i], heights[i], calibration::line_centres(image, threshold)});
      });
    }
    calibration::BeltCalibration belt = calibration::calibrate_belt(rig, boards, lines, settings);
    if (!belt.rig.parts) {
      belt.rig.parts = production::usual_parts(belt.rig, !counts.empty() || seconds.empty());
    }
    return belt;
  });
}

using NamedFigures = std::map<std::string, double>;

// All numbers of a camera that its laser needs. visit(number) may change it.
template <class Bundle, class Visit>
void visit_camera(Bundle& bundle, const Visit& visit) {
  std::for_each(bundle.camera.begin(), bundle.camera.end(), visit);
  std::for_each(bundle.shape.begin(), bundle.shape.end(), visit);
  visit(bundle.noise.bend), visit(bundle.noise.stretch);
  for (auto& pose : bundle.chessboard) {
    for (int i = 0; i < 3; ++i) {
      visit(pose.rotation[i]), visit(pose.translation[i]);
    }
  }
}

// Corners and sides of squares of the chessboard, whether it may be bent; rows and columns of the images; their names,
// and why they were left out; the numbers of those that were not; all numbers, and the residual.
using CameraState = std::tuple<Size, double, bool, Size, std::vector<std::pair<nb::bytes, std::string>>,
                               std::vector<std::size_t>, std::vector<double>, double>;

CameraState state_of_camera(const CameraResult& self) {
  const calibration::CameraReport& report = *self.report;
  const calibration::Chessboard& board = report.settings.chessboard;
  std::vector<std::pair<nb::bytes, std::string>> images;
  for (const calibration::BoardImage& image : report.images) {
    images.emplace_back(pickled_name(image.name), image.reason);
  }
  std::vector<double> numbers;
  visit_camera(report.model.result.bundle, [&](double value) { numbers.push_back(value); });
  return {{board.columns, board.rows},
          board.square_mm,
          report.settings.bent,
          {report.images.front().rows, report.images.front().columns},
          images,
          report.image_of_view,
          numbers,
          report.model.result.camera_rms};
}

void set_camera(CameraResult& self, const CameraState& state) {
  const auto& [corners, square_mm, bent, size, images, used, numbers, rms] = state;
  auto report = std::make_shared<calibration::CameraReport>();
  report->settings.chessboard = chessboard_of(corners, square_mm);
  report->settings.bent = bent;
  if (bent) {
    report->shape = calibration::board_modes(report->settings.chessboard);
  }
  for (const auto& [name, reason] : images) {
    calibration::BoardImage& image = report->images.emplace_back();
    image.name = name_of(name);
    image.reason = reason;
    image.rows = size.first;
    image.columns = size.second;
  }
  require(std::all_of(used.begin(), used.end(), [&](std::size_t i) { return i < report->images.size(); }),
          "state: is none of a CameraResult");
  report->image_of_view = used;
  report->model.result.camera_rms = rms;
  calibration::Bundle& bundle = report->model.result.bundle;
  bundle.chessboard.resize(used.size());
  std::size_t next = 0;
  visit_camera(bundle, [&](double& value) {
    require(next < numbers.size(), "state: is none of a CameraResult");
    value = numbers[next++];
  });
  new (&self) CameraResult{std::move(report)};
}

using LaserState = std::tuple<CameraResult, std::array<double, 3>, std::array<double, 4>, std::array<std::size_t, 3>>;

LaserState state_of_laser(const LaserResult& self) {
  const calibration::LaserPlane& laser = self.laser;
  return {self.camera,
          laser.plane.normal,
          {laser.plane.distance_mm, laser.rms_mm, laser.turn_sd_deg, laser.shift_sd_mm},
          {laser.images, laser.points, laser.left_out}};
}

void set_laser(LaserResult& self, const LaserState& state) {
  const auto& [camera, normal, numbers, counts] = state;
  new (&self) LaserResult{camera,
                          {.plane = {normal, numbers[0]},
                           .images = counts[0],
                           .points = counts[1],
                           .left_out = counts[2],
                           .rms_mm = numbers[1],
                           .turn_sd_deg = numbers[2],
                           .shift_sd_mm = numbers[3]}};
}

// Places and heights have names, and numbers in the order of their members.
using PlaceState = std::tuple<nb::bytes, std::array<double, 2>>;
using HeightState = std::tuple<nb::bytes, std::array<double, 3>, std::size_t>;
using BeltState = std::tuple<rig::Rig, std::vector<PlaceState>, std::vector<HeightState>, std::array<double, 9>>;

BeltState state_of_belt(const calibration::BeltCalibration& self) {
  std::vector<PlaceState> places;
  for (const calibration::BeltPlace& place : self.places) {
    places.emplace_back(pickled_name(place.name), std::array{place.along_mm, place.rms_px});
  }
  std::vector<HeightState> heights;
  for (const calibration::BeltCalibration::Height& height : self.heights) {
    heights.emplace_back(pickled_name(height.name), std::array{height.height_mm, height.mean_mm, height.rms_mm},
                         height.points);
  }
  return {self.rig,
          places,
          heights,
          {self.rms_px, self.distance_sd_mm, self.normal_sd_deg, self.direction_sd_deg, self.way, self.spread_mm,
           self.zero_mm, self.zero_turn_deg, self.light_turn_deg}};
}

void set_belt(calibration::BeltCalibration& self, const BeltState& state) {
  const auto& [rig, places, heights, n] = state;
  new (&self) calibration::BeltCalibration{rig, {}, n[0], n[1], n[2], n[3], n[4], n[5], n[6], n[7], n[8], {}};
  for (const auto& [name, numbers] : places) {
    self.places.push_back({name_of(name), numbers[0], numbers[1]});
  }
  for (const auto& [name, numbers, points] : heights) {
    self.heights.push_back({name_of(name), numbers[0], numbers[1], numbers[2], points});
  }
}

void bind_belt(nb::module_& module) {
  using calibration::BeltCalibration;
  nb::class_<BeltCalibration>(module, "BeltResult", "How a belt lies before a calibrated camera, and how it moves.")
      .def_prop_ro(
          "rig", [](const BeltCalibration& self) { return self.rig; },
          "The rig with its belt, and with a section `parts` if it had none.")
      .def_prop_ro(
          "along_mm",
          [](const BeltCalibration& self) {
            std::vector<double> along;
            for (const calibration::BeltPlace& place : self.places) {
              along.push_back(place.along_mm);
            }
            return along;
          },
          "How far the chessboard has moved since the first image, at each of them.")
      .def_ro("rms_px", &BeltCalibration::rms_px, "Of the corners.")
      .def_ro("distance_sd_mm", &BeltCalibration::distance_sd_mm, "Standard deviation of plane_z_mm.")
      .def_ro("normal_sd_deg", &BeltCalibration::normal_sd_deg, "Of the belt's normal.")
      .def_ro("direction_sd_deg", &BeltCalibration::direction_sd_deg, "Of the way that it moves.")
      .def_ro("max_uneven_mm", &BeltCalibration::spread_mm,
              "Greatest distance of a place from an even way by moves_mm, counts or seconds.")
      .def_ro("zero_before_mm", &BeltCalibration::zero_mm, "What the laser saw of the belt before it became 0.")
      .def_prop_ro(
          "heights",
          [](const BeltCalibration& self) {
            std::vector<NamedFigures> heights;
            for (const BeltCalibration::Height& height : self.heights) {
              heights.push_back({{"height_mm", height.height_mm},
                                 {"mean_mm", height.mean_mm},
                                 {"rms_mm", height.rms_mm},
                                 {"points", static_cast<double>(height.points)}});
            }
            return heights;
          },
          "Of each image of the laser, measured by the new rig: height_mm, mean_mm, rms_mm, points.")
      .def("__repr__",
           [](const BeltCalibration& self) {
             return "BeltResult(places=" + std::to_string(self.places.size()) +
                    ", plane_z_mm=" + std::to_string(self.rig.plane_z_mm) + ")";
           })
      .def("__getstate__", &state_of_belt)
      .def("__setstate__", &set_belt);
  const calibration::BeltSettings usual;
  module.def(
      "calibrate_belt", &belt_of, nb::arg("rig"), nb::arg("images").noconvert(), nb::arg("corners"),
      nb::arg("square_mm"), nb::arg("thickness_mm") = 0.0, nb::arg("moves_mm") = std::vector<double>{},
      nb::arg("counts") = std::vector<double>{}, nb::arg("seconds") = std::vector<double>{},
      nb::arg("laser").noconvert() = nb::none(), nb::arg("heights_mm") = std::vector<double>{},
      nb::arg("threshold") = 40, nb::arg("scale_tolerance") = usual.scale_tolerance,
      nb::arg("height_tolerance_mm") = usual.height_tolerance, nb::arg("channel") = "", nb::arg("shift") = nb::none(),
      "Finds the belt of a rig whose lens is known, as `selfproj calibrate belt`: images of a chessboard flat on\n"
      "it at two or more places, in their order, with the places (moves_mm), the encoder's counts or the times\n"
      "(seconds) there. laser: images of the laser's line at heights_mm, the first on the empty belt, which\n"
      "becomes height 0. InputError if the images do not determine the belt, or contradict what is said.");
}

}  // namespace

void bind_lasers(nb::module_& module) {
  nb::class_<CameraResult>(module, "CameraResult", "A camera alone, from plain images of a chessboard.")
      .def_prop_ro(
          "matrix", [](const CameraResult& self) { return camera_matrix(self.lens()); }, nb::rv_policy::reference,
          "3 x 3, float64.")
      .def_prop_ro(
          "distortion", [](const CameraResult& self) { return distortion(self.lens()); }, nb::rv_policy::reference,
          "k1, k2, p1, p2, k3, k4, k5, k6 of OpenCV.")
      .def_prop_ro(
          "rms_px", [](const CameraResult& self) { return self.report->model.result.camera_rms; }, "Of all residuals.")
      .def_prop_ro(
          "left_out",
          [](const CameraResult& self) {
            std::vector<std::pair<std::string, std::string>> out;
            for (const calibration::BoardImage& image : self.report->images) {
              if (!image.reason.empty()) {
                out.emplace_back(image.name, image.reason);
              }
            }
            return out;
          },
          "Images that were left out: name and reason.")
      .def("__repr__",
           [](const CameraResult& self) {
             return "CameraResult(rms_px=" + std::to_string(self.report->model.result.camera_rms) + ")";
           })
      .def("__getstate__", &state_of_camera)
      .def("__setstate__", &set_camera);
  module.def("calibrate_camera", &calibrate_camera_alone, nb::arg("images").noconvert(), nb::arg("corners"),
             nb::arg("square_mm"), nb::arg("distortion") = -1, nb::arg("bent") = true, nb::arg("channel") = "",
             nb::arg("shift") = nb::none(),
             "The camera's lens from images of a chessboard in two or more poses: array, list of arrays, folder or\n"
             "files. bent: the shape of the chessboard is estimated. InputError if the images do not suffice.");
  nb::class_<LaserResult>(module, "LaserPlane", "The plane of a laser's light: normal . (x, y, z) = distance_mm.")
      .def_prop_ro(
          "normal", [](const LaserResult& self) { return self.laser.plane.normal; }, "Of length 1.")
      .def_prop_ro(
          "distance_mm", [](const LaserResult& self) { return self.laser.plane.distance_mm; },
          "From the camera's centre.")
      .def_prop_ro(
          "rms_mm", [](const LaserResult& self) { return self.laser.rms_mm; }, "Of the points' distances from it.")
      .def_prop_ro(
          "points", [](const LaserResult& self) { return self.laser.points; }, "Number of points of the line.")
      .def(
          "rig",
          [](const LaserResult& self, const rig::Rig& drawn) {
            return calibration::rig_of_laser(drawn, *self.camera.report, self.laser);
          },
          nb::arg("drawn"), "The rig of this camera and laser; belt and pixel pitch are those of the drawn one.")
      .def("__repr__",
           [](const LaserResult& self) {
             return "LaserPlane(points=" + std::to_string(self.laser.points) +
                    ", rms_mm=" + std::to_string(self.laser.rms_mm) + ")";
           })
      .def("__getstate__", &state_of_laser)
      .def("__setstate__", &set_laser);
  module.def("laser_plane", &laser_of, nb::arg("camera"), nb::arg("images").noconvert(), nb::arg("threshold") = 40,
             nb::arg("channel") = "", nb::arg("shift") = nb::none(),
             "The plane of a laser from its line on the chessboard: one image of each pose of the camera's images, in\n"
             "the same order. threshold: the line is brighter. InputError if the line is found on fewer than three.");
  bind_belt(module);
}

}  // namespace selfproj::python
