// The model: moments, decoder, median, matching.
#include <cstddef>
#include <cstdint>
#include <memory>

#include "capi/convert.h"
#include "capi/errors.h"
#include "model/column_runs.h"
#include "model/gray_decoder.h"
#include "model/gray_match.h"
#include "model/median3x3.h"

namespace {

constexpr std::int64_t kMostPixels = std::int64_t{1} << 26;

}  // namespace

struct selfproj_gray {  // NOLINT(readability-identifier-naming): a name of C
  selfproj::GrayDecoder decoder;
};

std::int32_t selfproj_moments(const selfproj_image* image, const selfproj_measure* measure, std::uint32_t* m0,
                              std::uint32_t* m1, std::uint32_t* n, std::uint8_t* runs, std::uint8_t* second) {
  using namespace selfproj;
  return guarded([&] {
    const Measure how = measure_of(measure);
    measure_columns(image_of(image), how, runs_of(how.select, {m0, m1, n}, runs, second));
    return SELFPROJ_OK;
  });
}

std::int32_t selfproj_gray_create(std::int32_t rows, std::int32_t columns, std::int32_t bits, std::int32_t threshold,
                                  selfproj_gray** out) {
  using namespace selfproj;
  return guarded([&] {
    require(out != nullptr, "null pointer");
    check_sides(rows, columns);
    require(std::int64_t{rows} * columns <= kMostPixels, "more than 2^26 pixels");
    *out = new selfproj_gray{GrayDecoder({.rows = rows, .columns = columns, .bits = bits, .threshold = threshold})};
    return SELFPROJ_OK;
  });
}

void selfproj_gray_destroy(selfproj_gray* gray) { delete gray; }

std::int32_t selfproj_gray_take(selfproj_gray* gray, const selfproj_image* image, std::int32_t pattern,
                                std::int32_t good, std::uint16_t* codes, std::int32_t* due) {
  using namespace selfproj;
  return guarded([&] {
    require(gray != nullptr && due != nullptr, "null pointer");
    *due = gray->decoder.add_frame(image_of(image), pattern, good != 0, codes) ? 1 : 0;
    return SELFPROJ_OK;
  });
}

std::int32_t selfproj_gray_restart(selfproj_gray* gray) {
  using namespace selfproj;
  return guarded([&] {
    require(gray != nullptr, "null pointer");
    gray->decoder.restart();
    return SELFPROJ_OK;
  });
}

std::int32_t selfproj_median3x3(const std::uint16_t* codes, std::int32_t rows, std::int32_t columns,
                                std::uint16_t* out) {
  using namespace selfproj;
  return guarded([&] {
    check_sides(rows, columns);
    median3x3(codes, rows, columns, out);
    return SELFPROJ_OK;
  });
}

std::int32_t selfproj_match(const std::uint16_t* codes, std::size_t count, std::int32_t bits,
                            const std::uint16_t* table, std::uint16_t* lines) {
  using namespace selfproj;
  return guarded([&] {
    require(codes != nullptr && table != nullptr && lines != nullptr, "null pointer");
    GrayMatch::look_up(codes, count, bits, table, lines);
    return SELFPROJ_OK;
  });
}
