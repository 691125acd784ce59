#include "host/structured_light/depth_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "host/files/numbers.h"
#include "host/images/frame_options.h"
#include "selfproj/files/user_error.h"
#include "selfproj/structured_light/fast_decoder.h"
#include "selfproj/structured_light/lens_triangulation.h"

namespace selfproj::structured_light {
namespace {

ImageSource source_of(images::ImageSequence& images) {
  const images::Image& first = images.first();
  return {images.files().front(), first.rows, first.columns};
}

// Gives the scanner its background, if there is one.
void set_background(const DepthSetup& setup, const Triangulation& triangulation, Scanner& scanner) {
  if (setup.background.empty()) {
    return;
  }
  const images::FloatImage background = images::read_float_tiff(setup.background);
  if (background.rows != triangulation.rows() || background.columns != triangulation.columns()) {
    throw UserError(setup.background,
                    fmt::format("is {}, but the images are {}", images::size_text(background.rows, background.columns),
                                images::size_text(triangulation.rows(), triangulation.columns())));
  }
  scanner.set_background(background);
}

DepthShares shares_of(const Triangulation& triangulation, const Scanner& scanner, std::vector<PointState>& states) {
  triangulation.explain(scanner.codes().data(), scanner.depth().values.data(), states.data());
  return count_states(states);
}

// Copies the scanner's newest depth image.
void finish(const Scanner& scanner, DepthRun& run) {
  run.depth = scanner.depth();
  if (scanner.has_background()) {
    run.moved_depth.emplace(run.depth.rows, run.depth.columns);
    scanner.difference(*run.moved_depth);
  }
}

// Notes what contradicts, if it is the first.
void note_contradiction(DepthRun& run, const std::string& contradiction) {
  if (run.contradiction.empty()) {
    run.contradiction = contradiction;
  }
}

// Notes that the images have no code, or hardly any.
void note_no_code(DepthRun& run) {
  static constexpr std::size_t kFew = 200;  // pixels
  const bool none = std::all_of(run.all_shares.begin(), run.all_shares.end(), [](const OfImage<DepthShares>& shares) {
    const std::size_t coded = shares.value.total() - shares.value.of(PointState::not_measurable);
    return coded < std::clamp<std::size_t>(shares.value.total() / 1000, 1, kFew);
  });
  if (none) {
    note_contradiction(run,
                       "no pixel has a code, or hardly any: is there light, and is the threshold below the contrast of "
                       "positive and negative?");
  }
}

// Reads the next 2 bits images and makes the words of one axis' code.
class AxisDecoder {
 public:
  AxisDecoder(images::ImageSequence& images, const ScannerSettings& settings, const OnImage& on_image)
      : images_(images), settings_(settings), on_image_(on_image) {}

  std::vector<std::uint16_t> words(const Triangulation& triangulation, int bits, DepthRun& run) {
    const int rows = triangulation.rows();
    const int columns = triangulation.columns();
    FastGrayDecoder decoder({rows, columns, bits, settings_.threshold});
    SequenceCheck check(rows, columns, bits);
    std::vector<std::string> names;
    for (int pattern = 0; pattern < 2 * bits; ++pattern, ++next_) {
      images::Image& image = pair_[next_ % 2];
      image = images_.read(next_);
      decoder.add_frame(image.view(), pattern);
      check.add(pattern, image.view());
      names.push_back(images_.files()[next_]);
      if (on_image_) {
        on_image_(next_ + 1, {});
      }
    }
    note_contradiction(run, contradiction_of(check, names));
    std::vector<std::uint16_t> words(triangulation.pixels());
    if (settings_.strict) {
      unambiguous_code_words(decoder.codes(), words.data());
    } else {
      code_words(decoder.codes(), words.data());
    }
    return words;
  }

 private:
  images::ImageSequence& images_;
  ScannerSettings settings_;
  const OnImage& on_image_;
  std::array<images::Image, 2> pair_;  // the decoder reads the positive when its negative comes
  std::size_t next_ = 0;
};

LightOfPixels light_of_pair(const std::array<images::Image, 2>& pair) {
  LightOfPixels light;
  for (std::size_t i = 0; i < pair[0].pixels.size(); ++i) {
    const auto [dark, bright] = std::minmax(pair[0].pixels[i], pair[1].pixels[i]);
    light.intensity.push_back(bright);
    light.contrast.push_back(static_cast<float>(bright - dark));
  }
  return light;
}

}  // namespace

DepthRun depth_of_images(const DepthSetup& setup, images::ImageSequence& images, const OnDepth& on_depth,
                         const OnImage& on_image) {
  DepthRun run;
  run.triangulation = make_triangulation(setup.geometry, source_of(images));
  const Triangulation& triangulation = *run.triangulation;
  Scanner scanner(triangulation, setup.scanner);
  set_background(setup, triangulation, scanner);
  const auto patterns = static_cast<std::size_t>(2 * setup.geometry.bits);
  std::vector<PointState> states(triangulation.pixels());
  std::array<images::Image, 2> pair;  // the scanner reads the positive when its negative comes
  SequenceCheck check(triangulation.rows(), triangulation.columns(), setup.geometry.bits);
  std::vector<std::string> names(patterns);
  std::string note;
  for (std::size_t i = 0; i < images.count(); ++i) {
    images::Image& image = pair[i % 2];
    image = images.read(i);
    check.add(static_cast<int>(i % patterns), image.view());
    names[i % patterns] = images.files()[i];
    if (scanner.add_frame(image.view(), static_cast<int>(i % patterns))) {
      const std::size_t number = i / 2;
      run.shares = shares_of(triangulation, scanner, states);
      run.all_shares.push_back({number, run.shares});
      note_contradiction(run, contradiction_of(check, names));
      note_contradiction(run, contradiction_of(triangulation, scanner.codes().data(), run.shares));
      note = share_text(run.shares, PointState::valid);
      if (scanner.has_background()) {
        run.moved.push_back({number, scanner.foreground()});
        note += fmt::format(", {} pixels moved", scanner.foreground().pixels);
      }
      on_depth(number, scanner.depth());
      ++run.depth_images;
    }
    if (on_image) {
      on_image(i + 1, note);
    }
  }
  finish(scanner, run);
  note_no_code(run);
  if (run.depth_images > 0) {
    run.doubt = doubt_of(triangulation, scanner.codes().data());
    run.light = light_of_pair(pair);
  }
  return run;
}

DepthRun depth_of_both_axes(const DepthSetup& setup, images::ImageSequence& images, const OnImage& on_image) {
  DepthRun run;
  std::unique_ptr<LensTriangulation> triangulation = make_lens_triangulation(setup.geometry, source_of(images));
  std::vector<std::uint16_t> column_codes;
  std::vector<std::uint16_t> row_codes;
  {
    AxisDecoder decoder(images, setup.scanner, on_image);
    column_codes = decoder.words(*triangulation, setup.geometry.bits, run);
    row_codes = decoder.words(*triangulation, setup.geometry.row_bits, run);
  }
  if (triangulation->rows_are_x()) {
    std::swap(column_codes, row_codes);
  }
  run.depth = images::FloatImage(triangulation->rows(), triangulation->columns());
  std::vector<PointState> states(triangulation->pixels());
  std::vector<float> residuals(triangulation->pixels());
  triangulation->depth_of_both(column_codes.data(), row_codes.data(), run.depth.values.data(), states.data(),
                               residuals.data());
  run.depth_images = 1;
  run.shares = count_states(states);
  note_contradiction(run, contradiction_of(*triangulation, column_codes.data(), run.shares));
  run.doubt = doubt_of(*triangulation, column_codes.data());
  run.all_shares.push_back({images.count() / 2 - 1, run.shares});
  note_no_code(run);
  residuals.erase(std::remove_if(residuals.begin(), residuals.end(), [](float value) { return std::isnan(value); }),
                  residuals.end());
  if (!residuals.empty()) {
    run.median_residual_px = static_cast<double>(files::median_of(std::move(residuals)));
  }
  if (images.count() >= 2) {
    run.light = light_of_pair({images.read(images.count() - 2), images.read(images.count() - 1)});
  }
  run.triangulation = std::move(triangulation);
  return run;
}

bool DepthStream::add(const model::PacketView& packet) {
  const ScanStream::Got got = stream_.add(packet);
  if (got == ScanStream::Got::nothing) {
    return false;
  }
  const model::PacketHeader& header = stream_.header();
  const ImageSource source{"an image of " + uri_, header.rows, header.columns};
  if (!scanner_) {
    run_.triangulation = make_triangulation(setup_.geometry, source);
    scanner_.emplace(*run_.triangulation, setup_.scanner);
    check_.emplace(header.rows, header.columns, setup_.geometry.bits);
    set_background(setup_, *run_.triangulation, *scanner_);
  }
  check_size("an earlier image", run_.triangulation->rows(), run_.triangulation->columns(), source);
  if (got == ScanStream::Got::image && !stream_.follows()) {
    scanner_->restart();
  }
  if (got == ScanStream::Got::codes) {
    scanner_->add_codes(stream_.codes().data());
  } else {
    const int pattern = stream_.pattern(2 * setup_.geometry.bits);
    check_->add(pattern, stream_.image());
    if (!scanner_->add_frame(stream_.image(), pattern)) {
      return false;
    }
  }
  sequence_ = header.sequence;
  ++run_.depth_images;
  if (const Foreground* const newest = moved()) {
    run_.moved.push_back({sequence_, *newest});
  }
  return true;
}

const Foreground* DepthStream::moved() const {
  return scanner_ && scanner_->has_background() ? &scanner_->foreground() : nullptr;
}

DepthRun DepthStream::result(const driver::Counters& counters) {
  if (run_.depth_images == 0) {
    throw UserError(uri_, "delivered no complete code image, nor images enough for one");
  }
  std::vector<PointState> states(run_.triangulation->pixels());
  run_.shares = shares_of(*run_.triangulation, *scanner_, states);
  run_.all_shares.push_back({sequence_, run_.shares});
  run_.device = {counters, stream_.incomplete()};
  note_contradiction(run_, contradiction_of(*check_, names_of_patterns(uri_, 2 * setup_.geometry.bits)));
  note_contradiction(run_, contradiction_of(*run_.triangulation, scanner_->codes().data(), run_.shares));
  run_.doubt = doubt_of(*run_.triangulation, scanner_->codes().data());
  finish(*scanner_, run_);
  return std::move(run_);
}

}  // namespace selfproj::structured_light
