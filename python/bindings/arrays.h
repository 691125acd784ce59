// NumPy arrays for the bindings: images on the way in, without a copy; new arrays on the way out, which own their
// memory; and kernels, which run without the GIL.
#ifndef SELFPROJ_PYTHON_BINDINGS_ARRAYS_H
#define SELFPROJ_PYTHON_BINDINGS_ARRAYS_H

#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <nanobind/stl/filesystem.h>

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "selfproj/images/float_image.h"
#include "selfproj/model/column_moments.h"

namespace selfproj::python {

namespace nb = nanobind;

// What functions take: arrays of any layout that NumPy reads without a conversion.
template <typename T, typename... Rest>
using In = nb::ndarray<const T, nb::device::cpu, Rest...>;

// Files and folders as Python has them: str or os.PathLike, with names in any encoding.
using Path = std::filesystem::path;
using Paths = std::vector<Path>;

inline std::vector<std::string> names_of(const Paths& paths) {
  std::vector<std::string> names;
  for (const Path& path : paths) {
    names.push_back(path.string());
  }
  return names;
}

// What functions give.
template <typename T, typename... Rest>
using Out = nb::ndarray<nb::numpy, T, Rest...>;

// Throws ValueError in Python unless `good`.
inline void require(bool good, const char* text) {
  if (!good) {
    throw std::invalid_argument(text);
  }
}

// A new array whose entries are not set; Python frees it.
template <typename T, typename... Rest>
Out<T, Rest...> new_array(const std::vector<std::size_t>& shape) {
  std::size_t count = 1;
  for (const std::size_t side : shape) {
    count *= side;
  }
  std::unique_ptr<T[]> values(new T[count > 0 ? count : 1]);
  T* const data = values.get();
  const nb::capsule owner(data, [](void* memory) noexcept { delete[] static_cast<T*>(memory); });
  static_cast<void>(values.release());
  return Out<T, Rest...>(data, shape.size(), shape.data(), owner);
}

// The memory of a vector as an array, without a copy.
template <typename T>
Out<T> array_of(std::vector<T> values, const std::vector<std::size_t>& shape) {
  auto kept = std::make_unique<std::vector<T>>(std::move(values));
  T* const data = kept->data();
  const nb::capsule owner(kept.get(), [](void* memory) noexcept { delete static_cast<std::vector<T>*>(memory); });
  static_cast<void>(kept.release());
  return Out<T>(data, shape.size(), shape.data(), owner);
}

// Images as arrays of 2 dimensions, or of 3: one image after another, not of 3 or 4 columns, which are colours. The
// pixels of a row lie side by side; rows and images may have any distance, also a negative one. Throws ValueError
// otherwise.
template <typename Pixel>
class ImagesOf {
 public:
  explicit ImagesOf(const In<Pixel>& array) : array_(array) {
    require(array.ndim() == 2 || array.ndim() == 3, "image: an array of 2 dimensions is needed, or of 3 for several");
    const std::size_t last = array.ndim() - 1;
    for (std::size_t i = 0; i <= last; ++i) {
      require(array.shape(i) <= kMaxSide, "image: too large");
    }
    require(array.stride(last) == 1 || array.shape(last) <= 1,
            "image: the pixels of a row must lie side by side; numpy.ascontiguousarray makes such an image");
    require(array.ndim() == 2 || (array.shape(last) != 3 && array.shape(last) != 4),
            "image: a last side of 3 or 4 is that of a colour image (rows, columns, colours), which is none of several "
            "images (images, rows, columns); take one of its colours");
  }

  [[nodiscard]] bool several() const { return array_.ndim() == 3; }
  [[nodiscard]] std::size_t count() const { return several() ? array_.shape(0) : 1; }
  [[nodiscard]] std::size_t rows() const { return array_.shape(array_.ndim() - 2); }
  [[nodiscard]] std::size_t columns() const { return array_.shape(array_.ndim() - 1); }
  [[nodiscard]] model::PixelView<Pixel> view(std::size_t i) const {
    const std::ptrdiff_t from = several() ? static_cast<std::ptrdiff_t>(i) * array_.stride(0) : 0;
    return {array_.data() + from, static_cast<int>(rows()), static_cast<int>(columns()),
            static_cast<std::ptrdiff_t>(array_.stride(array_.ndim() - 2))};
  }

 private:
  static constexpr std::size_t kMaxSide = std::size_t{1} << 30U;
  In<Pixel> array_;
};
using Images = ImagesOf<std::uint8_t>;

// One image.
inline model::ImageView image_of(const In<std::uint8_t>& array) {
  require(array.ndim() == 2, "image: an array of 2 dimensions is needed");
  return Images(array).view(0);
}

// Nanoseconds that kernels have run in this process; the benchmark compares them with the time that passed.
inline std::atomic<std::int64_t>& kernel_ns() {
  static std::atomic<std::int64_t> sum{0};
  return sum;
}

// Releases the GIL while it lives.
//
// Once Python ends, it ends every other thread that asks for the GIL by an exception of the C library, which C++ turns
// into an abort of the whole process (Python 3.14 leaves such threads waiting instead). From end_of_python on such a
// thread waits here for the end of the process.
class WithoutGil {
 public:
  WithoutGil() : thread_(PyThreadState_GetID(PyThreadState_Get())), state_(PyEval_SaveThread()) {}
  WithoutGil(const WithoutGil&) = delete;
  WithoutGil& operator=(const WithoutGil&) = delete;
  ~WithoutGil() {
    ++returning();
    if (ending() && thread_ != ending_thread()) {
      --returning();
      for (;;) {
        std::this_thread::sleep_for(std::chrono::hours(1));
      }
    }
    PyEval_RestoreThread(state_);
    --returning();
  }

  // To be called by the thread that ends Python, before it does (atexit).
  static void end_of_python() {
    ending_thread() = PyThreadState_GetID(PyThreadState_Get());
    ending() = true;
    PyThreadState* const state = PyEval_SaveThread();
    while (returning() > 0) {  // those that asked for the GIL before
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    PyEval_RestoreThread(state);
  }

 private:
  static std::atomic<int>& returning() {
    static std::atomic<int> threads{0};
    return threads;
  }
  static std::atomic<bool>& ending() {
    static std::atomic<bool> ending{false};
    return ending;
  }
  static std::atomic<std::uint64_t>& ending_thread() {
    static std::atomic<std::uint64_t> id{0};
    return id;
  }

  std::uint64_t thread_;  // Python's number of it
  PyThreadState* state_;
};

// Runs `work` without the GIL. No object of Python may be touched in it.
template <typename Work>
auto without_gil(const Work& work) {
  struct Clock {
    std::chrono::steady_clock::time_point begin = std::chrono::steady_clock::now();
    ~Clock() {
      kernel_ns() +=
          std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now() - begin).count();
    }
  };
  const WithoutGil released;
  const Clock clock;
  return work();
}

// "Name(a x b)": how an object with arrays of this shape shows itself.
inline std::string shape_text(const std::string& name, const std::vector<std::size_t>& shape) {
  std::string text;
  for (const std::size_t side : shape) {
    text += (text.empty() ? "" : " x ") + std::to_string(side);
  }
  return name + "(" + text + ")";
}

template <typename Array>
std::vector<std::size_t> sides_of(const Array& array) {
  std::vector<std::size_t> sides;
  for (std::size_t i = 0; i < array.ndim(); ++i) {
    sides.push_back(array.shape(i));
  }
  return sides;
}

// An object that keeps state is for one thread at a time. Without this, a second thread could enter it while the first
// one runs without the GIL.
class Busy {
 public:
  class Entered {
   public:
    explicit Entered(Busy& busy) : busy_(&busy) {
      if (busy.busy_) {
        throw std::runtime_error("another thread is using this object");
      }
      busy.busy_ = true;
    }
    Entered(const Entered&) = delete;
    Entered& operator=(const Entered&) = delete;
    ~Entered() { busy_->busy_ = false; }

   private:
    Busy* busy_;
  };

 private:
  bool busy_ = false;  // read and written with the GIL
};

// Pickling (and copying) of an object that is in the midst of something is a TypeError with the reason.
template <typename Class>
void refuse_pickling(Class& bound, const char* reason) {
  bound.def("__reduce__", [reason](const nb::handle& self) -> nb::object {
    const std::string name = nb::cast<std::string>(nb::getattr(self.type(), "__name__"));
    throw nb::type_error((name + ": cannot be pickled or copied: it " + reason).c_str());
  });
}

// An array of an object as it goes into its pickle.
template <typename Array>
nb::object pickled(const Array& array) {
  return nb::cast(array, nb::rv_policy::reference);
}

// Names, which may be in any encoding.
inline nb::bytes pickled_name(const std::string& name) { return nb::bytes(name.data(), name.size()); }
inline std::string name_of(const nb::bytes& pickled) { return {pickled.c_str(), pickled.size()}; }

// The parts of the module.
void bind_model(nb::module_& module);
void bind_packets(nb::module_& module);
void bind_driver(nb::module_& module);
void bind_light_section(nb::module_& module);
void bind_references(nb::module_& module);  // of light_section
void bind_structured_light(nb::module_& module);
void bind_stripes(nb::module_& module);  // of structured_light
void bind_calibration(nb::module_& module);
void bind_lasers(nb::module_& module);  // of calibration
void bind_parts(nb::module_& module);
void bind_cameras(nb::module_& module);
void bind_pictures(nb::module_& module);

inline std::vector<std::size_t> sides_of_image(int rows, int columns) {
  return {static_cast<std::size_t>(rows), static_cast<std::size_t>(columns)};
}

// The memory of the image as an array, (rows, columns), without a copy.
inline Out<float> array_of_image(images::FloatImage image) {
  return array_of(std::move(image.values), sides_of_image(image.rows, image.columns));
}

// A map or depth image as an argument, and its copy.
using FloatArray = In<float, nb::ndim<2>, nb::c_contig>;
inline images::FloatImage float_image_of(const FloatArray& array) {
  constexpr std::size_t kMaxSide = 65535;
  require(array.shape(0) > 0 && array.shape(1) > 0 && array.shape(0) <= kMaxSide && array.shape(1) <= kMaxSide,
          "image: both sides must be in 1..65535");
  images::FloatImage image(static_cast<int>(array.shape(0)), static_cast<int>(array.shape(1)));
  image.values.assign(array.data(), array.data() + array.size());
  return image;
}

// One value for each column, and its copy.
using ColumnValues = In<double, nb::ndim<1>, nb::c_contig>;
inline std::vector<double> vector_of(const ColumnValues& array) { return {array.data(), array.data() + array.size()}; }
inline Out<double> array_of_values(std::vector<double> values) {
  const std::size_t count = values.size();
  return array_of(std::move(values), {count});
}

}  // namespace selfproj::python

#endif  // SELFPROJ_PYTHON_BINDINGS_ARRAYS_H
