#include "host/light_section/line_finder.h"

#include <cstddef>
#include <cstdint>
#include <stdexcept>
#include <utility>
#include <variant>

#include "selfproj/light_section/fast_moments.h"

namespace selfproj::light_section {

LineFinder::LineFinder(const rig::Rig& rig)
    : camera_(rig.camera),
      measure_(rig.measure.of_board()),
      rig_measure_(rig.measure),
      rules_(line_rules(rig)),
      least_share_(rig.measure.runs ? rig.measure.runs->ambiguous_from : 0) {
  runs_.resize(measure_.select, camera_.columns);
}

void LineFinder::find(const SensorView& image) {
  const auto [rows, columns] = std::visit([](const auto& view) { return std::pair(view.rows, view.columns); }, image);
  const bool whole = rows == camera_.rows && columns == camera_.columns;
  const rig::RigRegion sent = camera_.sent();
  if (!whole && (rows != sent.rows || columns != sent.columns)) {
    throw std::invalid_argument("line finder: an image has another size than the camera's");
  }
  const int first = whole ? 0 : sent.column_offset;
  row_offset_ = whole ? 0 : sent.row_offset;
  rules_ = line_rules(camera_, rig_measure_, row_offset_, rows);
  if (!whole) {
    runs_ = {};
    runs_.resize(measure_.select, camera_.columns);
  }
  const model::RunsView all = runs_.view();
  const model::RunsView seen{{all.moments.m0 + first, all.moments.m1 + first, all.moments.n + first},
                             all.runs == nullptr ? nullptr : all.runs + first,
                             all.second == nullptr ? nullptr : all.second + first};
  std::visit([&](const auto& view) { fast_measure_columns(view, measure_, seen); }, image);
}

Validity LineFinder::validity(std::size_t column) const {
  const std::uint32_t m0 = runs_.moments.m0[column];
  // A profile divides in single precision as well.
  const float c = static_cast<float>(runs_.moments.m1[column]) / static_cast<float>(m0);
  const std::int32_t second = measure_.select == model::Select::all
                                  ? 0
                                  : second_on_board(measure_.mode, runs_.runs[column], runs_.second[column]);
  return static_cast<Validity>(validity_of(c, static_cast<std::int32_t>(m0),
                                           static_cast<std::int32_t>(runs_.moments.n[column]), second, 1,
                                           code(Validity::valid), rules_));
}

}  // namespace selfproj::light_section
