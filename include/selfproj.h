/* selfproj in plain C: the bit-exact model, packets, devices, and profiles of a light section.
 *
 * Every function returns SELFPROJ_OK, or says what is wrong by a negative value and by the text of
 * selfproj_last_error(), and has then written nothing. No C++ exception leaves a function. Arrays belong to the caller,
 * must not overlap, and need no alignment beyond that of their type. Functions without a handle keep no state: any
 * number of threads may call them at once. A handle is for one thread at a time. A handle that is null is an error, one
 * that was destroyed is not noticed.
 *
 * ABI: a structure that a later version may extend begins with `size`, which the caller sets to its sizeof. Fields that
 * the caller's version does not have count as 0. Within one SELFPROJ_ABI_VERSION functions and fields are only added.
 */
#ifndef SELFPROJ_CAPI_SELFPROJ_H
#define SELFPROJ_CAPI_SELFPROJ_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define SELFPROJ_ABI_VERSION 1

/* What functions return. */
#define SELFPROJ_OK 0
#define SELFPROJ_TIMEOUT 1       /* selfproj_device_next: no packet came in time */
#define SELFPROJ_END 2           /* selfproj_device_next: no further packet will come */
#define SELFPROJ_BAD_ARGUMENT -1 /* an argument is null or out of range */
#define SELFPROJ_BAD_INPUT -2    /* a file, device or packet is missing, damaged or of another kind */
#define SELFPROJ_NO_MEMORY -3
#define SELFPROJ_INTERNAL -4 /* a fault of the library */

/* The SELFPROJ_ABI_VERSION with which the library was built. Compare it with that of the header. */
uint32_t selfproj_abi_version(void);

/* The hash of the specification in every packet: boards, models and hosts with the same one understand each other. */
uint32_t selfproj_spec_hash(void);

/* Why the last function of this thread that failed did so, in one line; "" if none has. Valid until the next one fails.
 */
const char* selfproj_last_error(void);

/* ---- The model: what the circuits compute, to the last bit. ---- */

/* How much a lit pixel p > T weighs. */
#define SELFPROJ_BINARY 0    /* 1 */
#define SELFPROJ_GREY 1      /* p */
#define SELFPROJ_GREY_OVER 2 /* p - T */

/* An image: pixel (row r, column c), both from 0, is pixels[r * stride + c]. Rows 1..2047, columns 1 or more (a board
 * takes multiples of 4 up to 4096). |stride| is at least columns; negative for an image that is upside down. */
typedef struct selfproj_image {
  const uint8_t* pixels;
  int32_t rows;
  int32_t columns;
  ptrdiff_t stride;
} selfproj_image;

/* What of a column is measured. */
#define SELFPROJ_ALL 0       /* all lit pixels */
#define SELFPROJ_STRONGEST 1 /* its strongest run of lit pixels (include/selfproj/model/column_runs.h) */

/* How an image is reduced to moments. */
typedef struct selfproj_measure {
  uint32_t size;
  int32_t mode;      /* SELFPROJ_BINARY, SELFPROJ_GREY, SELFPROJ_GREY_OVER */
  int32_t threshold; /* T, 0..255 */
  int32_t select;    /* SELFPROJ_ALL, SELFPROJ_STRONGEST */
  int32_t gap;       /* dark rows between two lit pixels of one run, 0..3 */
  int32_t first_row; /* first row that counts, 0..2047, from 1; 0: the first */
  int32_t last_row;  /* last row that counts, 0..2047; 0: the last */
} selfproj_measure;

/* Column moments (3.1): for each column M0 = sum w, M1 = sum row * w with rows from 1, and N = lit pixels, of what
 * `select` says. With SELFPROJ_STRONGEST also `runs`, the number of runs (3: three or more), and `second`, the
 * sixteenths of M0 that the second run has; otherwise these two are not touched and may be null. Each array has
 * image->columns entries. */
int32_t selfproj_moments(const selfproj_image* image, const selfproj_measure* measure, uint32_t* m0, uint32_t* m1,
                         uint32_t* n, uint8_t* runs, uint8_t* second);

/* Gray-code decoder (4.15 to 4.18) for images of one size. */
typedef struct selfproj_gray selfproj_gray;

/* rows and columns 1..32768 and at most 2^26 pixels, bits 1..12 (pairs in a cycle), threshold 0..255. */
int32_t selfproj_gray_create(int32_t rows, int32_t columns, int32_t bits, int32_t threshold, selfproj_gray** out);
void selfproj_gray_destroy(selfproj_gray* gray); /* null is allowed */

/* Takes a frame of that size with its pattern index: 2p is the positive of bit p, 2p + 1 its negative, p = 0 the most
 * significant. `good` is 0 for a broken frame. If a code image is due, sets *due = 1 and writes rows * columns words to
 * `codes`: the code in bits 11..0, and bit 15 where it is measurable. Otherwise *due = 0 and `codes` is not touched. */
int32_t selfproj_gray_take(selfproj_gray* gray, const selfproj_image* image, int32_t pattern, int32_t good,
                           uint16_t* codes, int32_t* due);

/* Waits for pattern 0, as after the start. */
int32_t selfproj_gray_restart(selfproj_gray* gray);

/* 3 x 3 median of a code image of rows * columns words, as selfproj_gray_take gives it, into as many words. Rows and
 * columns 1..32768. */
int32_t selfproj_median3x3(const uint16_t* codes, int32_t rows, int32_t columns, uint16_t* out);

/* Matching (4.19): looks up the projector line of each of `count` code words, in 1/64 line; 0xFFFF where there is none.
 * bits 1..8; `table` has count << bits words, those of one pixel after another, indexed by the code. */
int32_t selfproj_match(const uint16_t* codes, size_t count, int32_t bits, const uint16_t* table, uint16_t* lines);

/* ---- Packets ---- */

#define SELFPROJ_KIND_MOMENTS 1 /* one packet a frame */
#define SELFPROJ_KIND_CODES 2   /* one packet a line of a code image */
#define SELFPROJ_KIND_IMAGE 3   /* one packet a line of a raw image */
#define SELFPROJ_KIND_COMPACT 4 /* one packet a frame, columns divided in the circuit */
#define SELFPROJ_KIND_VERDICT 5 /* one packet a frame, with nothing but the board's verdict */

/* The fields of a header; docs/packet-reference.md explains them. */
typedef struct selfproj_header {
  uint32_t size;
  uint32_t kind;
  uint32_t stream;
  uint32_t lost;
  uint64_t sequence;
  uint64_t time_stamp;
  uint32_t encoder;
  uint32_t columns;
  uint32_t rows;
  uint32_t pattern;
  uint32_t mode;
  uint32_t threshold;
  uint32_t first_line;
  uint32_t lines;
  uint32_t flags;
  uint32_t select;
  uint32_t gap;
  uint32_t first_row;
  uint32_t last_row;
  uint16_t region_row; /* row and column of the sensor, from 1, at which the frame begins; 0: not said */
  uint16_t region_column;
  uint32_t pixel_bits; /* of a pixel, 8..12; images and codes have the upper 8; 0 counts as 8 */
  uint32_t tall;       /* 1: of a board for more than 1023 rows, whose columns are other words */
} selfproj_header;

/* A packet that was found right. The pointers lead into the bytes where it was found. */
typedef struct selfproj_packet {
  uint32_t size;
  uint32_t status;        /* of the frame; 0 = good */
  const uint8_t* bytes;   /* the whole packet */
  size_t byte_count;      /* the next packet begins behind them */
  const uint8_t* payload; /* within the packet */
  size_t payload_bytes;
  selfproj_header header; /* its size need not be set */
} selfproj_packet;

/* The bytes of a payload for so many columns, 0..65535: moments in this mode, one line of codes, one line of an image,
 * or compact columns (mode is ignored for the last three). */
int32_t selfproj_payload_bytes(uint32_t kind, int32_t mode, int32_t columns, size_t* bytes);

/* Writes moments as a payload, and reads them back. `payload` has selfproj_payload_bytes(SELFPROJ_KIND_MOMENTS, ...)
 * bytes, the arrays have `columns` entries. In SELFPROJ_BINARY n is M0, and `second` comes back as 8 or 0. With
 * SELFPROJ_ALL `runs` and `second` may be null. */
int32_t selfproj_pack_moments(int32_t select, int32_t mode, int32_t columns, const uint32_t* m0, const uint32_t* m1,
                              const uint32_t* n, const uint8_t* runs, const uint8_t* second, uint8_t* payload,
                              size_t payload_bytes);
int32_t selfproj_unpack_moments(int32_t select, int32_t mode, int32_t columns, const uint8_t* payload,
                                size_t payload_bytes, uint32_t* m0, uint32_t* m1, uint32_t* n, uint8_t* runs,
                                uint8_t* second);

/* Reads the moments of pixels of more than 8 bits (pixel_bits of the header), with SELFPROJ_ALL. */
int32_t selfproj_unpack_wide_moments(int32_t mode, int32_t columns, const uint8_t* payload, size_t payload_bytes,
                                     uint32_t* m0, uint32_t* m1, uint32_t* n);

/* The same with SELFPROJ_STRONGEST. In the grey modes n is at most 63, and `runs` is 0, 1, or 2 where `second` is not
 * 0. */
int32_t selfproj_unpack_wide_runs(int32_t mode, int32_t columns, const uint8_t* payload, size_t payload_bytes,
                                  uint32_t* m0, uint32_t* m1, uint32_t* n, uint8_t* runs, uint8_t* second);

/* Reads compact columns, `payload_bytes` at least those of SELFPROJ_KIND_COMPACT: m0 becomes 512, or 0 without light,
 * m1 the centroid in 1/512 rows; n, `runs` and `second` at most 63, 3 and 15. With SELFPROJ_ALL the last two may be
 * null. */
int32_t selfproj_unpack_compact(int32_t select, int32_t columns, const uint8_t* payload, size_t payload_bytes,
                                uint32_t* m0, uint32_t* m1, uint32_t* n, uint8_t* runs, uint8_t* second);

/* Reads the columns of a packet of moments or compact columns with this header, whatever their words are: one of the
 * functions above, or what boards for more than 1023 rows send. With SELFPROJ_ALL `runs` and `second` may be null. */
int32_t selfproj_unpack_columns(const selfproj_header* header, const uint8_t* payload, size_t payload_bytes,
                                uint32_t* m0, uint32_t* m1, uint32_t* n, uint8_t* runs, uint8_t* second);

/* Reads the code words of one line. */
int32_t selfproj_unpack_codes(int32_t columns, const uint8_t* payload, size_t payload_bytes, uint16_t* codes);

/* Builds a whole packet: header, payload (a multiple of 16 bytes, at most 16 MiB, may be null if 0), and trailer with
 * `status` and check word. Fields of the header are not checked against each other, but must fit their bits. *written
 * gets the bytes of the packet; if `capacity` is less, that is SELFPROJ_BAD_ARGUMENT and only *written is set. */
int32_t selfproj_build_packet(const selfproj_header* header, const uint8_t* payload, size_t payload_bytes,
                              uint32_t status, uint8_t* out, size_t capacity, size_t* written);

/* The whole way of one frame, from the image to the packet that a board sends: moments by `measure`, and a header with
 * it, the image's size and the fields stream, lost, sequence, time_stamp, encoder, pattern and flags of `header`. The
 * image must be one that a board takes. *written and `capacity` as above. */
int32_t selfproj_moments_packet(const selfproj_image* image, const selfproj_measure* measure,
                                const selfproj_header* header, uint8_t* out, size_t capacity, size_t* written);

/* Looks for a packet at the beginning of `count` bytes, and never reads beyond them. SELFPROJ_BAD_INPUT if there is
 * none, with the fault as selfproj_last_error(); "too_short" means that more bytes may complete it. Set packet->size.
 */
int32_t selfproj_parse_packet(const uint8_t* bytes, size_t count, selfproj_packet* packet);

/* ---- Devices ---- */

typedef struct selfproj_device selfproj_device;

#define SELFPROJ_WAIT_POLL_THEN_BLOCK 0
#define SELFPROJ_WAIT_POLL 1
#define SELFPROJ_WAIT_BLOCK 2

typedef struct selfproj_device_options {
  uint32_t size;
  int32_t wait;            /* SELFPROJ_WAIT_... */
  int32_t wait_for_board;  /* 1: a ring need not exist yet, and may be renewed */
  int32_t discard_backlog; /* 1: skip what was written to a ring before */
} selfproj_device_options;

/* Opens a device by its URI (docs/driver.md): ring:NAME, file:PATH, udp:HOST[:PORT] or litepcie:PATH. `options` may be
   null. */
int32_t selfproj_device_open(const char* uri, const selfproj_device_options* options, selfproj_device** out);
void selfproj_device_close(selfproj_device* device); /* null is allowed */

/* The next good packet in place, without a copy: SELFPROJ_OK, SELFPROJ_TIMEOUT or SELFPROJ_END. It stays valid until
 * the next call of this, selfproj_device_release or selfproj_device_close. Waits up to timeout_ns, 0..10^18; 0 looks
 * once. Set packet->size. */
int32_t selfproj_device_next(selfproj_device* device, int64_t timeout_ns, selfproj_packet* packet);

/* Frees the place of the packet, if one is held. */
int32_t selfproj_device_release(selfproj_device* device);

/* The counters of docs/driver.md since the device was opened. */
typedef struct selfproj_counters {
  uint32_t size;
  uint32_t reserved;
  uint64_t delivered, flagged, lost_board, lost_ring, missing, bad, other_spec, resynchronized, bytes_discarded,
      repeated, restarts, reattached, read_errors, lost_network, datagrams_lost, datagrams_overflow, datagrams_doubled,
      datagrams_reordered, datagrams_refused;
} selfproj_counters;
int32_t selfproj_device_counters(const selfproj_device* device, selfproj_counters* counters);

/* ---- Profiles of a light section ---- */

typedef struct selfproj_profiler selfproj_profiler;

/* The entries of a profile, one for each column, in mm in the camera's frame; NaN where there is no point. Arrays that
 * are null are not wanted. */
typedef struct selfproj_profile {
  uint32_t size;
  uint32_t columns; /* entries of each array; must be those of the profiler */
  float* centroid;  /* rows from 1 */
  float *x, *y, *z;
  float *dx, *dy, *dz; /* difference from the reference, NaN where it has no point; dz < 0 is nearer to the camera */
  uint8_t* validity;   /* 0 = valid; else the reason (include/selfproj/light_section/profile.h) */
} selfproj_profile;

/* `rig`: a built-in rig such as "light-section", or a YAML file. `reference`: the folder of a reference, or its
 * reference.csv; null for the empty plane. */
int32_t selfproj_profiler_create(const char* rig, const char* reference, selfproj_profiler** out);
void selfproj_profiler_destroy(selfproj_profiler* profiler); /* null is allowed */
int32_t selfproj_profiler_size(const selfproj_profiler* profiler, int32_t* rows, int32_t* columns);

/* The profile of a packet of moments. SELFPROJ_BAD_INPUT if it is of another kind, of another size than the rig's
 * camera, or of a broken frame. */
int32_t selfproj_profile_of_packet(selfproj_profiler* profiler, const selfproj_packet* packet,
                                   const selfproj_profile* out);

/* The same from moments; arrays have as many entries as the profiler has columns, and values below 2^31. */
int32_t selfproj_profile_of_moments(selfproj_profiler* profiler, const uint32_t* m0, const uint32_t* m1,
                                    const uint32_t* n, const selfproj_profile* out);

#ifdef __cplusplus
}
#endif

#endif /* SELFPROJ_CAPI_SELFPROJ_H */
