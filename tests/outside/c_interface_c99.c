/* The C interface as a program in C99 uses it: moments of an image, a packet, its profile; errors. Prints one line. */
#include <selfproj.h>
#include <stdio.h>
#include <string.h>

#define ROWS 96
#define COLUMNS 512

static uint8_t pixels[ROWS * COLUMNS];
static uint8_t packet[8192];

static int fail(const char* what) {
  fprintf(stderr, "c_interface_c99: %s: %s\n", what, selfproj_last_error());
  return 1;
}

int main(void) {
  const selfproj_image image = {pixels, ROWS, COLUMNS, COLUMNS};
  selfproj_measure measure;
  selfproj_header header;
  selfproj_packet found;
  selfproj_profiler* profiler = NULL;
  selfproj_profile profile;
  float z[COLUMNS];
  size_t written = 0;
  int32_t due = 7;

  if (selfproj_abi_version() != SELFPROJ_ABI_VERSION) return fail("another ABI");
  memset(pixels + 45 * COLUMNS, 100, 6 * COLUMNS); /* a line on the six middle rows */
  memset(&measure, 0, sizeof measure);
  measure.size = sizeof measure;
  measure.mode = SELFPROJ_GREY_OVER;
  measure.threshold = 20;
  memset(&header, 0, sizeof header);
  header.size = sizeof header;
  header.sequence = 5;
  if (selfproj_moments_packet(&image, &measure, &header, packet, sizeof packet, &written) != SELFPROJ_OK) {
    return fail("moments_packet");
  }
  memset(&found, 0, sizeof found);
  found.size = sizeof found;
  if (selfproj_parse_packet(packet, written, &found) != SELFPROJ_OK || found.byte_count != written) {
    return fail("parse_packet");
  }
  if (selfproj_profiler_create("light-section", NULL, &profiler) != SELFPROJ_OK) return fail("profiler_create");
  memset(&profile, 0, sizeof profile);
  profile.size = sizeof profile;
  profile.columns = COLUMNS;
  profile.z = z;
  if (selfproj_profile_of_packet(profiler, &found, &profile) != SELFPROJ_OK) return fail("profile_of_packet");
  selfproj_profiler_destroy(profiler);

  measure.mode = 3;
  if (selfproj_moments_packet(&image, &measure, &header, packet, sizeof packet, &written) != SELFPROJ_BAD_ARGUMENT ||
      strcmp(selfproj_last_error(), "unknown mode") != 0) {
    return fail("an unknown mode was taken");
  }
  if (selfproj_gray_take(NULL, &image, 0, 1, NULL, &due) != SELFPROJ_BAD_ARGUMENT || due != 7) {
    return fail("a null handle was taken");
  }
  printf("frame %u, z %.3f mm\n", (unsigned)found.header.sequence, (double)z[COLUMNS / 2]);
  return 0;
}
