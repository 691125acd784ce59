#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "host/cli/command_line.h"
#include "host/cli/progress.h"
#include "host/files/output_folder.h"
#include "host/images/frame_options.h"
#include "host/images/image_files.h"
#include "selfproj/files/user_error.h"
#include "selfproj/model/gray_decoder.h"
#include "sim/app/commands.h"
#include "sim/board/engines.h"

namespace selfproj::sim {
namespace {

struct DecodeOptions {
  std::string engine = "rtl";
  int bits = 0;
  int threshold = model::GraySettings{}.threshold;
  bool median = false;
  images::PixelOptions pixels;
  std::string out;
  std::vector<std::string> images;
};

std::unique_ptr<GrayEngine> make_gray_engine(const std::string& name) {
  if (name == "model") {
    return make_gray_model_engine();
  }
  if (name == "hls") {
    return make_gray_hls_engine();
  }
#ifdef SELFPROJ_HAS_RTL_ENGINE
  if (name == "rtl") {
    return make_gray_rtl_engine();
  }
#endif
  throw UserError("--engine " + name, "this engine is not part of this build");
}

void add_png(files::OutputFolder& out, const std::string& file, const cv::Mat& image) {
  std::vector<std::uint8_t> bytes;
  if (!cv::imencode(".png", image, bytes)) {
    throw std::runtime_error(file + ": cannot be encoded");
  }
  // NOLINTNEXTLINE(cppcoreguidelines-pro-type-reinterpret-cast): bytes as characters
  out.append(file, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

std::string code_file(std::size_t pair) { return fmt::format("code_{:04}.png", pair); }
std::string measurable_file(std::size_t pair) { return fmt::format("measurable_{:04}.png", pair); }

// Checks that need no image.
void check_files(const DecodeOptions& options, const files::OutputFolder& out) {
  const std::size_t total = options.images.size();
  const auto cycle = static_cast<std::size_t>(2 * options.bits);
  if (total % 2 != 0) {
    throw UserError("IMAGE",
                    fmt::format("{} images are an odd number; each positive is followed by its negative", total));
  }
  if (total < cycle) {
    throw UserError(
        "IMAGE", fmt::format("{} images are too few; at least {} are needed for {} bits", total, cycle, options.bits));
  }
  for (const std::string& file : options.images) {
    images::check_image_file(file);
  }
  for (std::size_t pair = static_cast<std::size_t>(options.bits) - 1; pair < total / 2; ++pair) {
    out.check(code_file(pair));
    out.check(measurable_file(pair));
  }
}

void run_decode(DecodeOptions options) {
  options.images = images::image_arguments(options.images);
  files::OutputFolder out(options.out);
  check_files(options, out);
  const std::unique_ptr<GrayEngine> engine = make_gray_engine(options.engine);
  const images::PixelRule rule = options.pixels.rule();
  const std::size_t total = options.images.size();
  const auto cycle = static_cast<std::size_t>(2 * options.bits);

  model::GraySettings settings{.rows = 0, .columns = 0, .bits = options.bits, .threshold = options.threshold};
  cv::Mat codes;
  std::size_t code_images = 0;
  std::size_t measurable_pixels = 0;  // of the last code image
  {
    cli::Progress progress("image", total);
    for (std::size_t i = 0; i < total; ++i) {
      const std::string& file = options.images[i];
      const images::Image image = images::read_image(file, rule);
      if (i == 0) {
        images::check_frame_size(file, image, engine->max_rows(), engine->max_columns());
        settings.rows = image.rows;
        settings.columns = image.columns;
        codes.create(image.rows, image.columns, CV_16UC1);
        engine->start(settings, options.median);
      } else {
        images::check_same_size(file, {image.rows, image.columns}, options.images.front(), settings.rows,
                                settings.columns);
      }
      if (engine->take(image.view(), static_cast<int>(i % cycle), codes.ptr<std::uint16_t>())) {
        cv::Mat measurable(codes.size(), CV_8UC1);
        std::transform(codes.begin<std::uint16_t>(), codes.end<std::uint16_t>(), measurable.begin<std::uint8_t>(),
                       [](std::uint16_t word) { return (word & model::GrayDecoder::kMeasurable) != 0 ? 255 : 0; });
        for (std::uint16_t& word : cv::Mat_<std::uint16_t>(codes)) {
          word = (word & model::GrayDecoder::kMeasurable) != 0 ? word ^ model::GrayDecoder::kMeasurable : 0;
        }
        add_png(out, code_file(i / 2), codes);
        add_png(out, measurable_file(i / 2), measurable);
        ++code_images;
        measurable_pixels = static_cast<std::size_t>(cv::countNonZero(measurable));
      }
      progress.update(i + 1);
    }
  }
  out.commit();
  fmt::print("{} images of {}, engine {}, {} bits, threshold {}{}: {} code {} → {}; measurable in the last: {:.1f} %\n",
             total, images::size_text(settings.rows, settings.columns), engine->name(), settings.bits,
             settings.threshold, options.median ? ", median" : "", code_images, code_images == 1 ? "image" : "images",
             options.out, 100.0 * static_cast<double>(measurable_pixels) / static_cast<double>(codes.total()));
}

}  // namespace

void add_decode_command(CLI::App& app) {
  CLI::App* command = cli::add_command(
      app,
      {.name = "decode",
       .purpose = "Decodes Gray-code images to code images, as the board does.",
       .details = "The images are the positive and the negative of each bit in turn, most significant bit first: pos0 "
                  "neg0 pos1 neg1 ... From pair M on, every pair completes a code image. The output folder gets, for "
                  "pair K counted from 0,\n"
                  "- code_KKKK.png: 16-bit codes, 0 where not measurable\n"
                  "- measurable_KKKK.png: 255 where measurable, else 0\n\n"
                  "The images have 8 bits, one size and a multiple of 4 columns. The RTL takes up to 4096 columns, "
                  "the HLS circuits take up to 2048; both take up to 4095 rows.",
       .examples = R"(
# Render a scene under 8-bit Gray codes, and decode the images with the board's RTL.
selfproj-sim scene render desk --count 16 --out codes
selfproj-sim decode --bits 8 --out decoded codes/frame_*.png
)"});
  const auto options = std::make_shared<DecodeOptions>();
  cli::begin_group(*command, "Decoding");
  command
      ->add_option(
          "--engine", options->engine,
          "Implementation that decodes the images: the board's RTL, the HLS circuits or the model. They give the same.")
      ->check(cli::one_of({"rtl", "hls", "model"}))
      ->type_name("ENGINE")
      ->capture_default_str();
  command->add_option("--bits", options->bits, "Bits of the code, which are pairs of images.")
      ->transform(cli::whole_number(1, model::GrayDecoder::kMaxBits))
      ->type_name("M")
      ->required();
  command
      ->add_option("--threshold", options->threshold,
                   "A pair of images that differs by at most this many grey levels is ambiguous.")
      ->transform(cli::whole_number(0, 255))
      ->type_name("T")
      ->capture_default_str();
  command->add_flag("--median", options->median, "Apply a 3 x 3 lower median to the measurable codes.");
  cli::add_pixel_options(*command, options->pixels);
  cli::begin_group(*command, "Output");
  command->add_option("--out", options->out, "Folder for the code images.")->type_name("DIR")->required();
  cli::add_files(*command, "IMAGE", options->images,
                 "Images in the order of the patterns, an even number, or one folder of them, in natural order.")
      ->required();
  command->callback([options] { run_decode(*options); });
}

}  // namespace selfproj::sim
