// Tests reading and writing of rigs, and the errors for wrong ones.

#include "selfproj/rig/rig.h"

#include <gtest/gtest.h>

#include <numbers>
#include <string>
#include <vector>

#include "host/files/notes.h"
#include "selfproj/files/user_error.h"
#include "tests/support/error_of.h"

namespace selfproj::test {
namespace {

std::string with(const std::string& from, const std::string& to) {
  std::string yaml = rig::to_yaml(rig::load_rig("light-section"));
  const std::size_t at = yaml.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return yaml.replace(at, from.size(), to);
}

std::string error_of(const std::string& yaml) {
  return test::error_of([&] { rig::parse_rig(yaml, "rig.yaml"); });
}

TEST(Rig, BuiltInOnesHaveTheValuesOfTheThesis) {
  const rig::Rig a = rig::load_rig("light-section");
  EXPECT_EQ(a.kind, rig::RigKind::light_section);
  EXPECT_EQ(a.camera.rows, 96);
  EXPECT_EQ(a.camera.columns, 512);
  EXPECT_DOUBLE_EQ(a.camera.pixel_pitch_mm, 0.010);
  EXPECT_DOUBLE_EQ(a.projector.tilt_rad, 20 * std::numbers::pi / 180);
  EXPECT_DOUBLE_EQ(a.camera.exposure_s, 90e-6);
  const rig::Rig b = rig::load_rig("scanner");
  EXPECT_EQ(b.kind, rig::RigKind::scanner);
  EXPECT_EQ(b.projector.lines, 768);
  EXPECT_DOUBLE_EQ(b.plane_z_mm, 550);
}

TEST(Rig, IsReadBackAsWritten) {
  for (const std::string& name : rig::built_in_rigs()) {
    rig::Rig rig = rig::load_any_rig(name);
    rig.camera.focal_length_mm = 1.0 / 3;
    rig.projector.tilt_rad = 0.1234567890123456;
    rig.name = "a: b # \"c\"";
    const std::string yaml = rig::to_yaml(rig);
    const rig::Rig read = rig::parse_rig(yaml, "text");
    EXPECT_EQ(rig::to_yaml(read), yaml);
    EXPECT_EQ(read.name, rig.name);
    EXPECT_EQ(read.camera.focal_length_mm, rig.camera.focal_length_mm);
    EXPECT_NEAR(read.projector.tilt_rad, rig.light_plane ? 0 : rig.projector.tilt_rad, 1e-16);
  }
}

// The section is optional: without it the pixel clock is the default one, and no section is written.
TEST(Rig, PixelClockIsThatOfTheBoard) {
  for (const std::string& name : rig::built_in_rigs()) {
    const rig::Rig rig = rig::load_any_rig(name);
    EXPECT_FALSE(rig.board);
    EXPECT_EQ(rig.pixel_clock_hz(), model::kDefaultPixelClockHz);
    EXPECT_EQ(rig::to_yaml(rig).find("board"), std::string::npos);
  }
  const std::string yaml = with("measure:\n", "board:\n  pixel_clock_hz: 125000000\nmeasure:\n");
  const rig::Rig rig = rig::parse_rig(yaml, "rig.yaml");
  EXPECT_EQ(rig.pixel_clock_hz(), 125e6);
  EXPECT_EQ(rig::to_yaml(rig), yaml);
  EXPECT_EQ(rig::parse_rig(rig::to_yaml(rig), "text").pixel_clock_hz(), 125e6);
  const auto error_with = [](const std::string& section) {
    return error_of(with("measure:\n", section + "measure:\n"));
  };
  EXPECT_EQ(error_with("board:\n  pixel_clock_hz: 0\n"),
            "rig.yaml: line 26: board.pixel_clock_hz is 0; it must be at least 1000 and at most 10000000000");
  EXPECT_EQ(error_with("board:\n  pixel_clock_hz: fast\n"),
            "rig.yaml: line 26: board.pixel_clock_hz is 'fast', not a number");
  EXPECT_EQ(error_with("board:\n  pixel_clock_mhz: 125\n"),
            "rig.yaml: line 26: board.pixel_clock_mhz: unknown key; the key is pixel_clock_hz");
  EXPECT_EQ(error_with("board:\n  name: x\n"), "rig.yaml: board.pixel_clock_hz is missing");
}

TEST(Rig, ErrorsNameFileLineKeyAndReason) {
  EXPECT_EQ(error_of(with("  focal_length_mm: 50", "  focal_length_mm: -50")),
            "rig.yaml: line 8: camera.focal_length_mm is -50; it must be greater than 0 and at most 1000000");
  EXPECT_EQ(error_of(with("  focal_length_mm: 50", "  focal_length_m: 0.05")),
            "rig.yaml: line 8: camera.focal_length_m: unknown key; the key is focal_length_mm");
  EXPECT_EQ(error_of(with("  speed_mm_per_s: 1000\n", "")), "rig.yaml: conveyor.speed_mm_per_s is missing");
  EXPECT_EQ(error_of(with("mode: grey-over", "mode: gray")),
            "rig.yaml: line 26: measure.mode is 'gray'; one of binary, grey, grey-over is expected");
  EXPECT_EQ(error_of(with("threshold: 20", "threshold: 256")),
            "rig.yaml: line 27: measure.threshold is 256; it must be at least 0 and at most 255");
  EXPECT_EQ(error_of(with("  rows: 96", "  rows: 96.5")),
            "rig.yaml: line 5: camera.rows is '96.5', not a whole number");
  EXPECT_EQ(error_of(with("  seed: 1\n", "  seed: 1\nspeed: 3\n")), "rig.yaml: line 42: speed: unknown key");
  EXPECT_EQ(error_of(with("min_lit_px: 3", "min_lit_px: 30")),
            "rig.yaml: measure.min_lit_px is 30, more than measure.max_lit_px, 24");
  EXPECT_EQ(error_of(with("ambient: 8", "ambient: 201")),
            "rig.yaml: imaging.dark is 2, imaging.ambient 201, imaging.white 200; each may be at most the next");
  EXPECT_EQ(error_of(with("dark: 2", "dark: 9")),
            "rig.yaml: imaging.dark is 9, imaging.ambient 8, imaging.white 200; each may be at most the next");
  EXPECT_EQ(error_of("just text"), "rig.yaml: is not a rig; keys and values are expected");
  EXPECT_EQ(error_of("a: [1"), "rig.yaml: line 1: end of sequence flow not found");
  EXPECT_THROW(rig::load_rig("no-such-rig"), UserError);
}

// Each number of a rig as one that is hardly there, or larger than anything: it is refused, or means itself wherever
// the rig is written again.
TEST(Rig, EveryNumberAtItsLimits) {
  for (const std::string& name : rig::built_in_rigs()) {
    const std::string yaml = rig::to_yaml(rig::load_any_rig(name));
    int numbers = 0;
    std::size_t begin = 0;
    for (std::size_t end = yaml.find('\n'); end != std::string::npos; end = yaml.find('\n', begin)) {
      const std::size_t colon = yaml.find(": ", begin);
      if (colon < end && yaml.find_first_of("-0123456789", colon) == colon + 2) {
        ++numbers;
        for (const char* value : {"1e-320", "-1e-320", "1e308", "-1e308", "1e39", "5e-324", "1e-9", "nan", ".inf"}) {
          std::string other = yaml;
          other.replace(colon + 2, end - colon - 2, value);
          if (const std::string error = error_of(other); error != "none") {
            const std::size_t first = yaml.find_first_not_of(' ', begin);
            std::string key = yaml.substr(first, colon - first);
            if (key.starts_with("normal_") || key.starts_with("direction_")) {
              key.erase(key.find('_'));  // a vector's length is that of all three
            }
            EXPECT_NE(error.find(key), std::string::npos) << error;
            continue;
          }
          const std::string again = rig::to_yaml(rig::parse_rig(other, "rig.yaml"));
          EXPECT_EQ(rig::to_yaml(rig::parse_rig(again, "again")), again)
              << yaml.substr(begin, end - begin) << " " << value;
        }
      }
      begin = end + 1;
    }
    EXPECT_GT(numbers, 30) << name;
  }
}

// A whole number is decimal, and one document is read.
TEST(Rig, OctalAndSecondDocument) {
  EXPECT_EQ(rig::parse_rig(with("  rows: 96", "  rows: 0120"), "text").camera.rows, 120);
  EXPECT_NE(error_of(with("  rows: 96", "  rows: 0x10")), "none");
  const std::string yaml = rig::to_yaml(rig::load_rig("light-section"));
  EXPECT_NE(error_of(yaml + "---\n" + yaml).find("a second document begins"), std::string::npos);
  EXPECT_NE(error_of("a: &x [*x]\n").find("aliases"), std::string::npos);
  EXPECT_NE(error_of(std::string(500'000, '[')).find("nested too deeply"), std::string::npos);
}

// A laser line takes the place of the projector.
TEST(Rig, LaserLineIsReadBackAndChecked) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.calibration.emplace();
  rig.calibration->camera = {.fx_px = 5000, .fy_px = 5001, .cx_px = 255, .cy_px = 47, .k1 = -0.1};
  rig.light_plane = rig::RigLightPlane{{0, 0.8, 0.6}, 700};
  const std::string yaml = rig::to_yaml(rig);
  EXPECT_EQ(yaml.find("projector"), yaml.find("projector_blur_px")) << yaml;
  const rig::Rig read = rig::parse_rig(yaml, "text");
  EXPECT_EQ(rig::to_yaml(read), yaml);
  ASSERT_TRUE(read.light_plane);
  EXPECT_EQ(read.light_plane->distance_mm, 700);
  EXPECT_EQ(read.calibration->camera.k1, -0.1);
  EXPECT_EQ(error_of(yaml + "projector:\n  x_mm: 1\n"), "rig.yaml: line 47: projector does not go with light_plane");
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = yaml;
    return error_of(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_EQ(changed("normal_z: 0.6", "normal_z: 0.7"),
            "rig.yaml: light_plane.normal has the length 1.06301; 1 is expected");
  EXPECT_EQ(changed("distance_mm: 700", "distance_mm: 0"), "rig.yaml: line 45: light_plane.distance_mm is 0");
  EXPECT_EQ(changed("kind: light-section", "kind: scanner"), "rig.yaml: light_plane goes only with kind light-section");
  EXPECT_EQ(changed("camera_lens:", "camera_glass:"),
            "rig.yaml: line 31: camera_glass: unknown key; the key is camera_lens");
}

TEST(Rig, SourcesAreReadBackAndAskedFor) {
  rig::Rig rig = rig::load_rig("light-section");
  EXPECT_NO_THROW(rig::expect_measured(rig, "rig.yaml"));  // nothing is said of its values
  rig.sources = rig::RigSources{.camera = rig::ValueSource::measured, .light = rig::ValueSource::measured};
  const std::string yaml = rig::to_yaml(rig);
  EXPECT_NE(yaml.find("sources:\n  camera: measured\n  light: measured\n  belt: drawing\n"), std::string::npos) << yaml;
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(yaml, "text")), yaml);
  EXPECT_EQ(error_of(yaml.substr(0, yaml.find("  encoder: drawing"))), "rig.yaml: sources.encoder is missing");
  const auto refused = [&](rig::Millimetres which = rig::Millimetres::of_part) -> std::string {
    try {
      rig::expect_measured(rig, "rig.yaml", which);
    } catch (const UserError& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_EQ(refused(),
            "rig.yaml: the place of its belt (plane_z_mm, belt_pose) is the drawing's and never measured; measure with "
            "`selfproj calibrate belt`, or say --assume belt");
  rig::assume(rig, "belt", "--assume");
  EXPECT_EQ(rig.sources->belt, rig::ValueSource::assumed);
  EXPECT_EQ(refused(rig::Millimetres::of_section), "");
  EXPECT_NE(refused().find("its conveyor's speed and encoder are the drawing's"), std::string::npos);
  rig.sources->speed = rig::ValueSource::measured;
  EXPECT_EQ(refused(), "");
  rig.parts = rig::RigParts{.by_encoder = true, .grid_mm = 1, .gap_mm = 1, .pause_s = 1, .length_mm = 10};
  EXPECT_NE(refused().find("its conveyor's encoder is the drawing's"), std::string::npos);
  rig::assume(rig, "camera,encoder", "--assume");
  EXPECT_EQ(refused(), "");
  EXPECT_THROW(rig::assume(rig, "belt,zero", "--assume"), UserError);
  rig.sources->camera = rig::ValueSource::drawing;
  EXPECT_NE(refused().find("measure with `selfproj calibrate`, or"), std::string::npos) << refused();
  rig.light_plane = rig::RigLightPlane{{0, 0.8, 0.6}, 700};
  EXPECT_NE(refused().find("measure with `selfproj calibrate camera`, or"), std::string::npos) << refused();
}

TEST(Rig, SectionsWithinMeasureAreReadBack) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.measure.runs = rig::RigRuns{.gap_rows = 2, .ambiguous_from = 0.75};
  rig.measure.window = model::RowWindow{.first = 3, .last = 90};
  rig.parts = rig::RigParts{.grid_mm = 1, .gap_mm = 1, .pause_s = 1, .length_mm = 10};
  const std::string yaml = to_yaml(rig);
  const rig::Rig read = rig::parse_rig(yaml, "text");
  EXPECT_EQ(to_yaml(read), yaml);
  ASSERT_TRUE(read.measure.runs && read.measure.window);
  EXPECT_EQ(read.measure.runs->gap_rows, 2);
  EXPECT_EQ(read.measure.runs->ambiguous_from, 0.75);
  EXPECT_EQ(*read.measure.window, (model::RowWindow{3, 90}));
}

TEST(Rig, CompactWordsAreReadBackAndChecked) {
  rig::Rig rig = rig::load_rig("light-section");
  EXPECT_FALSE(rig.measure.sends_compact());
  EXPECT_EQ(rig::to_yaml(rig).find("words:"), std::string::npos);
  rig.measure.mode = model::Mode::grey_over;
  rig.measure.compact = true;
  const std::string text = rig::to_yaml(rig);
  EXPECT_NE(text.find("words: compact"), std::string::npos);
  EXPECT_TRUE(rig::parse_rig(text, "rig.yaml").measure.sends_compact());
  rig.measure.mode = model::Mode::binary;
  EXPECT_EQ(error_of(rig::to_yaml(rig)),
            "rig.yaml: measure.words is compact, which goes with modes grey and grey_over: binary words have 32 bits");
}

TEST(Rig, PixelBitsAreReadBackAndChecked) {
  rig::Rig rig = rig::load_rig("light-section");
  EXPECT_EQ(rig.measure.bits(), 8);
  EXPECT_EQ(rig::to_yaml(rig).find("pixel_bits"), std::string::npos);
  rig.measure.pixel_bits = 12;
  rig.measure.threshold = 4095;
  const std::string yaml = rig::to_yaml(rig);
  const rig::Rig back = rig::parse_rig(yaml, "twelve");
  EXPECT_EQ(back.measure.of_board().bits, 12);
  EXPECT_EQ(back.measure.of_board().threshold, 4095);
  EXPECT_EQ(rig::to_yaml(back), yaml);
  const auto error = [](const rig::Rig& wrong) { return error_of(rig::to_yaml(wrong)); };
  rig::Rig ten = rig;
  ten.measure.pixel_bits = 10;
  EXPECT_NE(error(ten).find("threshold"), std::string::npos);  // 1023 at most
  rig::Rig tall = rig;
  tall.camera.rows = 1500;
  EXPECT_EQ(error(tall),
            "rig.yaml: the camera sends 1500 rows; with measure.pixel_bits 12 at most 1023 can be measured "
            "(camera.region takes fewer)");
  rig::Rig all = rig;
  all.measure.runs = rig::RigRuns{};
  all.measure.compact = true;
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(rig::to_yaml(all), "all")), rig::to_yaml(all));
  rig::Rig scanner = rig::load_rig("scanner");
  scanner.measure.pixel_bits = 12;
  EXPECT_NE(error(scanner).find("measure.pixel_bits"), std::string::npos);
}

TEST(Rig, ARegionIsReadBackAndChecked) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.camera.region = rig::RigRegion{
      .row_offset = 38, .rows = 20, .column_offset = 0, .columns = 512, .frame_rate_hz = 50000, .exposure_s = 18e-6};
  const std::string yaml = rig::to_yaml(rig);
  const rig::Rig read = rig::parse_rig(yaml, "text");
  EXPECT_EQ(rig::to_yaml(read), yaml);
  EXPECT_EQ(read.camera.region, rig.camera.region);
  EXPECT_EQ(read.camera.sent(), *rig.camera.region);
  // What was measured with the whole sensor goes on.
  EXPECT_EQ(rig::geometry_of(read), rig::geometry_of(rig::load_rig("light-section")));
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = yaml;
    return error_of(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_EQ(changed("row_offset: 38", "row_offset: 80"),
            "rig.yaml: camera.region ends at row 100, column 512; the camera has 96 rows, 512 columns");
  EXPECT_EQ(changed("column_offset: 0\n    columns: 512", "column_offset: 0\n    columns: 510"),
            "rig.yaml: camera.region.columns is 510; a multiple of 4 is expected");
}

TEST(Rig, HeightsAreReadBackAndChecked) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.heights = rig::RigHeights{-1, 41, 1, 1, {0.5, -0.25, 1.0 / 3, 0}};
  const std::string yaml = rig::to_yaml(rig);
  EXPECT_NE(yaml.find("corrections_mm: [0.5, -0.25, 0.3333333333333333, 0]"), std::string::npos) << yaml;
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(yaml, "text")), yaml);
  const auto changed = [&](const std::string& from, const std::string& to) {
    std::string text = yaml;
    return error_of(text.replace(text.find(from), from.size(), to));
  };
  EXPECT_EQ(changed("order: 1", "order: 2"), "rig.yaml: heights.corrections_mm has 4 numbers; orders 2 and 1 have 9");
  EXPECT_EQ(changed("max_mm: 41", "max_mm: -1"),
            "rig.yaml: heights.min_mm is -1, heights.max_mm -1; it must be greater");
  EXPECT_NE(changed("[0.5, ", "[half, ").find("has an entry, number 1, that is not a number"), std::string::npos);
}

// Keys had other names in files of the version before.
TEST(Rig, EarlierNamesOfKeysAreReadAndNoted) {
  rig::Rig rig = rig::load_rig("light-section");
  rig.heights = rig::RigHeights{-1, 41, 0, 0, {0.5}};
  const std::string yaml = rig::to_yaml(rig);
  std::string earlier = yaml;
  earlier.replace(earlier.find("min_mm: -1"), 6, "lowest_mm");
  earlier.replace(earlier.find("max_mm: 41"), 6, "highest_mm");
  std::vector<std::string> notes;
  files::note_sink() = [&](const std::string& line) { notes.push_back(line); };
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(earlier, "rig.yaml")), yaml);
  ASSERT_EQ(notes.size(), 2U);
  EXPECT_EQ(notes[0].find("rig.yaml: line "), 0U);
  EXPECT_NE(notes[0].find("heights.lowest_mm: this key is now called min_mm"), std::string::npos) << notes[0];
  notes.clear();
  EXPECT_EQ(rig::to_yaml(rig::parse_rig(yaml, "rig.yaml")), yaml);
  EXPECT_TRUE(notes.empty());
  EXPECT_NE(
      error_of(earlier.replace(earlier.find("lowest_mm: -1"), 13, "lowest_mm: x")).find("heights.lowest_mm is 'x'"),
      std::string::npos);
  files::note_sink() = {};
}

}  // namespace
}  // namespace selfproj::test
