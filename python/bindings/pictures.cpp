// selfproj.pictures: maps and images as PNG.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cmath>
#include <optional>
#include <string>

#include "host/images/image_files.h"
#include "host/report/map_picture.h"
#include "python/bindings/arrays.h"

namespace selfproj::python {
namespace {

nb::bytes bytes_of_png(const std::string& png) { return nb::bytes(png.data(), png.size()); }

nb::bytes map_png_of(const FloatArray& map, const std::string& title, bool signed_values, double row_mm,
                     double column_mm, std::optional<double> low, std::optional<double> high,
                     const std::string& row_axis, const std::string& column_axis) {
  require(row_mm >= 0 && column_mm > 0, "row_mm, column_mm: must be above 0; row_mm may be 0 if it is not known");
  const images::FloatImage image = float_image_of(map);
  return bytes_of_png(without_gil([&] {
    report::MapScale scale = signed_values ? report::difference_scale(image) : report::height_scale(image);
    scale.low = low.value_or(scale.low);
    scale.high = high.value_or(scale.high);
    require(std::isfinite(scale.low) && std::isfinite(scale.high) && scale.low < scale.high,
            "low, high: low must be below high");
    return report::labelled_map_png(image, scale, {row_mm, column_mm, row_axis, column_axis}, title);
  }));
}

}  // namespace

void bind_pictures(nb::module_& module) {
  module.def("map_png", &map_png_of, nb::arg("map").noconvert(), nb::arg("title") = "",
             nb::arg("signed_values") = false, nb::arg("row_mm") = 1.0, nb::arg("column_mm") = 1.0,
             nb::arg("low") = nb::none(), nb::arg("high") = nb::none(), nb::arg("row_axis") = "x",
             nb::arg("column_axis") = "y",
             "A map in mm (float32, NaN where there is no value) as PNG with a title, a colour bar and scale bars.\n"
             "signed_values: blue, white and red about 0; else dark to light. row_mm and column_mm: distance of\n"
             "neighbouring values. low, high: mm with the end colours; by default they follow from the values.\n"
             "row_axis, column_axis: what runs from row to row, and from column to column.");
  module.def(
      "image_png",
      [](const In<std::uint8_t>& array) {
        const model::ImageView view = image_of(array);
        require(view.rows > 0 && view.columns > 0, "image: has no pixels");
        return bytes_of_png(without_gil([&] { return images::encode_png(images::copy_of(view)); }));
      },
      nb::arg("image").noconvert(), "An image (uint8) as PNG.");
}

}  // namespace selfproj::python
