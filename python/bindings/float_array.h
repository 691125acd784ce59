// Float images as arrays.
#ifndef SELFPROJ_PYTHON_BINDINGS_FLOAT_ARRAY_H
#define SELFPROJ_PYTHON_BINDINGS_FLOAT_ARRAY_H

#include <cstddef>
#include <utility>

#include "host/images/float_image.h"
#include "python/bindings/arrays.h"

namespace selfproj::python {

// The memory of the image as an array, (rows, columns), without a copy.
inline Out<float> array_of_image(FloatImage image) {
  return array_of(std::move(image.values),
                  {static_cast<std::size_t>(image.rows), static_cast<std::size_t>(image.columns)});
}

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_FLOAT_ARRAY_H
