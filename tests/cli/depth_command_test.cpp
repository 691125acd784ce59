// Tests the contract of `selfproj depth`.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <utility>
#include <vector>

#include "host/report/depth_output.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/point_cloud.h"
#include "selfproj/structured_light/triangulation.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"
#include "tests/host/structured_light/pinhole.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

constexpr int kRows = 30;
constexpr int kColumns = 40;
constexpr int kBits = 6;

constexpr const char* kCalibration = R"(%YAML:1.0
cam_K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 50., 0., 19.5, 0., 50., 14.5, 0., 0., 1. ]
cam_kc: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0.01, 0., 0., 0., 0. ]
pro_K: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 80., 0., 31.5, 0., 80., 31.5, 0., 0., 1. ]
pro_kc: !!opencv-matrix
   rows: 1
   cols: 5
   dt: d
   data: [ 0.02, 0., 0., 0., 0. ]
R: !!opencv-matrix
   rows: 3
   cols: 3
   dt: d
   data: [ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]
T: !!opencv-matrix
   rows: 3
   cols: 1
   dt: d
   data: [ 100., 0., 0. ]
)";

class DepthCommand : public ::testing::Test {
 protected:
  DepthCommand() {
    rig_.camera.rows = kRows;
    rig_.camera.columns = kColumns;
    rig_.camera.pixel_pitch_mm = 0.1;
    rig_.projector.lines = 64;
    rig_.projector.line_pitch_mm *= 12;
    rig_.measure.max_z_per_line_mm = 60;
    write_text(folder_ / "rig.yaml", rig::to_yaml(rig_));
    write_text(folder_ / "cal.yaml", kCalibration);
  }

  // The code of a pixel whose surface is `height(row, column)` mm above the plane; -1 if it is not lit.
  template <class Height>
  std::vector<int> codes_of(Height&& height) const {
    std::vector<int> codes;
    for (int row = 0; row < kRows; ++row) {
      for (int column = 0; column < kColumns; ++column) {
        const double z = rig_.plane_z_mm - height(row, column);
        const double x = z * rig_.camera.pixel_pitch_mm * (row - 0.5 * (kRows - 1)) / rig_.camera.focal_length_mm;
        const double code = std::floor(projector_lights(rig_.projector, {x, 0, z}).row + 0.5);
        codes.push_back(code >= 0 && code < rig_.projector.lines ? static_cast<int>(code) : -1);
      }
    }
    return codes;
  }

  // Positive and negative of plane `plane`, as NAME_PP.png.
  void save_pair(const std::string& name, int plane, const std::vector<int>& codes) {
    for (const int half : {0, 1}) {
      cv::Mat image(kRows, kColumns, CV_8UC1);
      for (int i = 0; i < kRows * kColumns; ++i) {
        const int code = codes[static_cast<std::size_t>(i)];
        const int gray = (code ^ (code >> 1)) >> (kBits - 1 - plane) & 1;
        image.at<std::uint8_t>(i / kColumns, i % kColumns) = static_cast<std::uint8_t>(code < 0       ? 30
                                                                                       : gray != half ? 200
                                                                                                      : 40);
      }
      files_.push_back(fmt::format("{}_{:02}.png", name, files_.size()));
      save(files_.back(), image);
    }
  }

  void save(const std::string& name, const cv::Mat& image) const {
    ASSERT_TRUE(cv::imwrite((folder_ / name).string(), image));
  }

  void save_cycle(const std::string& name, const std::vector<int>& codes) {
    for (int plane = 0; plane < kBits; ++plane) {
      save_pair(name, plane, codes);
    }
  }

  // The depths of the codes, computed by the classes.
  images::FloatImage expected(const std::vector<int>& codes) const {
    std::vector<std::uint16_t> words;
    for (const int code : codes) {
      words.push_back(code < 0 ? std::uint16_t{0} : static_cast<std::uint16_t>(code | 0x8000));
    }
    images::FloatImage depth(kRows, kColumns);
    structured_light::PlaneTriangulation(rig_, kBits).depth(words.data(), depth.values.data());
    return depth;
  }

  Outcome depth(std::vector<std::string> arguments) const {
    arguments.insert(arguments.begin(), {"depth", "--out", "out"});
    return run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
  }

  Outcome depth_of_files(std::vector<std::string> arguments) const {
    arguments.insert(arguments.end(), files_.begin(), files_.end());
    return depth(std::move(arguments));
  }

  images::FloatImage tiff(const std::string& name) const {
    return images::read_float_tiff((folder_ / "out" / name).string());
  }

  // Expects status 2, one line with the subject first, and nothing written.
  void expect_refused(const std::vector<std::string>& arguments, const std::string& subject,
                      const std::string& reason) const {
    SCOPED_TRACE(subject);
    expect_refusal(depth(arguments), subject, {reason});
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }

  ScratchFolder folder_;
  rig::Rig rig_ = rig::load_rig("scanner");
  std::vector<std::string> files_;
};

bool same(const images::FloatImage& a, const images::FloatImage& b) {
  return a.rows == b.rows && a.columns == b.columns &&
         std::memcmp(a.values.data(), b.values.data(), a.values.size() * sizeof(float)) == 0;
}

double flat(int /*row*/, int /*column*/) { return 0; }

TEST_F(DepthCommand, WritesTheDepthOfOneCycle) {
  const std::vector<int> codes = codes_of([](int row, int column) { return row + column > 30 ? 60.0 : 0.0; });
  save_cycle("a", codes);
  const Outcome outcome = depth_of_files({"--rig", "rig.yaml", "--bits", "6"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out.rfind("1 depth image of 40 x 30, 6 bits, threshold 5 → out\n", 0), 0U) << outcome.out;
  const images::FloatImage depth = expected(codes);
  EXPECT_TRUE(same(tiff("depth.tiff"), depth));
  EXPECT_FALSE(fs::exists(folder_ / "out/depth_0005.tiff"));
  EXPECT_FALSE(fs::exists(folder_ / "out/moved.csv"));

  const cv::Mat picture = cv::imread((folder_ / "out/depth.png").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(picture.type(), CV_16UC1);
  std::size_t points = 0;
  for (std::size_t i = 0; i < depth.values.size(); ++i) {
    const auto value = picture.at<std::uint16_t>(static_cast<int>(i) / kColumns, static_cast<int>(i) % kColumns);
    if (std::isnan(depth.values[i])) {
      EXPECT_EQ(value, 0);
    } else {
      ++points;
      EXPECT_NEAR(value * report::kDepthUnit, static_cast<double>(depth.values[i]), report::kDepthUnit / 2 + 1e-6);
    }
  }
  EXPECT_GT(points, 500U);
  EXPECT_EQ(structured_light::read_ply((folder_ / "out/cloud.ply").string()).size(), points);
  EXPECT_FALSE(cv::imread((folder_ / "out/depth_colour.png").string()).empty());
  const std::string summary = read_text(folder_ / "out/summary.json");
  EXPECT_NE(summary.find(fmt::format("\"valid\": {}", points)), std::string::npos) << summary;
  EXPECT_NE(summary.find("\"too_coarse\""), std::string::npos);
}

// The first pairs of a longer code, whose codes are a line each and more than the lines, say how many lines they cover.
TEST_F(DepthCommand, TheFirstPairsOfALongerCodeOfARig) {
  rig_.projector.lines = 48;
  write_text(folder_ / "rig.yaml", rig::to_yaml(rig_));
  save_cycle("a", codes_of(flat));
  files_.resize(10);  // 5 of 6 pairs
  const auto median = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--rig", "rig.yaml", "--bits", "5", "--max-z-per-line", "1000"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = depth_of_files(arguments);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    std::vector<float> z = tiff("depth.tiff").values;
    z.erase(std::remove_if(z.begin(), z.end(), [](float value) { return std::isnan(value); }), z.end());
    EXPECT_GT(z.size(), 300U);
    std::nth_element(z.begin(), z.begin() + static_cast<std::ptrdiff_t>(z.size() / 2), z.end());
    return static_cast<double>(z[z.size() / 2]);
  };
  EXPECT_NEAR(median({"--lines", "64"}), rig_.plane_z_mm, 30);  // two lines are 70 mm
  EXPECT_GT(std::abs(median({}) - rig_.plane_z_mm), 100);
}

// A depth image comes after every pair from the m-th on, with the pixels that moved against the background.
TEST_F(DepthCommand, StreamsADepthImageAPairAndFollowsWhatMoves) {
  const std::vector<int> plane = codes_of(flat);
  const std::vector<int> object =
      codes_of([](int row, int column) { return row >= 5 && row < 15 && column >= 10 && column < 20 ? 100.0 : 0.0; });
  images::write_float_tiff((folder_ / "background.tiff").string(), expected(plane));
  save_cycle("a", plane);
  save_cycle("b", object);
  const Outcome outcome =
      depth_of_files({"--rig", "rig.yaml", "--bits", "6", "--background", "background.tiff", "--min-difference", "20"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_TRUE(same(tiff("depth_0005.tiff"), expected(plane)));
  EXPECT_TRUE(same(tiff("depth_0011.tiff"), expected(object)));
  EXPECT_TRUE(same(tiff("depth.tiff"), expected(object)));
  for (int pair = 5; pair < 12; ++pair) {
    EXPECT_TRUE(fs::exists(folder_ / fmt::format("out/depth_{:04}.tiff", pair)));
  }
  const images::FloatImage moved = tiff("moved.tiff");
  double count = 0;
  double z = 0;
  for (const float value : moved.values) {
    count += std::isnan(value) ? 0 : 1;
    z += std::isnan(value) ? 0 : static_cast<double>(value);
  }
  EXPECT_EQ(count, 100);
  const std::string table = read_text(folder_ / "out/moved.csv");
  EXPECT_EQ(table.rfind("pair,pixels,x,y,z\n5,0,,,\n", 0), 0U) << table;
  const std::size_t last = table.find("\n11,100,");
  ASSERT_NE(last, std::string::npos) << table;
  EXPECT_NE(table.find(fmt::format(",{:.2f}", z / count).substr(0, 6), last), std::string::npos) << table;
  EXPECT_EQ(std::count(table.begin(), table.end(), '\n'), 8);
}

TEST_F(DepthCommand, TakesACalibrationAndComparesClouds) {
  for (int axis = 0; axis < 2; ++axis) {
    // One pixel is lit, by the projector pixel that the undistorted lenses would give a point at z = 500.
    std::vector<int> codes(kRows * kColumns, -1);
    const double x = 500 * (20 - 19.5) / 50;
    const double y = 500 * (10 - 14.5) / 50;
    codes[10 * kColumns + 20] =
        static_cast<int>(std::lround(axis == 0 ? 80 * (x + 100) / 500 + 31.5 : 80 * y / 500 + 31.5));
    save_cycle(axis == 0 ? "x" : "y", codes);
  }
  structured_light::PlyText ply(2);
  ply.add({5, 45, -500}, 0, 0, 0);
  ply.add({500, 45, -500}, 0, 0, 0);
  write_text(folder_ / "cloud.ply", ply.file("two points"));
  const Outcome outcome = depth_of_files(
      {"--calibration", "cal.yaml", "--bits", "6", "--row-bits", "6", "--compare", "cloud.ply", "--compare-opengl"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  const images::FloatImage depth = tiff("depth.tiff");
  EXPECT_EQ(std::count_if(depth.values.begin(), depth.values.end(), [](float z) { return !std::isnan(z); }), 1);
  EXPECT_NEAR(static_cast<double>(depth.values[10 * kColumns + 20]), 500, 20);  // half a column is worth 16 mm
  EXPECT_NE(outcome.out.find("our 1 points to its 2"), std::string::npos) << outcome.out;

  // A cloud in other axes is told, in the files too.
  structured_light::PlyText other(1);
  other.add({-45, -5, -500}, 0, 0, 0);
  write_text(folder_ / "cloud.ply", other.file("that point, x and y exchanged"));
  std::vector<std::string> words = {"--calibration", "cal.yaml", "--bits",    "6",
                                    "--row-bits",    "6",        "--compare", "cloud.ply"};
  const std::string doubt = depth_of_files(words).err;
  EXPECT_NE(doubt.find("mm with --compare-exchange-xy --compare-opengl: are the clouds in one frame?"),
            std::string::npos)
      << doubt;
  EXPECT_NE(read_text(folder_ / "out/summary.json").find("--compare-opengl: are the"), std::string::npos);
  words.insert(words.end(), {"--compare-exchange-xy", "--compare-opengl"});
  EXPECT_EQ(depth_of_files(words).err, "");
  EXPECT_EQ(read_text(folder_ / "out/summary.json").find("doubts"), std::string::npos);
}

// ------------------------------------------------------------------ codes of a board

// The packets of one code image, one for each line. Line `skip` (from 0) is lost.
void append_code_image(std::vector<std::uint8_t>& stream, std::uint64_t sequence, const std::vector<int>& codes,
                       int skip = -1) {
  for (int row = 0; row < kRows; ++row) {
    model::PacketHeader header;
    header.kind = spec::kKindCodes;
    header.sequence = sequence;
    header.time_stamp = 1000 * sequence;
    header.columns = kColumns;
    header.rows = kRows;
    header.pattern = static_cast<std::uint16_t>(2 * kBits - 1);
    header.first_line = static_cast<std::uint16_t>(row + 1);
    header.lines = 1;
    std::vector<std::uint8_t> payload;
    for (int column = 0; column < kColumns; ++column) {
      const int code = codes[static_cast<std::size_t>(row * kColumns + column)];
      const unsigned word = code < 0 ? 0U : static_cast<unsigned>(code) | 0x8000U;
      payload.push_back(static_cast<std::uint8_t>(word & 0xFFU));
      payload.push_back(static_cast<std::uint8_t>(word >> 8U));
    }
    payload.resize(model::codes_line_payload_bytes(kColumns));
    if (row != skip) {
      model::append_packet(header, payload, 0, stream);
    }
  }
}

TEST_F(DepthCommand, TakesTheCodesOfADevice) {
  const std::vector<int> plane = codes_of(flat);
  const std::vector<int> object =
      codes_of([](int row, int column) { return row >= 5 && row < 15 && column >= 10 && column < 20 ? 100.0 : 0.0; });
  std::vector<std::uint8_t> stream;
  append_code_image(stream, 11, plane);
  append_code_image(stream, 13, object, 7);  // incomplete
  append_code_image(stream, 15, object);
  append_code_image(stream, 17, plane);
  write_text(folder_ / "codes.bin", std::string(stream.begin(), stream.end()));
  images::write_float_tiff((folder_ / "background.tiff").string(), expected(plane));
  const Outcome outcome = depth({"--device", "file:codes.bin", "--count", "2", "--rig", "rig.yaml", "--bits", "6",
                                 "--background", "background.tiff", "--min-difference", "20"});
  EXPECT_EQ(outcome.err, "");
  EXPECT_EQ(outcome.status, 0);
  EXPECT_EQ(outcome.out.rfind("2 depth images of 40 x 30, 6 bits, file:codes.bin → out\n", 0), 0U) << outcome.out;
  EXPECT_TRUE(same(tiff("depth.tiff"), expected(object)));
  const std::string table = read_text(folder_ / "out/moved.csv");
  EXPECT_EQ(table.rfind("pair,pixels,x,y,z\n11,0,,,\n15,100,", 0), 0U) << table;
  EXPECT_NE(read_text(folder_ / "out/summary.json").find("\"incomplete\": 1"), std::string::npos);
}

TEST_F(DepthCommand, RefusesADeviceThatDoesNotFit) {
  std::vector<std::uint8_t> stream;
  append_code_image(stream, 11, codes_of(flat));
  write_text(folder_ / "codes.bin", std::string(stream.begin(), stream.end()));
  write_text(folder_ / "empty.bin", "");
  const std::vector<std::string> base{"--rig", "rig.yaml", "--bits", "6"};
  const auto with = [](std::vector<std::string> all, const std::vector<std::string>& more) {
    all.insert(all.end(), more.begin(), more.end());
    return all;
  };
  expect_refused(with(base, {"--device", "file:empty.bin"}), "file:empty.bin: ", "holds no packet of a board");
  expect_refused(with(base, {"--device", "file:missing.bin"}), "missing.bin: ", "No such file");
  expect_refused(with(base, {"--device", "file:codes.bin", "a.png"}), "IMAGE, --device: ", "exactly one");
  expect_refused(base, "IMAGE, --device: ", "one of them");
  expect_refused(with(base, {"--device", "file:codes.bin", "--median"}), "--device: ", "--median");
  expect_refused(with(base, {"--count", "3", "a.png"}), "--count: ", "--device");
  expect_refused({"--rig", "scanner", "--bits", "6", "--device", "file:codes.bin"}, "--rig scanner: ", "512 x 512");
}

// ------------------------------------------------------------------ bad input

TEST_F(DepthCommand, RefusesImagesThatAreNotPairsOfOneSize) {
  save_cycle("a", codes_of(flat));
  const std::vector<std::string> base{"--rig", "rig.yaml", "--bits", "6"};
  const auto with = [&base](const std::vector<std::string>& files) {
    std::vector<std::string> all = base;
    all.insert(all.end(), files.begin(), files.end());
    return all;
  };
  expect_refused(with({files_.begin(), files_.end() - 1}), "IMAGE: ", "odd");
  expect_refused(with({files_.begin(), files_.end() - 2}), "IMAGE: ", "too few; 12");
  std::vector<std::string> files = files_;
  save("small.png", cv::Mat(kRows, kColumns - 1, CV_8UC1, cv::Scalar(9)));
  save("deep.png", cv::Mat(kRows, kColumns, CV_16UC1, cv::Scalar(9)));
  save("colour.png", cv::Mat(kRows, kColumns, CV_8UC3, cv::Scalar(9, 8, 7)));
  for (const auto& [name, reason] :
       std::vector<std::pair<std::string, std::string>>{{"small.png", "all images must have one size"},
                                                        {"deep.png", "16 bits"},
                                                        {"colour.png", "--channel"},
                                                        {"missing.png", "No such file"}}) {
    files[3] = name;
    expect_refused(with(files), name + ": ", reason);
  }
  save("other.png", cv::Mat(8, 8, CV_8UC1, cv::Scalar(9)));
  expect_refused(with(std::vector<std::string>(12, "other.png")), "--rig rig.yaml: ", "40 x 30");
}

TEST_F(DepthCommand, RefusesOptionsOutOfRange) {
  save_cycle("a", codes_of(flat));
  const std::vector<std::pair<std::vector<std::string>, std::string>> cases{
      {{"--rig", "rig.yaml", "--bits", "0"}, "--bits"},
      {{"--rig", "rig.yaml", "--bits", "13"}, "--bits"},
      {{"--rig", "rig.yaml"}, "--bits"},
      {{"--rig", "rig.yaml", "--bits", "6", "--threshold", "256"}, "--threshold"},
      {{"--rig", "rig.yaml", "--bits", "6", "--threshold", "-1"}, "--threshold"},
      {{"--bits", "6"}, "--rig, --calibration"},
      {{"--rig", "rig.yaml", "--calibration", "cal.yaml", "--bits", "6"}, "--rig, --calibration"},
      {{"--rig", "rig.yaml", "--bits", "6", "--row-bits", "6"}, "IMAGE: 12 images are too few; 24 are needed"},
      {{"--rig", "rig.yaml", "--bits", "6", "--lines", "6"}, "--lines: is 6, but no code"},
      {{"--rig", "rig.yaml", "--bits", "6", "--lines", "96"}, "--lines: is 96, but the projector of rig.yaml has 64;"},
      {{"--rig", "rig.yaml", "--bits", "6", "--lines", "128"},
       "--lines: is 128, but the projector of rig.yaml has 64;"},
      {{"--rig", "rig.yaml", "--bits", "6", "--row-lines", "64"}, "--row-lines: goes only with --row-bits"},
      {{"--rig", "rig.yaml", "--bits", "6", "--plane-region", "1,2,3,4"}, "--plane-region: is for --plane"},
      {{"--rig", "rig.yaml", "--bits", "6", "--plane", "--plane-region", "1,2,3"}, "--plane-region: '1,2,3' is not"},
      {{"--rig", "rig.yaml", "--bits", "6", "--plane", "--plane-region", "1,2,3,x"}, "--plane-region: '1,2,3,x' is"},
      {{"--rig", "rig.yaml", "--bits", "6", "--plane", "--plane-region", "1,2,30,4"}, "--plane-region: 1,2,30,4 reach"},
      {{"--rig", "rig.yaml", "--bits", "6", "--strict", "--median"}, "--strict"},
      {{"--rig", "rig.yaml", "--bits", "6", "--min-z", "30", "--max-z", "20"}, "--min-z: is 30, --max-z 20"},
      {{"--rig", "rig.yaml", "--bits", "6", "--compare-opengl"}, "--compare-opengl: is for --compare"},
      {{"--rig", "rig.yaml", "--bits", "6", "--compare-exchange-xy"}, "--compare-exchange-xy: is for --compare"},
      {{"--rig", "nowhere.yaml", "--bits", "6"}, "nowhere.yaml"},
      {{"--rig", "rig.yaml", "--bits", "6", "--background", "nowhere.tiff"}, "nowhere.tiff"},
      {{"--rig", "rig.yaml", "--bits", "6", "--background", "a_00.png"}, "a_00.png"},
      {{"--rig", "rig.yaml", "--bits", "6", "--compare", "nowhere.ply"}, "nowhere.ply"},
      {{"--rig", "rig.yaml", "--bits", "6", "--compare", "a_00.png"}, "a_00.png"},
  };
  for (const auto& [arguments, subject] : cases) {
    std::vector<std::string> all = arguments;
    all.insert(all.end(), files_.begin(), files_.end());
    expect_refused(all, subject, "");
  }
  images::write_float_tiff((folder_ / "other.tiff").string(), images::FloatImage(3, 4));
  std::vector<std::string> all{"--rig", "rig.yaml", "--bits", "6", "--background", "other.tiff"};
  all.insert(all.end(), files_.begin(), files_.end());
  expect_refused(all, "other.tiff: ", "4 x 3");
}

TEST_F(DepthCommand, SaysWhyThereIsNoPoint) {
  save_cycle("a", codes_of(flat));
  const auto reason = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"--rig", "rig.yaml", "--bits", "6"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const Outcome outcome = depth_of_files(arguments);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_FALSE(fs::exists(folder_ / "out"));
    return outcome.err;
  };
  EXPECT_NE(reason({"--threshold", "255"}).find("IMAGE: no pixel has a code, or hardly any: is there light"),
            std::string::npos);
  EXPECT_NE(reason({"--max-z", "10"}).find("100 % of the codes have a point outside of the limits of z"),
            std::string::npos);
  for (const auto& [arguments, text] :
       {std::pair(std::vector<std::string>{"nowhere"}, "nowhere: No such file or directory"),
        {std::vector<std::string>{"a_00.png", "."}, ".: is a folder; give one folder, or files"}}) {
    std::vector<std::string> all{"--rig", "rig.yaml", "--bits", "6"};
    all.insert(all.end(), arguments.begin(), arguments.end());
    expect_refused(all, text, "");
  }
}

// Depths beyond 16 bits of the usual unit are written in a larger one, which summary.json names.
TEST(DepthPng, HasAUnitThatFits) {
  const images::FloatImage near(1, 2, 3276.7F);
  images::FloatImage far = near;
  far.values[1] = 10000;
  EXPECT_DOUBLE_EQ(report::depth_unit(near), 0.05);
  EXPECT_DOUBLE_EQ(report::depth_unit(far), 0.2);
  const std::string png = report::depth_png(far);
  const cv::Mat decoded = cv::imdecode(std::vector<std::uint8_t>(png.begin(), png.end()), cv::IMREAD_UNCHANGED);
  EXPECT_EQ(decoded.at<std::uint16_t>(0, 1), 50000);
}

TEST_F(DepthCommand, RefusesABadCalibration) {
  save_cycle("a", codes_of(flat));
  const auto refuse = [&](const std::string& text, const std::string& reason) {
    write_text(folder_ / "bad.yaml", text);
    std::vector<std::string> all{"--calibration", "bad.yaml", "--bits", "6"};
    all.insert(all.end(), files_.begin(), files_.end());
    expect_refused(all, "bad.yaml: ", reason);
  };
  const std::string good = kCalibration;
  const auto replaced = [&good](const std::string& from, const std::string& to) {
    std::string text = good;
    return text.replace(text.find(from), from.size(), to);
  };
  refuse(replaced("\nR: ", "\nQ: "), "R is missing");
  refuse(replaced("\nT: ", "\nU: "), "T is missing");
  refuse(replaced("cam_K", "K"), "cam_K is missing");
  refuse(replaced("[ 1., 0., 0., 0., 1., 0., 0., 0., 1. ]", "[ 1., 0., 0., 0., 1., 0., 0., 0., 2. ]"),
         "R is not a rotation");
  refuse(replaced("[ 100., 0., 0. ]", "[ 0., 0., 0. ]"), "T is 0");
  refuse(replaced("[ 50., 0., 19.5", "[ 50., 1., 19.5"), "cam_K is not a camera matrix");
  refuse(replaced("cols: 5", "cols: 3"), "cam_kc");
  refuse("nothing: [", "");
  refuse("", "");
  refuse(good + "cam_size: !!opencv-matrix\n   rows: 2\n   cols: 1\n   dt: i\n   data: [ 640, 480 ]\n", "640 x 480");
}

TEST_F(DepthCommand, LeavesAnExistingFolderAsItWasWhereItFails) {
  save_cycle("a", codes_of(flat));
  ASSERT_EQ(depth_of_files({"--rig", "rig.yaml", "--bits", "6"}).status, 0);
  const std::string before = read_text(folder_ / "out/summary.json");
  files_[5] = "missing.png";
  EXPECT_EQ(depth_of_files({"--rig", "rig.yaml", "--bits", "6"}).status, 2);
  EXPECT_EQ(read_text(folder_ / "out/summary.json"), before);
}

}  // namespace
}  // namespace selfproj::test
