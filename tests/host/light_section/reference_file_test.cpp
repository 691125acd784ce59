// Tests references as files: what is written is read back, and every fault of a file gives a one-line error.
#include "selfproj/light_section/reference_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

constexpr double kUnmeasured = std::numeric_limits<double>::quiet_NaN();

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

// A reference with odd numbers and gaps.
light_section::ReferenceProfile some_reference(const rig::Rig& rig) {
  light_section::ReferenceProfile reference;
  reference.resize(rig.camera.columns);
  for (std::size_t i = 0; i < reference.valid.size(); ++i) {
    const auto k = static_cast<double>(i);
    const bool valid = i % 7 != 3;
    reference.valid[i] = valid ? 1 : 0;
    reference.tan_theta[i] = valid ? 0.6 + k / 3000 : kUnmeasured;
    reference.z_mm[i] = valid ? 1167 - k / 7 : kUnmeasured;
    reference.offset_px[i] = valid ? -k / 1e4 : kUnmeasured;
  }
  return reference;
}

TEST(ReferenceFile, ComesBackToTheLastBit) {
  const rig::Rig rig = rig::load_rig("light-section");
  const light_section::ReferenceProfile reference = some_reference(rig);
  const light_section::ReferenceProfile read =
      light_section::parse_reference_csv(rig, light_section::reference_csv(rig, reference), "r.csv");
  ASSERT_EQ(read.valid, reference.valid);
  for (std::size_t i = 0; i < read.valid.size(); ++i) {
    if (read.valid[i] != 0) {
      ASSERT_EQ(read.tan_theta[i], reference.tan_theta[i]);
      ASSERT_EQ(read.z_mm[i], reference.z_mm[i]);
      ASSERT_EQ(read.offset_px[i], reference.offset_px[i]);
    } else {
      ASSERT_TRUE(std::isnan(read.z_mm[i]));
    }
  }
  // It is also accepted for the rig that went through its own YAML.
  EXPECT_NO_THROW(light_section::parse_reference_csv(rig::parse_rig(rig::to_yaml(rig), "y"),
                                                     light_section::reference_csv(rig, reference), "r.csv"));
}

TEST(ReferenceFile, AnotherRigIsRefused) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::string text = light_section::reference_csv(rig, some_reference(rig));
  const auto message = [&](const rig::Rig& other) {
    return error_of([&] { light_section::parse_reference_csv(other, text, "r.csv"); });
  };
  rig::Rig other = rig;
  other.camera.focal_length_mm = 35;
  EXPECT_EQ(message(other), "r.csv: was made for another rig: camera.focal_length_mm is 50 there and 35 here");
  other = rig;
  other.camera.columns = 1024;
  EXPECT_EQ(message(other), "r.csv: was made for another rig: camera.columns is 512 there and 1024 here");
  other = rig;
  other.projector.tilt_rad += 1e-9;
  EXPECT_TRUE(contains(message(other), "projector.tilt_rad")) << message(other);
  other = rig;
  other.measure.threshold = 7;  // is not geometry
  EXPECT_EQ(message(other), "none");
}

TEST(ReferenceFile, DamageIsSeen) {
  const rig::Rig rig = rig::load_rig("light-section");
  const std::string text = light_section::reference_csv(rig, some_reference(rig));
  const auto message = [&](const std::string& damaged) {
    return error_of([&] { light_section::parse_reference_csv(rig, damaged, "r.csv"); });
  };
  EXPECT_EQ(message(text), "none");
  EXPECT_EQ(message(""), "r.csv: is not a reference; `selfproj pattern` writes references");
  EXPECT_EQ(message("frame,column,m0,m1,n\n"), "r.csv: is not a reference; `selfproj pattern` writes references");
  EXPECT_EQ(message("# selfproj reference 3\n"), "r.csv: is of version 3; this program reads versions 1 and 2");
  EXPECT_EQ(message("# selfproj reference 2\n"),
            "r.csv: was made for another rig: one with lenses, a laser or corrected heights");
  // A cut at any place is noticed.
  for (std::size_t size = 0; size < text.size(); size += 37) {
    ASSERT_NE(message(text.substr(0, size)), "none") << size;
  }
  ASSERT_NE(message(text.substr(0, text.size() - 1)), "none");
  const std::size_t line = text.find("\n9,");
  EXPECT_TRUE(contains(message(text.substr(0, line + 1)), "is truncated: it has 8 of 512 columns"));
  const auto replaced = [&](const std::string& from, const std::string& to) {
    std::string result = text;
    result.replace(result.find(from), from.size(), to);
    return result;
  };
  EXPECT_TRUE(contains(message(replaced("\n9,", "\n10,")), "line 25: is damaged: column 9"))
      << message(replaced("\n9,", "\n10,"));
  EXPECT_TRUE(contains(message(replaced("\n9,", "\n9,x")), "is not a number"));
  EXPECT_TRUE(contains(message(replaced("\n9,", "\n9,nan")), "is not a number"));
  EXPECT_TRUE(contains(message(replaced("\n9,", "\n9,1,")), "is damaged: column 9"));
  EXPECT_TRUE(contains(message(replaced("\n4,,,\n", "\n4,,7,\n")), "'' is not a number"));
  EXPECT_TRUE(contains(message(text + "513,,,\n"), "more than 512 columns"));
  // Numbers that no rig can mean; in the profiler's own float they would be infinite, or 0.
  const auto fourth = [&](const std::string& numbers) {
    return message(replaced("\n4,,,\n", "\n4," + numbers + "\n"));
  };
  EXPECT_EQ(fourth("0.6,1167,0.5"), "none");
  EXPECT_TRUE(contains(fourth("0.6,1167,-1e308"), "offset_px is -1e+308; its size may be at most 96"));
  EXPECT_TRUE(contains(fourth("0.6,1e39,0.5"), "z_mm is 1e+39; its size may be at most 1000000"));
  EXPECT_TRUE(contains(fourth("1e39,1167,0.5"), "tan_theta is 1e+39; its size may be at most 10000"));
  EXPECT_TRUE(contains(fourth("0.6,1e-320,0.5"), "z is 1e-320, less than 0.001"));
}

TEST(ReferenceFile, FoldersAndPatterns) {
  const rig::Rig rig = rig::load_rig("light-section");
  const ScratchFolder folder;
  const std::string path = folder.path().string();
  EXPECT_TRUE(contains(error_of([&] { light_section::load_reference(rig, path); }), "reference.csv: No such file"));
  write_text(folder / "reference.csv", light_section::reference_csv(rig, some_reference(rig)));
  EXPECT_EQ(light_section::load_reference(rig, path).valid, some_reference(rig).valid);
  EXPECT_EQ(light_section::load_reference(rig, path + "/reference.csv").valid, some_reference(rig).valid);
  images::FloatImage pattern(rig.projector.lines, rig.projector.columns, 0.25F);
  images::write_float_tiff(folder / "pattern.tiff", pattern);
  EXPECT_EQ(light_section::load_pattern(rig, path), pattern);
  pattern.row(3)[4] = 1.5F;
  images::write_float_tiff(folder / "pattern.tiff", pattern);
  EXPECT_TRUE(contains(error_of([&] { light_section::load_pattern(rig, path); }), "outside 0 to 1"));
  images::write_float_tiff(folder / "pattern.tiff", images::FloatImage(3, 4));
  EXPECT_TRUE(contains(error_of([&] { light_section::load_pattern(rig, path); }),
                       "has 3 x 4 pixels; the rig's projector has 512"));
}

TEST(CurveFile, Csv) {
  const light_section::ReferenceCurve curve =
      light_section::parse_curve_csv("y_mm,z_mm\r\n-1.5,1100\n0,\n0, 1e3\n2,1000.5", "c.csv");
  EXPECT_EQ(curve.y_mm, (std::vector<double>{-1.5, 0, 0, 2}));
  EXPECT_EQ(curve.z_mm[0], 1100);
  EXPECT_TRUE(std::isnan(curve.z_mm[1]));
  EXPECT_EQ(curve.z_mm[2], 1000);
  EXPECT_EQ(curve.z_mm[3], 1000.5);
  const auto message = [](const std::string& text) {
    return error_of([&] { light_section::parse_curve_csv(text, "c.csv"); });
  };
  EXPECT_EQ(message("y,z\n"), "c.csv: line 1: y_mm,z_mm is expected");
  EXPECT_EQ(message(""), "c.csv: line 1: y_mm,z_mm is expected");
  EXPECT_EQ(message("y_mm,z_mm\n0,1000\n"), "c.csv: has fewer than two points");
  EXPECT_EQ(message("y_mm,z_mm\n0,1000\n-1,1000\n"), "c.csv: line 3: y falls from 0 to -1");
  EXPECT_EQ(message("y_mm,z_mm\n0,1000,3\n"), "c.csv: line 2: two numbers are expected: y, z");
  EXPECT_EQ(message("y_mm,z_mm\n0,12mm\n"), "c.csv: line 2: '12mm' is not a number");
  EXPECT_TRUE(contains(message("y_mm,z_mm\n0,-5\n"), "must be greater than 0"));
  EXPECT_EQ(message("y_mm,z_mm\n0,1e39\n"), "c.csv: line 2: z is 1e+39; its size may be at most 1000000");
  EXPECT_EQ(message("y_mm,z_mm\n-1e308,9\n"), "c.csv: line 2: y is -1e+308; its size may be at most 1000000");
  EXPECT_TRUE(contains(message("y_mm,z_mm\n0,1e-320\n"), "at least 0.001"));
  EXPECT_TRUE(contains(message("y_mm,z_mm\n0,nan\n"), "is not a number"));
}

TEST(CurveFile, HeightsOfFrames) {
  const rig::Rig rig = rig::load_rig("light-section");
  const ScratchFolder folder;
  const std::string file = (folder / "h.tiff").string();
  images::FloatImage heights(3, 512);
  for (int c = 0; c < 512; ++c) {
    heights.row(0)[c] = 1;
    heights.row(1)[c] = 30;
    heights.row(2)[c] = 2;
  }
  heights.row(2)[5] = std::numeric_limits<float>::quiet_NaN();
  images::write_float_tiff(file, heights);
  EXPECT_EQ(light_section::load_curve(rig, file, {}).z_mm[4], 1165);  // the median
  EXPECT_EQ(light_section::load_curve(rig, file, 2).z_mm[4], 1137);
  EXPECT_TRUE(std::isnan(light_section::load_curve(rig, file, 3).z_mm[5]));
  EXPECT_NEAR(light_section::load_curve(rig, file, 3).y_mm[0], -255.5 * 0.01 / 50 * 1165, 1e-9);
  EXPECT_TRUE(contains(error_of([&] { light_section::load_curve(rig, file, 4); }), "has no frame 4; it has 3"));
  images::write_float_tiff(file, images::FloatImage(1, 500));
  EXPECT_TRUE(contains(error_of([&] { light_section::load_curve(rig, file, {}); }),
                       "has 500 columns; the rig's camera has 512"));
  EXPECT_TRUE(contains(error_of([&] { light_section::load_curve(rig, (folder / "none.csv").string(), {}); }),
                       "none.csv: No such file"));
  EXPECT_TRUE(contains(error_of([&] { light_section::load_curve(rig, folder.path().string(), {}); }), "is a folder"));
}

}  // namespace
}  // namespace selfproj::test
