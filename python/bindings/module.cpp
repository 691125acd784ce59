// The extension module selfproj._core: a submodule for each subject.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/variant.h>

#include <algorithm>
#include <cstddef>
#include <exception>
#include <optional>
#include <regex>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/text.h"
#include "host/images/image_files.h"
#include "python/bindings/arrays.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_moments.h"
#include "selfproj/model/generated/selfproj_spec.h"

namespace {

// The text of an error as Python says it: options of the commands by the names of the arguments here. What is between
// backticks is a command, and stays.
std::string in_python(const std::string& text) {
  static const std::vector<std::pair<std::regex, std::string>> changes = [] {
    std::vector<std::pair<std::regex, std::string>> made;
    const auto change = [&](const std::string& from, const std::string& to) {
      made.emplace_back("(^|[ (,;])" + from + "(?![\\w./-])", "$1" + to);
    };
    change("--assume (\\w+)", "assume='$2' to load_rig");
    change("--select strongest, measure\\.runs", "measure.runs");
    for (const char* name : {"shift", "bits", "row-bits", "lines", "row-lines", "every", "e"}) {
      std::string argument = name;
      std::replace(argument.begin(), argument.end(), '-', '_');
      change(std::string("--") + name + " (\\d+)", argument + "=$2");
      change(std::string("--") + name, argument);
    }
    for (const auto& [option, argument] : {std::pair{"rig", "rig"},
                                           {"calibration", "calibration"},
                                           {"channel", "channel"},
                                           {"projector", "projector"},
                                           {"chessboard", "corners"},
                                           {"square", "square_mm"},
                                           {"thickness", "thickness_mm"},
                                           {"moves", "moves_mm"},
                                           {"counts", "counts"},
                                           {"seconds", "seconds"},
                                           {"laser", "laser"},
                                           {"laser-threshold", "threshold"},
                                           {"heights", "heights_mm"},
                                           {"steps", "steps_mm"},
                                           {"scale-tolerance", "scale_tolerance"},
                                           {"threshold", "threshold"}}) {
      change(std::string("--") + option, argument);
    }
    return made;
  }();
  std::string said;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t quote = std::min(text.find('`', begin), text.size());
    std::string plain = text.substr(begin, quote - begin);
    for (const auto& [from, to] : changes) {
      plain = std::regex_replace(plain, from, to);
    }
    const std::size_t end = std::min(text.find('`', quote + 1), text.size() - 1) + 1;
    said += plain + (quote < text.size() ? text.substr(quote, end - quote) : "");
    begin = quote < text.size() ? end : text.size();
  }
  return said;
}

}  // namespace

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
      PyErr_SetString(input_error.ptr(), selfproj::files::shown(in_python(error.what())).c_str());
    } catch (const selfproj::CheckFailed& error) {
      PyErr_SetString(input_error.ptr(), selfproj::files::shown(in_python(error.what())).c_str());
    }
  });
  nb::module_::import_("atexit").attr("register")(nb::cpp_function(&WithoutGil::end_of_python));
  module.attr("__version__") = SELFPROJ_VERSION;
  module.def(
      "read_image",
      [](const Path& file, const std::string& channel, std::optional<int> shift,
         int bits) -> std::variant<Out<std::uint8_t>, Out<std::uint16_t>> {
        require(bits >= selfproj::spec::kPixelBits && bits <= selfproj::model::kMaxPixelBits, "bits: must be in 8..12");
        selfproj::images::PixelRule rule = selfproj::images::PixelOptions{channel, shift}.rule();
        rule.bits = bits;
        selfproj::images::SensorImage image =
            without_gil([&] { return selfproj::images::read_sensor_image(file.string(), rule); });
        return std::visit(
            [](auto& of) -> std::variant<Out<std::uint8_t>, Out<std::uint16_t>> {
              return array_of(std::move(of.pixels),
                              {static_cast<std::size_t>(of.rows), static_cast<std::size_t>(of.columns)});
            },
            image);
      },
      nb::arg("file"), nb::arg("channel") = "", nb::arg("shift") = nb::none(), nb::arg("bits") = 8,
      "Reads an image as one channel of 8 bits: uint8, (rows, columns). Of a colour image it takes `channel`: red,\n"
      "green, blue, grey, or for the light of a laser red-difference, green-difference or blue-difference. Values of\n"
      "more bits become value >> shift: 4 for 12 bits, 8 for 16. With bits of 9 to 12 all of them are taken: uint16.\n"
      "InputError names the file and the reason.");
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
