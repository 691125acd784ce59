// selfproj.calibration: captures of a chessboard under Gray codes, and the calibration that follows from them.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/calibration_output.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/files/output_file.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/image_sequence.h"
#include "python/bindings/arrays.h"
#include "selfproj/rig/calibration_file.h"

namespace selfproj::python {
namespace {

using Size = std::pair<int, int>;

// A matrix of OpenCV as an array.
template <int Rows, int Columns>
Out<double> array_of_matrix(const cv::Matx<double, Rows, Columns>& matrix) {
  const std::vector<std::size_t> shape =
      Columns == 1 ? std::vector<std::size_t>{Rows} : std::vector<std::size_t>{Rows, Columns};
  auto array = new_array<double>(shape);
  std::memcpy(array.data(), matrix.val, sizeof matrix.val);
  return array;
}

Out<double> camera_matrix(const rig::Lens& lens) {
  return array_of_matrix(cv::Matx33d(lens.fx, 0, lens.cx, 0, lens.fy, lens.cy, 0, 0, 1));
}

Out<double> distortion(const rig::Lens& lens) {
  auto array = new_array<double>({lens.k.size()});
  std::memcpy(array.data(), lens.k.data(), sizeof lens.k);
  return array;
}

// Codes of both axes, moved into arrays; and the mean image.
struct CaptureResult {
  calibration::Capture capture;  // without what the arrays took
  std::string name;
  Out<std::int16_t> projector_column, projector_row;
  Out<std::uint8_t> mean;
};

CaptureResult decode(const std::vector<std::string>& images, const Size& projector, int threshold, int contrast,
                     const std::string& channel) {
  const structured_light::GraySequence sequence(projector.first, projector.second);
  require(threshold >= 0 && threshold <= 255 && contrast >= 0 && contrast <= 255,
          "threshold, contrast: must be in 0..255");
  require(!images.empty(), "images: none are given");
  calibration::Capture capture = without_gil([&] {
    images::ImageSequence captured(images::image_arguments(images), images::channel_of(channel));
    return calibration::decode_capture(images.front(), captured, sequence,
                                       {.threshold = threshold, .contrast = contrast});
  });
  const std::vector<std::size_t> shape{static_cast<std::size_t>(capture.rows),
                                       static_cast<std::size_t>(capture.columns)};
  auto column = array_of(capture.projector_column, shape);
  auto row = array_of(capture.projector_row, shape);
  auto mean = array_of(capture.mean.pixels, shape);
  return {std::move(capture), images.front(), std::move(column), std::move(row), std::move(mean)};
}

calibration::Chessboard chessboard_of(const Size& corners, double square_mm) {
  require(corners.first >= 3 && corners.second >= 3 && corners.first <= 200 && corners.second <= 200,
          "corners: must be 3..200 along both sides");
  require(square_mm > 0 && square_mm < 1e6, "square_mm: must be above 0");
  return {.columns = corners.first, .rows = corners.second, .square_mm = square_mm};
}

std::optional<Out<double>> find_corners(const In<std::uint8_t>& array, const Size& corners) {
  const model::ImageView view = image_of(array);
  const calibration::Chessboard chessboard = chessboard_of(corners, 1);
  require(view.rows > 0 && view.columns > 0, "image: has no pixels");
  const calibration::FoundChessboard found =
      without_gil([&] { return calibration::find_chessboard(images::copy_of(view), chessboard); });
  if (found.corners.empty()) {
    return std::nullopt;
  }
  auto places = new_array<double>({found.corners.size(), 2});
  for (std::size_t i = 0; i < found.corners.size(); ++i) {
    places.data()[2 * i] = found.corners[i].x;
    places.data()[2 * i + 1] = found.corners[i].y;
  }
  return places;
}

struct Result {
  calibration::CalibrationReport report;
  [[nodiscard]] rig::CalibrationRms rms() const {
    return {report.bundle.camera_rms, report.bundle.projector_rms, report.bundle.rms};
  }
};

Result calibrate_captures(const std::vector<const CaptureResult*>& captures, const Size& corners, double square_mm,
                          const Size& projector, int camera_distortion, int projector_distortion) {
  calibration::CalibrateSettings settings;
  settings.chessboard = chessboard_of(corners, square_mm);
  require(projector.first >= 1 && projector.second >= 1, "projector: its sides must be 1 or more");
  settings.projector_columns = projector.first;
  settings.projector_rows = projector.second;
  settings.free = {camera_distortion, projector_distortion};
  for (const int free : {camera_distortion, projector_distortion}) {
    require((free >= -1 && free <= 5 && free != 3), "distortion: must be -1 (by the data), 0, 1, 2, 4 or 5");
  }
  for (const CaptureResult* capture : captures) {
    require(capture != nullptr, "captures: None is no capture");
  }
  return without_gil([&] {
    std::vector<calibration::PoseReport> poses;
    for (const CaptureResult* capture : captures) {
      poses.push_back(calibration::observe_pose(capture->name, capture->capture, settings));
    }
    return Result{calibration::calibrate(std::move(poses), settings)};
  });
}

void bind_result(nb::module_& module) {
  nb::class_<rig::Calibration>(module, "Calibration",
                               "Camera and projector. In the camera's frame and in mm, x_projector = R x_camera + T.")
      .def_prop_ro(
          "camera_matrix", [](const rig::Calibration& self) { return camera_matrix(self.camera); },
          nb::rv_policy::reference, "3 x 3, float64.")
      .def_prop_ro(
          "camera_distortion", [](const rig::Calibration& self) { return distortion(self.camera); },
          nb::rv_policy::reference, "k1, k2, p1, p2, k3, k4, k5, k6 of OpenCV.")
      .def_prop_ro(
          "projector_matrix", [](const rig::Calibration& self) { return camera_matrix(self.projector); },
          nb::rv_policy::reference)
      .def_prop_ro(
          "projector_distortion", [](const rig::Calibration& self) { return distortion(self.projector); },
          nb::rv_policy::reference)
      .def_prop_ro(
          "rotation", [](const rig::Calibration& self) { return array_of_matrix(self.rotation); },
          nb::rv_policy::reference, "R, 3 x 3.")
      .def_prop_ro(
          "translation", [](const rig::Calibration& self) { return array_of_matrix<3, 1>(self.translation); },
          nb::rv_policy::reference, "T, mm.")
      .def_prop_ro(
          "camera_size",
          [](const rig::Calibration& self) {
            return Size{self.camera_columns, self.camera_rows};
          },
          "Columns and rows; 0 if the file does not say.")
      .def_prop_ro("projector_size", [](const rig::Calibration& self) {
        return Size{self.projector_columns, self.projector_rows};
      });
  nb::class_<Result>(module, "Result", "What the least squares found.")
      .def_prop_ro("calibration", [](const Result& self) { return self.report.calibration; })
      .def_prop_ro(
          "refusal", [](const Result& self) { return self.report.model.refusal; },
          "Why the result must not be used; empty if it may.")
      .def_prop_ro("warnings", [](const Result& self) { return self.report.warnings; })
      .def_prop_ro(
          "rms_px", [](const Result& self) { return self.report.bundle.rms; }, "Of all residuals.")
      .def(
          "json", [](const Result& self) { return calibration::report_json(self.report); },
          "All findings with standard deviations, as `selfproj calibrate` writes them.")
      .def("__str__", [](const Result& self) { return calibration::report_text(self.report); })
      .def(
          "save",
          [](const Result& self, const std::string& file) {
            require(self.report.model.refusal.empty(), "the result must not be used; see refusal");
            files::OutputFile(file).write(rig::calibration_yaml(self.report.calibration, self.rms()));
          },
          nb::arg("file"), "Writes OpenCV's YAML, whole or not at all.");
}

}  // namespace

void bind_calibration(nb::module_& module) {
  nb::class_<CaptureResult>(module, "Capture", "The projector pixel that each camera pixel sees.")
      .def_ro("projector_column", &CaptureResult::projector_column, nb::rv_policy::reference,
              "From 0, int16; -1 if there is no code.")
      .def_ro("projector_row", &CaptureResult::projector_row, nb::rv_policy::reference,
              "From 0, int16; -1 if there is no code.")
      .def_ro("mean", &CaptureResult::mean, nb::rv_policy::reference,
              "The mean of all images, in which the patterns cancel, uint8.");
  module.def("decode_capture", &decode, nb::arg("images"), nb::arg("projector"), nb::arg("threshold") = 5,
             nb::arg("contrast") = 20, nb::arg("channel") = "",
             "Decodes the images of a whole GraySequence: a folder in a list, or the files in order. projector: its\n"
             "columns and rows. A pair that differs by no more than threshold is ambiguous; white must exceed black\n"
             "by more than contrast. InputError names the file that is wrong.");
  module.def("find_chessboard", &find_corners, nb::arg("image").noconvert(), nb::arg("corners"),
             "The inner corners of a chessboard in an image (uint8): x, y in pixels from 0, float64, (n, 2); None if\n"
             "it is not found. corners: along both sides.");
  bind_result(module);
  module.def("calibrate", &calibrate_captures, nb::arg("captures"), nb::arg("corners"), nb::arg("square_mm"),
             nb::arg("projector"), nb::arg("camera_distortion") = -1, nb::arg("projector_distortion") = -1,
             "Calibrates camera and projector from captures of a chessboard in two or more poses. Distortion\n"
             "coefficients: 0, 1, 2, 4, 5, or -1: as many as the captures support. InputError if the captures do\n"
             "not suffice.");
  module.def("read_calibration", &rig::read_calibration, nb::arg("file"), "Reads OpenCV's YAML.");
}

}  // namespace selfproj::python
