// Tests the contracts of `selfproj pattern stripes`, `selfproj match` and `selfproj accuracy`.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "host/structured_light/self_reference.h"
#include "selfproj/images/float_image.h"
#include "selfproj/model/gray_decoder.h"
#include "selfproj/model/packet.h"
#include "selfproj/model/packet_payload.h"
#include "selfproj/rig/rig.h"
#include "selfproj/structured_light/gray_sequence.h"
#include "tests/cli/program.h"
#include "tests/cli/refusal.h"
#include "tests/host/light_section/seen_surface.h"

namespace selfproj::test {
namespace {

namespace fs = std::filesystem;

// The camera's image of the points under a pattern of the projector.
void write_picture(const fs::path& file, const structured_light::ProjectorPoints& points,
                   const std::vector<std::uint8_t>& pattern, int pattern_columns) {
  cv::Mat image(points.line.rows, points.line.columns, CV_8UC1);
  for (int r = 0; r < image.rows; ++r) {
    for (int c = 0; c < image.cols; ++c) {
      const float line = points.line.row(r)[c];
      std::uint8_t value = 10;
      if (!std::isnan(line)) {
        const auto at = std::lround(line) * pattern_columns + std::lround(points.column.row(r)[c]);
        value = pattern[static_cast<std::size_t>(at)] != 0 ? 150 : 10;
      }
      image.at<std::uint8_t>(r, c) = value;
    }
  }
  ASSERT_TRUE(cv::imwrite(file.string(), image));
}

class MatchCommand : public ::testing::Test {
 protected:
  MatchCommand() : rig_(coarse_scanner(8)) {
    rig_.measure.max_z_per_line_mm = 50;
    write_text(folder_ / "rig.yaml", rig::to_yaml(rig_));
    rig_ = rig::load_rig((folder_ / "rig.yaml").string());
    points_ = points_of(rig_, plane_at(550));
  }

  Outcome run(const std::vector<std::string>& arguments) {
    return run_program(SELFPROJ_PROGRAM, arguments, folder_.path());
  }

  // The folder `scan` of Gray-code images of the plane.
  void scan() {
    fs::create_directory(folder_ / "scan");
    const structured_light::GraySequence sequence(rig_.projector.columns, rig_.projector.lines);
    for (int i = 0; i < sequence.count(); ++i) {
      write_picture(folder_ / fmt::format("scan/{:03}.png", i), points_, sequence.image(i), sequence.columns());
    }
  }

  // ... and the reference folder `ref` of it.
  void reference() {
    scan();
    const Outcome outcome =
        run({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--gray-code", "--out", "ref"});
    ASSERT_EQ(outcome.status, 0) << outcome.err;
  }

  // Expects status 2, one line on stderr that contains all of these texts, and nothing written.
  void refused(const std::vector<std::string>& arguments, const std::vector<std::string>& words) {
    expect_refusal(run(arguments), "", words);
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }

  // Writes images of planes, at each of these z in turn, under the patterns of a folder, and returns their names.
  std::vector<std::string> pictures(int count, const std::vector<double>& z, const std::string& patterns = "ref",
                                    const std::string& name = "image") {
    std::vector<std::string> names;
    for (int i = 0; i < count; ++i) {
      const cv::Mat pattern =
          cv::imread((folder_ / fmt::format("{}/pattern_{:02}.png", patterns, i % 8)).string(), cv::IMREAD_UNCHANGED);
      EXPECT_EQ(pattern.rows, rig_.projector.lines);
      names.push_back(fmt::format("{}_{}.png", name, i));
      write_picture(folder_ / names.back(), points_of(rig_, plane_at(z[static_cast<std::size_t>(i / 2) % z.size()])),
                    std::vector<std::uint8_t>(pattern.begin<std::uint8_t>(), pattern.end<std::uint8_t>()),
                    pattern.cols);
    }
    return names;
  }

  // The packets that a board sends of these images: moments of each, and the code images that it decodes, or the images
  // themselves. One line of the frame `without` is lost.
  [[nodiscard]] std::string packets(const std::vector<std::string>& names, bool codes,
                                    std::size_t without = SIZE_MAX) const {
    std::vector<std::uint8_t> bytes;
    model::PacketHeader header;
    header.rows = static_cast<std::uint16_t>(rig_.camera.rows);
    header.columns = static_cast<std::uint16_t>(rig_.camera.columns);
    model::GrayDecoder decoder({rig_.camera.rows, rig_.camera.columns, 4, rig_.measure.code_threshold});
    std::vector<std::uint16_t> words(rig_.camera.pixels());
    for (std::size_t i = 0; i < names.size(); ++i) {
      const cv::Mat image = cv::imread((folder_ / names[i]).string(), cv::IMREAD_UNCHANGED);
      header.sequence = i;
      header.kind = spec::kKindMoments;
      header.first_line = 0;
      header.lines = 0;
      model::append_packet(
          header, std::vector<std::uint8_t>(model::moments_payload_bytes(model::Mode::binary, image.cols)), 0, bytes);
      header.kind = codes ? spec::kKindCodes : spec::kKindImage;
      const bool due = decoder.add_frame({image.data, image.rows, image.cols, image.cols}, static_cast<int>(i % 8),
                                         true, words.data());
      for (int row = 0; row < image.rows && (due || !codes); ++row) {
        header.first_line = static_cast<std::uint16_t>(row + 1);
        header.lines = 1;
        std::vector<std::uint8_t> payload(codes ? model::codes_line_payload_bytes(image.cols)
                                                : model::image_line_payload_bytes(image.cols));
        if (codes) {
          model::pack_codes(image.cols, words.data() + row * image.cols, payload.data());
        } else {
          std::copy_n(image.ptr(row), image.cols, payload.begin());
        }
        if (i != without || row != 5) {
          model::append_packet(header, payload, 0, bytes);
        }
      }
    }
    return {bytes.begin(), bytes.end()};
  }

  ScratchFolder folder_;
  rig::Rig rig_;
  structured_light::ProjectorPoints points_;
};

TEST_F(MatchCommand, ReferenceOfAScanAndDepthOfImages) {
  reference();
  const structured_light::SelfReference found = structured_light::read_self_reference(rig_, (folder_ / "ref").string());
  EXPECT_EQ(found.stripes, (structured_light::Stripes{4, 2, structured_light::StripeCode::cyclic}));
  int compared = 0;
  for (std::size_t i = 0; i < found.points.line.values.size(); ++i) {
    if (found.measurable(i) && !std::isnan(points_.line.values[i])) {
      EXPECT_NEAR(found.points.line.values[i], points_.line.values[i], 0.6);
      ++compared;
    }
  }
  EXPECT_GT(compared, 2000);

  std::vector<std::string> arguments{"match", "--rig", "rig.yaml", "--reference", "ref", "--e", "4", "--out", "out"};
  for (const std::string& image : pictures(8, {530})) {
    arguments.push_back(image);
  }
  const Outcome outcome = run(arguments);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  const images::FloatImage difference = images::read_float_tiff((folder_ / "out/difference.tiff").string());
  double sum = 0;
  int count = 0;
  for (int r = 20; r < 44; ++r) {
    for (int c = 20; c < 44; ++c) {
      const float value = difference.row(r)[c];
      if (!std::isnan(value)) {
        sum += static_cast<double>(value);
        ++count;
      }
    }
  }
  ASSERT_GT(count, 300);
  EXPECT_NEAR(sum / count, 20, 5);  // one code of this coarse rig is 35 mm
}

// Codes and images that another process streams through the ring give the same depth images, byte for byte, and what
// is lost is counted.
TEST_F(MatchCommand, OnLineIsLikeOffLine) {
  reference();
  const std::vector<std::string> names = pictures(24, {530, 550, 515});
  const std::vector<std::string> match{"match", "--rig", "rig.yaml", "--reference", "ref", "--e", "4"};
  const auto with = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments = match;
    arguments.insert(arguments.end(), more.begin(), more.end());
    return arguments;
  };
  // The plane jumps so far between pairs that other pixels lie beside the projector's light.
  std::vector<std::string> offline = with({"--unchecked", "--out", "offline"});
  offline.insert(offline.end(), names.begin(), names.end());
  ASSERT_EQ(run(offline).status, 0);
  for (const bool codes : {true, false}) {
    SCOPED_TRACE(codes ? "codes" : "images");
    const std::string kind = codes ? "codes" : "images";
    write_text(folder_ / kind, packets(names, codes));
    const std::string ring = fmt::format("selfproj-match-test-{}-{}", kind, getpid());
    std::thread board([&] {
      const Outcome sent = run_program(
          SELFPROJ_SIM_PROGRAM, {"board", "--replay", kind, "--ring", ring, "--wait-for-reader", "--count", "24"},
          folder_.path());
      EXPECT_EQ(sent.status, 0) << sent.err;
    });
    const Outcome online = run(
        with({"--device", "ring:" + ring, "--wait-for-board", "--count", "9", "--save", "9", "--out", kind + ".out"}));
    board.join();
    ASSERT_EQ(online.status, 0) << online.err;
    EXPECT_EQ(online.out.rfind("9 depth images: ", 0), 0U) << online.out;
    for (int pair = 3; pair < 12; ++pair) {
      for (const char* map : {"depth", "difference"}) {
        const std::string file = fmt::format("{}_{:04}.tiff", map, pair);
        EXPECT_TRUE(read_text(folder_ / "offline" / file) == read_text(folder_ / (kind + ".out") / file)) << file;
      }
    }

    // A line in the middle is lost, and with it what it belongs to: a code image, or an image of the sequence.
    write_text(folder_ / "less", packets(names, codes, codes ? 11 : 10));
    const Outcome lost = run(with({"--device", "file:less", "--save", "9", "--out", kind + ".less"}));
    ASSERT_EQ(lost.status, 0) << lost.err;
    EXPECT_EQ(lost.out.rfind(codes ? "8 depth images: " : "3 depth images: ", 0), 0U) << lost.out;
    EXPECT_NE(lost.out.find("incomplete images 1;"), std::string::npos) << lost.out;
    EXPECT_FALSE(fs::exists(folder_ / (kind + ".less/depth_0005.tiff")));
    EXPECT_TRUE(read_text(folder_ / "offline/depth.tiff") == read_text(folder_ / (kind + ".less/depth.tiff")));
  }
  // A whole sequence of raw images is lost: the patterns go on as if nothing were, and no depth image has pairs of both
  // sides of the gap.
  std::string bytes = packets(names, false);
  const std::size_t frame = bytes.size() / names.size();
  bytes.erase(9 * frame, 8 * frame);
  write_text(folder_ / "gap", bytes);
  const Outcome outcome = run(with({"--device", "file:gap", "--save", "9", "--out", "gap.out"}));
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out.rfind("1 depth image: ", 0), 0U) << outcome.out;
  EXPECT_TRUE(fs::exists(folder_ / "gap.out/depth_0003.tiff"));
  // Images in another order: told at the end of the run, and refused by --check.
  const std::vector<std::string> still = pictures(8, {530}, "ref", "still");
  write_text(folder_ / "back", packets({still.rbegin(), still.rend()}, false));
  const Outcome back = run(with({"--device", "file:back", "--out", "back.out"}));
  EXPECT_EQ(back.status, 0) << back.err;
  EXPECT_NE(back.err.find("file:back: warning: the images are in another order"), std::string::npos) << back.err;
  const Outcome checked = run(with({"--device", "file:back", "--out", "back.out", "--check"}));
  EXPECT_EQ(checked.status, 1);
  EXPECT_NE(checked.err.find("--check: the images are in another order"), std::string::npos) << checked.err;
  refused(with({"--device", "file:codes", "--out", "out", "image_0.png"}), {"IMAGE: does not go with --device"});
  refused(with({"--save", "3", "--out", "out", "image_0.png"}), {"--save: goes only with --device"});
  write_text(folder_ / "few", packets({names.begin(), names.begin() + 6}, false));
  refused(with({"--device", "file:few", "--out", "out"}), {"file:few: delivered no complete code image"});
}

// Images under other patterns than those of the reference, mirrored ones and dark ones have no depth without a word.
TEST_F(MatchCommand, RefusesImagesOfOtherPatterns) {
  reference();
  ASSERT_EQ(run({"pattern", "gray", "--rig", "rig.yaml", "--bits", "4", "--out", "gray"}).status, 0);
  for (const char* name : {"good", "plain", "mirrored", "dark"}) {
    fs::create_directory(folder_ / name);
  }
  const std::vector<std::string> good = pictures(8, {530}, "ref", "good/image");
  const std::vector<std::string> plain = pictures(8, {530}, "gray", "plain/image");
  for (std::size_t i = 0; i < good.size(); ++i) {
    const cv::Mat image = cv::imread((folder_ / good[i]).string(), cv::IMREAD_UNCHANGED);
    cv::Mat mirrored;
    cv::flip(image, mirrored, 0);
    const std::string file = fmt::format("image_{}.png", i);
    ASSERT_TRUE(cv::imwrite((folder_ / "mirrored" / file).string(), mirrored));
    ASSERT_TRUE(cv::imwrite((folder_ / "dark" / file).string(), image / 100));
  }
  const auto match = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"match", "--rig", "rig.yaml", "--reference", "ref", "--e", "4", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments);
  };
  for (const auto& [folder, reason] : {std::pair("plain", "does not count on as the reference's stripes do"),
                                       {"mirrored", "does not count on as the reference's stripes do (-1."},
                                       {"dark", "no pixel has a code"}}) {
    SCOPED_TRACE(folder);
    const Outcome outcome = match({folder});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find(reason), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  }
  write_text(folder_ / "codes", packets(plain, true));
  const Outcome board = match({"--device", "file:codes"});
  EXPECT_EQ(board.status, 0) << board.err;
  EXPECT_NE(board.err.find("file:codes: warning: down the image the code does not count on"), std::string::npos)
      << board.err;
  EXPECT_EQ(match({"--device", "file:codes", "--check"}).status, 1);
  EXPECT_EQ(match({"--unchecked", "plain"}).status, 0);
  EXPECT_EQ(match({"good"}).err, "");
  // Stripes of another width.
  ASSERT_EQ(run({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--gray-code", "--rows-per-code", "4",
                 "--out", "wide"})
                .status,
            0);
  fs::create_directory(folder_ / "wider");
  pictures(8, {530}, "wide", "wider/image");
  EXPECT_NE(match({"wider"}).err.find("IMAGE: warning: down the image the code counts on 0.5"), std::string::npos);
}

TEST_F(MatchCommand, RefusesWrongScans) {
  scan();
  // Scans from which no right pattern can come
  const auto contradicts = [&](const std::string& folder, const std::string& text) {
    const std::vector<std::string> arguments{"pattern", "stripes",     "--rig", "rig.yaml", "--scan",
                                             folder,    "--gray-code", "--out", "out"};
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 1) << outcome.err;
    EXPECT_EQ(outcome.err.find("selfproj: " + folder + ": "), 0U) << outcome.err;
    EXPECT_NE(outcome.err.find(text), std::string::npos) << outcome.err;
    EXPECT_FALSE(fs::exists(folder_ / "out"));
  };
  const auto changed = [&](const std::string& folder, const std::function<cv::Mat(int, const cv::Mat&)>& change) {
    fs::create_directory(folder_ / folder);
    const int count = structured_light::GraySequence(rig_.projector.columns, rig_.projector.lines).count();
    for (int i = 0; i < count; ++i) {
      const std::string name = fmt::format("{:03}.png", i);
      const cv::Mat image = cv::imread((folder_ / "scan" / name).string(), cv::IMREAD_UNCHANGED);
      ASSERT_TRUE(cv::imwrite((folder_ / folder / name).string(), change(count - 1 - i, image)));
    }
  };
  changed("mirrored", [](int /*left*/, const cv::Mat& image) {
    cv::Mat other;
    cv::flip(image, other, 1);
    return other;
  });
  contradicts("mirrored", "belong to no common point");
  changed("negative_white", [](int left, const cv::Mat& image) { return left < 2 ? cv::Mat(160 - image) : image; });
  contradicts("negative_white", "no white and black picture");
  changed("dark", [](int left, const cv::Mat& image) {
    cv::Mat other = image.clone();
    other.colRange(3, image.cols).setTo(10);
    return left < 2 ? image : other;
  });
  contradicts("dark", "% of the projector's pixels on the reference");
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--out", "out"}, {"--scan", "--sweep"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--out", "out"}, {"scan", "images", "224"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "nowhere", "--out", "out"}, {"nowhere"});
  refused({"pattern", "stripes", "--rig", "light-section", "--scan", "scan", "--out", "out"}, {"kind scanner"});
  refused({"pattern", "stripes", "--rig", "scanner", "--scan", "scan", "--gray-code", "--out", "out"},
          {"scan", "images"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--bits", "9", "--out", "out"}, {"--bits"});
  refused({"pattern", "stripes", "--rig", "rig.yaml", "--scan", "scan", "--rows-per-code", "0", "--out", "out"},
          {"--rows-per-code"});
}

TEST_F(MatchCommand, RefusesWrongReferencesAndSettings) {
  reference();
  const std::vector<std::string> images(8, "scan/000.png");
  const auto with = [&](std::vector<std::string> arguments) {
    arguments.insert(arguments.end(), images.begin(), images.end());
    return arguments;
  };
  const auto match = [&](const std::vector<std::string>& more) {
    std::vector<std::string> arguments{"match", "--rig", "rig.yaml", "--reference", "ref", "--out", "out"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return with(arguments);
  };
  refused(match({"--e", "16"}), {"--e", "0 to 15"});
  refused(match({"--e", "-1"}), {"--e", "0 to 255"});
  refused(match({"--line-width", "0"}), {"--line-width"});
  refused({"match", "--rig", "rig.yaml", "--reference", "ref", "--out", "out", "scan/000.png"}, {"too few"});
  refused(with({"match", "--rig", "rig.yaml", "--reference", "nowhere", "--out", "out"}), {"nowhere"});
  refused(with({"match", "--rig", "rig.yaml", "--reference", "scan", "--out", "out"}), {"scan", "reference.yaml"});
  refused(with({"match", "--rig", "scanner", "--reference", "ref", "--out", "out"}), {"another rig", "camera.rows"});

  const std::string head = read_text(folder_ / "ref/reference.yaml");
  const auto damaged = [&](const std::string& text, const std::vector<std::string>& words) {
    write_text(folder_ / "ref/reference.yaml", text);
    refused(match({}), words);
    write_text(folder_ / "ref/reference.yaml", head);
  };
  damaged("", {"reference.yaml", "damaged"});
  damaged("{", {"reference.yaml", "line 1: end of map flow not found"});
  damaged(head.substr(0, 60), {"reference.yaml", "damaged"});
  damaged("selfproj_stripes: 2\n", {"version 2"});
  std::string other = head;
  other.replace(other.find("bits: 4"), 7, "bits: 9");
  damaged(other, {"reference.yaml", "bits"});

  for (const char* name : {"x_r_line.tiff", "f_r_row.tiff", "f_r_seen.png"}) {
    fs::rename(folder_ / ("ref/" + std::string(name)), folder_ / "kept");
    refused(match({}), {name});
    write_text(folder_ / ("ref/" + std::string(name)), "no image");
    refused(match({}), {name});
    fs::remove(folder_ / ("ref/" + std::string(name)));
    fs::rename(folder_ / "kept", folder_ / ("ref/" + std::string(name)));
  }
  images::write_float_tiff((folder_ / "ref/x_r_line.tiff").string(), images::FloatImage(3, 5));
  refused(match({}), {"x_r_line.tiff", "5 x 3"});
}

TEST_F(MatchCommand, AccuracyShowsPublishedAndDerivedFigures) {
  const Outcome outcome = run({"accuracy", "--out", "map"});
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  for (const char* text : {"1.79", "1.50", "0.72", "1.59", "496.72", "461.29", "457.88", "141.66"}) {
    EXPECT_NE(outcome.out.find(text), std::string::npos) << text;
  }
  const std::string map = read_text(folder_ / "map/error_map.csv");
  EXPECT_EQ(std::count(map.begin(), map.end(), '\n'), 1 + 3 * 16 * 16);
  refused({"accuracy", "--e", "16", "--out", "out"}, {"--e"});
  refused({"accuracy", "--rig", "light-section", "--out", "out"}, {"kind scanner"});
}

}  // namespace
}  // namespace selfproj::test
