// The model: moments, decoder, median, matching.
#include <cstddef>
#include <cstdint>

#include "capi/convert.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/model/median3x3.h"

namespace {

constexpr std::int64_t kMaxPixels = std::int64_t{1} << 26;

}  // namespace

struct selfproj_gray {  // NOLINT(readability-identifier-naming): a name of C
  selfproj::model::GrayDecoder decoder;
};

using namespace selfproj;
using namespace selfproj::capi;

std::int32_t selfproj_moments(const selfproj_image* image, const selfproj_measure* measure, std::uint32_t* m0,
                              std::uint32_t* m1, std::uint32_t* n, std::uint8_t* runs, std::uint8_t* second) {
  return guarded([&] {
    const model::Measure how = measure_of(measure);
    model::measure_columns(image_of(image), how, runs_of(how.select, {m0, m1, n}, runs, second));
  });
}

std::int32_t selfproj_gray_create(std::int32_t rows, std::int32_t columns, std::int32_t bits, std::int32_t threshold,
                                  selfproj_gray** out) {
  return guarded([&] {
    require(out != nullptr, "null pointer");
    check_sides(rows, columns);
    require(std::int64_t{rows} * columns <= kMaxPixels, "more than 2^26 pixels");
    *out =
        new selfproj_gray{model::GrayDecoder({.rows = rows, .columns = columns, .bits = bits, .threshold = threshold})};
  });
}

void selfproj_gray_destroy(selfproj_gray* gray) { delete gray; }

std::int32_t selfproj_gray_take(selfproj_gray* gray, const selfproj_image* image, std::int32_t pattern,
                                std::int32_t good, std::uint16_t* codes, std::int32_t* due) {
  return guarded([&] {
    require(gray != nullptr && due != nullptr, "null pointer");
    *due = gray->decoder.add_frame(image_of(image), pattern, good != 0, codes) ? 1 : 0;
  });
}

std::int32_t selfproj_gray_restart(selfproj_gray* gray) {
  return guarded([&] {
    require(gray != nullptr, "null pointer");
    gray->decoder.restart();
  });
}

std::int32_t selfproj_median3x3(const std::uint16_t* codes, std::int32_t rows, std::int32_t columns,
                                std::uint16_t* out) {
  return guarded([&] {
    check_sides(rows, columns);
    model::median3x3(codes, rows, columns, out);
  });
}

std::int32_t selfproj_match(const std::uint16_t* codes, std::size_t count, std::int32_t bits,
                            const std::uint16_t* table, std::uint16_t* lines) {
  return guarded([&] {
    require(codes != nullptr && table != nullptr && lines != nullptr, "null pointer");
    model::GrayMatch::look_up(codes, count, bits, table, lines);
  });
}
