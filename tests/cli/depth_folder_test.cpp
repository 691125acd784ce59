// Tests selfproj depth on a folder of a whole Gray sequence, white and black included, by a rig that takes both axes.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <string>
#include <vector>

#include "host/images/image_files.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/lens_triangulation.h"
#include "tests/cli/program.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {
namespace {

constexpr int kImageRows = 30;
constexpr int kImageColumns = 40;
constexpr int kCodeBits = 6;

// A small scanner with 64 lines and columns.
rig::Rig small_scanner() {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows = kImageRows;
  rig.camera.columns = kImageColumns;
  rig.camera.pixel_pitch_mm = 0.1;
  rig.projector.lines = rig.projector.columns = 64;
  rig.projector.line_pitch_mm *= 12;
  rig.projector.column_pitch_mm *= 16;
  rig.measure.max_z_per_line_mm = 60;
  return rig;
}

struct Codes {
  std::vector<int> columns, lines;  // of each pixel; -1: not lit
};

// What the projector shows where each pixel sees the plane.
Codes codes_on_plane(const rig::Rig& rig) {
  const double scale = rig.plane_z_mm * rig.camera.pixel_pitch_mm / rig.camera.focal_length_mm;
  const auto code = [](double place) {
    const double nearest = std::floor(place + 0.5);
    return nearest >= 0 && nearest < 64 ? static_cast<int>(nearest) : -1;
  };
  Codes codes;
  for (int row = 0; row < kImageRows; ++row) {
    for (int column = 0; column < kImageColumns; ++column) {
      const Pixel lit = projector_lights(rig.projector, {scale * (row - 0.5 * (kImageRows - 1)),
                                                         scale * (column - 0.5 * (kImageColumns - 1)), rig.plane_z_mm});
      codes.columns.push_back(code(lit.column));
      codes.lines.push_back(code(lit.row));
    }
  }
  return codes;
}

// The positive or the negative image of one plane of a code.
std::string image_of(const std::vector<int>& codes, int plane, bool negative) {
  images::Image image{kImageRows, kImageColumns, {}};
  for (const int code : codes) {
    const bool white = (((code ^ (code >> 1)) >> (kCodeBits - 1 - plane) & 1) != 0) != negative;
    image.pixels.push_back(code < 0 ? std::uint8_t{30} : white ? std::uint8_t{200} : std::uint8_t{40});
  }
  return images::encode_png(image);
}

TEST(DepthFolder, ARigTakesBothAxes) {
  const ScratchFolder folder;
  const rig::Rig rig = small_scanner();
  const Codes codes = codes_on_plane(rig);
  write_text(folder / "rig.yaml", rig::to_yaml(rig));
  std::filesystem::create_directory(folder / "images");
  int number = 0;
  const auto save = [&](const std::string& bytes) {
    write_text(folder / "images" / fmt::format("img{}.png", number++), bytes);  // natural order: 10 after 9
  };
  for (const std::vector<int>* axis : {&codes.columns, &codes.lines}) {
    for (int plane = 0; plane < kCodeBits; ++plane) {
      save(image_of(*axis, plane, false));
      save(image_of(*axis, plane, true));
    }
  }
  for (const int grey : {200, 20}) {
    save(images::encode_png({kImageRows, kImageColumns,
                             std::vector<std::uint8_t>(kImageRows * kImageColumns, static_cast<std::uint8_t>(grey))}));
  }
  const std::vector<std::string> usual{"depth", "--rig",   "rig.yaml", "--bits", "6",     "--row-bits",
                                       "6",     "--plane", "--out",    "out",    "images"};
  const Outcome outcome = run_program(SELFPROJ_PROGRAM, usual, folder.path());
  ASSERT_EQ(outcome.status, 0) << outcome.err;

  structured_light::LensSettings settings;
  settings.rows = kImageRows;
  settings.columns = kImageColumns;
  settings.bits = settings.row_bits = kCodeBits;
  settings.rows_are_x = true;
  settings.limits.max_z_per_line_mm = rig.measure.max_z_per_line_mm;
  const auto words = [](const std::vector<int>& all) {
    std::vector<std::uint16_t> result;
    for (const int code : all) {
      result.push_back(code < 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(code | 0x8000));
    }
    return result;
  };
  images::FloatImage expected(kImageRows, kImageColumns);
  structured_light::LensTriangulation(rig::calibration_of(rig), settings)
      .depth_of_both(words(codes.lines).data(), words(codes.columns).data(), expected.values.data(), nullptr, nullptr);
  const images::FloatImage depth = images::read_float_tiff((folder / "out" / "depth.tiff").string());
  ASSERT_EQ(depth.values.size(), expected.values.size());
  EXPECT_EQ(std::memcmp(depth.values.data(), expected.values.data(), depth.values.size() * sizeof(float)), 0);
  double sum = 0;
  int count = 0;
  for (const float z : depth.values) {
    sum += std::isnan(z) ? 0 : static_cast<double>(z);
    count += std::isnan(z) ? 0 : 1;
  }
  ASSERT_GT(count, 300);
  EXPECT_NEAR(sum / count, rig.plane_z_mm, 3);  // a line is worth up to 60 mm here

  // Results in the folder of the images would be read with them the next time.
  std::vector<std::string> into = usual;
  into[9] = "./images/";
  const Outcome inner = run_program(SELFPROJ_PROGRAM, into, folder.path());
  EXPECT_EQ(inner.status, 2);
  EXPECT_EQ(inner.err,
            "selfproj: ./images/: is the folder whose files are read; results in it would be read the next time\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "images/summary.json"));

  // What is no image is left out with a note; an odd number is not a sequence of pairs.
  std::filesystem::remove_all(folder / "out");
  write_text(folder / "images/notes.txt", "no image");
  const std::string note = "selfproj: images/notes.txt: is no image and left out\n";
  EXPECT_EQ(run_program(SELFPROJ_PROGRAM, usual, folder.path()).err, note);
  EXPECT_TRUE(std::filesystem::exists(folder / "out" / "depth.tiff"));
  std::filesystem::remove_all(folder / "out");
  std::filesystem::remove(folder / "images/img0.png");
  std::filesystem::remove(folder / "images/img25.png");
  std::filesystem::remove(folder / "images/img24.png");
  const Outcome refused = run_program(SELFPROJ_PROGRAM, usual, folder.path());
  EXPECT_EQ(refused.status, 2);
  EXPECT_EQ(refused.err,
            note + "selfproj: IMAGE: 23 images are an odd number; each positive is followed by its negative\n");
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

}  // namespace
}  // namespace selfproj::test
