// Of selfproj.calibration: a camera alone, and the plane of a laser.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/laser_plane.h"
#include "host/images/image_files.h"
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
    return LaserResult{camera, calibration::laser_plane(report, lines)};
  });
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
      .def("__repr__", [](const CameraResult& self) {
        return "CameraResult(rms_px=" + std::to_string(self.report->model.result.camera_rms) + ")";
      });
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
      .def("__repr__", [](const LaserResult& self) {
        return "LaserPlane(points=" + std::to_string(self.laser.points) +
               ", rms_mm=" + std::to_string(self.laser.rms_mm) + ")";
      });
  module.def("laser_plane", &laser_of, nb::arg("camera"), nb::arg("images").noconvert(), nb::arg("threshold") = 40,
             nb::arg("channel") = "", nb::arg("shift") = nb::none(),
             "The plane of a laser from its line on the chessboard: one image of each pose of the camera's images, in\n"
             "the same order. threshold: the line is brighter. InputError if the line is found on fewer than three.");
}

}  // namespace selfproj::python
