/* Between the arrays of SystemVerilog and selfproj.h, for selfproj_dpi_pkg.sv. Compiled by the simulator: as C, or by
 * Verilator as C++. */
#include <selfproj.h>
#include <string.h>
#include <svdpi.h>

#ifdef __cplusplus
extern "C" {
#endif

static const char* last_error = "";

static int fail(const char* text) {
  last_error = text;
  return SELFPROJ_BAD_ARGUMENT;
}

/* The result of a function of selfproj.h. */
static int result(int32_t returned) {
  if (returned < 0) last_error = selfproj_last_error();
  return returned;
}

/* The entries of an array, or null if it has fewer than `min_count` entries. */
static void* entries(const svOpenArrayHandle array, long long min_count) {
  if (min_count < 0 || svDimensions(array) != 1 || svSize(array, 1) < min_count) return NULL;
  return svGetArrayPtr(array);
}

static selfproj_measure measure_of(int mode, int threshold, int select, int gap, int first_row, int last_row) {
  selfproj_measure measure;
  memset(&measure, 0, sizeof measure);
  measure.size = sizeof measure;
  measure.mode = mode;
  measure.threshold = threshold;
  measure.select = select;
  measure.gap = gap;
  measure.first_row = first_row;
  measure.last_row = last_row;
  return measure;
}

const char* selfproj_dpi_last_error(void) { return last_error; }

int selfproj_dpi_moments(const svOpenArrayHandle pixels, int rows, int columns, int mode, int threshold, int select,
                         int gap, int first_row, int last_row, const svOpenArrayHandle m0, const svOpenArrayHandle m1,
                         const svOpenArrayHandle n, const svOpenArrayHandle runs, const svOpenArrayHandle second) {
  const selfproj_measure measure = measure_of(mode, threshold, select, gap, first_row, last_row);
  const selfproj_image image = {(const uint8_t*)entries(pixels, (long long)rows * columns), rows, columns, columns};
  return result(selfproj_moments(&image, &measure, (uint32_t*)entries(m0, columns), (uint32_t*)entries(m1, columns),
                                 (uint32_t*)entries(n, columns), (uint8_t*)entries(runs, columns),
                                 (uint8_t*)entries(second, columns)));
}

int selfproj_dpi_pack(int select, int mode, int columns, const svOpenArrayHandle m0, const svOpenArrayHandle m1,
                      const svOpenArrayHandle n, const svOpenArrayHandle runs, const svOpenArrayHandle second,
                      const svOpenArrayHandle payload) {
  size_t bytes = 0;
  int32_t returned = selfproj_payload_bytes(SELFPROJ_KIND_MOMENTS, mode, columns, &bytes);
  if (returned < 0) return result(returned);
  returned = selfproj_pack_moments(select, mode, columns, (const uint32_t*)entries(m0, columns),
                                   (const uint32_t*)entries(m1, columns), (const uint32_t*)entries(n, columns),
                                   (const uint8_t*)entries(runs, columns), (const uint8_t*)entries(second, columns),
                                   (uint8_t*)entries(payload, (long long)bytes), bytes);
  return returned < 0 ? result(returned) : (int)bytes;
}

int selfproj_dpi_packet(const svOpenArrayHandle pixels, int rows, int columns, int mode, int threshold, int select,
                        int gap, int first_row, int last_row, unsigned long long sequence_number,
                        unsigned long long time_stamp, unsigned encoder, const svOpenArrayHandle packet) {
  const selfproj_measure measure = measure_of(mode, threshold, select, gap, first_row, last_row);
  const selfproj_image image = {(const uint8_t*)entries(pixels, (long long)rows * columns), rows, columns, columns};
  selfproj_header header;
  size_t written = 0;
  int32_t returned;
  memset(&header, 0, sizeof header);
  header.size = sizeof header;
  header.sequence = sequence_number;
  header.time_stamp = time_stamp;
  header.encoder = encoder;
  returned = selfproj_moments_packet(&image, &measure, &header, (uint8_t*)entries(packet, 0), (size_t)svSize(packet, 1),
                                     &written);
  return returned < 0 ? result(returned) : (int)written;
}

void* selfproj_dpi_gray_create(int rows, int columns, int bits, int threshold) {
  selfproj_gray* gray = NULL;
  return result(selfproj_gray_create(rows, columns, bits, threshold, &gray)) < 0 ? NULL : gray;
}

void selfproj_dpi_gray_destroy(void* gray) { selfproj_gray_destroy((selfproj_gray*)gray); }

int selfproj_dpi_gray_take(void* gray, const svOpenArrayHandle pixels, int rows, int columns, int pattern, int good,
                           const svOpenArrayHandle codes) {
  const selfproj_image image = {(const uint8_t*)entries(pixels, (long long)rows * columns), rows, columns, columns};
  int32_t due = 0;
  const int32_t returned = selfproj_gray_take((selfproj_gray*)gray, &image, pattern, good,
                                              (uint16_t*)entries(codes, (long long)rows * columns), &due);
  return returned < 0 ? result(returned) : due;
}

int selfproj_dpi_median3x3(const svOpenArrayHandle codes, int rows, int columns, const svOpenArrayHandle filtered) {
  return result(selfproj_median3x3((const uint16_t*)entries(codes, (long long)rows * columns), rows, columns,
                                   (uint16_t*)entries(filtered, (long long)rows * columns)));
}

int selfproj_dpi_match(const svOpenArrayHandle codes, int count, int bits, const svOpenArrayHandle match_table,
                       const svOpenArrayHandle lines) {
  if (count < 0 || bits < 1 || bits > 8) return fail("count is negative, or bits are not in 1..8");
  return result(selfproj_match((const uint16_t*)entries(codes, count), (size_t)count, bits,
                               (const uint16_t*)entries(match_table, (long long)count << bits),
                               (uint16_t*)entries(lines, count)));
}

#ifdef __cplusplus
}
#endif
