// Writes a small inspection with known numbers, reads every file back and compares it.
#include "selfproj/light_section/inspection.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <sstream>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/files/output_folder.h"
#include "host/report/inspection_output.h"
#include "selfproj/files/user_error.h"
#include "selfproj/images/float_image.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

constexpr int kColumns = 8;
constexpr int kFrames = 6;
constexpr float kNone = std::numeric_limits<float>::quiet_NaN();

struct Sample {
  model::PacketHeader header;
  model::Moments moments;
  light_section::Profile profile;
};

// Frame i (from 0). Every number reveals its place. In each frame one column is invalid, each for another reason.
Sample sample(int i) {
  Sample s;
  s.header.kind = spec::kKindMoments;
  s.header.sequence = static_cast<std::uint64_t>(100 + i);
  s.header.time_stamp = static_cast<std::uint64_t>(15120) * static_cast<std::uint64_t>(i) + 7;
  s.header.encoder = static_cast<std::uint32_t>(-20 + 10 * i);  // through 0
  s.header.columns = kColumns;
  s.header.rows = 96;
  s.header.mode = spec::kModeGreyOver;
  s.header.threshold = 20;
  s.moments.resize(kColumns);
  s.profile.resize(kColumns);
  for (int c = 0; c < kColumns; ++c) {
    const auto at = static_cast<std::size_t>(c);
    const bool valid = c != i + 1;
    s.moments.m0[at] = c == 1 && i == 0 ? 0U : static_cast<std::uint32_t>(200 + c);
    s.moments.m1[at] = s.moments.m0[at] * 48 + static_cast<std::uint32_t>(i);
    s.moments.n[at] = static_cast<std::uint32_t>(4 + c);
    const auto value = [&](double v) { return valid ? static_cast<float>(v) : kNone; };
    s.profile.centroid[at] = value(48 + 0.001 * i);
    s.profile.x[at] = value(0.5 + 0.01 * i + 0.001 * c);
    s.profile.y[at] = value(-4 + c);
    s.profile.z[at] = value(1150 - i - 0.25 * c);
    s.profile.dx[at] = value(0.002 * c);
    s.profile.dy[at] = value(-0.003 * c);
    s.profile.dz[at] = value(0.125 * (c - 4));
    s.profile.validity[at] = static_cast<std::uint8_t>(valid ? 0 : i + 1);
  }
  return s;
}

light_section::Inspection inspect(int frames = kFrames, const light_section::InspectionOptions& options = {}) {
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns, options);
  for (int i = 0; i < frames; ++i) {
    Sample s = sample(i);
    inspection.add(s.header, s.moments.view(), s.profile.view());
  }
  return inspection;
}

report::CameraPicture camera_picture() {
  report::CameraPicture camera;
  camera.image.rows = 16;
  camera.image.columns = kColumns;
  camera.image.pixels.assign(16 * kColumns, 30);
  camera.moments = sample(0).moments;
  camera.frame = 1;
  return camera;
}

std::vector<std::vector<std::string>> read_csv(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> rows;
  std::istringstream lines(read_text(file));
  for (std::string line; std::getline(lines, line);) {
    rows.emplace_back();
    std::istringstream cells(line);
    for (std::string cell; std::getline(cells, cell, ',');) {
      rows.back().push_back(cell);
    }
  }
  return rows;
}

class WrittenInspection : public ::testing::Test {
 protected:
  void SetUp() override {
    files::OutputFolder output(scratch_ / "out");
    report::ReportParts parts;
    parts.title = "A <test> & more";
    parts.counters = {{"lost_board", "lost on the board", std::int64_t{1234567}}};
    parts.settings = {{"scene", "scene", std::string("stairs")}, {"gain", "gain", 1.5, "dB"}};
    parts.tables = {{"Published and measured", {"what", "published", "measured"}, {{"step", "30.12", "30.01"}}}};
    parts.camera = camera_picture();
    report::write_inspection(inspect(), output, parts);
    output.commit();
  }
  [[nodiscard]] std::filesystem::path file(const std::string& name) const { return scratch_ / "out" / name; }

  ScratchFolder scratch_;
};

TEST_F(WrittenInspection, HasAllFilesAndNothingElse) {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(scratch_ / "out")) {
    names.push_back(entry.path().filename());
  }
  std::sort(names.begin(), names.end());
  EXPECT_EQ(names,
            (std::vector<std::string>{"cloud.ply", "difference.png", "difference.tiff", "frame_1.png", "height.png",
                                      "height.tiff", "moments.csv", "profile.csv", "report.html", "summary.json"}));
  EXPECT_EQ(scratch_.names(), std::vector<std::string>{"out"});
}

TEST_F(WrittenInspection, MomentsOfEveryColumn) {
  const auto rows = read_csv(file("moments.csv"));
  ASSERT_EQ(rows.size(), 1U + kFrames * kColumns);
  EXPECT_EQ(rows[0], (std::vector<std::string>{"frame", "column", "m0", "m1", "n"}));
  std::size_t at = 1;
  for (int i = 0; i < kFrames; ++i) {
    const Sample s = sample(i);
    for (std::size_t c = 0; c < kColumns; ++c, ++at) {
      EXPECT_EQ(rows[at],
                (std::vector<std::string>{std::to_string(i + 1), std::to_string(c + 1), std::to_string(s.moments.m0[c]),
                                          std::to_string(s.moments.m1[c]), std::to_string(s.moments.n[c])}));
    }
  }
}

TEST_F(WrittenInspection, ProfileOfEveryValidColumn) {
  const auto rows = read_csv(file("profile.csv"));
  ASSERT_EQ(rows.size(), 1U + kFrames * (kColumns - 1));
  EXPECT_EQ(rows[0], (std::vector<std::string>{"frame", "column", "x", "y", "z", "dx", "dy", "dz"}));
  std::size_t at = 1;
  for (int i = 0; i < kFrames; ++i) {
    const Sample s = sample(i);
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (s.profile.validity[c] != 0) {
        continue;
      }
      ASSERT_EQ(rows[at].size(), 8U);
      EXPECT_EQ(rows[at][0], std::to_string(i + 1));
      EXPECT_EQ(rows[at][1], std::to_string(c + 1));
      const std::array<float, 6> expected = {s.profile.x[c],  s.profile.y[c],  s.profile.z[c],
                                             s.profile.dx[c], s.profile.dy[c], s.profile.dz[c]};
      for (std::size_t k = 0; k < expected.size(); ++k) {
        EXPECT_NEAR(std::stod(rows[at][k + 2]), static_cast<double>(expected[k]), 0.5001e-4);
      }
      ++at;
    }
  }
}

// x is less by 10 counts of 0.01 mm for each frame.
TEST_F(WrittenInspection, CloudIsCarriedBackByTheBelt) {
  const std::string ply = read_text(file("cloud.ply"));
  const std::string end = "end_header\n";
  const std::size_t header = ply.find(end) + end.size();
  EXPECT_EQ(ply.rfind("ply\nformat binary_little_endian 1.0\n", 0), 0U);
  const std::size_t points = kFrames * (kColumns - 1);
  EXPECT_NE(ply.find("element vertex " + std::to_string(points) + "\n"), std::string::npos);
  ASSERT_EQ(ply.size(), header + points * 27);
  std::size_t at = header;
  for (int i = 0; i < kFrames; ++i) {
    const Sample s = sample(i);
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (s.profile.validity[c] != 0) {
        continue;
      }
      std::array<float, 6> point{};
      for (std::size_t k = 0; k < 6; ++k) {
        std::uint32_t bits = 0;
        for (std::size_t byte = 0; byte < 4; ++byte) {
          // three bytes of colour before the last two
          bits |= static_cast<std::uint32_t>(static_cast<std::uint8_t>(ply[at + 4 * k + (k < 4 ? 0 : 3) + byte]))
                  << (8 * byte);
        }
        point.at(k) = std::bit_cast<float>(bits);
      }
      EXPECT_NEAR(point[0], s.profile.x[c] - 0.1F * static_cast<float>(i), 1e-6);
      EXPECT_EQ(point[1], s.profile.y[c]);
      EXPECT_EQ(point[2], s.profile.z[c]);
      EXPECT_EQ(point[3], -s.profile.dz[c]);
      const auto light = static_cast<float>(s.moments.m0[c]);
      EXPECT_EQ(point[4], s.moments.n[c] > 0 ? light / static_cast<float>(s.moments.n[c]) : 0);
      EXPECT_EQ(point[5], light);
      at += 27;
    }
  }
}

TEST_F(WrittenInspection, HeightAndDifferenceAreTowardsTheCamera) {
  const images::FloatImage height = images::read_float_tiff(file("height.tiff"));
  const images::FloatImage difference = images::read_float_tiff(file("difference.tiff"));
  ASSERT_EQ(height.rows, kFrames);
  ASSERT_EQ(height.columns, kColumns);
  ASSERT_EQ(difference.rows, kFrames);
  for (int i = 0; i < kFrames; ++i) {
    const Sample s = sample(i);
    for (int c = 0; c < kColumns; ++c) {
      const auto at = static_cast<std::size_t>(c);
      if (s.profile.validity[at] != 0) {
        EXPECT_TRUE(std::isnan(height.row(i)[c]));
        EXPECT_TRUE(std::isnan(difference.row(i)[c]));
      } else {
        EXPECT_FLOAT_EQ(height.row(i)[c], 1167.0F - s.profile.z[at]);
        EXPECT_FLOAT_EQ(difference.row(i)[c], -s.profile.dz[at]);
      }
    }
  }
}

TEST_F(WrittenInspection, PicturesAreThere) {
  for (const char* name : {"difference.png", "height.png", "frame_1.png"}) {
    const cv::Mat picture = cv::imread(file(name), cv::IMREAD_UNCHANGED);
    EXPECT_EQ(picture.type(), CV_8UC3) << name;
    EXPECT_GT(picture.cols, 100) << name;
  }
}

TEST_F(WrittenInspection, SummaryCounts) {
  const auto json = nlohmann::json::parse(read_text(file("summary.json")));
  EXPECT_EQ(json["frames"], kFrames);
  EXPECT_EQ(json["columns"], kColumns);
  EXPECT_EQ(json["column_count"]["valid"], kFrames * (kColumns - 1));
  for (const char* reason : {"unlit", "too_few", "too_wide", "cut_off", "no_reference", "out_of_range"}) {
    EXPECT_EQ(json["column_count"][reason], 1) << reason;
  }
  EXPECT_EQ(json["counters"]["lost_board"], 1234567);
  EXPECT_EQ(json["settings"]["scene"], "stairs");
  EXPECT_DOUBLE_EQ(json["settings"]["gain"], 1.5);
  EXPECT_EQ(json["belt"]["x_from"], "encoder");
  EXPECT_DOUBLE_EQ(json["belt"]["mm"], 0.5);
  EXPECT_DOUBLE_EQ(json["belt"]["mm_per_frame"], 0.1);
  EXPECT_EQ(json["first_sequence"], 100);
  EXPECT_EQ(json["mode"], "grey-over");
  EXPECT_DOUBLE_EQ(json["height_mm"]["min"], 17);       // frame 1, column 1
  EXPECT_DOUBLE_EQ(json["difference_mm"]["max"], 0.5);  // column 1
  EXPECT_EQ(rig::parse_rig(json["rig"]["yaml"], "summary").camera.columns, 512);
  EXPECT_EQ(json["tables"][0]["rows"][0][2], "30.01");
}

// One file without outside addresses, in which texts of the program are text and not markup.
TEST_F(WrittenInspection, ReportStandsAlone) {
  const std::string html = read_text(file("report.html"));
  EXPECT_EQ(html.find("http"), std::string::npos);
  EXPECT_EQ(html.find("<script"), std::string::npos);
  EXPECT_EQ(html.find("nan"), std::string::npos);
  EXPECT_NE(html.find("A &lt;test&gt; &amp; more"), std::string::npos);
  EXPECT_NE(html.find("prefers-color-scheme: dark"), std::string::npos);
  EXPECT_NE(html.find("<td>30.01</td>"), std::string::npos);
  EXPECT_NE(html.find("1\u202f234\u202f567"), std::string::npos);
  std::size_t pictures = 0;
  const std::string mark = "src=\"data:image/png;base64,";
  for (std::size_t at = html.find(mark); at != std::string::npos; at = html.find(mark, at + 1)) {
    EXPECT_EQ(html.compare(at + mark.size(), 8, "iVBORw0K"), 0);  // PNG's first bytes
    ++pictures;
  }
  EXPECT_EQ(pictures, 3U);
}

TEST(Inspection, ThePayloadSaysTheSameAsTheNumbers) {
  const ScratchFolder scratch;
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns, {.expected_frames = 2});
  for (int i = 0; i < kFrames; ++i) {
    Sample s = sample(i);
    std::vector<std::uint8_t> payload(model::moments_payload_bytes(model::Mode::grey_over, kColumns));
    model::pack_moments(model::Mode::grey_over, kColumns, s.moments.view(), payload.data());
    inspection.add(s.header, payload, s.profile.view());
  }
  files::OutputFolder by_payload(scratch / "a");
  report::write_inspection(inspection, by_payload);
  by_payload.commit();
  files::OutputFolder by_numbers(scratch / "b");
  report::write_inspection(inspect(), by_numbers);
  by_numbers.commit();
  for (const auto& entry : std::filesystem::directory_iterator(scratch / "a")) {
    EXPECT_EQ(read_text(entry.path()), read_text(scratch.path() / "b" / entry.path().filename())) << entry.path();
  }
}

TEST(Inspection, BeltByTimeWhereTheEncoderStands) {
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns);
  for (int i = 0; i < kFrames; ++i) {
    Sample s = sample(i);
    s.header.encoder = 5;
    s.header.time_stamp *= 2;  // every second frame was lost
    inspection.add(s.header, s.moments.view(), s.profile.view());
  }
  EXPECT_FALSE(inspection.encoder_counts());
  const std::vector<double> belt = inspection.belt_mm();
  for (std::size_t i = 0; i < belt.size(); ++i) {
    EXPECT_NEAR(belt[i], 0.2 * static_cast<double>(i), 1e-9);
  }
  EXPECT_NEAR(inspection.frame_spacing_mm(), 0.2, 1e-9);
  EXPECT_NEAR(inspection.column_spacing_mm(), 0.2334, 1e-9);
}

// The belt may run backwards, and the encoder's count may go through 0 and wrap.
TEST(Inspection, BeltByTheEncoderInBothDirections) {
  constexpr std::array<int, 5> kCounts{0, 15, -5, -20, -8};
  for (const std::uint32_t start : {1000U, 3U, 0x7FFFFFFEU, 0xFFFFFFFEU}) {
    SCOPED_TRACE(start);
    light_section::Inspection inspection(rig::load_rig("light-section"), kColumns);
    for (std::size_t i = 0; i < kCounts.size(); ++i) {
      Sample s = sample(static_cast<int>(i));
      s.header.encoder = start + static_cast<std::uint32_t>(kCounts[i]);
      inspection.add(s.header, s.moments.view(), s.profile.view());
    }
    const double mm_per_count = inspection.rig().conveyor.encoder_mm_per_count;
    const std::vector<double> belt = inspection.belt_mm();
    ASSERT_EQ(belt.size(), kCounts.size());
    for (std::size_t i = 0; i < kCounts.size(); ++i) {
      EXPECT_NEAR(belt[i], kCounts[i] * mm_per_count, 1e-9) << i;
    }
    EXPECT_NEAR(inspection.frame_spacing_mm(), 2 * mm_per_count, 1e-9);
  }
}

TEST(Inspection, BeltMovesOnWhereTheBoardWasRestarted) {
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns);
  for (const int i : {0, 1, 2, 0, 1}) {
    Sample s = sample(i);
    inspection.add(s.header, s.moments.view(), s.profile.view());
  }
  const std::vector<double> belt = inspection.belt_mm();
  for (std::size_t i = 0; i < belt.size(); ++i) {
    EXPECT_NEAR(belt[i], 0.1 * static_cast<double>(i), 1e-9);
  }
}

TEST(Inspection, CountsWhatItDoesNotKeep) {
  const light_section::Inspection inspection = inspect(5, {.max_frames = 3});
  EXPECT_EQ(inspection.frames(), 3U);
  EXPECT_EQ(inspection.frames_not_kept(), 2U);
  EXPECT_EQ(inspection.height().rows, 3);
}

TEST(Inspection, OneFrameWithoutAPointIsWritten) {
  const ScratchFolder scratch;
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns);
  Sample s = sample(0);
  std::fill(s.profile.validity.begin(), s.profile.validity.end(),
            static_cast<std::uint8_t>(light_section::Validity::unlit));
  for (auto* values : {&s.profile.x, &s.profile.y, &s.profile.z, &s.profile.dx, &s.profile.dy, &s.profile.dz}) {
    std::fill(values->begin(), values->end(), kNone);
  }
  inspection.add(s.header, s.moments.view(), s.profile.view());
  files::OutputFolder output(scratch / "out");
  report::write_inspection(inspection, output);
  output.commit();
  EXPECT_EQ(read_text(scratch.path() / "out" / "profile.csv"), "frame,column,x,y,z,dx,dy,dz\n");
  EXPECT_TRUE(nlohmann::json::parse(read_text(scratch.path() / "out" / "summary.json"))["height_mm"].is_null());
  EXPECT_EQ(read_text(scratch.path() / "out" / "report.html").find("nan"), std::string::npos);
}

TEST(Inspection, WrongWidthsAndNothingAtAll) {
  const ScratchFolder scratch;
  light_section::Inspection inspection(rig::load_rig("light-section"), kColumns);
  Sample s = sample(0);
  s.header.columns = 12;
  EXPECT_THROW(inspection.add(s.header, s.moments.view(), s.profile.view()), std::invalid_argument);
  s.header.columns = kColumns;
  const std::vector<std::uint8_t> payload(16);
  EXPECT_THROW(inspection.add(s.header, payload, s.profile.view()), std::invalid_argument);
  EXPECT_THROW(light_section::Inspection(rig::load_rig("light-section"), 0), std::invalid_argument);
  EXPECT_EQ(inspection.frames(), 0U);
  {
    files::OutputFolder output(scratch / "out");
    EXPECT_THROW(report::write_inspection(inspection, output), UserError);
  }
  EXPECT_TRUE(scratch.names().empty());
}

}  // namespace
}  // namespace selfproj::test
