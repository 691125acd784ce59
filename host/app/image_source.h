// Recorded images in place of a board: measured by the program as a board would, one after another.
#ifndef SELFPROJ_HOST_APP_IMAGE_SOURCE_H
#define SELFPROJ_HOST_APP_IMAGE_SOURCE_H

#include <CLI/CLI.hpp>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "host/images/prepared_images.h"
#include "selfproj/model/column_runs.h"
#include "selfproj/model/packet.h"
#include "selfproj/rig/rig.h"

namespace selfproj::app {

struct ImageSourceOptions {
  std::vector<std::string> images;       // files, folders or patterns; empty: a device
  images::Preparation preparation = {};  // its background, too
  std::optional<double> spacing_mm;      // of the belt, from image to image; empty: by the rig's speed and rate

  // Whether the user says how far the belt moves, so that the rig need not know it.
  [[nodiscard]] bool says_way() const { return !images.empty() && spacing_mm.has_value(); }
};

// Adds --images, --channel, --shift, --roi, --transpose, --background and --mm-per-image, which exclude --device.
void add_image_source_options(CLI::App& command, ImageSourceOptions& options, CLI::Option* device);

class ImageSource {
 public:
  // Reads the first image. Throws UserError as PreparedImages does, or if the images have neither the size of the
  // rig's camera nor that of its region, or more than kMaxSoftwareRows rows. Notes if they have more rows than a board
  // takes.
  ImageSource(const ImageSourceOptions& options, const rig::Rig& rig, const model::Measure& measure);

  [[nodiscard]] std::size_t count() const {
    return std::visit([](const auto& images) { return images.count(); }, images_);
  }
  [[nodiscard]] const std::string& first() const {
    return std::visit(
        [](const auto& images) -> const auto& { return images.files().front(); }, images_);
  }
  // That numbers are missing in the names of their files; empty: they are not.
  [[nodiscard]] const std::string& doubt() const { return doubt_; }

  // Measures up to `most` images (0: all), and calls take(header, columns) with what a board would have sent of each.
  // Ctrl-C ends the run. Encoder and time stamps are those of a belt that moves evenly.
  void run(std::uint64_t most, const std::function<void(const model::PacketHeader&, const model::RunsView&)>& take);

 private:
  [[nodiscard]] model::PacketHeader header_of(std::uint64_t image) const;
  template <typename Images>
  void run_of(Images& images, std::uint64_t most,
              const std::function<void(const model::PacketHeader&, const model::RunsView&)>& take);

  std::variant<images::PreparedImages, images::WidePreparedImages> images_;  // the latter of more than 8 bits
  rig::Rig rig_;
  model::Measure measure_;
  rig::RigRegion sent_;  // of a whole image of the sensor, this part is measured
  double spacing_mm_;
  std::string doubt_;
};

}  // namespace selfproj::app

#endif  // SELFPROJ_HOST_APP_IMAGE_SOURCE_H
