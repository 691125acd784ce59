// The extension module selfproj._core: a submodule for each subject.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>

#include <cstddef>
#include <exception>
#include <optional>
#include <string>
#include <utility>

#include "host/files/text.h"
#include "host/images/image_files.h"
#include "python/bindings/arrays.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

NB_MODULE(_core, module) {
  using namespace selfproj::python;
  nb::set_leak_warnings(false);  // simulators end their Python without freeing what it holds
  module.doc() = "The compiled part of selfproj. Use selfproj.model and the others.";
  static nb::object input_error = nb::exception<selfproj::UserError>(module, "InputError", PyExc_ValueError);
  input_error.doc() = "A file, a device or a setting is wrong. The text names it and says the reason.";
  // Names may be in any encoding, which nanobind's own translation does not expect.
  nb::register_exception_translator([](const std::exception_ptr& thrown, void* /*unused*/) {
    try {
      std::rethrow_exception(thrown);
    } catch (const selfproj::UserError& error) {
      PyErr_SetString(input_error.ptr(), selfproj::files::shown(error.what()).c_str());
    }
  });
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&WithoutGil::end_of_python));
  module.attr("__version__") = SELFPROJ_VERSION;
  module.def(
      "read_image",
      [](const Path& file, const std::string& channel, std::optional<int> shift) {
        const selfproj::images::PixelRule rule = selfproj::images::PixelOptions{channel, shift}.rule();
        selfproj::images::Image image = without_gil([&] { return selfproj::images::read_image(file.string(), rule); });
        return array_of(std::move(image.pixels),
                        {static_cast<std::size_t>(image.rows), static_cast<std::size_t>(image.columns)});
      },
      nb::arg("file"), nb::arg("channel") = "", nb::arg("shift") = nb::none(),
      "Reads an image as one channel of 8 bits: uint8, (rows, columns). Of a colour image it takes `channel`: red,\n"
      "green, blue, grey, or for the light of a laser red-difference, green-difference or blue-difference. Values of\n"
      "more bits become value >> shift: 4 for 12 bits, 8 for 16. InputError names the file and the reason.");
  module.attr("SPEC_HASH") = selfproj::spec::kHash;
  module.def(
      "kernel_ns", [] { return kernel_ns().load(); },
      "Nanoseconds that compiled functions have run without the GIL in this process.");
  const auto part = [&](const char* name, const char* text, void (*bind)(nb::module_&)) {
    nb::module_ made = module.def_submodule(name, text);
    bind(made);
  };
  part("model", "The bit-exact models of the circuits.", bind_model);
  part("packets", "Packets as boards send them.", bind_packets);
  part("driver", "Devices that bring packets.", bind_driver);
  part("light_section", "Profiles of a light section.", bind_light_section);
  part("structured_light", "Gray codes, self-projected stripes and depth.", bind_structured_light);
  part("calibration", "Calibration of camera and projector.", bind_calibration);
  part("parts", "Parts, tolerances and verdicts.", bind_parts);
  part("cameras", "Cameras.", bind_cameras);
  part("pictures", "Maps and images as PNG.", bind_pictures);
}
