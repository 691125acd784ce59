// Packets of random frames of the built-in light section.
#ifndef SELFPROJ_TESTS_OUTSIDE_GENTL_RECORDING_H
#define SELFPROJ_TESTS_OUTSIDE_GENTL_RECORDING_H

#include <cstdint>
#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include "model/column_runs.h"
#include "model/packet.h"
#include "model/packet_payload.h"

namespace selfproj::test {

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr Measure kMeasure{.mode = Mode::grey_over, .threshold = 60};

constexpr int kCountsOfFrame = 10;  // of the encoder, from frame to frame

// Frame `number`: a line of light 3 to 6 rows thick at random rows, and columns without light.
inline std::vector<std::uint8_t> pixels_of_frame(std::uint64_t number, int columns = kColumns) {
  std::mt19937_64 random(number + 1);
  std::vector<std::uint8_t> pixels(static_cast<std::size_t>(kRows) * static_cast<std::size_t>(columns));
  for (int column = 0; column < columns; ++column) {
    const auto draw = random();
    const int first = 20 + static_cast<int>(draw % 50);
    const int thick = draw % 16 == 0 ? 0 : 3 + static_cast<int>((draw >> 8U) % 4);
    for (int row = first; row < first + thick; ++row) {
      pixels[static_cast<std::size_t>(row * columns + column)] = static_cast<std::uint8_t>(61 + (draw >> 16U) % 190);
    }
  }
  return pixels;
}

// Its packet.
inline std::vector<std::uint8_t> packet_of_frame(std::uint64_t number, int columns = kColumns) {
  const std::vector<std::uint8_t> pixels = pixels_of_frame(number, columns);
  Runs runs;
  runs.resize(Select::all, columns);
  measure_columns({pixels.data(), kRows, columns, columns}, kMeasure, runs.view());
  std::vector<std::uint8_t> payload(moments_payload_bytes(kMeasure.mode, columns));
  pack_columns(Select::all, kMeasure.mode, columns, runs.view(), payload.data());
  PacketHeader header;
  header.kind = spec::kKindMoments;
  describe_frame(header, kRows, columns, kMeasure);
  header.sequence = number;
  header.time_stamp = 15120 * number;
  header.encoder = static_cast<std::uint32_t>(kCountsOfFrame * number);
  std::vector<std::uint8_t> packet;
  append_packet(header, payload, 0, packet);
  return packet;
}

// A file with the packets of frames 0, 1, ...
struct PacketFile {
  std::filesystem::path path;

  PacketFile(const std::string& name, int frames, int columns = kColumns)
      : path(std::filesystem::temp_directory_path() / (name + ".slfp")) {
    std::ofstream file(path, std::ios::binary);
    for (int frame = 0; frame < frames; ++frame) {
      const std::vector<std::uint8_t> packet = packet_of_frame(static_cast<std::uint64_t>(frame), columns);
      file.write(reinterpret_cast<const char*>(packet.data()), static_cast<std::streamsize>(packet.size()));
    }
  }
  PacketFile(const PacketFile&) = delete;
  PacketFile& operator=(const PacketFile&) = delete;
  ~PacketFile() { std::filesystem::remove(path); }

  [[nodiscard]] std::string uri() const { return "file:" + path.string(); }
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_OUTSIDE_GENTL_RECORDING_H
