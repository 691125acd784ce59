// Of selfproj.light_section: references, patterns, sweeps, heights tied to known ones.
#include <nanobind/stl/array.h>
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/light_section/height_fit.h"
#include "host/light_section/line_finder.h"
#include "host/light_section/pattern.h"
#include "host/light_section/scan.h"
#include "python/bindings/arrays.h"
#include "python/bindings/images_input.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/light_section/reference_file.h"
#include "selfproj/rig/rig.h"

namespace selfproj::python {
namespace {

using light_section::ReferenceProfile;

ReferenceProfile checked(ReferenceProfile reference, const char* what) {
  require(reference.valid_columns() > 0, what);
  return reference;
}

// Values where the reference is valid, elsewhere NaN.
Out<double> valid_values(const ReferenceProfile& reference, std::vector<double> values) {
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (reference.valid[i] == 0) {
      values[i] = std::nan("");
    }
  }
  return array_of_values(std::move(values));
}

template <typename Pixel>
void check_camera(const rig::Rig& rig, const std::string& name, const images::ImageOf<Pixel>& image) {
  if (image.rows != rig.camera.rows || image.columns != rig.camera.columns) {
    throw UserError(name, "has " + std::to_string(image.rows) + " x " + std::to_string(image.columns) +
                              " pixels; the rig's camera has " + std::to_string(rig.camera.rows) + " x " +
                              std::to_string(rig.camera.columns));
  }
}

images::SensorImage image_of_camera(const rig::Rig& rig, const GivenImages& given, std::size_t i) {
  images::SensorImage image = given.read(i);
  std::visit([&](const auto& one) { check_camera(rig, given.names()[i], one); }, image);
  return image;
}

std::vector<int> lines_of_sweep(const rig::Rig& rig, int every) {
  require(every >= 1 && every <= 1024, "every: must be in 1..1024");
  std::vector<int> lines = light_section::sweep_lines(rig, every);
  require(!lines.empty(), "rig: its line is wider than the projector's image");
  return lines;
}

// Passes on the images of a sweep, each with its line.
template <typename Take>
void for_each_line(const rig::Rig& rig, const GivenImages& given, const std::vector<int>& lines, const Take& take) {
  require(given.count() == lines.size(), "images: one is needed for each line of light_section.sweep_lines");
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const images::SensorImage image = image_of_camera(rig, given, i);
    take(lines[i], light_section::view_of(image));
  }
}

ReferenceProfile sweep_reference(const rig::Rig& rig, const ImagesArgument& images, int every,
                                 const std::string& channel, std::optional<int> shift) {
  const std::vector<int> lines = lines_of_sweep(rig, every);
  const GivenImages given(images, {channel, shift}, rig.measure.bits());
  return checked(without_gil([&] {
                   light_section::LineScan scan(rig, every);
                   for_each_line(rig, given, lines,
                                 [&](int line, const model::SensorView& image) { scan.add(line, image); });
                   return scan.reference();
                 }),
                 "images: no camera column sees the line cross its middle row");
}

ReferenceProfile residual_out(const rig::Rig& rig, const ReferenceProfile& reference, const ImagesArgument& images,
                              const std::string& channel, std::optional<int> shift, bool unchecked) {
  const GivenImages given(images, {channel, shift}, rig.measure.bits());
  return checked(without_gil([&] {
                   light_section::CentroidMean mean(rig);
                   for (std::size_t i = 0; i < given.count(); ++i) {
                     const images::SensorImage image = image_of_camera(rig, given, i);
                     mean.add(light_section::view_of(image));
                   }
                   if (const std::string contradiction = mean.contradiction(); !unchecked && !contradiction.empty()) {
                     throw UserError("images", contradiction);
                   }
                   return light_section::without_residual(rig, reference, mean.centroids());
                 }),
                 "images: no column of the reference sees the line");
}

images::FloatImage pattern_of(const rig::Rig& rig, const ReferenceProfile& reference) {
  return light_section::draw_pattern(
      rig, light_section::pattern_of_curve(rig, light_section::curve_of_reference(rig, reference)));
}

void save_reference(const ReferenceProfile& reference, const rig::Rig& rig, const Path& folder_name) {
  without_gil([&] {
    files::OutputFolder folder(folder_name.string());
    const images::FloatImage pattern = pattern_of(rig, reference);
    folder.append("reference.csv", light_section::reference_csv(rig, reference));
    folder.append("pattern.tiff", images::encode_float_tiff(folder.name() + "/pattern.tiff", pattern));
    folder.append("pattern.png", light_section::encode_pattern_png(pattern));
    folder.append("preview.png", light_section::draw_preview(rig, pattern, reference));
    folder.commit();
  });
}

// Pickled as its numbers.
using ReferenceState = std::tuple<std::vector<double>, std::vector<double>, std::vector<double>, std::vector<double>,
                                  std::vector<double>, std::vector<std::uint8_t>, std::vector<int>>;

ReferenceState state_of_reference(const ReferenceProfile& r) {
  std::vector<int> measured;
  if (r.measured) {
    measured = {static_cast<int>(r.measured->select), r.measured->gap, r.measured->window.first,
                r.measured->window.last};
  }
  return {r.tan_theta, r.line, r.slope, r.z_mm, r.offset_px, r.valid, measured};
}

void set_reference(ReferenceProfile& self, const ReferenceState& state) {
  new (&self) ReferenceProfile();
  std::vector<int> measured;
  std::tie(self.tan_theta, self.line, self.slope, self.z_mm, self.offset_px, self.valid, measured) = state;
  const std::size_t columns = self.valid.size();
  require(self.z_mm.size() == columns && self.offset_px.size() == columns &&
              (self.tan_theta.size() == columns || (self.line.size() == columns && self.slope.size() == columns)) &&
              (measured.empty() || measured.size() == 4),
          "state: is none of a Reference");
  if (!measured.empty()) {
    self.measured = light_section::Selection{
        static_cast<model::Select>(measured[0]), measured[1], {.first = measured[2], .last = measured[3]}};
  }
}

void bind_reference_class(nb::module_& module) {
  nb::class_<ReferenceProfile>(module, "Reference",
                               "The reference of a self-projected light section: for each camera column the plane of\n"
                               "light that it sees, and where that meets the reference.")
      .def_prop_ro(
          "z", [](const ReferenceProfile& self) { return valid_values(self, self.z_mm); }, nb::rv_policy::reference,
          "z in mm of the reference in each column, float64, NaN where there is none.")
      .def_prop_ro(
          "offset_px", [](const ReferenceProfile& self) { return valid_values(self, self.offset_px); },
          nb::rv_policy::reference,
          "Rows from the middle row to where the pattern is seen on the reference: 0 if it is self-projected.")
      .def_prop_ro(
          "valid",
          [](const ReferenceProfile& self) {
            auto valid = new_array<bool>({self.valid.size()});
            std::copy(self.valid.begin(), self.valid.end(), valid.data());
            return valid;
          },
          nb::rv_policy::reference, "Whether a column has a reference, bool.")
      .def("save", &save_reference, nb::arg("rig"), nb::arg("folder"),
           "Writes the folder of `selfproj pattern`: reference.csv, its pattern as TIFF and PNG, a preview.")
      .def("__len__", &ReferenceProfile::columns)
      .def("__repr__",
           [](const ReferenceProfile& self) {
             return "Reference(" + std::to_string(self.valid_columns()) + " of " + std::to_string(self.columns()) +
                    " columns)";
           })
      .def("__getstate__", &state_of_reference)
      .def("__setstate__", &set_reference);
  module.def(
      "load_reference",
      [](const rig::Rig& rig, const Path& folder) { return light_section::load_reference(rig, folder.string()); },
      nb::arg("rig"), nb::arg("folder"),
      "The reference of a folder that `selfproj pattern` or Reference.save wrote, or of its reference.csv. InputError\n"
      "if there is none, or the rig has another geometry.");
  module.def("reference_of_plane", &light_section::reference_of_plane, nb::arg("rig"),
             "The reference of the rig's empty belt.");
  module.def(
      "reference_of_heights",
      [](const rig::Rig& rig, const ColumnValues& heights) {
        const std::vector<double> values = vector_of(heights);
        return checked(without_gil([&] {
                         return light_section::reference_of_curve(rig, light_section::curve_of_heights(rig, values));
                       }),
                       "heights: no camera column sees the part in the projector's light");
      },
      nb::arg("rig"), nb::arg("heights").noconvert(),
      "The reference of a part whose height above the belt, mm, each camera column has: float64, NaN for no part.");
  module.def(
      "reference_of_sweep", &sweep_reference, nb::arg("rig"), nb::arg("images").noconvert(), nb::arg("every") = 1,
      nb::arg("channel") = "", nb::arg("shift") = nb::none(),
      "The reference that a sweep of straight lines found: one image under each line of sweep_lines(rig,\n"
      "every), as an array (images, rows, columns), a list of arrays, a folder or files. Arrays are uint8, or uint16\n"
      "where the rig's pixels have more than 8 bits.");
  module.def("without_residual", &residual_out, nb::arg("rig"), nb::arg("reference"), nb::arg("images").noconvert(),
             nb::arg("channel") = "", nb::arg("shift") = nb::none(), nb::arg("unchecked") = false,
             "The reference with its residual taken out: images of its pattern on the reference part itself. "
             "InputError if the line moves from image to image, unless unchecked.");
}

void bind_line_patterns(nb::module_& module) {
  module.def("sweep_lines", &lines_of_sweep, nb::arg("rig"), nb::arg("every") = 1,
             "The projector lines of a sweep, from 0: every `every`-th one at which the whole line fits.");
  module.def(
      "pattern_of_line",
      [](const rig::Rig& rig, double line) {
        require(line >= 0 && line <= rig.projector.lines - 1, "line: the projector has no such line");
        return array_of_image(light_section::draw_straight_line(rig, line));
      },
      nb::arg("rig"), nb::arg("line"),
      "The straight line of the conventional method and of a sweep: light 0..1, float32, (lines, columns) of the\n"
      "projector.");
  module.def(
      "pattern_of_reference",
      [](const rig::Rig& rig, const ReferenceProfile& reference) {
        return array_of_image(without_gil([&] { return pattern_of(rig, reference); }));
      },
      nb::arg("rig"), nb::arg("reference"),
      "The self-projected pattern (3.9) of a reference: light 0..1, float32, (lines, columns) of the projector.");
}

// Heights.
using LevelFigures = std::map<std::string, double>;

LevelFigures figures_of(const light_section::HeightLevel& level) {
  return {{"height_mm", level.height_mm},
          {"samples", static_cast<double>(level.samples)},
          {"mean_before_mm", level.before_mean_mm},
          {"rms_before_mm", level.before_rms_mm},
          {"mean_mm", level.mean_mm},
          {"rms_mm", level.rms_mm},
          {"uneven_mm", level.uneven_mm}};
}

light_section::HeightFit fit_sweeps(const rig::Rig& rig, const std::vector<ImagesArgument>& sweeps,
                                    const std::vector<double>& heights, const std::vector<double>& steps, int every,
                                    double tolerance, double flatness, std::optional<double> scale_tolerance,
                                    const std::string& channel, std::optional<int> shift) {
  require(heights.empty() != steps.empty(), "heights_mm, steps_mm: give one of them");
  require(heights.empty() || heights.size() == sweeps.size(), "heights_mm: one is needed for each sweep");
  require(tolerance > 0 && flatness > 0 && scale_tolerance.value_or(1) > 0,
          "tolerance_mm, flatness_mm, scale_tolerance: must be above 0");
  const std::vector<int> lines = lines_of_sweep(rig, every);
  std::vector<GivenImages> given;
  for (const ImagesArgument& sweep : sweeps) {
    given.emplace_back(sweep, images::PixelOptions{channel, shift}, rig.measure.bits());
  }
  return without_gil([&] {
    std::vector<light_section::HeightPosition> positions;
    for (std::size_t i = 0; i < given.size(); ++i) {
      light_section::HeightPosition& position = positions.emplace_back();
      position.name = "sweep " + std::to_string(i);
      position.height_mm = heights.empty() ? 0 : heights[i];
      light_section::LineFinder finder(rig);
      for_each_line(rig, given[i], lines, [&](int line, const model::SensorView& image) {
        light_section::add_sightings(finder, line, image, position.seen);
      });
    }
    light_section::HeightSettings settings;
    settings.steps_mm = steps;
    settings.tolerance_mm = tolerance;
    settings.flatness_mm = flatness;
    settings.scale_tolerance = scale_tolerance;
    return light_section::fit_heights(rig, positions, settings);
  });
}

// What Python sees of it.
using LevelState = std::tuple<std::string, std::size_t, std::array<double, 6>>;
using FitState = std::tuple<rig::Rig, std::vector<LevelState>, double, double>;

FitState state_of_fit(const light_section::HeightFit& self) {
  std::vector<LevelState> levels;
  for (const light_section::HeightLevel& level : self.levels) {
    levels.emplace_back(level.name, level.samples,
                        std::array{level.height_mm, level.before_rms_mm, level.before_mean_mm, level.rms_mm,
                                   level.mean_mm, level.uneven_mm});
  }
  return {self.rig, levels, self.rms_mm, self.correction_mm};
}

void set_fit(light_section::HeightFit& self, const FitState& state) {
  const auto& [rig, levels, rms, correction] = state;
  new (&self) light_section::HeightFit{.rig = rig, .levels = {}, .rms_mm = rms, .correction_mm = correction};
  for (const auto& [name, samples, n] : levels) {
    self.levels.push_back({name, n[0], samples, n[1], n[2], n[3], n[4], n[5]});
  }
}

void bind_heights(nb::module_& module) {
  nb::class_<light_section::HeightFit>(module, "HeightFit", "Heights of a light section tied to known ones.")
      .def_prop_ro(
          "rig", [](const light_section::HeightFit& self) { return self.rig; }, "The rig with its correction.")
      .def_prop_ro(
          "levels",
          [](const light_section::HeightFit& self) {
            std::vector<LevelFigures> levels;
            for (const light_section::HeightLevel& level : self.levels) {
              levels.push_back(figures_of(level));
            }
            return levels;
          },
          "Of each height: height_mm, samples, and mean_mm, rms_mm and uneven_mm of its errors; before: by the\n"
          "geometry alone.")
      .def_ro("rms_mm", &light_section::HeightFit::rms_mm, "Of single centroids, over all heights.")
      .def_ro("correction_mm", &light_section::HeightFit::correction_mm, "The greatest correction.")
      .def("__repr__",
           [](const light_section::HeightFit& self) {
             return "HeightFit(" + std::to_string(self.levels.size()) +
                    " heights, rms_mm=" + std::to_string(self.rms_mm) + ")";
           })
      .def("__getstate__", &state_of_fit)
      .def("__setstate__", &set_fit);
  module.def(
      "fit_heights", &fit_sweeps, nb::arg("rig"), nb::arg("sweeps").noconvert(),
      nb::arg("heights_mm") = std::vector<double>{}, nb::arg("steps_mm") = std::vector<double>{}, nb::arg("every") = 4,
      nb::arg("tolerance_mm") = 0.005, nb::arg("flatness_mm") = 0.01, nb::arg("scale_tolerance") = nb::none(),
      nb::arg("channel") = "", nb::arg("shift") = nb::none(),
      "Ties heights to known ones, as `selfproj calibrate heights`: a sweep (images as reference_of_sweep takes\n"
      "them) over a flat plate at each of three or more heights_mm; or sweeps over a block with treads of\n"
      "steps_mm. InputError or ValueError if they do not suffice.");
}

}  // namespace

void bind_references(nb::module_& module) {
  bind_reference_class(module);
  bind_line_patterns(module);
  bind_heights(module);
}

}  // namespace selfproj::python
