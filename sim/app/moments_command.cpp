#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_file.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "host/images/prepared_images.h"
#include "host/report/tables.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/generated/selfproj_spec.h"
#include "sim/app/commands.h"
#include "sim/board/engines.h"

namespace selfproj::sim {
namespace {

struct MomentsOptions {
  std::string engine = "rtl";
  int threshold = model::Measure{}.threshold;
  std::string mode = "binary";
  cli::SelectOptions select;
  images::Preparation preparation;
  std::string out;
  std::vector<std::string> images;
};

std::unique_ptr<MomentsEngine> make_moments_engine(const std::string& name) {
  if (name == "model") {
    return make_moments_model_engine();
  }
  if (name == "hls") {
    return make_moments_hls_engine();
  }
#ifdef SELFPROJ_HAS_RTL_ENGINE
  if (name == "rtl") {
    return make_moments_rtl_engine();
  }
#endif
  throw UserError("--engine " + name, "this engine is not part of this build");
}

// The number of frames that are held in memory and passed to the engine together.
std::size_t batch_size(const images::Image& image) {
  constexpr std::size_t kBytes = std::size_t{16} << 20U;
  constexpr std::size_t kMost = 64;
  return std::clamp<std::size_t>(kBytes / image.pixels.size(), 1, kMost);
}

// Columns of the frames that the engine gets: a circuit takes a multiple of 4, so that dark columns are added.
int columns_for(const std::string& engine, const images::PreparedImages& images) {
  const std::string& file = images.files().front();
  if (images.rows() > spec::kMaxRows) {
    throw UserError(file, fmt::format("has {} rows; at most {} are possible", images.rows(), spec::kMaxRows));
  }
  if (engine == "model") {
    return images.columns();
  }
  const int padded = (images.columns() + spec::kPixelsPerBeat - 1) / spec::kPixelsPerBeat * spec::kPixelsPerBeat;
  images::check_frame_size(file, {.rows = images.rows(), .columns = padded, .pixels = {}}, spec::kMaxRows,
                           spec::kMaxColumns);
  return padded;
}

void run_moments(const MomentsOptions& options) {
  const files::OutputFile out(options.out);
  model::Measure measure{.mode = images::mode_of(options.mode), .threshold = options.threshold};
  options.select.apply(measure);
  const std::unique_ptr<MomentsEngine> engine = make_moments_engine(options.engine);
  images::PreparedImages source(options.images, options.preparation);
  const std::size_t total = source.count();
  const MomentsSettings settings{
      .rows = source.rows(), .columns = columns_for(options.engine, source), .measure = measure};

  std::string csv = report::moments_csv_header(measure.select);
  std::vector<images::Image> images;
  std::vector<model::Runs> found;
  {
    cli::Progress progress("frame", total);
    std::size_t batch = 1;
    for (std::size_t i = 0; i < total; ++i) {
      const images::Image& image = images.emplace_back(images::with_columns(source.frame(i), settings.columns));
      batch = i == 0 ? batch_size(image) : batch;
      if (images.size() < batch && i + 1 < total) {
        continue;
      }
      std::vector<model::ImageView> frames;
      std::transform(images.begin(), images.end(), std::back_inserter(frames),
                     [](const images::Image& held) { return held.view(); });
      found.resize(frames.size());
      engine->process(frames, settings, found);
      for (std::size_t k = 0; k < found.size(); ++k) {
        found[k].resize(measure.select, source.columns());  // without the padding
        report::append_moments_csv(csv, i + 2 - found.size() + k, found[k]);
      }
      images.clear();
      progress.update(i + 1);
    }
  }
  out.write(csv);
  const std::string select = images::select_text(measure);
  fmt::print("{} {} of {}, engine {}, {}, threshold {}{}{}: {} columns → {}\n", total, total == 1 ? "frame" : "frames",
             images::size_text(settings.rows, source.columns()), engine->name(), options.mode, measure.threshold,
             select.empty() ? "" : ", ", select, total * static_cast<std::size_t>(source.columns()), out.name());
}

}  // namespace

void add_moments_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "moments",
       .purpose = "Computes the column moments of image files, as the board does for camera frames.",
       .details =
           "Each image is a frame. The table has the columns frame, column, m0, m1 and n. Frames, columns and rows "
           "are counted from 1; n is the number of lit pixels. The line crosses a column at row m1 / m0. With --select "
           "strongest they are those of the strongest run, and the table has two more columns: runs, the number of "
           "runs (3: three or more), and second, M0 of the second run in sixteenths of the strongest one's, rounded "
           "down (binary: 8 where it is half or more, else 0).\n\n"
           "The images have 8 bits, one size and up to 1023 rows. The model takes any width; for the others up to 2048 "
           "columns, dark columns are added where it is not a multiple of 4.",
       .examples = R"(
# Render 4 frames, and compute their moments with the board's RTL.
selfproj-sim scene render stairs --count 4 --out frames
selfproj-sim moments --mode grey-over --threshold 60 --out moments.csv frames/frame_*.png
)"});
  const auto options = std::make_shared<MomentsOptions>();
  cli::begin_group(*command, "Measuring");
  command
      ->add_option("--engine", options->engine,
                   "Implementation that computes the moments: the board's RTL, the HLS circuits or the model. They "
                   "give the same.")
      ->check(cli::one_of({"rtl", "hls", "model"}))
      ->type_name("ENGINE")
      ->capture_default_str();
  command
      ->add_option("--mode", options->mode,
                   "Weight of a lit pixel: 1 (binary), its grey value (grey), or its grey value less T (grey-over).")
      ->check(cli::one_of(images::mode_names()))
      ->type_name("MODE")
      ->capture_default_str();
  command->add_option("--threshold", options->threshold, "A pixel is lit where its grey value is greater than T.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->capture_default_str();
  cli::add_select_options(*command, options->select);
  cli::begin_group(*command, "Images");
  cli::add_files(*command, "--background", options->preparation.background,
                 "The same view without the line: one image for all, or one for each. It is subtracted.");
  cli::add_preparation_options(*command, options->preparation);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Table to write.")->type_name("FILE.csv")->required();
  cli::add_files(*command, "IMAGE", options->images, "Images in the order of the frames.")->required();
  command->callback([options] { run_moments(*options); });
}

}  // namespace selfproj::sim
