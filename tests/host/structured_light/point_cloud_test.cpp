// Tests that PLY files are read as they were written, and compares distances between clouds with those found by trying
// all pairs of points.

#include "selfproj/structured_light/point_cloud.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <utility>
#include <vector>

#include "selfproj/files/user_error.h"
#include "tests/cli/program.h"
#include "tests/support/error_of.h"
#include "tests/support/random_cases.h"

namespace selfproj::test {
namespace {

// The coordinates have few different values, so that many of them are equal.
std::vector<structured_light::Point3f> random_points(Random& random, int count) {
  std::vector<structured_light::Point3f> points;
  const int spread = random.between(1, 60);
  const auto coordinate = [&] { return static_cast<float>(random.between(-spread, spread)) / 4; };
  for (int i = 0; i < count; ++i) {
    points.push_back({coordinate(), coordinate(), coordinate()});
  }
  return points;
}

double nearest(const std::vector<structured_light::Point3f>& points, const structured_light::Point3f& point) {
  double best = std::numeric_limits<double>::infinity();
  for (const structured_light::Point3f& other : points) {
    best = std::min(best, std::hypot(static_cast<double>(other.x - point.x), static_cast<double>(other.y - point.y),
                                     static_cast<double>(other.z - point.z)));
  }
  return best;
}

TEST(NearestPoint, IsTheNearestOfAll) {
  for (const std::uint64_t seed : seeds(200)) {
    SCOPED_TRACE(how_to_repeat(seed));
    Random random(seed);
    const std::vector<structured_light::Point3f> points = random_points(random, random.between(0, 200));
    const structured_light::NearestPoint tree(points);
    for (const structured_light::Point3f& point : random_points(random, 30)) {
      const double expected = nearest(points, point);
      if (std::isinf(expected)) {
        ASSERT_TRUE(std::isinf(tree.distance(point)));
      } else {
        ASSERT_NEAR(tree.distance(point), expected, 1e-5);
      }
    }
  }
}

TEST(CompareClouds, CountsAndMedianAreThoseOfAllPairs) {
  const std::vector<structured_light::Point3f> ours{{0, 0, 0}, {0, 0, 2}, {0, 0, 7}};
  const std::vector<structured_light::Point3f> theirs{{0, 0, 0.5F}, {0, 0, 10}};
  const structured_light::CloudComparison found = structured_light::compare_clouds(ours, theirs, 1.0);
  EXPECT_EQ(found.ours, 3U);
  EXPECT_EQ(found.theirs, 2U);
  EXPECT_NEAR(found.median_mm, 1.5, 1e-6);  // 0.5, 1.5, 3
  EXPECT_NEAR(found.ours_within, 1.0 / 3, 1e-9);
  EXPECT_NEAR(found.theirs_within, 0.5, 1e-9);
  EXPECT_TRUE(std::isnan(structured_light::compare_clouds({}, theirs, 1.0).median_mm));
}

TEST(Ply, ReadsWhatItWrote) {
  const ScratchFolder folder;
  Random random(1);
  const std::vector<structured_light::Point3f> points = random_points(random, 50);
  structured_light::PlyText ply(points.size());
  for (const structured_light::Point3f& point : points) {
    ply.add(point, 1, 2, 3);
  }
  write_text(folder / "a.ply", ply.file("fifty"));
  const std::vector<structured_light::Point3f> found = structured_light::read_ply((folder / "a.ply").string());
  ASSERT_EQ(found.size(), points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    EXPECT_EQ(found[i].x, points[i].x);
    EXPECT_EQ(found[i].y, points[i].y);
    EXPECT_EQ(found[i].z, points[i].z);
  }
}

// The bytes of a number, from the lowest on.
template <class T>
std::string bytes_of(T value, bool big) {
  std::string bytes(sizeof value, '\0');
  std::memcpy(bytes.data(), &value, sizeof value);
  if (big) {
    std::reverse(bytes.begin(), bytes.end());
  }
  return bytes;
}

// Coordinates of any scalar type in any of the three formats, with other properties between them.
TEST(Ply, ReadsEveryFormat) {
  const ScratchFolder folder;
  const std::vector<structured_light::Point3f> points{{-1, 2.5F, 3}, {4, -5.25F, 100}};
  for (const std::string format : {"ascii", "binary_little_endian", "binary_big_endian"}) {
    for (const std::string end : {"\n", "\r\n"}) {
      std::string text =
          "ply" + end + "format " + format + " 1.0" + end + "comment \xE4" + end + "element vertex 2" + end;
      for (const char* property : {"double x", "uchar red", "float32 y", "short z"}) {
        text += std::string("property ") + property + end;
      }
      text += "element face 0" + end + "property list uchar int vertex_indices" + end + "end_header" + end;
      for (const structured_light::Point3f& point : points) {
        const bool big = format == "binary_big_endian";
        text += format == "ascii" ? std::to_string(point.x) + " 7\t" + std::to_string(point.y) + "  " +
                                        std::to_string(static_cast<int>(point.z)) + end
                                  : bytes_of(static_cast<double>(point.x), big) + '\7' + bytes_of(point.y, big) +
                                        bytes_of(static_cast<std::int16_t>(point.z), big);
      }
      write_text(folder / "a.ply", text);
      const std::vector<structured_light::Point3f> found = structured_light::read_ply((folder / "a.ply").string());
      ASSERT_EQ(found.size(), points.size()) << format;
      for (std::size_t i = 0; i < points.size(); ++i) {
        EXPECT_EQ(found[i].x, points[i].x) << format;
        EXPECT_EQ(found[i].y, points[i].y) << format;
        EXPECT_EQ(found[i].z, points[i].z) << format;
      }
    }
  }
}

TEST(Ply, RefusesWhatItDoesNotUnderstand) {
  const ScratchFolder folder;
  structured_light::PlyText ply(1);
  ply.add({1, 2, 3}, 1, 2, 3);
  const std::string good = ply.file("one");
  const auto replaced = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  const std::vector<std::pair<std::string, std::string>> cases{
      {"", "not a PLY"},
      {"plx" + good.substr(3), "not a PLY"},
      {replaced("binary_little_endian", "binary_middle_endian"), "is not a PLY of a known format"},
      {replaced("binary_little_endian", "ascii"), "is not a coordinate"},
      {replaced("float y", "double y"), "is truncated"},
      {replaced("float y", "float w"), "is not a PLY of a known format"},
      {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty float z\nend_header\n1 2 "
       "a\n",
       "vertex 1: 'a' is not a coordinate"},
      {replaced("float z", "quad z"), "type quad"},
      {replaced("vertex 1", "vertex 2"), "is truncated"},
      {replaced("vertex 1", "vertex 99999999999999999"), "is truncated"},
      {replaced("element vertex 1", "element face 1"), "is not a PLY of a known format"},
      {good.substr(0, good.size() - 1), "is truncated"},
  };
  for (const auto& [text, reason] : cases) {
    write_text(folder / "a.ply", text);
    const std::string error = test::error_of([&] { structured_light::read_ply((folder / "a.ply").string()); });
    EXPECT_NE(error.find(reason), std::string::npos) << error << " instead of: " << reason;
  }
}

}  // namespace
}  // namespace selfproj::test
