// selfproj.parts: parts cut out of what is measured, tolerances, verdicts.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/unique_ptr.h>
#include <nanobind/stl/variant.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <memory>
#include <new>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <variant>
#include <vector>

#include "host/files/input_file.h"
#include "host/files/json_text.h"
#include "host/files/output_file.h"
#include "host/production/classifier.h"
#include "host/production/cutter.h"
#include "host/production/height_map.h"
#include "host/production/learn.h"
#include "host/production/part_reference.h"
#include "host/production/part_result.h"
#include "host/production/tolerance.h"
#include "python/bindings/arrays.h"
#include "python/bindings/packet_view.h"
#include "python/bindings/profiler.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::python {
namespace {

using production::CutPart;
using production::PartResult;
using production::Tolerance;

// What a part is compared with: the section of a light section, or a depth image.
using PartReference = std::variant<Profiler, std::tuple<rig::Rig, FloatArray>>;

std::int64_t now_ns() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

images::FloatImage depth_of_camera(const rig::Rig& rig, const FloatArray& depth) {
  images::FloatImage image = float_image_of(depth);
  require(image.rows == rig.camera.rows && image.columns == rig.camera.columns,
          "depth: its size is not that of the rig's camera");
  return image;
}

production::SectionReference section_of_profiler(const Profiler& profiler) {
  return production::section_of(profiler.rig(), profiler.reference(), profiler.profiler());
}

production::HeightCells cells_of_depth(const rig::Rig& rig, const FloatArray& depth) {
  production::DepthGrid grid(rig);
  return grid.cells(depth_of_camera(rig, depth));
}

// Cuts profiles, for one thread at a time.
class ProfileCutting {
 public:
  explicit ProfileCutting(const Profiler& profiler) : profiler_(profiler), cutter_(profiler.rig()) {
    profile_.resize(profiler.profiler().columns());
  }

  std::optional<CutPart> add(const PacketHandle& packet) {
    const Busy::Entered entered(busy_);
    const model::PacketView& view = packet.view();
    const PacketHandle::Use use(packet);
    return without_gil([&]() -> std::optional<CutPart> {
      return profiler_.profiler().profile(view, profile_.view()) ? cutter_.add(view.header, profile_.view(), now_ns())
                                                                 : std::nullopt;
    });
  }
  std::optional<CutPart> finish() {
    const Busy::Entered entered(busy_);
    return cutter_.finish();
  }
  [[nodiscard]] std::uint64_t specks() const { return cutter_.specks(); }
  [[nodiscard]] std::string text() const { return "Cutter('" + profiler_.rig().name + "')"; }

 private:
  Profiler profiler_;
  production::ProfileCutter cutter_;
  light_section::Profile profile_;
  Busy busy_;
};

// A part from heights that were measured elsewhere.
CutPart part_of_heights(const FloatArray& heights, double pitch_mm, double along_mm, double across_mm) {
  require(pitch_mm > 0 && std::isfinite(along_mm) && std::isfinite(across_mm), "pitch_mm: must be above 0");
  CutPart part;
  part.cells.height = float_image_of(heights);
  part.cells.grid = {part.cells.height.rows, part.cells.height.columns, pitch_mm, along_mm, across_mm};
  part.cells.weight = images::FloatImage(part.cells.height.rows, part.cells.height.columns);
  for (std::size_t i = 0; i < part.cells.height.values.size(); ++i) {
    part.cells.weight.values[i] = std::isnan(part.cells.height.values[i]) ? 0.0F : 1.0F;
  }
  part.length_mm = pitch_mm * (part.cells.height.rows - 1);
  return part;
}

CutPart part_of_depth(const rig::Rig& rig, const FloatArray& depth) {
  CutPart part;
  part.cells = cells_of_depth(rig, depth);
  part.length_mm = part.cells.grid.pitch_mm * (part.cells.grid.rows - 1);
  return part;
}

nb::tuple state_of_part(const CutPart& p) {
  const production::MapGrid& g = p.cells.grid;
  return nb::make_tuple(array_of_image(p.cells.height), array_of_image(p.cells.weight),
                        std::vector<double>{g.pitch_mm, g.along_mm, g.across_mm, p.begin_mm, p.length_mm},
                        std::vector<std::uint64_t>{p.first, p.last, p.frames, p.missing}, p.too_long, p.restarted,
                        p.cut_off);
}

void set_part(CutPart& self, const nb::tuple& state) {
  require(state.size() == 7, "state: is none of a Part");
  CutPart p;
  p.cells.height = float_image_of(nb::cast<FloatArray>(state[0]));
  p.cells.weight = float_image_of(nb::cast<FloatArray>(state[1]));
  const auto numbers = nb::cast<std::vector<double>>(state[2]);
  const auto counts = nb::cast<std::vector<std::uint64_t>>(state[3]);
  require(numbers.size() == 5 && counts.size() == 4, "state: is none of a Part");
  p.cells.grid = {p.cells.height.rows, p.cells.height.columns, numbers[0], numbers[1], numbers[2]};
  p.begin_mm = numbers[3];
  p.length_mm = numbers[4];
  p.first = counts[0], p.last = counts[1], p.frames = counts[2], p.missing = counts[3];
  p.too_long = nb::cast<bool>(state[4]);
  p.restarted = nb::cast<bool>(state[5]);
  p.cut_off = nb::cast<bool>(state[6]);
  new (&self) CutPart(std::move(p));
}

// A result with its maps.
struct Judged {
  PartResult result;
  production::PlacedMaps maps;
};

// Pickled as their numbers.
using DefectState = std::tuple<std::string, std::array<double, 6>>;
using RegionState = std::tuple<std::string, std::array<double, 4>>;

DefectState state_of_defect(const production::Defect& d) {
  return {d.region, {d.along_mm, d.across_mm, d.size_along_mm, d.size_across_mm, d.area_mm2, d.depth_mm}};
}

production::Defect defect_of(const DefectState& state) {
  const auto& [region, n] = state;
  return {region, n[0], n[1], n[2], n[3], n[4], n[5]};
}

using PlacementState = std::tuple<std::array<double, 5>, std::optional<double>, std::optional<double>, std::string>;

// A map without cells is None.
nb::object state_of_map(const images::FloatImage& map) {
  return map.values.empty() ? nb::none() : nb::cast(array_of_image(map));
}

images::FloatImage map_of(const nb::handle& state) {
  return state.is_none() ? images::FloatImage() : float_image_of(nb::cast<FloatArray>(state));
}

nb::tuple state_of_result(const Judged& self) {
  const PartResult& r = self.result;
  std::vector<DefectState> defects;
  std::transform(r.defects.begin(), r.defects.end(), std::back_inserter(defects), state_of_defect);
  std::vector<RegionState> regions;
  for (const production::RegionFigures& f : r.regions) {
    regions.emplace_back(f.name, std::array{f.missing, f.mean_mm, f.lowest_mm, f.highest_mm});
  }
  std::optional<PlacementState> placement;
  if (r.placement) {
    const production::Placement& p = *r.placement;
    placement = {{p.along_mm, p.offset_mm, p.turn_rad, p.across_mm, p.residual_mm}, p.length_mm, p.width_mm, p.edges};
  }
  const production::MapGrid& g = self.maps.grid;
  return nb::make_tuple(std::vector<std::uint64_t>{r.number, static_cast<std::uint64_t>(r.verdict), r.first_frame,
                                                   r.last_frame, r.frames, r.missing_frames},
                        r.reason, defects, regions, placement,
                        std::vector<double>{r.begin_mm, r.length_mm, g.pitch_mm, g.along_mm, g.across_mm},
                        std::pair(g.rows, g.columns), state_of_map(self.maps.height),
                        state_of_map(self.maps.difference));
}

void set_result(Judged& self, const nb::tuple& state) {
  require(state.size() == 9, "state: is none of a PartResult");
  const auto counts = nb::cast<std::vector<std::uint64_t>>(state[0]);
  const auto numbers = nb::cast<std::vector<double>>(state[5]);
  require(counts.size() == 6 && counts[1] < production::kVerdictNames.size() && numbers.size() == 5,
          "state: is none of a PartResult");
  Judged judged;
  PartResult& r = judged.result;
  r.number = counts[0], r.verdict = static_cast<production::Verdict>(counts[1]);
  r.first_frame = counts[2], r.last_frame = counts[3], r.frames = counts[4], r.missing_frames = counts[5];
  r.reason = nb::cast<std::string>(state[1]);
  for (const DefectState& defect : nb::cast<std::vector<DefectState>>(state[2])) {
    r.defects.push_back(defect_of(defect));
  }
  for (const auto& [name, n] : nb::cast<std::vector<RegionState>>(state[3])) {
    r.regions.push_back({name, n[0], n[1], n[2], n[3]});
  }
  if (const auto placement = nb::cast<std::optional<PlacementState>>(state[4])) {
    const auto& [n, length, width, edges] = *placement;
    r.placement = {n[0], n[1], n[2], n[3], n[4], length, width, edges};
  }
  r.begin_mm = numbers[0], r.length_mm = numbers[1];
  const auto sides = nb::cast<std::pair<int, int>>(state[6]);
  judged.maps = {{sides.first, sides.second, numbers[2], numbers[3], numbers[4]}, map_of(state[7]), map_of(state[8])};
  new (&self) Judged(std::move(judged));
}

// Places and classifies parts; any number of threads may use it at once.
class Judge {
 public:
  Judge(const PartReference& reference, const Tolerance& tolerance)
      : reference_(kept(reference)), tolerance_(tolerance), classifier_(make(reference, tolerance)) {}

  [[nodiscard]] Judged classify(const CutPart& part) const {
    return without_gil([&] {
      Judged judged;
      judged.result = classifier_.classify(part, judged.maps);
      return judged;
    });
  }

  // What it was made of.
  [[nodiscard]] nb::object reference() const {
    if (const auto* profiler = std::get_if<Profiler>(&reference_)) {
      return nb::cast(*profiler);
    }
    const auto& [rig, depth] = std::get<1>(reference_);
    return nb::make_tuple(rig, array_of_image(depth));
  }
  [[nodiscard]] const Tolerance& tolerance() const { return tolerance_; }

 private:
  using Kept = std::variant<Profiler, std::pair<rig::Rig, images::FloatImage>>;  // without objects of Python

  static Kept kept(const PartReference& reference) {
    if (const auto* profiler = std::get_if<Profiler>(&reference)) {
      return *profiler;
    }
    const auto& [rig, depth] = std::get<1>(reference);
    return std::pair(rig, float_image_of(depth));
  }
  static production::Classifier make(const PartReference& reference, const Tolerance& tolerance) {
    if (const auto* profiler = std::get_if<Profiler>(&reference)) {
      return {profiler->rig(), section_of_profiler(*profiler), tolerance, "tolerance"};
    }
    const auto& [rig, depth] = std::get<1>(reference);
    return {rig, cells_of_depth(rig, depth), tolerance, "tolerance"};
  }

  Kept reference_;
  Tolerance tolerance_;
  production::Classifier classifier_;
};

Tolerance learn_tolerance(const PartReference& reference, const std::vector<CutPart>& parts, double min_defect_mm2,
                          double edge_mm, double spreads, double max_shift_mm, double max_turn_deg) {
  require(min_defect_mm2 > 0 && edge_mm >= 0 && spreads >= 1 && max_shift_mm >= 0 && max_turn_deg >= 0,
          "min_defect_mm2 must be above 0, spreads 1 or more, the others 0 or more");
  production::LearnOptions options;
  options.min_defect_mm2 = min_defect_mm2;
  options.edge_mm = edge_mm;
  options.spreads = spreads;
  options.max_shift_mm = max_shift_mm;
  options.max_turn_deg = max_turn_deg;
  const auto learn = [&](production::Learner learner) {
    return without_gil([&] {
      for (const CutPart& part : parts) {
        learner.add(CutPart(part));
      }
      return learner.learn("parts");
    });
  };
  if (const auto* profiler = std::get_if<Profiler>(&reference)) {
    return learn({profiler->rig(), section_of_profiler(*profiler), options});
  }
  const auto& [rig, depth] = std::get<1>(reference);
  return learn({rig, cells_of_depth(rig, depth), options});
}

void bind_part(nb::module_& module) {
  nb::class_<CutPart>(module, "Part", "A part as it was cut out of the stream: heights on an even grid.")
      .def(
          "__init__",
          [](CutPart* self, const FloatArray& heights, double pitch_mm, double along_mm, double across_mm) {
            new (self) CutPart(part_of_heights(heights, pitch_mm, along_mm, across_mm));
          },
          nb::arg("heights").noconvert(), nb::arg("pitch_mm"), nb::arg("along_mm") = 0.0, nb::arg("across_mm") = 0.0,
          "Of heights above the belt in mm, float32, rows along the belt, NaN where there is none. along_mm and\n"
          "across_mm: the place of the first cell.")
      .def_prop_ro(
          "heights", [](const CutPart& self) { return array_of_image(self.cells.height); }, nb::rv_policy::reference,
          "mm above the belt, float32, a copy; NaN where nothing was seen.")
      .def_prop_ro(
          "pitch_mm", [](const CutPart& self) { return self.cells.grid.pitch_mm; }, "Distance of cells.")
      .def_prop_ro(
          "along_mm", [](const CutPart& self) { return self.cells.grid.along_mm; }, "Of the first row.")
      .def_prop_ro(
          "across_mm", [](const CutPart& self) { return self.cells.grid.across_mm; }, "Of the first column.")
      .def_ro("begin_mm", &CutPart::begin_mm, "Where the belt was at its first frame.")
      .def_ro("length_mm", &CutPart::length_mm)
      .def_ro("frames", &CutPart::frames)
      .def_ro("missing_frames", &CutPart::missing)
      .def("__repr__",
           [](const CutPart& self) {
             return shape_text("Part", sides_of_image(self.cells.grid.rows, self.cells.grid.columns));
           })
      .def("__getstate__", &state_of_part)
      .def("__setstate__", &set_part);
  auto cutter = nb::class_<ProfileCutting>(
      module, "Cutter",
      "Cuts the profiles of packets into parts, by the section `parts` of the profiler's rig;\n"
      "for one thread at a time.");
  refuse_pickling(cutter, "is in the midst of a stream; pickle the parts that it gave");
  cutter.def(nb::init<const Profiler&>(), nb::arg("profiler"), "InputError if the rig has no section `parts`.")
      .def("add", &ProfileCutting::add, nb::arg("packet"),
           "Takes the next packet. Returns the Part that is then complete, else None.")
      .def("finish", &ProfileCutting::finish, "No packet comes any more: returns the Part that is there so far.")
      .def_prop_ro("specks", &ProfileCutting::specks, "How often something was too short to be a part.")
      .def("__repr__", &ProfileCutting::text);
  module.def("part_of_depth", &part_of_depth, nb::arg("rig"), nb::arg("depth").noconvert(),
             "The part that a depth image of the rig's camera shows: z in mm, float32, NaN where there is none.");
}

void bind_tolerance(nb::module_& module) {
  nb::class_<Tolerance>(module, "Tolerance", "What a good part may be (docs/parts.md).")
      .def_ro("length_mm", &Tolerance::length_mm)
      .def_prop_ro("width_mm", [](const Tolerance& self) { return self.right_mm - self.left_mm; })
      .def_prop_ro(
          "regions",
          [](const Tolerance& self) {
            std::vector<std::tuple<std::string, double, double, double>> regions;
            for (const production::ToleranceRegion& region : self.regions) {
              regions.emplace_back(region.name, region.low_mm, region.high_mm, region.max_missing);
            }
            return regions;
          },
          "Of each region: name, lowest and highest difference in mm, and the share of points that may be missing.")
      .def(
          "to_yaml", [](const Tolerance& self) { return production::to_yaml(self); }, "The text of its file.")
      .def(
          "save",
          [](const Tolerance& self, const Path& file) {
            files::OutputFile(file.string()).write(production::to_yaml(self));
          },
          nb::arg("file"), "Writes the file that `selfproj inspect --tolerance` takes.")
      .def("__repr__",
           [](const Tolerance& self) { return "Tolerance(" + std::to_string(self.regions.size()) + " regions)"; })
      .def("__getstate__", [](const Tolerance& self) { return production::to_yaml(self); })
      .def("__setstate__", [](Tolerance& self, const std::string& yaml) {
        new (&self) Tolerance(production::parse_tolerance(yaml, "a pickled tolerance"));
      });
  module.def(
      "load_tolerance", [](const Path& file) { return production::load_tolerance(file.string()); }, nb::arg("file"),
      "Reads a tolerance file. InputError with file, line and reason.");
  module.def("learn", &learn_tolerance, nb::arg("reference"), nb::arg("parts"), nb::arg("min_defect_mm2") = 0.5,
             nb::arg("edge_mm") = 1.5, nb::arg("spreads") = 6.0, nb::arg("max_shift_mm") = 2.0,
             nb::arg("max_turn_deg") = 3.0,
             "The tolerance of 5 or more good parts, as `selfproj tolerance learn`. reference: the profiler of a\n"
             "light section, or (rig, depth image of the reference) of a scanner. InputError if they do not suffice.");
}

void bind_results(nb::module_& module) {
  nb::class_<production::Defect>(module, "Defect", "A place outside the band of its region.")
      .def_ro("region", &production::Defect::region)
      .def_ro("along_mm", &production::Defect::along_mm, "Its middle on the placed map.")
      .def_ro("across_mm", &production::Defect::across_mm)
      .def_ro("size_along_mm", &production::Defect::size_along_mm)
      .def_ro("size_across_mm", &production::Defect::size_across_mm)
      .def_ro("area_mm2", &production::Defect::area_mm2)
      .def_ro("depth_mm", &production::Defect::depth_mm, "From the middle of the band; less than 0 is too low.")
      .def("__repr__",
           [](const production::Defect& self) {
             return "Defect('" + self.region + "', area_mm2=" + std::to_string(self.area_mm2) +
                    ", depth_mm=" + std::to_string(self.depth_mm) + ")";
           })
      .def("__getstate__", &state_of_defect)
      .def("__setstate__", [](production::Defect& self, const DefectState& state) {
        new (&self) production::Defect(defect_of(state));
      });
  nb::class_<Judged>(module, "PartResult", "The verdict on a part.")
      .def_prop_ro(
          "verdict", [](const Judged& self) { return production::verdict_name(self.result.verdict); },
          "good, bad or inconclusive.")
      .def_prop_ro(
          "reason", [](const Judged& self) { return self.result.reason; }, "One line; empty if good.")
      .def_prop_ro(
          "defects", [](const Judged& self) { return self.result.defects; }, "A list of Defect.")
      .def_prop_ro(
          "heights", [](const Judged& self) { return array_of_image(self.maps.height); }, nb::rv_policy::reference,
          "Heights placed on the reference, mm, float32, a copy.")
      .def_prop_ro(
          "difference", [](const Judged& self) { return array_of_image(self.maps.difference); },
          nb::rv_policy::reference, "Heights less those of the reference, mm, float32, a copy.")
      .def_prop_ro(
          "pitch_mm", [](const Judged& self) { return self.maps.grid.pitch_mm; }, "Distance of cells.")
      .def(
          "json", [](const Judged& self) { return files::json_text(production::part_json(self.result), 2); },
          "As parts.jsonl has it (docs/parts.md).")
      .def("__repr__",
           [](const Judged& self) {
             return std::string("PartResult('") + production::verdict_name(self.result.verdict) + "', " +
                    std::to_string(self.result.defects.size()) + " defects)";
           })
      .def("__getstate__", &state_of_result)
      .def("__setstate__", &set_result);
  nb::class_<Judge>(module, "Classifier",
                    "Places parts on the reference and compares them with a tolerance; any number of threads may use\n"
                    "it at once.")
      .def(nb::init<const PartReference&, const Tolerance&>(), nb::arg("reference"), nb::arg("tolerance"),
           "reference: as in learn. InputError if the tolerance is of another part.")
      .def("classify", &Judge::classify, nb::arg("part"), "The PartResult of a Part.")
      .def("__repr__",
           [](const Judge& self) {
             return "Classifier(" + std::to_string(self.tolerance().regions.size()) + " regions)";
           })
      .def("__getstate__", [](const Judge& self) { return nb::make_tuple(self.reference(), self.tolerance()); })
      .def("__setstate__", [](Judge& self, const std::tuple<PartReference, Tolerance>& state) {
        new (&self) Judge(std::get<0>(state), std::get<1>(state));
      });
}

}  // namespace

void bind_parts(nb::module_& module) {
  bind_part(module);
  bind_tolerance(module);
  bind_results(module);
}

}  // namespace selfproj::python
