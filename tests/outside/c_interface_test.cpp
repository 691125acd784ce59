// The C interface gives what the C++ functions give, and says what is wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <utility>
#include <vector>

#include "selfproj.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/light_section/reference.h"
#include "selfproj/model/board.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/gray_match.h"
#include "selfproj/model/median3x3.h"
#include "selfproj/model/packet.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

template <typename Struct>
Struct sized() {
  Struct value{};
  value.size = sizeof value;
  return value;
}

selfproj_measure measure_of(int mode, int threshold) {
  selfproj_measure measure = sized<selfproj_measure>();
  measure.mode = mode;
  measure.threshold = threshold;
  return measure;
}

// A file with packets of random frames of the built-in light section, and the packets.
struct Recording {
  std::filesystem::path path;
  std::vector<std::vector<std::uint8_t>> packets;

  Recording(Random& random, int frames)
      : path(std::filesystem::temp_directory_path() / ("c_interface_" + std::to_string(random.bits()) + ".slfp")) {
    std::ofstream file(path, std::ios::binary);
    for (int frame = 0; frame < frames; ++frame) {
      const std::vector<std::uint8_t> pixels = random.bytes(96 * 512);
      const selfproj_image image{pixels.data(), 96, 512, 512};
      selfproj_measure measure = measure_of(random.between(0, 2), random.between(200, 255));
      measure.select = random.between(0, 1);
      selfproj_header header = sized<selfproj_header>();
      header.sequence = static_cast<std::uint64_t>(frame);
      header.time_stamp = 15120 * header.sequence;
      std::vector<std::uint8_t> packet(5000);
      std::size_t written = 0;
      EXPECT_EQ(selfproj_moments_packet(&image, &measure, &header, packet.data(), packet.size(), &written),
                SELFPROJ_OK);
      packet.resize(written);
      file.write(reinterpret_cast<const char*>(packet.data()), static_cast<std::streamsize>(written));
      packets.push_back(packet);
    }
  }
  Recording(const Recording&) = delete;
  Recording& operator=(const Recording&) = delete;
  ~Recording() { std::filesystem::remove(path); }
};

// The packet of an image that the model of the whole board sends, with sequence and losses of `header`.
std::vector<std::uint8_t> packet_of(const selfproj_image& image, const selfproj_measure& measure,
                                    const selfproj_header& header) {
  model::BoardPacket sent;
  model::BoardModel board([&](model::BoardPacket&& packet) { sent = std::move(packet); });
  board.write({.columns = image.columns,
               .rows = image.rows,
               .mode = static_cast<model::Mode>(measure.mode),
               .threshold = measure.threshold,
               .select = static_cast<model::Select>(measure.select),
               .gap = measure.gap,
               .window = {measure.first_row, measure.last_row}});
  model::BoardInputs inputs{.clock = 100};
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; column += 4) {
      model::VideoBeat beat{.start = row == 0 && column == 0, .line_end = column + 4 == image.columns};
      std::copy_n(image.pixels + row * image.stride + column, 4, beat.pixels.begin());
      board.beat(inputs, beat);
      ++inputs.clock;
    }
  }
  sent.header.sequence = header.sequence;
  sent.header.lost = header.lost;
  sent.header.time_stamp = header.time_stamp;
  std::vector<std::uint8_t> packet;
  model::append_packet(sent.header, sent.payload, sent.status, packet);
  return packet;
}

TEST(CInterface, MomentsAndPackets) {
  for (const std::uint64_t seed : seeds(60)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 60);
    const int columns = 4 * random.between(1, 20);
    const int stride = columns + random.between(0, 5);
    const std::vector<std::uint8_t> pixels =
        random.bytes(static_cast<std::size_t>(rows) * static_cast<std::size_t>(stride));
    const selfproj_image image{pixels.data(), rows, columns, stride};
    const int mode = random.between(0, 2);
    const int threshold = random.between(0, 255);
    const auto select = static_cast<model::Select>(random.between(0, 1));
    selfproj_measure measure = measure_of(mode, threshold);
    measure.select = static_cast<std::int32_t>(select);
    measure.gap = random.between(0, 3);
    measure.first_row = random.between(0, 4);
    measure.last_row = random.between(0, rows + 3);
    model::Runs ours;
    ours.resize(select, columns);
    model::measure_columns({pixels.data(), rows, columns, stride},
                           {.mode = static_cast<model::Mode>(mode),
                            .threshold = threshold,
                            .select = select,
                            .gap = measure.gap,
                            .window = {measure.first_row, measure.last_row}},
                           ours.view());
    model::Runs theirs;
    theirs.resize(select, columns);
    ASSERT_EQ(selfproj_moments(&image, &measure, theirs.moments.m0.data(), theirs.moments.m1.data(),
                               theirs.moments.n.data(), theirs.runs.data(), theirs.second.data()),
              SELFPROJ_OK);
    EXPECT_EQ(theirs, ours);

    // The packet that a board would send, by the model of the board and by the interface.
    selfproj_header header = sized<selfproj_header>();
    header.sequence = random.bits();
    header.lost = static_cast<std::uint32_t>(random.bits());
    const std::vector<std::uint8_t> expected = packet_of(image, measure, header);
    std::vector<std::uint8_t> packet(expected.size());
    std::size_t written = 0;
    ASSERT_EQ(selfproj_moments_packet(&image, &measure, &header, packet.data(), packet.size(), &written), SELFPROJ_OK);
    EXPECT_EQ(packet, expected);
    EXPECT_EQ(selfproj_moments_packet(&image, &measure, &header, packet.data(), packet.size() - 1, &written),
              SELFPROJ_BAD_ARGUMENT);
    EXPECT_EQ(written, expected.size());

    selfproj_packet found = sized<selfproj_packet>();
    ASSERT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &found), SELFPROJ_OK);
    EXPECT_EQ(found.header.lost, header.lost);
    EXPECT_EQ(found.payload, packet.data() + spec::kHeaderBytes);
    EXPECT_EQ(found.header.last_row, static_cast<std::uint32_t>(measure.last_row));
    model::Runs back;
    back.resize(select, columns);
    ASSERT_EQ(selfproj_unpack_moments(measure.select, mode, columns, found.payload, found.payload_bytes,
                                      back.moments.m0.data(), back.moments.m1.data(), back.moments.n.data(),
                                      back.runs.data(), back.second.data()),
              SELFPROJ_OK);
    EXPECT_EQ(back.moments, ours.moments);
    EXPECT_EQ(back.runs, ours.runs);
    std::vector<std::uint8_t> packed(found.payload_bytes);
    ASSERT_EQ(selfproj_pack_moments(measure.select, mode, columns, back.moments.m0.data(), back.moments.m1.data(),
                                    back.moments.n.data(), back.runs.data(), back.second.data(), packed.data(),
                                    packed.size()),
              SELFPROJ_OK);
    EXPECT_TRUE(std::equal(packed.begin(), packed.end(), found.payload));
    packet[static_cast<std::size_t>(random.between(0, static_cast<int>(written) - 1))] ^= 1U;
    EXPECT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &found), SELFPROJ_BAD_INPUT);
  }
}

// Packets of pixels of 12 bits; and a caller who was built before the header had pixel_bits: nothing is written or read
// behind what he has.
TEST(CInterface, PacketsOfTwelveBits) {
  constexpr int kColumns = 512;
  std::vector<std::uint32_t> m0(kColumns, 4095 * 20);
  std::vector<std::uint32_t> m1(kColumns, 4095 * 20 * 48);
  std::vector<std::uint32_t> n(kColumns, 20);
  std::vector<std::uint8_t> payload(model::moments_payload_bytes(model::Mode::grey, kColumns));
  model::pack_columns(model::ColumnWord::wide_grey, kColumns, {.moments = {m0.data(), m1.data(), n.data()}},
                      payload.data());
  selfproj_header header = sized<selfproj_header>();
  header.kind = SELFPROJ_KIND_MOMENTS;
  header.columns = kColumns;
  header.rows = 96;
  header.mode = SELFPROJ_GREY;
  header.first_line = 1;
  header.lines = 96;
  header.threshold = 4000;
  std::vector<std::uint8_t> packet(model::packet_bytes(payload.size()));
  std::size_t written = 0;
  const auto build = [&] {
    return selfproj_build_packet(&header, payload.data(), payload.size(), 0, packet.data(), packet.size(), &written);
  };
  header.pixel_bits = 13;
  EXPECT_EQ(build(), SELFPROJ_BAD_ARGUMENT);
  header.pixel_bits = 12;
  ASSERT_EQ(build(), SELFPROJ_OK);
  selfproj_packet found = sized<selfproj_packet>();
  ASSERT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &found), SELFPROJ_OK);
  EXPECT_EQ(found.header.pixel_bits, 12U);
  EXPECT_EQ(found.header.threshold, 4000U);
  model::Moments back;
  back.resize(kColumns);
  ASSERT_EQ(selfproj_unpack_wide_moments(SELFPROJ_GREY, kColumns, found.payload, found.payload_bytes, back.m0.data(),
                                         back.m1.data(), back.n.data()),
            SELFPROJ_OK);
  EXPECT_EQ(back.m0, m0);
  EXPECT_EQ(back.m1, m1);
  EXPECT_EQ(back.n, n);

  std::vector<std::uint8_t> runs(kColumns, 2);
  std::vector<std::uint8_t> second(kColumns, 5);
  model::pack_columns(model::ColumnWord::wide_grey_run, kColumns,
                      {{m0.data(), m1.data(), n.data()}, runs.data(), second.data()}, payload.data());
  header.select = SELFPROJ_STRONGEST;
  ASSERT_EQ(build(), SELFPROJ_OK);
  ASSERT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &found), SELFPROJ_OK);
  std::vector<std::uint8_t> found_runs(kColumns);
  std::vector<std::uint8_t> found_second(kColumns);
  ASSERT_EQ(selfproj_unpack_wide_runs(SELFPROJ_GREY, kColumns, found.payload, found.payload_bytes, back.m0.data(),
                                      back.m1.data(), back.n.data(), found_runs.data(), found_second.data()),
            SELFPROJ_OK);
  EXPECT_EQ(back.m0, m0);
  EXPECT_EQ(back.n, n);
  EXPECT_EQ(found_runs, runs);
  EXPECT_EQ(found_second, second);
  EXPECT_EQ(selfproj_unpack_wide_runs(SELFPROJ_GREY, kColumns, found.payload, found.payload_bytes, back.m0.data(),
                                      back.m1.data(), back.n.data(), nullptr, nullptr),
            SELFPROJ_BAD_ARGUMENT);
  std::vector<std::uint8_t> same_runs(kColumns);
  ASSERT_EQ(selfproj_unpack_columns(&found.header, found.payload, found.payload_bytes, back.m0.data(), back.m1.data(),
                                    back.n.data(), same_runs.data(), found_second.data()),
            SELFPROJ_OK);
  EXPECT_EQ(same_runs, runs);

  // A board for 2,047 rows, in mode binary.
  model::Moments tall{.m0 = m0, .m1 = m1, .n = m0};
  std::ranges::fill(tall.m0, 2047U);
  std::ranges::fill(tall.m1, 2047U * 1024U);
  tall.n = tall.m0;
  std::vector<std::uint8_t> tall_payload(model::moments_payload_bytes(model::Mode::binary, kColumns));
  model::pack_columns(model::ColumnWord::tall_binary, kColumns, {.moments = tall.view()}, tall_payload.data());
  selfproj_header of_tall = header;
  of_tall.mode = SELFPROJ_BINARY;
  of_tall.pixel_bits = 8;
  of_tall.threshold = 100;
  of_tall.rows = 2047;
  of_tall.lines = 2047;
  of_tall.tall = 1;
  ASSERT_EQ(selfproj_build_packet(&of_tall, tall_payload.data(), tall_payload.size(), 0, packet.data(), packet.size(),
                                  &written),
            SELFPROJ_OK);
  ASSERT_EQ(selfproj_parse_packet(packet.data(), written, &found), SELFPROJ_OK);
  EXPECT_EQ(found.header.tall, 1U);
  ASSERT_EQ(selfproj_unpack_columns(&found.header, found.payload, found.payload_bytes, back.m0.data(), back.m1.data(),
                                    back.n.data(), same_runs.data(), found_second.data()),
            SELFPROJ_OK);
  EXPECT_EQ(back, tall);
  EXPECT_EQ(selfproj_unpack_columns(&found.header, found.payload, found.payload_bytes - 16, back.m0.data(),
                                    back.m1.data(), back.n.data(), same_runs.data(), found_second.data()),
            SELFPROJ_BAD_ARGUMENT);

  header.select = SELFPROJ_ALL;
  ASSERT_EQ(build(), SELFPROJ_OK);

  selfproj_packet older{};
  std::memset(&older, 0xEE, sizeof older);
  older.size = offsetof(selfproj_packet, header) + offsetof(selfproj_header, pixel_bits);
  EXPECT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &older), SELFPROJ_BAD_ARGUMENT);
  header.pixel_bits = 8;
  header.threshold = 300;
  EXPECT_EQ(build(), SELFPROJ_BAD_ARGUMENT);
  header.threshold = 40;
  ASSERT_EQ(build(), SELFPROJ_OK);
  ASSERT_EQ(selfproj_parse_packet(packet.data(), packet.size(), &older), SELFPROJ_OK);
  EXPECT_EQ(older.header.pixel_bits, 0xEEEEEEEEU);
  EXPECT_EQ(older.header.size, offsetof(selfproj_header, pixel_bits));
  selfproj_profiler* profiler = nullptr;
  ASSERT_EQ(selfproj_profiler_create("light-section", nullptr, &profiler), SELFPROJ_OK);
  std::vector<std::uint8_t> validity(kColumns, 255);
  auto profile = sized<selfproj_profile>();
  profile.columns = kColumns;
  profile.validity = validity.data();
  EXPECT_EQ(selfproj_profile_of_packet(profiler, &older, &profile), SELFPROJ_OK) << selfproj_last_error();
  selfproj_profiler_destroy(profiler);
}

TEST(CInterface, CodesMedianAndMatches) {
  for (const std::uint64_t seed : seeds(20)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const int rows = random.between(1, 12);
    const int columns = random.between(1, 12);
    const int bits = random.between(1, 4);
    const auto pixels = static_cast<std::size_t>(rows) * static_cast<std::size_t>(columns);
    model::GrayDecoder decoder({.rows = rows, .columns = columns, .bits = bits, .threshold = 20});
    selfproj_gray* gray = nullptr;
    ASSERT_EQ(selfproj_gray_create(rows, columns, bits, 20, &gray), SELFPROJ_OK);
    std::vector<std::uint16_t> ours(pixels, 0);
    std::vector<std::uint16_t> theirs(pixels, 0);
    for (int frame = 0; frame < 6 * bits; ++frame) {
      const std::vector<std::uint8_t> image = random.bytes(pixels);
      const int pattern = random.chance(5) ? random.between(-1, 2 * bits) : frame % (2 * bits);
      const bool good = !random.chance(5);
      const selfproj_image view{image.data(), rows, columns, columns};
      std::int32_t due = -1;
      ASSERT_EQ(selfproj_gray_take(gray, &view, pattern, good ? 1 : 0, theirs.data(), &due), SELFPROJ_OK);
      EXPECT_EQ(due != 0, decoder.add_frame({image.data(), rows, columns, columns}, pattern, good, ours.data()));
      ASSERT_EQ(theirs, ours);
    }
    selfproj_gray_destroy(gray);
    std::vector<std::uint16_t> filtered(pixels);
    std::vector<std::uint16_t> wanted(pixels);
    model::median3x3(ours.data(), rows, columns, wanted.data());
    ASSERT_EQ(selfproj_median3x3(ours.data(), rows, columns, filtered.data()), SELFPROJ_OK);
    EXPECT_EQ(filtered, wanted);
    std::vector<std::uint16_t> table(pixels << static_cast<unsigned>(bits));
    std::generate(table.begin(), table.end(), [&] { return static_cast<std::uint16_t>(random.bits()); });
    model::GrayMatch::look_up(ours.data(), pixels, bits, table.data(), wanted.data());
    ASSERT_EQ(selfproj_match(ours.data(), pixels, bits, table.data(), filtered.data()), SELFPROJ_OK);
    EXPECT_EQ(filtered, wanted);
  }
}

TEST(CInterface, DeviceAndProfiles) {
  Random random(1);
  const Recording recording(random, 5);
  selfproj_device* device = nullptr;
  ASSERT_EQ(selfproj_device_open(("file:" + recording.path.string()).c_str(), nullptr, &device), SELFPROJ_OK);
  selfproj_profiler* profiler = nullptr;
  ASSERT_EQ(selfproj_profiler_create("light-section", nullptr, &profiler), SELFPROJ_OK);
  std::int32_t rows = 0;
  std::int32_t columns = 0;
  ASSERT_EQ(selfproj_profiler_size(profiler, &rows, &columns), SELFPROJ_OK);
  EXPECT_EQ(rows, 96);
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::DifferentialProfiler ours(rig, light_section::reference_of_plane(rig));
  ASSERT_EQ(columns, ours.columns());
  light_section::Profile expected;
  expected.resize(columns);
  light_section::Profile given;
  given.resize(columns);
  selfproj_packet packet = sized<selfproj_packet>();
  for (const std::vector<std::uint8_t>& sent : recording.packets) {
    ASSERT_EQ(selfproj_device_next(device, 1'000'000'000, &packet), SELFPROJ_OK);
    ASSERT_EQ(packet.byte_count, sent.size());
    EXPECT_EQ(std::memcmp(packet.bytes, sent.data(), sent.size()), 0);
    const light_section::ProfileView view = given.view();
    const selfproj_profile out{
        sizeof(selfproj_profile), 512, view.centroid, view.x, view.y, view.z, view.dx, view.dy, view.dz, view.validity};
    ASSERT_EQ(selfproj_profile_of_packet(profiler, &packet, &out), SELFPROJ_OK);
    ours.profile(static_cast<model::Select>(packet.header.select), static_cast<model::Mode>(packet.header.mode),
                 packet.payload, expected.view());
    // NOLINTBEGIN(bugprone-suspicious-memory-comparison): gaps, NaN, are equal, too
    EXPECT_EQ(std::memcmp(given.z.data(), expected.z.data(), 512 * sizeof(float)), 0);
    EXPECT_EQ(std::memcmp(given.dx.data(), expected.dx.data(), 512 * sizeof(float)), 0);
    // NOLINTEND(bugprone-suspicious-memory-comparison)
    EXPECT_EQ(given.validity, expected.validity);
    ASSERT_EQ(selfproj_device_release(device), SELFPROJ_OK);
  }
  EXPECT_EQ(selfproj_device_next(device, 0, &packet), SELFPROJ_END);
  selfproj_counters counters = sized<selfproj_counters>();
  ASSERT_EQ(selfproj_device_counters(device, &counters), SELFPROJ_OK);
  EXPECT_EQ(counters.delivered, 5U);
  EXPECT_EQ(counters.bad, 0U);
  selfproj_device_close(device);

  // A packet of another size, and one that was handed over by hand and says more than it has.
  packet = sized<selfproj_packet>();
  ASSERT_EQ(selfproj_parse_packet(recording.packets[0].data(), recording.packets[0].size(), &packet), SELFPROJ_OK);
  const selfproj_profile none{sizeof(selfproj_profile), 512, {}, {}, {}, {}, {}, {}, {}, {}};
  EXPECT_EQ(selfproj_profile_of_packet(profiler, &packet, &none), SELFPROJ_OK);
  packet.header.select = 2;
  EXPECT_EQ(selfproj_profile_of_packet(profiler, &packet, &none), SELFPROJ_BAD_ARGUMENT);
  packet.header.select = SELFPROJ_ALL;
  packet.payload_bytes -= 16;
  EXPECT_EQ(selfproj_profile_of_packet(profiler, &packet, &none), SELFPROJ_BAD_ARGUMENT);
  packet.payload_bytes += 16;
  packet.header.columns = 508;
  EXPECT_EQ(selfproj_profile_of_packet(profiler, &packet, &none), SELFPROJ_BAD_INPUT);
  selfproj_profiler_destroy(profiler);
}

TEST(CInterface, ErrorsNameTheReasonAndWriteNothing) {
  EXPECT_EQ(selfproj_abi_version(), static_cast<std::uint32_t>(SELFPROJ_ABI_VERSION));
  EXPECT_EQ(selfproj_spec_hash(), spec::kHash);
  selfproj_device* device = nullptr;
  EXPECT_EQ(selfproj_device_open("file:/no/such/file", nullptr, &device), SELFPROJ_BAD_INPUT);
  EXPECT_NE(std::strstr(selfproj_last_error(), "/no/such/file"), nullptr) << selfproj_last_error();
  EXPECT_EQ(selfproj_device_open("nonsense", nullptr, &device), SELFPROJ_BAD_INPUT);
  EXPECT_EQ(selfproj_device_open(nullptr, nullptr, &device), SELFPROJ_BAD_ARGUMENT);
  EXPECT_EQ(device, nullptr);
  selfproj_profiler* profiler = nullptr;
  EXPECT_EQ(selfproj_profiler_create("no-such-rig", nullptr, &profiler), SELFPROJ_BAD_INPUT);
  EXPECT_EQ(selfproj_profiler_create("scanner", nullptr, &profiler), SELFPROJ_BAD_INPUT);
  EXPECT_EQ(profiler, nullptr);
  std::uint32_t words[3] = {7, 7, 7};
  const std::uint8_t pixel[4] = {1, 2, 3, 4};
  const selfproj_measure good = measure_of(0, 0);
  for (const selfproj_image& image :
       {selfproj_image{nullptr, 1, 4, 4}, selfproj_image{pixel, 0, 4, 4}, selfproj_image{pixel, 1, 0, 4},
        selfproj_image{pixel, 1, 4, 3}, selfproj_image{pixel, 1, -4, 4}, selfproj_image{pixel, 1 << 20, 4, 4}}) {
    EXPECT_EQ(selfproj_moments(&image, &good, words, words + 1, words + 2, nullptr, nullptr), SELFPROJ_BAD_ARGUMENT);
  }
  const selfproj_image image{pixel, 1, 1, 1};
  for (const selfproj_measure& bad : {measure_of(3, 0), measure_of(-1, 0), measure_of(0, 256), selfproj_measure{},
                                      selfproj_measure{sizeof(selfproj_measure), 0, 0, 2, 0, 0, 0},
                                      selfproj_measure{sizeof(selfproj_measure), 0, 0, 1, 4, 0, 0},
                                      selfproj_measure{sizeof(selfproj_measure), 0, 0, 0, 0, 0, 2048}}) {
    EXPECT_EQ(selfproj_moments(&image, &bad, words, words + 1, words + 2, nullptr, nullptr), SELFPROJ_BAD_ARGUMENT);
  }
  EXPECT_EQ(words[0] + words[1] + words[2], 21U);
  // A caller of a later version, whose structure is longer, is served with the fields that are known here.
  struct {
    selfproj_measure measure;
    int later;
  } later{measure_of(0, 0), 1};
  later.measure.size = sizeof later;
  EXPECT_EQ(selfproj_moments(&image, &later.measure, words, words + 1, words + 2, nullptr, nullptr), SELFPROJ_OK);
}

}  // namespace
}  // namespace selfproj::test
