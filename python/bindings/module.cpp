// The extension module selfproj._core: a submodule for each subject.
#include <nanobind/stl/string.h>

#include <cstddef>
#include <string>
#include <utility>

#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "python/bindings/arrays.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/generated/selfproj_spec.h"

NB_MODULE(_core, module) {
  using namespace selfproj::python;
  nb::set_leak_warnings(false);  // simulators end their Python without freeing what it holds
  module.doc() = "The compiled part of selfproj. Use selfproj.model and the others.";
  nb::exception<selfproj::UserError>(module, "InputError", PyExc_ValueError).doc() =
      "A file, a device or a setting is wrong. The text names it and says the reason.";
  module.def(
      "read_image",
      [](const std::string& file, const std::string& channel) {
        selfproj::images::Image image =
            without_gil([&] { return selfproj::images::read_image(file, selfproj::images::channel_of(channel)); });
        return array_of(std::move(image.pixels),
                        {static_cast<std::size_t>(image.rows), static_cast<std::size_t>(image.columns)});
      },
      nb::arg("file"), nb::arg("channel") = "",
      "Reads an 8-bit image of one channel: uint8, (rows, columns). Of a colour image it takes `channel`: red, green,\n"
      "blue, grey or red-difference. InputError names the file and the reason.");
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
  part("structured_light", "Gray codes and depth.", bind_structured_light);
  part("calibration", "Calibration of camera and projector.", bind_calibration);
}
