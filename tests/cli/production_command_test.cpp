// Tests the simulated production line from the command line: what `selfproj-sim production` plants is what `selfproj`
// finds, in packets, with a camera and with structured light.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "host/images/frame_options.h"
#include "selfproj/images/float_image.h"
#include "selfproj/rig/calibration.h"
#include "selfproj/rig/rig.h"
#include "tests/cli/program.h"

namespace selfproj::test {
namespace {

using Words = std::vector<std::string>;

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields;
  std::istringstream stream(line);
  for (std::string field; std::getline(stream, field, ',');) {
    fields.push_back(field);
  }
  return fields;
}

class ProductionCommand : public ::testing::Test {
 protected:
  Outcome sim(const Words& words) { return run_program(SELFPROJ_SIM_PROGRAM, words, folder_.path()); }
  Outcome host(const Words& words) { return run_program(SELFPROJ_PROGRAM, words, folder_.path()); }
  static Words with(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }

  // Learns the tolerance of the line's good parts, tolerance.yaml.
  Outcome learn(const Words& of) {
    return host(with({"tolerance", "learn", "--device", "file:line/good.packets", "--out", "tolerance.yaml"}, of));
  }
  // That, and the table of verdicts for it, verdict.yaml.
  Outcome learn_and_make_table(const Words& of) {
    if (Outcome learned = learn(of); learned.status != 0) {
      return learned;
    }
    return host(
        with({"verdict", "table", "--tolerance", "tolerance.yaml", "--defect", "2x2", "--out", "verdict.yaml"}, of));
  }

  // Compares the results in the folder `parts` with the truth in `line`, and returns how many parts were bad. Defects
  // are searched for within `near` mm; their depths may be off by `off` mm.
  int agrees(const std::string& line, const std::string& parts, double near, double off) {
    std::istringstream truth(read_text(folder_ / (line + "/run.csv")));
    std::istringstream results(read_text(folder_ / (parts + "/parts.jsonl")));
    int bad = 0;
    std::string row;
    std::getline(truth, row);
    EXPECT_EQ(row, "part,verdict,along_mm,across_mm,size_mm,depth_mm");
    for (std::string result; std::getline(truth, row);) {
      if (!std::getline(results, result)) {
        ADD_FAILURE() << "no result of " << row;
        return bad;
      }
      const std::vector<std::string> fields = fields_of(row);
      const auto part = nlohmann::json::parse(result);
      EXPECT_EQ(std::to_string(part.at("part").get<int>()), fields.at(0));
      EXPECT_EQ(part.at("verdict"), fields.at(1)) << result;
      if (fields.at(1) != "bad") {
        continue;
      }
      ++bad;
      bool found = false;
      for (const auto& defect : part.at("defects")) {
        found = found || (std::abs(defect.at("along_mm").get<double>() - std::stod(fields.at(2))) < near &&
                          std::abs(defect.at("across_mm").get<double>() - std::stod(fields.at(3))) < near &&
                          std::abs(defect.at("depth_mm").get<double>() - std::stod(fields.at(5))) < off);
      }
      EXPECT_TRUE(found) << row << "\n" << result;
    }
    EXPECT_FALSE(std::getline(results, row)) << row;
    return bad;
  }

  ScratchFolder folder_;
};

TEST_F(ProductionCommand, FindsWhatItPlants) {
  const Outcome made = sim(
      {"production", "--good", "5", "--parts", "4", "--bad-every", "2", "--seed", "5", "--out", "line", "--images"});
  ASSERT_EQ(made.status, 0) << made.err;
  EXPECT_EQ(made.out, "5 good parts, then 4 of which 2 are bad → line\n");
  const Words rig = {"--rig", "line/rig.yaml", "--reference", "line/part"};
  const Outcome learned = host(
      with({"tolerance", "learn", "--device", "file:line/good.packets", "--strict", "--out", "tolerance.yaml"}, rig));
  ASSERT_EQ(learned.status, 0) << learned.err;
  const Outcome run = host(with({"inspect", "--device", "file:line/run.packets", "--check", "--tolerance",
                                 "tolerance.yaml", "--parts", "today", "--out", "today-out"},
                                rig));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(agrees("line", "today", 1, 0.05), 2);
  const std::string page = read_text(folder_ / "today-out/report.html");
  for (const char* const text : {"nine tenths of the parts", "bad parts", "<h2>The parts</h2>", "its depth, mm"}) {
    EXPECT_NE(page.find(text), std::string::npos) << text;
  }

  EXPECT_TRUE(std::filesystem::exists(folder_ / "line/good/frame_00640.png"));
  EXPECT_FALSE(std::filesystem::exists(folder_ / "line/good/frame_00641.png"));

  // The reference beside a recording is the default, and no other goes with it.
  const Outcome beside = host({"inspect", "--device", "file:line/run.packets", "--rig", "line/rig.yaml", "--check",
                               "--tolerance", "tolerance.yaml", "--parts", "beside"});
  ASSERT_EQ(beside.status, 0) << beside.err;
  EXPECT_EQ(read_text(folder_ / "beside/parts.jsonl"), read_text(folder_ / "today/parts.jsonl"));
  write_text(folder_ / "flat.csv", "y_mm,z_mm\n-55,1150\n55,1150\n");
  ASSERT_EQ(host({"pattern", "--rig", "line/rig.yaml", "--reference", "flat.csv", "--out", "flat"}).status, 0);
  const Words wrong = {"inspect", "--device", "file:line/run.packets", "--rig", "line/rig.yaml", "--reference", "flat"};
  EXPECT_EQ(host(wrong).err,
            "selfproj: --reference flat: is not the one under which file:line/run.packets was taken, which is "
            "line/run.packets.reference.csv\n");
  ASSERT_EQ(host({"record", "--device", "file:line/run.packets", "--reference", "line/part", "--out", "copy"}).status,
            0);
  EXPECT_EQ(read_text(folder_ / "copy.reference.csv"), read_text(folder_ / "line/run.packets.reference.csv"));
  EXPECT_EQ(host({"record", "--device", "file:line/run.packets", "--out", "copy"}).status, 2);

  // The same again, byte for byte; another seed is another line.
  ASSERT_EQ(
      sim({"production", "--good", "1", "--parts", "2", "--bad-every", "2", "--seed", "5", "--out", "again"}).status,
      0);
  const std::string all = read_text(folder_ / "line/run.packets");
  EXPECT_EQ(read_text(folder_ / "again/run.packets"), all.substr(0, all.size() / 2));

  // Images give what packets give, byte for byte.
  const Outcome of_images = host(with({"tolerance", "learn", "--images", "line/good", "--out", "of-images.yaml"}, rig));
  ASSERT_EQ(of_images.status, 0) << of_images.err;
  EXPECT_EQ(read_text(folder_ / "of-images.yaml"), read_text(folder_ / "tolerance.yaml"));
  const Outcome seen = host(with({"inspect", "--images", "line/run/*.png", "--check", "--tolerance", "tolerance.yaml",
                                  "--parts", "seen", "--out", "seen-out"},
                                 rig));
  ASSERT_EQ(seen.status, 0) << seen.err;
  EXPECT_EQ(seen.out.rfind("512 profiles, points in ", 0), 0U) << seen.out;
  EXPECT_EQ(seen.err.find("numbers are missing"), std::string::npos) << seen.err;
  const std::string frame = "line/run/frame_0000";
  EXPECT_NE(host(with({"inspect", "--images", frame + "1.png", frame + "2.png", frame + "4.png"}, rig))
                .err.find("numbers are missing between line/run/frame_00002.png and line/run/frame_00004.png"),
            std::string::npos);
  for (const std::string file : {"parts.jsonl", "part_000002/height.tiff"}) {
    EXPECT_EQ(read_text(folder_ / ("seen/" + file)), read_text(folder_ / ("today/" + file))) << file;
  }
  for (const std::string file : {"moments.csv", "profile.csv", "cloud.ply", "height.tiff", "difference.tiff"}) {
    EXPECT_EQ(read_text(folder_ / ("seen-out/" + file)), read_text(folder_ / ("today-out/" + file))) << file;
  }
  EXPECT_NE(host({"inspect", "--images", "line/run/frame_00001.png", "--rig", "line/rig.yaml", "--roi", "64x96+0+0"})
                .err.find("line/run/frame_00001.png: is 64 x 96, but the camera of the rig 512 x 96"),
            std::string::npos);
  EXPECT_NE(host({"inspect", "--images", "line/run", "--device", "ring:x"}).err.find("--device"), std::string::npos);
  EXPECT_NE(host({"inspect"}).err.find("--device, --images: one of them is required"), std::string::npos);
}

// A reason in words where columns give no points, or parts no verdict.
TEST_F(ProductionCommand, SaysWhyThereIsNoPoint) {
  ASSERT_EQ(sim({"production", "--good", "5", "--parts", "1", "--bad-every", "0", "--out", "line"}).status, 0);
  ASSERT_EQ(host({"tolerance", "learn", "--rig", "line/rig.yaml", "--reference", "line/part", "--device",
                  "file:line/good.packets", "--out", "tolerance.yaml"})
                .status,
            0);
  const auto change = [&](const std::string& file, const std::string& from, const std::string& to,
                          const std::string& as) {
    std::string text = read_text(folder_ / file);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    text.replace(at, text.find('\n', at) - at, to);
    write_text(folder_ / as, text);
  };
  const auto inspect = [&](const std::string& rig, const Words& more) {
    return host(with({"inspect", "--rig", rig, "--reference", "line/part", "--device", "file:line/run.packets"}, more));
  };
  change("line/rig.yaml", "min_lit_px: ", "min_lit_px: 20", "thin.yaml");
  const Outcome thin = inspect("thin.yaml", {"--out", "thin"});
  EXPECT_EQ(thin.status, 0) << thin.err;
  const std::string reason = "have fewer than 20 lit pixels: raise the exposure, or lower the threshold or min_lit_px";
  EXPECT_NE(thin.err.find(reason), std::string::npos) << thin.err;
  EXPECT_NE(read_text(folder_ / "thin/summary.json").find(reason), std::string::npos);
  EXPECT_NE(read_text(folder_ / "thin/report.html").find(reason), std::string::npos);
  const Outcome checked = inspect("thin.yaml", {"--check"});
  EXPECT_EQ(checked.status, 1);
  EXPECT_NE(checked.err.find("--check: none of the 65536 columns became a point: "), std::string::npos) << checked.err;

  change("line/rig.yaml", "above_mm: ", "above_mm: 500", "high.yaml");
  const Outcome high = inspect("high.yaml", {"--tolerance", "tolerance.yaml", "--check"});
  EXPECT_EQ(high.status, 1);
  EXPECT_NE(high.err.find("no part was cut: nothing was higher than above_mm (500 mm)"), std::string::npos) << high.err;

  change("tolerance.yaml", "max_residual_mm: ", "max_residual_mm: 0.001", "strict.yaml");
  const Outcome strict = inspect("line/rig.yaml", {"--tolerance", "strict.yaml", "--check"});
  EXPECT_EQ(strict.status, 1);
  EXPECT_NE(strict.err.find("1 of 1 parts has no verdict; the last: "), std::string::npos) << strict.err;
}

// Rigs with a laser, or with lenses, have a line as well: the defect of a bad part is where run.csv says.
TEST_F(ProductionCommand, TakesLasersAndLenses) {
  const rig::Rig drawn = rig::load_rig("light-section");
  rig::Calibration calibration = rig::calibration_of(drawn);
  calibration.camera.k[0] = 0.05;
  rig::Rig lenses = rig::rig_of(calibration, drawn);
  lenses.sources = rig::RigSources{};  // the simulation knows its rig
  write_text(folder_ / "lenses.yaml", rig::to_yaml(lenses));
  for (const std::string rig : {"laser", "lenses.yaml"}) {
    SCOPED_TRACE(rig);
    const std::string line = "line-of-" + rig;
    const Outcome made = sim(
        {"production", "--rig", rig, "--good", "1", "--parts", "1", "--bad-every", "1", "--seed", "4", "--out", line});
    ASSERT_EQ(made.status, 0) << made.err;
    EXPECT_EQ(std::filesystem::exists(folder_ / (line + "/run.packets.reference.csv")), rig != "laser");
    const Outcome run = host({"inspect", "--rig", line + "/rig.yaml", "--reference", line + "/part", "--device",
                              "file:" + line + "/run.packets", "--check", "--out", line + "-out"});
    ASSERT_EQ(run.status, 0) << run.err;
    std::istringstream truth(read_text(folder_ / (line + "/run.csv")));
    std::string row;
    std::getline(truth, row);
    std::getline(truth, row);
    const std::vector<std::string> fields = fields_of(row);
    ASSERT_EQ(fields.at(1), "bad");
    const double across = std::stod(fields.at(3));
    const double depth = std::stod(fields.at(5));
    // Differences where the profile says that the defect is, across the belt.
    std::istringstream profile(read_text(folder_ / (line + "-out/profile.csv")));
    std::getline(profile, row);
    const std::vector<std::string> keys = fields_of(row);
    const auto key = [&](const std::string& name) {
      return static_cast<std::size_t>(std::find(keys.begin(), keys.end(), name) - keys.begin());
    };
    const std::size_t y = key("y");
    const std::size_t deeper = key("dz");
    ASSERT_LT(std::max(y, deeper), keys.size()) << row;
    int there = 0;
    while (std::getline(profile, row)) {
      const std::vector<std::string> point = fields_of(row);
      if (point.size() == keys.size() && std::abs(std::stod(point[y]) - across) < std::stod(fields.at(4)) / 4 &&
          std::abs(-std::stod(point[deeper]) - depth) < 0.1) {
        ++there;
      }
    }
    EXPECT_GT(there, 20);
  }
}

// A rig that sends a region of its sensor: images of the region and of the whole sensor give the same heights.
TEST_F(ProductionCommand, ImagesOfARegionAreMeasured) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.region = rig::RigRegion{.row_offset = 30,
                                     .rows = 40,
                                     .column_offset = 64,
                                     .columns = 400,
                                     .frame_rate_hz = rig.camera.frame_rate_hz,
                                     .exposure_s = rig.camera.exposure_s};
  write_text(folder_ / "few.yaml", rig::to_yaml(rig));
  const Words quiet = {"scene", "render", "plane", "--count", "1", "--without", "shot-noise,read-noise"};
  ASSERT_EQ(sim(with(quiet, {"--out", "whole"})).status, 0);
  ASSERT_EQ(sim(with(quiet, {"--region-of", "few.yaml", "--out", "part"})).status, 0);
  for (const std::string images : {"whole", "part"}) {
    const Outcome run =
        host({"inspect", "--rig", "few.yaml", "--images", images + "/frame_00001.png", "--out", images + "-out"});
    ASSERT_EQ(run.status, 0) << run.err;
  }
  for (const std::string file : {"moments.csv", "profile.csv", "height.tiff"}) {
    EXPECT_EQ(read_text(folder_ / ("part-out/" + file)), read_text(folder_ / ("whole-out/" + file))) << file;
  }
  const Outcome wrong =
      host({"inspect", "--rig", "few.yaml", "--images", "part/frame_00001.png", "--roi", "64x40+0+0"});
  EXPECT_NE(wrong.err.find("but the camera of the rig 512 x 96, and its region 400 x 40"), std::string::npos)
      << wrong.err;
}

// A dim line in images of 8 and of 12 bits, without noise: what the moments of more bits give is finer, and the
// commands say what does not go with them.
TEST_F(ProductionCommand, ImagesOfTwelveBits) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.imaging.white = 24;
  rig.imaging.ambient = 2;
  rig.imaging.dark = 2;
  rig.measure.threshold = 3;
  write_text(folder_ / "eight.yaml", rig::to_yaml(rig));
  rig.measure.pixel_bits = 12;
  rig.measure.threshold *= 16;
  write_text(folder_ / "twelve.yaml", rig::to_yaml(rig));
  std::map<std::string, double> rms;
  for (const std::string bits : {"eight", "twelve"}) {
    ASSERT_EQ(sim({"scene", "render", "mountain", "--first", "300", "--count", "1", "--without",
                   "shot-noise,read-noise", "--rig", bits + ".yaml", "--truth", bits + ".tiff", "--out", bits})
                  .status,
              0);
    const Outcome run =
        host({"inspect", "--rig", bits + ".yaml", "--images", bits + "/frame_00300.png", "--out", bits + "-out"});
    ASSERT_EQ(run.status, 0) << run.err;
    const auto summary = nlohmann::json::parse(read_text(folder_ / (bits + "-out/summary.json")));
    EXPECT_EQ(summary.value("pixel_bits", 8), bits == "eight" ? 8 : 12);
    const images::FloatImage truth = images::read_float_tiff(folder_ / (bits + ".tiff"));
    const images::FloatImage height = images::read_float_tiff(folder_ / (bits + "-out/height.tiff"));
    ASSERT_EQ(truth.values.size(), height.values.size());
    double squares = 0;
    int count = 0;
    for (std::size_t i = 0; i < truth.values.size(); ++i) {
      if (const double off = height.values[i] - truth.values[i]; !std::isnan(off)) {
        squares += off * off;
        ++count;
      }
    }
    ASSERT_GT(count, 300);
    rms[bits] = std::sqrt(squares / count);
  }
  EXPECT_LT(rms["twelve"], 0.4 * rms["eight"]);
  const auto refused = [&](const Words& words) { return host(words).err; };
  EXPECT_NE(refused({"inspect", "--rig", "eight.yaml", "--images", "twelve/frame_00300.png"}).find("--shift 4"),
            std::string::npos);
  EXPECT_NE(refused({"inspect", "--rig", "twelve.yaml", "--images", "eight/frame_00300.png"})
                .find("has values up to 255; pixels of 12 bits are expected, up to 4095"),
            std::string::npos);
  // The same region, and 16 times the threshold, up to its rounding.
  const auto few = [&](const std::string& bits) {
    EXPECT_EQ(host({"rows", "--rig", bits + ".yaml", "--rows", "24", "--out", "few-" + bits + ".yaml"}).status, 0);
    return rig::load_any_rig((folder_ / ("few-" + bits + ".yaml")).string());
  };
  const rig::Rig few_eight = few("eight");
  const rig::Rig few_twelve = few("twelve");
  EXPECT_EQ(few_twelve.camera.region->row_offset, few_eight.camera.region->row_offset);
  EXPECT_NEAR(few_twelve.measure.threshold, 16 * few_eight.measure.threshold, 16);
  // One run in each column: the strongest run is all there is.
  ASSERT_EQ(host({"inspect", "--rig", "twelve.yaml", "--images", "twelve/frame_00300.png", "--select", "strongest",
                  "--out", "strongest-out"})
                .status,
            0);
  const std::vector<float> strongest = images::read_float_tiff(folder_ / "strongest-out/height.tiff").values;
  const std::vector<float> all = images::read_float_tiff(folder_ / "twelve-out/height.tiff").values;
  EXPECT_TRUE(
      std::ranges::equal(strongest, all, [](float a, float b) { return a == b || (std::isnan(a) && std::isnan(b)); }));
  // The same image, recorded, through the Verilated board and the model, and played by the simulated board: the packets
  // that the board of a laboratory would send.
  for (const std::string engine : {"rtl", "model"}) {
    const Outcome run = sim({"cosim", "--frames", "twelve/frame_00300.png", "--rig", "twelve.yaml", "--engine", engine,
                             "--packets", engine + ".slfp", "--select", "strongest"});
    ASSERT_EQ(run.status, 0) << run.err;
    EXPECT_NE(run.out.find("512 columns in 1 frames, 0 mismatches"), std::string::npos) << run.out;
  }
  EXPECT_EQ(read_text(folder_ / "rtl.slfp"), read_text(folder_ / "model.slfp"));
  ASSERT_EQ(
      sim({"board", "--images", "twelve/frame_00300.png", "--rig", "twelve.yaml", "--record", "played.slfp"}).status,
      0);
  ASSERT_EQ(host({"inspect", "--rig", "twelve.yaml", "--device", "file:played.slfp", "--out", "played-out"}).status, 0);
  EXPECT_EQ(read_text(folder_ / "played-out/height.tiff"), read_text(folder_ / "twelve-out/height.tiff"));
  const auto no_board = [&](const Words& words) { return sim(words).err; };
  EXPECT_NE(no_board({"cosim", "--rig", "twelve.yaml", "--engine", "hls"}).find("--engine rtl and model"),
            std::string::npos);
  EXPECT_NE(no_board({"cosim", "--threshold", "256"}).find("pixels of 8 bits are 255 at most"), std::string::npos);
  EXPECT_NE(no_board({"board", "--images", "twelve/frame_00300.png", "--rig", "twelve.yaml", "--bits", "2", "--record",
                      "none.slfp"})
                .find("--bits takes pixels of 8 bits"),
            std::string::npos);
}

// Scenes of 10 and 12 bits under the simulated camera: exact and divided columns, the strongest run, and a bus that
// stalls.
TEST_F(ProductionCommand, CosimulationOfMoreBits) {
  rig::Rig rig = rig::load_rig("light-section");
  for (const int bits : {10, 12}) {
    rig.measure.pixel_bits = bits;
    rig.measure.threshold = 20 << (bits - 8);
    write_text(folder_ / "wide.yaml", rig::to_yaml(rig));
    for (const Words& words : std::vector<Words>{{"--mode", "binary"}, {"--compact"}, {"--select", "strongest"}}) {
      Words all = {"cosim", "--scene", "stairs-marked", "--first",     "700", "--count",
                   "3",     "--rig",   "wide.yaml",     "--bus-stall", "40"};
      all.insert(all.end(), words.begin(), words.end());
      const Outcome run = sim(all);
      EXPECT_EQ(run.status, 0) << run.err;
      EXPECT_NE(run.out.find("1536 columns in 3 frames, 0 mismatches"), std::string::npos) << run.out;
    }
  }
  rig.measure.pixel_bits = 11;
  write_text(folder_ / "wide.yaml", rig::to_yaml(rig));
  EXPECT_NE(sim({"cosim", "--rig", "wide.yaml"}).err.find("the Verilated boards 8, 10 and 12"), std::string::npos);
  rig.camera.rows = 1500;
  rig.measure.pixel_bits = 10;
  write_text(folder_ / "wide.yaml", rig::to_yaml(rig));
  EXPECT_NE(
      sim({"cosim", "--rig", "wide.yaml"})
          .err.find("--rig wide.yaml: its camera sends 512 x 1500; the boards of co-simulation take up to 2048 x 1023"),
      std::string::npos);
}

// The sweep of a part in images of 12 bits: its pattern, without its residual; and plates at known heights.
TEST_F(ProductionCommand, SweepsOfTwelveBits) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.pixel_bits = 12;
  rig.measure.threshold *= rig.measure.values_per_grey();
  write_text(folder_ / "twelve.yaml", rig::to_yaml(rig));
  const Words of = {"--rig", "twelve.yaml"};
  ASSERT_EQ(host(with({"pattern", "--sweep", "--every", "8", "--out", "lines"}, of)).status, 0);
  ASSERT_EQ(
      sim(with({"capture", "--patterns", "lines", "--scene", "stairs", "--stopped", "--out", "swept"}, of)).status, 0);
  const Outcome scanned = host(with({"pattern", "--scan", "swept", "--every", "8", "--out", "part"}, of));
  ASSERT_EQ(scanned.status, 0) << scanned.err;
  ASSERT_EQ(sim(with({"scene", "render", "stairs", "--pattern", "part/pattern.tiff", "--first", "180", "--count", "8",
                      "--out", "good"},
                     of))
                .status,
            0);
  const Outcome taken = host(with({"pattern", "--reference", "part", "--residual", "good", "--out", "exact"}, of));
  ASSERT_EQ(taken.status, 0) << taken.err;
  const Outcome inspected =
      host(with({"inspect", "--reference", "exact", "--images", "good/frame_00183.png", "--out", "found"}, of));
  ASSERT_EQ(inspected.status, 0) << inspected.err;
  std::vector<float> off = images::read_float_tiff(folder_ / "found/difference.tiff").values;
  std::erase_if(off, [](float value) { return std::isnan(value); });
  ASSERT_GT(off.size(), 300U);
  std::ranges::sort(off);
  EXPECT_LT(std::max(std::abs(off[off.size() / 20]), std::abs(off[19 * off.size() / 20])), 0.05);  // mm

  for (const std::string height : {"0", "10", "20"}) {
    ASSERT_EQ(sim(with({"capture", "--patterns", "lines", "--plate", height, "--out", "at" + height}, of)).status, 0);
  }
  const Outcome fitted = host(with(
      {"calibrate", "heights", "--every", "8", "--heights", "0,10,20", "--out", "fitted", "at0", "at10", "at20"}, of));
  ASSERT_EQ(fitted.status, 0) << fitted.err;
  const Outcome checked = host({"calibrate", "heights", "--rig", "fitted/rig.yaml", "--assume", "camera,light,belt",
                                "--every", "8", "--heights", "10", "--check", "at10"});
  EXPECT_EQ(checked.status, 0) << checked.err;

  // Images of other bits are no images of this rig.
  rig.measure = rig::load_rig("light-section").measure;
  write_text(folder_ / "eight.yaml", rig::to_yaml(rig));
  ASSERT_EQ(sim({"capture", "--rig", "eight.yaml", "--patterns", "lines", "--plate", "0", "--out", "eight"}).status, 0);
  EXPECT_NE(host(with({"pattern", "--scan", "eight", "--every", "8", "--out", "no"}, of))
                .err.find("pixels of 12 bits are expected"),
            std::string::npos);
  EXPECT_NE(host({"pattern", "--rig", "eight.yaml", "--scan", "swept", "--every", "8", "--out", "no"})
                .err.find("--shift 4 takes values of 12 bits"),
            std::string::npos);
  EXPECT_NE(sim(with({"capture", "--patterns", "lines", "--chessboard", "9x7", "--square", "21", "--out", "no"}, of))
                .err.find("twelve.yaml: measure.pixel_bits is 12; --chessboard takes pixels of 8 bits"),
            std::string::npos);
}

// From whole images to few rows at their rate and light, and to verdicts by heights and by moments: docs/few-rows.md.
TEST_F(ProductionCommand, FewRowsAreJudged) {
  ASSERT_EQ(sim({"production", "--good", "1", "--parts", "1", "--out", "whole"}).status, 0);
  const Outcome rows = host({"rows", "--rig", "whole/rig.yaml", "--reference", "whole/part", "--rows", "24", "--rate",
                             "40000", "--out", "fast.yaml"});
  ASSERT_EQ(rows.status, 0) << rows.err;
  const Outcome made = sim({"production", "--rig", "fast.yaml", "--rate", "40000", "--good", "5", "--parts", "4",
                            "--bad-every", "2", "--seed", "8", "--out", "line"});
  ASSERT_EQ(made.status, 0) << made.err;
  const rig::Rig rig = rig::load_rig((folder_ / "line/rig.yaml").string());
  EXPECT_EQ(rig.camera.sent().rows, 24);
  EXPECT_EQ(rig.camera.sent().frame_rate_hz, 40000);
  EXPECT_LT(rig.camera.sent().exposure_s, 0.3 * rig.camera.exposure_s);

  const Words of = {"--rig", "line/rig.yaml", "--reference", "line/part"};
  const Outcome table = learn_and_make_table(of);
  ASSERT_EQ(table.status, 0) << table.err;
  const Outcome run = host(with({"inspect", "--device", "file:line/run.packets", "--tolerance", "tolerance.yaml",
                                 "--verdict", "verdict.yaml", "--verdict-placed", "--parts", "judged"},
                                of));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(agrees("line", "judged", 1, 0.1), 2);
  EXPECT_NE(run.out.find("by moments 2 of 4 parts have a defect"), std::string::npos) << run.out;
  EXPECT_NE(run.out.find("as by heights 4, more 0, less 0"), std::string::npos) << run.out;
}

// The same line in pixels of 8 and of 12 bits, in exact and in compact columns: one path, the same verdicts.
TEST_F(ProductionCommand, PartsOfTwelveBitsAreJudged) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.pixel_bits = 12;
  rig.measure.threshold *= rig.measure.values_per_grey();
  write_text(folder_ / "twelve.yaml", rig::to_yaml(rig));
  ASSERT_EQ(sim({"production", "--rig", "twelve.yaml", "--parts", "4", "--bad-every", "2", "--seed", "12", "--images",
                 "--out", "line"})
                .status,
            0);
  const Words of = {"--rig", "line/rig.yaml", "--reference", "line/part"};
  const Outcome table = learn_and_make_table(of);
  ASSERT_EQ(table.status, 0) << table.err;
  EXPECT_EQ(table.err, "");  // noise makes no defects
  const Outcome run = host(with({"inspect", "--device", "file:line/run.packets", "--tolerance", "tolerance.yaml",
                                 "--verdict", "verdict.yaml", "--check", "--parts", "judged"},
                                of));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(agrees("line", "judged", 1, 0.1), 2);
  EXPECT_NE(run.out.find("as by heights 4, more 0, less 0"), std::string::npos) << run.out;
  const Outcome images = host(with({"inspect", "--images", "line/run/frame_*.png", "--tolerance", "tolerance.yaml",
                                    "--check", "--parts", "of-images"},
                                   of));
  ASSERT_EQ(images.status, 0) << images.err;
  EXPECT_EQ(agrees("line", "of-images", 1, 0.1), 2);

  rig.measure.compact = true;
  write_text(folder_ / "compact.yaml", rig::to_yaml(rig));
  ASSERT_EQ(sim({"production", "--rig", "compact.yaml", "--parts", "4", "--bad-every", "2", "--seed", "12", "--out",
                 "compact"})
                .status,
            0);
  EXPECT_LT(std::filesystem::file_size(folder_ / "compact/run.packets"),
            0.6 * static_cast<double>(std::filesystem::file_size(folder_ / "line/run.packets")));
  const Outcome compact =
      host({"inspect", "--rig", "compact/rig.yaml", "--reference", "compact/part", "--device",
            "file:compact/run.packets", "--tolerance", "tolerance.yaml", "--check", "--parts", "of-compact"});
  ASSERT_EQ(compact.status, 0) << compact.err;
  EXPECT_EQ(agrees("compact", "of-compact", 1, 0.1), 2);
}

// The rig that `production` writes is one for its own parts, also where a laser's columns are wide.
TEST_F(ProductionCommand, ALaserLineLearnsAndJudges) {
  ASSERT_EQ(
      sim({"production", "--rig", "laser", "--good", "5", "--parts", "2", "--bad-every", "2", "--out", "line"}).status,
      0);
  const Words of = {"--rig", "line/rig.yaml", "--reference", "line/part"};
  const Outcome learned = learn(of);
  ASSERT_EQ(learned.status, 0) << learned.err;
  const Outcome run = host(
      with({"inspect", "--device", "file:line/run.packets", "--tolerance", "tolerance.yaml", "--parts", "judged"}, of));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(agrees("line", "judged", 1, 0.1), 1);

  // What the parts are compared with is not theirs: the empty belt has no treads. With --check nothing is written.
  const Words of_the_belt = {"tolerance", "learn", "--device", "file:line/good.packets", "--rig", "line/rig.yaml"};
  std::filesystem::remove(folder_ / "line/good.reference.csv");
  const Outcome told = host(with(of_the_belt, {"--out", "belt.yaml"}));
  EXPECT_EQ(told.status, 0);
  EXPECT_NE(told.err.find("is the reference (--reference) that of these parts?"), std::string::npos) << told.err;
  const Outcome refused = host(with(of_the_belt, {"--check", "--out", "checked.yaml"}));
  EXPECT_EQ(refused.status, 1);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "checked.yaml"));

  // A verdict by moments counts along the belt by its encoder, and where no part begins, that is told.
  ASSERT_EQ(host(with({"verdict", "table", "--tolerance", "tolerance.yaml", "--start", "8000000", "--pitch", "4000000",
                       "--out", "verdict.yaml"},
                      of))
                .status,
            0);
  Words by_moments = {"inspect",        "--device",  "file:line/run.packets", "--tolerance",
                      "tolerance.yaml", "--verdict", "verdict.yaml",          "--check",
                      "--parts",        "by-moments"};
  const Outcome none = host(with(by_moments, of));
  EXPECT_EQ(none.status, 1);
  EXPECT_NE(none.err.find("by moments 0 parts came, by heights 2"), std::string::npos) << none.err;
  rig::Rig by_clock = rig::load_any_rig((folder_ / "line/rig.yaml").string());
  by_clock.parts->by_encoder = false;
  write_text(folder_ / "clock.yaml", rig::to_yaml(by_clock));
  by_moments.back() = "by-clock";
  const Outcome clock = host(with(by_moments, {"--rig", "clock.yaml", "--reference", "line/part"}));
  EXPECT_EQ(clock.status, 2);
  EXPECT_NE(clock.err.find("says belt: clock"), std::string::npos) << clock.err;
}

// Every command that gives millimetres refuses them from a value that was never measured, of either kind of rig, unless
// it is told to take it.
TEST_F(ProductionCommand, NothingThatWasNeverMeasuredGivesMillimetres) {
  for (const std::string kind : {"laser", "light-section"}) {
    ASSERT_EQ(sim({"scene", "render", "plane", "--rig", kind, "--count", "1", "--out", kind}).status, 0);
    std::vector<std::pair<std::string, Words>> commands = {
        {"belt,encoder", {"inspect", "--images", kind}},
        {"belt,encoder", {"inspect", "--device", "file:nothing.packets"}},
        {"belt,encoder", {"tolerance", "learn", "--images", kind, "--out", "tolerance.yaml"}},
        {"belt,encoder", {"rows"}},
        {"belt", {"calibrate", "heights", "--heights", "0", "--every", "4", "--check", kind}}};
    if (kind == "laser") {
      commands.push_back({"belt", {"pattern", "--residual", kind, "--out", "reference"}});
    }
    using rig::ValueSource;
    rig::Rig rig = rig::load_any_rig(kind);
    rig.sources = rig::RigSources{.camera = ValueSource::measured, .light = ValueSource::measured};
    write_text(folder_ / "begun.yaml", rig::to_yaml(rig));
    rig.sources->belt = rig.sources->encoder = ValueSource::measured;
    rig.sources->light = ValueSource::drawing;
    write_text(folder_ / "dark.yaml", rig::to_yaml(rig));
    for (const auto& [assumed, words] : commands) {
      SCOPED_TRACE(kind + ": " + words.front());
      for (const std::string file : {"begun.yaml", "dark.yaml"}) {
        const Outcome refused = host(with(words, {"--rig", file}));
        EXPECT_NE(refused.status, 0);
        EXPECT_NE(refused.err.find("the drawing's and never measured; measure with `selfproj "), std::string::npos)
            << refused.err;
        const Outcome taken = host(with(words, {"--rig", file, "--assume", file == "begun.yaml" ? assumed : "light"}));
        EXPECT_EQ(taken.err.find("never measured"), std::string::npos) << taken.err;
      }
    }
    // Images do not say how far the belt moves from one to the next.
    ASSERT_EQ(sim({"scene", "render", "plane", "--rig", kind, "--count", "3", "--out", kind + "3"}).status, 0);
    const Words images = {"inspect", "--images", kind + "3", "--rig", "dark.yaml", "--assume"};
    EXPECT_NE(host(with(images, {"light"})).err.find("--images: nothing says how far the belt moves"),
              std::string::npos);
    for (const Words& way : {Words{"light", "--mm-per-image", "0.1"}, Words{"light,speed"}}) {
      EXPECT_EQ(host(with(images, way)).err.find("nothing says"), std::string::npos);
    }
    // If the user says it, the rig need not know it; and a verdict by moments cannot do without.
    const Outcome said = host({"inspect", "--images", kind + "3/frame_*.png", "--rig", "begun.yaml", "--assume", "belt",
                               "--mm-per-image", "0.1", "--out", kind + "-said"});
    EXPECT_EQ(said.status, 0) << said.err;
    EXPECT_NE(read_text(folder_ / (kind + "-said/summary.json")).find("\"mm_per_image\": 0.1"), std::string::npos);
    const Words table = {"verdict", "table",       "--rig",        "dark.yaml", "--assume",
                         "light",   "--tolerance", "nothing.yaml", "--out",     "v.yaml"};
    EXPECT_NE(host(table).err.find("--mm-per-frame: is needed"), std::string::npos);
    EXPECT_NE(host(with(table, {"--mm-per-frame", "0.1"})).err.find("nothing.yaml: "), std::string::npos);
  }
}

// The belt of a rig with a projector, which lights the chessboard evenly: the rig knows belt and encoder, and how parts
// are cut, with no key edited.
TEST_F(ProductionCommand, BeltOfAProjectorIsFound) {
  ASSERT_EQ(host({"pattern", "gray", "--rig", "light-section", "--out", "gray"}).status, 0);
  std::filesystem::create_directories(folder_ / "white");
  std::filesystem::copy_file(folder_ / "gray/pattern_36.png", folder_ / "white/0.png");
  ASSERT_EQ(sim({"capture", "--rig", "light-section", "--patterns", "white", "--chessboard", "21x3", "--square", "2.2",
                 "--heights", "0", "--moves", "0,3,6", "--out", "carried"})
                .status,
            0);
  Words belt = {"calibrate", "belt",     "--rig",     "light-section", "--chessboard", "21x3",  "--square",
                "2.2",       "--counts", "0,300,600", "--part-length", "40",           "--out", "belt"};
  for (int i = 1; i <= 3; ++i) {
    belt.push_back("carried/pose_0" + std::to_string(i) + "/image_00.png");
  }
  const Outcome found = host(belt);
  ASSERT_EQ(found.status, 0) << found.err;
  const rig::Rig rig = rig::load_rig((folder_ / "belt/rig.yaml").string());
  EXPECT_NEAR(rig.plane_z_mm, 1167, 0.1);
  EXPECT_NEAR(rig.conveyor.encoder_mm_per_count, 0.01, 1e-5);
  ASSERT_TRUE(rig.sources && rig.parts);
  EXPECT_EQ(rig.sources->belt, rig::ValueSource::measured);
  EXPECT_EQ(rig.sources->encoder, rig::ValueSource::measured);
  EXPECT_EQ(rig.sources->camera, rig::ValueSource::drawing);
  EXPECT_TRUE(rig.parts->by_encoder);
  EXPECT_EQ(rig.parts->length_mm, 40);
  EXPECT_EQ(rig.parts->grid_mm, 0.25);  // a column is 0.233 mm wide
  EXPECT_EQ(rig.parts->above_mm, 1);
  ASSERT_EQ(sim({"scene", "render", "plane", "--count", "1", "--out", "plane"}).status, 0);
  const Words inspect = {"inspect", "--rig", "belt/rig.yaml", "--images", "plane/frame_00001.png",
                         "--check", "--out", "seen"};
  EXPECT_NE(host(inspect).err.find("its camera's lens is the drawing's and never measured; measure with `selfproj "
                                   "calibrate`, or say --assume camera"),
            std::string::npos);
  const Outcome assumed = host(with(inspect, {"--assume", "camera,light"}));
  ASSERT_EQ(assumed.status, 0) << assumed.err;
  for (const float height : images::read_float_tiff(folder_ / "seen/height.tiff").values) {
    ASSERT_FALSE(std::abs(height) > 0.3F) << height;
  }
}

// Tall images, which no board takes, are measured all the same.
TEST_F(ProductionCommand, TallImagesAreMeasured) {
  const Words quiet = {"--count", "1", "--without", "shot-noise,read-noise"};
  ASSERT_EQ(sim(with({"scene", "render", "plane", "--out", "low"}, quiet)).status, 0);
  ASSERT_EQ(host({"inspect", "--images", "low/frame_00001.png", "--out", "low-out"}).status, 0);
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.rows = 2400;  // the line is still on the middle row
  write_text(folder_ / "tall.yaml", rig::to_yaml(rig));
  ASSERT_EQ(sim(with({"scene", "render", "plane", "--rig", "tall.yaml", "--out", "tall"}, quiet)).status, 0);
  const Outcome run =
      host({"inspect", "--rig", "tall.yaml", "--images", "tall/frame_00001.png", "--out", "tall-out", "--check"});
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_NE(run.err.find("has 2400 rows and a board takes at most 2047: this program alone measures them"),
            std::string::npos)
      << run.err;
  // With 1,200 rows a board takes them, if it is built for so many; its packets have other words.
  rig.camera.rows = 1200;
  for (const auto& [mode, select] : {std::pair{model::Mode::binary, model::Select::strongest},
                                     {model::Mode::grey_over, model::Select::all},
                                     {model::Mode::grey, model::Select::strongest}}) {
    rig.measure.mode = mode;
    model::Measure measure = rig.measure.of_board();
    measure.select = select;
    rig.measure.apply(measure);
    write_text(folder_ / "board.yaml", rig::to_yaml(rig));
    ASSERT_EQ(sim(with({"scene", "render", "plane", "--rig", "board.yaml", "--out", "of-board"}, quiet)).status, 0);
    ASSERT_EQ(sim({"board", "--images", "of-board/frame_00001.png", "--rig", "board.yaml", "--mode",
                   images::mode_name(mode), "--threshold", std::to_string(rig.measure.threshold), "--select",
                   select == model::Select::strongest ? "strongest" : "all", "--record", "tall.slfp"})
                  .status,
              0);
    const Outcome of_images =
        host({"inspect", "--rig", "board.yaml", "--images", "of-board/frame_00001.png", "--out", "images-out"});
    EXPECT_EQ(of_images.err.find("this program alone"), std::string::npos) << of_images.err;
    ASSERT_EQ(host({"inspect", "--rig", "board.yaml", "--device", "file:tall.slfp", "--out", "packets-out"}).status, 0);
    EXPECT_EQ(read_text(folder_ / "images-out/height.tiff"), read_text(folder_ / "packets-out/height.tiff"));
  }
  const images::FloatImage low = images::read_float_tiff(folder_ / "low-out/height.tiff");
  const images::FloatImage tall = images::read_float_tiff(folder_ / "tall-out/height.tiff");
  ASSERT_EQ(tall.values.size(), low.values.size());
  for (std::size_t i = 0; i < low.values.size(); ++i) {
    ASSERT_NEAR(tall.values[i], low.values[i], 0.001) << i;
  }
}

TEST_F(ProductionCommand, FindsWhatItPlantsWithStructuredLight) {
  rig::Rig rig = rig::load_rig("scanner");
  rig.camera.rows /= 2;
  rig.camera.columns /= 2;
  rig.camera.pixel_pitch_mm *= 2;
  write_text(folder_ / "coarse.yaml", rig::to_yaml(rig));
  const Outcome made =
      sim({"production", "--rig", "coarse.yaml", "--good", "5", "--parts", "4", "--bad-every", "2", "--out", "scans"});
  ASSERT_EQ(made.status, 0) << made.err;
  // Dents lie below the reference.
  const Words words = {"--rig", "scans/rig.yaml", "--reference", "scans/stripes", "--e", "4"};
  const Outcome learned =
      host(with({"tolerance", "learn", "--device", "file:scans/good.packets", "--out", "tolerance.yaml"}, words));
  ASSERT_EQ(learned.status, 0) << learned.err;
  const Outcome run = host(with({"match", "--device", "file:scans/run.packets", "--check", "--tolerance",
                                 "tolerance.yaml", "--parts", "today", "--out", "newest"},
                                words));
  ASSERT_EQ(run.status, 0) << run.err;
  EXPECT_EQ(agrees("scans", "today", 5, 2), 2);  // whole codes of this coarse rig are worth 2 mm to both sides
  const std::string page = read_text(folder_ / "newest/report.html");
  EXPECT_NE(page.find("<h2>The parts</h2>"), std::string::npos);
  EXPECT_NE(page.find("bad parts"), std::string::npos);
}

TEST_F(ProductionCommand, RefusesWhatItCannotShow) {
  std::filesystem::create_directory(folder_ / "there");
  const Outcome there = sim({"production", "--out", "there", "--parts", "1", "--good", "1"});
  EXPECT_EQ(there.status, 2);
  EXPECT_NE(there.err.find("there"), std::string::npos) << there.err;
  rig::Rig rig = rig::load_rig("light-section");
  rig.projector.tilt_rad = 0.8;  // the light falls elsewhere
  write_text(folder_ / "beside.yaml", rig::to_yaml(rig));
  const Outcome beside = sim({"production", "--rig", "beside.yaml", "--out", "line"});
  EXPECT_EQ(beside.status, 2);
  EXPECT_EQ(beside.err, "selfproj-sim: --rig beside.yaml: no camera column sees the part in the projector's light\n");
  EXPECT_FALSE(std::filesystem::exists(folder_ / "line"));
}

}  // namespace
}  // namespace selfproj::test
