// Loads a GenTL producer as a consumer of GenTL does, calls its functions, and makes packets for it.
#ifndef SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H
#define SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H

#include <dlfcn.h>

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/gentl/gentl_types.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"

namespace selfproj::test {

// A loaded producer. It finds the functions of the standard by their names. If the file or a function is missing, it
// prints the reason and ends the program.
struct Producer {
  explicit Producer(const std::string& path) : library(dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL)) {
    if (library == nullptr) {
      std::fprintf(stderr, "%s\n", dlerror());
      std::exit(1);
    }
  }

  template <typename Function>
  Function* function(const char* name) const {
    void* const found = dlsym(library, name);
    if (found == nullptr) {
      std::fprintf(stderr, "%s\n", dlerror());
      std::exit(1);
    }
    return reinterpret_cast<Function*>(found);
  }

  void* library;  // never unloaded, so that the sanitizers can name the functions that leak
};

// The producer of this build.
inline const Producer& producer() {
  static const Producer one(SELFPROJ_GENTL_PRODUCER);
  return one;
}

// Calls a function of the producer: call(GC(TLOpen), &handle).
#define GC(name) ::selfproj::test::producer().function<decltype(::name)>(#name)

// The code and the text of the last error of this thread.
struct GenTLFailure {
  GC_ERROR code = GC_ERR_SUCCESS;
  std::string text;
};

inline GenTLFailure last_failure() {
  GenTLFailure found;
  std::size_t size = 0;
  if (GC(GCGetLastError)(&found.code, nullptr, &size) != GC_ERR_SUCCESS || size == 0) {
    return {GC_ERR_ERROR, "GCGetLastError failed"};
  }
  std::vector<char> text(size);
  if (GC(GCGetLastError)(&found.code, text.data(), &size) != GC_ERR_SUCCESS) {
    return {GC_ERR_ERROR, "GCGetLastError failed"};
  }
  found.text = text.data();
  return found;
}

// Calls a function that fills (type, buffer, size), such as DSGetInfo, and returns its answer as a value of this type.
// Throws std::runtime_error if the call fails or the answer has another size.
template <typename Value, typename Ask>
Value answer_of(const Ask& ask) {
  INFO_DATATYPE type = INFO_DATATYPE_UNKNOWN;
  Value value{};
  std::size_t size = sizeof value;
  if (ask(&type, &value, &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  if (size != sizeof value) {
    throw std::runtime_error("an answer of another size");
  }
  return value;
}

// The same for an answer that is a text of any length.
template <typename Ask>
std::string text_of(const Ask& ask) {
  INFO_DATATYPE type = INFO_DATATYPE_UNKNOWN;
  std::size_t size = 0;
  if (ask(&type, nullptr, &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  std::vector<char> text(size);
  if (ask(&type, text.data(), &size) != GC_ERR_SUCCESS) {
    throw std::runtime_error(last_failure().text);
  }
  return text.data();
}

constexpr int kRows = 96;
constexpr int kColumns = 512;
constexpr model::Measure kMeasure{.mode = model::Mode::grey_over, .threshold = 60};

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

// What is measured of pixels of so many bits, whose upper 8 bits are those of pixels_of_frame.
constexpr model::Measure measure_of_bits(int bits) {
  model::Measure measure = kMeasure;
  measure.bits = bits;
  measure.threshold <<= bits - spec::kPixelBits;
  return measure;
}

// Its packet.
inline std::vector<std::uint8_t> packet_of_frame(std::uint64_t number, int columns = kColumns,
                                                 int bits = spec::kPixelBits) {
  const std::vector<std::uint8_t> pixels = pixels_of_frame(number, columns);
  const model::Measure measure = measure_of_bits(bits);
  model::Runs runs;
  runs.resize(model::Select::all, columns);
  if (bits > spec::kPixelBits) {
    std::vector<std::uint16_t> wide(pixels.begin(), pixels.end());
    for (std::size_t i = 0; i < wide.size(); ++i) {
      wide[i] = static_cast<std::uint16_t>(wide[i] << (bits - spec::kPixelBits) | (wide[i] == 0 ? 0 : i % 4));
    }
    model::measure_columns({wide.data(), kRows, columns, columns}, measure, runs.view());
  } else {
    model::measure_columns({pixels.data(), kRows, columns, columns}, measure, runs.view());
  }
  std::vector<std::uint8_t> payload(model::moments_payload_bytes(kMeasure.mode, columns));
  model::PacketHeader header;
  header.kind = spec::kKindMoments;
  model::describe_frame(header, kRows, columns, measure);
  model::pack_columns(header, runs.view(), payload.data());
  header.sequence = number;
  header.time_stamp = 15120 * number;
  header.encoder = static_cast<std::uint32_t>(kCountsOfFrame * number);
  std::vector<std::uint8_t> packet;
  model::append_packet(header, payload, 0, packet);
  return packet;
}

// A file with the packets of frames 0, 1, ...
struct PacketFile {
  std::filesystem::path path;

  PacketFile(const std::string& name, int frames, int columns = kColumns, int bits = spec::kPixelBits)
      : path(std::filesystem::temp_directory_path() / (name + ".slfp")) {
    std::ofstream file(path, std::ios::binary);
    for (int frame = 0; frame < frames; ++frame) {
      const std::vector<std::uint8_t> packet = packet_of_frame(static_cast<std::uint64_t>(frame), columns, bits);
      file.write(reinterpret_cast<const char*>(packet.data()), static_cast<std::streamsize>(packet.size()));
    }
  }
  PacketFile(const PacketFile&) = delete;
  PacketFile& operator=(const PacketFile&) = delete;
  ~PacketFile() { std::filesystem::remove(path); }

  [[nodiscard]] std::string uri() const { return "file:" + path.string(); }
};

}  // namespace selfproj::test

#endif  // SELFPROJ_TESTS_OUTSIDE_GENTL_PRODUCER_H
