#include "sim/app/moments_command.h"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <iterator>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/io/command_line.h"
#include "host/io/frame_options.h"
#include "host/io/image_files.h"
#include "host/io/output_file.h"
#include "host/io/progress.h"
#include "host/io/user_error.h"
#include "model/column_moments.h"
#include "model/spec/generated/selfproj_spec.h"
#include "sim/board/moments_engine.h"
#include "sim/experiment/moments_csv.h"

namespace selfproj {
namespace {

struct MomentsOptions {
  std::string engine = "rtl";
  int threshold = MomentsSettings{}.threshold;
  std::string mode = "binary";
  std::string channel;  // empty: none asked for
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
std::size_t batch_size(const Image& image) {
  constexpr std::size_t kBytes = std::size_t{16} << 20U;
  constexpr std::size_t kMost = 64;
  return std::clamp<std::size_t>(kBytes / image.pixels.size(), 1, kMost);
}

void run_moments(const MomentsOptions& options) {
  const OutputFile out(options.out);
  for (const std::string& file : options.images) {
    check_image_file(file);
  }
  const std::unique_ptr<MomentsEngine> engine = make_moments_engine(options.engine);
  const std::optional<Channel> channel = channel_of(options.channel);
  const std::size_t total = options.images.size();

  MomentsSettings settings{0, 0, mode_of(options.mode), options.threshold};
  std::string csv = kMomentsCsvHeader;
  std::vector<Image> images;
  std::vector<Moments> moments;
  {
    Progress progress("frame", total);
    std::size_t batch = 1;
    for (std::size_t i = 0; i < total; ++i) {
      const std::string& file = options.images[i];
      const Image& image = images.emplace_back(read_image(file, channel));
      if (i == 0) {
        check_frame_size(file, image, spec::kMaxRows, spec::kMaxColumns);
        settings.rows = image.rows;
        settings.columns = image.columns;
        batch = batch_size(image);
      }
      check_same_size(file, image, options.images.front(), settings.rows, settings.columns);
      if (images.size() < batch && i + 1 < total) {
        continue;
      }
      std::vector<ImageView> frames;
      std::transform(images.begin(), images.end(), std::back_inserter(frames),
                     [](const Image& held) { return held.view(); });
      moments.resize(frames.size());
      engine->process(frames, settings, moments);
      for (std::size_t k = 0; k < moments.size(); ++k) {
        append_moments_csv(csv, i + 2 - moments.size() + k, moments[k]);
      }
      images.clear();
      progress.update(i + 1);
    }
  }
  out.write(csv);
  fmt::print("{} {} of {}, engine {}, {}, threshold {}: {} columns → {}\n", total, total == 1 ? "frame" : "frames",
             size_text(settings.rows, settings.columns), engine->name(), options.mode, settings.threshold,
             total * static_cast<std::size_t>(settings.columns), out.name());
}

}  // namespace

void add_moments_command(CLI::App& app) {
  CLI::App* command = add_command(
      app,
      {.name = "moments",
       .purpose = "Computes the column moments of image files, as the board does for camera frames.",
       .details =
           "Each image is a frame. The table has the columns frame, column, m0, m1 and n. Frames, columns and rows "
           "are counted from 1; n is the number of lit pixels. The line crosses a column at row m1 / m0.\n\n"
           "The images have 8 bits, one size, a multiple of 4 columns up to 2048, and up to 1023 rows.",
       .examples = R"(
# Render 4 frames, and compute their moments with the board's RTL.
selfproj-sim scene render stairs --count 4 --out frames
selfproj-sim moments --mode grey-over --threshold 60 --out moments.csv frames/frame_*.png
)"});
  const auto options = std::make_shared<MomentsOptions>();
  begin_group(*command, "Measuring");
  command
      ->add_option(
          "--engine", options->engine,
          "Implementation that computes the moments: the board's RTL, the HLS kernel or the model. They give the same.")
      ->check(one_of({"rtl", "hls", "model"}))
      ->type_name("ENGINE")
      ->capture_default_str();
  command
      ->add_option("--mode", options->mode,
                   "Weight of a lit pixel: 1 (binary), its grey value (grey), or its grey value less T (grey-over).")
      ->check(one_of(mode_names()))
      ->type_name("MODE")
      ->capture_default_str();
  command->add_option("--threshold", options->threshold, "A pixel is lit where its grey value is greater than T.")
      ->transform(whole_number(0, 255))
      ->type_name("T")
      ->capture_default_str();
  add_channel_option(*command, options->channel);
  begin_group(*command, "Output");
  command->add_option("--out", options->out, "Table to write.")->type_name("FILE.csv")->required();
  add_files(*command, "IMAGE", options->images, "Images in the order of the frames.")->required();
  command->callback([options] { run_moments(*options); });
}

}  // namespace selfproj
