// Of selfproj.structured_light: self-projected stripes, their reference, and depth from them.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <new>
#include <optional>
#include <string>
#include <tuple>
#include <utility>
#include <vector>

#include "host/files/output_folder.h"
#include "host/images/image_files.h"
#include "host/structured_light/match_table.h"
#include "host/structured_light/point_scan.h"
#include "host/structured_light/self_reference.h"
#include "host/structured_light/self_scanner.h"
#include "host/structured_light/sequence_check.h"
#include "python/bindings/arrays.h"
#include "python/bindings/images_input.h"
#include "selfproj/files/user_error.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "selfproj/structured_light/point_cloud.h"

namespace selfproj::python {
namespace {

using structured_light::SelfReference;

// A reference with its rig.
struct StripeReference {
  rig::Rig rig;
  SelfReference reference;
};

Out<const float> view_of(const images::FloatImage& image, nb::handle self) {
  const std::vector<std::size_t> shape = sides_of_image(image.rows, image.columns);
  return {image.values.data(), 2, shape.data(), self};
}

structured_light::Stripes stripes_of(int bits, int width, const std::string& code) {
  require(code == "cyclic" || code == "reflected", "code: must be cyclic or reflected");
  const structured_light::Stripes stripes{
      .bits = bits,
      .width = width,
      .code = code == "cyclic" ? structured_light::StripeCode::cyclic : structured_light::StripeCode::reflected};
  structured_light::check_stripes(stripes);
  return stripes;
}

const rig::Rig& checked_scanner(const rig::Rig& rig) {
  require(rig.kind == rig::RigKind::scanner, "rig: must be of kind scanner");
  return rig;
}

StripeReference stripes_of_points(const rig::Rig& rig, const FloatArray& line, const FloatArray& column, int bits,
                                  int width, const std::string& code) {
  const structured_light::Stripes stripes = stripes_of(bits, width, code);
  structured_light::ProjectorPoints points{float_image_of(line), float_image_of(column)};
  return without_gil([&] {
    return StripeReference{rig, structured_light::make_self_reference(checked_scanner(rig), points, stripes)};
  });
}

template <typename Scan, typename Look>
void add_images(const GivenImages& given, Scan& scan, const Look& look) {
  images::ImageSequence sequence = given.sequence();
  for (std::size_t i = 0; i < given.count(); ++i) {
    const images::Image image = sequence.read(i);
    scan.add(image.view());
    look(i, image.view());
  }
}

structured_light::ProjectorPoints points_of_codes(const rig::Rig& rig, const GivenImages& given, bool unchecked) {
  structured_light::GrayPointScan scan(rig);
  const structured_light::GraySequence sequence(rig.projector.columns, rig.projector.lines);
  const auto columns = static_cast<std::size_t>(sequence.first_of_rows());
  const auto codes = static_cast<std::size_t>(sequence.white());
  structured_light::SequenceCheck of_columns(rig.camera.rows, rig.camera.columns, sequence.column_bits());
  structured_light::SequenceCheck of_lines(rig.camera.rows, rig.camera.columns, sequence.row_bits());
  add_images(given, scan, [&](std::size_t i, const model::ImageView& image) {
    if (i < codes) {
      (i < columns ? of_columns : of_lines).add(static_cast<int>(i < columns ? i : i - columns), image);
    }
  });
  std::string contradiction = structured_light::contradiction_of(of_columns, given.names());
  if (contradiction.empty()) {
    contradiction = structured_light::contradiction_of(
        of_lines, {given.names().begin() + sequence.first_of_rows(), given.names().end()});
  }
  if (!unchecked && !contradiction.empty()) {
    throw UserError("images", contradiction);
  }
  return scan.points();
}

StripeReference stripes_of_scan(const rig::Rig& rig, const ImagesArgument& images, int bits, int width,
                                const std::string& code, const std::string& channel, std::optional<int> shift,
                                bool unchecked) {
  const structured_light::Stripes stripes = stripes_of(bits, width, code);
  checked_scanner(rig);
  const GivenImages given(images, {channel, shift});
  const auto all = static_cast<std::size_t>(structured_light::GrayPointScan(rig).count());
  const auto of_lines = static_cast<std::size_t>(structured_light::LinePointScan(rig).count());
  require(given.count() == all || given.count() + 2 == all || given.count() == of_lines,
          "images: those of the Gray codes of both axes are needed (GraySequence), or one under each line and each "
          "column of the projector");
  {
    images::ImageSequence sequence = given.sequence();
    const images::Image& first = sequence.first();
    require(first.rows == rig.camera.rows && first.columns == rig.camera.columns,
            "images: their size is not that of the rig's camera");
  }
  return without_gil([&] {
    structured_light::ProjectorPoints points;
    if (given.count() == of_lines) {
      structured_light::LinePointScan scan(rig);
      add_images(given, scan, [](std::size_t /*i*/, const model::ImageView& /*image*/) {});
      points = scan.points();
    } else {
      points = points_of_codes(rig, given, unchecked);
    }
    return StripeReference{rig, structured_light::make_self_reference(rig, points, stripes)};
  });
}

Out<std::uint8_t> pattern_of_stripes(const StripeReference& self, int index) {
  if (index < 0 || index >= 2 * self.reference.stripes.bits) {
    throw nb::index_error("there is no such pattern");
  }
  const images::FloatImage light =
      without_gil([&] { return structured_light::self_projected_pattern(self.reference, index); });
  auto image = new_array<std::uint8_t>(sides_of_image(light.rows, light.columns));
  std::transform(light.values.begin(), light.values.end(), image.data(),
                 [](float value) { return static_cast<std::uint8_t>(std::lround(255 * value)); });
  return image;
}

using StripeState = std::tuple<std::string, int, int, int, std::vector<nb::object>, std::vector<std::uint8_t>, int>;

StripeState state_of_stripes(const StripeReference& self) {
  const SelfReference& r = self.reference;
  std::vector<nb::object> images;
  for (const images::FloatImage* image : {&r.points.line, &r.points.column, &r.row, &r.column}) {
    images.push_back(nb::cast(array_of_image(*image)));
  }
  return {rig::to_yaml(self.rig), r.stripes.bits, r.stripes.width, static_cast<int>(r.stripes.code), images, r.seen,
          r.camera_rows};
}

void set_stripes(StripeReference& self, const StripeState& state) {
  const auto& [yaml, bits, width, code, images, seen, camera_rows] = state;
  require(images.size() == 4, "state: is none of a StripeReference");
  SelfReference r;
  r.stripes = stripes_of(bits, width, code == 0 ? "cyclic" : "reflected");
  std::size_t next = 0;
  for (images::FloatImage* image : {&r.points.line, &r.points.column, &r.row, &r.column}) {
    *image = float_image_of(nb::cast<FloatArray>(images[next++]));
  }
  r.seen = seen;
  r.camera_rows = camera_rows;
  new (&self) StripeReference{rig::parse_rig(yaml, "a pickled rig"), std::move(r)};
}

// A depth image, and its difference from the reference.
struct StripeScan {
  Out<float> depth, difference;
  Out<float> points;
};

// Depth after every pair, for one thread at a time.
class StripeScanner {
 public:
  StripeScanner(const StripeReference& reference, std::optional<int> e, int threshold, bool printed_direction,
                bool printed_window)
      : reference_(reference),
        table_(without_gil([&] {
          return structured_light::MatchTable(reference_.rig, reference_.reference,
                                              {.e = e.value_or((1 << reference_.reference.stripes.bits) / 2),
                                               .printed_direction = printed_direction,
                                               .printed_window = printed_window});
        })),
        scanner_(without_gil([&] {
          require(threshold >= 0 && threshold <= 255, "threshold: must be in 0..255");
          return std::make_unique<structured_light::SelfScanner>(reference_.rig, reference_.reference, table_,
                                                                 threshold);
        })) {}
  StripeScanner(const StripeScanner&) = delete;
  StripeScanner& operator=(const StripeScanner&) = delete;
  ~StripeScanner() = default;

  std::optional<StripeScan> take(const In<std::uint8_t>& image, int pattern, bool good) {
    const Busy::Entered entered(busy_);
    const model::ImageView view = image_of(image);
    require(view.rows == table_.rows() && view.columns == table_.columns(),
            "image: its size is not that of the rig's camera");
    if (!without_gil([&] { return scanner_->add_frame(positive_.keep(view, pattern), pattern, good); })) {
      return std::nullopt;
    }
    return newest();
  }

  StripeScan scan(const ImagesArgument& images, const std::string& channel, std::optional<int> shift, bool unchecked) {
    const Busy::Entered entered(busy_);
    const GivenImages given(images, {channel, shift});
    const auto patterns = 2 * static_cast<std::size_t>(table_.bits());
    require(given.count() >= patterns && given.count() % 2 == 0,
            "images: at least 2 for each bit of the stripes are needed, in pairs");
    without_gil([&] {
      images::ImageSequence sequence = given.sequence();
      scanner_->restart();
      structured_light::SequenceCheck check(table_.rows(), table_.columns(), table_.bits(), true);
      std::vector<std::string> names(patterns);
      images::Image kept;
      for (std::size_t i = 0; i < given.count(); ++i) {
        images::Image image = sequence.read(i);
        if (image.rows != table_.rows() || image.columns != table_.columns()) {
          throw UserError(given.names()[i], "has not the size of the rig's camera");
        }
        const auto pattern = static_cast<int>(i % patterns);
        check.add(pattern, image.view());
        names[i % patterns] = given.names()[i];
        scanner_->add_frame(image.view(), pattern);
        kept = std::move(image);  // the positive of a pair is read again with its negative
      }
      const std::string contradiction = structured_light::contradiction_of(check, names, *scanner_);
      scanner_->restart();
      if (!unchecked && !contradiction.empty()) {
        throw UserError("images", contradiction);
      }
    });
    return newest();
  }

  void restart() {
    const Busy::Entered entered(busy_);
    scanner_->restart();
  }

  [[nodiscard]] Out<std::uint16_t> table() const {
    std::vector<std::uint16_t> words = without_gil([&] { return table_.by_pixels(); });
    return array_of(std::move(words),
                    {static_cast<std::size_t>(table_.rows()), static_cast<std::size_t>(table_.columns()),
                     std::size_t{1} << static_cast<unsigned>(table_.bits())});
  }
  [[nodiscard]] const structured_light::MatchTable& matches() const { return table_; }
  [[nodiscard]] Out<float> reference_depth() const { return array_of_image(scanner_->reference_depth()); }

 private:
  [[nodiscard]] StripeScan newest() const {
    const images::FloatImage& depth = scanner_->depth();
    std::vector<float> points;
    for (std::size_t i = 0; i < depth.values.size(); ++i) {
      if (!std::isnan(depth.values[i])) {
        const structured_light::Point3f point = scanner_->triangulation().point(i, depth.values[i]);
        points.insert(points.end(), {point.x, point.y, point.z});
      }
    }
    const std::size_t count = points.size() / 3;
    return {array_of_image(depth), array_of_image(scanner_->difference()), array_of(std::move(points), {count, 3})};
  }

  StripeReference reference_;
  structured_light::MatchTable table_;
  std::unique_ptr<structured_light::SelfScanner> scanner_;
  KeptPositive positive_;
  Busy busy_;
};

void bind_stripe_reference(nb::module_& module) {
  using Self = nb::pointer_and_handle<StripeReference>;
  nb::class_<StripeReference>(module, "StripeReference",
                              "The reference of self-projected stripes: which projector point each camera pixel sees\n"
                              "on it, and the patterns that the camera then sees as straight stripes.")
      .def_prop_ro(
          "rig", [](const StripeReference& self) { return self.rig; }, "A copy of its rig.")
      .def_prop_ro(
          "bits", [](const StripeReference& self) { return self.reference.stripes.bits; }, "m: 2 m patterns.")
      .def_prop_ro(
          "line", [](Self self) { return view_of(self.p->reference.points.line, self.h); },
          "Projector line that each camera pixel sees, from 0, float32, NaN where there is none; read-only.")
      .def_prop_ro(
          "column", [](Self self) { return view_of(self.p->reference.points.column, self.h); }, "The projector column.")
      .def_prop_ro(
          "camera_row", [](Self self) { return view_of(self.p->reference.row, self.h); },
          "f_R: camera row that each projector pixel lights, (lines, columns) of the projector.")
      .def_prop_ro(
          "camera_column", [](Self self) { return view_of(self.p->reference.column, self.h); },
          "f_R: the camera column.")
      .def("pattern", &pattern_of_stripes, nb::arg("index"),
           "Pattern 0..2m - 1 for the projector, positives and negatives by turns: uint8, 0 or 255. IndexError if\n"
           "there is none.")
      .def(
          "save",
          [](const StripeReference& self, const Path& name) {
            without_gil([&] {
              files::OutputFolder folder(name.string());
              structured_light::write_self_reference(self.rig, self.reference, folder);
              folder.commit();
            });
          },
          nb::arg("folder"), "Writes the folder that `selfproj match --reference` takes.")
      .def("__repr__",
           [](const StripeReference& self) {
             return "StripeReference('" + self.rig.name + "', bits=" + std::to_string(self.reference.stripes.bits) +
                    ", width=" + std::to_string(self.reference.stripes.width) + ")";
           })
      .def("__getstate__", &state_of_stripes)
      .def("__setstate__", &set_stripes);
  module.def("stripes_of_scan", &stripes_of_scan, nb::arg("rig"), nb::arg("images").noconvert(), nb::arg("bits") = 4,
             nb::arg("width") = 2, nb::arg("code") = "cyclic", nb::arg("channel") = "", nb::arg("shift") = nb::none(),
             nb::arg("unchecked") = false,
             "The reference from images of it: under all of GraySequence(columns, lines) of the rig's projector, or\n"
             "under each line and each column. Array, list of arrays, folder or files. code: cyclic or reflected.\n"
             "InputError where the images contradict each other, unless unchecked.");
  module.def("stripes_of_points", &stripes_of_points, nb::arg("rig"), nb::arg("line").noconvert(),
             nb::arg("column").noconvert(), nb::arg("bits") = 4, nb::arg("width") = 2, nb::arg("code") = "cyclic",
             "The reference from the projector line and column that each camera pixel sees: float32, NaN for none.");
  module.def(
      "load_stripes",
      [](const rig::Rig& rig, const Path& folder) {
        return without_gil([&] {
          return StripeReference{rig, structured_light::read_self_reference(rig, folder.string())};
        });
      },
      nb::arg("rig"), nb::arg("folder"), "The reference of a folder of `selfproj pattern stripes`, or of save().");
}

void bind_stripe_scanner(nb::module_& module) {
  nb::class_<StripeScan>(module, "StripeScan", "A depth image from self-projected stripes.")
      .def_ro("depth", &StripeScan::depth, nb::rv_policy::reference, "z in mm, float32, NaN where there is none.")
      .def_ro("difference", &StripeScan::difference, nb::rv_policy::reference,
              "z of the reference less z, mm: positive towards the camera.")
      .def(
          "points", [](const StripeScan& self) { return self.points; }, nb::rv_policy::reference,
          "The points x, y, z in mm, float32, (n, 3).")
      .def("__repr__", [](const StripeScan& self) { return shape_text("StripeScan", sides_of(self.depth)); })
      .def("__getstate__",
           [](const StripeScan& self) {
             return nb::make_tuple(pickled(self.depth), pickled(self.difference), pickled(self.points));
           })
      .def("__setstate__", [](StripeScan& self, const nb::tuple& state) {
        require(state.size() == 3, "state: is none of a StripeScan");
        new (&self)
            StripeScan{nb::cast<Out<float>>(state[0]), nb::cast<Out<float>>(state[1]), nb::cast<Out<float>>(state[2])};
      });
  auto scanner = nb::class_<StripeScanner>(
      module, "StripeScanner",
      "Depth from images under the stripes of a reference, as `selfproj match`; for one thread\n"
      "at a time. It searches all matches when it is made.");
  refuse_pickling(scanner, "is in the midst of a cycle of images; pickle its StripeReference and its results");
  scanner
      .def(nb::init<const StripeReference&, std::optional<int>, int, bool, bool>(), nb::arg("reference"),
           nb::arg("e") = nb::none(), nb::arg("threshold") = 5, nb::arg("printed_direction") = false,
           nb::arg("printed_window") = false,
           "e: cells below the reference that are searched, 0..2^m - 1; None: half of them. printed_...: the forms\n"
           "of the text, which are wrong for references that vary.")
      .def("take", &StripeScanner::take, nb::arg("image").noconvert(), nb::arg("pattern"), nb::arg("good") = true,
           "Takes a frame with its pattern index. Returns a StripeScan if one is due, after every pair, else None.")
      .def("scan", &StripeScanner::scan, nb::arg("images").noconvert(), nb::arg("channel") = "",
           nb::arg("shift") = nb::none(), nb::arg("unchecked") = false,
           "The newest StripeScan of images that begin with pattern 0: array, list of arrays, folder or files.\n"
           "InputError where they contradict each other, or are not of this reference's patterns, unless unchecked.")
      .def("restart", &StripeScanner::restart, "Waits for pattern 0.")
      .def_prop_ro("table", &StripeScanner::table, nb::rv_policy::reference,
                   "The matches for selfproj.model.match, and for the board: uint16, (rows, columns, 2^m).")
      .def_prop_ro("reference_depth", &StripeScanner::reference_depth, nb::rv_policy::reference,
                   "z of the reference in mm, float32.")
      .def_prop_ro(
          "missing", [](const StripeScanner& self) { return self.matches().missing(); },
          "Share of codes without a match, 0..1.")
      .def_prop_ro(
          "doubled", [](const StripeScanner& self) { return self.matches().doubled(); }, "Share of codes with several.")
      .def("__repr__", [](const StripeScanner& self) {
        return shape_text("StripeScanner", sides_of_image(self.matches().rows(), self.matches().columns()));
      });
}

}  // namespace

void bind_stripes(nb::module_& module) {
  bind_stripe_reference(module);
  bind_stripe_scanner(module);
}

}  // namespace selfproj::python
