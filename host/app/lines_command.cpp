#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "host/app/commands.h"
#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/notes.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "host/report/frame_picture.h"
#include "host/report/line_images.h"
#include "host/report/report.h"
#include "selfproj/files/user_error.h"
#include "selfproj/light_section/fast_moments.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {
namespace {

struct LinesOptions {
  std::vector<std::string> images;
  images::Preparation preparation;
  std::string mode = "grey-over";
  int threshold = 128;
  cli::SelectOptions select;
  double ambiguous_from = rig::RigRuns{}.ambiguous_from;
  std::size_t pictures = 20;
  std::string out;
};

rig::RigMeasure measure_of(const LinesOptions& options) {
  model::Measure measure{
      .mode = images::mode_of(options.mode), .threshold = options.threshold, .select = model::Select::strongest};
  options.select.apply(measure, model::kMaxSoftwareRows);
  rig::RigMeasure result;
  result.apply(measure);
  if (result.runs) {
    result.runs->ambiguous_from = options.ambiguous_from;
  }
  return result;
}

void run_lines(const LinesOptions& options) {
  const rig::RigMeasure rig_measure = measure_of(options);
  const model::Measure measure = rig_measure.of_board();
  files::OutputFolder folder(options.out);
  images::PreparedImages images(images::image_arguments(options.images), options.preparation);
  if (images.rows() > model::kMaxSoftwareRows) {
    throw UserError(images.files().front(), fmt::format("has {} rows; at most {} are possible: see --roi and "
                                                        "--transpose",
                                                        images.rows(), model::kMaxSoftwareRows));
  }
  const bool tall = images.rows() > spec::kRowLimit;
  if (tall) {
    files::note(
        fmt::format("{}: has {} rows and a board takes at most {}: this command measures them all; for a board, take "
                    "a part with --roi, or --transpose",
                    images.files().front(), images.rows(), spec::kRowLimit));
  }
  report::LineImages lines(images.rows(), images.columns(), rig_measure);
  std::vector<report::CameraPicture> pictures;
  model::Runs runs;
  runs.resize(measure.select, images.columns());
  // A line is thin: light of more rows than this is likely no line.
  const auto widest = static_cast<std::uint32_t>(std::max(16, images.rows() / 10));
  std::vector<std::string> dark, wide;  // images without light, and with much of it
  {
    cli::Progress progress("image", images.count());
    for (std::size_t i = 0; i < images.count(); ++i) {
      images::Image as_taken;
      const images::Image frame = images.frame(i, &as_taken);
      if (tall) {
        measure_tall_columns(frame.view(), measure, runs.view());
      } else {
        light_section::fast_measure_columns(frame.view(), measure, runs.view());
      }
      lines.add(i + 1, runs);
      const auto lit = std::ranges::count_if(runs.moments.n, [](std::uint32_t n) { return n > 0; });
      if (lit == 0) {
        dark.push_back(images.files()[i]);
      } else if (2 * std::ranges::count_if(runs.moments.n, [&](std::uint32_t n) { return n > widest; }) > lit) {
        wide.push_back(images.files()[i]);
      }
      if (i < options.pictures) {
        pictures.push_back(lines.picture(i + 1, std::move(as_taken), runs));
        folder.append(fmt::format("frame_{}.png", i + 1), report::frame_png(pictures.back()));
      }
      progress.update(i + 1);
    }
  }
  std::vector<report::Fact> settings = {{"first_image", "first image", images.files().front()}};
  if (!options.preparation.background.empty()) {
    settings.push_back({"background", "subtracted from them", options.preparation.background.front()});
  }
  const std::string all = images.count() == 1 ? images.files().front()
                                              : fmt::format("{} to {}", images.files().front(), images.files().back());
  std::vector<std::string> doubts;
  const auto say = [&](const std::vector<std::string>& which, const std::string& what) {
    if (!which.empty()) {
      const bool some = which.size() > 1 && which.size() < images.count();
      const std::string& subject = which.size() == images.count() ? all : which.front();
      const std::string doubt =
          what + (some ? fmt::format("; so in {} of the {} images", which.size(), images.count()) : "");
      cli::note_doubt(subject, doubt);
      doubts.push_back(subject + ": " + doubt);
    }
  };
  say(dark, fmt::format("no column has a pixel above the threshold of {}", measure.threshold));
  say(wide,
      fmt::format("most columns with light have more than {} lit rows, which is likely no line: raise --threshold, "
                  "subtract the view without the line (--background), or choose another --channel",
                  widest));
  lines.write(folder, {.title = "Lines in recorded images", .counters = {}, .settings = settings, .doubts = doubts},
              images.count(), pictures);
  folder.commit();
  const std::string select = images::select_text(measure);
  fmt::print("{} {} of {}, {}, threshold {}{}{}\n{} columns with light, {} ambiguous → {}\n", images.count(),
             images.count() == 1 ? "image" : "images", images::size_text(images.rows(), images.columns()), options.mode,
             measure.threshold, select.empty() ? "" : ", ", select, lines.lit(), lines.ambiguous(), options.out);
}

}  // namespace

void add_lines_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "lines",
       .purpose = "Finds the laser line in recorded images, column by column, as a board would.",
       .details = "Each image is a frame of any width. A board takes up to 2047 rows; this command measures up to 5803 "
                  "and says so. A line that runs from top to bottom needs --transpose. The folder of --out gets "
                  "frame_K.png, the images with the line drawn over them, "
                  "moments.csv, centroid.tiff (rows are images; pixel rows count from 1), summary.json and "
                  "report.html.\n\n"
                  "By default the strongest run of each column counts. A column is ambiguous, and magenta in the "
                  "pictures, where its second run is nearly as strong.",
       .examples = R"(
# Render images of a scene, and find the line in them.
selfproj-sim scene render stairs --count 3 --out frames
selfproj lines --threshold 20 --out lines frames/frame_*.png

# A red laser in colours, with an image taken while it was off, and without (needs your files)
selfproj lines --channel red --threshold 15 --background off.jpg --out lines on.jpg
selfproj lines --channel red-difference --threshold 15 --out lines on.jpg
)"});
  const auto options = std::make_shared<LinesOptions>();
  cli::begin_group(*command, "Images");
  cli::add_files(*command, "IMAGE", options->images, "Images with the line, or one folder of them.")->required();
  cli::add_files(*command, "--background", options->preparation.background,
                 "The same view without the line: one image for all, or one for each. It is subtracted.");
  cli::add_preparation_options(*command, options->preparation);
  cli::begin_group(*command, "Measuring");
  command
      ->add_option("--mode", options->mode,
                   "Weight of a lit pixel: 1 (binary), its grey value (grey), or its grey value less T (grey-over).")
      ->check(cli::one_of(images::mode_names()))
      ->type_name("MODE")
      ->capture_default_str();
  command->add_option("--threshold", options->threshold, "A pixel is lit where its grey value is greater than T.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->required();
  cli::add_select_options(*command, options->select, "strongest");
  command
      ->add_option("--ambiguous-from", options->ambiguous_from,
                   "A column is ambiguous where its second run has at least this share of the strongest one.")
      ->transform(cli::real_number(1.0 / 16, 2))
      ->type_name("SHARE")
      ->capture_default_str();
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for pictures, tables and report.")->type_name("DIR")->required();
  command->add_option("--pictures", options->pictures, "Images that are shown, the first ones.")
      ->transform(cli::whole_number(0, 10000))
      ->type_name("N")
      ->capture_default_str();
  command->callback([options] { run_lines(*options); });
}

}  // namespace selfproj::app
