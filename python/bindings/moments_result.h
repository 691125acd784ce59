// Moments on their way between arrays and the model.
#ifndef SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H
#define SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "model/column_runs.h"
#include "python/bindings/arrays.h"

namespace selfproj::python {

// New arrays for the moments of one or several images, and, for the strongest run, for the runs.
struct MomentsResult {
  MomentsResult(Select select, const std::vector<std::size_t>& shape)
      : m0(new_array<std::uint32_t>(shape)), m1(new_array<std::uint32_t>(shape)), n(new_array<std::uint32_t>(shape)) {
    if (select == Select::strongest) {
      runs = new_array<std::uint8_t>(shape);
      second = new_array<std::uint8_t>(shape);
    }
  }

  // The entries from `first` on.
  [[nodiscard]] RunsView view(std::size_t first) const {
    return {{m0.data() + first, m1.data() + first, n.data() + first},
            runs ? runs->data() + first : nullptr,
            second ? second->data() + first : nullptr};
  }

  Out<std::uint32_t> m0, m1, n;
  std::optional<Out<std::uint8_t>> runs, second;
};

// The moments of images by `kernel`, which has the arguments of measure_columns.
template <typename Kernel>
MomentsResult measure_images(const In<std::uint8_t>& array, const Measure& measure, const Kernel& kernel) {
  const Images images(array);
  MomentsResult result(measure.select, images.shape_of_columns());
  without_gil([&] {
    for (std::size_t i = 0; i < images.count(); ++i) {
      kernel(images.view(i), measure, result.view(i * images.columns()));
    }
  });
  return result;
}

// Defines `moments` in the module: images measured by `kernel`.
template <typename Kernel>
void def_moments(nb::module_& module, const Kernel& kernel, const char* documentation) {
  module.def(
      "moments",
      [kernel](const In<std::uint8_t>& image, int threshold, Mode mode, Select select, int gap, int first_row,
               int last_row) {
        return measure_images(image,
                              {.mode = mode,
                               .threshold = threshold,
                               .select = select,
                               .gap = gap,
                               .window = {.first = first_row, .last = last_row}},
                              kernel);
      },
      nb::arg("image").noconvert(), nb::arg("threshold"), nb::arg("mode") = Mode::grey_over,
      nb::arg("select") = Select::all, nb::arg("gap") = 0, nb::arg("first_row") = 0, nb::arg("last_row") = 0,
      documentation);
}

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_MOMENTS_RESULT_H
