// selfproj.cameras: cameras of this machine and its network.
#include <nanobind/stl/map.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/camera/camera.h"
#include "host/camera/camera_uri.h"
#include "host/camera/open_camera.h"
#include "python/bindings/arrays.h"

namespace selfproj::python {
namespace {

// An image of the camera in memory of its own.
struct TakenImage {
  Out<std::uint8_t> pixels;
  std::uint64_t number = 0;
  std::int64_t time_ns = 0;
  bool complete = false;
};

using CameraImageState = std::tuple<Out<std::uint8_t>, std::uint64_t, std::int64_t, bool>;

// A camera, for one thread at a time.
class CameraHandle {
 public:
  explicit CameraHandle(std::unique_ptr<camera::Camera> camera) : camera_(std::move(camera)) {}

  [[nodiscard]] camera::Camera& camera() const {
    require(camera_ != nullptr, "the camera is closed");
    return *camera_;
  }

  void start() {
    const Busy::Entered entered(busy_);
    camera::Camera& from = camera();
    without_gil([&] { from.start(); });
  }

  void stop() {
    const Busy::Entered entered(busy_);
    camera::Camera& from = camera();
    without_gil([&] { from.stop(); });
  }

  void trigger() {
    const Busy::Entered entered(busy_);
    camera::Camera& from = camera();
    without_gil([&] { from.trigger(); });
  }

  // The next image; nothing after `timeout` seconds. Looks for signals meanwhile.
  std::optional<TakenImage> next(double timeout) {
    const Busy::Entered entered(busy_);
    require(timeout >= 0, "timeout: must be 0 or more seconds");
    camera::Camera& from = camera();
    const auto begin = std::chrono::steady_clock::now();
    for (;;) {
      const double left = timeout - std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
      constexpr double kLongest = 0.1;
      const auto slice = std::chrono::duration_cast<std::chrono::nanoseconds>(
          std::chrono::duration<double>(std::clamp(left, 0.0, kLongest)));
      camera::CameraImage image;
      if (without_gil([&] { return from.next(image, slice); })) {
        return taken(image);
      }
      if (left <= 0) {
        return std::nullopt;
      }
      if (PyErr_CheckSignals() != 0) {
        throw nb::python_error();
      }
    }
  }

  void close() {
    const Busy::Entered entered(busy_);
    without_gil([&] { camera_.reset(); });
  }

  [[nodiscard]] std::string text() const {
    return camera_ == nullptr ? "Camera(closed)" : "Camera('" + camera_->uri() + "')";
  }

 private:
  static TakenImage taken(const camera::CameraImage& image) {
    TakenImage result{new_array<std::uint8_t>(sides_of_image(image.view.rows, image.view.columns)), image.number,
                      image.time_ns, image.complete};
    const auto columns = static_cast<std::size_t>(image.view.columns);
    for (int row = 0; row < image.view.rows; ++row) {
      std::memcpy(result.pixels.data() + static_cast<std::size_t>(row) * columns,
                  image.view.pixels + row * image.view.stride, columns);
    }
    return result;
  }

  std::unique_ptr<camera::Camera> camera_;
  Busy busy_;
};

}  // namespace

void bind_cameras(nb::module_& module) {
  nb::class_<TakenImage>(module, "CameraImage", "An image of a camera.")
      .def_ro("pixels", &TakenImage::pixels, nb::rv_policy::reference, "uint8, (rows, columns), a copy.")
      .def_ro("number", &TakenImage::number, "The camera's own number, from 0 at the first image after start().")
      .def_ro("time_ns", &TakenImage::time_ns, "The camera's clock when it took the image.")
      .def_ro("complete", &TakenImage::complete, "Otherwise parts are missing, and the pixels mean nothing.")
      .def("__repr__", [](const TakenImage& self) { return shape_text("CameraImage", sides_of(self.pixels)); })
      .def("__getstate__",
           [](const TakenImage& self) {
             return nb::make_tuple(pickled(self.pixels), self.number, self.time_ns, self.complete);
           })
      .def("__setstate__", [](TakenImage& self, const CameraImageState& state) {
        const auto& [pixels, number, time_ns, complete] = state;
        new (&self) TakenImage{pixels, number, time_ns, complete};
      });
  auto camera = nb::class_<CameraHandle>(module, "Camera", "A camera, for one thread at a time.");
  refuse_pickling(camera, "holds an open camera; pickle its images, or its uri and open it again");
  camera.def("start", &CameraHandle::start, "Begins to take images; counts from 0 again.")
      .def("stop", &CameraHandle::stop)
      .def("trigger", &CameraHandle::trigger, "Asks for one image, if opened with trigger=software.")
      .def("next", &CameraHandle::next, nb::arg("timeout") = 1.0,
           "The next image as a CameraImage; None after `timeout` seconds.")
      .def_prop_ro(
          "rows", [](const CameraHandle& self) { return self.camera().rows(); }, "Of its images.")
      .def_prop_ro("columns", [](const CameraHandle& self) { return self.camera().columns(); })
      .def_prop_ro(
          "uri", [](const CameraHandle& self) { return self.camera().uri(); }, "Without its parameters.")
      .def(
          "counters",
          [](const CameraHandle& self) {
            const camera::CameraCounters counters = self.camera().counters();
            return std::map<std::string, std::uint64_t>{{"complete", counters.complete},
                                                        {"incomplete", counters.incomplete},
                                                        {"dropped", counters.dropped},
                                                        {"late", counters.late}};
          },
          "What became of the images since start().")
      .def("close", &CameraHandle::close, "Stops the camera, and leaves it as it was found.")
      .def("__enter__", [](const nb::object& self) { return self; })
      .def(
          "__exit__", [](CameraHandle& self, const nb::args&) { self.close(); }, "Closes the camera.")
      .def("__repr__", &CameraHandle::text);
  module.def(
      "list",
      [] {
        std::vector<std::map<std::string, std::string>> found;
        for (const camera::CameraEntry& entry : without_gil([] { return camera::list_cameras(); })) {
          found.push_back({{"uri", entry.uri},
                           {"kind", entry.kind},
                           {"model", entry.model},
                           {"address", entry.address},
                           {"problem", entry.problem}});
        }
        return found;
      },
      "The cameras there are: uri, kind, model, address, and the problem why one cannot be used. Takes a second.");
  module.def(
      "open",
      [](const std::string& uri) {
        return std::make_unique<CameraHandle>(
            without_gil([&] { return camera::open_camera(camera::parse_camera_uri(uri)); }));
      },
      nb::arg("uri"),
      "Opens a camera: camera:NAME?exposure-us=500&... as `selfproj devices` lists the keys. InputError if it cannot\n"
      "be opened or refuses a setting.");
}

}  // namespace selfproj::python
