// selfproj.calibration: captures of a chessboard under Gray codes, and the calibration that follows from them.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <array>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <type_traits>
#include <utility>
#include <variant>
#include <vector>

#include "host/calibration/calibrate.h"
#include "host/calibration/calibration_output.h"
#include "host/calibration/capture.h"
#include "host/calibration/chessboard.h"
#include "host/files/output_file.h"
#include "host/files/text.h"
#include "host/images/image_files.h"
#include "python/bindings/arrays.h"
#include "python/bindings/chessboards.h"
#include "python/bindings/images_input.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/rig/calibration_file.h"

namespace selfproj::python {
namespace {

// Codes of both axes, moved into arrays; and the mean image.
struct CaptureResult {
  calibration::Capture capture;  // without what the arrays took
  std::string name;
  Out<std::int16_t> projector_column, projector_row;
  Out<std::uint8_t> mean;
};

CaptureResult decode(const ImagesArgument& images, const Size& projector, int threshold, int contrast,
                     const std::string& channel, std::optional<int> shift) {
  constexpr int kMaxSide = 1 << model::GrayDecoder::kMaxBits;
  require(projector.first >= 1 && projector.second >= 1 && projector.first <= kMaxSide && projector.second <= kMaxSide,
          "projector: its columns and rows must be in 1..4096");
  const structured_light::GraySequence sequence(projector.first, projector.second);
  require(threshold >= 0 && threshold <= 255 && contrast >= 0 && contrast <= 255,
          "threshold, contrast: must be in 0..255");
  const auto* paths = std::get_if<Paths>(&images);
  const auto* path = std::get_if<Path>(&images);
  const GivenImages given(images, {channel, shift});
  std::string name = path != nullptr ? path->string() : paths != nullptr ? paths->front().string() : "images";
  calibration::Capture capture = without_gil([&] {
    images::ImageSequence captured = given.sequence();
    return calibration::decode_capture(name, captured, sequence, {.threshold = threshold, .contrast = contrast});
  });
  const std::vector<std::size_t> shape = sides_of_image(capture.rows, capture.columns);
  auto column = array_of(capture.projector_column, shape);
  auto row = array_of(capture.projector_row, shape);
  auto mean = array_of(capture.mean.pixels, shape);
  return {std::move(capture), std::move(name), std::move(column), std::move(row), std::move(mean)};
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

// What Python sees of a report.
struct Result {
  rig::Calibration calibration;
  rig::CalibrationRms rms;
  std::string refusal;  // empty: it may be used
  std::vector<std::string> warnings;
  std::string json, text;
};

Result result_of(const calibration::CalibrationReport& report) {
  return {report.calibration,
          {report.bundle.camera_rms, report.bundle.projector_rms, report.bundle.rms},
          report.model.refusal,
          report.warnings,
          calibration::report_json(report),
          files::shown(calibration::report_text(report))};
}

Result calibrate_captures(const std::vector<const CaptureResult*>& captures, const Size& corners, double square_mm,
                          const Size& projector, int camera_distortion, int projector_distortion, bool unchecked) {
  calibration::CalibrateSettings settings;
  settings.chessboard = chessboard_of(corners, square_mm);
  require(projector.first >= 1 && projector.second >= 1, "projector: its sides must be 1 or more");
  settings.projector_columns = projector.first;
  settings.projector_rows = projector.second;
  settings.free = {camera_distortion, projector_distortion};
  for (const int free : {camera_distortion, projector_distortion}) {
    require((free >= -1 && free <= 5 && free != 3), "distortion: must be -1 (by the data), 0, 1, 2, 4 or 5");
  }
  require(!captures.empty(), "captures: none are given");
  for (const CaptureResult* capture : captures) {
    require(capture != nullptr, "captures: None is no capture");
  }
  return without_gil([&] {
    std::vector<calibration::PoseReport> poses;
    for (const CaptureResult* capture : captures) {
      calibration::PoseReport& pose =
          poses.emplace_back(calibration::observe_pose(capture->name, capture->capture, settings));
      if (!unchecked && pose.reason.empty() && pose.used() > 0) {
        pose.reason = capture->capture.contradiction;
      }
    }
    return result_of(calibration::calibrate(std::move(poses), settings));
  });
}

// All numbers of a calibration, in one order. visit(number) may change it.
template <class Calibrated, class Visit>
void visit_numbers(Calibrated& calibration, const Visit& visit) {
  for (auto* lens : {&calibration.camera, &calibration.projector}) {
    visit(lens->fx), visit(lens->fy), visit(lens->cx), visit(lens->cy);
    for (auto& k : lens->k) {
      visit(k);
    }
  }
  for (auto& value : calibration.rotation.val) {
    visit(value);
  }
  for (auto& value : calibration.translation.val) {
    visit(value);
  }
  visit(calibration.camera_columns), visit(calibration.camera_rows);
  visit(calibration.projector_columns), visit(calibration.projector_rows);
}

std::vector<double> state_of_calibration(const rig::Calibration& self) {
  std::vector<double> numbers;
  visit_numbers(self, [&](const auto& value) { numbers.push_back(value); });
  return numbers;
}

void set_calibration(rig::Calibration& self, const std::vector<double>& numbers) {
  new (&self) rig::Calibration();
  std::size_t next = 0;
  visit_numbers(self, [&](auto& value) {
    require(next < numbers.size(), "state: is none of a Calibration");
    value = static_cast<std::decay_t<decltype(value)>>(numbers[next++]);
  });
}

// A capture as its arrays.
nb::tuple state_of_capture(const CaptureResult& self) {
  return nb::make_tuple(pickled_name(self.name), pickled(self.projector_column), pickled(self.projector_row),
                        pickled(self.mean), self.capture.lit, self.capture.contradiction);
}

void set_capture(CaptureResult& self, const nb::tuple& state) {
  require(state.size() == 6, "state: is none of a Capture");
  std::string name = name_of(nb::cast<nb::bytes>(state[0]));
  auto column = nb::cast<Out<std::int16_t>>(state[1]);
  auto row = nb::cast<Out<std::int16_t>>(state[2]);
  auto mean = nb::cast<Out<std::uint8_t>>(state[3]);
  calibration::Capture capture;
  capture.lit = nb::cast<std::vector<bool>>(state[4]);
  capture.contradiction = nb::cast<std::string>(state[5]);
  require(mean.ndim() == 2 && column.size() == mean.size() && row.size() == mean.size() &&
              capture.lit.size() == mean.size(),
          "state: is none of a Capture");
  capture.rows = static_cast<int>(mean.shape(0));
  capture.columns = static_cast<int>(mean.shape(1));
  capture.projector_column.assign(column.data(), column.data() + column.size());
  capture.projector_row.assign(row.data(), row.data() + row.size());
  capture.mean = {capture.rows, capture.columns, {mean.data(), mean.data() + mean.size()}};
  new (&self) CaptureResult{std::move(capture), std::move(name), std::move(column), std::move(row), std::move(mean)};
}

using ResultState = std::tuple<rig::Calibration, std::array<double, 3>, std::string, std::vector<std::string>,
                               std::string, std::string>;

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
      .def_prop_ro("projector_size",
                   [](const rig::Calibration& self) {
                     return Size{self.projector_columns, self.projector_rows};
                   })
      .def("__repr__",
           [](const rig::Calibration& self) {
             return "Calibration(camera " + std::to_string(self.camera_columns) + " x " +
                    std::to_string(self.camera_rows) + ", projector " + std::to_string(self.projector_columns) + " x " +
                    std::to_string(self.projector_rows) + ")";
           })
      .def("__getstate__", &state_of_calibration)
      .def("__setstate__", &set_calibration);
  nb::class_<Result>(module, "Result", "What the least squares found.")
      .def_prop_ro("calibration", [](const Result& self) { return self.calibration; })
      .def_ro("refusal", &Result::refusal, "Why the result must not be used; empty if it may.")
      .def_prop_ro("warnings", [](const Result& self) { return self.warnings; })
      .def_prop_ro(
          "rms_px", [](const Result& self) { return self.rms.stereo; }, "Of all residuals.")
      .def(
          "json", [](const Result& self) { return self.json; },
          "All findings with standard deviations, as `selfproj calibrate` writes them.")
      .def("__str__", [](const Result& self) { return self.text; })
      .def("__repr__", [](const Result& self) { return "Result(rms_px=" + std::to_string(self.rms.stereo) + ")"; })
      .def(
          "save",
          [](const Result& self, const Path& file) {
            require(self.refusal.empty(), "the result must not be used; see refusal");
            files::OutputFile(file.string()).write(rig::calibration_yaml(self.calibration, self.rms));
          },
          nb::arg("file"), "Writes OpenCV's YAML, whole or not at all.")
      .def("__getstate__",
           [](const Result& self) -> ResultState {
             return {self.calibration, {self.rms.camera, self.rms.projector, self.rms.stereo},
                     self.refusal,     self.warnings,
                     self.json,        self.text};
           })
      .def("__setstate__", [](Result& self, const ResultState& state) {
        const auto& [calibration, rms, refusal, warnings, json, text] = state;
        new (&self) Result{calibration, {rms[0], rms[1], rms[2]}, refusal, warnings, json, text};
      });
}

}  // namespace

void bind_calibration(nb::module_& module) {
  nb::class_<CaptureResult>(module, "Capture", "The projector pixel that each camera pixel sees.")
      .def_ro("projector_column", &CaptureResult::projector_column, nb::rv_policy::reference,
              "From 0, int16; -1 if there is no code.")
      .def_ro("projector_row", &CaptureResult::projector_row, nb::rv_policy::reference,
              "From 0, int16; -1 if there is no code.")
      .def_ro("mean", &CaptureResult::mean, nb::rv_policy::reference,
              "The mean of all images, in which the patterns cancel, uint8.")
      .def_prop_ro(
          "contradiction", [](const CaptureResult& self) { return self.capture.contradiction; },
          "What the images contradict in each other, such as another order; empty: nothing.")
      .def("__repr__", [](const CaptureResult& self) { return shape_text("Capture", sides_of(self.mean)); })
      .def("__getstate__", &state_of_capture)
      .def("__setstate__", &set_capture);
  module.def("decode_capture", &decode, nb::arg("images").noconvert(), nb::arg("projector"), nb::arg("threshold") = 5,
             nb::arg("contrast") = 20, nb::arg("channel") = "", nb::arg("shift") = nb::none(),
             "Decodes the images of a whole GraySequence: a uint8 array (images, rows, columns), a list of arrays, a\n"
             "folder, or the files in order. projector: its columns and rows. A pair that differs by no more than\n"
             "threshold is ambiguous; white must exceed black by more than contrast. InputError names the file that\n"
             "is wrong.");
  module.def("find_chessboard", &find_corners, nb::arg("image").noconvert(), nb::arg("corners"),
             "The inner corners of a chessboard in an image (uint8): x, y in pixels from 0, float64, (n, 2); None if\n"
             "it is not found. corners: along both sides.");
  bind_result(module);
  bind_lasers(module);
  module.def("calibrate", &calibrate_captures, nb::arg("captures"), nb::arg("corners"), nb::arg("square_mm"),
             nb::arg("projector"), nb::arg("camera_distortion") = -1, nb::arg("projector_distortion") = -1,
             nb::arg("unchecked") = false,
             "Calibrates camera and projector from captures of a chessboard in two or more poses. Distortion\n"
             "coefficients: 0, 1, 2, 4, 5, or -1: as many as the captures support. A capture whose images contradict\n"
             "each other is left out, unless unchecked. InputError if the captures do not suffice.");
  module.def(
      "read_calibration", [](const Path& file) { return rig::read_calibration(file.string()); }, nb::arg("file"),
      "Reads OpenCV's YAML.");
}

}  // namespace selfproj::python
