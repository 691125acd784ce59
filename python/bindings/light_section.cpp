// selfproj.light_section: fast moments, rigs, profiles, height maps.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <cstddef>
#include <cstdint>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "python/bindings/arrays.h"
#include "python/bindings/moments_result.h"
#include "python/bindings/packet_view.h"
#include "python/bindings/profiler.h"
#include "selfproj/images/float_image.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/light_section/inspection.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::python {
namespace {

// Pickled as its arrays.
nb::tuple state_of(const ProfileResult& self) {
  return nb::make_tuple(pickled(self.centroid), pickled(self.x), pickled(self.y), pickled(self.z), pickled(self.dx),
                        pickled(self.dy), pickled(self.dz), pickled(self.validity));
}

void set_state(ProfileResult& self, const nb::tuple& state) {
  require(state.size() == 8, "state: is none of a Profile");
  new (&self) ProfileResult({0});
  std::size_t next = 0;
  for (auto* values : {&self.centroid, &self.x, &self.y, &self.z, &self.dx, &self.dy, &self.dz}) {
    *values = nb::cast<Out<float>>(state[next++]);
  }
  self.validity = nb::cast<Out<std::uint8_t>>(state[next]);
}

// Collects the frames of an inspection, for one thread at a time.
class Collected {
 public:
  Collected(const Profiler& profiler, std::size_t max_frames)
      : profiler_(profiler.profiler()),
        inspection_(profiler.rig(), profiler_.columns(), {.expected_frames = 0, .max_frames = max_frames}) {
    profile_.resize(profiler_.columns());
  }

  bool add(const PacketHandle& packet) {
    const Busy::Entered entered(busy_);
    const model::PacketView& view = packet.view();
    const PacketHandle::Use use(packet);
    return without_gil([&] {
      if (!profiler_.profile(view, profile_.view())) {
        return false;
      }
      inspection_.add(view.header, view.payload, profile_.view());
      return true;
    });
  }

  template <typename Get>
  auto get(const Get& member) {
    const Busy::Entered entered(busy_);
    return without_gil([&] { return (inspection_.*member)(); });
  }

 private:
  light_section::DifferentialProfiler profiler_;
  light_section::Inspection inspection_;
  light_section::Profile profile_;
  Busy busy_;
};

void save_tiff(const Path& file, const FloatArray& image) {
  without_gil([&] { images::write_float_tiff(file.string(), float_image_of(image)); });
}

void bind_rig(nb::module_& module) {
  nb::class_<rig::Rig>(module, "Rig", "Camera, projector and conveyor (docs/rigs.md).")
      .def_ro("name", &rig::Rig::name)
      .def_prop_ro(
          "kind",
          [](const rig::Rig& rig) { return rig.kind == rig::RigKind::light_section ? "light-section" : "scanner"; })
      .def_prop_ro(
          "rows", [](const rig::Rig& rig) { return rig.camera.rows; }, "Rows of the camera.")
      .def_prop_ro(
          "columns", [](const rig::Rig& rig) { return rig.camera.columns; }, "Columns of the camera.")
      .def_ro("plane_z_mm", &rig::Rig::plane_z_mm, "z of the conveyor or table; height = plane_z_mm - z.")
      .def_prop_ro(
          "mode", [](const rig::Rig& rig) { return rig.measure.mode; }, "How the board weighs pixels.")
      .def_prop_ro(
          "threshold", [](const rig::Rig& rig) { return rig.measure.threshold; }, "From where pixels are lit.")
      .def_prop_ro(
          "pixel_bits", [](const rig::Rig& rig) { return rig.measure.bits(); }, "Bits of a pixel that count, 8 to 12.")
      .def("to_yaml", &rig::to_yaml, "The rig as the text of a rig file.")
      .def("__repr__",
           [](const rig::Rig& rig) {
             return "Rig('" + rig.name + "', " + std::to_string(rig.camera.columns) + " x " +
                    std::to_string(rig.camera.rows) + ")";
           })
      .def("__getstate__", &rig::to_yaml)
      .def("__setstate__",
           [](rig::Rig& rig, const std::string& yaml) { new (&rig) rig::Rig(rig::parse_rig(yaml, "a pickled rig")); });
  module.def(
      "load_rig",
      [](const Path& name_or_file, const std::string& assume) {
        rig::Rig rig = rig::load_any_rig(name_or_file.string());
        if (!assume.empty()) {
          rig::assume(rig, assume, "assume");
        }
        return rig;
      },
      nb::arg("name_or_file"), nb::arg("assume") = "",
      "A built-in rig (light-section, scanner, laser), or that of a YAML file. InputError with file, line and reason.\n"
      "assume: what is taken from the drawing though no calibration measured it: camera, light, belt, speed, encoder,\n"
      "with commas between them.");
}

void bind_profiles(nb::module_& module) {
  nb::enum_<light_section::Validity>(module, "Validity", "Why a column has no point.")
      .value("VALID", light_section::Validity::valid)
      .value("UNLIT", light_section::Validity::unlit)
      .value("TOO_FEW", light_section::Validity::too_few)
      .value("TOO_WIDE", light_section::Validity::too_wide)
      .value("CUT_OFF", light_section::Validity::cut_off)
      .value("NO_REFERENCE", light_section::Validity::no_reference)
      .value("OUT_OF_RANGE", light_section::Validity::out_of_range)
      .value("AMBIGUOUS", light_section::Validity::ambiguous)
      .value("OUTSIDE", light_section::Validity::outside);
  nb::class_<ProfileResult>(module, "Profile",
                            "Profiles: float32 arrays of shape (columns,) or (frames, columns), mm in the camera's\n"
                            "frame, NaN where a column has no point.")
      .def_ro("centroid", &ProfileResult::centroid, nb::rv_policy::reference, "M1 / M0, rows from 1.")
      .def_ro("x", &ProfileResult::x, nb::rv_policy::reference)
      .def_ro("y", &ProfileResult::y, nb::rv_policy::reference)
      .def_ro("z", &ProfileResult::z, nb::rv_policy::reference)
      .def_ro("dx", &ProfileResult::dx, nb::rv_policy::reference, "Difference from the reference.")
      .def_ro("dy", &ProfileResult::dy, nb::rv_policy::reference)
      .def_ro("dz", &ProfileResult::dz, nb::rv_policy::reference, "Less than 0 is nearer to the camera.")
      .def_ro("validity", &ProfileResult::validity, nb::rv_policy::reference, "Values of Validity, uint8.")
      .def("__repr__", [](const ProfileResult& self) { return shape_text("Profile", sides_of(self.z)); })
      .def("__getstate__", &state_of)
      .def("__setstate__", &set_state);
  nb::class_<Profiler>(module, "Profiler", "Computes profiles; any number of threads may use it at once.")
      .def(nb::init<const rig::Rig&, const std::optional<Profiler::Reference>&>(), nb::arg("rig"),
           nb::arg("reference") = nb::none(),
           "reference: a Reference, a folder that `selfproj pattern` wrote, or its reference.csv; None: the empty\n"
           "plane.")
      .def_prop_ro(
          "rig", [](const Profiler& profiler) { return profiler.rig(); }, "A copy of its rig.")
      .def_prop_ro(
          "reference", [](const Profiler& profiler) { return profiler.reference(); }, "A copy of its reference.")
      .def("__repr__", [](const Profiler& profiler) { return "Profiler('" + profiler.rig().name + "')"; })
      .def("profile", &Profiler::of_packet, nb::arg("packet"),
           "The profile of a packet of moments. ValueError if it is another packet, or of a broken frame.")
      .def("profile_of_moments", &Profiler::of_moments, nb::arg("m0").noconvert(), nb::arg("m1").noconvert(),
           nb::arg("n").noconvert(),
           "Profiles of moments of all lit pixels: uint32 arrays of shape (columns,) or (frames, columns), values\n"
           "below 2^31.")
      .def("__getstate__", [](const Profiler& self) { return std::tuple(self.rig(), self.reference()); })
      .def("__setstate__", [](Profiler& self, const std::tuple<rig::Rig, light_section::ReferenceProfile>& state) {
        new (&self) Profiler(std::get<0>(state), std::get<1>(state));
      });
}

}  // namespace

void bind_light_section(nb::module_& module) {
  const auto kernel = [](const auto& image, const model::Measure& measure, const model::RunsView& out) {
    light_section::fast_measure_columns(image, measure, out);
  };
  def_moments(module, kernel, "The same as selfproj.model.moments, at the speed of memory.");
  bind_rig(module);
  bind_references(module);
  bind_profiles(module);
  auto inspection = nb::class_<Collected>(module, "Inspection", "Collects frames, for one thread at a time.");
  refuse_pickling(inspection, "is collecting frames; pickle its height(), difference() and belt_mm()");
  inspection
      .def(nb::init<const Profiler&, std::size_t>(), nb::arg("profiler"), nb::arg("max_frames") = 20000,
           "Frames after max_frames are only counted.")
      .def("add", &Collected::add, nb::arg("packet"),
           "Adds the profile of a packet. Returns False, and adds nothing, if it gives none.")
      .def("__len__", [](Collected& self) { return self.get(&light_section::Inspection::frames); })
      .def("__repr__",
           [](Collected& self) {
             return "Inspection(" + std::to_string(self.get(&light_section::Inspection::frames)) + " frames)";
           })
      .def(
          "height", [](Collected& self) { return array_of_image(self.get(&light_section::Inspection::height)); },
          "Heights over the plane in mm, float32, (frames, columns), NaN where there is no point.")
      .def(
          "difference",
          [](Collected& self) { return array_of_image(self.get(&light_section::Inspection::difference)); },
          "Differences from the reference in mm, positive towards the camera.")
      .def(
          "belt_mm",
          [](Collected& self) {
            std::vector<double> moved = self.get(&light_section::Inspection::belt_mm);
            const std::size_t frames = moved.size();
            return array_of(std::move(moved), {frames});
          },
          "How far the belt has moved since the first frame, mm, float64.")
      .def_prop_ro(
          "spacing_mm",
          [](Collected& self) {
            return std::pair(self.get(&light_section::Inspection::frame_spacing_mm),
                             self.get(&light_section::Inspection::column_spacing_mm));
          },
          "Distance of neighbouring frames and of neighbouring columns, mm: row_mm and column_mm of map_png.");
  module.def("save_tiff", &save_tiff, nb::arg("file"), nb::arg("image").noconvert(),
             "Writes a TIFF of 32-bit numbers, whole or not at all. InputError if it cannot be written.");
  module.def(
      "load_tiff", [](const Path& file) { return array_of_image(images::read_float_tiff(file.string())); },
      nb::arg("file"), "Reads such a file: float32, (rows, columns).");
}

}  // namespace selfproj::python
