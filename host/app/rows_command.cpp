#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/app/commands.h"
#include "host/app/section_run.h"
#include "host/cli/command_line.h"
#include "host/files/output_file.h"
#include "host/light_section/rows.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/differential_profile.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

// A camera or sensor whose maker says how long a frame of few rows takes: row time times rows, and an overhead. The
// exposure of the next frame overlaps with it.
struct Sensor {
  const char* name;
  double row_us;
  double overhead_us;
  const char* source;
};
constexpr std::array<Sensor, 5> kSensors{{
    {"IDP Express (thesis)", 0.9615, 7.69, "512 rows at 2,000 fps and 96 rows at 10,000 fps: a line through both"},
    {"Photonfocus MV2-D1280-640", 2.0, 0.12, "manual MAN033 07/2008, 4.3: 132 clocks a row, 1,024 rows at 488 fps"},
    {"PixeLINK PL-D7715", 10.69, 1561, "readout timing: 2,352 clocks of 220 MHz a row, 146 rows of overhead"},
    {"PixeLINK PL-D775", 10.13, 91.1, "readout timing: 972 clocks of 96 MHz a row, 9 rows of overhead"},
    {"mvBlueFOX3-1020", 15.73, 78.7, "manual, 22.4.3: 2 rows + 10 lines of 944 clocks of 120 MHz"},
}};

struct RowsOptions {
  SectionOptions section;
  std::optional<int> rows;
  std::optional<double> range_mm;
  double share = 0.98;
  std::optional<double> lit_rows;
  std::optional<double> row_us;
  double overhead_us = 0;
  std::optional<double> rate_hz;
  std::string out;
};

constexpr double kRangeMm = 2;

// The share of a frame's time in which light is collected; the rest resets the pixels.
constexpr double kExposed = 0.9;

// What a shorter exposure leaves: light falls with it, and the threshold may follow down to five standard deviations
// above what is there without the line.
struct Shot {
  int threshold = 0;  // a value of the rig's pixels
  double noise_rows = 0;
};
Shot shot_of(const rig::Rig& rig, double exposure_s, double lit_rows) {
  const rig::RigImaging& imaging = rig.imaging;
  const double share = rig.camera.exposure_s > 0 ? std::min(exposure_s / rig.camera.exposure_s, 1.0) : 1;
  const double without = imaging.dark + imaging.ambient * share;
  const double noise = std::hypot(imaging.read_noise, std::sqrt(without / imaging.electrons_per_grey));
  const int per_grey = rig.measure.values_per_grey();
  Shot shot{.threshold =
                std::min(rig.measure.threshold, static_cast<int>(std::ceil(per_grey * (without + 5 * noise))))};
  shot.noise_rows = light_section::centroid_noise(imaging, light_section::kPeakOfWhite * imaging.white * share,
                                                  lit_rows, static_cast<double>(shot.threshold) / per_grey);
  return shot;
}

void run_rows(const RowsOptions& options) {
  const rig::Rig rig = options.section.load_rig();
  if (options.rows && *options.rows > rig.camera.rows) {
    throw UserError("--rows", fmt::format("is {}; the camera has {}", *options.rows, rig.camera.rows));
  }
  if (!options.out.empty() && !options.rows) {
    throw UserError("--out", "needs --rows");
  }
  if (options.rows && options.rate_hz) {
    const double most = std::floor(light_section::board_rate_hz(rig, *options.rows, rig.camera.columns));
    if (*options.rate_hz > most) {
      throw UserError("--rate", fmt::format("is {:.0f}; the board takes at most {:.0f} frames a second of {} rows",
                                            *options.rate_hz, most, *options.rows));
    }
  }
  const std::optional<files::OutputFile> file =
      options.out.empty() ? std::nullopt : std::optional<files::OutputFile>(std::in_place, options.out);
  const light_section::DifferentialProfiler profiler(rig, options.section.load_reference(rig, ""));
  const double lit = options.lit_rows.value_or(light_section::usual_lit_rows(rig));
  const light_section::RowTable table(rig, profiler, lit);
  if (table.columns() == 0) {
    throw UserError("--reference", "the camera sees it in no column");
  }
  const double mm_per_row = table.mm_per_row();
  const int columns = rig.camera.columns;
  fmt::print("{} of {} columns have a reference; a row means {:.3f} mm there, the line lights {:.1f} rows\n\n",
             table.columns(), columns, mm_per_row, lit);
  fmt::print("  rows   from row   measures, mm           board    Ethernet   exposure   threshold   noise\n");
  std::vector<int> sizes = {8, 12, 16, 20, 24, 32, 48, 64, 96, 128, 192, 256, 512};
  if (options.rows) {
    sizes = {*options.rows};
  }
  const double range_mm = options.range_mm.value_or(kRangeMm);
  std::optional<int> enough;
  std::optional<rig::RigRegion> chosen;
  int threshold = rig.measure.threshold;
  for (const int rows : sizes) {
    if (rows > rig.camera.rows) {
      break;
    }
    const light_section::RowTable::Choice choice = table.best(rows, options.share);
    const double board = light_section::board_rate_hz(rig, rows, columns);
    const double wire = light_section::ethernet_rate_hz(rig, columns);
    const double rate = std::min(std::floor(board), options.rate_hz.value_or(board));
    const double exposure_s = std::min(rig.camera.exposure_s, kExposed / rate);
    const bool some = choice.range.low_mm < choice.range.high_mm;
    const Shot shot = shot_of(rig, exposure_s, lit);
    fmt::print("  {:4}   {:8}   {:<18} {:>9.0f}   {:>9.0f}   {:5.1f} µs   {:9}   {}\n", rows, choice.first_row + 1,
               some ? fmt::format("{:.2f} .. {:+.2f}", choice.range.low_mm, choice.range.high_mm) : "nothing", board,
               wire, 1e6 * exposure_s, shot.threshold,
               std::isfinite(shot.noise_rows) ? fmt::format("{:.4f} mm", shot.noise_rows * mm_per_row) : "too dark");
    if (!enough && some && choice.both_sides_mm() >= range_mm) {
      enough = rows;
    }
    if (options.rows) {
      if (file && !some) {
        throw UserError("--rows", fmt::format("is {}: so few measure nothing, because the line and a dark row on both "
                                              "sides must fit in",
                                              rows));
      }
      if (options.range_mm && choice.both_sides_mm() < *options.range_mm) {
        cli::note_doubt(
            "--rows", fmt::format("{} measure {:.2f} mm to both sides in {:.0f} % of the columns, not {} "
                                  "(--range)",
                                  rows, std::max(0.0, choice.both_sides_mm()), 100 * options.share, *options.range_mm));
      }
      if (file && rate > wire) {
        cli::note_doubt("--rate", fmt::format("Gigabit Ethernet carries {:.0f} of {:.0f} frames a second; with `words: "
                                              "compact` in section measure of the rig packets are shorter",
                                              wire, rate));
      }
      threshold = shot.threshold;
      chosen = rig::RigRegion{.row_offset = choice.first_row,
                              .rows = rows,
                              .column_offset = 0,
                              .columns = columns,
                              .frame_rate_hz = rate,
                              .exposure_s = exposure_s};
    }
  }
  if (!options.rows) {
    fmt::print("\n{}\n", enough ? fmt::format("{} rows measure {:.2f} mm to both sides in {:.0f} % of the columns",
                                              *enough, range_mm, 100 * options.share)
                                : fmt::format("no number of rows measures {:.2f} mm to both sides in {:.0f} % of the "
                                              "columns",
                                              range_mm, 100 * options.share));
  }
  const int rows = options.rows.value_or(enough.value_or(rig.camera.rows));
  fmt::print("\nFrames a second of {} rows by sensor\n", rows);
  if (options.row_us) {
    fmt::print("  {:>9.0f}   this one: {} µs a row, {} µs a frame\n",
               1e6 / (rows * *options.row_us + options.overhead_us), *options.row_us, options.overhead_us);
  }
  for (const Sensor& sensor : kSensors) {
    fmt::print("  {:>9.0f}   {}; {}\n", 1e6 / (rows * sensor.row_us + sensor.overhead_us), sensor.name, sensor.source);
  }
  if (file) {
    rig::Rig few = rig;
    few.camera.region = chosen;
    few.measure.threshold = threshold;
    file->write(rig::to_yaml(few));
    fmt::print("\n{}: the rig with this region at {:.0f} fps\n", options.out, chosen->frame_rate_hz);
  }
}

}  // namespace

void add_rows_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "rows",
       .purpose = "Says how many rows of the sensor a light section needs, and how fast they can come.",
       .details =
           "On a good part the line stays where the reference has it, so that few rows around it are enough, and "
           "a camera reads few rows faster. For regions of different heights this says which heights over and "
           "under the reference they measure, the frames a second that the board's circuit and Gigabit Ethernet "
           "take, the longest exposure at that rate or at --rate (at most the rig's), and the noise of a height that "
           "camera and light of the rig's section `imaging` give with it. With --rows and --out it writes the rig "
           "with that region, from which inspect and the simulation take it.",
       .examples = R"(
# What the built-in rig needs for 2 mm to both sides of the plane.
selfproj rows

# A rig whose camera sends the best 20 rows.
selfproj rows --rows 20 --rate 50000 --out few.yaml
)"});
  const auto options = std::make_shared<RowsOptions>();
  options->section.rig = "light-section";
  add_section_options(*command, options->section);
  command->add_option("--rows", options->rows, "Only this number of rows.")
      ->transform(cli::whole_number(1, 1 << 14))
      ->type_name("N");
  command->add_option("--range", options->range_mm, "Height over and under the reference to be measured, mm.")
      ->transform(cli::real_number(0.001, 1000))
      ->type_name("MM")
      ->default_str(fmt::format("{}", kRangeMm));
  command->add_option("--share", options->share, "Share of the columns in which it is to be measured.")
      ->transform(cli::real_number(0.01, 1))
      ->type_name("SHARE")
      ->capture_default_str();
  command
      ->add_option(
          "--rate", options->rate_hz,
          "Frames a second at which the camera is to run; of heights at which the board takes fewer, that many.")
      ->transform(cli::real_number(0.1, 1e7))
      ->type_name("HZ")
      ->default_str("what the board takes");
  command
      ->add_option("--lit-rows", options->lit_rows,
                   "Rows that the line lights, as `selfproj lines` counts them (n in its table).")
      ->transform(cli::real_number(1, 1000))
      ->type_name("N")
      ->default_str("the middle of the rig's min_lit_px and half of its max_lit_px");
  CLI::Option* const row = command->add_option("--row-us", options->row_us, "Time of a row of your sensor, µs.")
                               ->transform(cli::real_number(0.001, 10000))
                               ->type_name("US");
  command->add_option("--overhead-us", options->overhead_us, "Time of a frame of your sensor beside its rows, µs.")
      ->transform(cli::real_number(0, 1e6))
      ->type_name("US")
      ->needs(row)
      ->capture_default_str();
  command->add_option("--out", options->out, "File for the rig with this region; needs --rows.")->type_name("FILE");
  command->callback([options] { run_rows(*options); });
}

}  // namespace selfproj::app
